use backseat_units::Timestamp;
use backseat_units::math::{TAU, cos};
use serde::Deserialize;

use crate::error::WorldError;
use crate::span::Span;
use crate::stream::Stream;

/// The `[tide]` section: how the water level rises and falls, the same everywhere. The tidal streams are configured
/// separately, in [`CurrentConfig::tides`](crate::CurrentConfig::tides).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TideLevelConfig {
    /// Height of high water over the mean, metres, 0 to 10.
    pub amplitude_m: Span,
    /// Period, hours, 0.1 to 10000; M2's 12.4206 unless given.
    pub period_h: Span,
    /// Time from the start to the first high water, degrees of its period.
    pub phase_deg: Span,
}

impl Default for TideLevelConfig {
    fn default() -> Self {
        Self {
            amplitude_m: Span::fixed(0.0),
            period_h: Span::fixed(12.4206),
            phase_deg: Span::fixed(0.0),
        }
    }
}

/// The water level of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TideLevel {
    amplitude_m: f64,
    rad_per_s: f64,
    phase_rad: f64,
}

impl TideLevel {
    /// Draws it from its own stream.
    pub(crate) fn new(config: &TideLevelConfig, seed: u64) -> Result<Self, WorldError> {
        config.amplitude_m.within(0.0, 10.0, "tide.amplitude_m", "0 to 10 m")?;
        config
            .period_h
            .within(0.1, 10_000.0, "tide.period_h", "0.1 to 10000 h")?;
        config
            .phase_deg
            .within(-360.0, 720.0, "tide.phase_deg", "-360 to 720 degrees")?;
        let mut stream = Stream::new(seed, "tide");
        Ok(Self {
            amplitude_m: config.amplitude_m.draw(&mut stream),
            rad_per_s: TAU / (3600.0 * config.period_h.draw(&mut stream)),
            phase_rad: config.phase_deg.draw(&mut stream).to_radians(),
        })
    }

    /// Metres above the mean level.
    pub(crate) fn at_m(&self, time: Timestamp) -> f64 {
        if self.amplitude_m == 0.0 {
            return 0.0;
        }
        self.amplitude_m * cos(self.rad_per_s * time.as_secs_f64() - self.phase_rad)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn high_water_comes_at_its_phase() {
        let config = toml::from_str("amplitude_m = 1.5\nperiod_h = 12\nphase_deg = 90").unwrap();
        let tide = TideLevel::new(&config, 1).unwrap();
        let at = |hours: u64| tide.at_m(Timestamp::from_secs(hours * 3600));
        assert!(at(0).abs() < 1e-12 && (at(3) - 1.5).abs() < 1e-12 && (at(9) + 1.5).abs() < 1e-12);
        let level = TideLevel::new(&TideLevelConfig::default(), 1).unwrap();
        assert_eq!(level.at_m(Timestamp::from_secs(1000)), 0.0);
    }
}
