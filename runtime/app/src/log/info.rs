//! `backseat log info`: what a log contains, and whether it is complete.

use std::path::{Path, PathBuf};

use anyhow::Result;
use backseat_fence::Rfc3339;
use backseat_recorder::{Log, Record};
use clap::Args;
use serde_json::{Value, json};

use super::files::each;
use super::read_log;
use crate::output::say;

#[derive(Debug, Args)]
pub(crate) struct LogInfo {
    /// The logs, written by `run`, `fly` or `sim --log`
    #[arg(value_name = "DIVE.mcap", required = true)]
    files: Vec<PathBuf>,
    /// Print one JSON object for each log on standard output and nothing else
    #[arg(long)]
    json: bool,
}

pub(super) fn info(arguments: &LogInfo) -> Result<bool> {
    each(&arguments.files, |file| {
        let log = read_log(file)?;
        let summary = Summary::of(&log);
        if arguments.json {
            say!("{}", summary.to_json(file, &log));
        } else {
            summary.print(file, &log)?;
        }
        Ok(true)
    })
}

/// Counts of a log's records.
#[derive(Default)]
struct Summary {
    seconds: f64,
    /// Bytes on the link, from the vehicle and to it.
    received: usize,
    sent: usize,
    notes: usize,
    gaps: usize,
    /// Records that are missing.
    missing: u64,
}

impl Summary {
    fn of(log: &Log) -> Self {
        let mut summary = Self {
            notes: log.notes().count(),
            seconds: log.entries.last().map_or(0.0, |entry| entry.now.as_secs_f64()),
            ..Self::default()
        };
        for (_, from_vehicle, bytes) in log.link() {
            if from_vehicle {
                summary.received += bytes.len();
            } else {
                summary.sent += bytes.len();
            }
        }
        for entry in &log.entries {
            if let Record::Gap { records, .. } = &entry.record {
                summary.gaps += 1;
                summary.missing += records;
            }
        }
        summary
    }

    fn print(&self, path: &Path, log: &Log) -> Result<()> {
        let run = &log.run;
        let seed = run.seed.map_or_else(String::new, |seed| format!(", seed {seed}"));
        say!(
            "{}: {}{seed}, {:.1} min from {}, backseat {}",
            path.display(),
            run.mission,
            self.seconds / 60.0,
            Rfc3339(run.utc_at_start),
            run.version
        );
        say!(
            "  {} records; {} kB from the vehicle, {} kB to it; {} notes",
            log.entries.len(),
            self.received / 1000,
            self.sent / 1000,
            self.notes
        );
        say!(
            "  metres count from {:.6} {:.6}",
            run.origin.latitude.as_deg(),
            run.origin.longitude.as_deg()
        );
        if run.part > 1 {
            say!(
                "  part {} of a log; `backseat log join` makes one of all parts",
                run.part
            );
        }
        for attachment in &log.attachments {
            say!("  attached: {}, {} bytes", attachment.name, attachment.data.len());
        }
        if self.gaps > 0 {
            say!("  {} gaps: {} records are missing", self.gaps, self.missing);
        }
        say!(
            "  {}",
            if log.complete && run.part > 1 {
                "this part is complete"
            } else if log.complete {
                "the log is complete"
            } else {
                "cut short, or still being written: the log does not end properly, and its last records may be missing"
            }
        );
        Ok(())
    }

    fn to_json(&self, path: &Path, log: &Log) -> Value {
        let run = &log.run;
        let attached: Vec<&str> = log.attachments.iter().map(|file| file.name.as_str()).collect();
        json!({
            "log": path.display().to_string(),
            "mission": run.mission,
            "seed": run.seed,
            "version": run.version,
            "part": run.part,
            "origin": {
                "latitude_deg": run.origin.latitude.as_deg(),
                "longitude_deg": run.origin.longitude.as_deg(),
            },
            "utc_at_start": Rfc3339(run.utc_at_start).to_string(),
            "seconds": self.seconds,
            "complete": log.complete,
            "records": log.entries.len(),
            "bytes_from_vehicle": self.received,
            "bytes_to_vehicle": self.sent,
            "notes": self.notes,
            "gaps": self.gaps,
            "records_missing": self.missing,
            "attached": attached,
        })
    }
}
