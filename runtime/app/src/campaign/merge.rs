use std::path::PathBuf;

use anyhow::Result;
use backseat_campaign::{Folder, finish};
use backseat_campaign_report::write;
use clap::Args;

use super::conclude;

#[derive(Debug, Args)]
pub(crate) struct CampaignMerge {
    /// The results folder of the shards; the merged results go there
    #[arg(value_name = "DIR")]
    out: PathBuf,
    /// Other folders with shards of the same campaign, if they were not flown into one folder
    #[arg(value_name = "MORE")]
    more: Vec<PathBuf>,
    /// Print one JSON object on standard output and nothing else
    #[arg(long)]
    json: bool,
}

pub(super) fn merge(arguments: &CampaignMerge) -> Result<u8> {
    let out = Folder::open(&arguments.out)?;
    let mut folders = vec![out.clone()];
    for path in &arguments.more {
        folders.push(Folder::open(path)?);
    }
    let plan = out.manifest()?.plan(out.path())?;
    let finished = finish(&plan, &folders, &out)?;
    write(&out, &plan, None)?;
    conclude(&out, &finished, arguments.json)
}
