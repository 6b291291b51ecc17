use backseat_units::Timestamp;
use backseat_units::math::{TAU, sin_cos};
use serde::Deserialize;

use crate::error::{WorldError, check};
use crate::span::Span;
use crate::stream::Stream;

/// One `[[current.tides]]`: the tidal ellipse of one constituent. M2 has a period of 12.4206 h, S2 12, K1 23.9345,
/// O1 25.8193.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TideConfig {
    /// Greatest speed, along the major axis, metres a second, 0 to 5.
    pub speed_mps: Span,
    /// Direction of its major axis, degrees clockwise from the frame's north.
    pub towards_deg: Span,
    /// Period, hours, 0.1 to 10000.
    pub period_h: Span,
    /// Time from the start until it first flows in that direction at its greatest speed, degrees of its period; 0
    /// unless given.
    #[serde(default = "zero")]
    pub phase_deg: Span,
    /// Minor axis over major axis, -1 to 1. A positive one turns anticlockwise, a negative one clockwise, 0 flows back
    /// and forth.
    #[serde(default = "zero")]
    pub ellipticity: Span,
}

const fn zero() -> Span {
    Span::fixed(0.0)
}

/// One constituent: major·cos(ωt - g) + minor·sin(ωt - g). The minor axis is a quarter turn anticlockwise of the major
/// one.
///
/// Source: Foreman, *Manual for Tidal Currents Analysis and Prediction*, Pacific Marine Science Report 78-6 (1978),
/// section 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ellipse {
    /// Half axes, metres a second east and north.
    major: (f64, f64),
    minor: (f64, f64),
    rad_per_s: f64,
    phase_rad: f64,
}

/// Draws the constituents from their own stream.
pub(super) fn draw(configs: &[TideConfig], seed: u64) -> Result<Vec<Ellipse>, WorldError> {
    let count = configs.len();
    check(count <= 8, "current.tides", count as f64, "at most 8 constituents")?;
    let mut stream = Stream::new(seed, "tidal current");
    let mut ellipses = Vec::with_capacity(count);
    for config in configs {
        config
            .speed_mps
            .within(0.0, 5.0, "current.tides.speed_mps", "0 to 5 m/s")?;
        let degrees = "-360 to 720 degrees";
        config
            .towards_deg
            .within(-360.0, 720.0, "current.tides.towards_deg", degrees)?;
        config
            .period_h
            .within(0.1, 10_000.0, "current.tides.period_h", "0.1 to 10000 h")?;
        config
            .phase_deg
            .within(-360.0, 720.0, "current.tides.phase_deg", degrees)?;
        config
            .ellipticity
            .within(-1.0, 1.0, "current.tides.ellipticity", "-1 to 1")?;
        let speed_mps = config.speed_mps.draw(&mut stream);
        let (sin, cos) = sin_cos(config.towards_deg.draw(&mut stream).to_radians());
        let rad_per_s = TAU / (3600.0 * config.period_h.draw(&mut stream));
        let phase_rad = config.phase_deg.draw(&mut stream).to_radians();
        let minor_mps = speed_mps * config.ellipticity.draw(&mut stream);
        ellipses.push(Ellipse {
            major: (speed_mps * sin, speed_mps * cos),
            minor: (-minor_mps * cos, minor_mps * sin),
            rad_per_s,
            phase_rad,
        });
    }
    Ok(ellipses)
}

impl Ellipse {
    pub(super) fn at(&self, time: Timestamp) -> (f64, f64) {
        let (sin, cos) = sin_cos(self.rad_per_s * time.as_secs_f64() - self.phase_rad);
        (
            self.major.0 * cos + self.minor.0 * sin,
            self.major.1 * cos + self.minor.1 * sin,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(text: &str) -> Ellipse {
        draw(&[toml::from_str(text).unwrap()], 1).unwrap()[0]
    }

    #[test]
    fn an_ellipse_has_its_axes_and_direction_of_turn() {
        let ellipse = one("speed_mps = 0.4\ntowards_deg = 0\nperiod_h = 12\nphase_deg = 90\nellipticity = 0.5");
        let at = |hours: u64| ellipse.at(Timestamp::from_secs(hours * 3600));
        let near =
            |(east, north): (f64, f64), (x, y): (f64, f64)| (east - x).abs() < 1e-12 && (north - y).abs() < 1e-12;
        // A quarter of the period after the start it flows north at its greatest speed. Each further quarter of the
        // period turns it left by a quarter turn.
        assert!(near(at(3), (0.0, 0.4)), "{:?}", at(3));
        assert!(near(at(6), (-0.2, 0.0)), "{:?}", at(6));
        assert!(near(at(9), (0.0, -0.4)) && near(at(12), (0.2, 0.0)));
        let flat = one("speed_mps = 0.4\ntowards_deg = 90\nperiod_h = 12");
        assert!(near(flat.at(Timestamp::from_secs(3 * 3600)), (0.0, 0.0)));
    }

    #[test]
    fn ranges_are_checked_by_their_key() {
        let config: TideConfig = toml::from_str("speed_mps = 0.4\ntowards_deg = 0\nperiod_h = 0").unwrap();
        let error = draw(&[config], 1).unwrap_err();
        assert_eq!(
            error.to_string(),
            "current.tides.period_h is 0, expected 0.1 to 10000 h"
        );
    }
}
