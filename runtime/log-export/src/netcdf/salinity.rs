//! Practical salinity from conductivity, by the Practical Salinity Scale 1978 (Fofonoff and Millard, Unesco technical
//! papers in marine science 44, 1983).

/// Conductivity of sea water of salinity 35 at 15 degC (IPTS-68) and no pressure, S/m.
const STANDARD_S_PER_M: f64 = 4.2914;
/// Temperatures of ITS-90 times this are those of IPTS-68, in which the scale is defined.
const IPTS_68: f64 = 1.000_24;
/// The pressure of the air at the surface, dbar.
const AIR_DBAR: f64 = 10.1325;

/// Practical salinity, or `None` outside the scale's range (2 to 42, -2 to 35 degC).
///
/// Conductivity in S/m, temperature in degC, absolute pressure in dbar.
pub(super) fn practical_salinity(conductivity_s_per_m: f64, temperature_degc: f64, pressure_dbar: f64) -> Option<f64> {
    let ratio = conductivity_s_per_m / STANDARD_S_PER_M;
    let salinity = of_ratio(ratio, temperature_degc * IPTS_68, (pressure_dbar - AIR_DBAR).max(0.0));
    let is_in_range = (-2.0..=35.0).contains(&temperature_degc) && (2.0..=42.0).contains(&salinity);
    is_in_range.then_some(salinity)
}

/// Practical salinity from the ratio of conductivities, the temperature (IPTS-68) and the pressure of the water, dbar.
fn of_ratio(ratio: f64, t: f64, p: f64) -> f64 {
    let polynomial = |coefficients: &[f64], x: f64| coefficients.iter().rev().fold(0.0, |sum, factor| sum * x + factor);
    let of_pressure = p * polynomial(&[2.070e-5, -6.370e-10, 3.989e-15], p)
        / (1.0 + 3.426e-2 * t + 4.464e-4 * t * t + (4.215e-1 - 3.107e-3 * t) * ratio);
    let of_temperature = polynomial(&[0.676_609_7, 2.005_64e-2, 1.104_259e-4, -6.969_8e-7, 1.003_1e-9], t);
    let root = (ratio / ((1.0 + of_pressure) * of_temperature)).max(0.0).sqrt();
    let at_15 = polynomial(&[0.0080, -0.1692, 25.3851, 14.0941, -7.0261, 2.7081], root);
    let apart = polynomial(&[0.0005, -0.0056, -0.0066, -0.0375, 0.0636, -0.0144], root);
    at_15 + (t - 15.0) / (1.0 + 0.0162 * (t - 15.0)) * apart
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn salinity_has_the_check_values_of_the_unesco_paper() {
        for (ratio, t, p, expected) in [
            (1.0, 15.0, 0.0, 35.000_000),
            (1.2, 20.0, 2000.0, 37.245_628),
            (0.65, 5.0, 1500.0, 27.995_347),
        ] {
            let found = of_ratio(ratio, t, p);
            assert!((found - expected).abs() < 1e-6, "{found}, expected {expected}");
        }
    }

    #[test]
    fn air_and_impossible_readings_have_no_salinity() {
        assert_eq!(practical_salinity(0.0001, 12.0, 10.13), None);
        assert_eq!(practical_salinity(f64::NAN, 12.0, 10.13), None);
        assert_eq!(practical_salinity(4.0, 60.0, 10.13), None);
        assert!(practical_salinity(4.0, 12.0, 10.13).is_some_and(|salinity| (34.0..35.5).contains(&salinity)));
    }
}
