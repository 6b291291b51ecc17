use std::path::PathBuf;

use anyhow::{Result, bail};
use backseat_campaign::{Crew, Folder, RUNS, pending};
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
    let manifest = folder.manifest()?;
    let plan = manifest.plan(folder.path())?;
    let plugins = arguments.plugins.clone().or_else(|| manifest.plugins.clone());
    let crew = Crew::new(host_with(true)?, plugins.filter(|plugins| plugins.is_dir()));
    warn_lacking(write(&folder, &plan, Some(&crew))?);
    say!("report: {}", folder.path().join("report.html").display());
    Ok(())
}

/// Opens a results folder whose rows are all there.
pub(super) fn whole(path: &std::path::Path) -> Result<Folder> {
    let folder = Folder::open(path)?;
    if !folder.path().join(RUNS).is_file() {
        let plan = folder.manifest()?.plan(folder.path())?;
        let left = pending(&plan, &folder)?;
        bail!(
            "{}: has no {RUNS} yet: {} of {} runs are flown; fly the rest with the same command, or merge its shards",
            path.display(),
            plan.runs() - left,
            plan.runs()
        );
    }
    Ok(folder)
}
