use backseat_sdk::units::math::{sin_cos, wrap_180};
use backseat_sdk::units::{EastNorth, LocalFrame, Position};
use serde::{Deserialize, Serialize};

/// A straight line, in metres east and north of the area's centre.
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

    /// The position of a point along the line, 0 to 1 between its ends, and its distance from the line, metres.
    #[must_use]
    pub fn progress(&self, at: EastNorth) -> (f64, f64) {
        let (way, from) = (self.end - self.start, at - self.start);
        let length_m = self.length_m().max(1e-6);
        let along = (way.east_m * from.east_m + way.north_m * from.north_m) / (length_m * length_m);
        let across_m = (way.east_m * from.north_m - way.north_m * from.east_m) / length_m;
        (along, across_m.abs())
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

    fn turned(self) -> Self {
        Self {
            start: self.end,
            end: self.start,
        }
    }

    /// The line, beginning at the end that is closer to a point.
    fn begun_near(self, at: EastNorth) -> Self {
        if self.end.distance_m(at) < self.start.distance_m(at) {
            self.turned()
        } else {
            self
        }
    }
}

/// The rectangle to survey. Points are in metres east and north of its centre. Its own axes are u, along its longer
/// side, and v, across it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area {
    frame: LocalFrame,
    half_u_m: f64,
    half_v_m: f64,
    /// The unit vector of u.
    axis: EastNorth,
}

impl Area {
    /// A rectangle around a centre, with a width (east) and a height (north) before it is turned clockwise by
    /// `orientation_deg`.
    #[must_use]
    pub fn new(centre: Position, size: EastNorth, orientation_deg: f64) -> Self {
        let wide = size.east_m >= size.north_m;
        let u_deg = orientation_deg + if wide { 90.0 } else { 0.0 };
        let (sin, cos) = sin_cos(wrap_180(u_deg).to_radians());
        let (half_u_m, half_v_m) = if wide {
            (size.east_m / 2.0, size.north_m / 2.0)
        } else {
            (size.north_m / 2.0, size.east_m / 2.0)
        };
        Self {
            frame: LocalFrame::new(centre),
            half_u_m,
            half_v_m,
            axis: EastNorth::new(sin, cos),
        }
    }

    /// The local frame around its centre.
    #[must_use]
    pub const fn frame(&self) -> &LocalFrame {
        &self.frame
    }

    /// The length of its longer side, metres.
    #[must_use]
    pub const fn length_m(&self) -> f64 {
        2.0 * self.half_u_m
    }

    /// The length of its shorter side, metres.
    #[must_use]
    pub const fn width_m(&self) -> f64 {
        2.0 * self.half_v_m
    }

    /// Whether a point is in the area, or within `margin_m` of it.
    #[must_use]
    pub fn contains(&self, at: EastNorth, margin_m: f64) -> bool {
        let (u, v) = self.axes(at);
        u.abs() <= self.half_u_m + margin_m && v.abs() <= self.half_v_m + margin_m
    }

    /// The point of the area that is closest.
    #[must_use]
    pub fn nearest(&self, at: EastNorth) -> EastNorth {
        let (u, v) = self.axes(at);
        self.point(
            u.clamp(-self.half_u_m, self.half_u_m),
            v.clamp(-self.half_v_m, self.half_v_m),
        )
    }

    /// A lawnmower pattern: parallel lines at most `spacing_m` apart; the outer lines lie half of that distance from
    /// the long sides. It begins at the corner closest to `from`.
    #[must_use]
    pub fn lawnmower(&self, spacing_m: f64, from: EastNorth) -> Vec<Line> {
        // At most 2000, because the configuration is validated.
        let count = (self.width_m() / spacing_m).ceil().clamp(2.0, 2000.0) as u32;
        let apart_m = self.width_m() / f64::from(count);
        let (u, v) = self.axes(from);
        let (first_u, first_v) = (if u > 0.0 { 1.0 } else { -1.0 }, if v > 0.0 { 1.0 } else { -1.0 });
        (0..count)
            .map(|index| {
                let v_m = first_v * (self.half_v_m - (f64::from(index) + 0.5) * apart_m);
                let side = if index % 2 == 0 { first_u } else { -first_u };
                Line {
                    start: self.point(side * self.half_u_m, v_m),
                    end: self.point(-side * self.half_u_m, v_m),
                }
            })
            .collect()
    }

    /// Two lines through a point, `half_m` to both sides but within the area. The first goes across the lawnmower
    /// pattern, where least is known. Each begins at the end closer to the vehicle.
    #[must_use]
    pub fn cross(&self, through: EastNorth, half_m: f64, from: EastNorth) -> [Line; 2] {
        let (u, v) = self.axes(self.nearest(through));
        let span = |middle_m: f64, most_m: f64| ((middle_m - half_m).max(-most_m), (middle_m + half_m).min(most_m));
        let (v_start, v_end) = span(v, self.half_v_m);
        let (u_start, u_end) = span(u, self.half_u_m);
        let across = Line {
            start: self.point(u, v_start),
            end: self.point(u, v_end),
        }
        .begun_near(from);
        let along = Line {
            start: self.point(u_start, v),
            end: self.point(u_end, v),
        }
        .begun_near(across.end);
        [across, along]
    }

    fn axes(&self, at: EastNorth) -> (f64, f64) {
        let (east, north) = (self.axis.east_m, self.axis.north_m);
        (
            at.east_m * east + at.north_m * north,
            at.north_m * east - at.east_m * north,
        )
    }

    fn point(&self, u_m: f64, v_m: f64) -> EastNorth {
        let (east, north) = (self.axis.east_m, self.axis.north_m);
        EastNorth::new(u_m * east - v_m * north, u_m * north + v_m * east)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn area(orientation_deg: f64) -> Area {
        let centre = Position::from_deg(42.0, -70.0).unwrap();
        Area::new(centre, EastNorth::new(600.0, 500.0), orientation_deg)
    }

    proptest! {
        #[test]
        fn lines_stay_inside_and_leave_no_gap(
            turn in -180.0..180.0f64, spacing in 20.0..200.0f64, u in -299.0..299.0f64, v in -249.0..249.0f64,
        ) {
            let area = area(turn);
            let from = area.point(900.0, -700.0);
            let lines = area.lawnmower(spacing, from);
            let at = area.point(u, v);
            let nearest_m = lines.iter().map(|line| line.progress(at).1).fold(f64::INFINITY, f64::min);
            prop_assert!(nearest_m <= spacing / 2.0 + 1e-6);
            prop_assert!(lines.iter().all(|line| area.contains(line.start, 1e-6) && area.contains(line.end, 1e-6)));
            for pair in lines.windows(2) {
                prop_assert!(pair[0].end.distance_m(pair[1].start) <= spacing + 1e-6, "the lines are far apart");
            }
            let corner_m = lines[0].start.distance_m(area.point(300.0, -250.0));
            prop_assert!(corner_m <= spacing / 2.0 + 1e-6);
            for line in area.cross(at, 150.0, from) {
                prop_assert!(line.progress(at).1 < 1e-6 && line.length_m() >= 149.0);
                prop_assert!(area.contains(line.start, 1e-6) && area.contains(line.end, 1e-6));
            }
        }
    }

    #[test]
    fn a_line_is_not_shortened_below_its_least_length() {
        let line = Line {
            start: EastNorth::new(0.0, 0.0),
            end: EastNorth::new(200.0, 0.0),
        };
        let shorter = line.shortened(50.0, 60.0).unwrap();
        assert_eq!((shorter.start.east_m, shorter.end.east_m), (50.0, 150.0));
        assert_eq!(shorter.shortened(50.0, 60.0), None);
    }
}
