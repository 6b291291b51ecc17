use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::Args;
use serde_json::Value;

use crate::cargo::{backseat, cargo, root, target};
use crate::cross;
use crate::demo::release;
use crate::plugins::plugins;

/// Flies the same missions in several processes and builds. Their reports must be the same to the byte.
#[derive(Args)]
pub(crate) struct Digest {
    /// The missions' folders
    #[arg(default_values = ["missions/isobath", "missions/plume"])]
    pub(crate) missions: Vec<PathBuf>,
    /// Number of seeds of each mission, from 1 on
    #[arg(long, default_value_t = 5)]
    pub(crate) seeds: u64,
    /// Inject the faults in this file into every run
    #[arg(long, value_name = "FILE")]
    pub(crate) faults: Option<PathBuf>,
    /// Build the program for aarch64 too, and fly it under qemu
    #[arg(long)]
    pub(crate) aarch64: bool,
}

/// A program, and the command that runs it.
struct Build {
    name: &'static str,
    program: PathBuf,
    emulator: Option<PathBuf>,
}

/// The results of a run.
#[derive(Debug, PartialEq)]
struct Flight {
    digest: String,
    /// The whole report, without the real time that the run took.
    report: Value,
    log: Vec<u8>,
}

pub(crate) fn digest(arguments: &Digest) -> Result<()> {
    let builds = builds(arguments.aarch64)?;
    // Once, so that all builds load the same files.
    plugins()?;
    let others: Vec<&str> = builds[1..].iter().map(|build| build.name).collect();
    println!("| mission | seed | digest of release | {} |", others.join(" | "));
    println!("|---|---|---|{}", "---|".repeat(others.len()));
    let mut different = 0;
    for mission in &arguments.missions {
        for seed in 1..=arguments.seeds {
            different += usize::from(!compare(&builds, mission, seed, arguments.faults.as_deref())?);
        }
    }
    if different > 0 {
        bail!("{different} seeds fly differently; reports and logs of the last are in target/digest");
    }
    println!("link, report and log are the same in every build");
    Ok(())
}

fn builds(aarch64: bool) -> Result<Vec<Build>> {
    cargo(&["build", "--package", "backseat"])?;
    let native = |name, program: &Path| Build {
        name,
        program: program.to_owned(),
        emulator: None,
    };
    let release = release()?;
    let debug = target()?.join("debug/backseat");
    let mut builds = vec![
        native("release", &release),
        native("release again", &release),
        native("debug", &debug),
    ];
    if aarch64 {
        builds.push(Build {
            name: "aarch64",
            program: cross::release()?,
            emulator: Some(cross::emulator()?),
        });
    }
    Ok(builds)
}

/// Flies a seed in every build and prints its row. All builds are compared with the first.
fn compare(builds: &[Build], mission: &Path, seed: u64, faults: Option<&Path>) -> Result<bool> {
    let mut flights = Vec::new();
    for build in builds {
        flights.push(fly(build, mission, seed, faults).with_context(|| format!("{}, seed {seed}", build.name))?);
    }
    let Some((first, others)) = flights.split_first() else {
        return Ok(true);
    };
    let cells: Vec<String> = others.iter().map(|other| difference(first, other)).collect();
    println!(
        "| {} | {seed} | {} | {} |",
        mission.file_name().unwrap_or_default().display(),
        first.digest,
        cells.join(" | ")
    );
    Ok(others.iter().all(|other| other == first))
}

fn fly(build: &Build, mission: &Path, seed: u64, faults: Option<&Path>) -> Result<Flight> {
    let folder = target()?.join("digest");
    std::fs::create_dir_all(&folder)?;
    let log = folder.join(format!("{}.mcap", build.name.replace(' ', "-")));
    let mut command = match &build.emulator {
        Some(emulator) => {
            let mut command = backseat(emulator);
            command.arg(&build.program);
            command
        }
        None => backseat(&build.program),
    };
    command.arg("sim").arg(mission).arg("--plugins");
    command.arg(target()?.join("plugins")).arg("--log").arg(&log);
    command.args(["--json", "--seed", &seed.to_string()]);
    if let Some(faults) = faults {
        command.arg("--faults").arg(faults);
    }
    let output = command
        .current_dir(root()?)
        .output()
        .with_context(|| format!("{command:?}"))?;
    // A run that did not meet its expectations can be compared too, but a run without a report cannot.
    let mut report: Value = serde_json::from_slice(&output.stdout)
        .with_context(|| String::from_utf8_lossy(&output.stderr).trim().to_owned())?;
    std::fs::write(log.with_extension("json"), &output.stdout)?;
    let keys = report.as_object_mut().context("the report is not a JSON object")?;
    for real_time in ["wall_seconds", "load_seconds"] {
        keys.remove(real_time);
    }
    let digest = report["digest"]
        .as_str()
        .context("the report has no digest")?
        .to_owned();
    let log = std::fs::read(&log).with_context(|| log.display().to_string())?;
    Ok(Flight { digest, report, log })
}

/// The differences, in a few words.
fn difference(first: &Flight, other: &Flight) -> String {
    let mut different = Vec::new();
    if first.digest != other.digest {
        different.push(format!("link {}", other.digest));
    }
    if first.report != other.report {
        different.push("report".to_owned());
    }
    if first.log != other.log {
        let same = first
            .log
            .iter()
            .zip(&other.log)
            .take_while(|(first, other)| first == other);
        different.push(format!("log from byte {} on", same.count()));
    }
    if different.is_empty() {
        return "same".to_owned();
    }
    format!("DIFFERENT: {}", different.join(", "))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn flight() -> Flight {
        Flight {
            digest: "0f".to_owned(),
            report: json!({ "measures": { "contour_rms_m": 1.4 } }),
            log: vec![1, 2, 3, 4],
        }
    }

    #[test]
    fn each_difference_is_named_with_its_place() {
        assert_eq!(difference(&flight(), &flight()), "same");
        let link = Flight {
            digest: "10".to_owned(),
            ..flight()
        };
        assert_eq!(difference(&flight(), &link), "DIFFERENT: link 10");
        let report = Flight {
            report: json!({ "measures": { "contour_rms_m": 1.400_000_000_000_000_1 } }),
            ..flight()
        };
        assert_eq!(difference(&flight(), &report), "DIFFERENT: report");
        let log = Flight {
            log: vec![1, 2, 4, 4],
            ..flight()
        };
        assert_eq!(difference(&flight(), &log), "DIFFERENT: log from byte 2 on");
        let shorter = Flight {
            log: vec![1, 2, 3],
            ..flight()
        };
        assert_eq!(difference(&flight(), &shorter), "DIFFERENT: log from byte 3 on");
    }
}
