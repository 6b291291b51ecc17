//! The targets of a world, as the fan of a sidescan sonar meets them.

use backseat_units::EastNorth;
use backseat_units::math::{hypot, sin_cos};
use backseat_world::{Target, TargetKind, World};

use super::bed::{Bed, Fan};
use crate::level::power_of;

/// Targets are kept by size, so that one large target does not widen the search for the small ones: half of the length
/// from corner to corner, metres.
const SIZES_M: [f64; 3] = [5.0, 50.0, f64::MAX];
/// How far off the axis a target still echoes, in widths of the beam.
const REACH: f64 = 1.2;
/// The heights of a target are taken at this many places along the fan.
const PLACES: usize = 9;

#[derive(Clone, Copy, Debug)]
pub(super) struct Object {
    kind: TargetKind,
    at: EastNorth,
    half_length_m: f64,
    half_width_m: f64,
    height_m: f64,
    heading: EastNorth,
    radius_m: f64,
    /// Its target strength, square metres at 1 m.
    pub(super) strength_m2: f64,
}

impl Object {
    fn new(target: &Target) -> Self {
        let (sin, cos) = sin_cos(target.heading_deg.to_radians());
        let (half_length_m, half_width_m) = (0.5 * target.length_m, 0.5 * target.width_m);
        let is_point = target.kind == TargetKind::Point;
        Self {
            kind: target.kind,
            at: target.at,
            half_length_m,
            half_width_m,
            height_m: target.height_m,
            heading: EastNorth::new(sin, cos),
            radius_m: if is_point {
                0.0
            } else {
                hypot(half_length_m, half_width_m)
            },
            strength_m2: power_of(target.strength_db),
        }
    }

    /// Its height at a place, given along and across its heading in halves of its length and width.
    fn height_at_m(&self, along: f64, across: f64) -> f64 {
        let round = |square: f64| (1.0 - square).max(0.0).sqrt();
        self.height_m
            * match self.kind {
                TargetKind::Point => 0.0,
                TargetKind::Rock => round(along * along + across * across),
                TargetKind::Cylinder => round(across * across),
                TargetKind::Box => 1.0,
                // A hull with a superstructure, which stands elsewhere on each wreck.
                TargetKind::Wreck => {
                    let phase = (0.37 * self.at.east_m + 0.59 * self.at.north_m).abs();
                    let wave = 2.0 * ((0.8 * along + phase).abs().fract() - 0.5).abs();
                    round(across * across) * (0.6 + 0.4 * wave)
                }
            }
    }
}

/// A place on a target's surface, or the seabed at its foot: outwards and below the sonar, metres.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Place {
    pub(super) out_m: f64,
    pub(super) below_m: f64,
}

impl Place {
    pub(super) fn slant_m(self) -> f64 {
        hypot(self.out_m, self.below_m)
    }

    /// Whether a ray from the sonar to this place clears another place nearer to the vertical.
    pub(super) fn clears(self, nearer: Self) -> bool {
        self.out_m * nearer.below_m >= nearer.out_m * self.below_m
    }
}

/// What the fan meets of a target.
#[derive(Clone, Copy, Debug)]
pub(super) struct Met {
    pub(super) strength_m2: f64,
    /// The seabed at its near edge.
    pub(super) foot: Place,
    /// The last place on it that sound reaches.
    pub(super) apex: Place,
    /// Least and greatest slant range of the places that sound reaches, metres.
    pub(super) slants_m: (f64, f64),
    /// Its middle, metres ahead of the axis of the beam, and how far it reaches from there along track.
    ahead_m: f64,
    half_m: f64,
    pub(super) has_shadow: bool,
}

impl Met {
    /// The part of the target's strength that echoes: what the beam, transmitting and receiving, has at its nearest
    /// edge, and the part of its length that is in the beam.
    pub(super) fn insonified(&self, along_rad: f64, equivalent_rad: f64) -> f64 {
        let slant_m = self.slants_m.0.max(1e-3);
        let off_m = (self.ahead_m.abs() - self.half_m).max(0.0);
        let part = (equivalent_rad * slant_m / (2.0 * self.half_m).max(1e-9)).min(1.0);
        part * crate::beam::two_way(off_m / slant_m, along_rad)
    }

    /// The part of the beam that it hides, 0 to 1.
    pub(super) fn hides(&self, along_rad: f64) -> f64 {
        let half_beam_m = 0.5 * along_rad * self.apex.slant_m().max(1e-3);
        let ahead = (self.ahead_m + self.half_m).min(half_beam_m);
        let astern = (self.ahead_m - self.half_m).max(-half_beam_m);
        ((ahead - astern) / (2.0 * half_beam_m)).clamp(0.0, 1.0)
    }
}

/// The targets of a world, by size, each size sorted from west to east.
#[derive(Clone, Debug)]
pub(super) struct Objects([Vec<Object>; 3]);

/// A target near the fan, and where its middle is: metres ahead of it and to starboard.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    object: Object,
    ahead_m: f64,
    starboard_m: f64,
}

impl Objects {
    pub(super) fn new(world: &World) -> Self {
        let mut sizes = [const { Vec::new() }; 3];
        for object in world.targets().iter().map(Object::new) {
            let size = SIZES_M
                .iter()
                .position(|most_m| object.radius_m <= *most_m)
                .unwrap_or(2);
            sizes[size].push(object);
        }
        Self(sizes)
    }

    /// Finds the targets that the fan can meet, to a distance on both sides.
    pub(super) fn near(&self, fan: &Fan, range_m: f64, along_rad: f64, found: &mut Vec<Candidate>) {
        found.clear();
        let reach_m = REACH * along_rad * range_m;
        let half_m = range_m * fan.starboard.east_m.abs() + reach_m;
        for (size, objects) in self.0.iter().enumerate() {
            let largest_m = SIZES_M[size].min(2000.0);
            let west_m = fan.origin.east_m - half_m - largest_m;
            let east_m = fan.origin.east_m + half_m + largest_m;
            let first = objects.partition_point(|object| object.at.east_m < west_m);
            for object in &objects[first..] {
                if object.at.east_m > east_m {
                    break;
                }
                let from = object.at - fan.origin;
                let ahead_m = from.east_m * fan.ahead.east_m + from.north_m * fan.ahead.north_m;
                let starboard_m = from.east_m * fan.starboard.east_m + from.north_m * fan.starboard.north_m;
                if ahead_m.abs() <= object.radius_m + reach_m && starboard_m.abs() <= object.radius_m + range_m {
                    found.push(Candidate {
                        object: *object,
                        ahead_m,
                        starboard_m,
                    });
                }
            }
        }
    }
}

impl Candidate {
    /// What the fan meets of it on one side. `None` if it is off the beam, or on the other side.
    pub(super) fn meet(&self, fan: &Fan, bed: &Bed, side: f64, along_rad: f64) -> Option<Met> {
        let object = &self.object;
        let middle_m = side * self.starboard_m;
        let slant_m = hypot(middle_m, bed.at(middle_m.max(0.0)).0);
        let heading_ahead = object.heading.east_m * fan.ahead.east_m + object.heading.north_m * fan.ahead.north_m;
        let heading_out =
            side * (object.heading.east_m * fan.starboard.east_m + object.heading.north_m * fan.starboard.north_m);
        let (length_m, width_m) = (object.half_length_m, object.half_width_m);
        let half_m = match object.kind {
            TargetKind::Point => 0.0,
            TargetKind::Rock => hypot(length_m * heading_ahead, width_m * heading_out),
            TargetKind::Cylinder | TargetKind::Box | TargetKind::Wreck => {
                length_m * heading_ahead.abs() + width_m * heading_out.abs()
            }
        };
        if self.ahead_m.abs() > half_m + REACH * along_rad * slant_m {
            return None;
        }
        if object.kind == TargetKind::Point {
            let (below_m, _, _) = bed.at(middle_m.max(0.0));
            let place = Place {
                out_m: middle_m,
                below_m,
            };
            return (middle_m >= 0.0).then_some(Met {
                strength_m2: object.strength_m2,
                foot: place,
                apex: place,
                slants_m: (slant_m, slant_m),
                ahead_m: self.ahead_m,
                half_m,
                has_shadow: false,
            });
        }
        // The line through the target that stands for the beam: its middle if that is in the beam, and else what is
        // nearest to the axis.
        let half_beam_m = 0.5 * along_rad * slant_m;
        let off_m = self.ahead_m - self.ahead_m.clamp(-half_beam_m, half_beam_m);
        let line_m = -off_m.clamp(-0.9 * half_m, 0.9 * half_m);
        // That line in halves of the target's length and width: `start` where it passes the middle, `step` a metre out.
        let start = (line_m * heading_ahead / length_m, -line_m * heading_out / width_m);
        let step = (heading_out / length_m, heading_ahead / width_m);
        let chord = if object.kind == TargetKind::Rock {
            ellipse(start, step)
        } else {
            rectangle(start, step)
        };
        let (near_m, far_m) = chord?;
        let (near_m, far_m) = ((middle_m + near_m).max(0.0), middle_m + far_m);
        if far_m <= near_m {
            return None;
        }
        let (foot_below_m, _, _) = bed.at(near_m);
        let foot = Place {
            out_m: near_m,
            below_m: foot_below_m,
        };
        let mut met = Met {
            strength_m2: object.strength_m2,
            foot,
            apex: foot,
            slants_m: (foot.slant_m(), foot.slant_m()),
            ahead_m: self.ahead_m,
            half_m,
            has_shadow: object.height_m > 0.0,
        };
        for number in 0..PLACES {
            let out_m = near_m + (far_m - near_m) * number as f64 / (PLACES - 1) as f64;
            let from_middle_m = out_m - middle_m;
            let height_m = object.height_at_m(start.0 + step.0 * from_middle_m, start.1 + step.1 * from_middle_m);
            let place = Place {
                out_m,
                below_m: bed.at(out_m).0 - height_m,
            };
            if place.clears(met.apex) {
                met.apex = place;
                let slant_m = place.slant_m();
                met.slants_m = (met.slants_m.0.min(slant_m), met.slants_m.1.max(slant_m));
            }
        }
        Some(met)
    }
}

/// Where a line crosses the square of half-side 1 about the origin.
fn rectangle(start: (f64, f64), step: (f64, f64)) -> Option<(f64, f64)> {
    let slab = |start: f64, step: f64| {
        if step.abs() < 1e-12 {
            (start.abs() <= 1.0).then_some((f64::MIN, f64::MAX))
        } else {
            let (one, other) = ((-1.0 - start) / step, (1.0 - start) / step);
            Some((one.min(other), one.max(other)))
        }
    };
    let (one, other) = (slab(start.0, step.0)?, slab(start.1, step.1)?);
    let (enter, leave) = (one.0.max(other.0), one.1.min(other.1));
    (enter < leave).then_some((enter, leave))
}

/// Where a line crosses the circle of radius 1 about the origin.
fn ellipse(start: (f64, f64), step: (f64, f64)) -> Option<(f64, f64)> {
    let a = step.0 * step.0 + step.1 * step.1;
    let half_b = start.0 * step.0 + start.1 * step.1;
    let square = half_b * half_b - a * (start.0 * start.0 + start.1 * start.1 - 1.0);
    (square > 0.0 && a > 0.0).then(|| ((-half_b - square.sqrt()) / a, (-half_b + square.sqrt()) / a))
}
