//! Decibels, and the levels of sources and of noise.

use core::f64::consts::LN_10;

use backseat_units::math::{exp, ln};

/// A ratio of powers from decibels.
pub(crate) fn power_of(db: f64) -> f64 {
    exp(db * (LN_10 / 10.0))
}

/// Decibels from a ratio of powers.
pub(crate) fn decibels(power: f64) -> f64 {
    10.0 / LN_10 * ln(power)
}

/// Speed of the wind that makes the noise of the sea, metres a second: about sea state 3.
const WIND_MPS: f64 = 7.5;

/// Noise of the sea, decibels relative to 1 µPa² a hertz: wind and heat.
///
/// 50 + 7.5 √w + 20 log f - 40 log (f + 0.4) for the wind, -15 + 20 log f for the heat of the water, with the frequency f
/// in kilohertz and the wind w in metres a second: Coates, *Underwater acoustic systems* (Wiley 1989), as written by
/// Stojanovic, *On the relationship between capacity and distance in an underwater acoustic communication channel*
/// (ACM Mobile Computing and Communications Review 11, 2007). The second is that of Mellen (1952). Ships and turbulence
/// make noise below 100 Hz only.
pub(crate) fn noise_db(frequency_hz: f64) -> f64 {
    let khz = frequency_hz / 1000.0;
    let wind = 50.0 + 7.5 * WIND_MPS.sqrt() + 2.0 * decibels(khz) - 4.0 * decibels(khz + 0.4);
    let heat = -15.0 + 2.0 * decibels(khz);
    decibels(power_of(wind) + power_of(heat))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decibels_and_powers_are_inverse() {
        for (db, power) in [(0.0, 1.0), (10.0, 10.0), (-20.0, 0.01), (3.010_299_956_639_812, 2.0)] {
            assert!((power_of(db) / power - 1.0).abs() < 1e-12);
            assert!((decibels(power) - db).abs() < 1e-12);
        }
    }

    #[test]
    fn noise_falls_with_frequency_until_heat_takes_over() {
        // 50 + 20.54 - 40 log 1.4 = 64.7 at 1 kHz; heat alone is -15 + 20 log 500 = 39.0 at 500 kHz.
        assert!((noise_db(1000.0) - 64.7).abs() < 0.05, "{}", noise_db(1000.0));
        assert!((noise_db(500_000.0) - 39.0).abs() < 0.2);
        assert!(noise_db(50_000.0) < noise_db(5000.0) && noise_db(50_000.0) < noise_db(500_000.0));
    }
}
