use backseat_units::EastNorth;
use backseat_units::math::{sin_cos, tan, wrap_180};
use serde::{Deserialize, Serialize};

use crate::Swath;

/// What one side of a sidescan sees: from an inner to an outer distance over the ground from the track, metres. Empty if
/// the outer one is not greater.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Band {
    /// Where the gap below the vehicle ends.
    pub inner_m: f64,
    /// How far it sees.
    pub outer_m: f64,
}

impl Band {
    /// Its width, metres; 0 if it is empty.
    #[must_use]
    pub fn width_m(&self) -> f64 {
        (self.outer_m - self.inner_m).max(0.0)
    }

    /// A side of a sonar over a level bottom. `slant_m` is how far it hears along the slant, and `nadir_deg` half of the
    /// angle straight below the vehicle in which its image is no good.
    #[must_use]
    pub fn level(slant_m: f64, altitude_m: f64, nadir_deg: f64) -> Self {
        let altitude_m = altitude_m.max(0.0);
        Self {
            inner_m: gap_m(altitude_m, nadir_deg),
            outer_m: (slant_m * slant_m - altitude_m * altitude_m).max(0.0).sqrt(),
        }
    }
}

/// Half of the width of the gap below the vehicle on a level bottom, metres.
pub(super) fn gap_m(altitude_m: f64, nadir_deg: f64) -> f64 {
    altitude_m.max(0.0) * tan(nadir_deg.to_radians())
}

/// What a sidescan sees from a pose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Look {
    /// When, nanoseconds of the run.
    pub at_ns: u64,
    /// Where the vehicle is, in the local frame.
    pub at: EastNorth,
    /// Its heading, degrees clockwise from the local frame's north.
    pub bearing_deg: f64,
    /// What the port side sees.
    pub port: Band,
    /// What the starboard side sees.
    pub starboard: Band,
}

impl Look {
    /// A look by the swath that the runtime reports. This is an upper bound: it does not know what comes back. Returns
    /// `None` if the swath has no altitude, because then its gap is unknown.
    #[must_use]
    pub fn of_swath(swath: &Swath, nadir_deg: f64, at_ns: u64, at: EastNorth, bearing_deg: f64) -> Option<Self> {
        let inner_m = gap_m(swath.altitude?, nadir_deg);
        let band = |outer_m| Band { inner_m, outer_m };
        let look = Self {
            at_ns,
            at,
            bearing_deg,
            port: band(swath.port),
            starboard: band(swath.starboard),
        };
        look.is_sound().then_some(look)
    }

    /// Whether all values are finite and the bands within 2 km.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        let near = |value: f64| (0.0..=2000.0).contains(&value);
        let bands = [self.port, self.starboard];
        self.at.east_m.is_finite()
            && self.at.north_m.is_finite()
            && self.bearing_deg.is_finite()
            && bands.iter().all(|band| near(band.inner_m) && near(band.outer_m))
    }

    /// The points at the inner and outer end of a side's band: -1 for port, 1 for starboard.
    fn ends(&self, side: f64) -> [EastNorth; 2] {
        let (sin, cos) = sin_cos(self.bearing_deg.to_radians());
        let out = EastNorth::new(cos * side, -sin * side);
        let band = if side < 0.0 { self.port } else { self.starboard };
        [
            self.at + out * band.inner_m,
            self.at + out * band.outer_m.max(band.inner_m),
        ]
    }
}

/// What a sidescan has seen between two successive looks: one quadrangle a side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strip {
    /// The look at its begin.
    pub from: Look,
    /// The look at its end.
    pub to: Look,
}

impl Strip {
    /// Its length along the track, metres.
    #[must_use]
    pub fn length_m(&self) -> f64 {
        self.from.at.distance_m(self.to.at)
    }

    /// The four triangles that it is made of: two a side, and none for a side whose band is empty at both ends.
    pub(super) fn triangles(&self) -> impl Iterator<Item = [EastNorth; 3]> {
        [-1.0, 1.0].into_iter().flat_map(|side| {
            let ([from_in, from_out], [to_in, to_out]) = (self.from.ends(side), self.to.ends(side));
            let is_empty = from_in == from_out && to_in == to_out;
            [[from_in, from_out, to_out], [from_in, to_out, to_in]]
                .into_iter()
                .filter(move |_| !is_empty)
        })
    }
}

/// Makes strips of successive looks.
///
/// Looks that are too far apart make no strip, because nothing tells what was seen between them. Neither do looks
/// between which the vehicle turned fast: the beams spread on one side and cross on the other, so that an image is no
/// good there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Strips {
    turn_max_dps: f64,
    apart_max_m: f64,
    last: Option<Look>,
}

impl Strips {
    /// `turn_max_dps` is the greatest rate of turn, degrees a second, and `apart_max_m` the greatest distance between
    /// two looks, metres.
    #[must_use]
    pub const fn new(turn_max_dps: f64, apart_max_m: f64) -> Self {
        Self {
            turn_max_dps,
            apart_max_m,
            last: None,
        }
    }

    /// Takes in the next look. Returns the strip from the last one, if there is one. A look that is not newer than the
    /// last one, or that is not sound, is ignored.
    pub fn next(&mut self, look: Look) -> Option<Strip> {
        if !look.is_sound() || self.last.is_some_and(|last| look.at_ns <= last.at_ns) {
            return None;
        }
        let from = self.last.replace(look)?;
        let seconds = (look.at_ns - from.at_ns) as f64 * 1e-9;
        let turned_deg = wrap_180(look.bearing_deg - from.bearing_deg).abs();
        let strip = Strip { from, to: look };
        let is_whole = strip.length_m() <= self.apart_max_m && turned_deg <= self.turn_max_dps * seconds;
        is_whole.then_some(strip)
    }

    /// Forgets the last look, so that no strip leads from it to the next one.
    pub fn interrupt(&mut self) {
        self.last = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn look(second: u64, north_m: f64, bearing_deg: f64) -> Look {
        let band = Band {
            inner_m: 5.0,
            outer_m: 50.0,
        };
        Look {
            at_ns: second * 1_000_000_000,
            at: EastNorth::new(0.0, north_m),
            bearing_deg,
            port: band,
            starboard: band,
        }
    }

    #[test]
    fn a_level_bottom_gives_reach_and_gap_from_the_altitude() {
        let band = Band::level(50.0, 30.0, 45.0);
        assert!(
            (band.outer_m - 40.0).abs() < 1e-9 && (band.inner_m - 30.0).abs() < 1e-9,
            "{band:?}"
        );
        assert_eq!(
            Band::level(20.0, 30.0, 10.0).width_m(),
            0.0,
            "the range ends above the bottom"
        );
    }

    #[test]
    fn turns_and_pauses_make_no_strip() {
        let mut strips = Strips::new(2.0, 30.0);
        assert_eq!(strips.next(look(1, 0.0, 0.0)), None);
        assert!(strips.next(look(2, 2.0, 1.0)).is_some());
        assert_eq!(strips.next(look(2, 3.0, 1.0)), None, "the same time again");
        assert_eq!(strips.next(look(3, 4.0, 4.0)), None, "3 degrees in a second");
        assert!(strips.next(look(4, 6.0, 359.0 + 4.0)).is_some(), "across north");
        assert_eq!(strips.next(look(30, 58.0, 3.0)), None, "52 m");
        strips.interrupt();
        assert_eq!(strips.next(look(31, 60.0, 3.0)), None);
        assert_eq!(
            strips.next(Look {
                bearing_deg: f64::NAN,
                ..look(32, 61.0, 3.0)
            }),
            None
        );
    }

    #[test]
    fn port_is_to_the_left() {
        let strip = Strip {
            from: look(1, 0.0, 0.0),
            to: Look {
                port: Band::default(),
                ..look(2, 2.0, 0.0)
            },
        };
        let easts: Vec<f64> = strip.triangles().flatten().map(|at| at.east_m).collect();
        assert_eq!(
            easts,
            [-5.0, -50.0, 0.0, -5.0, 0.0, 0.0, 5.0, 50.0, 50.0, 5.0, 50.0, 5.0]
        );
    }

    #[test]
    fn a_swath_without_altitude_makes_no_look() {
        let swath = Swath {
            sensor: 1,
            number: 1,
            port: 40.0,
            starboard: 42.0,
            altitude: None,
            source: crate::AltitudeSource::GroundRange,
        };
        assert_eq!(Look::of_swath(&swath, 30.0, 1, EastNorth::default(), 0.0), None);
        let look = Look::of_swath(
            &Swath {
                altitude: Some(10.0),
                ..swath
            },
            45.0,
            1,
            EastNorth::default(),
            0.0,
        )
        .unwrap();
        assert!((look.starboard.inner_m - 10.0).abs() < 1e-9 && look.port.outer_m == 40.0);
    }
}
