use backseat_sdk::survey::{FieldMap, Known, Line};
use backseat_sdk::units::EastNorth;

use crate::settings::Settings;

/// At how many places the variance counts: those of most interest.
const KNOWN_MAX: usize = 80;
/// At how many places the map is looked at in a step.
const SCAN: usize = 80;
/// Plans of about so many measured points are judged in a step.
const JUDGED: usize = 40;
/// The directions of a plan's first line.
const DIRECTIONS: u32 = 16;
/// The directions of its second line.
const TURNS: u32 = 8;
/// How many places far away are looked at as ends of the first line.
const TARGETS: usize = 8;
/// How many of the first lines are continued by a second one.
const CONTINUED: usize = 6;
/// What a turn costs, metres of way.
const TURN_M: f64 = 20.0;
/// The shortest line, metres.
const LINE_MIN_M: f64 = 60.0;
/// The most points of a line that are judged.
const POINTS_MAX: u32 = 16;

/// A plan: one line or two, and what it is worth: by how much it reduces the variance, for each metre of its way.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Plan {
    worth: f64,
    first: Line,
    second: Option<Line>,
}

impl Plan {
    /// What it measures, after what is measured before it.
    fn measured(&self, settings: &Settings, ahead: &[EastNorth]) -> Vec<EastNorth> {
        let lines = std::iter::once(self.first).chain(self.second);
        let own = lines.flat_map(|line| settings.along(&line, POINTS_MAX));
        ahead.iter().copied().chain(own).collect()
    }

    /// What it costs, metres of way.
    fn way_m(&self) -> f64 {
        let each = |line: Line| line.length_m() + TURN_M;
        each(self.first) + self.second.map_or(0.0, each)
    }
}

/// How far a search has come.
#[derive(Clone, Debug)]
enum Stage {
    /// Looks at the places of the map; with the next one.
    Scan(usize),
    /// Judges plans; with those that are left.
    Judge {
        known: Known,
        /// How much each of the known places counts, and its variance when the line begins.
        counts: Vec<(f64, f64)>,
        waiting: Vec<Plan>,
        /// Whether the plans have second lines already.
        continued: bool,
    },
}

/// A search for the next line, a step's work at a time.
#[derive(Clone, Debug)]
pub struct Search {
    map: FieldMap,
    from: EastNorth,
    left_m: f64,
    /// Places that will be measured before the line begins.
    ahead: Vec<EastNorth>,
    /// Places with their interest.
    scored: Vec<(f64, EastNorth)>,
    judged: Vec<Plan>,
    stage: Stage,
}

/// What a step of a search has brought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Progress {
    /// The search goes on.
    More,
    /// The search has ended, with the next line if there is one.
    Done(Option<Line>),
}

impl Search {
    /// A search for a line from a place, where so much of the way is left, metres. `ahead` will be measured before the
    /// vehicle comes to that place.
    #[must_use]
    pub const fn new(map: FieldMap, from: EastNorth, left_m: f64, ahead: Vec<EastNorth>) -> Self {
        Self {
            map,
            from,
            left_m,
            ahead,
            scored: Vec::new(),
            judged: Vec::new(),
            stage: Stage::Scan(0),
        }
    }

    /// Does a step's work. `places` are those of the map.
    pub fn work(&mut self, settings: &Settings, places: &[EastNorth]) -> Progress {
        match &mut self.stage {
            Stage::Scan(next) => {
                let until = (*next + SCAN).min(places.len());
                for place in &places[*next..until] {
                    let known = self.map.at(*place);
                    let interest = settings.weight(&known) * known.deviation * known.deviation;
                    self.scored.push((interest, *place));
                }
                *next = until;
                if until == places.len() {
                    self.begin_to_judge(settings);
                }
                Progress::More
            }
            Stage::Judge {
                known,
                counts,
                waiting,
                continued,
            } => {
                let mut points = 0;
                while points < JUDGED
                    && let Some(mut plan) = waiting.pop()
                {
                    let measured = plan.measured(settings, &self.ahead);
                    points += measured.len();
                    plan.worth = gain(&self.map, (known, counts), &measured) / plan.way_m();
                    self.judged.push(plan);
                }
                if !waiting.is_empty() {
                    return Progress::More;
                }
                self.judged.sort_by(|one, other| other.worth.total_cmp(&one.worth));
                if *continued {
                    let best = self.judged.first().filter(|plan| plan.worth > 0.0);
                    return Progress::Done(best.map(|plan| plan.first));
                }
                *continued = true;
                let left_m = self.left_m;
                let first = self.judged.iter().take(CONTINUED);
                *waiting = first.flat_map(|plan| with_second(settings, plan, left_m)).collect();
                Progress::More
            }
        }
    }

    fn begin_to_judge(&mut self, settings: &Settings) {
        self.scored.sort_by(|one, other| other.0.total_cmp(&one.0));
        let top: Vec<EastNorth> = self.scored.iter().take(KNOWN_MAX).map(|(_, place)| *place).collect();
        let known = self.map.know(&top);
        let deviations = || known.estimates().iter().map(|known| known.deviation).collect();
        let before = self
            .map
            .deviations_after(&known, &self.ahead)
            .unwrap_or_else(deviations);
        let each = known.estimates().iter().zip(before);
        let counts = each.map(|(known, before)| (settings.weight(known), before * before));
        let counts = counts.collect();
        self.stage = Stage::Judge {
            known,
            counts,
            waiting: self.first_lines(settings),
            continued: false,
        };
    }

    /// Lines in all directions, and lines to the most interesting places and a little beyond them.
    fn first_lines(&self, settings: &Settings) -> Vec<Plan> {
        let scale_m = settings.kernel.length_m;
        let mut ends = Vec::new();
        for part in [0.5, 1.0] {
            for direction in 0..DIRECTIONS {
                let bearing_deg = 360.0 * f64::from(direction) / f64::from(DIRECTIONS);
                ends.push(self.from.offset(bearing_deg, part * settings.line_m));
            }
        }
        let mut targets: Vec<EastNorth> = Vec::new();
        for (_, place) in &self.scored {
            if targets.len() < TARGETS && targets.iter().all(|other| other.distance_m(*place) > scale_m) {
                targets.push(*place);
            }
        }
        for target in targets {
            let beyond = target.offset(self.from.bearing_deg(target), 0.7 * scale_m);
            ends.extend([target, settings.area.nearest(beyond)]);
        }
        let plans = ends.into_iter().filter_map(|end| {
            let first = line(settings, self.from, end, self.left_m)?;
            Some(Plan {
                worth: 0.0,
                first,
                second: None,
            })
        });
        plans.collect()
    }
}

/// The line from a place to another, as far as the way allows; `None` if it leads out of the area or is too short.
fn line(settings: &Settings, start: EastNorth, end: EastNorth, left_m: f64) -> Option<Line> {
    let mut line = Line { start, end };
    if line.length_m() > left_m {
        line.end = line.at(left_m);
    }
    (settings.area.contains(line.end, 0.0) && line.length_m() >= LINE_MIN_M).then_some(line)
}

/// The plan with a second line in each direction.
fn with_second(settings: &Settings, plan: &Plan, left_m: f64) -> Vec<Plan> {
    let from = plan.first.end;
    let left_m = left_m - plan.first.length_m() - TURN_M;
    let second = |turn: u32| {
        let end = from.offset(360.0 * f64::from(turn) / f64::from(TURNS), settings.line_m);
        line(settings, from, end, left_m)
    };
    let plans = (0..TURNS).filter_map(second).map(|second| Plan {
        second: Some(second),
        ..*plan
    });
    plans.collect()
}

/// By how much some measurements reduce the variance of what is of interest.
fn gain(map: &FieldMap, (known, counts): (&Known, &[(f64, f64)]), measured: &[EastNorth]) -> f64 {
    let Some(after) = map.deviations_after(known, measured) else {
        return 0.0;
    };
    let each = counts.iter().zip(after);
    each.map(|((weight, before), left)| weight * (before - left * left))
        .sum()
}

#[cfg(test)]
mod tests {
    use backseat_sdk::survey::GaussianProcess;

    use super::*;
    use crate::settings::tests::settings;

    fn planned(settings: &Settings, process: &GaussianProcess, from: EastNorth, left_m: f64) -> Option<Line> {
        let places = settings.places();
        let mut search = Search::new(process.fit().unwrap(), from, left_m, vec![]);
        for _ in 0..200 {
            if let Progress::Done(line) = search.work(settings, &places) {
                return line;
            }
        }
        panic!("the search does not end");
    }

    fn searched(warm: EastNorth) -> GaussianProcess {
        let settings = settings();
        let mut process = settings.process().unwrap();
        for line in settings.first_lines(EastNorth::new(-300.0, -200.0)) {
            for at in settings.along(&line, 100) {
                let off = at.distance_m(warm) / 70.0;
                process.add(at, 12.0 + 1.5 * backseat_sdk::units::math::exp(-0.5 * off * off));
            }
        }
        process
    }

    #[test]
    fn it_goes_to_the_warm_place_from_far_away() {
        let settings = settings();
        for (warm, from) in [
            (EastNorth::new(-150.0, 0.0), EastNorth::new(-300.0, 100.0)),
            (EastNorth::new(200.0, 10.0), EastNorth::new(-300.0, 100.0)),
        ] {
            let process = searched(warm);
            let line = planned(&settings, &process, from, 1000.0).unwrap();
            assert!(line.progress(warm).1 < 80.0, "{line:?} to {warm:?}");
            assert!(settings.area.contains(line.end, 0.0));
        }
    }

    #[test]
    fn a_line_is_no_longer_than_the_way_that_is_left() {
        let settings = settings();
        let process = searched(EastNorth::new(200.0, 10.0));
        let from = EastNorth::new(-300.0, 100.0);
        let line = planned(&settings, &process, from, 100.0).unwrap();
        assert!(line.length_m() < 100.1);
        assert_eq!(planned(&settings, &process, from, 50.0), None);
    }
}
