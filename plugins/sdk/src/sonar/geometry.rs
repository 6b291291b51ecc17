//! The geometry of a ping over a level seabed (Blondel, *The Handbook of Sidescan Sonar*, Springer 2009, chapter 2).

use super::look::{Look, Side};

/// How many pieces the samples of a side become in the search for the first return.
const PIECES: usize = 256;
/// These pieces belong to the transmission.
const BLANK: usize = PIECES * 3 / 100;

/// Ground range of a slant range over a level seabed, metres. `None` nearer than the seabed: water column.
#[must_use]
pub fn ground_m(slant_m: f64, altitude_m: f64) -> Option<f64> {
    let square = slant_m * slant_m - altitude_m * altitude_m;
    (square >= 0.0).then(|| square.sqrt())
}

/// Slant range of a ground range over a level seabed, metres.
#[must_use]
pub fn slant_m(ground_m: f64, altitude_m: f64) -> f64 {
    (ground_m * ground_m + altitude_m * altitude_m).sqrt()
}

/// Height of an object above a level seabed by the length of its shadow, metres: `h = H Ls / (R + Ls)`, with the
/// altitude `H`, the slant range `R` to where the shadow begins and the length `Ls` of the shadow along the slant
/// range. The ray over the top of the object, the sonar and the seabed make two similar triangles.
#[must_use]
pub fn shadow_height_m(altitude_m: f64, slant_m: f64, shadow_m: f64) -> f64 {
    let end_m = slant_m + shadow_m;
    if end_m > 0.0 {
        altitude_m * shadow_m / end_m
    } else {
        0.0
    }
}

/// Slant range of the first return in the imagery, metres: the altitude, if the seabed below is the nearest thing. The
/// nearer side counts. `None` if nothing stands out.
///
/// The samples of a side become 256 pieces of their maximum, without the first 3 %, which belong to the transmission.
/// The seabed begins at the first piece that reaches a quarter of the greatest, if the piece behind it reaches an
/// eighth: a single piece is a fish, or noise.
#[must_use]
pub fn first_return_m(look: &Look<'_>) -> Option<f64> {
    let mut nearest: Option<f64> = None;
    for side in Side::BOTH {
        let Some(strip) = look.side(side).filter(|strip| !strip.over_ground) else {
            continue;
        };
        let count = strip.samples.len();
        let pieces = PIECES.min(count);
        let mut greatest = [0.0_f32; PIECES];
        for (piece, greatest) in greatest[..pieces].iter_mut().enumerate() {
            let samples = &strip.samples[piece * count / pieces..(piece + 1) * count / pieces];
            *greatest = samples
                .iter()
                .copied()
                .filter(|sample| sample.is_finite())
                .fold(0.0, f32::max);
        }
        let blank = BLANK.min(pieces);
        let most = greatest[blank..pieces].iter().copied().fold(0.0, f32::max);
        let found = (blank..pieces.saturating_sub(1))
            .find(|piece| most > 0.0 && greatest[*piece] >= 0.25 * most && greatest[piece + 1] >= 0.125 * most);
        if let Some(piece) = found {
            let begin_m = strip.start_m + (strip.end_m - strip.start_m) * piece as f64 / pieces as f64;
            nearest = Some(nearest.map_or(begin_m, |other| other.min(begin_m)));
        }
    }
    nearest.filter(|slant_m| *slant_m > 0.0)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::sonar::{Pose, Strip};

    proptest! {
        #[test]
        fn slant_and_ground_range_are_inverse(ground in 0.0..300.0_f64, altitude in 0.5..100.0_f64) {
            let back = ground_m(slant_m(ground, altitude), altitude).unwrap();
            prop_assert!((back - ground).abs() < 1e-5, "{back} {ground}");
        }

        #[test]
        fn nothing_is_nearer_than_the_seabed(part in 0.0..0.999_f64, altitude in 0.5..100.0_f64) {
            prop_assert_eq!(ground_m(part * altitude, altitude), None);
        }

        /// The ray over the top of an upright object meets the seabed where similar triangles say.
        #[test]
        fn a_shadow_gives_back_the_height(
            ground in 1.0..150.0_f64, altitude in 2.0..60.0_f64, part in 0.01..0.9_f64,
        ) {
            let height = part * altitude;
            let top = (ground * ground + (altitude - height) * (altitude - height)).sqrt();
            let end = slant_m(ground * altitude / (altitude - height), altitude);
            prop_assert!((shadow_height_m(altitude, top, end - top) - height).abs() < 1e-9 * altitude);
        }

        #[test]
        fn any_samples_give_a_range_inside_or_none(samples in prop::collection::vec(prop::num::f32::ANY, 0..600)) {
            let strip = Strip::along_slant(&samples, 50.0);
            let pose = Pose {
                at: Default::default(), latitude_deg: 0.0, longitude_deg: 0.0, heading_deg: 0.0, altitude_m: None,
            };
            let look = Look { pose, port: Some(strip), starboard: None };
            if let Some(range) = first_return_m(&look) {
                prop_assert!((0.0..50.0).contains(&range));
            }
        }
    }

    #[test]
    fn the_first_return_is_where_the_water_column_ends() {
        let mut samples = vec![0.5_f32; 1000];
        samples[..20].fill(90.0);
        samples[120] = 80.0;
        for (index, sample) in samples.iter_mut().enumerate().skip(200) {
            *sample = 60.0 - 0.05 * index as f32;
        }
        let pose = Pose {
            at: Default::default(),
            latitude_deg: 0.0,
            longitude_deg: 0.0,
            heading_deg: 0.0,
            altitude_m: None,
        };
        let strip = Strip::along_slant(&samples, 50.0);
        let look = Look {
            pose,
            port: Some(strip),
            starboard: None,
        };
        let found = first_return_m(&look).unwrap();
        assert!((found - 10.0).abs() < 0.25, "the fish at 6 m does not count: {found}");
    }
}
