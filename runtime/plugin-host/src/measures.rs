//! The values that a plugin publishes, within bounds.

use std::collections::BTreeSet;
use std::fmt;

use backseat_core::plugin::{LogLine, Measure};
use backseat_units::Timestamp;

use crate::allowance::{Allowance, warning};

/// How many values of a plugin are kept in a second. As many again may come in a burst.
pub(crate) const VALUES_PER_S: u32 = 64;
/// How many names a plugin may use: each has a channel of its own in the log.
const NAMES: usize = 64;
/// The longest name, bytes.
const NAME_BYTES: usize = 48;
/// The longest unit, bytes.
const UNIT_BYTES: usize = 16;

/// Why a value is dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Dropped {
    Name,
    Unit,
    Value,
    Names,
    Rate,
}

impl fmt::Display for Dropped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Name => write!(
                f,
                "a name is 1 to {NAME_BYTES} of a-z, 0-9 and _, and begins with a letter"
            ),
            Self::Unit => write!(f, "a unit is at most {UNIT_BYTES} bytes without control characters"),
            Self::Value => write!(f, "a value is a finite number"),
            Self::Names => write!(f, "a plugin may use {NAMES} names"),
            Self::Rate => write!(f, "{VALUES_PER_S} values are kept a second"),
        }
    }
}

/// What calls of a plugin have published.
#[derive(Debug)]
pub(crate) struct Published {
    values: Vec<Measure>,
    allowed: usize,
    dropped: u64,
    /// The name that was dropped last, and why.
    last: Option<(String, Dropped)>,
}

impl Default for Published {
    fn default() -> Self {
        Self {
            values: Vec::new(),
            allowed: VALUES_PER_S as usize,
            dropped: 0,
            last: None,
        }
    }
}

impl Published {
    /// Sets how many values may be kept until they are taken.
    pub(crate) fn allow(&mut self, values: usize) {
        self.allowed = values;
    }

    /// Keeps a value, or counts it as dropped.
    pub(crate) fn publish(&mut self, name: &str, value: f64, unit: &str) {
        let dropped = if !is_name(name) {
            Dropped::Name
        } else if unit.len() > UNIT_BYTES || unit.chars().any(char::is_control) {
            Dropped::Unit
        } else if !value.is_finite() {
            Dropped::Value
        } else if self.values.len() >= self.allowed {
            Dropped::Rate
        } else {
            self.values.push(Measure {
                name: name.to_owned(),
                value,
                unit: unit.to_owned(),
            });
            return;
        };
        self.drop(name, dropped);
    }

    /// Keeps only the first values, and forgets what was dropped.
    pub(crate) fn truncate(&mut self, values: usize) {
        self.values.truncate(values);
        self.dropped = 0;
        self.last = None;
    }

    fn drop(&mut self, name: &str, why: Dropped) {
        self.dropped += 1;
        self.last = Some((name[..name.floor_char_boundary(NAME_BYTES)].to_owned(), why));
    }
}

/// Limits the values of one plugin over time, whichever instance published them.
#[derive(Debug)]
pub(crate) struct Measures {
    allowance: Allowance,
    names: BTreeSet<String>,
    last: Option<(String, Dropped)>,
}

impl Default for Measures {
    fn default() -> Self {
        Self {
            allowance: Allowance::per_s(VALUES_PER_S),
            names: BTreeSet::new(),
            last: None,
        }
    }
}

impl Measures {
    /// How many values a step at this time may publish.
    pub(crate) fn allowed(&mut self, now: Timestamp) -> usize {
        self.allowance.left(now)
    }

    /// Takes the values to keep of a step. Adds a line about dropped values to the log when one is due.
    pub(crate) fn keep(&mut self, now: Timestamp, published: &mut Published, log: &mut Vec<LogLine>) -> Vec<Measure> {
        let mut values = core::mem::take(&mut published.values);
        values.retain(|measure| {
            let known = self.names.contains(&measure.name);
            let fits = known || self.names.len() < NAMES;
            if !known && fits {
                self.names.insert(measure.name.clone());
            } else if !fits {
                published.drop(&measure.name, Dropped::Names);
            }
            fits
        });
        self.last = published.last.take().or_else(|| self.last.take());
        let dropped = core::mem::take(&mut published.dropped);
        if let Some(dropped) = self.allowance.take(now, values.len(), dropped)
            && let Some((name, why)) = self.last.take()
        {
            log.push(warning(match dropped {
                1 => format!("the value {name:?} was not published: {why}"),
                _ => format!("{dropped} values were not published, the last of them {name:?}: {why}"),
            }));
        }
        values
    }
}

fn is_name(name: &str) -> bool {
    name.len() <= NAME_BYTES
        && name.starts_with(|first: char| first.is_ascii_lowercase())
        && name
            .bytes()
            .all(|byte| matches!(byte, b'a'..=b'z' | b'0'..=b'9' | b'_'))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keep(measures: &mut Measures, published: &mut Published, second: u64) -> (Vec<Measure>, Vec<String>) {
        let mut log = Vec::new();
        let now = Timestamp::from_millis(1000 * second);
        let values = measures.keep(now, published, &mut log);
        (values, log.into_iter().map(|line| line.text).collect())
    }

    #[test]
    fn what_does_not_fit_is_dropped_and_said_with_the_reason() {
        for (name, value, unit, why) in [
            (
                "Max T",
                1.0,
                "",
                "a name is 1 to 48 of a-z, 0-9 and _, and begins with a letter",
            ),
            ("", 1.0, "", "a name is"),
            ("9lives", 1.0, "", "a name is"),
            ("größe", 1.0, "", "a name is"),
            (&"a".repeat(49), 1.0, "", "a name is"),
            ("depth", f64::NAN, "m", "a value is a finite number"),
            ("depth", f64::INFINITY, "m", "a value is a finite number"),
            ("depth", 1.0, "metres below the surface", "a unit is at most 16 bytes"),
            ("depth", 1.0, "m\n", "a unit is"),
        ] {
            let (mut measures, mut published) = (Measures::default(), Published::default());
            published.publish(name, value, unit);
            let (values, log) = keep(&mut measures, &mut published, 0);
            assert!(values.is_empty(), "{name}");
            assert!(log.len() == 1 && log[0].contains(why), "{name}: {log:?}");
        }
    }

    #[test]
    fn a_plugin_has_64_names_and_goes_on_with_those() {
        let (mut measures, mut published) = (Measures::default(), Published::default());
        for index in 0..70 {
            published.allow(measures.allowed(Timestamp::from_millis(1000 * index)));
            published.publish(&format!("name_{index}"), 1.0, "");
            published.publish("name_0", 2.0, "");
            let (values, log) = keep(&mut measures, &mut published, index);
            let expected = if index < 64 { 2 } else { 1 };
            assert_eq!(
                (values.len(), log.is_empty()),
                (expected, index < 64),
                "{index}: {log:?}"
            );
        }
    }

    #[test]
    fn a_plugin_that_publishes_in_every_step_fills_no_disk() {
        let (mut measures, mut published) = (Measures::default(), Published::default());
        let (mut kept, mut told) = (0, 0);
        for step in 0..500u64 {
            let now = Timestamp::from_millis(20 * step);
            published.allow(measures.allowed(now));
            for _ in 0..100 {
                published.publish("depth", 1.0, "m");
            }
            let mut log = Vec::new();
            kept += measures.keep(now, &mut published, &mut log).len();
            told += log.len();
        }
        assert!((640..=768).contains(&kept), "{kept} of 50,000 values in 10 s");
        assert!((9..=11).contains(&told), "{told}");
    }
}
