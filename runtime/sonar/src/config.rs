//! The settings of the client: the table `[sonar]` of mission.toml.

use std::ops::RangeInclusive;
use std::time::Duration;

use backseat_s7k::plc::Generic;
use backseat_s7k::{BluefinChecksum, SensorIndex};
use serde::de::{Error as _, Unexpected};
use serde::{Deserialize, Deserializer, Serialize};

use crate::order::check_setting;

/// The settings of the client. Every key has a default; [`SonarConfig::check`] compares the values with their ranges.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SonarConfig {
    /// The controller's host name or address. Default `127.0.0.1`: a simulated controller on this computer.
    pub host: String,
    /// The controller's TCP port, 1 to 65535. Default 7000: no port is published for the 6046, and this is the port of
    /// its successor.
    #[serde(deserialize_with = "port")]
    pub port: u16,
    /// The sensors of the controller whose data are wanted, at most 16. Default: none.
    pub sensor: Vec<SensorConfig>,
    /// Whether the controller acknowledges commands (command 11). Without acknowledgements a command that solicits no
    /// message ends as [`crate::Outcome::Unconfirmed`]. Default `true`.
    pub verbose: bool,
    /// Whether the client sets the controller's clock on each connection (command 20). Default `true`.
    pub time_sync: bool,
    /// Whether the controller sends a time message about once a minute (command 28, record 7400). The setting holds
    /// for all clients of the controller. Default `true`.
    pub time_messages: bool,
    /// What the client shuts down when the vehicle is about to cut the power. Default `controller`.
    pub shutdown: ShutdownKind,
    /// Size and overlap of the controller's log files (command 26). Default: left as they are.
    pub logging: Option<LoggingSetup>,
    /// Whether logging follows the vehicle: on at BFBDL, off at BFSDL (SPI 5.3, 5.4). This setting is for the driver,
    /// which gives the orders. Default `true`.
    pub log_with_vehicle: bool,
    /// Whether the client passes the vehicle's navigation and speed of sound to the controller (record 3100). Default
    /// `true`.
    pub vehicle_data: bool,
    /// The sensor to which the controller routes records that are not for itself (command 24), 0 or more. Default: the
    /// controller's own setting.
    pub route_to: Option<i32>,
    /// What the position and attitude times of a navigation frame hold, which the specification leaves open. Default
    /// `unix`.
    pub navigation_times: NavigationTimes,
    /// How the checksum of a Bluefin frame is computed, which the specification leaves open: `whole_packet`,
    /// `data_only` or `none`. Default `whole_packet`.
    pub bluefin_checksum: BluefinChecksum,
    /// What happens to a record whose checksum is wrong. Default `count`.
    pub checksum: ChecksumPolicy,
    /// Which layout of the imagery's header the controller is expected to write. Both are read in any case; a record
    /// in another one is counted. Default `any`.
    pub header_layout: ExpectedLayout,
    /// The pause before the first new attempt to connect, seconds, 0.1 to 60. It doubles with each attempt. Default 1.
    pub reconnect_min_s: f64,
    /// The longest pause between two attempts to connect, seconds, `reconnect_min_s` to 600. Default 60.
    pub reconnect_max_s: f64,
    /// How long the controller may take to answer a command, seconds, 0.2 to 30. Default 3.
    pub command_timeout_s: f64,
    /// How often a command is sent in all before it counts as unanswered, 1 to 10. Default 3.
    pub command_attempts: u32,
    /// How often the client asks for the sensors' health (command 21), seconds, 1 to 600. This is also how it notices
    /// that the controller has stalled. Default 10.
    pub health_period_s: f64,
    /// The longest record that is read, bytes, 65536 to 67108864. Default 4194304.
    pub frame_limit_bytes: usize,
}

/// A sensor of the controller.
///
/// The client sends the settings (command 0) on each connection, so what a plugin has changed is lost with a connection.
/// Without a setting, the sensor keeps its own.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorConfig {
    /// The sensor's index in the controller's run list, 0 or more.
    pub index: i32,
    /// The device identifier in the frames of its records: 11000 sub-bottom, 11001 low-frequency sidescan, 11002
    /// high-frequency sidescan. Records carry no sensor index, so this is how they are told apart.
    pub device: u32,
    /// The record types to subscribe to, at most 8: 3000 sidescan, 3001 sub-bottom.
    pub records: Vec<u32>,
    /// Its range, metres, over 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range_m: Option<f64>,
    /// Its pulse, by the sonar's own name for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pulse: Option<String>,
    /// Its power, 0 to 100 %.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub power_percent: Option<f64>,
    /// The receiver's gain, in the sonar's own steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gain: Option<i32>,
    /// The time from ping to ping, milliseconds, over 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub period_ms: Option<f64>,
    /// Whether it pings. Sent after its other settings.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ping: Option<bool>,
}

impl SensorConfig {
    /// Its settings, in the order in which they are sent.
    pub(crate) fn settings(&self) -> impl Iterator<Item = (&'static str, Generic)> + '_ {
        let pulse = |name: &String| Generic::Pulse {
            name: Box::from(name.as_str()),
        };
        let settings = [
            ("range_m", self.range_m.map(|range_m| Generic::Range { range_m })),
            ("pulse", self.pulse.as_ref().map(pulse)),
            (
                "power_percent",
                self.power_percent.map(|percent| Generic::TxPower { percent }),
            ),
            ("gain", self.gain.map(|gain| Generic::RxGain { gain })),
            (
                "period_ms",
                self.period_ms.map(|period_ms| Generic::Duration { period_ms }),
            ),
            ("ping", self.ping.map(|on| Generic::Ping { on })),
        ];
        settings.into_iter().filter_map(|(key, setting)| Some((key, setting?)))
    }
}

/// What command 13 shuts down.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ShutdownKind {
    /// The controller's program only.
    #[default]
    Controller,
    /// The operating system too, and the sensors that can.
    System,
}

/// Size and overlap of log files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoggingSetup {
    /// The size at which the next file begins, 1 to 100000. The specification states no unit; the status has megabytes.
    pub file_size: u32,
    /// How many records of a file the next one repeats, 0 to 1000.
    pub overlap: u32,
}

/// What the times in a navigation frame hold. The frame's header has the time of the solution in any case.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NavigationTimes {
    /// Seconds since 1970, UTC.
    #[default]
    Unix,
    /// Seconds since midnight, UTC, as SPI has times.
    Day,
    /// Nothing: both are zero and their quality bits are clear.
    Invalid,
}

/// What happens to a record whose checksum is wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ChecksumPolicy {
    /// It is counted and used: there are writers whose checksums are wrong.
    #[default]
    Count,
    /// It is counted and dropped.
    Refuse,
    /// Checksums are not computed, which saves a pass over the bytes.
    Ignore,
}

/// Which layout of the imagery's header is expected.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ExpectedLayout {
    /// Either.
    #[default]
    Any,
    /// 20 bytes, as in the specification.
    Spec,
    /// 32 bytes, as the best-known public reader expects.
    Padded,
}

/// A setting outside its range.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("sonar setting {key}: {found} is not {expected}")]
pub struct ConfigError {
    /// The key.
    pub key: String,
    /// The value.
    pub found: String,
    /// What it has to be.
    pub expected: String,
}

/// How many sensors may be configured.
pub(crate) const SENSORS_MAX: usize = 16;
/// How many record types of a sensor may be subscribed to.
const RECORDS_MAX: usize = 8;

/// Reads a port, and names its range, which the type alone does not.
fn port<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u16, D::Error> {
    let number = i64::deserialize(deserializer)?;
    let port = u16::try_from(number).ok().filter(|port| *port > 0);
    port.ok_or_else(|| D::Error::invalid_value(Unexpected::Signed(number), &"1 to 65535"))
}

impl Default for SonarConfig {
    fn default() -> Self {
        Self {
            host: "127.0.0.1".to_owned(),
            port: 7000,
            sensor: Vec::new(),
            verbose: true,
            time_sync: true,
            time_messages: true,
            shutdown: ShutdownKind::Controller,
            logging: None,
            log_with_vehicle: true,
            vehicle_data: true,
            route_to: None,
            navigation_times: NavigationTimes::Unix,
            bluefin_checksum: BluefinChecksum::WholePacket,
            checksum: ChecksumPolicy::Count,
            header_layout: ExpectedLayout::Any,
            reconnect_min_s: 1.0,
            reconnect_max_s: 60.0,
            command_timeout_s: 3.0,
            command_attempts: 3,
            health_period_s: 10.0,
            frame_limit_bytes: 4 << 20,
        }
    }
}

impl SonarConfig {
    /// Compares every value with its range.
    ///
    /// # Errors
    /// [`ConfigError`] names the first key whose value is outside its range.
    pub fn check(&self) -> Result<(), ConfigError> {
        if self.host.is_empty() || self.host.len() > 253 {
            return Err(fault(
                "host",
                &self.host,
                "a host name or address of 1 to 253 characters",
            ));
        }
        if self.port == 0 {
            return Err(fault("port", &self.port, "within 1 to 65535"));
        }
        within("reconnect_min_s", self.reconnect_min_s, 0.1..=60.0)?;
        within("reconnect_max_s", self.reconnect_max_s, self.reconnect_min_s..=600.0)?;
        within("command_timeout_s", self.command_timeout_s, 0.2..=30.0)?;
        within("command_attempts", self.command_attempts, 1..=10)?;
        within("health_period_s", self.health_period_s, 1.0..=600.0)?;
        within("frame_limit_bytes", self.frame_limit_bytes, 1 << 16..=64 << 20)?;
        if let Some(sensor) = self.route_to {
            within("route_to", sensor, 0..=i32::MAX)?;
        }
        if let Some(logging) = self.logging {
            within("logging.file_size", logging.file_size, 1..=100_000)?;
            within("logging.overlap", logging.overlap, 0..=1000)?;
        }
        self.check_sensors()
    }

    fn check_sensors(&self) -> Result<(), ConfigError> {
        if self.sensor.len() > SENSORS_MAX {
            let expected = format!("at most {SENSORS_MAX} sensors");
            return Err(fault("sensor", &self.sensor.len(), &expected));
        }
        for (number, sensor) in self.sensor.iter().enumerate() {
            let key = |name: &str| format!("sensor[{number}].{name}");
            within(&key("index"), sensor.index, 0..=i32::MAX)?;
            if sensor.records.is_empty() || sensor.records.len() > RECORDS_MAX {
                let expected = format!("1 to {RECORDS_MAX} record types");
                return Err(fault(&key("records"), &sensor.records.len(), &expected));
            }
            for (name, setting) in sensor.settings() {
                check_setting(&setting).map_err(|expected| {
                    let mut found = String::new();
                    let _unwritable = setting.write(&mut found);
                    fault(&key(name), &found, &format!("allowed: {expected}"))
                })?;
            }
            for other in &self.sensor[..number] {
                if other.index == sensor.index {
                    return Err(fault(&key("index"), &sensor.index, "an index that no other sensor has"));
                }
                if other.device == sensor.device {
                    let expected = "a device that no other sensor has: records could not be told apart";
                    return Err(fault(&key("device"), &sensor.device, expected));
                }
            }
        }
        Ok(())
    }

    /// The sensor whose records come from the device.
    pub(crate) fn sensor_of(&self, device: u32) -> Option<&SensorConfig> {
        self.sensor.iter().find(|sensor| sensor.device == device)
    }

    /// Whether the sensor is configured.
    pub(crate) fn has(&self, sensor: SensorIndex) -> bool {
        self.sensor.iter().any(|known| known.index == sensor.0)
    }

    pub(crate) fn command_timeout(&self) -> Duration {
        seconds(self.command_timeout_s)
    }

    pub(crate) fn health_period(&self) -> Duration {
        seconds(self.health_period_s)
    }

    /// The pause before the attempt of this number, counted from 0: twice as long each time, up to the longest.
    pub(crate) fn pause(&self, attempt: u32) -> Duration {
        let doublings = attempt.min(20);
        let pause_s = self.reconnect_min_s * f64::from(1_u32 << doublings);
        seconds(pause_s.min(self.reconnect_max_s))
    }

    pub(crate) fn longest_pause(&self) -> Duration {
        seconds(self.reconnect_max_s)
    }
}

/// `check` has compared the seconds with their range.
fn seconds(seconds: f64) -> Duration {
    Duration::try_from_secs_f64(seconds).unwrap_or(Duration::from_secs(1))
}

fn fault(key: &str, found: &dyn std::fmt::Display, expected: &str) -> ConfigError {
    ConfigError {
        key: key.to_owned(),
        found: found.to_string(),
        expected: expected.to_owned(),
    }
}

fn within<T: PartialOrd + std::fmt::Display>(key: &str, value: T, range: RangeInclusive<T>) -> Result<(), ConfigError> {
    if range.contains(&value) {
        Ok(())
    } else {
        let expected = format!("within {} to {}", range.start(), range.end());
        Err(fault(key, &value, &expected))
    }
}
