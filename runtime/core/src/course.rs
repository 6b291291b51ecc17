//! The way that the vehicle keeps to: from where a behaviour began to where its path begins.
//!
//! A vehicle that has been led off its way, or takes up again what was interrupted, does not head for the nearest of its
//! ends: it steers to the line itself (line-of-sight steering, Fossen, *Handbook of Marine Craft Hydrodynamics and Motion
//! Control*, 2011, section 10.3). To know where that may lead to, the places are kept where the behaviours began that it
//! may fly on. Of one whose begin was not heard nobody knows it: what is flown has to be heard, or to be seen from the lines
//! that the vehicle keeps to, before anything of ours steers. All that is judged by it belongs to safety requirement 002.

use std::collections::BTreeMap;
use std::time::Duration;

use backseat_spi::BehaviorId;
use backseat_units::math::hypot;
use backseat_units::{EastNorth, Timestamp};

use crate::context::Context;
use crate::envelope::{Approach, Insert, Track};
use crate::ledger::Entry;
use crate::navigation::Jump;
use crate::plugin::{Refusal, RequestState};
use crate::refusal::refused;

/// How often one behaviour can begin until a later begin takes the place of the last.
const BEGINS_MAX: usize = 4;
/// A vehicle that neither climbs nor dives by more, metres a second, for so long has settled.
const LEVEL_MPS: f64 = 0.15;
const LEVEL_FOR: Duration = Duration::from_secs(5);
/// The same where a process before this one may have left a modify, that this is over and the way back from its depth
/// has begun.
const LEVEL_AFTER_ANOTHER_FOR: Duration = Duration::from_secs(15);
/// From above the surface to the deepest sea.
const ALL_DEPTHS_M: [f64; 2] = [-100.0, 12_000.0];
/// So long on its line it is not merely passing where the line is.
const ON_LINE_FOR: Duration = Duration::from_secs(10);
/// Places that are nearer to each other count as one, metres.
const SAME_M: f64 = 1.0;
/// On its line a vehicle goes along it to less than this: the cosine of 30 degrees.
const ALONG: f64 = 0.866;

/// Whose path is flown: an element of the plan by its number, or an insert.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Flown {
    Planned(u32),
    Inserted(BehaviorId),
}

/// Where a behaviour began, as well as navigation knows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Begin {
    pub(crate) at: EastNorth,
    within_m: f64,
}

/// Where the behaviours began that the vehicle may fly on.
#[derive(Debug, Default)]
pub(crate) struct Courses {
    begun: BTreeMap<Flown, Vec<Begin>>,
    current: Option<Flown>,
    /// When it was heard that this began, until navigation tells of a time after that.
    begun_at: Option<Timestamp>,
    /// No navigation had been heard by then.
    unplaced: bool,
    /// Since when it goes along the line of what is flown now.
    on_line_since: Option<Timestamp>,
    /// Where nobody heard what is flown, whose lines it goes along, and since when.
    along: Vec<(Flown, Timestamp)>,
    /// Where nobody heard what is flown, what it was seen to fly.
    placed: Vec<Flown>,
    /// It may have left a behaviour of its plan that is not done: for an insert that interrupts, and no planned behaviour
    /// has begun since. Other inserts may be flown first (SPI 7.5).
    left_plan: bool,
    /// Since when it neither climbs nor dives, while nobody of ours steers.
    level_since: Option<Timestamp>,
    /// It has come to the depth of what is flown now.
    settled: bool,
    /// The depths that it has settled at in this mission, from and to, metres.
    depths_m: Option<[f64; 2]>,
    /// The fastest over ground that it was seen to fly its own plan in this mission, m/s.
    seen_mps: f64,
}

impl Courses {
    /// The vehicle may have been led away from its plan.
    pub(crate) const fn leave_plan(&mut self) {
        self.left_plan = true;
    }

    /// A behaviour has begun, at a place where that is known.
    fn began(&mut self, now: Timestamp, flown: Flown, here: Option<Begin>) {
        if matches!(flown, Flown::Planned(_)) {
            self.begun.retain(|other, _| *other == flown);
            self.left_plan = false;
        }
        let begins = self.begun.entry(flown).or_default();
        begins.truncate(BEGINS_MAX - 1);
        begins.extend(here);
        self.current = Some(flown);
        self.unplace();
        self.begun_at = Some(now);
        self.unplaced = here.is_none();
        self.on_line_since = None;
        (self.settled, self.level_since) = (false, None);
    }

    /// An insert will not be flown on.
    fn ended(&mut self, insert: BehaviorId) {
        self.begun.remove(&Flown::Inserted(insert));
    }

    /// What is flown is not known: the link is gone, or it has ended and nothing has begun.
    pub(crate) fn lose(&mut self) {
        self.current = None;
        self.unplace();
        self.begun_at = None;
        self.on_line_since = None;
        (self.settled, self.level_since) = (false, None);
    }

    fn unplace(&mut self) {
        self.along.clear();
        self.placed.clear();
    }

    /// Nobody heard what is flown, nor steers: it goes along these paths. True where it was seen by now what it flies.
    fn keeps_to(&mut self, now: Timestamp, paths: &[Flown]) -> bool {
        let since = |path: &Flown| {
            let before = self.along.iter().find(|(along, _)| along == path);
            (*path, before.map_or(now, |(_, since)| *since))
        };
        self.along = paths.iter().map(since).collect();
        let long = |(_, since): &(Flown, Timestamp)| now.since(*since) >= ON_LINE_FOR;
        let seen = self.along.iter().any(long);
        if seen {
            self.placed = paths.to_vec();
            // It is on their lines: what led there is behind it.
            for path in paths {
                self.begun.insert(*path, Vec::new());
                self.left_plan &= !matches!(path, Flown::Planned(_));
            }
        }
        seen
    }

    /// Where it is and how fast it dives, while nobody of ours steers.
    fn levels(&mut self, now: Timestamp, [depth_m, down_mps]: [f64; 2], level_for: Duration) {
        // A figure that is none is not level.
        let level = down_mps.abs() <= LEVEL_MPS;
        self.level_since = level.then(|| self.level_since.unwrap_or(now));
        if self.level_since.is_some_and(|since| now.since(since) >= level_for) {
            // What an insert is flown at is not the plan's depth.
            if matches!(self.current, Some(Flown::Inserted(_))) {
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
        self.left_plan = false;
        self.lose();
    }

    /// Where what is flown now may have begun.
    pub(crate) fn of_current(&self) -> Vec<Begin> {
        match self.current {
            Some(current) => self.of(current),
            None => self.begun.values().flatten().copied().collect(),
        }
    }

    /// The fastest that it was seen to fly its own plan in this mission, m/s over ground.
    pub(crate) const fn seen_mps(&self) -> f64 {
        self.seen_mps
    }

    /// What is flown now, where that was heard.
    pub(crate) const fn current(&self) -> Option<Flown> {
        self.current
    }

    /// What was seen to be flown, where nobody heard it.
    pub(crate) fn placed(&self) -> &[Flown] {
        &self.placed
    }

    /// Where the plan is taken up again it is not known where its behaviour began.
    fn lacks_plan(&self) -> bool {
        !self.begun.keys().any(|flown| matches!(flown, Flown::Planned(_)))
    }

    /// Where a behaviour may have begun.
    fn of(&self, flown: Flown) -> Vec<Begin> {
        self.begun.get(&flown).cloned().unwrap_or_default()
    }
}

impl Context {
    /// A behaviour has begun here.
    pub(crate) fn course_began(&mut self, number: Option<u32>, identifier: Option<BehaviorId>) {
        let planned = number.map(Flown::Planned);
        let Some(flown) = identifier.map(Flown::Inserted).or(planned) else {
            return;
        };
        self.vehicle.courses.began(self.now, flown, self.begins_here());
        let insert = |identifier| self.ledger.get(self.ledger.by_identifier(identifier)?)?.insert;
        // One that is not known here may have interrupted too.
        if identifier.is_some_and(|identifier| insert(identifier).is_none_or(|insert| insert.interrupt)) {
            self.vehicle.courses.leave_plan();
        }
    }

    /// Where the vehicle is, and how far it may have gone since it was there.
    pub(crate) fn begins_here(&self) -> Option<Begin> {
        let navigation = self.vehicle.navigation.newest()?;
        let limits = self.monitor.limits();
        let age_s = self.now.since(navigation.solution).as_secs_f64() + limits.link_delay_max_s;
        Some(Begin {
            at: navigation.local,
            within_m: limits.speed_max_mps * age_s,
        })
    }

    /// Navigation has come, and has jumped perhaps. Where it did so around a begin, the vehicle knew itself at the one place
    /// or at the other.
    pub(crate) fn course_navigated(&mut self, jump: Option<Jump>) {
        let Some(mut here) = self.begins_here() else { return };
        let solution = self.vehicle.navigation.newest().map(|newest| newest.solution);
        let before = jump.map(|jump| Begin {
            at: jump.from,
            within_m: self.monitor.limits().speed_max_mps * jump.elapsed_s,
        });
        here.within_m += before.map_or(0.0, |before| before.within_m);
        let courses = &mut self.vehicle.courses;
        let places = match courses.current {
            Some(current) if courses.begun_at.is_some() => courses.begun.entry(current).or_default(),
            _ => return,
        };
        if before.is_some() || courses.unplaced {
            places.extend(before);
            places.push(here);
            courses.unplaced = false;
        }
        courses.begun_at = courses
            .begun_at
            .filter(|begun| solution.is_none_or(|solution| solution <= *begun));
    }

    /// Whether it is known what the vehicle flies and goes on to, so that a modify's ways back can be judged: a behaviour of
    /// its plan or an insert of this process, which was heard to begin or was seen by its lines.
    pub(crate) fn knows_what_is_flown(&self) -> Result<(), Refusal> {
        let known = match self.vehicle.courses.current {
            // Who needs no plan is judged without it, but for what a process before this one has led the vehicle away from.
            None => {
                self.is_placed() || (!self.monitor.limits().modify_needs_plan && self.vehicle.former.is_none())
            }
            Some(Flown::Planned(number)) => self.vehicle.plan.names(number) || !self.vehicle.plan.is_complete(),
            Some(Flown::Inserted(identifier)) => self.ledger.by_identifier(identifier).is_some(),
        };
        if !known {
            let text = if self.vehicle.courses.current.is_none() {
                "it was not heard what the vehicle flies, nor has it kept to a line of its plan for 10 s"
            } else {
                "what the vehicle flies is not in its plan, nor so the way back to it"
            };
            return Err(refused("plan", text));
        }
        self.knows_what_is_taken_up(false)
    }

    /// Whether it was seen what the vehicle flies, where nobody heard it.
    pub(crate) fn is_placed(&self) -> bool {
        let placed = self.vehicle.courses.placed();
        let known = |flown: &Flown| match flown {
            Flown::Planned(number) => self.vehicle.plan.names(*number),
            Flown::Inserted(identifier) => self.ledger.by_identifier(*identifier).is_some(),
        };
        !placed.is_empty() && placed.iter().all(known)
    }

    /// Whether it was heard what the vehicle flies, so that an insert's way to it can be judged.
    pub(crate) fn heard_what_is_flown(&self, interrupts: bool) -> Result<(), Refusal> {
        if self.vehicle.courses.current.is_none() {
            let text = "it was not heard what the vehicle flies, nor so where the insert would begin";
            return Err(refused("plan", text));
        }
        self.knows_what_is_taken_up(interrupts)
    }

    /// Whether it is known where the planned behaviour began that the vehicle may take up again.
    pub(crate) fn knows_what_is_taken_up(&self, interrupts: bool) -> Result<(), Refusal> {
        if self.takes_up_plan(interrupts) && self.vehicle.courses.lacks_plan() {
            let text =
                "it was not heard what the vehicle takes up again after what it flies, nor so the way back to it";
            return Err(refused("plan", text));
        }
        Ok(())
    }

    /// A behaviour has ended, for good or for one that interrupts it. Until another begins what is flown is not known.
    pub(crate) fn course_ended(&mut self, number: Option<u32>, identifier: Option<BehaviorId>) {
        let ended = identifier.map(Flown::Inserted).or(number.map(Flown::Planned));
        // Where it was seen what is flown, whatever ends makes that another.
        if ended.is_some() && (self.vehicle.courses.current.is_none() || ended == self.vehicle.courses.current) {
            self.vehicle.courses.lose();
        }
        let Some(identifier) = identifier else { return };
        let entry = self.ledger.by_identifier(identifier);
        if !entry.is_some_and(|request| self.ledger.get(request).is_some_and(|entry| entry.interrupted)) {
            self.vehicle.courses.ended(identifier);
        }
    }

    /// The lines of the plan and of our open tracklines, and whose they are; none where the vehicle may fly anything else.
    pub(crate) fn lines_that_may_be_flown(&self) -> Vec<(Flown, (EastNorth, EastNorth))> {
        let mut others = self
            .vehicle
            .plan
            .others(|identifier| self.identifiers.is_ours(identifier));
        if !self.vehicle.plan.is_complete() || others.next().is_some() {
            return Vec::new();
        }
        let planned = self
            .vehicle
            .plan
            .lines()
            .map(|(number, line)| (Flown::Planned(number), line));
        let ours = self.ledger.iter().filter_map(|(_, entry)| {
            let (identifier, insert) = (entry.identifier?, entry.insert?);
            Some((Flown::Inserted(identifier), self.monitor.envelope.line_led(&insert)?))
        });
        planned.chain(ours).collect()
    }

    /// The depths on the ways to what the vehicle flies before or after a request, from and to, metres. Those of our own
    /// inserts are known. What the front seat flies at no sentence says: it is taken for what the vehicle has settled at in
    /// this mission, once it has settled on what is flown now, and for all depths before.
    pub(crate) fn depths_of_ways(&self) -> Option<[f64; 2]> {
        let Some([from_m, to_m]) = self.vehicle.courses.depths_m.filter(|_| self.vehicle.courses.settled) else {
            return Some(ALL_DEPTHS_M);
        };
        // At what an insert is flown that is not ours no sentence says (6.20).
        let mut others = self
            .vehicle
            .plan
            .others(|identifier| self.identifiers.is_ours(identifier));
        if others.next().is_some() {
            return Some(ALL_DEPTHS_M);
        }
        let navigation = self.vehicle.navigation.newest()?;
        let lock = self.vehicle.navigation.bottom_lock(self.now);
        let (mut from_m, mut to_m) = (from_m.min(navigation.depth.as_m()), to_m.max(navigation.depth.as_m()));
        for (_, insert, _) in self.chain() {
            let Some([least_m, most_m]) = self.monitor.envelope.depths_m(&insert, navigation.depth, lock) else {
                return Some(ALL_DEPTHS_M);
            };
            (from_m, to_m) = (from_m.min(least_m), to_m.max(most_m));
        }
        let error_m = self.monitor.limits().vertical_error_m;
        Some([from_m - error_m, to_m + error_m])
    }

    /// The line of a behaviour that is one line, or the first of several, as it was given: the way to it may lead along any
    /// other.
    pub(crate) fn first_line_of(&self, flown: Flown) -> Option<(EastNorth, EastNorth)> {
        match flown {
            Flown::Planned(_) => self.vehicle.plan.flown().flat_map(crate::plan::Element::legs).next(),
            Flown::Inserted(identifier) => {
                let insert = self.ledger.get(self.ledger.by_identifier(identifier)?)?.insert?;
                self.monitor.envelope.line_given(&insert)
            }
        }
    }

    /// What the vehicle may be on where it flies an insert, from where that may have begun on.
    pub(crate) fn tracks_of_insert(&self, insert: &Insert, begun: &[Begin]) -> Vec<Track> {
        let approach = |begin: &Begin| self.approach(begin, self.monitor.envelope.path_begins(insert, begin.at));
        let lines = self.monitor.envelope.legs(insert).into_iter();
        let lines = lines.map(|(start, end)| Track::Line(start, end));
        begun.iter().filter_map(approach).chain(lines).collect()
    }

    /// Lines, and the ways to where each begins.
    pub(crate) fn tracks_of_lines(&self, begun: &[Begin], lines: &[(EastNorth, EastNorth)]) -> Vec<Track> {
        let mut starts: Vec<EastNorth> = Vec::new();
        for (start, _) in lines {
            if !starts.contains(start) {
                starts.push(*start);
            }
        }
        // Places that are one for every purpose: what is judged is far wider.
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

    /// The way from a begin to where the path begins; none from as near as the vehicle tracks, which is there.
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

    /// What the vehicle may take up again after an insert, lines and the ways to them: what is interrupted already,
    /// and where the insert interrupts, what is flown now (SPI 7.5; vehicles differ).
    pub(crate) fn taken_up_after(&self, interrupts: bool) -> Vec<Track> {
        let mut tracks = Vec::new();
        if self.takes_up_plan(interrupts) {
            let planned: Vec<_> = self
                .vehicle
                .plan
                .current()
                .flat_map(crate::plan::Element::legs)
                .collect();
            let begun: Vec<Begin> = self
                .vehicle
                .courses
                .begun
                .iter()
                .filter(|(flown, _)| matches!(flown, Flown::Planned(_)))
                .flat_map(|(_, begun)| begun.iter().copied())
                .collect();
            tracks.extend(self.tracks_of_lines(&begun, &planned));
        }
        let may_resume = |entry: &Entry| entry.interrupted || (interrupts && entry.state == RequestState::Started);
        for (_, entry) in self.ledger.iter().filter(|(_, entry)| may_resume(entry)) {
            let Some(insert) = entry.insert else { continue };
            let begun = entry
                .identifier
                .map(|identifier| self.vehicle.courses.of(Flown::Inserted(identifier)));
            tracks.extend(self.tracks_of_insert(&insert, &begun.unwrap_or_default()));
        }
        tracks
    }

    /// Whether the vehicle may take up its plan again after what it flies, or after an insert that interrupts that.
    pub(crate) fn takes_up_plan(&self, interrupts: bool) -> bool {
        interrupts || self.ledger.interrupts() || self.former_may_fly() || self.vehicle.courses.left_plan
    }

    /// Where the vehicle is while nobody of ours steers: on its line, from where on the way to it is behind it.
    pub(crate) fn watch_course(&mut self) {
        if self.arbiter.modifies() {
            self.vehicle.courses.level_since = None;
            return;
        }
        let Some(navigation) = self.vehicle.navigation.newest() else {
            return;
        };
        let here = navigation.local;
        if matches!(self.vehicle.courses.current, Some(Flown::Planned(_))) {
            let ground_mps = hypot(navigation.east_mps, navigation.north_mps);
            self.vehicle.courses.seen_mps = self.vehicle.courses.seen_mps.max(ground_mps);
        }
        let level_for = if self.vehicle.former.is_none() {
            LEVEL_FOR
        } else {
            LEVEL_AFTER_ANOTHER_FOR
        };
        let vertical = [navigation.depth.as_m(), navigation.down_mps];
        self.vehicle.courses.levels(self.now, vertical, level_for);
        let velocity = EastNorth::new(navigation.east_mps, navigation.north_mps);
        let within_m = self.monitor.limits().tracking_error_m;
        let line = match self.vehicle.courses.current {
            None => {
                let mut paths: Vec<Flown> = Vec::new();
                for (flown, line) in self.lines_that_may_be_flown() {
                    if is_on(line, here, velocity, within_m) && !paths.contains(&flown) {
                        paths.push(flown);
                    }
                }
                if self.vehicle.courses.placed.is_empty() && self.vehicle.courses.keeps_to(self.now, &paths) {
                    self.vehicle.plan.seen_at(self.vehicle.courses.placed());
                }
                return;
            }
            Some(current) if self.vehicle.courses.begun.get(&current).is_none_or(Vec::is_empty) => return,
            Some(current) => self.first_line_of(current),
        };
        let on_line = line.is_some_and(|line| is_on(line, here, velocity, within_m));
        let since = self.vehicle.courses.on_line_since.filter(|_| on_line);
        self.vehicle.courses.on_line_since = on_line.then(|| since.unwrap_or(self.now));
        if since.is_none_or(|since| self.now.since(since) < ON_LINE_FOR) {
            return;
        }
        if let Some(current) = self.vehicle.courses.current {
            self.vehicle.courses.begun.insert(current, Vec::new());
        }
    }
}

/// Whether the vehicle goes along a line that it is on.
fn is_on((start, end): (EastNorth, EastNorth), here: EastNorth, velocity: EastNorth, within_m: f64) -> bool {
    let length_m = start.distance_m(end);
    let along = (end - start) * (1.0 / length_m);
    let from = here - start;
    let dot = |a: EastNorth, b: EastNorth| a.east_m * b.east_m + a.north_m * b.north_m;
    let (along_m, right_m) = (
        dot(from, along),
        from.east_m * along.north_m - from.north_m * along.east_m,
    );
    let speed_mps = hypot(velocity.east_m, velocity.north_m);
    // Written so that a figure that is none is not on it, nor one that stands still.
    (0.0..=length_m).contains(&along_m)
        && right_m.abs() <= within_m
        && speed_mps > 0.0
        && dot(velocity, along) >= ALONG * speed_mps
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
    fn where_what_is_flown_began_is_known_until_its_line_or_another_behaviour() {
        let insert = BehaviorId::new(7);
        let mut courses = Courses::default();
        let now = Timestamp::default();
        courses.began(now, Flown::Planned(1), Some(begin(2.0)));
        assert_eq!(courses.of_current(), [begin(2.0)]);
        courses.began(now, Flown::Inserted(insert), Some(begin(3.0)));
        assert_eq!(courses.of_current(), [begin(3.0)]);
        assert_eq!(courses.of(Flown::Planned(1)), [begin(2.0)]);
        // Interrupted and taken up again: it may fly on from either place.
        courses.began(now, Flown::Inserted(insert), Some(begin(4.0)));
        assert_eq!(courses.of_current(), [begin(3.0), begin(4.0)]);
        courses.ended(insert);
        courses.began(now, Flown::Planned(2), Some(begin(5.0)));
        assert_eq!(courses.of(Flown::Planned(1)), []);
        courses.lose();
        assert_eq!(courses.of_current(), [begin(5.0)]);
    }

    #[test]
    fn what_was_not_heard_is_seen_once_one_path_was_kept_to_for_ten_seconds() {
        let (second, third) = (Flown::Planned(2), Flown::Planned(3));
        let at = |seconds: u64| Timestamp::from_millis(1000 * seconds);
        let mut courses = Courses::default();
        // Ten seconds on two paths, but on neither for as long.
        assert!(!courses.keeps_to(at(0), &[second]));
        assert!(!courses.keeps_to(at(5), &[second, third]));
        assert!(!courses.keeps_to(at(8), &[third]));
        assert!(!courses.keeps_to(at(14), &[second, third]));
        assert!(courses.keeps_to(at(15), &[second, third]));
        // Both count, for it may be either.
        assert_eq!(courses.placed(), [second, third]);
        courses.lose();
        assert_eq!(courses.placed(), []);
        assert!(!courses.keeps_to(at(16), &[third]));
        assert!(!courses.keeps_to(at(20), &[]));
        assert!(!courses.keeps_to(at(26), &[third]));
        courses.began(at(30), third, None);
        assert!(!courses.keeps_to(at(36), &[third]));
    }

    #[test]
    fn a_vehicle_that_crosses_a_line_is_not_on_it() {
        let line = (at(0.0, 0.0), at(100.0, 0.0));
        assert!(is_on(line, at(50.0, 4.0), at(1.5, -0.3), 5.0));
        assert!(!is_on(line, at(50.0, 4.0), at(0.3, -1.5), 5.0));
        assert!(!is_on(line, at(50.0, 4.0), at(-1.5, 0.0), 5.0));
        assert!(!is_on(line, at(50.0, 6.0), at(1.5, 0.0), 5.0));
        assert!(!is_on(line, at(50.0, 4.0), at(0.0, 0.0), 5.0));
        assert!(!is_on(line, at(-1.0, 0.0), at(1.5, 0.0), 5.0));
        assert!(!is_on((at(0.0, 0.0), at(0.0, 0.0)), at(0.0, 0.0), at(1.5, 0.0), 5.0));
    }
}
