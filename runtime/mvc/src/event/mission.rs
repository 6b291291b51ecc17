use core::fmt;
use core::time::Duration;

use backseat_spi::{BehaviorId, Text};

use crate::event::ClientId;
use crate::plan::PayloadText;

/// What the executive did because the plan or a payload asked for it.
#[derive(Clone, Debug, PartialEq)]
pub enum MissionEvent {
    /// The vehicle sent a text of the plan to the payload.
    Told {
        /// The role of the client that gets it (SPI 4.1); `None` for every client.
        role: Option<Box<str>>,
        /// Which message.
        what: Told,
        /// The text.
        text: Text,
    },
    /// A dive was loaded. The mission's status says whether it is ready.
    DiveLoaded(Text),
    /// A GPS hit has its fix.
    GpsFix(BehaviorId),
    /// A GPS hit ended without a fix.
    NoGpsFix(BehaviorId),
    /// BPABT: a payload ends the mission.
    Abort {
        /// Which client.
        client: ClientId,
        /// Whether the mission counts as aborted with errors; otherwise as successful.
        errors: bool,
        /// Why.
        text: Text,
    },
    /// BPKIL: a payload ends the mission and all movement.
    Kill(ClientId, Text),
    /// BPRCB: a payload ends the current behavior.
    CancelCurrent(ClientId),
    /// BPRCE: a payload ends the current element.
    CancelElement(ClientId),
    /// BPSEM: a payload starts an empty mission that may last this long.
    EmptyMission(ClientId, Duration),
}

/// A message of the plan to the payload.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Told {
    /// BFMSC (SPI 5.1).
    Command,
    /// BFBDL (SPI 5.3).
    LoggingBegins,
    /// BFSDL (SPI 5.4).
    LoggingEnds,
}

impl MissionEvent {
    pub(crate) fn told(message: &PayloadText, what: Told) -> Self {
        Self::Told {
            role: message.role.clone(),
            what,
            text: message.text.clone(),
        }
    }
}

impl fmt::Display for MissionEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Told { role, what, text } => {
                let role = role.as_deref().unwrap_or("every client");
                match what {
                    Told::Command => write!(f, "mission command to {role}: {text}"),
                    Told::LoggingBegins => write!(f, "start of logging, to {role}: {text}"),
                    Told::LoggingEnds => write!(f, "end of logging, to {role}: {text}"),
                }
            }
            Self::DiveLoaded(file) => write!(f, "dive {file} is loaded"),
            Self::GpsFix(id) => write!(f, "gps fix of insert {id}"),
            Self::NoGpsFix(id) => write!(f, "no gps fix of insert {id}: its time is over"),
            Self::Abort {
                client,
                errors: true,
                text,
            } => write!(f, "{client} aborts the mission: {text}"),
            Self::Abort {
                client,
                errors: false,
                text,
            } => write!(f, "{client} ends the mission as successful: {text}"),
            Self::Kill(client, text) => write!(f, "{client} kills the mission: {text}"),
            Self::CancelCurrent(client) => write!(f, "{client} ends the current behavior"),
            Self::CancelElement(client) => write!(f, "{client} ends the current element"),
            Self::EmptyMission(client, most) => {
                write!(
                    f,
                    "{client} starts an empty mission of at most {} s",
                    most.as_secs_f64()
                )
            }
        }
    }
}
