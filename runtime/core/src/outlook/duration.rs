//! When requests are flown. Zones that are valid for a limited time are judged by these times (safety requirement 002).
//!
//! The vehicle flies an insert when it comes to it. The judgement of an insert covers the time from its request to the
//! latest end that core can compute. A lease under which the planned leg takes longer, or an insert that interrupts,
//! can delay it beyond that. `Inserts::watch_schedules` and [`Outlook::admit_delay`] handle these cases.

use backseat_fence::Span;
use backseat_units::Timestamp;
use backseat_units::math::hypot;

use super::Outlook;
use crate::ledger::schedule::Schedule;
use crate::monitor::envelope::{APART_MAX, Insert, Route};
use crate::monitor::limits::seconds;
use crate::plugin::{Refusal, RequestState};

/// The longest time from the request for an insert until the vehicle takes it up, if nothing is flown before it. It
/// covers the message's way to the vehicle, the pending acknowledgement (SPI 7.5), and the change of behavior.
const TAKEN_UP_S: f64 = 10.0;

impl Outlook<'_> {
    /// The longest time that the vehicle may fly something else before a new insert, seconds; infinite if core cannot
    /// compute it.
    pub(crate) fn before_insert_s(&self, interrupt: bool) -> f64 {
        if interrupt {
            return TAKEN_UP_S;
        }
        self.current_s() + self.others_s() + self.ledger.open_duration_s() + TAKEN_UP_S
    }

    /// The longest time for which the vehicle still flies inserts that have begun, or that are not ours, seconds; 0 if
    /// there are none.
    pub(crate) fn flown_insert_s(&self) -> f64 {
        let flown = self
            .ledger
            .iter()
            .filter(|(_, entry)| entry.state == RequestState::Started);
        let others_s = self.others_s();
        flown.fold(others_s, |all, (_, entry)| all + entry.duration_s)
    }

    /// The longest time for which the planned behavior that is flown goes on, seconds. Core can compute it for lines
    /// only: no sentence says what else the vehicle does at a place, or how often it goes round (SPI 6.20).
    pub(crate) fn current_s(&self) -> f64 {
        let Some(navigation) = self.vehicle.navigation.newest() else {
            return f64::INFINITY;
        };
        let slowest_mps = self.monitor.envelope.slowest_mps();
        // A vehicle that is slower than its least speed waits for something.
        let over_ground_mps = hypot(navigation.east_mps, navigation.north_mps);
        if over_ground_mps.is_nan() || over_ground_mps < slowest_mps {
            return f64::INFINITY;
        }
        let mut longest_m: Option<f64> = None;
        for element in self.vehicle.plan.flown() {
            let length_m = element
                .line_m()
                .map(|length_m| length_m + navigation.local.distance_m(element.first()));
            longest_m = Some(longest_m.unwrap_or(0.0).max(length_m.unwrap_or(f64::INFINITY)));
        }
        longest_m.map_or(f64::INFINITY, |length_m| length_m / slowest_mps)
    }

    /// How long the inserts take that are not ours, seconds.
    pub(crate) fn others_s(&self) -> f64 {
        let mut at = self.vehicle.navigation.newest().map(|navigation| navigation.local);
        let others = self.others();
        let mut all_m = 0.0;
        for (_, element) in others {
            let transit_m = at.map_or(f64::INFINITY, |at| at.distance_m(element.first()));
            all_m += transit_m + element.line_m().unwrap_or(f64::INFINITY);
            at = Some(element.last());
        }
        all_m / self.monitor.envelope.slowest_mps()
    }

    /// The times by which an insert that is about to be sent was judged. `None` if these are not known, so that the
    /// worst case was judged, or if no zone ever changes.
    pub(crate) fn schedule(&self, insert: &Insert, route: &Route) -> Option<Schedule> {
        let lasts_s = self.monitor.envelope.lasts_s(insert, route);
        let known = self.clocks().next(route.before_s + lasts_s).is_some();
        if !known || !self.monitor.envelope.fence().changes() {
            return None;
        }
        let begins_by = self.now + seconds(route.before_s);
        Some(Schedule {
            begins_by,
            ends_by: begins_by + seconds(lasts_s),
            lasts_s,
        })
    }

    /// Refuses an insert that delays one of ours, if a zone changes in the time by which that one is delayed. An insert
    /// that interrupts delays what is flown. While one of ours is or may be interrupted, each further insert delays it: the
    /// vehicle may fly all that wait before it comes back (SPI 7.5).
    pub(crate) fn admit_delay(&self, insert: &Insert, route: &Route) -> Result<(), Refusal> {
        let all_s =
            TAKEN_UP_S + self.others_s() + self.ledger.open_duration_s() + self.monitor.envelope.lasts_s(insert, route);
        let begun = self
            .ledger
            .iter()
            .filter(|(_, entry)| entry.state == RequestState::Started);
        for (request, entry) in begun {
            let Some(schedule) = entry.schedule else { continue };
            if !insert.interrupt && !entry.interrupted && !self.ledger.awaits_interrupter(request) {
                continue;
            }
            let delay_s = all_s - entry.duration_s;
            if !delay_s.is_finite() || self.changes_between(schedule.ends_by, schedule.ends_by + seconds(delay_s)) {
                return Err(Refusal::Delays { request });
            }
        }
        Ok(())
    }

    /// Whether a zone opens or closes between two times, by our clock or the vehicle's.
    pub(crate) fn changes_between(&self, from: Timestamp, until: Timestamp) -> bool {
        let apart = self.clocks_apart().unwrap_or(APART_MAX);
        self.monitor.envelope.fence().changes_within(Span {
            from: self.stamper.zone_utc(from - apart),
            until: self.stamper.zone_utc(until + apart),
        })
    }
}
