use std::collections::BTreeMap;
use std::time::Duration;

use backseat_units::{TimeOfDay, Timestamp, Utc};

/// Gives our sentences their timestamps: UTC in whole milliseconds, never the same twice running for one name, so that
/// an acknowledgement's echo names exactly one command.
#[derive(Debug)]
pub(crate) struct Stamper {
    utc_at_start: Utc,
    last: BTreeMap<&'static str, TimeOfDay>,
}

impl Stamper {
    pub(crate) fn new(utc_at_start: Utc) -> Self {
        Self {
            utc_at_start,
            last: BTreeMap::new(),
        }
    }

    pub(crate) fn utc(&self, now: Timestamp) -> Utc {
        self.utc_at_start + Duration::from_nanos(now.as_nanos())
    }

    pub(crate) fn stamp(&mut self, now: Timestamp, name: &'static str) -> TimeOfDay {
        let mut stamp = self.utc(now).time_of_day().truncated_to_millis();
        if let Some(last) = self.last.get(name)
            && stamp.nanos_since(*last) <= 0
            // Further back than this is a new day or a stepped clock, not a burst.
            && stamp.nanos_since(*last) > -60_000_000_000
        {
            stamp = *last + Duration::from_millis(1);
        }
        self.last.insert(name, stamp);
        stamp
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_of_one_name_never_repeat() {
        let mut stamper = Stamper::new(Utc::from_unix_nanos(86_399_999_000_000));
        let stamps: Vec<String> = (0..3)
            .map(|_| stamper.stamp(Timestamp::ZERO, "BPRMB").to_string())
            .collect();
        assert_eq!(stamps, ["23:59:59.999", "00:00:00.000", "00:00:00.001"]);
        assert_eq!(stamper.stamp(Timestamp::ZERO, "BPRTK").to_string(), "23:59:59.999");
        assert_eq!(
            stamper.stamp(Timestamp::from_secs(1), "BPRMB").to_string(),
            "00:00:00.999"
        );
    }
}
