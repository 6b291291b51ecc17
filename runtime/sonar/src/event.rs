//! What the client reports.

use backseat_s7k::SensorIndex;
use backseat_s7k::plc::{CommandId, HealthEntry, ModuleEntry, PlcVersion, PulseName, RunListEntry};
use serde::Serialize;

use crate::alarm::AlarmState;
use crate::counts::Counts;
use crate::io::Ticket;
use crate::logging::FileDetails;
use crate::order::Outcome;
use crate::swath::Swath;

/// Something that has happened. Its `Display` is a line for the log.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "event", rename_all = "kebab-case")]
pub enum Event {
    /// The connection came up.
    Connected,
    /// The connection was lost, could not be made, or was reset.
    Disconnected {
        /// The controller's host and port.
        address: Box<str>,
        /// Why.
        why: &'static str,
        /// The next attempt comes after this, seconds; `None` if none comes.
        retry_s: Option<f64>,
    },
    /// Everything that is said on a new connection has been said: data come, and orders are sent.
    Ready,
    /// A command of the client's own was not accepted.
    CommandFailed {
        /// The command.
        command: CommandId,
        /// The sensor that it is about.
        sensor: SensorIndex,
        /// What became of it.
        why: Box<str>,
    },
    /// A sensor rejects its settings, as each does that has not started yet. Reported once on a connection.
    SensorStarting {
        /// The sensor.
        sensor: SensorIndex,
        /// Its settings are sent again after this, seconds.
        again_s: f64,
    },
    /// A sensor does not take a setting of the mission.
    SettingFailed {
        /// The sensor.
        sensor: SensorIndex,
        /// The setting with its value, as it was sent.
        setting: Box<str>,
        /// What became of it.
        why: Box<str>,
        /// Whether it is sent again.
        again: bool,
    },
    /// Imagery of a device or a type that no configured sensor has. Reported once on a connection.
    NotSubscribed {
        /// The record's device.
        device: u32,
        /// The record's type.
        record_type: u32,
        /// Devices and types of the configured sensors.
        expected: Vec<(u32, Vec<u32>)>,
    },
    /// The controller's version.
    Version {
        /// The version.
        version: PlcVersion,
    },
    /// The sensor modules that the controller supports.
    Modules {
        /// The modules.
        modules: Vec<ModuleEntry>,
    },
    /// The sensors that the controller has loaded.
    RunList {
        /// The sensors.
        sensors: Vec<RunListEntry>,
        /// Configured sensors that are not among them.
        missing: Vec<SensorIndex>,
    },
    /// Size and overlap of the controller's log files.
    LoggingSetup {
        /// The size at which the next file begins, megabytes.
        file_size: u32,
        /// How many records of a file the next one repeats.
        overlap: u32,
        /// The folder of logged data, cut to 260 bytes.
        folder: Box<str>,
    },
    /// Logging went on or off, or to another file.
    Logging {
        /// Its state.
        details: FileDetails,
        /// Whether it is off although it was ordered on.
        missing: bool,
    },
    /// The health of the sensors has changed.
    Health {
        /// Each sensor's.
        sensors: Vec<HealthEntry>,
    },
    /// The pulses of a sensor, which an order asked for.
    Pulses {
        /// Their names.
        pulses: Vec<PulseName>,
    },
    /// The controller's clock was measured, or has changed against ours.
    Clock {
        /// The controller's clock less ours, seconds.
        offset_s: f64,
        /// How far the true offset can be from that, seconds; `None` if the controller has not answered yet.
        within_s: Option<f64>,
    },
    /// An alarm began, ended or happened.
    Alarm {
        /// The alarm.
        alarm: AlarmState,
    },
    /// The controller says that no alarm is active any more.
    AlarmsClear,
    /// There were too many events. These alarms are active now.
    ActiveAlarms {
        /// The alarms.
        alarms: Vec<AlarmState>,
    },
    /// How wide the seabed is seen.
    Swath(Swath),
    /// An order has ended.
    Outcome {
        /// The order.
        ticket: Ticket,
        /// How.
        outcome: Outcome,
    },
    /// The controller is shutting down by itself. The client tries to connect at the longest pause.
    ControllerShutdown,
    /// Something of the controller cannot be read. At most one in ten seconds; the others are counted.
    Malformed {
        /// What, in a line.
        text: Box<str>,
    },
    /// What could not be used or was dropped has grown. At most one in ten seconds.
    Counts {
        /// All counts since the start.
        counts: Counts,
    },
}

impl Event {
    /// Whether plugins may see it: alarms, logging, health, the swath, and whether data come.
    #[must_use]
    pub const fn is_for_plugins(&self) -> bool {
        match self {
            Self::Ready
            | Self::Disconnected { .. }
            | Self::Logging { .. }
            | Self::Health { .. }
            | Self::Alarm { .. }
            | Self::AlarmsClear
            | Self::ActiveAlarms { .. }
            | Self::Swath(_)
            | Self::ControllerShutdown => true,
            Self::Connected
            | Self::CommandFailed { .. }
            | Self::SensorStarting { .. }
            | Self::SettingFailed { .. }
            | Self::NotSubscribed { .. }
            | Self::Version { .. }
            | Self::Modules { .. }
            | Self::RunList { .. }
            | Self::LoggingSetup { .. }
            | Self::Pulses { .. }
            | Self::Clock { .. }
            | Self::Outcome { .. }
            | Self::Malformed { .. }
            | Self::Counts { .. } => false,
        }
    }
}

impl std::fmt::Display for Event {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Connected => f.write_str("connected to the payload controller"),
            Self::Disconnected { address, why, retry_s } => {
                write!(f, "no connection to the payload controller at {address}: {why}")?;
                match retry_s {
                    Some(retry_s) => write!(f, "; next attempt in {retry_s:.1} s"),
                    None => Ok(()),
                }
            }
            Self::Ready => f.write_str("the payload controller is ready"),
            Self::CommandFailed { command, sensor, why } if *sensor == SensorIndex::PLC => {
                write!(f, "command {command:?} {why}")
            }
            Self::CommandFailed { command, sensor, why } => write!(f, "command {command:?} for sensor {sensor} {why}"),
            Self::SensorStarting { sensor, again_s } => {
                write!(
                    f,
                    "sensor {sensor} is starting; its settings are sent again every {again_s:.0} s"
                )
            }
            Self::SettingFailed {
                sensor,
                setting,
                why,
                again,
            } => {
                let then = if *again {
                    "it is sent again with each health check; look at the value"
                } else {
                    "it is not sent again"
                };
                write!(f, "setting \"{setting}\" for sensor {sensor} {why}; {then}")
            }
            Self::NotSubscribed {
                device,
                record_type,
                expected,
            } => {
                write!(f, "not used: records {record_type} of device {device}; expected")?;
                for (place, (device, records)) in expected.iter().enumerate() {
                    let records: Vec<String> = records.iter().map(u32::to_string).collect();
                    let comma = if place == 0 { "" } else { "," };
                    write!(f, "{comma} {} of device {device}", records.join(" and "))?;
                }
                match expected.is_empty() {
                    true => f.write_str(" none, because [sonar] has no [[sonar.sensor]]"),
                    false => Ok(()),
                }
            }
            Self::Version { version } => write!(f, "the payload controller has version {version}"),
            Self::Modules { modules } => {
                write!(f, "{} sensor modules", modules.len())?;
                modules
                    .iter()
                    .try_for_each(|module| write!(f, "; {} {}", module.file, module.version))
            }
            Self::RunList { sensors, missing } => {
                write!(f, "{} sensors", sensors.len())?;
                for sensor in sensors {
                    write!(f, "; {} {}", sensor.sensor, sensor.name)?;
                }
                missing
                    .iter()
                    .try_for_each(|sensor| write!(f, "; sensor {sensor} is configured and not loaded"))
            }
            Self::LoggingSetup {
                file_size,
                overlap,
                folder,
            } => write!(
                f,
                "log files of {file_size} MB with {overlap} records of overlap in {folder}"
            ),
            Self::Logging {
                details,
                missing: false,
            } => write!(f, "{details}"),
            Self::Logging { details, missing: true } => write!(f, "{details}, although it was ordered on"),
            Self::Health { sensors } => {
                f.write_str("health")?;
                for entry in sensors {
                    let word = if entry.healthy { "healthy" } else { "unhealthy" };
                    write!(f, "; sensor {} {word}", entry.sensor)?;
                }
                Ok(())
            }
            Self::Pulses { pulses } => {
                write!(f, "{} pulses", pulses.len())?;
                pulses.iter().try_for_each(|pulse| write!(f, "; {}", pulse.0))
            }
            Self::Clock { offset_s, within_s } => {
                // No "-0.000".
                let offset_s = (offset_s * 1000.0).round() / 1000.0 + 0.0;
                write!(f, "the payload controller's clock is {offset_s:+.3} s from ours")?;
                match within_s {
                    Some(within_s) => write!(f, " (within {within_s:.3} s)"),
                    None => f.write_str(" at least"),
                }
            }
            Self::Alarm { alarm } => write!(f, "alarm: {alarm}"),
            Self::AlarmsClear => f.write_str("all alarms are clear"),
            Self::ActiveAlarms { alarms } => {
                write!(f, "{} alarms are active", alarms.len())?;
                alarms.iter().try_for_each(|alarm| write!(f, "; {}", alarm.title()))
            }
            Self::Swath(swath) => write!(f, "{swath}"),
            Self::Outcome { ticket, outcome } => write!(f, "order {}: {outcome}", ticket.0),
            Self::ControllerShutdown => f.write_str("the payload controller is shutting down"),
            Self::Malformed { text } => f.write_str(text),
            Self::Counts { counts } => write!(f, "not used: {counts}"),
        }
    }
}
