use std::collections::BTreeMap;
use std::time::Duration;

use backseat_units::{TimeOfDay, Timestamp, Utc};

/// How long an earlier stamp can move a new one on. After that, the earlier one is another day's.
const BURST: Duration = Duration::from_secs(60);

/// Gives our sentences their timestamps: UTC in whole milliseconds. Two sentences in a row of one name never have the
/// same stamp, so the echo in an acknowledgement names exactly one command. No stamp is midnight to the millisecond,
/// which in an echo means that there was no time.
#[derive(Debug)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Stamper {
    utc_at_start: Utc,
    /// By how much our computer's clock was set since then, nanoseconds.
    set_nanos: i64,
    /// The last stamp of each name, and when it was given.
    last: BTreeMap<&'static str, (TimeOfDay, Timestamp)>,
}

impl Stamper {
    pub(crate) fn new(utc_at_start: Utc) -> Self {
        Self {
            utc_at_start,
            set_nanos: 0,
            last: BTreeMap::new(),
        }
    }

    /// Our UTC, by the clock of the start: for stamps, and for what is measured with them.
    pub(crate) fn utc(&self, now: Timestamp) -> Utc {
        self.utc_at_start + Duration::from_nanos(now.as_nanos())
    }

    /// Our UTC at a time, by the computer's clock as it is set now: for zones that are valid for a limited time.
    pub(crate) fn zone_utc(&self, at: Timestamp) -> Utc {
        let nanos = self.utc(at).as_unix_nanos();
        Utc::from_unix_nanos(nanos.saturating_add_signed(self.set_nanos))
    }

    /// By how much our computer's clock was set since the start, nanoseconds.
    pub(crate) const fn set_nanos(&self) -> i64 {
        self.set_nanos
    }

    /// The computer's clock was set, in all by this much since the start. Returns by how many seconds it was set now.
    /// Stamps stay on the clock of the start, or answers would seem to come from another time. Zones follow the new
    /// clock.
    pub(crate) fn set(&mut self, by_nanos: i64) -> f64 {
        let before = core::mem::replace(&mut self.set_nanos, by_nanos);
        by_nanos.saturating_sub(before) as f64 / 1e9
    }

    pub(crate) fn stamp(&mut self, now: Timestamp, name: &'static str) -> TimeOfDay {
        let mut stamp = self.utc(now).time_of_day().truncated_to_millis();
        if let Some((last, given)) = self.last.get(name)
            && now.since(*given) < BURST
            && stamp.nanos_since(*last) <= 0
        {
            stamp = *last + Duration::from_millis(1);
        }
        if stamp == TimeOfDay::MIDNIGHT {
            stamp = stamp + Duration::from_millis(1);
        }
        self.last.insert(name, (stamp, now));
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
        assert_eq!(stamps, ["23:59:59.999", "00:00:00.001", "00:00:00.002"]);
        assert_eq!(stamper.stamp(Timestamp::ZERO, "BPRTK").to_string(), "23:59:59.999");
        assert_eq!(
            stamper.stamp(Timestamp::from_secs(1), "BPRMB").to_string(),
            "00:00:00.999"
        );
    }

    #[test]
    fn a_day_later_the_stamp_is_that_of_the_clock() {
        let mut stamper = Stamper::new(Utc::from_unix_nanos(36_000_000_000_000));
        stamper.stamp(Timestamp::from_secs(30), "BPABT");
        let next_day = stamper.stamp(Timestamp::from_secs(86_400), "BPABT");
        assert_eq!(next_day.to_string(), "10:00:00.000");
    }
}
