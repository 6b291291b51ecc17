//! The ways back of a vehicle that was led away. It does not steer to one of the ends of a line, but to the line itself
//! (safety requirement 002).

use backseat_fence::Shape;
use backseat_units::EastNorth;
use backseat_units::math::{asin, atan2, cos, sin_cos};

/// The widest range of directions that one solid covers, degrees.
const FAN_MAX_DEG: f64 = 20.0;

/// A line that the vehicle follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Track {
    /// From one point to another.
    Line(EastNorth, EastNorth),
    Approach(Approach),
}

/// The way from where a behavior began to where its path begins. Only the vehicle knows both places exactly. Core knows
/// the first as precisely as navigation does. The second lies between two points, because the length of a lead-in, or
/// where the vehicle enters a circle, is not known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Approach {
    pub(crate) begun: EastNorth,
    /// How far from there it may have begun, metres.
    pub(crate) within_m: f64,
    pub(crate) to: [EastNorth; 2],
}

impl Track {
    /// The points that it lies between.
    pub(crate) fn points(&self) -> impl Iterator<Item = EastNorth> + use<> {
        let [a, b, c] = match *self {
            Self::Line(start, end) => [start, end, end],
            Self::Approach(Approach { begun, to: [a, b], .. }) => [begun, a, b],
        };
        [a, b, c].into_iter()
    }

    /// How far from its points it may begin, metres.
    pub(crate) const fn within_m(&self) -> f64 {
        match self {
            Self::Line(..) => 0.0,
            Self::Approach(approach) => approach.within_m,
        }
    }

    /// Solids that contain every way from anywhere between some points onto the track, and along it to its end. A
    /// vehicle behind the start meets the extension of the line abeam of itself.
    pub(super) fn onto(&self, vehicle: &[EastNorth]) -> Vec<Shape> {
        match self {
            Self::Line(start, end) => onto_line(vehicle, (*start, *end)),
            Self::Approach(approach) => approach.onto(vehicle),
        }
    }
}

impl Approach {
    /// The directions in which the way may lead: the first one, and how far the others extend from it to the right,
    /// both in degrees.
    fn directions_deg(&self) -> (f64, f64) {
        let [a, b] = self.to.map(|to| to - self.begun);
        let square_m2 = |to: EastNorth| to.east_m * to.east_m + to.north_m * to.north_m;
        // The point between `a` and `b` that is nearest to the begin.
        let along = b - a;
        let share = -(a.east_m * along.east_m + a.north_m * along.north_m) / square_m2(along);
        let nearest_m2 = if share > 0.0 && share < 1.0 {
            square_m2(a + along * share)
        } else {
            square_m2(a).min(square_m2(b))
        };
        let sine = self.within_m / nearest_m2.sqrt();
        // So near to the begin every direction is possible. NaN is treated alike.
        if sine.is_nan() || sine > 0.7 {
            return (0.0, 360.0);
        }
        let around_deg = asin(sine).to_degrees();
        let bearing_deg = |to: EastNorth| atan2(to.east_m, to.north_m).to_degrees();
        let right = a.north_m * b.east_m - a.east_m * b.north_m >= 0.0;
        let (left, right) = if right { (a, b) } else { (b, a) };
        let span_deg = (bearing_deg(right) - bearing_deg(left)).rem_euclid(360.0);
        // Rounding may make two equal directions differ by a whole turn.
        let span_deg = if span_deg > 359.0 { 0.0 } else { span_deg };
        (bearing_deg(left) - around_deg, span_deg + 2.0 * around_deg)
    }

    /// Solids that contain every way from anywhere between the vehicle's places onto the approach, one for each range
    /// of directions.
    ///
    /// Take the feet of the perpendiculars from a place of the vehicle onto all lines through one point. They lie on
    /// the circle whose diameter is the way from the place to the point (Thales). Seen from the centre of that circle,
    /// two feet are twice as many degrees apart as their lines. So a solid contains the feet on every line between two
    /// lines if it contains the feet on these two, moved outwards from the centre until the chord between them touches
    /// the circle.
    fn onto(&self, vehicle: &[EastNorth]) -> Vec<Shape> {
        let (first_deg, span_deg) = self.directions_deg();
        let count = (span_deg / FAN_MAX_DEG).ceil().max(1.0);
        let step_deg = span_deg / count;
        let outwards = 1.0 / cos(step_deg.to_radians());
        let mut solids = Vec::new();
        let mut fan = 0.0;
        while fan < count {
            let sides = [first_deg + fan * step_deg, first_deg + (fan + 1.0) * step_deg].map(|deg| {
                let (east, north) = sin_cos(deg.to_radians());
                EastNorth::new(east, north)
            });
            let feet = |place: EastNorth| {
                let off = place - self.begun;
                let along_m = sides.map(|side| (off.east_m * side.east_m + off.north_m * side.north_m).min(0.0));
                if along_m == [0.0, 0.0] {
                    return [self.begun; 2];
                }
                let middle = (place + self.begun) * 0.5;
                let taken_out =
                    |side: EastNorth, along_m: f64| middle + (self.begun + side * along_m - middle) * outwards;
                [taken_out(sides[0], along_m[0]), taken_out(sides[1], along_m[1])]
            };
            let mut points = vec![self.begun, self.to[0], self.to[1]];
            points.extend(vehicle.iter().flat_map(|place| {
                let [left, right] = feet(*place);
                [*place, left, right]
            }));
            solids.extend(Shape::convex_hulls(&points));
            fan += 1.0;
        }
        solids
    }
}

fn onto_line(vehicle: &[EastNorth], (start, end): (EastNorth, EastNorth)) -> Vec<Shape> {
    let line = end - start;
    let square_m2 = line.east_m * line.east_m + line.north_m * line.north_m;
    let along = |point: &EastNorth| {
        let from = *point - start;
        (from.east_m * line.east_m + from.north_m * line.north_m) / square_m2
    };
    let behind = vehicle.iter().map(along).fold(0.0, f64::min);
    let first = start + line * behind;
    if let [here, ahead] = *vehicle {
        return vec![Shape::quadrilateral([here, ahead, first, end])];
    }
    let points = vehicle.iter().copied().chain([first, end]);
    Shape::convex_hulls(&points.collect::<Vec<_>>())
}

#[cfg(test)]
mod tests;
