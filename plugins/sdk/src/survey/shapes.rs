use backseat_units::EastNorth;
use backseat_units::math::{atan2, sin_cos, wrap_180, wrap_360};
use serde::{Deserialize, Serialize};

/// The most lines of one pattern.
const LINES_MAX: f64 = 10_000.0;

/// A straight line from one point to another.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// Where it begins.
    pub start: EastNorth,
    /// Where it ends.
    pub end: EastNorth,
}

impl Line {
    /// Its length, metres.
    #[must_use]
    pub fn length_m(&self) -> f64 {
        self.start.distance_m(self.end)
    }

    /// From start to end, degrees clockwise from the frame's north, in [0, 360).
    #[must_use]
    pub fn bearing_deg(&self) -> f64 {
        self.start.bearing_deg(self.end)
    }

    /// The same line, flown the other way.
    #[must_use]
    pub const fn reversed(self) -> Self {
        Self {
            start: self.end,
            end: self.start,
        }
    }

    /// The line, beginning at the end that is closer to a point.
    #[must_use]
    pub fn begun_near(self, at: EastNorth) -> Self {
        if self.end.distance_m(at) < self.start.distance_m(at) {
            self.reversed()
        } else {
            self
        }
    }

    /// The point so many metres from the start. Negative is before the start, and beyond the end is allowed.
    #[must_use]
    pub fn at(&self, along_m: f64) -> EastNorth {
        self.start.offset(self.bearing_deg(), along_m)
    }

    /// Where a point is along the line, 0 at the start and 1 at the end, and its distance from the line, metres.
    #[must_use]
    pub fn progress(&self, at: EastNorth) -> (f64, f64) {
        let (way, from) = (self.end - self.start, at - self.start);
        let length_m = self.length_m().max(1e-6);
        let along = (way.east_m * from.east_m + way.north_m * from.north_m) / (length_m * length_m);
        let across_m = (way.east_m * from.north_m - way.north_m * from.east_m) / length_m;
        (along, across_m.abs())
    }

    /// How far along the line a point is, metres from the start.
    #[must_use]
    pub fn along_m(&self, at: EastNorth) -> f64 {
        let (sin, cos) = sin_cos(self.bearing_deg().to_radians());
        let from = at - self.start;
        from.east_m * sin + from.north_m * cos
    }

    /// How far to starboard of the line a point is, metres.
    #[must_use]
    pub fn across_m(&self, at: EastNorth) -> f64 {
        let (sin, cos) = sin_cos(self.bearing_deg().to_radians());
        let from = at - self.start;
        from.east_m * cos - from.north_m * sin
    }

    /// The line shortened by this much at both ends; `None` if less than `least_m` would remain.
    #[must_use]
    pub fn shortened(&self, each_m: f64, least_m: f64) -> Option<Self> {
        let length_m = self.length_m();
        if length_m - 2.0 * each_m < least_m {
            return None;
        }
        let cut = (self.end - self.start) * (each_m / length_m);
        Some(Self {
            start: self.start + cut,
            end: self.end - cut,
        })
    }

    /// The heading that brings a vehicle at a point onto the line and then along it: towards the point of the line that
    /// is `lookahead_m` metres ahead. Degrees from the frame's north, in [0, 360). Source: line-of-sight guidance,
    /// Fossen, *Handbook of Marine Craft Hydrodynamics and Motion Control*, 2011, section 10.3.2.
    #[must_use]
    pub fn heading_to_follow_deg(&self, at: EastNorth, lookahead_m: f64) -> f64 {
        wrap_360(self.bearing_deg() - atan2(self.across_m(at), lookahead_m).to_degrees())
    }
}

/// A rectangle: its centre, its length and width, and the direction of its length.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rectangle {
    centre: EastNorth,
    half_length_m: f64,
    half_width_m: f64,
    /// The unit vector of the length.
    axis: EastNorth,
}

impl Rectangle {
    /// A rectangle around a centre. `bearing_deg` is the direction of its length, degrees clockwise from the frame's
    /// north.
    #[must_use]
    pub fn new(centre: EastNorth, length_m: f64, width_m: f64, bearing_deg: f64) -> Self {
        let (sin, cos) = sin_cos(wrap_180(bearing_deg).to_radians());
        Self {
            centre,
            half_length_m: length_m / 2.0,
            half_width_m: width_m / 2.0,
            axis: EastNorth::new(sin, cos),
        }
    }

    /// Its centre.
    #[must_use]
    pub const fn centre(&self) -> EastNorth {
        self.centre
    }

    /// Its length, metres.
    #[must_use]
    pub const fn length_m(&self) -> f64 {
        2.0 * self.half_length_m
    }

    /// Its width, metres.
    #[must_use]
    pub const fn width_m(&self) -> f64 {
        2.0 * self.half_width_m
    }

    /// A point from the rectangle's own coordinates: metres from the centre along the length, and to starboard of it.
    #[must_use]
    pub fn point(&self, along_m: f64, across_m: f64) -> EastNorth {
        let starboard = EastNorth::new(self.axis.north_m, -self.axis.east_m);
        self.centre + (self.axis * along_m + starboard * across_m)
    }

    /// The rectangle's own coordinates of a point: metres from the centre along the length, and to starboard of it.
    #[must_use]
    pub fn axes(&self, at: EastNorth) -> (f64, f64) {
        let from = at - self.centre;
        (
            self.axis.east_m * from.east_m + self.axis.north_m * from.north_m,
            self.axis.north_m * from.east_m - self.axis.east_m * from.north_m,
        )
    }

    /// Whether a point is inside, or within `margin_m` metres of it. A negative margin counts inwards.
    #[must_use]
    pub fn contains(&self, at: EastNorth, margin_m: f64) -> bool {
        let (along_m, across_m) = self.axes(at);
        along_m.abs() <= self.half_length_m + margin_m && across_m.abs() <= self.half_width_m + margin_m
    }

    /// The point of the rectangle that is closest to another.
    #[must_use]
    pub fn nearest(&self, at: EastNorth) -> EastNorth {
        let (along_m, across_m) = self.axes(at);
        self.point(
            along_m.clamp(-self.half_length_m, self.half_length_m),
            across_m.clamp(-self.half_width_m, self.half_width_m),
        )
    }

    /// Its corners, clockwise, beginning at the port end of the side where the length begins.
    #[must_use]
    pub fn corners(&self) -> [EastNorth; 4] {
        let (length_m, width_m) = (self.half_length_m, self.half_width_m);
        [
            self.point(-length_m, -width_m),
            self.point(length_m, -width_m),
            self.point(length_m, width_m),
            self.point(-length_m, width_m),
        ]
    }

    /// A lawnmower: lines along the length, flown to and fro, at most `spacing_m` metres apart; the outer ones lie half
    /// of their distance from the long sides. It begins at the corner that is closest to `from`. At most 10,000 lines;
    /// none if the spacing is not above 0.
    #[must_use]
    pub fn lawnmower(&self, spacing_m: f64, from: EastNorth) -> Vec<Line> {
        if spacing_m.is_nan() || spacing_m <= 0.0 {
            return Vec::new();
        }
        let count = (self.width_m() / spacing_m).ceil().clamp(1.0, LINES_MAX) as u32;
        let apart_m = self.width_m() / f64::from(count);
        let (along_m, across_m) = self.axes(from);
        let side = |metres: f64| if metres > 0.0 { 1.0 } else { -1.0 };
        let (first_along, first_across) = (side(along_m), side(across_m));
        let lines = (0..count).map(|index| {
            let across_m = first_across * (self.half_width_m - (f64::from(index) + 0.5) * apart_m);
            let end = if index % 2 == 0 { first_along } else { -first_along };
            Line {
                start: self.point(end * self.half_length_m, across_m),
                end: self.point(-end * self.half_length_m, across_m),
            }
        });
        lines.collect()
    }

    /// Two lines through a point, `half_m` metres to both sides but within the rectangle: the first across it, the second
    /// along it. Each begins at the end that is closer to the vehicle.
    #[must_use]
    pub fn cross(&self, through: EastNorth, half_m: f64, from: EastNorth) -> [Line; 2] {
        let (along_m, across_m) = self.axes(self.nearest(through));
        let span = |middle_m: f64, most_m: f64| ((middle_m - half_m).max(-most_m), (middle_m + half_m).min(most_m));
        let (across_start_m, across_end_m) = span(across_m, self.half_width_m);
        let (along_start_m, along_end_m) = span(along_m, self.half_length_m);
        let across = Line {
            start: self.point(along_m, across_start_m),
            end: self.point(along_m, across_end_m),
        }
        .begun_near(from);
        let along = Line {
            start: self.point(along_start_m, across_m),
            end: self.point(along_end_m, across_m),
        }
        .begun_near(across.end);
        [across, along]
    }

    /// A zigzag along the length: lines from one long side to the other, each of which goes on `step_m` metres along the
    /// length, as for a front that lies along it. It begins at the corner that is closest to `from`. At most 10,000 lines;
    /// none if the step is not above 0.
    #[must_use]
    pub fn zigzag(&self, step_m: f64, from: EastNorth) -> Vec<Line> {
        if step_m.is_nan() || step_m <= 0.0 {
            return Vec::new();
        }
        let count = (self.length_m() / step_m).ceil().clamp(1.0, LINES_MAX) as u32;
        let step_m = self.length_m() / f64::from(count);
        let (along_m, across_m) = self.axes(from);
        let side = |metres: f64| if metres > 0.0 { 1.0 } else { -1.0 };
        let (first_along, first_across) = (side(along_m), side(across_m));
        let corner = |index: u32| {
            let across = if index.is_multiple_of(2) {
                first_across
            } else {
                -first_across
            };
            self.point(
                first_along * (self.half_length_m - f64::from(index) * step_m),
                across * self.half_width_m,
            )
        };
        let lines = (0..count).map(|index| Line {
            start: corner(index),
            end: corner(index + 1),
        });
        lines.collect()
    }
}

/// An expanding square around a point: each line turns 90 degrees to starboard, and after two lines the next ones are
/// `spacing_m` metres longer (International Aeronautical and Maritime Search and Rescue Manual, volume III, section 3).
/// The first line leads in the direction `bearing_deg`, degrees from the frame's north.
#[must_use]
pub fn expanding_square(centre: EastNorth, spacing_m: f64, lines: u32, bearing_deg: f64) -> Vec<Line> {
    let mut start = centre;
    let flown = (0..lines).map(|index| {
        let length_m = spacing_m * f64::from(index / 2 + 1);
        let end = start.offset(bearing_deg + 90.0 * f64::from(index % 4), length_m);
        let line = Line { start, end };
        start = end;
        line
    });
    flown.collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn at(east_m: f64, north_m: f64) -> EastNorth {
        EastNorth::new(east_m, north_m)
    }

    fn near(is: EastNorth, expected: EastNorth) {
        assert!(is.distance_m(expected) < 1e-9, "{is:?} instead of {expected:?}");
    }

    #[test]
    fn a_point_is_along_and_to_starboard_of_a_line() {
        let line = Line {
            start: at(10.0, 10.0),
            end: at(110.0, 10.0),
        };
        assert_eq!(line.bearing_deg(), 90.0);
        assert!((line.along_m(at(40.0, 0.0)) - 30.0).abs() < 1e-9);
        assert!(
            (line.across_m(at(40.0, 0.0)) - 10.0).abs() < 1e-9,
            "south is to starboard of east"
        );
        let (along, off_m) = line.progress(at(40.0, 0.0));
        assert!((along - 0.3).abs() < 1e-12 && (off_m - 10.0).abs() < 1e-12);
        near(line.at(-5.0), at(5.0, 10.0));
        // 10 m to starboard with 10 m of lookahead: 45 degrees to port.
        assert!((line.heading_to_follow_deg(at(40.0, 0.0), 10.0) - 45.0).abs() < 1e-9);
        assert_eq!(line.begun_near(at(100.0, 0.0)), line.reversed());
        assert_eq!(line.begun_near(at(0.0, 0.0)), line);
        let shorter = line.shortened(30.0, 40.0).unwrap();
        near(shorter.start, at(40.0, 10.0));
        near(shorter.end, at(80.0, 10.0));
        assert_eq!(line.shortened(30.0, 41.0), None);
    }

    #[test]
    fn a_rectangle_has_its_length_in_the_direction_of_its_bearing() {
        let area = Rectangle::new(at(100.0, 0.0), 80.0, 20.0, 90.0);
        let corners = [at(60.0, 10.0), at(140.0, 10.0), at(140.0, -10.0), at(60.0, -10.0)];
        for (is, expected) in area.corners().into_iter().zip(corners) {
            near(is, expected);
        }
        assert!(area.contains(at(139.0, 9.0), 0.0) && !area.contains(at(141.0, 0.0), 0.0));
        assert!(area.contains(at(141.0, 0.0), 2.0) && !area.contains(at(139.0, 9.0), -2.0));
        near(area.nearest(at(200.0, 50.0)), at(140.0, 10.0));
        assert_eq!((area.length_m(), area.width_m()), (80.0, 20.0));
    }

    #[test]
    fn a_lawnmower_goes_to_and_fro_from_the_nearest_corner() {
        let area = Rectangle::new(at(0.0, 0.0), 100.0, 60.0, 0.0);
        let lines = area.lawnmower(25.0, at(-100.0, -100.0));
        let expected = [(-20.0, -50.0, 50.0), (0.0, 50.0, -50.0), (20.0, -50.0, 50.0)];
        assert_eq!(lines.len(), 3);
        for (line, (east, from, to)) in lines.iter().zip(expected) {
            near(line.start, at(east, from));
            near(line.end, at(east, to));
        }
        let lines = area.lawnmower(25.0, at(100.0, 100.0));
        near(lines[0].start, at(20.0, 50.0));
        assert_eq!(area.lawnmower(1000.0, at(0.0, 0.0)).len(), 1);
        for spacing in [0.0, -1.0, f64::NAN] {
            assert!(area.lawnmower(spacing, at(0.0, 0.0)).is_empty());
        }
    }

    #[test]
    fn a_zigzag_goes_from_side_to_side() {
        let area = Rectangle::new(at(0.0, 0.0), 100.0, 60.0, 0.0);
        let lines = area.zigzag(40.0, at(-100.0, 100.0));
        assert_eq!(lines.len(), 3);
        near(lines[0].start, at(-30.0, 50.0));
        near(lines[0].end, at(30.0, 50.0 - 100.0 / 3.0));
        near(lines[2].end, at(30.0, -50.0));
        for pair in lines.windows(2) {
            assert_eq!(pair[0].end, pair[1].start);
        }
        assert!(area.zigzag(0.0, at(0.0, 0.0)).is_empty());
    }

    #[test]
    fn an_expanding_square_turns_to_starboard_and_grows_after_two_lines() {
        let lines = expanding_square(at(0.0, 0.0), 10.0, 5, 0.0);
        let corners = [
            at(0.0, 0.0),
            at(0.0, 10.0),
            at(10.0, 10.0),
            at(10.0, -10.0),
            at(-10.0, -10.0),
            at(-10.0, 20.0),
        ];
        assert_eq!(lines.len(), 5);
        for (index, line) in lines.iter().enumerate() {
            near(line.start, corners[index]);
            near(line.end, corners[index + 1]);
        }
    }

    proptest! {
        #[test]
        fn a_lawnmower_passes_every_point_of_its_rectangle_within_half_of_its_spacing(
            (length_m, width_m, bearing_deg) in (10.0..3000.0, 10.0..3000.0, -360.0..360.0),
            spacing_m in 5.0..500.0,
            (along, across) in (-0.5..=0.5, -0.5..=0.5),
            (east_m, north_m) in (-4000.0..4000.0, -4000.0..4000.0),
        ) {
            let area = Rectangle::new(at(70.0, -30.0), length_m, width_m, bearing_deg);
            let lines = area.lawnmower(spacing_m, at(east_m, north_m));
            let point = area.point(along * length_m, across * width_m);
            let off_m = lines.iter().map(|line| line.progress(point).1).fold(f64::INFINITY, f64::min);
            prop_assert!(off_m <= spacing_m / 2.0 + 1e-6);
            for line in &lines {
                prop_assert!(area.contains(line.start, 1e-6) && area.contains(line.end, 1e-6));
                prop_assert!((line.length_m() - length_m).abs() < 1e-6);
            }
            let first_m = lines[0].start.distance_m(at(east_m, north_m));
            let last_m = lines[lines.len() - 1].start.distance_m(at(east_m, north_m));
            prop_assert!(first_m <= last_m + length_m + 1e-6);
        }

        #[test]
        fn a_cross_lies_in_its_rectangle(
            (length_m, width_m, bearing_deg) in (200.0..3000.0, 200.0..3000.0, -360.0..360.0),
            (through_east, through_north) in (-2000.0..2000.0, -2000.0..2000.0),
        ) {
            let area = Rectangle::new(at(70.0, -30.0), length_m, width_m, bearing_deg);
            let through = at(through_east, through_north);
            for line in area.cross(through, 80.0, at(0.0, 0.0)) {
                prop_assert!(line.progress(area.nearest(through)).1 < 1e-6);
                prop_assert!(area.contains(line.start, 1e-6) && area.contains(line.end, 1e-6));
            }
        }
    }
}
