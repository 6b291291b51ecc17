use std::path::PathBuf;

use anyhow::Result;
use backseat_campaign::Folder;
use backseat_campaign_report::{Outcomes, Summary, table};
use clap::Args;

use super::report::whole;
use crate::output::say;

#[derive(Debug, Args)]
pub(crate) struct CampaignShow {
    /// The results folder
    #[arg(value_name = "DIR")]
    dir: PathBuf,
    /// Print one JSON object: `variants`, `reasons`, `measures` with their quantiles, and `comparisons` of each variant
    /// with the first
    #[arg(long)]
    json: bool,
}

pub(super) fn show(arguments: &CampaignShow) -> Result<()> {
    let folder = whole(&arguments.dir)?;
    if !arguments.json {
        return print(&folder);
    }
    say!("{}", serde_json::to_string(&Summary::new(&outcomes(&folder)?))?);
    Ok(())
}

fn outcomes(folder: &Folder) -> Result<Outcomes> {
    let plan = folder.manifest()?.plan(folder.path())?;
    Ok(Outcomes::read(folder, &plan)?)
}

pub(super) fn print(folder: &Folder) -> Result<()> {
    let outcomes = outcomes(folder)?;
    say!("{}", table(&outcomes).trim_end());
    Ok(())
}
