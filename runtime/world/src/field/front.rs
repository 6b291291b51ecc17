use backseat_units::math::sin_cos;
use backseat_units::{EastNorth, Timestamp};
use serde::Deserialize;

use super::{Adds, smooth_step, zero};
use crate::error::{WorldError, check};
use crate::span::Span;
use crate::stream::Stream;

/// One `[[field.fronts]]`: a straight front that moves, the same at all depths. The water behind it differs from the
/// water ahead of it, with a hyperbolic tangent in between.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrontConfig {
    /// A point on it at the start, metres east of the origin.
    pub east_m: Span,
    /// A point on it at the start, metres north of the origin.
    pub north_m: Span,
    /// The direction in which it moves, at a right angle to itself, degrees clockwise from the frame's north.
    pub towards_deg: Span,
    /// Its speed, metres a second, 0 to 5.
    #[serde(default = "zero")]
    pub speed_mps: Span,
    /// Its width, metres, 0.1 to 20000: 76 % of the step lies within it.
    pub width_m: Span,
    /// What it adds to the temperature behind it, degrees Celsius, within ±40.
    #[serde(default = "zero")]
    pub temperature_c: Span,
    /// What it adds to the conductivity behind it, microsiemens a centimetre, within ±100000.
    #[serde(default = "zero")]
    pub conductivity_us_per_cm: Span,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Front {
    /// A point on it at the start.
    from: EastNorth,
    /// Direction of its motion: a vector of one metre.
    towards: EastNorth,
    speed_mps: f64,
    per_half_width: f64,
    pub(super) adds: Adds,
}

/// Draws the fronts from their own stream.
pub(super) fn draw(configs: &[FrontConfig], seed: u64) -> Result<Vec<Front>, WorldError> {
    let count = configs.len();
    check(count <= 8, "field.fronts", count as f64, "at most 8 fronts")?;
    let mut stream = Stream::new(seed, "fronts");
    let mut fronts = Vec::with_capacity(count);
    for config in configs {
        config.validate()?;
        let from = EastNorth::new(config.east_m.draw(&mut stream), config.north_m.draw(&mut stream));
        let (sin, cos) = sin_cos(config.towards_deg.draw(&mut stream).to_radians());
        fronts.push(Front {
            from,
            towards: EastNorth::new(sin, cos),
            speed_mps: config.speed_mps.draw(&mut stream),
            per_half_width: 2.0 / config.width_m.draw(&mut stream),
            adds: Adds {
                temperature_c: config.temperature_c.draw(&mut stream),
                conductivity_us_per_cm: config.conductivity_us_per_cm.draw(&mut stream),
                tracer: 0.0,
            },
        });
    }
    Ok(fronts)
}

impl FrontConfig {
    fn validate(&self) -> Result<(), WorldError> {
        let near = "within 50 km of the origin";
        self.east_m.within(-50_000.0, 50_000.0, "field.fronts.east_m", near)?;
        self.north_m.within(-50_000.0, 50_000.0, "field.fronts.north_m", near)?;
        let degrees = "-360 to 720 degrees";
        self.towards_deg
            .within(-360.0, 720.0, "field.fronts.towards_deg", degrees)?;
        self.speed_mps
            .within(0.0, 5.0, "field.fronts.speed_mps", "0 to 5 m/s")?;
        self.width_m
            .within(0.1, 20_000.0, "field.fronts.width_m", "0.1 to 20000 m")?;
        let key = "field.fronts.temperature_c";
        self.temperature_c
            .within(-40.0, 40.0, key, "-40 to 40 degrees Celsius")?;
        let key = "field.fronts.conductivity_us_per_cm";
        self.conductivity_us_per_cm
            .within(-100_000.0, 100_000.0, key, "-100000 to 100000 uS/cm")
    }
}

impl Front {
    /// The part of its step that has arrived at a place, 0 to 1.
    pub(super) fn share(&self, at: EastNorth, time: Timestamp) -> f64 {
        let from = at - self.from;
        let ahead_m = from.east_m * self.towards.east_m + from.north_m * self.towards.north_m
            - self.speed_mps * time.as_secs_f64();
        smooth_step(-ahead_m * self.per_half_width)
    }
}

#[cfg(test)]
mod tests {
    use backseat_units::math::tanh;

    use super::*;

    #[test]
    fn a_front_moves_at_its_speed() {
        let text =
            "east_m = 100\nnorth_m = -5000\ntowards_deg = 270\nspeed_mps = 0.5\nwidth_m = 20\ntemperature_c = -2";
        let front = draw(&[toml::from_str(text).unwrap()], 1).unwrap()[0];
        let at = |east_m, seconds| front.share(EastNorth::new(east_m, 70.0), Timestamp::from_secs(seconds));
        assert!((at(100.0, 0) - 0.5).abs() < 1e-12 && (at(0.0, 200) - 0.5).abs() < 1e-9);
        // Behind it and ahead of it.
        assert!((at(110.0, 0) - 0.5 * (1.0 + tanh(1.0))).abs() < 1e-9);
        assert!(at(400.0, 0) > 0.999_999 && at(-400.0, 0) < 1e-9 && at(-400.0, 10_000) == 1.0);
        assert_eq!(front.adds.temperature_c, -2.0);
    }

    #[test]
    fn ranges_are_checked_by_their_key() {
        let config: FrontConfig = toml::from_str("east_m = 0\nnorth_m = 0\ntowards_deg = 0\nwidth_m = 0").unwrap();
        let error = draw(&[config], 1).unwrap_err();
        assert_eq!(error.to_string(), "field.fronts.width_m is 0, expected 0.1 to 20000 m");
    }
}
