/// Pressure of the air, kilopascals.
pub(super) const AIR_KPA: f64 = 101.325;
/// Pressure of a metre of sea water at 1025 kg/m3, kilopascals.
pub(super) const WATER_KPA_PER_M: f64 = 10.052;
/// Conductivity of sea water of salinity 35 at 15 degrees and at the surface, microsiemens a centimetre (Culkin and
/// Smith, 1980).
const STANDARD_US_PER_CM: f64 = 42_914.0;

/// Practical salinity, from conductivity in microsiemens a centimetre, temperature in degrees Celsius, and pressure
/// above the air's in decibars: the Practical Salinity Scale of 1978 (Fofonoff and Millard, *Algorithms for computation of fundamental properties of seawater*,
/// UNESCO Technical Papers in Marine Science 44, 1983). Kept within 0 to 42, the scale's own range.
pub(super) fn salinity(conductivity_us_per_cm: f64, temperature_c: f64, pressure_dbar: f64) -> f64 {
    let (t, p) = (temperature_c, pressure_dbar);
    let ratio = conductivity_us_per_cm / STANDARD_US_PER_CM;
    let by_temperature = 0.676_609_7 + t * (2.005_64e-2 + t * (1.104_259e-4 + t * (-6.969_8e-7 + t * 1.003_1e-9)));
    let by_pressure = 1.0
        + p * (2.070e-5 + p * (-6.370e-10 + p * 3.989e-15))
            / (1.0 + t * (3.426e-2 + t * 4.464e-4) + (4.215e-1 - 3.107e-3 * t) * ratio);
    let root = (ratio / (by_temperature * by_pressure)).max(0.0).sqrt();
    let at_15 = series([0.008_0, -0.169_2, 25.385_1, 14.094_1, -7.026_1, 2.708_1], root);
    let change = series([0.000_5, -0.005_6, -0.006_6, -0.037_5, 0.063_6, -0.014_4], root);
    (at_15 + (t - 15.0) / (1.0 + 0.016_2 * (t - 15.0)) * change).clamp(0.0, 42.0)
}

fn series(coefficients: [f64; 6], x: f64) -> f64 {
    coefficients
        .iter()
        .rev()
        .fold(0.0, |sum, coefficient| sum * x + coefficient)
}

/// Speed of sound, metres a second (Mackenzie, "Nine-term equation for sound speed in the oceans", Journal of the
/// Acoustical Society of America 70, 1981).
pub(super) fn sound_speed_mps(temperature_c: f64, salinity: f64, depth_m: f64) -> f64 {
    let (t, s, d) = (temperature_c, salinity - 35.0, depth_m);
    1448.96 + t * (4.591 + t * (-5.304e-2 + t * 2.374e-4)) + s * (1.340 - 1.025e-2 * t) + d * (1.630e-2 + d * 1.675e-7)
        - 7.139e-13 * t * d * d * d
}

/// Speed of sound by what a CTD measures: microsiemens a centimetre, degrees Celsius, kilopascals with the air's.
pub(super) fn sound_speed_by_ctd_mps(conductivity_us_per_cm: f64, temperature_c: f64, pressure_kpa: f64) -> f64 {
    let water_kpa = (pressure_kpa - AIR_KPA).max(0.0);
    let salinity = salinity(conductivity_us_per_cm, temperature_c, water_kpa / 10.0);
    sound_speed_mps(temperature_c, salinity, water_kpa / WATER_KPA_PER_M)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn salinity_has_the_published_check_values() {
        for (ratio, temperature_c, pressure_dbar, expected) in [
            (1.0, 15.0, 0.0, 35.0),
            (1.2, 20.0, 2000.0, 37.245_628),
            (0.65, 5.0, 1500.0, 27.995_347),
        ] {
            let found = salinity(ratio * STANDARD_US_PER_CM, temperature_c, pressure_dbar);
            assert!((found - expected).abs() < 1e-5, "{found} {expected}");
        }
        assert_eq!(salinity(0.0, 15.0, 0.0), 0.008);
    }

    #[test]
    fn sound_speed_has_the_published_check_value() {
        assert!((sound_speed_mps(25.0, 35.0, 1000.0) - 1550.744).abs() < 1e-3);
        let by_ctd = sound_speed_by_ctd_mps(STANDARD_US_PER_CM, 15.0, AIR_KPA);
        assert!((by_ctd - sound_speed_mps(15.0, 35.0, 0.0)).abs() < 1e-3);
    }
}
