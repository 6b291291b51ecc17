//! Ways onto a line by a vehicle that steers to the line rather than to one of its ends (safety requirement 002).

use backseat_fence::Shape;
use backseat_units::EastNorth;

/// The solid that holds every such way from between two points onto a line and on to its end. Abeam of a point behind
/// the start, the vehicle comes to where the line would be there.
pub(super) fn onto([here, ahead]: [EastNorth; 2], (start, end): (EastNorth, EastNorth)) -> Shape {
    let line = end - start;
    let square_m2 = line.east_m * line.east_m + line.north_m * line.north_m;
    let along = |point: EastNorth| {
        let from = point - start;
        (from.east_m * line.east_m + from.north_m * line.north_m) / square_m2
    };
    let behind = along(here).min(along(ahead));
    let first = if behind < 0.0 { start + line * behind } else { start };
    Shape::quadrilateral([here, ahead, first, end])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(east_m: f64, north_m: f64) -> EastNorth {
        EastNorth::new(east_m, north_m)
    }

    #[test]
    fn behind_the_start_the_way_leads_to_the_line_abeam() {
        let line = (at(0.0, 0.0), at(100.0, 0.0));
        let solid = |here, ahead, first| Shape::quadrilateral([here, ahead, first, line.1]);
        let (beside, behind, farther) = (at(50.0, 30.0), at(-40.0, 30.0), at(-60.0, 20.0));
        assert_eq!(onto([beside, beside], line), solid(beside, beside, at(0.0, 0.0)));
        assert_eq!(onto([beside, behind], line), solid(beside, behind, at(-40.0, 0.0)));
        assert_eq!(onto([farther, behind], line), solid(farther, behind, at(-60.0, 0.0)));
        let point = (at(5.0, 5.0), at(5.0, 5.0));
        assert_eq!(
            onto([beside, behind], point),
            Shape::quadrilateral([beside, behind, point.0, point.1])
        );
    }
}
