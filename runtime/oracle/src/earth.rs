//! The ellipsoid of WGS84, in three dimensions.
//!
//! A line between two places is the straight one through the earth, seen from above. Its points lie under the normal
//! section of the ellipsoid, and over the size of a fence no geodesic leaves that section by a centimetre. The oracle
//! uses no projection, so it cannot make the same error of projection as the runtime.

/// Semi-major axis, metres, and first eccentricity squared (NIMA TR8350.2, tables 3.1 and 3.3).
pub(crate) const SEMI_MAJOR_AXIS_M: f64 = 6_378_137.0;
pub(crate) const E2: f64 = 6.694_379_990_14e-3;
/// Mean radius, metres, for terms that are small already.
const MEAN_RADIUS_M: f64 = 6_371_000.0;

/// A place on the earth, in degrees of WGS84. A position with a NaN lies nowhere.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Position {
    /// North, degrees.
    pub latitude_deg: f64,
    /// East, degrees.
    pub longitude_deg: f64,
}

/// A straight line between two places.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    ends: [Position; 2],
    from_m: [f64; 3],
    along_m: [f64; 3],
}

impl Line {
    pub(crate) fn between(from: Position, to: Position) -> Self {
        let (from_m, to_m) = (from_centre_m(from), from_centre_m(to));
        Self {
            ends: [from, to],
            from_m,
            along_m: [to_m[0] - from_m[0], to_m[1] - from_m[1], to_m[2] - from_m[2]],
        }
    }

    /// Its length on the surface, metres: that of the chord, plus the difference to its arc.
    pub(crate) fn length_m(&self) -> f64 {
        let [x, y, z] = self.along_m;
        let chord_m = (x * x + y * y + z * z).sqrt();
        let half = chord_m / (2.0 * MEAN_RADIUS_M);
        chord_m * (1.0 + half * half / 6.0)
    }

    /// A place on the line, from 0 at its begin to 1 at its end.
    pub(crate) fn at(&self, part: f64) -> Position {
        let [from, to] = self.ends;
        if part <= 0.0 {
            from
        } else if part >= 1.0 {
            to
        } else {
            above([0, 1, 2].map(|axis| self.from_m[axis] + self.along_m[axis] * part))
        }
    }
}

/// Wraps an angle into -180 to 180 degrees.
pub(crate) fn wrap_180(deg: f64) -> f64 {
    if (-180.0..180.0).contains(&deg) {
        return deg;
    }
    deg - 360.0 * ((deg + 180.0) / 360.0).floor()
}

/// The vector from the earth's centre to a place, metres: towards the Greenwich meridian, towards 90 E, along the axis.
fn from_centre_m(position: Position) -> [f64; 3] {
    let (sin, cos) = libm::sincos(position.latitude_deg.to_radians());
    let (sin_east, cos_east) = libm::sincos(position.longitude_deg.to_radians());
    let normal_m = SEMI_MAJOR_AXIS_M / (1.0 - E2 * sin * sin).sqrt();
    [
        normal_m * cos * cos_east,
        normal_m * cos * sin_east,
        normal_m * (1.0 - E2) * sin,
    ]
}

/// The place on the surface above or below a point: Bowring, "Transformation from spatial to geographical coordinates",
/// Survey Review 181 (1976), which is exact to a micrometre so near to the surface.
fn above([x, y, z]: [f64; 3]) -> Position {
    let flat = (1.0 - E2).sqrt();
    let across_m = (x * x + y * y).sqrt();
    let (sin, cos) = libm::sincos(libm::atan2(z, across_m * flat));
    let second = E2 / (1.0 - E2);
    let up_m = z + second * SEMI_MAJOR_AXIS_M * flat * sin * sin * sin;
    let out_m = across_m - E2 * SEMI_MAJOR_AXIS_M * cos * cos * cos;
    Position {
        latitude_deg: libm::atan2(up_m, out_m).to_degrees(),
        longitude_deg: libm::atan2(y, x).to_degrees(),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const fn position(latitude_deg: f64, longitude_deg: f64) -> Position {
        Position {
            latitude_deg,
            longitude_deg,
        }
    }

    /// Vincenty's inverse, Survey Review 176 (1975): metres along the geodesic.
    fn geodesic_m(a: Position, b: Position) -> f64 {
        const F: f64 = 1.0 / 298.257_223_563;
        let minor_m = SEMI_MAJOR_AXIS_M * (1.0 - F);
        let reduced = |deg: f64| libm::atan((1.0 - F) * libm::tan(deg.to_radians()));
        let ((sin1, cos1), (sin2, cos2)) = (
            libm::sincos(reduced(a.latitude_deg)),
            libm::sincos(reduced(b.latitude_deg)),
        );
        let east = wrap_180(b.longitude_deg - a.longitude_deg).to_radians();
        let mut lambda = east;
        for _ in 0..100 {
            let (sin_l, cos_l) = libm::sincos(lambda);
            let (p, q) = (cos2 * sin_l, cos1 * sin2 - sin1 * cos2 * cos_l);
            let sin_s = (p * p + q * q).sqrt();
            if sin_s == 0.0 {
                return 0.0;
            }
            let cos_s = sin1 * sin2 + cos1 * cos2 * cos_l;
            let sigma = libm::atan2(sin_s, cos_s);
            let sin_a = cos1 * cos2 * sin_l / sin_s;
            let cos_a2 = 1.0 - sin_a * sin_a;
            let cos_2m = if cos_a2 == 0.0 {
                0.0
            } else {
                cos_s - 2.0 * sin1 * sin2 / cos_a2
            };
            let c = F / 16.0 * cos_a2 * (4.0 + F * (4.0 - 3.0 * cos_a2));
            let next = east
                + (1.0 - c) * F * sin_a * (sigma + c * sin_s * (cos_2m + c * cos_s * (2.0 * cos_2m * cos_2m - 1.0)));
            let done = (next - lambda).abs() < 1e-14;
            lambda = next;
            if done {
                let u2 = cos_a2 * (SEMI_MAJOR_AXIS_M * SEMI_MAJOR_AXIS_M - minor_m * minor_m) / (minor_m * minor_m);
                let big_a = 1.0 + u2 / 16384.0 * (4096.0 + u2 * (-768.0 + u2 * (320.0 - 175.0 * u2)));
                let big_b = u2 / 1024.0 * (256.0 + u2 * (-128.0 + u2 * (74.0 - 47.0 * u2)));
                let delta = big_b
                    * sin_s
                    * (cos_2m
                        + big_b / 4.0
                            * (cos_s * (2.0 * cos_2m * cos_2m - 1.0)
                                - big_b / 6.0 * cos_2m * (4.0 * sin_s * sin_s - 3.0) * (4.0 * cos_2m * cos_2m - 3.0)));
                return minor_m * big_a * (sigma - delta);
            }
        }
        f64::NAN
    }

    #[test]
    fn lengths_agree_with_published_ones() {
        // A degree of latitude and of longitude at 45 N, by the tables of the ellipsoid: 111,131.745 m and 78,846.835
        // m.
        let north_m = Line::between(position(44.5, 3.0), position(45.5, 3.0)).length_m();
        assert!((north_m - 111_131.745).abs() < 0.5, "{north_m}");
        let hundredth_m = Line::between(position(45.0, 3.0), position(45.0, 3.01)).length_m();
        assert!((hundredth_m - 788.468_35).abs() < 0.001, "{hundredth_m}");
        // Flinders Peak to Buninyon, the example of Geoscience Australia for GDA94: 54,972.271 m.
        let dms = |deg: f64, min: f64, sec: f64| deg + min / 60.0 + sec / 3600.0;
        let flinders = position(-dms(37.0, 57.0, 3.720_30), dms(144.0, 25.0, 29.524_40));
        let buninyon = position(-dms(37.0, 39.0, 10.156_10), dms(143.0, 55.0, 35.383_90));
        let length_m = Line::between(flinders, buninyon).length_m();
        assert!((length_m - 54_972.271).abs() < 0.01, "{length_m}");
        assert!((geodesic_m(flinders, buninyon) - 54_972.271).abs() < 0.001);
    }

    #[test]
    fn a_nan_position_has_no_length_and_does_not_panic() {
        let nowhere = position(f64::NAN, f64::INFINITY);
        let line = Line::between(nowhere, position(0.0, 0.0));
        assert!(line.length_m().is_nan() && line.at(0.5).latitude_deg.is_nan());
        for deg in [-540.0, -180.0, 180.0, 540.0, 900.0] {
            assert_eq!(wrap_180(deg), -180.0);
        }
        assert_eq!(wrap_180(190.0), -170.0);
    }

    proptest! {
        /// Over 25 km, lengths agree with those of geodesics, and every point of a line lies on the geodesic, to a
        /// centimetre.
        #[test]
        fn lines_are_geodesics_to_a_centimetre(
            latitude in -80.0..80.0f64, longitude in -180.0..180.0f64,
            north in -0.15..0.15f64, east in -0.15..0.15f64, part in 0.0..1.0f64,
        ) {
            let (_, cos) = libm::sincos(latitude.to_radians());
            let from = position(latitude, longitude);
            let to = position(latitude + north, wrap_180(longitude + east / cos));
            let line = Line::between(from, to);
            let length_m = geodesic_m(from, to);
            prop_assert!((line.length_m() - length_m).abs() < 0.01, "{} {length_m}", line.length_m());
            let middle = line.at(part);
            let detour_m = geodesic_m(from, middle) + geodesic_m(middle, to) - length_m;
            // A point beside the line makes the way longer by the square of its distance.
            let (a, b) = (part * length_m, (1.0 - part) * length_m);
            let beside_m = (2.0 * detour_m.max(0.0) * a * b / (a + b)).sqrt();
            prop_assert!(beside_m < 0.02 || detour_m < 3e-9, "{beside_m} {detour_m}");
            prop_assert!((geodesic_m(from, middle) - a).abs() < 0.01);
        }
    }
}
