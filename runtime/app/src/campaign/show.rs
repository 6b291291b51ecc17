use std::path::PathBuf;

use anyhow::Result;
use backseat_campaign::Folder;
use backseat_campaign_report::{Outcomes, table};
use clap::Args;

use super::report::whole;
use crate::output::say;

#[derive(Debug, Args)]
pub(crate) struct CampaignShow {
    /// The results folder
    #[arg(value_name = "DIR")]
    dir: PathBuf,
}

pub(super) fn show(arguments: &CampaignShow) -> Result<()> {
    print(&whole(&arguments.dir)?)
}

pub(super) fn print(folder: &Folder) -> Result<()> {
    let plan = folder.manifest()?.plan(folder.path())?;
    let outcomes = Outcomes::read(folder, &plan)?;
    say!("{}", table(&outcomes).trim_end());
    Ok(())
}
