//! The lines that the vehicle may be on, and the ways to them.

use backseat_units::EastNorth;

use super::Outlook;
use crate::ledger::Entry;
use crate::monitor::envelope::{Approach, Insert, Track};
use crate::plugin::RequestState;
use crate::vehicle::course::{Begin, Flown};
use crate::vehicle::plan::Element;

/// Places that are closer to each other than this count as one, metres.
const SAME_M: f64 = 1.0;

impl Outlook<'_> {
    /// The lines on which the vehicle may be while it flies an insert, with the ways from the places where the insert
    /// may have begun.
    pub(crate) fn tracks_of_insert(&self, insert: &Insert, begun: &[Begin]) -> Vec<Track> {
        let approach = |begin: &Begin| self.approach(begin, self.monitor.envelope.path_begins(insert, begin.at));
        let lines = self.monitor.envelope.legs(insert).into_iter();
        let lines = lines.map(|(start, end)| Track::Line(start, end));
        begun.iter().filter_map(approach).chain(lines).collect()
    }

    /// These lines, and the ways to the start of each.
    pub(crate) fn tracks_of_lines(&self, begun: &[Begin], lines: &[(EastNorth, EastNorth)]) -> Vec<Track> {
        let mut starts: Vec<EastNorth> = Vec::new();
        for (start, _) in lines {
            if !starts.contains(start) {
                starts.push(*start);
            }
        }
        // Places this close to each other make no difference: the judged shapes are far wider.
        let mut places: Vec<Begin> = Vec::new();
        for begin in begun {
            match places.iter_mut().find(|known| known.at.distance_m(begin.at) < SAME_M) {
                Some(known) => known.within_m = known.within_m.max(begin.within_m),
                None => places.push(*begin),
            }
        }
        let mut tracks = Vec::new();
        for start in &starts {
            tracks.extend(places.iter().filter_map(|begin| self.approach(begin, [*start; 2])));
        }
        tracks.extend(lines.iter().map(|(start, end)| Track::Line(*start, *end)));
        tracks
    }

    /// The way from where a behavior began to where its path begins. `None` if that is within the tracking error: the
    /// vehicle is already there.
    pub(crate) fn approach(&self, begin: &Begin, to: [EastNorth; 2]) -> Option<Track> {
        let there_m = self.monitor.limits().tracking_error_m;
        let there = to.iter().all(|to| begin.at.distance_m(*to) <= there_m);
        let approach = Approach {
            begun: begin.at,
            within_m: begin.within_m,
            to,
        };
        (!there).then_some(Track::Approach(approach))
    }

    /// What the vehicle may take up again after an insert, as lines and the ways to them: what is interrupted already,
    /// and, if the insert interrupts, what is flown now (SPI 7.5; vehicles differ).
    pub(crate) fn taken_up_after(&self, interrupts: bool) -> Vec<Track> {
        let mut tracks = Vec::new();
        if self.takes_up_plan(interrupts) {
            let planned: Vec<_> = self.vehicle.plan.current().flat_map(Element::legs).collect();
            let begun = self.vehicle.courses.of_plan();
            tracks.extend(self.tracks_of_lines(&begun, &planned));
        }
        let may_resume = |entry: &Entry| entry.interrupted || (interrupts && entry.state == RequestState::Started);
        let open = self
            .ledger
            .iter()
            .map(|(_, entry)| entry)
            .filter(|entry| may_resume(entry));
        // An insert may be flown although it was not answered. What has interrupted the plan may have interrupted that.
        let left_plan = interrupts || self.vehicle.courses.has_left_plan();
        let doubtful = self.ledger.doubtful().filter(|_| left_plan);
        for entry in open.chain(self.ledger.left()).chain(doubtful) {
            let Some(insert) = entry.insert else { continue };
            let begun = entry
                .identifier
                .map(|identifier| self.vehicle.courses.of(Flown::Inserted(identifier)));
            tracks.extend(self.tracks_of_insert(&insert, &begun.unwrap_or_default()));
        }
        tracks
    }

    /// The place to which the vehicle may return before its suspended mission goes on.
    pub(crate) fn returns_to(&self) -> impl Iterator<Item = EastNorth> + '_ {
        self.vehicle.suspended.iter().filter_map(|suspended| suspended.local)
    }
}
