//! The controller's clock against ours.

use std::time::Duration;

use backseat_units::{Timestamp, Utc};

/// Our UTC: what the driver gave for the start, and by how much this computer's clock was set since.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OurClock {
    utc_at_start: Utc,
    set_nanos: i64,
}

impl OurClock {
    pub(crate) const fn new(utc_at_start: Utc) -> Self {
        Self {
            utc_at_start,
            set_nanos: 0,
        }
    }

    pub(crate) const fn set(&mut self, by_nanos: i64) {
        self.set_nanos = by_nanos;
    }

    pub(crate) const fn utc(&self, now: Timestamp) -> Utc {
        let nanos = self.utc_at_start.as_unix_nanos().saturating_add(now.as_nanos());
        Utc::from_unix_nanos(nanos.saturating_add_signed(self.set_nanos))
    }
}

/// How far the controller's clock is from ours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Offset {
    /// The controller's clock less ours.
    pub(crate) nanos: i64,
    /// How far the true offset can be from that; `None` if it was learnt from one way alone.
    pub(crate) within: Option<Duration>,
    at: Timestamp,
}

/// After this long a measurement is replaced by a worse one.
const KEPT: Duration = Duration::from_secs(60);
/// The least change that is reported.
const STEP_NANOS: u64 = 50_000_000;

/// What is known of the controller's clock.
#[derive(Debug, Default)]
pub(crate) struct ControllerClock {
    offset: Option<Offset>,
    told: Option<Offset>,
}

impl ControllerClock {
    /// A new connection, or a clock was set: nothing is known.
    pub(crate) const fn forget(&mut self) {
        self.offset = None;
    }

    /// An acknowledgement. The controller wrote it between our two times, so its clock is known to half of the round
    /// trip.
    pub(crate) fn round_trip(&mut self, now: Timestamp, sent: Utc, received: Utc, controller: Utc) {
        let half = received.as_unix_nanos().saturating_sub(sent.as_unix_nanos()) / 2;
        let middle = sent + Duration::from_nanos(half);
        self.learn(Offset {
            nanos: difference(controller, middle),
            within: Some(Duration::from_nanos(half)),
            at: now,
        });
    }

    /// A time message. It took a while to come, so the offset is at least this.
    pub(crate) fn one_way(&mut self, now: Timestamp, received: Utc, controller: Utc) {
        self.learn(Offset {
            nanos: difference(controller, received),
            within: None,
            at: now,
        });
    }

    fn learn(&mut self, new: Offset) {
        let better = match self.offset {
            None => true,
            Some(old) => {
                let rank = |offset: &Offset| offset.within.unwrap_or(Duration::MAX);
                let old_is_stale = new.at.since(old.at) > KEPT;
                rank(&new) <= rank(&old) || old_is_stale || old.is_refuted_by(&new)
            }
        };
        if better {
            self.offset = Some(new);
        }
    }

    /// The offset, if it differs from the one that was reported last by more than measurement explains.
    pub(crate) fn news(&mut self) -> Option<Offset> {
        let offset = self.offset?;
        let changed = self.told.is_none_or(|told| {
            let doubt = [told.within, offset.within]
                .into_iter()
                .flatten()
                .max()
                .unwrap_or_default();
            let doubt = u64::try_from(doubt.as_nanos()).unwrap_or(u64::MAX);
            told.nanos.abs_diff(offset.nanos) > doubt.max(STEP_NANOS)
        });
        if changed {
            self.told = Some(offset);
            Some(offset)
        } else {
            None
        }
    }

    /// Our time at an instant of the controller's clock; `None` without a measurement.
    pub(crate) fn ours(&self, controller: Utc) -> Option<Utc> {
        let offset = self.offset?.nanos;
        let nanos = if offset >= 0 {
            controller.as_unix_nanos().saturating_sub(offset.unsigned_abs())
        } else {
            controller.as_unix_nanos().saturating_add(offset.unsigned_abs())
        };
        Some(Utc::from_unix_nanos(nanos))
    }
}

impl Offset {
    /// Whether a later measurement shows that a clock was set since.
    fn is_refuted_by(&self, new: &Self) -> bool {
        let Some(within) = self.within else {
            return true;
        };
        let doubt = new.within.unwrap_or_default().saturating_add(within);
        let doubt = u64::try_from(doubt.as_nanos())
            .unwrap_or(u64::MAX)
            .saturating_add(STEP_NANOS);
        let differs = self.nanos.abs_diff(new.nanos) > doubt;
        // A time message can be late by any delay, but never early.
        differs && (new.within.is_some() || new.nanos > self.nanos)
    }
}

/// How much later `a` is than `b`, nanoseconds.
fn difference(a: Utc, b: Utc) -> i64 {
    let nanos = i128::from(a.as_unix_nanos()) - i128::from(b.as_unix_nanos());
    i64::try_from(nanos).unwrap_or(if nanos > 0 { i64::MAX } else { i64::MIN })
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn utc(millis: u64) -> Utc {
        Utc::from_unix_nanos(1_000_000_000_000_000_000 + millis * 1_000_000)
    }

    #[test]
    fn a_round_trip_bounds_the_offset_by_its_half() {
        let mut clock = ControllerClock::default();
        clock.round_trip(Timestamp::ZERO, utc(1000), utc(1040), utc(3020));
        let offset = clock.news().unwrap();
        assert_eq!(
            (offset.nanos, offset.within),
            (2_000_000_000, Some(Duration::from_millis(20)))
        );
        assert_eq!(clock.ours(utc(5000)), Some(utc(3000)));
        assert!(clock.news().is_none(), "it is reported once");
    }

    #[test]
    fn a_worse_measurement_replaces_no_better_one_unless_a_clock_was_set() {
        let mut clock = ControllerClock::default();
        clock.round_trip(Timestamp::ZERO, utc(1000), utc(1010), utc(1005));
        clock.one_way(Timestamp::from_secs(1), utc(2000), utc(1400));
        clock.round_trip(Timestamp::from_secs(2), utc(3000), utc(4000), utc(3300));
        assert_eq!(clock.offset.unwrap().nanos, 0, "late messages prove nothing");
        clock.one_way(Timestamp::from_secs(3), utc(5000), utc(9000));
        assert_eq!(
            clock.offset.unwrap().nanos,
            4_000_000_000,
            "no message comes before it is sent"
        );
        clock.round_trip(Timestamp::from_secs(4), utc(6000), utc(6100), utc(1050));
        assert_eq!(clock.offset.unwrap().nanos, -5_000_000_000);
        assert_eq!(clock.ours(utc(1000)), Some(utc(6000)));
    }
}
