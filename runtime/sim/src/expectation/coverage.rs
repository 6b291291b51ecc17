//! `[expect.coverage]`: which part of an area a sidescan has truly seen, and by how long a way.
//!
//! A place counts as seen if it was abeam of the vehicle between two successive pings, within the sonar's range along the
//! slant to the true seabed there, and outside the gap below the vehicle. Between pings that are more than three seconds
//! or 25 m apart, and while the vehicle turns faster than the expectation allows, nothing is seen. Shadows of the terrain
//! and of objects, and noise, are not taken into account. This code shares nothing with the tools of plugins.

use std::time::Duration;

use backseat_mvc::{CoverageExpectation, SidescanName};
use backseat_plc::SensorKind;
use backseat_units::EastNorth;
use backseat_units::math::{sin_cos, tan, wrap_180};
use backseat_world::World;

use crate::report::Report;
use crate::trace::{Sample, Sounding, Trace};

/// Pings that are farther apart show nothing of what is between them.
const APART_MAX: Duration = Duration::from_secs(3);
const APART_MAX_M: f64 = 25.0;

pub(super) fn judge(report: &mut Report, expect: &CoverageExpectation, trace: &Trace, world: &World) {
    let sensor = match expect.sensor {
        SidescanName::SidescanLow => SensorKind::SidescanLow,
        SidescanName::SidescanHigh => SensorKind::SidescanHigh,
    };
    let mut cells = Cells::new(expect, world);
    let of_sensor = trace.soundings.iter().filter(|sounding| sounding.sensor == sensor);
    let mut last: Option<&Sounding> = None;
    for sounding in of_sensor {
        if let Some(last) = last {
            cells.see(last, sounding, world);
        }
        last = Some(sounding);
    }
    let percent = 100.0 * cells.part();
    let way_m = way_m(expect, &trace.samples);
    let per_km = if way_m > 0.0 { percent / (way_m / 1000.0) } else { 0.0 };
    report.measures.insert("coverage_percent", percent);
    report.measures.insert("coverage_way_m", way_m);
    report.measures.insert("coverage_per_km_percent", per_km);
    let mut unmet = |holds: bool, text: String| {
        if !holds {
            report.unmet.push(text);
        }
    };
    let least = expect.seen_min_percent;
    unmet(
        percent >= least,
        format!("{percent:.1} % of the area was seen, expected at least {least} %"),
    );
    if let Some(most_m) = expect.way_max_m {
        unmet(
            way_m <= most_m,
            format!("the way over the area was {way_m:.0} m, expected at most {most_m} m"),
        );
    }
    if let Some(least) = expect.per_km_min_percent {
        unmet(
            per_km >= least,
            format!("{per_km:.2} % of the area was seen a kilometre, expected at least {least} %"),
        );
    }
}

/// The square cells of the area's rectangle, and which of them were seen.
struct Cells {
    expect: CoverageExpectation,
    /// The unit vector along the rectangle's length.
    along: EastNorth,
    columns: usize,
    /// The middle of each cell, and the depth of the water there without the tide, metres.
    middles: Vec<(EastNorth, f64)>,
    seen: Vec<bool>,
}

impl Cells {
    fn new(expect: &CoverageExpectation, world: &World) -> Self {
        let (sin, cos) = sin_cos(expect.bearing_deg.to_radians());
        let along = EastNorth::new(sin, cos);
        let count = |side_m: f64| (side_m / expect.cell_m).ceil().max(1.0) as usize;
        let (columns, rows) = (count(expect.length_m), count(expect.width_m));
        let middles: Vec<(EastNorth, f64)> = (0..rows * columns)
            .map(|index| {
                let from_middle =
                    |cell: usize, count: usize, side_m: f64| ((cell as f64 + 0.5) / count as f64 - 0.5) * side_m;
                let along_m = from_middle(index % columns, columns, expect.length_m);
                let across_m = from_middle(index / columns, rows, expect.width_m);
                let at = EastNorth::new(
                    expect.east_m + along_m * along.east_m + across_m * along.north_m,
                    expect.north_m + along_m * along.north_m - across_m * along.east_m,
                );
                (at, world.water_depth_m(at))
            })
            .collect();
        let seen = vec![false; middles.len()];
        Self {
            expect: *expect,
            along,
            columns,
            middles,
            seen,
        }
    }

    fn part(&self) -> f64 {
        self.seen.iter().filter(|seen| **seen).count() as f64 / self.seen.len() as f64
    }

    /// Marks what was abeam between two pings.
    fn see(&mut self, from: &Sounding, to: &Sounding, world: &World) {
        let apart = to.at.since(from.at);
        let turned_deg = wrap_180(to.heading_deg - from.heading_deg).abs();
        if apart > APART_MAX
            || from.local.distance_m(to.local) > APART_MAX_M
            || turned_deg > self.expect.turn_max_dps * apart.as_secs_f64()
        {
            return;
        }
        let range_m = from.range_m.min(to.range_m);
        let altitude_m = world.water_depth_at_m(to.local, to.at) - to.depth_m;
        let gap_m = altitude_m.max(0.0) * tan(self.expect.nadir_deg.to_radians());
        let tide_m = world.tide_m(to.at);
        // How far a place is ahead of a ping's beams, and of the next one's.
        let ahead = |sounding: &Sounding, at: EastNorth| {
            let (sin, cos) = sin_cos(sounding.heading_deg.to_radians());
            let way = at - sounding.local;
            way.east_m * sin + way.north_m * cos
        };
        for index in self.near(from.local, range_m + APART_MAX_M) {
            if self.seen[index] {
                continue;
            }
            let (at, depth_m) = self.middles[index];
            let (behind_m, before_m) = (ahead(from, at), -ahead(to, at));
            if behind_m < 0.0 || before_m <= 0.0 {
                continue;
            }
            let part = behind_m / (behind_m + before_m);
            let abeam = from.local + (to.local - from.local) * part;
            let out_m = abeam.distance_m(at);
            let below_m = depth_m + tide_m - (from.depth_m + (to.depth_m - from.depth_m) * part);
            self.seen[index] = out_m >= gap_m && out_m * out_m + below_m * below_m <= range_m * range_m;
        }
    }

    /// The cells of the square around a place, row by row.
    fn near(&self, at: EastNorth, radius_m: f64) -> impl Iterator<Item = usize> + use<> {
        let from = at - EastNorth::new(self.expect.east_m, self.expect.north_m);
        let along_m = from.east_m * self.along.east_m + from.north_m * self.along.north_m;
        let across_m = from.east_m * self.along.north_m - from.north_m * self.along.east_m;
        let (columns, rows) = (self.columns, self.middles.len() / self.columns);
        let span = |middle_m: f64, side_m: f64, count: usize| {
            let cell = |offset_m: f64| {
                let place = (middle_m + offset_m + 0.5 * side_m) / side_m * count as f64;
                place.clamp(0.0, count as f64) as usize
            };
            cell(-radius_m)..(cell(radius_m) + 1).min(count)
        };
        let (across, along) = (
            span(across_m, self.expect.width_m, rows),
            span(along_m, self.expect.length_m, columns),
        );
        across.flat_map(move |row| along.clone().map(move |column| row * columns + column))
    }
}

/// The way from the first to the last moment in the rectangle, metres.
fn way_m(expect: &CoverageExpectation, samples: &[Sample]) -> f64 {
    let (sin, cos) = sin_cos(expect.bearing_deg.to_radians());
    let is_inside = |sample: &Sample| {
        let from = sample.local - EastNorth::new(expect.east_m, expect.north_m);
        let (along_m, across_m) = (
            from.east_m * sin + from.north_m * cos,
            from.east_m * cos - from.north_m * sin,
        );
        along_m.abs() <= 0.5 * expect.length_m && across_m.abs() <= 0.5 * expect.width_m
    };
    let (Some(first), Some(last)) = (samples.iter().position(is_inside), samples.iter().rposition(is_inside)) else {
        return 0.0;
    };
    samples[first..=last]
        .windows(2)
        .map(|pair| pair[0].local.distance_m(pair[1].local))
        .sum()
}

#[cfg(test)]
mod tests {
    use backseat_units::Timestamp;
    use backseat_world::WorldConfig;

    use super::*;

    fn world() -> World {
        let config: WorldConfig = toml::from_str(
            "[origin]\nlatitude_deg = 42.3\nlongitude_deg = -70.6\n\
            [seabed]\ndepth_m = 40\nslope = 0\nmeanders = 0\nmeander_slope = 0",
        )
        .unwrap();
        World::new(&config, 1).unwrap()
    }

    fn expect() -> CoverageExpectation {
        toml::from_str(
            "east_m = 100\nnorth_m = 50\nlength_m = 400\nwidth_m = 200\nbearing_deg = 90\nnadir_deg = 45\ncell_m = 2",
        )
        .unwrap()
    }

    /// A line to the east at 20 m above the seabed, a ping a second.
    fn line(north_m: f64, heading_deg: f64) -> Vec<Sounding> {
        (0..400_u32)
            .map(|second| Sounding {
                at: Timestamp::from_secs(u64::from(second)),
                sensor: SensorKind::SidescanHigh,
                range_m: 52.0,
                local: EastNorth::new(-200.0 + 1.5 * f64::from(second), north_m),
                depth_m: 20.0,
                heading_deg,
            })
            .collect()
    }

    fn part(soundings: &[Sounding]) -> f64 {
        let mut cells = Cells::new(&expect(), &world());
        for pair in soundings.windows(2) {
            cells.see(&pair[0], &pair[1], &world());
        }
        cells.part()
    }

    #[test]
    fn a_line_sees_from_the_gap_to_the_end_of_its_range() {
        // 52 m along the slant are 48 m over the ground; 20 m to each side are the gap: 28 m of 200 m a side.
        let along = part(&line(50.0, 90.0));
        assert!((along - 56.0 / 200.0).abs() < 1e-9, "{along}");
        // At the edge of the rectangle only one side sees it.
        let edge = part(&line(150.0, 90.0));
        assert!((edge - 28.0 / 200.0).abs() < 1e-9, "{edge}");
        // The beams of a vehicle that crabs reach less far across its track.
        let crab = part(&line(50.0, 50.0));
        assert!(crab < along && crab > 0.6 * along, "{crab}");
    }

    #[test]
    fn turns_and_missing_pings_show_nothing() {
        let mut turning = line(50.0, 90.0);
        turning
            .iter_mut()
            .zip(0_u32..)
            .for_each(|(sounding, second)| sounding.heading_deg = 90.0 + 2.0 * f64::from(second % 2));
        assert_eq!(part(&turning), 0.0);
        let sparse: Vec<Sounding> = line(50.0, 90.0).into_iter().step_by(4).collect();
        assert_eq!(part(&sparse), 0.0);
        assert!(part(&line(50.0, 90.0)[..180]) < 0.5 * part(&line(50.0, 90.0)));
    }

    #[test]
    fn the_way_is_that_between_the_first_and_the_last_moment_inside() {
        let sample = |second: u32| Sample {
            at: Timestamp::from_secs(u64::from(second)),
            local: EastNorth::new(-200.0 + 10.0 * f64::from(second), 60.0),
            position: backseat_units::Position::from_deg(42.0, -70.0).unwrap(),
            depth_m: 20.0,
            water_depth_m: 40.0,
            steering: crate::trace::Steering::Insert,
        };
        let samples: Vec<Sample> = (0..100).map(sample).collect();
        assert!((way_m(&expect(), &samples) - 400.0).abs() < 1e-9);
        assert_eq!(way_m(&expect(), &samples[..5]), 0.0);
    }
}
