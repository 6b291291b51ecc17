use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Deserializer};

/// The seeds of a campaign: `1..1000`, with both ends, or a list of such ranges and single seeds: `1..10, 42`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Seeds {
    /// First and last of each range.
    ranges: Vec<(u64, u64)>,
    count: u64,
}

impl Seeds {
    /// How many there are.
    #[must_use]
    pub const fn count(&self) -> u64 {
        self.count
    }

    /// The seed at a place, from 0; the places are below [`Seeds::count`].
    #[must_use]
    pub fn at(&self, place: u64) -> Option<u64> {
        let mut left = place;
        for (first, last) in &self.ranges {
            let within = last - first;
            if left <= within {
                return Some(first + left);
            }
            left -= within + 1;
        }
        None
    }
}

impl FromStr for Seeds {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || format!("`{text}`: expected seeds such as 1..1000 (both ends count) or 1..10,42");
        let mut ranges = Vec::new();
        let mut count = 0u64;
        for part in text.split(',') {
            let part = part.trim();
            let (first, last) = part.split_once("..").unwrap_or((part, part));
            let number = |text: &str| text.trim().parse::<u64>().map_err(|_| expected());
            let (first, last) = (number(first)?, number(last.trim_start_matches('='))?);
            if first > last {
                return Err(format!("`{part}`: the range is empty: expected the smaller seed first"));
            }
            count = (last - first)
                .checked_add(1)
                .and_then(|more| count.checked_add(more))
                .ok_or_else(|| format!("`{part}`: too many seeds"))?;
            ranges.push((first, last));
        }
        let mut sorted = ranges.clone();
        sorted.sort_unstable();
        if let Some(pair) = sorted.windows(2).find(|pair| pair[1].0 <= pair[0].1) {
            return Err(format!("`{text}`: seed {} is in it twice", pair[1].0));
        }
        Ok(Self { ranges, count })
    }
}

impl fmt::Display for Seeds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, (first, last)) in self.ranges.iter().enumerate() {
            if place > 0 {
                f.write_str(",")?;
            }
            if first == last {
                write!(f, "{first}")?;
            } else {
                write!(f, "{first}..{last}")?;
            }
        }
        Ok(())
    }
}

impl<'de> Deserialize<'de> for Seeds {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?
            .parse()
            .map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_are_counted_and_found_by_their_place() {
        let seeds: Seeds = "1..3, 10,7..8".parse().unwrap();
        assert_eq!(seeds.count(), 6);
        let all: Vec<u64> = (0..6).filter_map(|place| seeds.at(place)).collect();
        assert_eq!(all, [1, 2, 3, 10, 7, 8]);
        assert_eq!(seeds.at(6), None);
        assert_eq!(seeds.to_string(), "1..3,10,7..8");
    }

    #[test]
    fn what_is_not_a_list_of_seeds_is_refused() {
        for (text, expected) in [
            ("", "expected seeds"),
            ("5..2", "the range is empty"),
            ("1..x", "expected seeds"),
            ("-1..3", "expected seeds"),
            ("1..4,3", "seed 3 is in it twice"),
            ("0..18446744073709551615", "too many seeds"),
        ] {
            let error = text.parse::<Seeds>().unwrap_err();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
