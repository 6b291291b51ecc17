use backseat_sdk::sonar::coverage::{Band, CoverageMap, FillWish, LineReach, Look, Place, Strip, Sweep};
use backseat_sdk::units::math::tan;
use serde::{Deserialize, Serialize};

use crate::config::Config;

/// The way from one short line to the next and onto it, metres.
const FILL_OVERHEAD_M: f64 = 150.0;
/// A line of the sweep that goes back to a hole sees at least this part of what one side sees on fresh ground.
const WORTH: f64 = 0.6;
/// The shortest line, metres.
pub(crate) const LINE_MIN_M: f64 = 60.0;
/// A survey ends after so many lines on which nothing was seen at all.
const BLIND_MAX: u32 = 3;
/// No survey has more lines.
const LINES_MAX: u32 = 500;

/// A straight line along the map's axes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Line {
    pub(crate) from: Place,
    pub(crate) to: Place,
}

impl Line {
    pub(crate) fn length_m(&self) -> f64 {
        (self.to.along_m - self.from.along_m).abs()
    }

    /// Whether it leads along the axes, and not against them: then starboard is towards greater distances across.
    fn is_forward(&self) -> bool {
        self.to.along_m >= self.from.along_m
    }

    /// How far a place is along it, 0 at its begin and 1 at its end, and its distance from it, metres.
    pub(crate) fn progress(&self, at: Place) -> (f64, f64) {
        let length_m = (self.to.along_m - self.from.along_m).abs().max(1e-6);
        let sign = if self.is_forward() { 1.0 } else { -1.0 };
        let along = (at.along_m - self.from.along_m) * sign / length_m;
        (along, (at.across_m - self.from.across_m).abs())
    }

    /// The line shortened at both ends; `None` if less than the shortest line would remain.
    pub(crate) fn shortened(&self, each_m: f64) -> Option<Self> {
        let cut_m = if self.is_forward() { each_m } else { -each_m };
        (self.length_m() - 2.0 * each_m >= LINE_MIN_M).then_some(Self {
            from: Place {
                along_m: self.from.along_m + cut_m,
                ..self.from
            },
            to: Place {
                along_m: self.to.along_m - cut_m,
                ..self.to
            },
        })
    }
}

/// Why a line is flown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Purpose {
    /// It is one of those that cross the area.
    Sweep,
    /// It fills gaps.
    Fill,
}

/// Why there is no further line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum End {
    /// Enough of the area was seen.
    Enough,
    /// No gap is worth its way.
    NoGapWorth,
    /// The most lines to fill gaps were flown.
    FillLines,
    /// The sonar shows nothing.
    Blind,
    /// The limit of lines was reached.
    Lines,
}

/// Decides on the lines.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Lines {
    /// Distances across times [`Lines::sign`].
    sweep: Sweep,
    /// 1 if the sweep goes towards greater distances across, -1 if it goes towards smaller ones.
    sign: f64,
    /// Which sweep this is, from 1.
    number: u8,
    /// What each line has seen: its distance across, and the worst of both sides.
    achieved: Vec<(f64, Band)>,
    /// What the last line has seen towards new ground: the next one is expected to see as much.
    expected: Band,
    fills: u32,
    blind: u32,
    asked: u32,
}

impl Lines {
    pub(crate) fn new(config: &Config, map: &CoverageMap) -> Self {
        Self {
            sweep: sweep(config, map, 1.0),
            sign: 1.0,
            number: 1,
            achieved: Vec::new(),
            expected: Band::level(config.range_m, config.first_altitude_m, config.nadir_deg),
            fills: 0,
            blind: 0,
            asked: 0,
        }
    }

    /// What a line at a distance across is expected to see: as much as the nearest one did.
    pub(crate) fn expected(&self, across_m: f64) -> Band {
        let off = |(other_m, _): &&(f64, Band)| (other_m - across_m).abs();
        let nearest = self
            .achieved
            .iter()
            .rev()
            .min_by(|one, other| off(one).total_cmp(&off(other)));
        nearest.map_or(self.expected, |(_, band)| *band)
    }

    /// The altitude from which the last line has seen the least, metres; `None` if nothing tells it.
    pub(crate) fn altitude_m(&self, config: &Config) -> Option<f64> {
        let per_altitude = tan(config.nadir_deg.to_radians());
        (per_altitude > 0.01).then(|| self.expected.inner_m / per_altitude)
    }

    /// The sonar's range will be another one on the next line.
    pub(crate) fn expect_range(&mut self, range_m: f64, altitude_m: f64, config: &Config) {
        self.expected = Band::level(range_m, altitude_m, config.nadir_deg);
    }

    /// A line was flown, or is nearly at its end.
    pub(crate) fn flown(&mut self, line: &Line, purpose: Purpose, reach: &LineReach, config: &Config) {
        let across_m = line.from.across_m;
        let Some((port, starboard)) = reach.worst(config.worst_but) else {
            self.blind += 1;
            self.given_up(line, purpose);
            return;
        };
        self.blind = 0;
        let (low, high) = if line.is_forward() {
            (port, starboard)
        } else {
            (starboard, port)
        };
        self.achieved.push((
            across_m,
            Band {
                inner_m: low.inner_m.max(high.inner_m),
                outer_m: low.outer_m.min(high.outer_m),
            },
        ));
        if purpose == Purpose::Sweep {
            let before = self.sweep.clone();
            let (low, high) = if self.sign > 0.0 { (low, high) } else { (high, low) };
            self.sweep.flown(self.sign * across_m, low, high);
            if high.width_m() > 2.0 * config.overlap_m {
                self.expected = high;
            }
            if self.sweep == before {
                // It has seen nothing new over its whole length. Gaps are for later.
                self.given_up(line, purpose);
            }
        }
    }

    /// A line is not flown: what it should have seen counts as done for the sweep. The map knows better.
    pub(crate) fn given_up(&mut self, line: &Line, purpose: Purpose) {
        let (across_m, outer_m) = (self.sign * line.from.across_m, self.expected.outer_m);
        if purpose == Purpose::Sweep {
            self.sweep.skip(across_m - outer_m, across_m + outer_m.max(1.0));
        }
    }

    /// The next line, from a place, in a map that has what the present line still will see.
    pub(crate) fn next(&mut self, map: &CoverageMap, from: Place, config: &Config) -> Result<(Line, Purpose), End> {
        if self.asked == 0 {
            // The sweep begins on the side that is nearer to the vehicle.
            let (least, most) = map.bounds();
            if (from.across_m - most.across_m).abs() < (from.across_m - least.across_m).abs() {
                self.sign = -1.0;
                self.sweep = sweep(config, map, self.sign);
            }
        }
        self.asked += 1;
        if self.asked > LINES_MAX {
            return Err(End::Lines);
        }
        if self.blind >= BLIND_MAX {
            return Err(End::Blind);
        }
        loop {
            let Some(across_m) = self.sweep.next(self.expected, config.overlap_m) else {
                if self.number >= config.times {
                    break;
                }
                // Back over the area from where the last sweep has ended.
                self.number += 1;
                self.sign = -self.sign;
                self.sweep = sweep(config, map, self.sign);
                continue;
            };
            let across_m = self.sign * across_m;
            let reach_m = self.expected.outer_m;
            let Some(extent) = map.extent(across_m - reach_m, across_m + reach_m, self.number) else {
                // All of it was seen already, on other ways.
                self.sweep
                    .skip(self.sign * across_m - reach_m, self.sign * across_m + reach_m);
                continue;
            };
            let gain_m2 = map.gain_m2(across_m, extent, self.expected, self.number);
            let length_m = extent.1 - extent.0;
            match self.sweep.hole_m() {
                // A hole in what was seen is worth a line of the sweep only if that sees much that is new.
                Some((from_m, to_m)) if gain_m2 < WORTH * self.expected.width_m() * length_m => {
                    self.sweep.skip(from_m, to_m);
                }
                Some(_) | None => return Ok((line(across_m, extent, from, config), Purpose::Sweep)),
            }
        }
        if map.part(config.times) >= config.enough {
            return Err(End::Enough);
        }
        if self.fills >= config.fill_lines_max {
            return Err(End::FillLines);
        }
        let wish = FillWish {
            times: config.times,
            overlap_m: 0.5 * config.overlap_m,
            length_min_m: LINE_MIN_M,
            overhead_m: FILL_OVERHEAD_M,
            worth_m2_per_m: config.fill_worth_m2_per_m,
        };
        let fill = map
            .best_fill(&wish, |across_m| self.expected(across_m))
            .ok_or(End::NoGapWorth)?;
        self.fills += 1;
        Ok((
            line(fill.across_m, (fill.from_m, fill.to_m), from, config),
            Purpose::Fill,
        ))
    }

    /// The map as it will be when the vehicle has flown the rest of a line, from a place.
    pub(crate) fn foreseen(&self, map: &CoverageMap, line: &Line, from: Place) -> CoverageMap {
        let mut map = map.clone();
        let band = self.expected(line.from.across_m);
        let heading = map.axes().local(line.from).bearing_deg(map.axes().local(line.to));
        let look = |place: Place| Look {
            at_ns: 0,
            at: map.axes().local(place),
            bearing_deg: heading,
            port: band,
            starboard: band,
        };
        let strip = Strip {
            from: look(Place {
                across_m: line.from.across_m,
                ..from
            }),
            to: look(line.to),
        };
        map.mark(&strip);
        map
    }
}

fn sweep(config: &Config, map: &CoverageMap, sign: f64) -> Sweep {
    let (least, most) = map.bounds();
    let (one_m, other_m) = (sign * least.across_m, sign * most.across_m);
    Sweep::new(one_m.min(other_m), one_m.max(other_m), config.cell_m)
}

/// A line over an extent that begins at the end that is nearer to a place.
fn line(across_m: f64, (from_m, to_m): (f64, f64), near: Place, config: &Config) -> Line {
    let short_m = (0.5 * (LINE_MIN_M - (to_m - from_m))).max(config.run_in_m);
    let low = Place {
        along_m: from_m - short_m,
        across_m,
    };
    let high = Place {
        along_m: to_m + short_m,
        across_m,
    };
    if (near.along_m - low.along_m).abs() <= (near.along_m - high.along_m).abs() {
        Line { from: low, to: high }
    } else {
        Line { from: high, to: low }
    }
}
