use backseat_units::math::{TAU, exp, sin_cos};
use backseat_units::{EastNorth, Timestamp};
use serde::Deserialize;

use crate::error::{WorldError, check};
use crate::span::Span;
use crate::stream::Stream;

/// The `[current]` section: the same everywhere, turning slowly, weaker with depth where that is asked for.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CurrentConfig {
    /// Speed at the surface, metres a second, 0 to 5.
    pub speed_mps: Span,
    /// Where it flows to at the start, degrees clockwise from the frame's north.
    pub towards_deg: Span,
    /// Time of one full clockwise turn, hours, 0.1 or more; none does not turn. A semidiurnal tide has 12.42.
    pub rotation_h: Option<Span>,
    /// Depth over which it falls to 1/e, metres, 1 or more; none does not fall.
    pub decay_depth_m: Option<f64>,
}

impl Default for CurrentConfig {
    fn default() -> Self {
        Self {
            speed_mps: Span::fixed(0.0),
            towards_deg: Span::between(0.0, 360.0),
            rotation_h: None,
            decay_depth_m: None,
        }
    }
}

/// The current that a seed has drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Current {
    speed_mps: f64,
    towards_rad: f64,
    rotation_rad_per_s: f64,
    /// One over the decay depth; zero does not decay.
    decay_per_m: f64,
    /// East and north at the start: what it stays where it does not turn.
    at_start: (f64, f64),
}

impl Current {
    /// Draws a current.
    ///
    /// # Errors
    /// [`WorldError`] where the configuration leaves its ranges.
    pub fn new(config: &CurrentConfig, seed: u64) -> Result<Self, WorldError> {
        config.speed_mps.within(0.0, 5.0, "current.speed_mps", "0 to 5 m/s")?;
        config
            .towards_deg
            .within(-360.0, 720.0, "current.towards_deg", "-360 to 720 degrees")?;
        if let Some(rotation) = config.rotation_h {
            rotation.within(0.1, 1e6, "current.rotation_h", "0.1 h or more")?;
        }
        if let Some(decay) = config.decay_depth_m {
            check(
                (1.0..=1e6).contains(&decay),
                "current.decay_depth_m",
                decay,
                "1 m or more",
            )?;
        }
        let mut stream = Stream::new(seed, "current");
        let speed_mps = config.speed_mps.draw(&mut stream);
        let towards_rad = config.towards_deg.draw(&mut stream).to_radians();
        let rotation_rad_per_s = config
            .rotation_h
            .map_or(0.0, |hours| TAU / (3600.0 * hours.draw(&mut stream)));
        let (sin, cos) = sin_cos(towards_rad);
        Ok(Self {
            speed_mps,
            towards_rad,
            rotation_rad_per_s,
            decay_per_m: config.decay_depth_m.map_or(0.0, |depth| 1.0 / depth),
            at_start: (speed_mps * sin, speed_mps * cos),
        })
    }

    /// Velocity of the water, metres a second east and north.
    #[must_use]
    pub fn at(&self, _place: EastNorth, depth_m: f64, time: Timestamp) -> (f64, f64) {
        let (mut east, mut north) = self.at_start;
        if self.rotation_rad_per_s != 0.0 {
            let (sin, cos) = sin_cos(self.towards_rad + self.rotation_rad_per_s * time.as_secs_f64());
            (east, north) = (self.speed_mps * sin, self.speed_mps * cos);
        }
        if self.decay_per_m > 0.0 {
            let factor = exp(-depth_m.max(0.0) * self.decay_per_m);
            (east, north) = (east * factor, north * factor);
        }
        (east, north)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_turns_and_decays() {
        let config = CurrentConfig {
            speed_mps: Span::fixed(0.4),
            towards_deg: Span::fixed(90.0),
            rotation_h: Some(Span::fixed(4.0)),
            decay_depth_m: Some(50.0),
        };
        let current = Current::new(&config, 1).unwrap();
        let at = |depth_m, hours: u64| current.at(EastNorth::default(), depth_m, Timestamp::from_secs(hours * 3600));
        assert!((at(0.0, 0).0 - 0.4).abs() < 1e-12 && at(0.0, 0).1.abs() < 1e-12);
        // A quarter of a turn later it flows south.
        assert!(at(0.0, 1).0.abs() < 1e-12 && (at(0.0, 1).1 + 0.4).abs() < 1e-12);
        assert!((at(50.0, 0).0 - 0.4 / core::f64::consts::E).abs() < 1e-12);
    }

    #[test]
    fn draws_stay_within_their_span() {
        let config = CurrentConfig {
            speed_mps: Span::between(0.1, 0.3),
            ..CurrentConfig::default()
        };
        for seed in 0..200 {
            let (east, north) = Current::new(&config, seed)
                .unwrap()
                .at(EastNorth::default(), 0.0, Timestamp::ZERO);
            let speed = (east * east + north * north).sqrt();
            assert!((0.1 - 1e-9..=0.3 + 1e-9).contains(&speed));
        }
    }
}
