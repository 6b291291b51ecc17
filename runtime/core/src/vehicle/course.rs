//! The way that the vehicle follows: from where a behavior began to where its path begins.
//!
//! A vehicle that was led off its way, or that takes up again what was interrupted, does not head for the nearest end
//! of its line. It steers to the line itself (line-of-sight steering, Fossen, *Handbook of Marine Craft Hydrodynamics
//! and Motion Control*, 2011, section 10.3). To know where that may lead, core remembers the places where the behaviors
//! began that the vehicle may continue. If a begin was not heard, its place is not known. Then, before anything of ours
//! steers, core must hear what is flown, or see it from the lines that the vehicle follows. A BFMBS alone is not enough
//! if the vehicle may have flown that behavior before: it may take up the way that it followed then. Everything that is
//! judged by these places belongs to safety requirement 002.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use backseat_spi::BehaviorId;
use backseat_units::math::hypot;
use backseat_units::{EastNorth, Timestamp};

/// How many begins of one behavior are remembered. A later begin then takes the place of the last one.
const BEGINS_MAX: usize = 4;
/// A vehicle that neither climbs nor dives faster than this, metres a second, for `LEVEL_FOR` has settled.
const LEVEL_MPS: f64 = 0.15;
const LEVEL_FOR: Duration = Duration::from_secs(5);
/// The same if a previous run may have left a modify: after this time the modify is over, and the way back from its
/// depth has begun.
const LEVEL_AFTER_ANOTHER_FOR: Duration = Duration::from_secs(15);
/// A vehicle that has been on a line for this long is not merely crossing it.
const ON_LINE_FOR: Duration = Duration::from_secs(10);
/// A vehicle on its line moves over ground in a direction that differs from the line's by at most 15 degrees: the cosine
/// of that. One that crosses the line at a smaller angle is taken for one that follows it; its way then differs little
/// from the line.
const ALONG: f64 = 0.966;

/// The tangent of 15 degrees.
pub(crate) const WIDENS: f64 = 0.268;

/// Whose path is flown: that of an element of the plan by its number, or that of an insert.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) enum Flown {
    Planned(u32),
    Inserted(BehaviorId),
}

/// Where a behavior began, as precisely as navigation knows it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) struct Begin {
    pub(crate) at: EastNorth,
    pub(crate) within_m: f64,
}

/// One of the planned behaviors that the vehicle may fly, if it was seen and not heard.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sighting {
    pub(crate) number: u32,
    /// The vehicle is on the first line of it, so the way to that line is behind the vehicle.
    pub(crate) on_first_line: bool,
    /// The vehicle may be on the way to it: from where.
    pub(crate) comes_from: Option<Begin>,
}

/// The behaviors whose begin core may have missed since the newest planned behavior that it can place. The vehicle may
/// have left them for an insert that interrupts, and may take them up again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
enum Missed {
    #[default]
    Nothing,
    /// Any behavior.
    Any,
    /// This behavior of the plan. Everything that has begun after it was heard.
    Only(u32),
}

/// The places where the behaviors began that the vehicle may continue.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Courses {
    begun: BTreeMap<Flown, Vec<Begin>>,
    current: Option<Flown>,
    /// When the current behavior was heard to begin, until a solution of navigation is later than that.
    begun_at: Option<Timestamp>,
    /// No navigation had come when it was heard to begin.
    unplaced: bool,
    /// Since when the vehicle has moved along the line of what is flown now.
    on_line_since: Option<Timestamp>,
    /// If nobody heard what is flown: the planned behaviors along whose lines the vehicle moves, and since when.
    along: Vec<(u32, Timestamp)>,
    /// The planned behaviors of which a line was ahead of the vehicle in that time.
    ahead: BTreeSet<u32>,
    /// If nobody heard what is flown: the planned behaviors of which one was seen to be flown.
    placed: Vec<u32>,
    /// The vehicle may have left a behavior of its plan that is not done, for an insert that interrupts, and no planned
    /// behavior has begun since. Other inserts may be flown first (SPI 7.5).
    left_plan: bool,
    /// Another payload inserts into this mission too. Its inserts may interrupt, and they may begin and end unheard.
    shared: bool,
    /// The insert that has begun last, if core does not know its way: another payload's, or a previous run's.
    foreign: Option<BehaviorId>,
    /// The vehicle may take up such an insert again, which another insert may have interrupted (SPI 7.5).
    left_foreign: bool,
    missed: Missed,
    /// The planned behavior that was heard to begin, if it is not known where the vehicle continues it.
    resumed: Option<u32>,
    /// Until then a modify may still lead the vehicle that was sent before the link was lost, or by a previous run.
    led_until: Timestamp,
    /// Since when the vehicle has neither climbed nor dived, while nothing of ours steers.
    level_since: Option<Timestamp>,
    /// The vehicle has reached the depth of what is flown now.
    settled: bool,
    /// The least and the greatest depth at which it has settled in this mission, metres.
    depths_m: Option<[f64; 2]>,
    /// The greatest speed over ground at which it was seen to fly its own plan in this mission, m/s.
    seen_mps: f64,
}

impl Courses {
    /// What a process knows as it begins: nobody has heard for it what has begun in the vehicle's mission. If there was
    /// a previous run, that run may have left inserts in it that interrupt.
    pub(crate) fn new(after_another: bool) -> Self {
        Self {
            left_plan: after_another,
            missed: Missed::Any,
            ..Self::default()
        }
    }

    /// The vehicle may have left a behavior of its plan that is not done.
    pub(crate) const fn leave_plan(&mut self) {
        self.left_plan = true;
    }

    /// Another payload inserts into this mission too.
    pub(crate) const fn is_shared(&mut self) {
        self.shared = true;
    }

    /// Whether another payload inserts into this mission too.
    pub(crate) const fn shared(&self) -> bool {
        self.shared
    }

    /// An insert begins: `known` if core knows its way, and `interrupts` if it may interrupt what was flown.
    pub(crate) fn inserts(&mut self, insert: BehaviorId, known: bool, interrupts: bool) {
        let other = self.foreign.is_some_and(|foreign| foreign != insert);
        self.left_foreign |= other && (!known || interrupts);
        self.foreign = (!known).then_some(insert);
    }

    /// The vehicle may fly, or take up again, an insert whose way core does not know.
    pub(crate) const fn leave_foreign(&mut self) {
        self.left_foreign = true;
    }

    /// Whether the vehicle may take up an insert again whose way core does not know.
    pub(crate) const fn has_left_foreign(&self) -> bool {
        self.left_foreign
    }

    /// Whether the vehicle may have flown this behavior before, with a begin that nobody heard: it may then continue
    /// from there, and the place where it begins now says nothing about its way.
    pub(crate) fn may_have_begun_unheard(&self, flown: Flown) -> bool {
        match self.missed {
            Missed::Nothing => false,
            Missed::Any => self.left_plan,
            Missed::Only(number) => flown == Flown::Planned(number),
        }
    }

    /// A behavior has begun that the vehicle may have flown before, with a begin that nobody heard.
    pub(crate) fn resumed(&mut self, flown: Flown) {
        self.unknown();
        if let Flown::Planned(number) = flown {
            self.begun.clear();
            self.plan_goes_on();
            self.missed = Missed::Only(number);
            self.resumed = Some(number);
        }
    }

    /// The planned behavior that was heard to begin, if it is not known where the vehicle continues it. The vehicle
    /// flies this and nothing else.
    pub(crate) const fn resumes(&self) -> Option<u32> {
        self.resumed
    }

    /// Until then a modify may lead the vehicle that this process can no longer end.
    pub(crate) fn may_be_led_until(&mut self, then: Timestamp) {
        self.led_until = self.led_until.max(then);
    }

    /// Whether a modify may lead the vehicle that this process can no longer end.
    pub(crate) fn may_be_led(&self, now: Timestamp) -> bool {
        now < self.led_until
    }

    /// A behavior has begun, at this place if it is known.
    pub(crate) fn began(&mut self, now: Timestamp, flown: Flown, here: Option<Begin>) {
        if matches!(flown, Flown::Planned(_)) {
            self.begun.retain(|other, _| *other == flown);
            self.plan_goes_on();
            self.missed = Missed::Nothing;
        }
        let begins = self.begun.entry(flown).or_default();
        begins.truncate(BEGINS_MAX - 1);
        begins.extend(here);
        self.current = Some(flown);
        self.resumed = None;
        self.unplace();
        self.begun_at = Some(now);
        self.unplaced = here.is_none();
        self.on_line_since = None;
        (self.settled, self.level_since) = (false, None);
    }

    /// A behavior of the plan is flown: no insert is left to be taken up again.
    const fn plan_goes_on(&mut self) {
        self.left_plan = false;
        self.left_foreign = false;
        self.foreign = None;
    }

    /// Navigation has come: `here`, and `before` if it has jumped from there. What began around the jump began at
    /// either place. What began before any navigation began here.
    pub(crate) fn navigated(&mut self, before: Option<Begin>, here: Begin, solution: Option<Timestamp>) {
        let places = match self.current {
            Some(current) if self.begun_at.is_some() => self.begun.entry(current).or_default(),
            Some(_) | None => return,
        };
        if before.is_some() || self.unplaced {
            places.extend(before);
            places.push(here);
            self.unplaced = false;
        }
        self.begun_at = self
            .begun_at
            .filter(|begun| solution.is_none_or(|solution| solution <= *begun));
    }

    /// Something of ours leads the vehicle elsewhere. The lines along which it has moved until now, and its depth, show
    /// nothing about its own way.
    pub(crate) fn led_away(&mut self) {
        self.level_since = None;
        self.on_line_since = None;
        self.forget_along();
    }

    /// Takes the vehicle's speed over ground, m/s. It counts while the vehicle flies its plan.
    pub(crate) fn flies_at(&mut self, ground_mps: f64) {
        if self.flies_plan() {
            self.seen_mps = self.seen_mps.max(ground_mps);
        }
    }

    /// Whether the way to the line of what is flown is behind the vehicle, or was never known.
    pub(crate) fn is_placed_on(&self, current: Flown) -> bool {
        self.begun.get(&current).is_none_or(Vec::is_empty)
    }

    /// Says whether the vehicle moves along the line of what is flown. After a while on it, the way to it is behind the
    /// vehicle.
    pub(crate) fn is_on_line(&mut self, now: Timestamp, current: Flown, on_line: bool) {
        let since = self.on_line_since.filter(|_| on_line);
        self.on_line_since = on_line.then(|| since.unwrap_or(now));
        if since.is_some_and(|since| now.since(since) >= ON_LINE_FOR) {
            self.begun.insert(current, Vec::new());
        }
    }

    /// The vehicle will not continue an insert.
    pub(crate) fn ended(&mut self, insert: BehaviorId) {
        self.begun.remove(&Flown::Inserted(insert));
    }

    /// A message or the link was lost: it may have been a begin or an end.
    pub(crate) fn invalidate_after_loss(&mut self) {
        // What the vehicle takes up again may have been interrupted before: it is still not known where it began.
        self.left_plan |= matches!(self.missed, Missed::Only(_));
        self.missed = Missed::Any;
        self.unknown();
    }

    /// What is flown is not known: a behavior has ended and nothing has begun, or a begin may have been missed.
    pub(crate) fn unknown(&mut self) {
        self.current = None;
        self.resumed = None;
        self.unplace();
        self.begun_at = None;
        self.on_line_since = None;
        (self.settled, self.level_since) = (false, None);
    }

    /// Whatever was seen of what is flown no longer counts.
    pub(crate) fn unplace(&mut self) {
        self.forget_along();
        self.placed.clear();
    }

    fn forget_along(&mut self) {
        self.along.clear();
        self.ahead.clear();
    }

    /// Nobody has heard what is flown, and nothing of ours steers: the vehicle moves along lines of these planned
    /// behaviors, and lines of those are `ahead` of it. Returns true once it has moved along for long enough to show that
    /// it flies its plan.
    pub(crate) fn keeps_to(&mut self, now: Timestamp, along: &[u32], ahead: impl IntoIterator<Item = u32>) -> bool {
        let since = |number: &u32| {
            let before = self.along.iter().find(|(along, _)| along == number);
            (*number, before.map_or(now, |(_, since)| *since))
        };
        self.along = along.iter().map(since).collect();
        if self.along.is_empty() {
            self.ahead.clear();
        } else {
            self.ahead.extend(ahead);
        }
        self.along.iter().any(|(_, since)| now.since(*since) >= ON_LINE_FOR)
    }

    /// The vehicle was seen to fly one of these planned behaviors and nothing else.
    pub(crate) fn seen_on(&mut self, seen: &[Sighting]) {
        let mut begun = BTreeMap::new();
        for sighting in seen {
            let flown = Flown::Planned(sighting.number);
            let known = self.begun.remove(&flown).filter(|_| !sighting.on_first_line);
            let begins: &mut Vec<Begin> = begun.entry(flown).or_insert_with(|| known.unwrap_or_default());
            begins.extend(sighting.comes_from);
        }
        self.placed = seen.iter().map(|sighting| sighting.number).collect();
        self.begun = begun;
        self.plan_goes_on();
        self.missed = Missed::Nothing;
    }

    /// The planned behaviors of which a line was ahead while the vehicle moved along others, or that it may have been
    /// about to come back to before.
    pub(crate) fn may_come_to(&self) -> impl Iterator<Item = u32> + '_ {
        self.ahead.iter().copied().chain(self.begun_numbers())
    }

    fn begun_numbers(&self) -> impl Iterator<Item = u32> + '_ {
        self.begun.keys().filter_map(|flown| match flown {
            Flown::Planned(number) => Some(*number),
            Flown::Inserted(_) => None,
        })
    }

    /// Where the planned behaviors may have begun, with their numbers.
    pub(crate) fn begun_of_plan(&self) -> impl Iterator<Item = (u32, Begin)> + '_ {
        self.begun.iter().flat_map(|(flown, begins)| {
            let number = match flown {
                Flown::Planned(number) => Some(*number),
                Flown::Inserted(_) => None,
            };
            begins.iter().filter_map(move |begin| Some((number?, *begin)))
        })
    }

    /// Whether the vehicle surely flies its plan: core has heard it begin, or has seen the vehicle on its lines alone.
    pub(crate) fn flies_plan(&self) -> bool {
        match self.current {
            Some(current) => matches!(current, Flown::Planned(_)),
            None => !self.placed.is_empty(),
        }
    }

    /// Takes the vehicle's depth and how fast it dives, while nothing of ours steers. The depth counts as one of the plan
    /// if it flies that (`of_plan`). With `after_another`, a previous run may have left a modify, which must be over.
    pub(crate) fn levels(&mut self, now: Timestamp, [depth_m, down_mps]: [f64; 2], of_plan: bool, after_another: bool) {
        let level_for = if after_another {
            LEVEL_AFTER_ANOTHER_FOR
        } else {
            LEVEL_FOR
        };
        // NaN is not level.
        let level = down_mps.abs() <= LEVEL_MPS;
        self.level_since = level.then(|| self.level_since.unwrap_or(now));
        if self.level_since.is_some_and(|since| now.since(since) >= level_for) {
            // The depth at which an insert is flown is not the plan's depth.
            if !of_plan {
                self.settled = self.depths_m.is_some();
                return;
            }
            self.settled = true;
            let [from_m, to_m] = self.depths_m.unwrap_or([depth_m, depth_m]);
            self.depths_m = Some([from_m.min(depth_m), to_m.max(depth_m)]);
        }
    }

    /// The mission is over.
    pub(crate) fn forget(&mut self) {
        self.begun.clear();
        self.depths_m = None;
        self.seen_mps = 0.0;
        self.plan_goes_on();
        self.missed = Missed::Nothing;
        self.unknown();
    }

    /// Where what is flown now may have begun; every remembered place if that is not known.
    pub(crate) fn of_current(&self) -> Vec<Begin> {
        match self.current {
            Some(current) => self.of(current),
            None => self.begun.values().flatten().copied().collect(),
        }
    }

    /// The greatest speed over ground at which it was seen to fly its own plan in this mission, m/s.
    pub(crate) const fn seen_mps(&self) -> f64 {
        self.seen_mps
    }

    /// What is flown now, if it was heard to begin.
    pub(crate) const fn current(&self) -> Option<Flown> {
        self.current
    }

    /// The planned behaviors of which one was seen to be flown, if nobody heard it begin.
    pub(crate) fn placed(&self) -> &[u32] {
        &self.placed
    }

    /// Whether the vehicle may have left a behavior of its plan that is not done.
    pub(crate) const fn has_left_plan(&self) -> bool {
        self.left_plan
    }

    /// The least and the greatest depth at which the vehicle has settled in this mission, metres, once it has reached
    /// the depth of what it flies.
    pub(crate) fn settled_depths_m(&self) -> Option<[f64; 2]> {
        self.depths_m.filter(|_| self.settled)
    }

    /// Where the planned behaviors may have begun.
    pub(crate) fn of_plan(&self) -> Vec<Begin> {
        let planned = self
            .begun
            .iter()
            .filter(|(flown, _)| matches!(flown, Flown::Planned(_)));
        planned.flat_map(|(_, begun)| begun.iter().copied()).collect()
    }

    /// Whether it is unknown where the planned behavior began that the vehicle may take up again. If any begin may have
    /// been missed, it may be another behavior than the one that was heard last.
    pub(crate) fn lacks_plan(&self) -> bool {
        self.missed == Missed::Any || !self.begun.keys().any(|flown| matches!(flown, Flown::Planned(_)))
    }

    /// Where a behavior may have begun.
    pub(crate) fn of(&self, flown: Flown) -> Vec<Begin> {
        self.begun.get(&flown).cloned().unwrap_or_default()
    }
}

/// Whether the vehicle is on a line and moves along it.
pub(crate) fn is_on((start, end): (EastNorth, EastNorth), here: EastNorth, velocity: EastNorth, within_m: f64) -> bool {
    let length_m = start.distance_m(end);
    let along = (end - start) * (1.0 / length_m);
    let from = here - start;
    let dot = |a: EastNorth, b: EastNorth| a.east_m * b.east_m + a.north_m * b.north_m;
    let (along_m, right_m) = (
        dot(from, along),
        from.east_m * along.north_m - from.north_m * along.east_m,
    );
    let speed_mps = hypot(velocity.east_m, velocity.north_m);
    // NaN fails these comparisons, and so does a vehicle that stands still.
    (0.0..=length_m).contains(&along_m)
        && right_m.abs() <= within_m
        && speed_mps > 0.0
        && dot(velocity, along) >= ALONG * speed_mps
}

/// Whether the vehicle moves towards a line, or a place: whether it lies, somewhere, in the region that begins `within_m`
/// behind the vehicle, is as wide to each side there, and widens ahead by 15 degrees.
pub(crate) fn leads_to(
    here: EastNorth,
    velocity: EastNorth,
    (start, end): (EastNorth, EastNorth),
    within_m: f64,
) -> bool {
    let speed_mps = hypot(velocity.east_m, velocity.north_m);
    let along = velocity * (1.0 / speed_mps);
    // How far a place is inside each of the three edges of the region, metres.
    let inside = |place: EastNorth| {
        let to = place - here;
        let ahead_m = to.east_m * along.east_m + to.north_m * along.north_m + within_m;
        let right_m = to.east_m * along.north_m - to.north_m * along.east_m;
        let half_m = within_m + WIDENS * ahead_m;
        [ahead_m, half_m - right_m, half_m + right_m]
    };
    let (mut from, mut to) = (0.0, 1.0);
    for (start_m, end_m) in inside(start).into_iter().zip(inside(end)) {
        match (start_m >= 0.0, end_m >= 0.0) {
            (true, true) => {}
            (true, false) => to = f64::min(to, start_m / (start_m - end_m)),
            (false, true) => from = f64::max(from, start_m / (start_m - end_m)),
            (false, false) => return false,
        }
    }
    from <= to
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(east_m: f64, north_m: f64) -> EastNorth {
        EastNorth::new(east_m, north_m)
    }

    fn begin(east_m: f64) -> Begin {
        Begin {
            at: at(east_m, 0.0),
            within_m: 3.0,
        }
    }

    #[test]
    fn sr_002_time_on_a_line_counts_only_while_no_modify_steers() {
        let now = Timestamp::default();
        let after = |seconds| now + Duration::from_secs(seconds);
        let mut courses = Courses::default();
        courses.began(now, Flown::Planned(1), Some(begin(2.0)));
        courses.is_on_line(after(1), Flown::Planned(1), true);
        courses.led_away();
        courses.is_on_line(after(12), Flown::Planned(1), true);
        assert!(
            !courses.is_placed_on(Flown::Planned(1)),
            "the way to the line still counts"
        );
        courses.is_on_line(after(21), Flown::Planned(1), true);
        assert!(!courses.is_placed_on(Flown::Planned(1)));
        courses.is_on_line(after(22), Flown::Planned(1), true);
        assert!(courses.is_placed_on(Flown::Planned(1)));

        let mut unheard = Courses::default();
        assert!(!unheard.keeps_to(after(1), &[1], [3]));
        unheard.led_away();
        assert!(!unheard.keeps_to(after(12), &[1], [2]));
        assert!(unheard.keeps_to(after(22), &[1], []));
        assert_eq!(unheard.may_come_to().collect::<Vec<_>>(), [2]);
    }

    #[test]
    fn the_places_of_begins_are_kept_until_an_insert_ends_or_a_planned_behavior_begins() {
        let insert = BehaviorId::new(7);
        let mut courses = Courses::default();
        let now = Timestamp::default();
        courses.began(now, Flown::Planned(1), Some(begin(2.0)));
        assert_eq!(courses.of_current(), [begin(2.0)]);
        courses.began(now, Flown::Inserted(insert), Some(begin(3.0)));
        assert_eq!(courses.of_current(), [begin(3.0)]);
        assert_eq!(courses.of(Flown::Planned(1)), [begin(2.0)]);
        // Interrupted and taken up again: the vehicle may continue from either place.
        courses.began(now, Flown::Inserted(insert), Some(begin(4.0)));
        assert_eq!(courses.of_current(), [begin(3.0), begin(4.0)]);
        courses.ended(insert);
        courses.began(now, Flown::Planned(2), Some(begin(5.0)));
        assert_eq!(courses.of(Flown::Planned(1)), []);
        courses.invalidate_after_loss();
        assert_eq!(courses.of_current(), [begin(5.0)]);
    }

    #[test]
    fn what_was_not_heard_is_seen_after_ten_seconds_on_one_path() {
        let at = |seconds: u64| Timestamp::from_millis(1000 * seconds);
        let mut courses = Courses::default();
        // Ten seconds on the two paths, but on neither of them for that long.
        assert!(!courses.keeps_to(at(0), &[2], []));
        assert!(!courses.keeps_to(at(5), &[2, 3], []));
        assert!(!courses.keeps_to(at(8), &[3], []));
        assert!(!courses.keeps_to(at(14), &[2, 3], []));
        assert!(courses.keeps_to(at(15), &[2, 3], []));
        courses.invalidate_after_loss();
        assert!(!courses.keeps_to(at(16), &[3], []));
        assert!(!courses.keeps_to(at(20), &[], []));
        assert!(!courses.keeps_to(at(26), &[3], []));
        courses.began(at(30), Flown::Planned(3), None);
        assert!(!courses.keeps_to(at(36), &[3], []));
    }

    #[test]
    fn sr_002_who_is_seen_on_a_later_line_may_still_be_on_the_way_to_the_first() {
        let seen = |on_first_line, comes_from| {
            let mut courses = Courses::default();
            courses.began(Timestamp::default(), Flown::Planned(2), Some(begin(2.0)));
            courses.leave_plan();
            courses.invalidate_after_loss();
            assert!(courses.lacks_plan() && courses.may_have_begun_unheard(Flown::Planned(2)));
            courses.seen_on(&[Sighting {
                number: 2,
                on_first_line,
                comes_from,
            }]);
            assert_eq!(courses.placed(), [2]);
            assert!(courses.flies_plan() && !courses.has_left_plan() && !courses.lacks_plan());
            assert!(!courses.may_have_begun_unheard(Flown::Planned(2)));
            courses.of_current()
        };
        assert_eq!(seen(true, None), []);
        assert_eq!(seen(false, None), [begin(2.0)]);
        assert_eq!(seen(false, Some(begin(7.0))), [begin(2.0), begin(7.0)]);
    }

    #[test]
    fn sr_002_a_vehicle_leads_to_what_lies_ahead_of_it_or_close_aside() {
        let here = at(10.0, 0.0);
        let east = at(1.5, 0.0);
        let leads_to = |velocity, line| leads_to(here, velocity, line, 5.0);
        let place = |east_m, north_m| (at(east_m, north_m), at(east_m, north_m));
        assert!(leads_to(at(1.5, 0.3), place(100.0, 0.0)));
        assert!(!leads_to(at(1.5, 0.7), place(100.0, 0.0)));
        // Ahead and slightly aside, and just passed.
        assert!(
            leads_to(east, place(12.0, 5.0)) && leads_to(east, place(6.0, 0.0)) && leads_to(east, place(10.0, 0.0))
        );
        assert!(!leads_to(east, place(12.0, 8.0)) && !leads_to(east, place(4.0, 0.0)));
        // A line that crosses the way far ahead, one beside it, and one behind.
        assert!(leads_to(east, (at(500.0, -300.0), at(500.0, 300.0))));
        assert!(!leads_to(east, (at(10.0, 50.0), at(100.0, 50.0))));
        assert!(!leads_to(east, (at(-5.0, -300.0), at(-5.0, 300.0))));
        assert!(!leads_to(at(0.0, 0.0), place(100.0, 0.0)), "it stands still");
    }

    #[test]
    fn sr_002_an_insert_of_unknown_way_that_another_one_may_have_interrupted_may_be_taken_up_again() {
        let id = BehaviorId::new;
        let after = |begins: &[(u32, bool, bool)]| {
            let mut courses = Courses::default();
            for (insert, known, interrupts) in begins {
                courses.inserts(id(*insert), *known, *interrupts);
            }
            courses
        };
        assert!(!after(&[(40, false, true)]).has_left_foreign());
        assert!(!after(&[(40, false, true), (40, false, true)]).has_left_foreign());
        assert!(after(&[(40, false, true), (41, false, true)]).has_left_foreign());
        assert!(!after(&[(40, false, true), (1, true, false)]).has_left_foreign());
        assert!(after(&[(40, false, true), (1, true, true)]).has_left_foreign());
        assert!(!after(&[(1, true, true), (2, true, true)]).has_left_foreign());
        let mut courses = after(&[(40, false, true), (41, false, true)]);
        courses.began(Timestamp::default(), Flown::Inserted(id(41)), None);
        assert!(courses.has_left_foreign());
        courses.began(Timestamp::default(), Flown::Planned(1), None);
        assert!(!courses.has_left_foreign());
    }

    #[test]
    fn a_vehicle_that_crosses_a_line_is_not_on_it() {
        let line = (at(0.0, 0.0), at(100.0, 0.0));
        assert!(is_on(line, at(50.0, 4.0), at(1.5, -0.3), 5.0));
        assert!(!is_on(line, at(50.0, 4.0), at(1.5, -0.5), 5.0));
        assert!(!is_on(line, at(50.0, 4.0), at(0.3, -1.5), 5.0));
        assert!(!is_on(line, at(50.0, 4.0), at(-1.5, 0.0), 5.0));
        assert!(!is_on(line, at(50.0, 6.0), at(1.5, 0.0), 5.0));
        assert!(!is_on(line, at(50.0, 4.0), at(0.0, 0.0), 5.0));
        assert!(!is_on(line, at(-1.0, 0.0), at(1.5, 0.0), 5.0));
        assert!(!is_on((at(0.0, 0.0), at(0.0, 0.0)), at(0.0, 0.0), at(1.5, 0.0), 5.0));
    }
}
