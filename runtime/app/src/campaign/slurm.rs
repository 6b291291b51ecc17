use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use backseat_campaign::{Slurm, word};
use backseat_reference::STOPPED;
use clap::Args;

use super::CampaignArguments;
use crate::output::say;

#[derive(Debug, Args)]
pub(crate) struct CampaignSlurm {
    #[command(flatten)]
    campaign: CampaignArguments,
    /// Number of shards: tasks of the array
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    shards: u64,
    /// Cores of a task
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1024))]
    cores: u32,
    /// Minutes that a task may take; one that takes longer goes on as the same task
    #[arg(long, default_value_t = 60, value_parser = clap::value_parser!(u64).range(3..=100_000))]
    minutes: u64,
    /// A further option of sbatch for both jobs, such as --sbatch=--partition=short
    #[arg(long, value_name = "OPTION", allow_hyphen_values = true)]
    sbatch: Vec<String>,
    /// Submit the jobs too
    #[arg(long)]
    submit: bool,
}

pub(super) fn slurm(arguments: &CampaignSlurm) -> Result<()> {
    let campaign = &arguments.campaign;
    let given = campaign.given()?;
    if campaign.shard.is_some() {
        bail!("--shard: the tasks get it from `campaign slurm`: leave it out");
    }
    if campaign.stop_after.is_some() {
        bail!("--stop-after: a task stops before its --minutes are over: leave it out");
    }
    if campaign.workers.is_some() {
        bail!("--workers: a task flies on all of its --cores: leave it out");
    }
    if campaign.json {
        bail!("--json: the tasks write to files of the results folder: leave it out");
    }
    // Reads everything once here, so that an error comes now and not from each task.
    campaign.open(&given)?;
    let absolute = |path: &Path| std::path::absolute(path).with_context(|| path.display().to_string());
    let out = absolute(&campaign.out)?;
    let mut words = vec![absolute(&campaign.campaign)?.display().to_string()];
    if let Some(seeds) = &campaign.seeds {
        words.extend(["--seeds".to_owned(), seeds.to_string()]);
    }
    for set in &campaign.set {
        words.extend(["--set".to_owned(), set.clone()]);
    }
    if let Some(plugins) = &campaign.plugins {
        words.extend(["--plugins".to_owned(), absolute(plugins)?.display().to_string()]);
    }
    if campaign.no_cache {
        words.push("--no-cache".to_owned());
    }
    let program = std::env::current_exe().context("the program's own path")?;
    let job = Slurm {
        program: &program,
        arguments: &words,
        out: &out,
        shards: arguments.shards.min(given.plan.runs()),
        cores: arguments.cores,
        minutes: arguments.minutes,
        stopped: STOPPED,
        options: &arguments.sbatch,
    };
    let folder = out.join("slurm");
    fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    let array = write(&folder, "array.sh", &job.array_script())?;
    let merge = write(&folder, "merge.sh", &job.merge_script())?;
    if !arguments.submit {
        say!("written: {} and {}", array.display(), merge.display());
        say!(
            "submit: sbatch --dependency=afterok:$(sbatch --parsable {}) {}",
            word(&array.display().to_string()),
            word(&merge.display().to_string())
        );
        return Ok(());
    }
    let first = submit(&[], &array)?;
    let second = submit(&[format!("--dependency=afterok:{first}")], &merge)?;
    say!(
        "submitted: array job {first} of {} tasks, and job {second} that merges",
        job.shards
    );
    Ok(())
}

fn write(folder: &Path, name: &str, text: &str) -> Result<PathBuf> {
    let path = folder.join(name);
    fs::write(&path, text).with_context(|| path.display().to_string())?;
    Ok(path)
}

/// Submits a script; returns the job's number.
fn submit(options: &[String], script: &Path) -> Result<String> {
    let output = Command::new("sbatch")
        .arg("--parsable")
        .args(options)
        .arg(script)
        .output()
        .context("sbatch: is Slurm installed here? Without --submit the scripts are only written")?;
    if !output.status.success() {
        let text = String::from_utf8_lossy(&output.stderr);
        bail!("sbatch {}: {}", script.display(), text.trim().replace('\n', " "));
    }
    let text = String::from_utf8_lossy(&output.stdout);
    // With a cluster's name, it follows a semicolon.
    Ok(text.trim().split(';').next().unwrap_or_default().to_owned())
}
