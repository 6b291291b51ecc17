use std::collections::BTreeSet;

use backseat_spi::{BehaviorId, PlanElement, PlanElementKind};
use backseat_units::{EastNorth, LocalFrame, TimeOfDay, Timestamp};

use crate::vehicle::clock::elapsed_nanos;

/// A plan with more points than this is not believed.
const POINTS_MAX: usize = 10_000;
/// A message that the vehicle makes this long after the newest of a series may still belong to it.
const SERIES_LASTS_NANOS: i64 = 1_000_000_000;
/// How many of the numbers that the plan does not have are remembered.
const LACKS_MAX: usize = 64;

/// One behavior of the vehicle's plan, from the BFPLN messages with its number or identifier (SPI 6.20).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) struct Element {
    pub(crate) number: Option<u32>,
    pub(crate) identifier: Option<BehaviorId>,
    /// In the order in which the vehicle passes them; never empty.
    pub(crate) points: Vec<EastNorth>,
    /// The kinds that its messages named, each once.
    pub(crate) kinds: Vec<PlanElementKind>,
    /// It is a circle, for any number of orbits.
    pub(crate) circles: bool,
}

impl Element {
    fn is_of(&self, message: &PlanElement) -> bool {
        self.number == message.number && self.identifier == message.identifier
    }

    /// What it is, in words.
    pub(crate) fn kind_name(&self) -> &'static str {
        match self.kinds.first() {
            Some(PlanElementKind::Waypoint) if self.points.len() == 1 => "a waypoint",
            Some(PlanElementKind::Waypoint) => "several waypoints",
            Some(PlanElementKind::TracklineStart | PlanElementKind::TracklineEnd) => "a trackline",
            Some(PlanElementKind::Trackcircle) => "a trackcircle",
            Some(PlanElementKind::Other(_)) => "of another kind",
            None => "nothing",
        }
    }

    /// The first point.
    pub(crate) fn first(&self) -> EastNorth {
        self.points[0]
    }

    /// The last point.
    pub(crate) fn last(&self) -> EastNorth {
        self.points[self.points.len() - 1]
    }

    /// The points to which the vehicle may go on after something that it flies in the middle of the element: each but the
    /// first. A single line has no middle.
    fn goes_on_within(&self) -> impl Iterator<Item = EastNorth> + '_ {
        let of_line =
            |kind: &PlanElementKind| matches!(kind, PlanElementKind::TracklineStart | PlanElementKind::TracklineEnd);
        let is_one_line = self.points.len() == 2 && self.kinds.iter().all(of_line);
        let points = self.points.iter().skip(1).copied();
        points.filter(move |_| !is_one_line)
    }

    /// The length of a line, metres; `None` for a circle and for a single place.
    pub(crate) fn line_m(&self) -> Option<f64> {
        if self.circles || self.points.len() < 2 {
            return None;
        }
        Some(self.legs().map(|(start, end)| start.distance_m(end)).sum())
    }

    /// The legs between its points; a single point is a leg of no length.
    pub(crate) fn legs(&self) -> impl Iterator<Item = (EastNorth, EastNorth)> + '_ {
        let single = (self.points.len() == 1).then(|| (self.points[0], self.points[0]));
        single
            .into_iter()
            .chain(self.points.windows(2).map(|pair| (pair[0], pair[1])))
    }
}

/// What became of a BFPLN.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Collected {
    /// It is part of the series.
    Taken,
    /// It came before, or nobody asked for it.
    Ignored,
    /// It belongs to a series that had ended: the plan lacks it.
    Late,
}

/// What tells two BFPLN apart: when the vehicle made them, number, identifier, index, and the bits of the position.
type Told = (u64, Option<u32>, Option<BehaviorId>, u32, [u64; 2]);

/// The messages of a series, to tell one that comes again.
#[derive(Clone, Debug, Default)]
struct Series {
    messages: BTreeSet<Told>,
    newest: Option<TimeOfDay>,
}

impl Series {
    fn created(&self) -> Option<TimeOfDay> {
        self.newest
    }

    /// Returns whether it is new.
    fn insert(&mut self, message: &PlanElement) -> bool {
        if self.messages.len() > POINTS_MAX {
            return true;
        }
        let place = [
            message.position.latitude.as_deg().to_bits(),
            message.position.longitude.as_deg().to_bits(),
        ];
        let is_new = self.messages.insert((
            message.created.as_nanos(),
            message.number,
            message.identifier,
            message.index,
            place,
        ));
        let is_later = self
            .newest
            .is_none_or(|newest| elapsed_nanos(newest, message.created) > 0);
        if is_new && is_later {
            self.newest = Some(message.created);
        }
        is_new
    }
}

/// The vehicle's plan as the last answer to BPRMP gave it, and where in it the vehicle is.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Plan {
    elements: Vec<Element>,
    collecting: Option<Vec<Element>>,
    points_collected: usize,
    /// The messages of the series.
    #[cfg_attr(feature = "explore", serde(skip))]
    series: Series,
    /// The inserts that have ended since the series began.
    ended: BTreeSet<BehaviorId>,
    /// When the vehicle was asked for it.
    asked_at: Timestamp,
    /// How much had been lost on the link when the series began, and whether one of its own messages could not be read.
    lost: u64,
    unreadable: bool,
    /// Number, identifier and index of the first message of the series.
    first: Option<(Option<u32>, Option<BehaviorId>, u32)>,
    complete: bool,
    /// Numbers of behaviors that the vehicle was flying when a complete series came without them. The vehicle does not
    /// report these, and that is no fault of its plan.
    lacks: BTreeSet<u32>,
    current: Option<u32>,
    /// The current behavior has ended, and nothing has begun since.
    between: bool,
    /// A message was lost, so another behavior may have begun since.
    unheard: bool,
    /// The behaviors of which one was seen to be flown, if its begin was not heard.
    seen: Vec<u32>,
}

impl Plan {
    /// Forgets all of it.
    pub(crate) fn forget(&mut self) {
        *self = Self::default();
    }

    /// The plan is not valid any more, but the vehicle's place in it is.
    pub(crate) fn invalidate(&mut self) {
        self.complete = false;
    }

    /// BPRMP has been sent, or the vehicle has acknowledged it as pending: what comes now is a new plan. `lost` is how
    /// much had been lost on the link until then.
    pub(crate) fn begin(&mut self, lost: u64) {
        self.collecting = Some(Vec::new());
        self.points_collected = 0;
        self.ended.clear();
        self.series = Series::default();
        self.lost = lost;
        self.unreadable = false;
        self.first = None;
    }

    /// Takes a BFPLN.
    pub(crate) fn collect(&mut self, frame: &LocalFrame, message: &PlanElement) -> Collected {
        let last = self.series.created();
        let is_older = last.is_some_and(|last| elapsed_nanos(last, message.created) < 0);
        let is_new = self.series.insert(message);
        let Some(elements) = &mut self.collecting else {
            // One that was made later belongs to another series, for which another payload may have asked.
            let of_series = last.is_some_and(|last| elapsed_nanos(last, message.created) <= SERIES_LASTS_NANOS);
            return if self.complete && is_new && of_series {
                Collected::Late
            } else {
                Collected::Ignored
            };
        };
        if !is_new {
            return Collected::Ignored;
        }
        // The vehicle makes the messages of a series in their order.
        self.unreadable |= is_older;
        let of = (message.number, message.identifier, message.index);
        if *self.first.get_or_insert(of) == of && (of.0.is_some() || of.1.is_some()) {
            // The series begins again: the plan was asked for twice, and both answers come.
            elements.clear();
        }
        let point = frame.to_local(message.position);
        let circles = message.element == PlanElementKind::Trackcircle;
        match elements.last_mut() {
            Some(last) if last.is_of(message) => {
                last.points.push(point);
                last.circles |= circles;
                if !last.kinds.contains(&message.element) {
                    last.kinds.push(message.element);
                }
            }
            _ => elements.push(Element {
                number: message.number,
                identifier: message.identifier,
                points: vec![point],
                kinds: vec![message.element],
                circles,
            }),
        }
        self.points_collected += 1;
        if self.points_collected > POINTS_MAX {
            self.collecting = None;
        }
        Collected::Taken
    }

    /// BPRMP leaves now.
    pub(crate) const fn asked(&mut self, now: Timestamp) {
        self.asked_at = now;
    }

    pub(crate) const fn asked_at(&self) -> Timestamp {
        self.asked_at
    }

    /// A BFPLN could not be read.
    pub(crate) fn unreadable(&mut self) {
        self.unreadable = true;
    }

    /// The vehicle has sent the whole series; `lost` is how much has been lost on the link until now. Returns true if
    /// the plan is known now. It is not if anything was lost since the series began, because that may have been one of
    /// its messages: a series does not say how many messages it has (SPI 6.20).
    pub(crate) fn end(&mut self, lost: u64) -> bool {
        let whole = lost == self.lost && !self.unreadable;
        let collected = self.collecting.take();
        let Some(elements) = collected.filter(|elements| whole && !elements.is_empty()) else {
            return false;
        };
        self.elements = joined(elements);
        let ended = std::mem::take(&mut self.ended);
        self.elements
            .retain(|element| element.identifier.is_none_or(|identifier| !ended.contains(&identifier)));
        self.complete = true;
        if let Some(number) = self.current.filter(|number| !self.names(*number))
            && self.lacks.len() < LACKS_MAX
        {
            self.lacks.insert(number);
        }
        true
    }

    /// The series has failed.
    pub(crate) fn fail(&mut self) {
        self.collecting = None;
    }

    pub(crate) fn is_complete(&self) -> bool {
        self.complete
    }

    pub(crate) fn is_collecting(&self) -> bool {
        self.collecting.is_some()
    }

    /// A planned behavior has begun. Returns false if the complete plan does not have it, so that it may not be the
    /// current plan. A behavior that the vehicle is known not to report does not count.
    pub(crate) fn began(&mut self, number: u32) -> bool {
        self.current = Some(number);
        (self.between, self.unheard) = (false, false);
        self.seen.clear();
        !self.complete || self.names(number) || self.lacks.contains(&number)
    }

    /// A planned behavior has ended. Until something begins, it is not known which one is flown.
    pub(crate) fn finished(&mut self, number: u32) {
        if self.current == Some(number) {
            self.between = true;
        }
        self.seen.clear();
    }

    /// A message was lost. Until a planned behavior begins, it is not known which one is flown.
    pub(crate) fn invalidate_after_loss(&mut self) {
        self.unheard = true;
        self.seen.clear();
    }

    /// The begin of what is flown was not heard, but the vehicle was seen to fly one of these.
    pub(crate) fn seen_at(&mut self, numbers: &[u32]) {
        self.seen = numbers.to_vec();
    }

    /// An insert has begun. The planned behavior that ended before it is the one after which it was inserted, and which
    /// the vehicle may have left for it. So that behavior is still the place in the plan.
    pub(crate) fn left_for_insert(&mut self) {
        self.between = false;
    }

    /// The planned behavior that is flown, or that was flown when an insert began, if the plan has it. Several if the
    /// vehicle was seen to fly one of them; none if nobody knows.
    fn at(&self) -> &[u32] {
        let heard = |number: &u32| !self.between && !self.unheard && self.names(*number);
        match &self.current {
            Some(current) if heard(current) => std::slice::from_ref(current),
            _ => &self.seen,
        }
    }

    fn is_at(&self, element: &Element) -> bool {
        element.number.is_some_and(|number| self.at().contains(&number))
    }

    /// Whether the plan names an insert.
    pub(crate) fn has(&self, identifier: BehaviorId) -> bool {
        self.elements
            .iter()
            .any(|element| element.identifier == Some(identifier))
    }

    /// Inserts of the plan that are not known to be ours: a previous run's, or another payload's.
    pub(crate) fn others(&self, is_ours: impl Fn(BehaviorId) -> bool) -> impl Iterator<Item = (BehaviorId, &Element)> {
        self.elements.iter().filter_map(move |element| {
            let identifier = element.identifier?;
            (!is_ours(identifier)).then_some((identifier, element))
        })
    }

    /// An insert is over: the vehicle will not fly it again.
    pub(crate) fn ended(&mut self, identifier: BehaviorId) {
        self.elements.retain(|element| element.identifier != Some(identifier));
        if self.collecting.is_some() {
            // The vehicle may have made the series before.
            self.ended.insert(identifier);
        }
    }

    /// The front seat's own elements.
    pub(crate) fn planned(&self) -> impl Iterator<Item = &Element> {
        self.elements.iter().filter(|element| element.identifier.is_none())
    }

    /// The elements that the vehicle may be on now: the current ones, or every one if those are not known.
    pub(crate) fn current(&self) -> impl Iterator<Item = &Element> {
        let anywhere = self.at().is_empty();
        self.planned().filter(move |element| anywhere || self.is_at(element))
    }

    /// Whether the plan has a planned behavior with this number.
    pub(crate) fn names(&self, number: u32) -> bool {
        self.planned().any(|element| element.number == Some(number))
    }

    /// The elements of the planned behavior that is flown; none if that is not known.
    pub(crate) fn flown(&self) -> impl Iterator<Item = &Element> {
        self.planned().filter(|element| self.is_at(element))
    }

    /// The lines of the front seat's own elements, and the way to each element from the one before, with the number of
    /// the element.
    pub(crate) fn lines(&self) -> impl Iterator<Item = (u32, (EastNorth, EastNorth))> + '_ {
        let before = std::iter::once(None).chain(self.planned().map(Some));
        before.zip(self.planned()).flat_map(|(before, element)| {
            let way = before.map(|before| (before.last(), element.first()));
            let lines = way.into_iter().chain(element.legs());
            lines.filter_map(|line| Some((element.number?, line)))
        })
    }

    /// If what is flown was seen and not heard: the ways to what was seen, and the legs of what comes before it.
    pub(crate) fn seen_before(&self) -> impl Iterator<Item = (EastNorth, EastNorth)> + '_ {
        let pairs = self.planned().zip(self.planned().skip(1));
        let pairs = pairs.filter(|(_, element)| element.number.is_some_and(|number| self.seen.contains(&number)));
        pairs.flat_map(|(before, element)| before.legs().chain([(before.last(), element.first())]))
    }

    /// The first points of what may come after the current element.
    pub(crate) fn next_points(&self) -> Vec<EastNorth> {
        if self.at().is_empty() {
            return self.planned().map(Element::first).collect();
        }
        let next = |current: &u32| {
            let mut after = self.planned().skip_while(|element| element.number != Some(*current));
            // Several elements may have one number, because they belong to one behavior. All of them are passed over.
            after
                .find(|element| element.number != Some(*current))
                .map(Element::first)
        };
        self.at().iter().filter_map(next).collect()
    }

    /// Where the vehicle may go on after an insert: to the first points of what comes after the current element, or, if the
    /// insert is flown between two points of that, to the next of them (SPI 7.5).
    pub(crate) fn goes_on_to(&self) -> Vec<EastNorth> {
        let points = self.current().flat_map(Element::goes_on_within);
        let mut to = self.next_points();
        to.extend(points);
        to
    }

    /// All elements, the inserts included.
    pub(crate) fn elements(&self) -> impl Iterator<Item = &Element> {
        self.elements.iter()
    }

    /// How many elements there are, the inserts included.
    pub(crate) fn len(&self) -> usize {
        self.elements.len()
    }
}

/// Joins the elements of each behavior of the plan. The plan may name an insert between two of them.
fn joined(elements: Vec<Element>) -> Vec<Element> {
    let mut joined: Vec<Element> = Vec::new();
    for element in elements {
        let planned = element.identifier.is_none() && element.number.is_some();
        let before = joined.iter_mut().rev().find(|before| before.identifier.is_none());
        match before.filter(|before| planned && before.number == element.number) {
            Some(before) => {
                before.points.extend(element.points);
                before.circles |= element.circles;
                for kind in element.kinds {
                    if !before.kinds.contains(&kind) {
                        before.kinds.push(kind);
                    }
                }
            }
            None => joined.push(element),
        }
    }
    joined
}

#[cfg(test)]
mod tests {
    use backseat_spi::PlanElementKind;
    use backseat_units::{Position, TimeOfDay};

    use super::*;

    fn frame() -> LocalFrame {
        LocalFrame::new(Position::from_deg(42.0, -70.0).unwrap())
    }

    fn collect(plan: &mut Plan, number: Option<u32>, identifier: Option<u32>, index: u32, east_m: f64) {
        let frame = frame();
        plan.collect(
            &frame,
            &PlanElement {
                created: TimeOfDay::MIDNIGHT,
                number,
                identifier: identifier.map(BehaviorId::new),
                index,
                element: PlanElementKind::Waypoint,
                position: frame.to_position(EastNorth::new(east_m, 0.0)),
            },
        );
    }

    fn plan() -> Plan {
        let mut plan = Plan::default();
        plan.begin(3);
        collect(&mut plan, Some(1), None, 0, 0.0);
        collect(&mut plan, Some(2), None, 0, 100.0);
        collect(&mut plan, Some(2), None, 1, 200.0);
        collect(&mut plan, None, Some(7), 0, 250.0);
        collect(&mut plan, Some(3), None, 0, 300.0);
        plan
    }

    #[test]
    fn a_plan_counts_only_when_its_series_is_complete() {
        let mut whole = plan();
        assert!(!whole.is_complete());
        assert!(whole.end(3) && whole.is_complete() && whole.has(BehaviorId::new(7)));
        let mut cut = plan();
        cut.fail();
        assert!(!cut.end(3) && !cut.is_complete());
        let mut damaged = plan();
        assert!(!damaged.end(4) && !damaged.is_complete());
        let mut unreadable = plan();
        unreadable.unreadable();
        assert!(!unreadable.end(3) && !unreadable.is_complete());
    }

    #[test]
    fn a_series_that_comes_twice_is_one_plan() {
        let frame = frame();
        let mut plan = plan();
        for (number, index, east_m) in [(1, 0, 0.0), (2, 0, 100.0), (2, 1, 200.0), (3, 0, 300.0)] {
            let message = PlanElement {
                created: TimeOfDay::MIDNIGHT + std::time::Duration::from_millis(1),
                number: Some(number),
                identifier: None,
                index,
                element: PlanElementKind::Waypoint,
                position: frame.to_position(EastNorth::new(east_m, 0.0)),
            };
            plan.collect(&frame, &message);
        }
        assert!(plan.end(3));
        let points: Vec<usize> = plan.planned().map(|element| element.points.len()).collect();
        assert_eq!(points, [1, 2, 1]);
        assert!(!plan.has(BehaviorId::new(7)), "the newer series counts");
    }

    #[test]
    fn the_front_seats_next_element_comes_next_or_any_if_the_current_one_is_unknown() {
        let mut plan = plan();
        assert!(plan.end(3));
        assert_eq!(plan.next_points().len(), 3);
        assert!(plan.began(2));
        let next = plan.next_points();
        assert_eq!(next.len(), 1);
        assert!((next[0].east_m - 300.0).abs() < 1e-3);
        assert_eq!(plan.current().flat_map(Element::legs).count(), 1);
        assert!(!plan.began(9), "a behavior that the plan does not have");
    }
}
