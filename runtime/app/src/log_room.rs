//! Watches the room for logs on a thread of its own: says when it gets short, and removes the oldest logs beyond a quota.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::Result;
use tracing::warn;

use crate::aside;
use crate::clock::pause;
use crate::log_parts::Current;

/// How often the thread looks.
const LOOK_EVERY: Duration = Duration::from_secs(20);
/// Less free room than this is worth a line, bytes: some hours of a dive.
const SHORT: u64 = 256 << 20;

/// What may be kept in a folder of logs.
#[derive(Clone, Debug)]
pub(crate) struct LogRoom {
    folder: PathBuf,
    /// The log that is being written.
    current: Current,
    /// Logs of this mission alone are removed.
    mission: String,
    /// Bytes of logs of this mission.
    quota: Option<u64>,
}

impl LogRoom {
    pub(crate) fn new(current: Current, mission: &str, quota: Option<u64>) -> Self {
        Self {
            folder: current.path().parent().map(Path::to_path_buf).unwrap_or_default(),
            current,
            mission: mission.to_owned(),
            quota,
        }
    }

    /// Starts the thread, which ends with the process.
    ///
    /// # Errors
    /// If it cannot start.
    pub(crate) fn watch(self) -> Result<()> {
        aside::spawn("log-room", move || {
            let mut told = false;
            loop {
                self.keep_quota();
                told = self.tell_room(told);
                pause(LOOK_EVERY);
            }
        })?;
        Ok(())
    }

    /// Removes the oldest logs until all of them together are within the quota. The current one stays.
    fn keep_quota(&self) {
        let Some(quota) = self.quota else { return };
        let mut logs = self.logs();
        let mut total: u64 = logs.iter().map(|(_, _, size)| size).sum();
        logs.sort();
        let current = self.current.path();
        for (_, path, size) in logs {
            if total <= quota {
                return;
            }
            if path == current {
                continue;
            }
            match fs::remove_file(&path) {
                Ok(()) => {
                    total -= size;
                    warn!("{}: removed, because of --log-quota", path.display());
                }
                Err(error) => {
                    warn!("{}: cannot be removed: {error}", path.display());
                    return;
                }
            }
        }
    }

    /// The logs that `run` has written of this mission: when each began, its path and its size.
    fn logs(&self) -> Vec<(u64, PathBuf, u64)> {
        let entries = fs::read_dir(&self.folder).into_iter().flatten().filter_map(Result::ok);
        entries
            .filter_map(|entry| {
                let name = entry.file_name().into_string().ok()?;
                let began = name
                    .strip_suffix(".mcap")?
                    .strip_prefix(&self.mission)?
                    .strip_prefix('-')?;
                let about = entry.metadata().ok().filter(fs::Metadata::is_file)?;
                Some((began.parse().ok()?, self.folder.join(name), about.len()))
            })
            .collect()
    }

    /// Says once that the room gets short. Returns whether that was said.
    fn tell_room(&self, told: bool) -> bool {
        let Ok(figures) = rustix::fs::statvfs(&self.folder) else {
            return told;
        };
        let free = figures.f_bavail.saturating_mul(figures.f_frsize);
        if free >= 2 * SHORT {
            return false;
        }
        if free < SHORT && !told {
            warn!(
                "{}: {} MB are free: when they are used up, the log ends and the run continues",
                self.folder.display(),
                free >> 20
            );
            return true;
        }
        told
    }
}

/// A size on the command line, such as 20GB or 500MB.
pub(crate) fn size(text: &str) -> Result<u64, String> {
    let units = [("GB", 1_000_000_000), ("MB", 1_000_000)];
    let found = units
        .into_iter()
        .find_map(|(unit, bytes)| Some((text.strip_suffix(unit)?.trim().parse::<u64>().ok()?, bytes)));
    match found {
        Some((number, bytes)) if (1..=1_000_000).contains(&number) => Ok(number * bytes),
        Some(_) | None => Err("expected a whole number of GB or MB, such as 20GB".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oldest_logs_of_this_mission_go_first_and_nothing_else_goes() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str| {
            let path = folder.path().join(name);
            fs::write(&path, [0; 1000]).unwrap();
            path
        };
        for name in ["dive-900.mcap", "dive-1000.mcap", "dive-2000.mcap", "dive-3000.mcap"] {
            write(name);
        }
        let others = [
            "deep-1.mcap",
            "dive-notes.mcap",
            "dive-1.txt",
            "dive-1-copy.mcap",
            "dive1.mcap",
        ];
        for name in others {
            write(name);
        }
        let current = Current::new(&folder.path().join("dive-900.mcap"));
        LogRoom::new(current.clone(), "dive", Some(2500)).keep_quota();
        let there = |name: &str| folder.path().join(name).exists();
        assert!(there("dive-900.mcap"), "the current log stays, however old its name is");
        assert!(!there("dive-1000.mcap") && !there("dive-2000.mcap") && there("dive-3000.mcap"));
        assert!(others.iter().all(|name| there(name)));
        LogRoom::new(current, "dive", None).keep_quota();
        assert!(there("dive-3000.mcap"));
    }

    #[test]
    fn a_quota_has_a_unit() {
        assert_eq!(size("20GB"), Ok(20_000_000_000));
        assert_eq!(size("500 MB"), Ok(500_000_000));
        for text in ["20", "0GB", "-1GB", "GB", "1.5GB", "20KB"] {
            assert!(size(text).is_err(), "{text}");
        }
    }
}
