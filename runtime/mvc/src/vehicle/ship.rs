use backseat_units::math::sin_cos;
use backseat_units::{EastNorth, LocalFrame};

use crate::file::{ShipConfig, ShipSide};

/// A beam whose end is closer than this to the plane of a plate ends at that plate, metres.
const SAME_PLATE_M: f64 = 1e-6;

/// A ship at rest in the world's frame: a box without a top.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ship {
    centre: EastNorth,
    /// Degrees from the frame's north.
    heading_deg: f64,
    sin: f64,
    cos: f64,
    half_length_m: f64,
    half_beam_m: f64,
    draft_m: f64,
    side: ShipSide,
}

impl Ship {
    pub(crate) fn new(config: &ShipConfig, frame: &LocalFrame) -> Self {
        let centre = EastNorth::new(config.east_m, config.north_m);
        let heading_deg = config.heading_deg - frame.convergence_deg(frame.to_position(centre));
        let (sin, cos) = sin_cos(heading_deg.to_radians());
        Self {
            centre,
            heading_deg,
            sin,
            cos,
            half_length_m: config.length_m / 2.0,
            half_beam_m: config.beam_m / 2.0,
            draft_m: config.draft_m,
            side: config.side,
        }
    }

    /// Midships of the inspected side, at the waterline.
    pub(crate) fn reference(&self) -> EastNorth {
        self.centre.offset(self.inward_deg(), -self.half_beam_m)
    }

    /// The direction straight into the inspected side, degrees from the frame's north.
    pub(crate) fn inward_deg(&self) -> f64 {
        match self.side {
            ShipSide::Starboard => self.heading_deg - 90.0,
            ShipSide::Port => self.heading_deg + 90.0,
        }
    }

    /// The distance of a place from the plane of the inspected side, metres, if a beam from there that is `range_m`
    /// long and ends at the ship ends at that side. `direction` is a unit vector east, north, down.
    pub(crate) fn off_side_m(&self, at: EastNorth, direction: (f64, f64, f64), range_m: f64) -> Option<f64> {
        let (inward_east, inward_north) = match self.side {
            ShipSide::Starboard => (-self.cos, self.sin),
            ShipSide::Port => (self.cos, -self.sin),
        };
        let from = at - self.reference();
        let off_m = -(from.east_m * inward_east + from.north_m * inward_north);
        let reaches_m = range_m * (direction.0 * inward_east + direction.1 * inward_north);
        // A beam that ends at another plate reaches less far, or farther.
        (off_m > 0.0 && (reaches_m - off_m).abs() < SAME_PLATE_M).then_some(reaches_m)
    }

    /// Distance from the hull, metres, negative inside, and the unit vector directly away from the hull (east, north,
    /// down).
    ///
    /// The signed distance of a box (Ericson, *Real-Time Collision Detection*, 2004, section 5.1). It is a convex
    /// function of the place, so a step that does not approach along that vector comes no closer.
    pub(crate) fn clearance(&self, at: EastNorth, depth_m: f64) -> (f64, (f64, f64, f64)) {
        let from = at - self.centre;
        let ahead_m = from.east_m * self.sin + from.north_m * self.cos;
        let starboard_m = from.east_m * self.cos - from.north_m * self.sin;
        let beyond = [
            ahead_m.abs() - self.half_length_m,
            starboard_m.abs() - self.half_beam_m,
            depth_m - self.draft_m,
        ];
        let outside = beyond.map(|metres| metres.max(0.0));
        let squared = outside.iter().map(|metres| metres * metres).sum::<f64>();
        let (clearance_m, away) = if squared > 0.0 {
            let clearance_m = squared.sqrt();
            (clearance_m, outside.map(|metres| metres / clearance_m))
        } else {
            // Inside, the vector leads out through the nearest face.
            let greatest = beyond[0].max(beyond[1]).max(beyond[2]);
            (greatest, beyond.map(|metres| f64::from(u8::from(metres >= greatest))))
        };
        let ahead = away[0] * sign(ahead_m);
        let starboard = away[1] * sign(starboard_m);
        (
            clearance_m,
            (
                ahead * self.sin + starboard * self.cos,
                ahead * self.cos - starboard * self.sin,
                away[2],
            ),
        )
    }

    /// Distance from a place outside the ship to its plating under water along a direction (a unit vector east, north,
    /// down), metres. `None` if the direction misses the ship.
    ///
    /// The part of a line inside a box is the intersection of its parts inside the box's slabs (Ericson, section
    /// 5.3.3).
    pub(crate) fn ahead_m(&self, at: EastNorth, depth_m: f64, direction: (f64, f64, f64)) -> Option<f64> {
        let from = at - self.centre;
        let (east, north, down) = direction;
        let ahead_m = from.east_m * self.sin + from.north_m * self.cos;
        let starboard_m = from.east_m * self.cos - from.north_m * self.sin;
        let (mut enters_m, mut leaves_m) = (0.0_f64, f64::INFINITY);
        for (place_m, way, least_m, most_m) in [
            (
                ahead_m,
                east * self.sin + north * self.cos,
                -self.half_length_m,
                self.half_length_m,
            ),
            (
                starboard_m,
                east * self.cos - north * self.sin,
                -self.half_beam_m,
                self.half_beam_m,
            ),
            (depth_m, down, 0.0, self.draft_m),
        ] {
            if way == 0.0 {
                if !(least_m..=most_m).contains(&place_m) {
                    return None;
                }
                continue;
            }
            let (one_m, other_m) = ((least_m - place_m) / way, (most_m - place_m) / way);
            enters_m = enters_m.max(one_m.min(other_m));
            leaves_m = leaves_m.min(one_m.max(other_m));
        }
        (enters_m > 0.0 && enters_m <= leaves_m).then_some(enters_m)
    }
}

const fn sign(value: f64) -> f64 {
    if value < 0.0 { -1.0 } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use backseat_units::Position;

    use super::*;

    fn ship(side: ShipSide) -> Ship {
        let frame = LocalFrame::new(Position::from_deg(42.3, -70.9).unwrap());
        let config = ShipConfig {
            east_m: 0.0,
            north_m: 0.0,
            heading_deg: 90.0,
            length_m: 40.0,
            beam_m: 10.0,
            draft_m: 5.0,
            side,
        };
        Ship::new(&config, &frame)
    }

    #[test]
    fn the_distance_is_to_the_nearest_plate() {
        let ship = ship(ShipSide::Starboard);
        for (east, north, depth, clearance) in [
            (0.0, -8.0, 2.0, 3.0),
            (0.0, 7.0, 0.0, 2.0),
            (23.0, -9.0, 0.0, 5.0),
            (0.0, 0.0, 9.0, 4.0),
            (0.0, -8.0, 9.0, 5.0),
            (0.0, -4.0, 1.0, -1.0),
            (0.0, 0.0, 4.5, -0.5),
        ] {
            let (found, away) = ship.clearance(EastNorth::new(east, north), depth);
            assert!((found - clearance).abs() < 1e-9, "{east} {north} {depth}: {found}");
            let length = away.0 * away.0 + away.1 * away.1 + away.2 * away.2;
            assert!((length - 1.0).abs() < 1e-9, "{away:?}");
            let next = EastNorth::new(east + 0.01 * away.0, north + 0.01 * away.1);
            let (farther, _) = ship.clearance(next, depth + 0.01 * away.2);
            assert!((farther - found - 0.01).abs() < 1e-9, "{east} {north} {depth}");
        }
    }

    #[test]
    fn a_beam_ends_at_the_first_plate_or_misses() {
        let ship = ship(ShipSide::Starboard);
        let slant = (0.0, 0.6, 0.8);
        for (east, north, depth, direction, ahead) in [
            (0.0, -8.0, 2.0, (0.0, 1.0, 0.0), Some(3.0)),
            (0.0, -8.0, 2.0, (0.0, -1.0, 0.0), None),
            (0.0, -8.0, 6.0, (0.0, 1.0, 0.0), None),
            (21.0, -8.0, 2.0, (0.0, 1.0, 0.0), None),
            (0.0, -6.2, 2.0, slant, Some(2.0)),
            (0.0, -8.0, 2.0, slant, None),
            // The beam reaches the surface before it reaches the ship.
            (0.0, -8.0, 2.0, (0.0, 0.6, -0.8), None),
            (3.0, 1.0, 9.0, (0.0, 0.0, -1.0), Some(4.0)),
        ] {
            let found = ship.ahead_m(EastNorth::new(east, north), depth, direction);
            assert_eq!(
                found.map(|metres: f64| (metres * 1e6).round() / 1e6),
                ahead,
                "{east} {north} {depth} {direction:?}"
            );
        }
    }

    #[test]
    fn a_beam_tells_the_distance_of_the_side_that_it_meets() {
        let slant = (0.6, 0.8, 0.0);
        for (side, at, direction, off) in [
            (ShipSide::Starboard, (0.0, -8.0), (0.0, 1.0, 0.0), Some(3.0)),
            (ShipSide::Starboard, (0.0, -8.0), slant, Some(3.0)),
            // It ends at the stern.
            (ShipSide::Starboard, (-22.0, -6.0), slant, None),
            (ShipSide::Port, (0.0, 9.0), (0.0, -1.0, 0.0), Some(4.0)),
            // This side is not the inspected one.
            (ShipSide::Port, (0.0, -8.0), (0.0, 1.0, 0.0), None),
        ] {
            let (ship, at) = (ship(side), EastNorth::new(at.0, at.1));
            let range_m = ship.ahead_m(at, 2.0, direction).expect("it meets the ship");
            let found = ship.off_side_m(at, direction, range_m);
            let found = found.map(|metres| (metres * 1e6).round() / 1e6);
            assert_eq!(found, off, "{side:?} {at:?} {direction:?}");
        }
    }

    #[test]
    fn positions_count_from_the_side_that_is_inspected() {
        // The bow points east, so starboard is south.
        let starboard = ship(ShipSide::Starboard);
        assert!(starboard.reference().distance_m(EastNorth::new(0.0, -5.0)) < 1e-9);
        assert!((starboard.inward_deg() - 0.0).abs() < 1e-9);
        let port = ship(ShipSide::Port);
        assert!(port.reference().distance_m(EastNorth::new(0.0, 5.0)) < 1e-9);
        assert!((port.inward_deg() - 180.0).abs() < 1e-9);
    }
}
