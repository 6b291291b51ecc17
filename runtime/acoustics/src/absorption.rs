use backseat_units::math::pow;
use backseat_units::{EastNorth, Timestamp};
use backseat_world::World;

/// Acidity of the sea.
const PH: f64 = 8.0;

/// The water that sound passes through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Water {
    /// Temperature, degrees Celsius.
    pub temperature_c: f64,
    /// Practical salinity.
    pub salinity: f64,
    /// Depth, metres.
    pub depth_m: f64,
}

impl Water {
    /// The water of a world at its origin and half of the depth there, at the start of a run. A sonar uses it everywhere:
    /// over the fields that a world can have, absorption changes by some percent.
    #[must_use]
    pub fn of(world: &World) -> Self {
        let at = EastNorth::default();
        let depth_m = 0.5 * world.water_depth_m(at);
        Self {
            temperature_c: world.temperature_c(at, depth_m, Timestamp::ZERO),
            salinity: world.salinity(at, depth_m, Timestamp::ZERO),
            depth_m,
        }
    }

    /// How much sound of a frequency in hertz is absorbed, decibels a metre, one way.
    ///
    /// The equation of Francois and Garrison, *Sound absorption based on ocean measurements. Part II: Boric acid
    /// contribution and equation for total absorption*, Journal of the Acoustical Society of America 72 (1982), at a pH
    /// of 8. It is meant for 400 Hz to 1 MHz, -1.8 to 30 °C and a salinity of 30 to 35. Temperature is clamped to -2 to
    /// 40 °C and salinity to 0 to 45, so the result is finite everywhere.
    #[must_use]
    pub fn absorption_db_per_m(&self, frequency_hz: f64) -> f64 {
        let t = self.temperature_c.clamp(-2.0, 40.0);
        let s = self.salinity.clamp(0.0, 45.0);
        let z = self.depth_m.clamp(0.0, 12_000.0);
        let f = frequency_hz / 1000.0;
        let kelvin = t + 273.0;
        let c = 1412.0 + 3.21 * t + 1.19 * s + 0.0167 * z;
        // Boric acid.
        let a1 = 8.86 / c * pow(10.0, 0.78 * PH - 5.0);
        let f1 = 2.8 * (s / 35.0).sqrt() * pow(10.0, 4.0 - 1245.0 / kelvin);
        // Magnesium sulphate.
        let a2 = 21.44 * s / c * (1.0 + 0.025 * t);
        let p2 = 1.0 - 1.37e-4 * z + 6.2e-9 * z * z;
        let f2 = 8.17 * pow(10.0, 8.0 - 1990.0 / kelvin) / (1.0 + 0.0018 * (s - 35.0));
        // Pure water.
        let a3 = if t <= 20.0 {
            4.937e-4 - t * (2.590e-5 - t * (9.11e-7 - t * 1.50e-8))
        } else {
            3.964e-4 - t * (1.146e-5 - t * (1.45e-7 - t * 6.5e-10))
        };
        let p3 = 1.0 - 3.83e-5 * z + 4.9e-10 * z * z;
        let square = f * f;
        let boric = a1 * f1 * square / (square + f1 * f1);
        let magnesium = a2 * p2 * f2 * square / (square + f2 * f2);
        (boric + magnesium + a3 * p3 * square) / 1000.0
    }
}

#[cfg(test)]
mod tests {
    use backseat_units::math::exp;

    use super::*;

    /// Ainslie and McColm, *A simplified formula for viscous and chemical absorption in sea water*, Journal of the
    /// Acoustical Society of America 103 (1998): within a tenth of Francois and Garrison in the oceans.
    fn ainslie_and_mccolm(t: f64, s: f64, z_km: f64, khz: f64) -> f64 {
        let f1 = 0.78 * (s / 35.0).sqrt() * exp(t / 26.0);
        let f2 = 42.0 * exp(t / 17.0);
        let square = khz * khz;
        0.106 * f1 * square / (f1 * f1 + square)
            + 0.52 * (1.0 + t / 43.0) * (s / 35.0) * f2 * square / (f2 * f2 + square) * exp(-z_km / 6.0)
            + 0.00049 * square * exp(-(t / 27.0 + z_km / 17.0))
    }

    #[test]
    fn absorption_agrees_with_the_simplified_formula() {
        for temperature_c in [2.0, 10.0, 18.0, 25.0] {
            for depth_m in [0.0, 100.0, 1000.0] {
                for khz in [4.0, 12.0, 50.0, 120.0, 450.0, 900.0] {
                    let water = Water {
                        temperature_c,
                        salinity: 35.0,
                        depth_m,
                    };
                    let found = 1000.0 * water.absorption_db_per_m(khz * 1000.0);
                    let expected = ainslie_and_mccolm(temperature_c, 35.0, depth_m / 1000.0, khz);
                    let apart = (found / expected - 1.0).abs();
                    assert!(apart < 0.15, "{temperature_c} {depth_m} {khz}: {found} {expected}");
                }
            }
        }
    }

    #[test]
    fn no_water_gives_nonsense() {
        for temperature_c in [-400.0, 0.0, 20.0, 500.0] {
            for salinity in [-1.0, 0.0, 35.0, 400.0] {
                for depth_m in [-5.0, 0.0, 20_000.0] {
                    let water = Water {
                        temperature_c,
                        salinity,
                        depth_m,
                    };
                    let found = water.absorption_db_per_m(4e5);
                    assert!(found > 0.0 && found < 1.0, "{water:?} {found}");
                }
            }
        }
    }
}
