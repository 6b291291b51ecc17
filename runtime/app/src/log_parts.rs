//! When the log of a run goes on in another file, and where that is.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use backseat_units::{Timestamp, Utc};

/// The file that is being written; the thread that watches the room must not remove it.
#[derive(Clone, Debug)]
pub(crate) struct Current(Arc<Mutex<PathBuf>>);

impl Current {
    pub(crate) fn new(path: &Path) -> Self {
        Self(Arc::new(Mutex::new(path.to_path_buf())))
    }

    pub(crate) fn path(&self) -> PathBuf {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn set(&self, path: PathBuf) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = path;
    }
}

/// After how much a new part begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Split {
    After(Duration),
    Bytes(u64),
}

/// The parts of one log.
#[derive(Clone, Debug)]
pub(crate) struct Parts {
    splits: Vec<Split>,
    current: Current,
    mission: String,
    utc_at_start: Utc,
    /// When the current part began.
    began: Timestamp,
    /// No other part is begun before this.
    not_before: Timestamp,
}

/// After a part that could not begin, the next one is tried after this.
const TRY_AGAIN: Duration = Duration::from_secs(30);

impl Parts {
    pub(crate) fn new(splits: Vec<Split>, current: Current, mission: &str, utc_at_start: Utc) -> Self {
        Self {
            splits,
            current,
            mission: mission.to_owned(),
            utc_at_start,
            began: Timestamp::ZERO,
            not_before: Timestamp::ZERO,
        }
    }

    /// Where the next part is to be written, if it is due at this time, with so many bytes in the current one.
    pub(crate) fn due(&self, now: Timestamp, bytes: u64) -> Option<PathBuf> {
        let due = |split: &Split| match *split {
            Split::After(after) => now.since(self.began) >= after,
            Split::Bytes(most) => bytes >= most,
        };
        if now < self.not_before || !self.splits.iter().any(due) {
            return None;
        }
        let path = self.current.path();
        let millis = self.utc_at_start.as_unix_nanos().saturating_add(now.as_nanos()) / 1_000_000;
        Some(path.with_file_name(format!("{}-{millis}.mcap", self.mission)))
    }

    /// This part begins.
    pub(crate) fn begin(&mut self, now: Timestamp, path: PathBuf) {
        self.began = now;
        self.current.set(path);
    }

    /// The next part could not begin.
    pub(crate) fn put_off(&mut self, now: Timestamp) {
        self.not_before = now + TRY_AGAIN;
    }
}

/// When to begin a new part, on the command line, such as 1h or 500MB.
pub(crate) fn split(text: &str) -> Result<Split, String> {
    const UNITS: [(&str, u64, bool); 5] = [
        ("min", 60, true),
        ("h", 3600, true),
        ("s", 1, true),
        ("MB", 1_000_000, false),
        ("GB", 1_000_000_000, false),
    ];
    let found = UNITS.into_iter().find_map(|(unit, size, is_time)| {
        let number: u64 = text.strip_suffix(unit)?.trim().parse().ok()?;
        let number = number.checked_mul(size)?;
        Some(if is_time {
            Split::After(Duration::from_secs(number))
        } else {
            Split::Bytes(number)
        })
    });
    match found {
        Some(split @ Split::After(after)) if (10..=3_600_000).contains(&after.as_secs()) => Ok(split),
        Some(split @ Split::Bytes(1_000_000..=1_000_000_000_000)) => Ok(split),
        Some(_) | None => {
            Err("expected a time of 10s to 1000h, such as 1h, or a size of 1MB to 1000GB, such as 500MB".to_owned())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_is_due_after_its_time_or_its_size() {
        let first = Path::new("logs/dive-1000.mcap");
        let current = Current::new(first);
        let splits = vec![Split::After(Duration::from_secs(60)), Split::Bytes(1000)];
        let utc = Utc::from_unix_nanos(1_000_000_000);
        let mut parts = Parts::new(splits, current.clone(), "dive", utc);
        assert_eq!(parts.due(Timestamp::from_secs(59), 999), None);
        let second = PathBuf::from("logs/dive-61000.mcap");
        assert_eq!(parts.due(Timestamp::from_secs(60), 10).as_ref(), Some(&second));
        assert_eq!(current.path(), first);
        parts.begin(Timestamp::from_secs(60), second.clone());
        assert_eq!(current.path(), second);
        assert_eq!(parts.due(Timestamp::from_secs(119), 999), None);
        assert_eq!(
            parts.due(Timestamp::from_secs(61), 1000),
            Some(PathBuf::from("logs/dive-62000.mcap"))
        );
        parts.put_off(Timestamp::from_secs(61));
        assert_eq!(parts.due(Timestamp::from_secs(90), 1000), None);
        assert!(parts.due(Timestamp::from_secs(91), 1000).is_some());
    }

    #[test]
    fn a_split_has_a_unit() {
        assert_eq!(split("10s"), Ok(Split::After(Duration::from_secs(10))));
        assert_eq!(split("1h"), Ok(Split::After(Duration::from_secs(3600))));
        assert_eq!(split("30 min"), Ok(Split::After(Duration::from_secs(1800))));
        assert_eq!(split("500MB"), Ok(Split::Bytes(500_000_000)));
        assert_eq!(split("2GB"), Ok(Split::Bytes(2_000_000_000)));
        for text in [
            "",
            "1",
            "0h",
            "0MB",
            "9s",
            "-1h",
            "1.5h",
            "2000h",
            "18446744073709551615GB",
            "20KB",
        ] {
            assert!(split(text).is_err(), "{text}");
        }
    }
}
