use std::collections::BTreeMap;
use std::time::Duration;

use backseat_units::{TimeOfDay, Timestamp, Utc};

/// How long an earlier stamp can move a new one on. After that, the earlier one is another day's.
const BURST: Duration = Duration::from_secs(60);

/// The commands with an identifier. Their answers decide what core believes that the vehicle flies.
const TOLD_APART: [&str; 4] = ["RTK", "RTC", "RGP", "RCN"];
/// How far apart the stamps of such commands are. An echo with two decimals, as the specification prints it, is up to
/// 10 ms before the stamp if the vehicle cuts the rest off, and up to 5 ms before or after it if the vehicle rounds. It
/// echoes each stamp that is less than 10 ms from it.
const APART: Duration = Duration::from_millis(20);
/// How far ahead of the clock a stamp can be for that.
const AHEAD_MAX: Duration = Duration::from_secs(1);

/// Gives our sentences their timestamps: UTC in whole milliseconds. Two sentences in a row of one name never have the
/// same stamp, so the echo in an acknowledgement names exactly one command. It does so even with two decimals if the
/// command is an insert or a cancel, unless core sends more than 50 of one name in a second. No stamp is midnight to the
/// millisecond, which in an echo means that there was no time.
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
        {
            let apart = *last + APART;
            let ahead = i128::from(apart.nanos_since(stamp));
            if TOLD_APART.contains(&name) && ahead > 0 && ahead <= AHEAD_MAX.as_nanos() as i128 {
                stamp = apart;
            } else if stamp.nanos_since(*last) <= 0 {
                stamp = *last + Duration::from_millis(1);
            }
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
    use backseat_spi::EchoedTime;

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
    fn echoes_with_two_decimals_tell_inserts_of_one_instant_apart() {
        for name in TOLD_APART {
            let mut stamper = Stamper::new(Utc::from_unix_nanos(86_399_990_000_000));
            let stamps: Vec<TimeOfDay> = (0..50).map(|_| stamper.stamp(Timestamp::ZERO, name)).collect();
            for (index, stamp) in stamps.iter().enumerate() {
                let rounded = *stamp + Duration::from_millis(5);
                for written in [*stamp, rounded].map(|written| EchoedTime::with_decimals(written, 2)) {
                    let echoed = stamps.iter().filter(|other| written.echoes(**other));
                    assert!(echoed.eq([stamp]), "{name} {index}: {written}");
                }
            }
            assert!(stamps[49].nanos_since(stamps[0]) <= 1_000_000_000);
            // More in one second have stamps of their own, but a short echo may not tell them apart.
            let more = stamper.stamp(Timestamp::ZERO, name);
            let more: Vec<TimeOfDay> = (0..9)
                .map(|_| stamper.stamp(Timestamp::ZERO, name))
                .chain([more])
                .collect();
            assert!(more.iter().all(|stamp| !stamps.contains(stamp)));
        }
    }

    #[test]
    fn a_day_later_the_stamp_is_that_of_the_clock() {
        let mut stamper = Stamper::new(Utc::from_unix_nanos(36_000_000_000_000));
        stamper.stamp(Timestamp::from_secs(30), "BPABT");
        let next_day = stamper.stamp(Timestamp::from_secs(86_400), "BPABT");
        assert_eq!(next_day.to_string(), "10:00:00.000");
    }
}
