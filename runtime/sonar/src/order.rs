use backseat_s7k::SensorIndex;
use backseat_s7k::plc::Generic;
use serde::Serialize;

use crate::config::SonarConfig;
use crate::logging::FileDetails;

/// How many orders may wait for their turn.
pub const ORDERS_MAX: usize = 32;

/// How long the name of a log file may be, bytes.
pub(crate) const FILE_BYTES: usize = 64;

/// What the driver wants of the controller: because the vehicle says so, or because a plugin may ask for it.
///
/// Each order has one [`Outcome`].
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    /// Logging on or off (command 1). With a name, logging then changes to that file (command 2). The outcome has the
    /// controller's answer to command 18. On a later connection the client restores what was ordered last.
    Logging {
        /// On or off.
        on: bool,
        /// The name of the file: 1 to 64 ASCII characters without path separators; only with `on`.
        file: Option<Box<str>>,
    },
    /// Changes the log file now (command 2).
    SwitchFile {
        /// The name of the file as for [`Order::Logging`], or `Auto` for automatic names.
        file: Box<str>,
    },
    /// A setting of a sensor (command 0): range, pulse, ping, gain, power, period.
    Set {
        /// The sensor, which must be configured.
        sensor: SensorIndex,
        /// The setting.
        setting: Generic,
    },
    /// The power will be cut: stop logging, then shut the controller down (command 13). The client ends within 10 s.
    Shutdown,
}

/// How an order ended.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The controller has accepted it.
    Accepted {
        /// The state of logging, for orders that concern it; `None` if the controller did not say.
        details: Option<FileDetails>,
    },
    /// It was sent, and the controller does not acknowledge commands by our own setting `verbose = false`.
    Unconfirmed,
    /// The controller has accepted it, but did not do all of it: logging is not as ordered, or the name of the file was
    /// rejected.
    Incomplete {
        /// The state of logging.
        details: Option<FileDetails>,
    },
    /// The controller has rejected it.
    Rejected,
    /// The controller does not know the command.
    Unknown,
    /// The time was over.
    TimedOut {
        /// Whether it was sent. If so, nobody knows whether the controller did it.
        sent: bool,
    },
    /// The connection was lost before the answer: nobody knows whether the controller did it.
    Lost,
    /// The client did not send it.
    Refused {
        /// Why.
        why: Box<str>,
    },
}

impl Outcome {
    pub(crate) fn refused(why: &str) -> Self {
        Self::Refused { why: Box::from(why) }
    }
}

impl Order {
    /// Why the order cannot be sent, if so.
    pub(crate) fn check(&self, config: &SonarConfig) -> Result<(), &'static str> {
        match self {
            Self::Logging {
                on: false,
                file: Some(_),
            } => Err("a file name needs logging on"),
            Self::Logging { on: _, file: None } | Self::Shutdown => Ok(()),
            Self::Logging {
                on: true,
                file: Some(file),
            }
            | Self::SwitchFile { file } => check_file(file),
            Self::Set { sensor, .. } if !config.has(*sensor) => Err("the sensor is not configured"),
            Self::Set { sensor: _, setting } => check_setting(setting),
        }
    }
}

/// A name must not lead out of the folder of logged data, and must be a name on every system.
fn check_file(file: &str) -> Result<(), &'static str> {
    let allowed = |byte: u8| byte.is_ascii_graphic() && !br#"/\:*?"<>|,"#.contains(&byte) || byte == b' ';
    if file.is_empty() || file.len() > FILE_BYTES || file.trim() != file {
        Err("a file name has 1 to 64 characters and no space at its ends")
    } else if !file.bytes().all(allowed) || file.starts_with('.') {
        Err(
            "a file name has no path separators, commas, wildcards or characters outside ASCII, and no dot at its begin",
        )
    } else {
        Ok(())
    }
}

pub(crate) fn check_setting(setting: &Generic) -> Result<(), &'static str> {
    let positive = |value: f64| value.is_finite() && value > 0.0 && value < 1e6;
    match setting {
        Generic::Range { range_m } if !positive(*range_m) => Err("the range must be over 0 m"),
        Generic::Duration { period_ms } if !positive(*period_ms) => Err("the period must be over 0 ms"),
        Generic::TxPower { percent } if !(0.0..=100.0).contains(percent) => Err("the power must be within 0 to 100 %"),
        Generic::Pulse { name } if name.len() > 128 => Err("the name of a pulse has at most 128 bytes"),
        Generic::Range { .. }
        | Generic::Pulse { .. }
        | Generic::Ping { .. }
        | Generic::TxPower { .. }
        | Generic::RxGain { .. }
        | Generic::Duration { .. }
        | Generic::PulseFiles {}
        | Generic::DefaultState {} => setting
            .write(&mut String::new())
            .map_err(|_| "the name of a pulse has no control characters, and no spaces at its ends"),
    }
}

impl std::fmt::Display for Outcome {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let with = |f: &mut std::fmt::Formatter<'_>, words: &str, details: &Option<FileDetails>| match details {
            Some(details) => write!(f, "{words}: {details}"),
            None => f.write_str(words),
        };
        match self {
            Self::Accepted { details } => with(f, "accepted", details),
            Self::Unconfirmed => f.write_str("sent, without acknowledgement"),
            Self::Incomplete { details } => with(f, "accepted, but not done as ordered", details),
            Self::Rejected => f.write_str("rejected by the controller"),
            Self::Unknown => f.write_str("unknown to the controller"),
            Self::TimedOut { sent: true } => f.write_str("not answered in time"),
            Self::TimedOut { sent: false } => f.write_str("not sent in time"),
            Self::Lost => f.write_str("lost with the connection"),
            Self::Refused { why } => write!(f, "refused: {why}"),
        }
    }
}
