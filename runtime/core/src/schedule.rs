//! When things are flown: what the zones that are valid for a time are judged by (safety requirement 002).
//!
//! An insert flies when the vehicle comes to it. Its judgement covers the time from the asking to the latest end that
//! can be told. What delays it beyond that, a lease under which the planned leg grows longer, an insert that interrupts,
//! is met here: one that has not begun by then is judged by the new time, and called back where that does not hold.

use std::time::Duration;

use backseat_fence::Span;
use backseat_units::Timestamp;
use backseat_units::math::hypot;

use crate::context::Context;
use crate::envelope::{APART_MAX, Clocks, Insert, Route};
use crate::inserts::Inserts;
use crate::io::Note;
use crate::limits::seconds;
use crate::plan::Element;
use crate::plugin::{Refusal, RequestState};
use crate::refusal::refused;

/// An insert is taken up so long after it was asked for at the latest, where nothing is flown before it: its way there,
/// the vehicle's pending answer (SPI 7.5), and the change of the behaviour.
const TAKEN_UP_S: f64 = 10.0;

/// By when an insert was judged to be flown.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Schedule {
    begins_by: Timestamp,
    ends_by: Timestamp,
    lasts_s: f64,
}

impl Inserts {
    /// Calls back what has not begun in time and whose zones change by when it may be flown now.
    pub(crate) fn watch_schedules(&mut self, cx: &mut Context) {
        let now = cx.now;
        let waiting = cx
            .ledger
            .iter()
            .filter(|(_, entry)| entry.state != RequestState::Started);
        let late: Vec<(u64, Schedule)> = waiting
            .filter_map(|(request, entry)| Some((request, entry.schedule?)))
            .filter(|(_, schedule)| schedule.begins_by < now)
            .collect();
        if late.is_empty() {
            return;
        }
        // Its elders alone come before it. All that is open takes no less.
        let before_s = cx.before_insert_s(false);
        for (request, schedule) in late {
            let anew = Schedule {
                begins_by: now + seconds(before_s),
                ends_by: now + seconds(before_s + schedule.lasts_s),
                ..schedule
            };
            let holds = before_s.is_finite() && !cx.changes_between(schedule.ends_by, anew.ends_by);
            if let Some(entry) = cx.ledger.get_mut(request) {
                entry.schedule = holds.then_some(anew);
            }
            if !holds {
                self.call_back(
                    cx,
                    request,
                    "it has not begun in the time that its zones were judged for",
                );
            }
        }
    }

    /// Takes an insert back, where that can be done, and says why.
    pub(crate) fn call_back(&mut self, cx: &mut Context, request: u64, why: &str) {
        if cx.ledger.is_gps_hit(Some(request)) {
            let text = format!("GPS hit {request}: {why}, and it cannot be cancelled (SPI 7.8)");
            return cx.note(Note::Text { text });
        }
        let text = format!("insert {request} is called back: {why}");
        cx.note(Note::Text { text });
        self.recall(cx, request);
    }
}

impl Context {
    /// What is known of the time.
    pub(crate) fn clocks(&self) -> Clocks {
        Clocks {
            utc: self.zone_utc(self.now),
            apart: self.clocks_apart(),
        }
    }

    /// By how much our clock and the vehicle's differ, where that is little enough for both to tell the time.
    pub(crate) fn clocks_apart(&self) -> Option<Duration> {
        self.vehicle.navigation.clocks_apart(self.now, self.stamper.set_nanos())
    }

    /// How long what may be flown before a new insert takes at most, seconds; infinite where nobody can say.
    pub(crate) fn before_insert_s(&self, interrupt: bool) -> f64 {
        if interrupt {
            return TAKEN_UP_S;
        }
        self.current_s() + self.others_s() + self.ledger.open_duration_s() + TAKEN_UP_S
    }

    /// How long the insert that is flown goes on at most, seconds; 0 where the vehicle flies its plan.
    pub(crate) fn flown_insert_s(&self) -> f64 {
        let flown = self
            .ledger
            .iter()
            .filter(|(_, entry)| entry.state == RequestState::Started);
        let others_s = self.others_s();
        flown.fold(others_s, |all, (_, entry)| all + entry.duration_s)
    }

    /// How long the planned behaviour that is flown goes on at most, seconds. Only that of a line can be told: what
    /// else the vehicle does at a place, or how often it goes round, no sentence says (SPI 6.20).
    pub(crate) fn current_s(&self) -> f64 {
        let Some(navigation) = self.vehicle.navigation.newest() else {
            return f64::INFINITY;
        };
        let slowest_mps = self.monitor.envelope.slowest_mps();
        // One that makes less way than it must waits for something.
        let over_ground_mps = hypot(navigation.east_mps, navigation.north_mps);
        if over_ground_mps.is_nan() || over_ground_mps < slowest_mps {
            return f64::INFINITY;
        }
        let mut longest_m: Option<f64> = None;
        for element in self.vehicle.plan.flown() {
            let length_m = line_m(element).map(|length_m| length_m + navigation.local.distance_m(element.first()));
            longest_m = Some(longest_m.unwrap_or(0.0).max(length_m.unwrap_or(f64::INFINITY)));
        }
        longest_m.map_or(f64::INFINITY, |length_m| length_m / slowest_mps)
    }

    /// How long the inserts take that are not ours.
    pub(crate) fn others_s(&self) -> f64 {
        let mut at = self.vehicle.navigation.newest().map(|navigation| navigation.local);
        let others = self
            .vehicle
            .plan
            .others(|identifier| self.identifiers.is_ours(identifier));
        let mut all_m = 0.0;
        for (_, element) in others {
            let transit_m = at.map_or(f64::INFINITY, |at| at.distance_m(element.first()));
            all_m += transit_m + line_m(element).unwrap_or(f64::INFINITY);
            at = Some(element.last());
        }
        all_m / self.monitor.envelope.slowest_mps()
    }

    /// The time that an insert about to be sent was judged by; `None` where it was judged at the worst, or no zone ever
    /// changes.
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

    /// What interrupts an insert of ours delays it, and the vehicle may come back to it (SPI 7.5).
    pub(crate) fn admit_delay(&self, insert: &Insert, route: &Route) -> Result<(), Refusal> {
        if !insert.interrupt {
            return Ok(());
        }
        let delay_s = route.before_s + self.monitor.envelope.lasts_s(insert, route);
        let begun = self
            .ledger
            .iter()
            .filter(|(_, entry)| entry.state == RequestState::Started);
        for (request, entry) in begun {
            let delayed = entry
                .schedule
                .filter(|schedule| self.changes_between(schedule.ends_by, schedule.ends_by + seconds(delay_s)));
            if delayed.is_some() {
                return Err(refused(
                    "time",
                    &format!("it would delay insert {request} into a time for which that was not judged"),
                ));
            }
        }
        Ok(())
    }

    /// Whether a zone opens or closes between two times, by our clock or the vehicle's.
    pub(crate) fn changes_between(&self, from: Timestamp, until: Timestamp) -> bool {
        let apart = self.clocks_apart().unwrap_or(APART_MAX);
        self.monitor.envelope.fence().changes_within(Span {
            from: self.zone_utc(from - apart),
            until: self.zone_utc(until + apart),
        })
    }
}

/// The length of an element that is a line; `None` of a circle, and of a single place.
fn line_m(element: &Element) -> Option<f64> {
    if element.circles || element.points.len() < 2 {
        return None;
    }
    Some(element.legs().map(|(start, end)| start.distance_m(end)).sum())
}
