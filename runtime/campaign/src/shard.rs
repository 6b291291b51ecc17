use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// One of N shares of a campaign: `2/7` is the second of seven.
///
/// The shares are contiguous ranges of runs, as equal as they can be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Shard {
    /// Which one, from 1.
    index: u64,
    /// How many there are.
    count: u64,
}

impl Shard {
    /// The whole campaign.
    pub const WHOLE: Self = Self { index: 1, count: 1 };

    /// The runs of this share.
    #[must_use]
    pub fn of(self, runs: u64) -> Range<u64> {
        let place = |index: u64| (u128::from(runs) * u128::from(index) / u128::from(self.count)) as u64;
        place(self.index - 1)..place(self.index)
    }

    /// How many shards there are.
    pub(crate) const fn count(self) -> u64 {
        self.count
    }

    /// A name for files: `2-of-7`.
    #[must_use]
    pub fn name(self) -> String {
        format!("{}-of-{}", self.index, self.count)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text
            .split_once('/')
            .and_then(|(index, count)| Some((index.parse().ok()?, count.parse().ok()?)));
        match numbers {
            Some((index, count)) if 1 <= index && index <= count => Ok(Self { index, count }),
            _ => Err("expected I/N with I from 1 to N, such as 2/7".to_owned()),
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shards_are_all_runs_once() {
        for (runs, count) in [(0, 3), (1, 7), (10, 3), (1_000_000, 7), (5, 5)] {
            let mut next = 0;
            for index in 1..=count {
                let range = Shard { index, count }.of(runs);
                assert_eq!(range.start, next);
                assert!(range.end - range.start <= runs.div_ceil(count));
                next = range.end;
            }
            assert_eq!(next, runs);
        }
    }

    #[test]
    fn a_shard_is_written_as_a_fraction() {
        assert_eq!("2/7".parse::<Shard>().unwrap().to_string(), "2/7");
        for text in ["0/3", "4/3", "1", "a/b", "1/0", "-1/3"] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
    }
}
