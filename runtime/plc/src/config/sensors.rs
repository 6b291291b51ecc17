use backseat_world::Span;
use serde::{Deserialize, Deserializer};

use crate::config::{is_plain_text, span_within};
use crate::error::{PlcError, check, within};
use crate::sonar::SensorKind;

/// A sensor of the run list: `[[plc.sensor]]`.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorEntry {
    /// Its kind. There is at most one sensor of each.
    pub kind: SensorKind,
    /// Its name in the run list: 1 to 64 printable characters without comma.
    pub name: String,
    /// Its port, as the run list shows it; 0 without this key.
    #[serde(default)]
    pub port: i32,
}

/// A sonar: `[plc.sub_bottom]`, `[plc.sidescan_low]` or `[plc.sidescan_high]`. Keys that are left out have the default of
/// that sonar. The settings are those of the default state, which commands change.
#[derive(Clone, Debug, PartialEq)]
pub struct SonarConfig {
    /// How long the sonar takes to start, seconds, 0 to 600.
    pub start_s: Span,
    /// How long it takes to shut down, seconds, 0 to 600.
    pub shutdown_s: Span,
    /// The range, m, within the next two.
    pub range_m: f64,
    /// The least range that can be set, m, 1 to 1000.
    pub range_min_m: f64,
    /// The greatest range that can be set, m, from the least one to 1000.
    pub range_max_m: f64,
    /// The transmission power, 0 to 100 %.
    pub power_percent: f64,
    /// The gain of the receiver, steps, 0 to the next.
    pub gain_steps: i32,
    /// The greatest gain, steps, 0 to 1000.
    pub gain_max_steps: i32,
    /// The time from ping to ping, ms, 10 to 60000. The sonar listens to the end of its range before the next ping, so
    /// the time is longer if the range needs it.
    pub period_ms: f64,
    /// The time from sample to sample, microseconds, 1 to 1000.
    pub sample_interval_us: u32,
    /// N, where one step of a sample is 2^-N volts.
    pub weighting_factor: i16,
    /// The pulses, 1 to 32. The first one is the default.
    pub pulses: Vec<PulseConfig>,
}

/// A pulse of a sonar.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PulseConfig {
    /// Its name: 1 to 64 printable characters without comma.
    pub name: String,
    /// The first frequency of its sweep, kHz, 0.1 to 655.
    pub start_khz: f64,
    /// The last frequency of its sweep, kHz, 0.1 to 655.
    pub end_khz: f64,
    /// Its length, ms, 0.01 to 1000.
    pub length_ms: f64,
}

impl SensorEntry {
    /// One sensor of each kind.
    pub(crate) fn defaults() -> Vec<Self> {
        let entry = |kind: SensorKind, name: &str, port: i32| Self {
            kind,
            name: name.to_owned(),
            port,
        };
        vec![
            entry(SensorKind::SubBottom, "Sub-bottom", 1700),
            entry(SensorKind::SidescanLow, "Sidescan LF", 1701),
            entry(SensorKind::SidescanHigh, "Sidescan HF", 1702),
            entry(SensorKind::Bluefin, "Bluefin", 0),
        ]
    }
}

pub(super) fn validate(sensors: &[SensorEntry]) -> Result<(), PlcError> {
    for (place, sensor) in sensors.iter().enumerate() {
        check(
            is_name(&sensor.name),
            "plc.sensor.name",
            format!("{:?}", sensor.name),
            "1 to 64 printable characters without comma",
        )?;
        let again = sensors[..place].iter().any(|other| other.kind == sensor.kind);
        check(!again, "plc.sensor.kind", sensor.kind, "one sensor of each kind")?;
    }
    Ok(())
}

/// Whether a text can be a parameter in the middle of a status.
pub(crate) fn is_name(name: &str) -> bool {
    is_plain_text(name) && name.len() <= 64 && !name.contains(',')
}

impl SonarConfig {
    pub(super) fn sub_bottom() -> Self {
        let pulse = |name: &str, start_khz, end_khz, length_ms| PulseConfig {
            name: name.to_owned(),
            start_khz,
            end_khz,
            length_ms,
        };
        Self {
            start_s: Span::between(2.0, 4.0),
            shutdown_s: Span::between(1.0, 2.0),
            range_m: 75.0,
            range_min_m: 5.0,
            range_max_m: 300.0,
            power_percent: 100.0,
            gain_steps: 0,
            gain_max_steps: 60,
            period_ms: 200.0,
            sample_interval_us: 40,
            weighting_factor: 12,
            pulses: vec![
                pulse("FM 4-24 kHz 10 ms", 4.0, 24.0, 10.0),
                pulse("FM 2-16 kHz 20 ms", 2.0, 16.0, 20.0),
                pulse("FM 4-20 kHz 5 ms", 4.0, 20.0, 5.0),
            ],
        }
    }

    pub(super) fn sidescan_low() -> Self {
        Self {
            range_m: 100.0,
            range_min_m: 10.0,
            range_max_m: 500.0,
            period_ms: 150.0,
            pulses: vec![PulseConfig {
                name: "FM 110-130 kHz 8 ms".to_owned(),
                start_khz: 110.0,
                end_khz: 130.0,
                length_ms: 8.0,
            }],
            ..Self::sub_bottom()
        }
    }

    pub(super) fn sidescan_high() -> Self {
        Self {
            range_m: 75.0,
            range_min_m: 5.0,
            range_max_m: 150.0,
            period_ms: 110.0,
            sample_interval_us: 20,
            pulses: vec![PulseConfig {
                name: "FM 390-430 kHz 4 ms".to_owned(),
                start_khz: 390.0,
                end_khz: 430.0,
                length_ms: 4.0,
            }],
            ..Self::sub_bottom()
        }
    }

    pub(super) fn validate(&self, table: &str) -> Result<(), PlcError> {
        let key = |key: &str| format!("plc.{table}.{key}");
        span_within(self.start_s, 0.0, 600.0, &key("start_s"), "s")?;
        span_within(self.shutdown_s, 0.0, 600.0, &key("shutdown_s"), "s")?;
        for (name, value, least, most, unit) in [
            ("range_min_m", self.range_min_m, 1.0, 1000.0, "m"),
            ("range_max_m", self.range_max_m, self.range_min_m, 1000.0, "m"),
            ("range_m", self.range_m, self.range_min_m, self.range_max_m, "m"),
            ("power_percent", self.power_percent, 0.0, 100.0, "%"),
            ("gain_max_steps", f64::from(self.gain_max_steps), 0.0, 1000.0, "steps"),
            (
                "gain_steps",
                f64::from(self.gain_steps),
                0.0,
                f64::from(self.gain_max_steps),
                "steps",
            ),
            ("period_ms", self.period_ms, PERIOD_MIN_MS, PERIOD_MAX_MS, "ms"),
            (
                "sample_interval_us",
                f64::from(self.sample_interval_us),
                1.0,
                1000.0,
                "us",
            ),
            ("pulses", self.pulses.len() as f64, 1.0, 32.0, "pulses"),
        ] {
            within(value, least, most, &key(name), unit)?;
        }
        for pulse in &self.pulses {
            check(
                is_name(&pulse.name),
                &key("pulses.name"),
                format!("{:?}", pulse.name),
                "1 to 64 printable characters without comma",
            )?;
            within(pulse.start_khz, 0.1, 655.0, &key("pulses.start_khz"), "kHz")?;
            within(pulse.end_khz, 0.1, 655.0, &key("pulses.end_khz"), "kHz")?;
            within(pulse.length_ms, 0.01, 1000.0, &key("pulses.length_ms"), "ms")?;
        }
        Ok(())
    }
}

/// The least and greatest time from ping to ping, ms: also for the command "Duration".
pub(crate) const PERIOD_MIN_MS: f64 = 10.0;
pub(crate) const PERIOD_MAX_MS: f64 = 60_000.0;

/// The keys of a sonar's table, all of them optional.
macro_rules! optional_keys {
    ($($key:ident: $Type:ty,)*) => {
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        struct SonarKeys {
            $( $key: Option<$Type>, )*
        }

        impl SonarKeys {
            fn over(self, mut defaults: SonarConfig) -> SonarConfig {
                $( if let Some(value) = self.$key { defaults.$key = value; } )*
                defaults
            }
        }
    };
}

optional_keys! {
    start_s: Span,
    shutdown_s: Span,
    range_m: f64,
    range_min_m: f64,
    range_max_m: f64,
    power_percent: f64,
    gain_steps: i32,
    gain_max_steps: i32,
    period_ms: f64,
    sample_interval_us: u32,
    weighting_factor: i16,
    pulses: Vec<PulseConfig>,
}

pub(super) fn sub_bottom<'de, D: Deserializer<'de>>(deserializer: D) -> Result<SonarConfig, D::Error> {
    Ok(SonarKeys::deserialize(deserializer)?.over(SonarConfig::sub_bottom()))
}

pub(super) fn sidescan_low<'de, D: Deserializer<'de>>(deserializer: D) -> Result<SonarConfig, D::Error> {
    Ok(SonarKeys::deserialize(deserializer)?.over(SonarConfig::sidescan_low()))
}

pub(super) fn sidescan_high<'de, D: Deserializer<'de>>(deserializer: D) -> Result<SonarConfig, D::Error> {
    Ok(SonarKeys::deserialize(deserializer)?.over(SonarConfig::sidescan_high()))
}
