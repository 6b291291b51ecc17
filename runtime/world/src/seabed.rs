use backseat_units::EastNorth;
use backseat_units::math::{TAU, exp, sin_cos};
use serde::Deserialize;

use crate::error::{WorldError, check};
use crate::span::Span;
use crate::stream::Stream;

/// The `[seabed]` section: a shelf that slopes one way, with meanders and banks drawn by the seed.
///
/// The meanders' slopes add up to at most `meander_slope`; kept below `slope` they bend the depth contours without
/// ever closing one, so that a contour can be followed for ever.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SeabedConfig {
    /// Water depth at the origin before meanders and banks, metres, above 0 to 6000.
    pub depth_m: Span,
    /// Slope of the shelf, metres down a metre, 0 to 0.5.
    pub slope: Span,
    /// The way that is down, degrees clockwise from the frame's north.
    pub downslope_deg: Span,
    /// How many meanders, 0 to 16.
    pub meanders: u32,
    /// The most slope that all meanders together may add, metres a metre, 0 to 0.5.
    pub meander_slope: f64,
    /// Length of a meander, metres, 50 to 100000.
    pub meander_wavelength_m: Span,
    /// How many banks, 0 to 16.
    pub banks: u32,
    /// Height of a bank over the shelf, metres, 0 to 1000.
    pub bank_height_m: Span,
    /// Radius of a bank (one standard deviation), metres, 20 to 20000.
    pub bank_radius_m: Span,
    /// Banks lie this far east of the origin, metres.
    pub bank_east_m: Span,
    /// Banks lie this far north of the origin, metres.
    pub bank_north_m: Span,
    /// The water is nowhere shallower, metres, above 0.
    pub depth_min_m: f64,
    /// The water is nowhere deeper, metres.
    pub depth_max_m: f64,
}

impl Default for SeabedConfig {
    fn default() -> Self {
        Self {
            depth_m: Span::fixed(60.0),
            slope: Span::between(0.03, 0.045),
            downslope_deg: Span::between(0.0, 360.0),
            meanders: 4,
            meander_slope: 0.012,
            meander_wavelength_m: Span::between(400.0, 2000.0),
            banks: 0,
            bank_height_m: Span::between(3.0, 10.0),
            bank_radius_m: Span::between(100.0, 300.0),
            bank_east_m: Span::between(-1000.0, 1000.0),
            bank_north_m: Span::between(-1000.0, 1000.0),
            depth_min_m: 2.0,
            depth_max_m: 6000.0,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Meander {
    amplitude_m: f64,
    /// Radians a metre, east and north.
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

/// The seabed that a seed has drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Seabed {
    depth_m: f64,
    /// Metres down a metre, east and north.
    slope: EastNorth,
    meanders: Vec<Meander>,
    banks: Vec<Bank>,
    depth_min_m: f64,
    depth_max_m: f64,
}

impl Seabed {
    /// Draws a seabed.
    ///
    /// # Errors
    /// [`WorldError`] where the configuration leaves its ranges.
    pub fn new(config: &SeabedConfig, seed: u64) -> Result<Self, WorldError> {
        validate(config)?;
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
        Ok(Self {
            depth_m,
            slope: EastNorth::new(sin, cos) * slope_of,
            meanders,
            banks,
            depth_min_m: config.depth_min_m,
            depth_max_m: config.depth_max_m,
        })
    }

    /// Water depth, metres.
    #[must_use]
    pub fn water_depth_m(&self, at: EastNorth) -> f64 {
        self.depth_and_gradient(at).0
    }

    /// The way down and how steep: metres deeper a metre, east and north.
    #[must_use]
    pub fn gradient(&self, at: EastNorth) -> EastNorth {
        self.depth_and_gradient(at).1
    }

    /// Water depth in metres and its gradient in one pass.
    #[must_use]
    pub fn depth_and_gradient(&self, at: EastNorth) -> (f64, EastNorth) {
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
        if depth_m < self.depth_min_m {
            (self.depth_min_m, EastNorth::default())
        } else if depth_m > self.depth_max_m {
            (self.depth_max_m, EastNorth::default())
        } else {
            (depth_m, gradient)
        }
    }
}

fn validate(config: &SeabedConfig) -> Result<(), WorldError> {
    config.depth_m.within(0.1, 6000.0, "seabed.depth_m", "0.1 to 6000 m")?;
    config.slope.within(0.0, 0.5, "seabed.slope", "0 to 0.5")?;
    config
        .downslope_deg
        .within(-360.0, 720.0, "seabed.downslope_deg", "-360 to 720 degrees")?;
    check(
        config.meanders <= 16,
        "seabed.meanders",
        f64::from(config.meanders),
        "at most 16",
    )?;
    let meander_slope_ok = (0.0..=0.5).contains(&config.meander_slope);
    check(
        meander_slope_ok,
        "seabed.meander_slope",
        config.meander_slope,
        "0 to 0.5",
    )?;
    config
        .meander_wavelength_m
        .within(50.0, 100_000.0, "seabed.meander_wavelength_m", "50 to 100000 m")?;
    check(
        config.banks <= 16,
        "seabed.banks",
        f64::from(config.banks),
        "at most 16",
    )?;
    config
        .bank_height_m
        .within(0.0, 1000.0, "seabed.bank_height_m", "0 to 1000 m")?;
    config
        .bank_radius_m
        .within(20.0, 20_000.0, "seabed.bank_radius_m", "20 to 20000 m")?;
    config
        .bank_east_m
        .within(-50_000.0, 50_000.0, "seabed.bank_east_m", "within 50 km of the origin")?;
    config
        .bank_north_m
        .within(-50_000.0, 50_000.0, "seabed.bank_north_m", "within 50 km of the origin")?;
    let least_ok = config.depth_min_m > 0.0 && config.depth_min_m < config.depth_max_m;
    check(
        least_ok,
        "seabed.depth_min_m",
        config.depth_min_m,
        "above 0 and below depth_max_m",
    )?;
    check(
        config.depth_max_m <= 12_000.0,
        "seabed.depth_max_m",
        config.depth_max_m,
        "at most 12000 m",
    )
}

#[cfg(test)]
mod tests {
    use backseat_units::math::hypot;
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_shelf_can_be_followed_everywhere(
            seed in any::<u64>(), east in -1000.0..1000.0f64, north in -1000.0..1000.0f64,
        ) {
            let config = SeabedConfig { depth_m: Span::fixed(200.0), ..SeabedConfig::default() };
            let seabed = Seabed::new(&config, seed).unwrap();
            let gradient = seabed.gradient(EastNorth::new(east, north));
            let slope = hypot(gradient.east_m, gradient.north_m);
            prop_assert!((0.018..=0.06).contains(&slope), "{slope}");
        }

        #[test]
        fn the_gradient_is_the_depths_own(seed in any::<u64>(), east in -900.0..900.0f64, north in -900.0..900.0f64) {
            let config = SeabedConfig { depth_m: Span::fixed(200.0), banks: 3, ..SeabedConfig::default() };
            let seabed = Seabed::new(&config, seed).unwrap();
            let at = EastNorth::new(east, north);
            let gradient = seabed.gradient(at);
            let depth = |east: f64, north: f64| seabed.water_depth_m(at + EastNorth::new(east, north));
            let by_difference = EastNorth::new(
                depth(0.5, 0.0) - depth(-0.5, 0.0),
                depth(0.0, 0.5) - depth(0.0, -0.5),
            );
            prop_assert!(gradient.distance_m(by_difference) < 1e-4);
        }
    }

    #[test]
    fn seeds_differ_and_bounds_hold() {
        let config = SeabedConfig {
            depth_min_m: 10.0,
            depth_max_m: 90.0,
            ..SeabedConfig::default()
        };
        let one = Seabed::new(&config, 1).unwrap();
        assert_ne!(one, Seabed::new(&config, 2).unwrap());
        for east in [-20_000.0, 20_000.0] {
            for north in [-20_000.0, 20_000.0] {
                assert!((10.0..=90.0).contains(&one.water_depth_m(EastNorth::new(east, north))));
            }
        }
    }

    #[test]
    fn a_bad_key_is_named() {
        let config = SeabedConfig {
            slope: Span::between(0.1, 0.9),
            ..SeabedConfig::default()
        };
        assert_eq!(
            Seabed::new(&config, 1).unwrap_err().to_string(),
            "seabed.slope is 0.9, expected 0 to 0.5"
        );
    }
}
