use backseat_spi::Compass as CompassMessage;
use backseat_units::TimeOfDay;
use backseat_units::math::{sin_cos, wrap_360};

use super::noise::Noise;
use crate::file::{COMPASSES_MAX, CompassConfig};
use crate::vehicle::Vehicle;

/// The magnetic compasses.
#[derive(Clone, Debug)]
pub(super) struct Compasses {
    config: CompassConfig,
    noise: Noise,
    /// Archibald Smith's coefficients A to E of each compass, degrees.
    deviations: [[f64; 5]; COMPASSES_MAX],
}

impl Compasses {
    pub(super) fn new(config: &CompassConfig, seed: u64) -> Self {
        let constant = Noise::new(seed, "compass deviation");
        let mut deviations = [[0.0; 5]; COMPASSES_MAX];
        for (number, coefficients) in (0..).zip(&mut deviations) {
            let mut draws = constant.reading(number);
            *coefficients = [
                draws.normal(config.bias_deg),
                draws.normal(config.deviation_deg),
                draws.normal(config.deviation_deg),
                draws.normal(config.soft_iron_deg),
                draws.normal(config.soft_iron_deg),
            ];
        }
        Self {
            config: *config,
            noise: Noise::new(seed, "compass"),
            deviations,
        }
    }

    pub(super) const fn count(&self) -> u32 {
        self.config.count
    }

    /// BFRCM (SPI 6.5) of one compass, with the reading of this number. Compasses count from 1.
    pub(super) fn message(
        &self,
        compass: u32,
        vehicle: &Vehicle,
        true_heading_deg: f64,
        number: u64,
        stamp: TimeOfDay,
    ) -> CompassMessage {
        let magnetic_deg = true_heading_deg - self.config.declination_deg;
        let coefficients = self.deviations[(compass as usize + COMPASSES_MAX - 1) % COMPASSES_MAX];
        let noise_deg = self.config.noise_deg;
        let mut draws = self.noise.reading(number * COMPASSES_MAX as u64 + u64::from(compass));
        CompassMessage {
            created: stamp,
            number: compass,
            heading_deg: wrap_360(magnetic_deg + deviation_deg(coefficients, magnetic_deg) + draws.normal(noise_deg)),
            pitch_deg: vehicle.motion().pitch_deg + draws.normal(noise_deg),
            roll_deg: vehicle.motion().roll_deg + draws.normal(noise_deg),
            measured: stamp,
        }
    }
}

fn deviation_deg([a, b, c, d, e]: [f64; 5], magnetic_deg: f64) -> f64 {
    let (sin, cos) = sin_cos(magnetic_deg.to_radians());
    let (sin_twice, cos_twice) = (2.0 * sin * cos, cos * cos - sin * sin);
    a + b * sin + c * cos + d * sin_twice + e * cos_twice
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_deviation_follows_the_five_coefficients() {
        // At 90 degrees, the deviation is A + B - E.
        assert!((deviation_deg([0.1, 2.0, 7.0, 9.0, 0.5], 90.0) - 1.6).abs() < 1e-12);
        // At 45 degrees, D counts in full and E not at all.
        assert!((deviation_deg([0.0, 0.0, 0.0, 3.0, 5.0], 45.0) - 3.0).abs() < 1e-12);
    }
}
