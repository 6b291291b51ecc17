use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use anyhow::{Context, Result, bail};
use clap::Args;
use serde_json::Value;

use crate::cargo::{backseat, root, target};
use crate::demo::release;
use crate::plugins::plugins;

/// Flies a mission with many seeds, each in a process of its own as a user would run it, and evaluates the printed
/// reports.
#[derive(Args)]
pub(crate) struct Seeds {
    /// The mission's folder
    pub(crate) mission: PathBuf,
    /// Number of seeds, from --first on
    #[arg(long, default_value_t = 100)]
    pub(crate) runs: u64,
    /// The first seed
    #[arg(long, default_value_t = 1)]
    pub(crate) first: u64,
    /// Number of runs that must meet every expectation [default: all]
    #[arg(long)]
    pub(crate) least: Option<u64>,
}

pub(crate) fn seeds(arguments: &Seeds) -> Result<()> {
    let program = release()?;
    plugins()?;
    let folder = target()?.join("plugins");
    let next = AtomicU64::new(arguments.first);
    let end = arguments.first + arguments.runs;
    let reports = Mutex::new(BTreeMap::new());
    let fly = || -> Result<()> {
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= end {
                return Ok(());
            }
            let output = backseat(&program)
                .arg("sim")
                .arg(&arguments.mission)
                .arg("--plugins")
                .arg(&folder)
                .args(["--json", "--seed", &seed.to_string()])
                .current_dir(root()?)
                .output()?;
            let text = String::from_utf8_lossy(&output.stdout);
            let report: Value = serde_json::from_str(&text)
                .with_context(|| format!("seed {seed}: {}", String::from_utf8_lossy(&output.stderr).trim()))?;
            reports
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .insert(seed, report);
        }
    };
    std::thread::scope(|scope| -> Result<()> {
        let workers = std::thread::available_parallelism().map_or(1, usize::from);
        let flights: Vec<_> = (0..workers).map(|_| scope.spawn(fly)).collect();
        for flight in flights {
            match flight.join() {
                Ok(result) => result?,
                Err(_) => bail!("a worker panicked"),
            }
        }
        Ok(())
    })?;
    let reports = reports.into_inner().unwrap_or_else(PoisonError::into_inner);
    tell(&reports, arguments)
}

fn tell(reports: &BTreeMap<u64, Value>, arguments: &Seeds) -> Result<()> {
    let mut good = 0;
    let mut violations = 0;
    let mut measures: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for (seed, report) in reports {
        let unmet: Vec<&str> = report["unmet"]
            .as_array()
            .into_iter()
            .flatten()
            .filter_map(Value::as_str)
            .collect();
        if unmet.is_empty() {
            good += 1;
        } else {
            println!("seed {seed}: {}", unmet.join("; "));
        }
        violations += report["violations"].as_array().map_or(0, Vec::len);
        for (name, value) in report["measures"].as_object().into_iter().flatten() {
            measures.entry(name.clone()).or_default().extend(value.as_f64());
        }
    }
    for (name, mut values) in measures {
        values.sort_by(f64::total_cmp);
        if values.is_empty() {
            continue;
        }
        let middle = values[values.len() / 2];
        let (least, most) = (values[0], values[values.len() - 1]);
        println!("{name}: least {least:.1}, median {middle:.1}, most {most:.1}");
    }
    println!(
        "{good} of {} runs held every expectation; {violations} violations",
        reports.len()
    );
    let least = arguments.least.unwrap_or(arguments.runs);
    if good < least || violations > 0 {
        bail!("expected at least {least} good runs and no violation");
    }
    Ok(())
}
