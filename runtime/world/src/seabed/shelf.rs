use backseat_units::EastNorth;
use backseat_units::math::{TAU, exp, sin_cos};

use super::SeabedConfig;
use crate::stream::Stream;

#[derive(Clone, Copy, Debug, PartialEq)]
struct Meander {
    amplitude_m: f64,
    /// Wave vector, radians per metre.
    wave: EastNorth,
    phase_rad: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Bank {
    centre: EastNorth,
    height_m: f64,
    /// One over the radius squared.
    tightness: f64,
}

/// The analytic seabed: a shelf with meanders and banks, drawn by a seed.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Shelf {
    depth_m: f64,
    /// Gradient of the depth, metres per metre.
    slope: EastNorth,
    meanders: Vec<Meander>,
    banks: Vec<Bank>,
}

impl Shelf {
    /// Draws a shelf from a validated configuration.
    pub(super) fn new(config: &SeabedConfig, seed: u64) -> Self {
        let mut stream = Stream::new(seed, "seabed");
        let depth_m = config.depth_m.draw(&mut stream);
        let slope_of = config.slope.draw(&mut stream);
        let (sin, cos) = sin_cos(config.downslope_deg.draw(&mut stream).to_radians());
        let each_slope = config.meander_slope / f64::from(config.meanders.max(1));
        let meanders = (0..config.meanders)
            .map(|_| {
                let number = TAU / config.meander_wavelength_m.draw(&mut stream);
                let (east, north) = sin_cos(stream.uniform_in(0.0, TAU));
                let steepness = each_slope * stream.uniform_in(0.4, 1.0);
                Meander {
                    amplitude_m: steepness / number,
                    wave: EastNorth::new(east, north) * number,
                    phase_rad: stream.uniform_in(0.0, TAU),
                }
            })
            .collect();
        let banks = (0..config.banks)
            .map(|_| {
                let radius_m = config.bank_radius_m.draw(&mut stream);
                Bank {
                    centre: EastNorth::new(
                        config.bank_east_m.draw(&mut stream),
                        config.bank_north_m.draw(&mut stream),
                    ),
                    height_m: config.bank_height_m.draw(&mut stream),
                    tightness: 1.0 / (radius_m * radius_m),
                }
            })
            .collect();
        Self {
            depth_m,
            slope: EastNorth::new(sin, cos) * slope_of,
            meanders,
            banks,
        }
    }

    /// Depth in metres and its gradient, before `depth_min_m` and `depth_max_m` are applied.
    pub(super) fn depth_and_gradient(&self, at: EastNorth) -> (f64, EastNorth) {
        let mut depth_m = self.depth_m + self.slope.east_m * at.east_m + self.slope.north_m * at.north_m;
        let mut gradient = self.slope;
        for meander in &self.meanders {
            let phase = meander.wave.east_m * at.east_m + meander.wave.north_m * at.north_m + meander.phase_rad;
            let (sin, cos) = sin_cos(phase);
            depth_m += meander.amplitude_m * sin;
            gradient = gradient + meander.wave * (meander.amplitude_m * cos);
        }
        for bank in &self.banks {
            let from = at - bank.centre;
            let square = (from.east_m * from.east_m + from.north_m * from.north_m) * bank.tightness;
            if square < 50.0 {
                let height_m = bank.height_m * exp(-0.5 * square);
                depth_m -= height_m;
                gradient = gradient + from * (height_m * bank.tightness);
            }
        }
        (depth_m, gradient)
    }
}
