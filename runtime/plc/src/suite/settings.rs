use backseat_s7k::plc::Generic;

use crate::config::{PERIOD_MAX_MS, PERIOD_MIN_MS, SonarConfig};
use crate::sonar::Pulse;

/// What the generic commands set of a sonar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Settings {
    pub(crate) range_m: f64,
    /// The pulse's place in the list of the sonar's pulses.
    pub(crate) pulse: usize,
    pub(crate) pinging: bool,
    pub(crate) power_percent: f64,
    pub(crate) gain_steps: i32,
    pub(crate) period_ms: f64,
}

impl Settings {
    /// The default state: as configured, and not pinging.
    pub(crate) const fn of(config: &SonarConfig) -> Self {
        Self {
            range_m: config.range_m,
            pulse: 0,
            pinging: false,
            power_percent: config.power_percent,
            gain_steps: config.gain_steps,
            period_ms: config.period_ms,
        }
    }

    /// Does a generic command; the error says in words why the sonar cannot.
    pub(crate) fn apply(&mut self, command: &Generic, config: &SonarConfig) -> Result<(), String> {
        match command {
            Generic::Range { range_m } => {
                within("range", *range_m, config.range_min_m, config.range_max_m, "m")?;
                self.range_m = *range_m;
            }
            Generic::Pulse { name } => {
                let place = config.pulses.iter().position(|pulse| *pulse.name == **name);
                // The name is the client's, and may be long.
                let shown: String = name.chars().take(40).collect();
                self.pulse = place.ok_or_else(|| format!("there is no pulse {shown}"))?;
            }
            Generic::Ping { on } => self.pinging = *on,
            Generic::TxPower { percent } => {
                within("power", *percent, 0.0, 100.0, "%")?;
                self.power_percent = *percent;
            }
            Generic::RxGain { gain } => {
                within("gain", f64::from(*gain), 0.0, f64::from(config.gain_max_steps), "steps")?;
                self.gain_steps = *gain;
            }
            Generic::Duration { period_ms } => {
                within("period", *period_ms, PERIOD_MIN_MS, PERIOD_MAX_MS, "ms")?;
                self.period_ms = *period_ms;
            }
            Generic::PulseFiles {} => {}
            Generic::DefaultState {} => *self = Self::of(config),
        }
        Ok(())
    }

    /// The pulse as the acoustics need it.
    pub(crate) fn pulse(&self, config: &SonarConfig) -> Pulse {
        let id = self.pulse.min(config.pulses.len().saturating_sub(1));
        let (start_khz, end_khz, length_ms) = config.pulses.get(id).map_or((0.0, 0.0, 0.0), |pulse| {
            (pulse.start_khz, pulse.end_khz, pulse.length_ms)
        });
        Pulse {
            id: u16::try_from(id).unwrap_or(u16::MAX),
            start_hz: start_khz * 1e3,
            end_hz: end_khz * 1e3,
            length_s: length_ms * 1e-3,
        }
    }
}

fn within(what: &str, value: f64, least: f64, most: f64, unit: &str) -> Result<(), String> {
    if (least..=most).contains(&value) {
        Ok(())
    } else {
        Err(format!("{what} {value:.2} is outside {least} to {most} {unit}"))
    }
}
