use std::collections::BTreeMap;
use std::fmt;

use backseat_spi::catalogue;

use crate::reading::{Cause, Checksum, Reading};

/// Counts of messages and faults.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Decoded sentences by name. Unknown names count as a fault.
    pub(crate) messages: BTreeMap<&'static str, u64>,
    faults: BTreeMap<Cause, u64>,
    ignored_checksums: u64,
    pub(crate) too_long: u64,
    pub(crate) noise_bytes: u64,
}

impl Tally {
    pub(crate) fn count(&mut self, reading: &Reading<'_>) {
        match &reading.outcome {
            Ok(_) => {
                // Every decoded sentence has a row.
                let name = reading.entry.map_or("", |entry| entry.name);
                *self.messages.entry(name).or_default() += 1;
                if reading.checksum == Checksum::Invalid {
                    self.ignored_checksums += 1;
                }
            }
            Err(error) => *self.faults.entry(error.cause()).or_default() += 1,
        }
    }

    /// Sets the splitter's counts of skipped bytes, which cover its whole life.
    pub(crate) const fn set_passed(&mut self, too_long: u64, noise_bytes: u64) {
        self.too_long = too_long;
        self.noise_bytes = noise_bytes;
    }

    /// All sentences, including the faulty ones.
    #[must_use]
    pub fn sentences(&self) -> u64 {
        self.read() + self.faults.values().sum::<u64>()
    }

    /// Decoded sentences.
    #[must_use]
    pub fn read(&self) -> u64 {
        self.messages.values().sum()
    }

    /// How many messages of each name have been decoded, in the order of the specification.
    pub(crate) fn by_message(&self) -> impl Iterator<Item = (&'static str, u64)> + '_ {
        catalogue()
            .iter()
            .filter_map(|entry| Some((entry.name, *self.messages.get(entry.name)?)))
    }

    /// The faults in words; empty if there are none.
    pub(crate) fn faults(&self) -> Vec<String> {
        let mut faults: Vec<String> = self
            .faults
            .iter()
            .map(|(cause, count)| format!("{count} {}", cause.text()))
            .collect();
        if self.ignored_checksums > 0 {
            faults.push(format!("{} read in spite of a wrong checksum", self.ignored_checksums));
        }
        if self.too_long > 0 {
            faults.push(format!(
                "{} over {} bytes without an end",
                self.too_long,
                backseat_spi::MAX_LINE
            ));
        }
        if self.noise_bytes > 0 {
            faults.push(format!("{} bytes of noise", self.noise_bytes));
        }
        faults
    }
}

impl fmt::Display for Tally {
    /// One line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sentences = self.sentences();
        write!(
            f,
            "{sentences} sentence{}, {} read",
            if sentences == 1 { "" } else { "s" },
            self.read()
        )?;
        self.faults().iter().try_for_each(|fault| write!(f, ", {fault}"))
    }
}
