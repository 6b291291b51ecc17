//! Equations of sea water: pressure, salinity, speed of sound.
//!
//! Salinity and sound speed are the polynomials of Fofonoff and Millard, *Algorithms for computation of fundamental
//! properties of seawater*, Unesco technical papers in marine science 44 (1983). They use the temperature scale of
//! 1968. Temperatures in this crate are on ITS-90 and are converted with Saunders' factor 1.00024 (WOCE Newsletter 10,
//! 1990). The polynomials are valid for -2 to 40 °C and practical salinities of 2 to 42. Outside that, temperature is
//! clamped to the range, and salinity is what the polynomial gives: it is finite, but only approximate.

/// From ITS-90 to IPTS-68.
const SCALE_OF_1968: f64 = 1.000_24;
/// Conductivity of water of salinity 35 at 15 °C (IPTS-68) and pressure 0, microsiemens a centimetre. Source: Culkin
/// and Smith, IEEE Journal of Oceanic Engineering 5 (1980).
const REFERENCE_US_PER_CM: f64 = 42_914.0;

/// Pressure of the sea at a depth, decibars, without atmospheric pressure, for the standard ocean of 0 °C and salinity
/// 35. The depth is clamped to 0 to 12,000 m.
///
/// Source: Saunders, *Practical conversion of pressure to depth*, Journal of Physical Oceanography 11 (1981).
#[must_use]
pub fn pressure_dbar(depth_m: f64, latitude_deg: f64) -> f64 {
    let sin = backseat_units::math::sin(latitude_deg.to_radians());
    let linear = 1.0 - (5.92e-3 + 5.25e-3 * sin * sin);
    let depth_m = depth_m.clamp(0.0, 12_000.0);
    (linear - (linear * linear - 8.84e-6 * depth_m).sqrt()) / 4.42e-6
}

/// Practical salinity (PSS-78) from conductivity in situ in microsiemens a centimetre, temperature in degrees Celsius
/// (ITS-90) and pressure in decibars. Never below 0.
#[must_use]
pub fn salinity(conductivity_us_per_cm: f64, temperature_c: f64, pressure_dbar: f64) -> f64 {
    let t = temperature_of_1968(temperature_c);
    let ratio = conductivity_us_per_cm.max(0.0) / REFERENCE_US_PER_CM;
    salinity_of_1968(ratio, t, pressure_dbar)
}

/// Conductivity at pressure 0, microsiemens a centimetre, of water with a practical salinity: the inverse of
/// [`salinity`], by bisection. It is fast enough, because it runs only when a world is drawn.
#[must_use]
pub(crate) fn conductivity_us_per_cm(salinity: f64, temperature_c: f64) -> f64 {
    let t = temperature_of_1968(temperature_c);
    // A ratio of 4 is more than 100,000 uS/cm.
    let (mut least, mut most) = (0.0, 4.0);
    for _ in 0..60 {
        let middle = 0.5 * (least + most);
        if salinity_of_1968(middle, t, 0.0) < salinity {
            least = middle;
        } else {
            most = middle;
        }
    }
    most * REFERENCE_US_PER_CM
}

fn temperature_of_1968(temperature_c: f64) -> f64 {
    temperature_c.clamp(-2.0, 40.0) * SCALE_OF_1968
}

/// Unesco 44, section 1. `ratio` is the conductivity over the reference conductivity.
fn salinity_of_1968(ratio: f64, t: f64, p: f64) -> f64 {
    let rt = 0.676_609_7 + t * (2.005_64e-2 + t * (1.104_259e-4 + t * (-6.969_8e-7 + t * 1.003_1e-9)));
    let pressure_part = p * (2.070e-5 + p * (-6.370e-10 + p * 3.989e-15))
        / (1.0 + t * (3.426e-2 + t * 4.464e-4) + (4.215e-1 - 3.107e-3 * t) * ratio);
    let x = (ratio / ((1.0 + pressure_part) * rt)).max(0.0).sqrt();
    let at_15 = 0.008_0 + x * (-0.169_2 + x * (25.385_1 + x * (14.094_1 + x * (-7.026_1 + x * 2.708_1))));
    let part = 0.000_5 + x * (-0.005_6 + x * (-0.006_6 + x * (-0.037_5 + x * (0.063_6 + x * -0.014_4))));
    let from_15 = t - 15.0;
    (at_15 + from_15 / (1.0 + 0.016_2 * from_15) * part).max(0.0)
}

/// Speed of sound, metres a second, from practical salinity, temperature in degrees Celsius (ITS-90) and pressure in
/// decibars, by Chen and Millero (1977), who include brackish water.
#[must_use]
pub fn sound_speed_mps(salinity: f64, temperature_c: f64, pressure_dbar: f64) -> f64 {
    chen_millero(
        salinity.max(0.0),
        temperature_of_1968(temperature_c),
        0.1 * pressure_dbar,
    )
}

/// Unesco 44, section 9. Pressure in bars.
fn chen_millero(s: f64, t: f64, p: f64) -> f64 {
    let d = 1.727e-3 - 7.983_6e-6 * p;
    let b = -1.922e-2 - 4.42e-5 * t + (7.363_7e-5 + 1.794_5e-7 * t) * p;
    let a0 = 1.389 + t * (-1.262e-2 + t * (7.164e-5 + t * (2.006e-6 + t * -3.21e-8)));
    let a1 = 9.474_2e-5 + t * (-1.258_0e-5 + t * (-6.488_5e-8 + t * (1.050_7e-8 + t * -2.012_2e-10)));
    let a2 = -3.906_4e-7 + t * (9.104_1e-9 + t * (-1.600_2e-10 + t * 7.988e-12));
    let a3 = 1.100e-10 + t * (6.649e-12 + t * -3.389e-13);
    let a = a0 + p * (a1 + p * (a2 + p * a3));
    let c0 = 1402.388 + t * (5.037_11 + t * (-5.808_52e-2 + t * (3.342_0e-4 + t * (-1.478_00e-6 + t * 3.146_4e-9))));
    let c1 = 0.153_563 + t * (6.898_2e-4 + t * (-8.178_8e-6 + t * (1.362_1e-7 + t * -6.118_5e-10)));
    let c2 = 3.126_0e-5 + t * (-1.710_7e-6 + t * (2.597_4e-8 + t * (-2.533_5e-10 + t * 1.040_5e-12)));
    let c3 = -9.772_9e-9 + t * (3.850_4e-10 + t * -2.364_3e-12);
    let water = c0 + p * (c1 + p * (c2 + p * c3));
    water + s * (a + b * s.sqrt() + d * s)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: f64, expected: f64, within: f64) {
        assert!((found - expected).abs() <= within, "{found} {expected}");
    }

    #[test]
    fn pressure_agrees_with_saunders() {
        // Saunders' check value: 7500 dbar at 30 degrees of latitude is 7321.45 m.
        near(pressure_dbar(7321.45, 30.0), 7500.0, 0.01);
        assert_eq!(pressure_dbar(-3.0, 30.0), 0.0);
    }

    #[test]
    fn salinity_agrees_with_the_published_check_values() {
        // Unesco 44, page 9.
        near(salinity_of_1968(1.0, 15.0, 0.0), 35.0, 1e-6);
        near(salinity_of_1968(1.2, 20.0, 2000.0), 37.245_628, 1e-6);
        near(salinity_of_1968(0.65, 5.0, 1500.0), 27.995_347, 1e-6);
        // Page 8.
        near(salinity_of_1968(1.888_091, 40.0, 10_000.0), 40.0, 1e-5);
        near(salinity(42_914.0, 15.0 / SCALE_OF_1968, 0.0), 35.0, 1e-6);
    }

    #[test]
    fn sound_speed_agrees_with_the_published_values() {
        // Unesco 44, page 48: the check value, and the first table.
        near(chen_millero(40.0, 40.0, 1000.0), 1731.995, 1e-3);
        for (s, t, p_dbar, speed_mps) in [
            (25.0, 0.0, 0.0, 1435.8),
            (25.0, 20.0, 0.0, 1510.3),
            (35.0, 10.0, 0.0, 1489.8),
            (35.0, 40.0, 0.0, 1563.2),
        ] {
            near(chen_millero(s, t, 0.1 * p_dbar), speed_mps, 0.05);
        }
        // Mackenzie's equation (1981) gives 1550.744 m/s at 25 °C, salinity 35 and 1000 m. The two differ by 0.6 m/s.
        near(sound_speed_mps(35.0, 25.0, pressure_dbar(1000.0, 45.0)), 1550.744, 0.7);
    }

    #[test]
    fn conductivity_is_the_inverse_of_salinity() {
        for (s, t) in [(35.0, 12.0), (2.0, 0.0), (42.0, 30.0), (10.0, 5.5)] {
            near(salinity(conductivity_us_per_cm(s, t), t, 0.0), s, 1e-9);
        }
    }

    #[test]
    fn no_input_gives_nan() {
        for conductivity in [-1.0, 0.0, 1e3, 1e5, 2e6] {
            for temperature in [-400.0, 0.0, 20.0, 440.0] {
                for depth in [-5.0, 0.0, 12_000.0, 1e9] {
                    let p = pressure_dbar(depth, 90.0);
                    let s = salinity(conductivity, temperature, p);
                    assert!(s >= 0.0 && s.is_finite());
                    assert!(sound_speed_mps(s, temperature, p).is_finite());
                }
            }
        }
    }
}
