use std::path::PathBuf;

use anyhow::{Result, bail};
use backseat_campaign::{Crew, Folder, RUNS};
use backseat_campaign_report::write;
use clap::Args;

use super::warn_lacking;
use crate::arguments::folder;
use crate::cache::host_with;
use crate::output::say;

#[derive(Debug, Args)]
pub(crate) struct CampaignReport {
    /// The results folder
    #[arg(value_name = "DIR")]
    dir: PathBuf,
    /// Look in this folder first for plugins that a mission names without a path
    #[arg(long, value_name = "DIR", value_parser = folder)]
    plugins: Option<PathBuf>,
}

pub(super) fn report(arguments: &CampaignReport) -> Result<()> {
    let folder = whole(&arguments.dir)?;
    let plan = folder.manifest()?.plan(folder.path())?;
    let crew = Crew::new(host_with(true)?, arguments.plugins.clone());
    warn_lacking(write(&folder, &plan, Some(&crew))?);
    say!("report: {}", folder.path().join("report.html").display());
    Ok(())
}

/// Opens a results folder whose rows are all there.
pub(super) fn whole(path: &std::path::Path) -> Result<Folder> {
    let folder = Folder::open(path)?;
    if !folder.path().join(RUNS).is_file() {
        bail!(
            "{}: has no {RUNS} yet: the campaign is not whole; fly the rest with the same command, or merge its shards",
            path.display()
        );
    }
    Ok(folder)
}
