use core::fmt;

use super::client::ClientId;

/// What happened to the DVL's triggering.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DvlTriggerEvent {
    /// A client asks for external triggering.
    Asked(ClientId),
    /// The payload may trigger (BFDVT 1).
    Began,
    /// The payload must stop triggering because it asked to end (BFDVT 0).
    StopAsked,
    /// The payload must stop triggering because the vehicle decided so (BFDVT 0).
    StopOrdered,
    /// The DVL is triggered internally again.
    Internal,
    /// The payload did not trigger the DVL in time, so it is triggered internally again.
    TimedOut,
    /// A client reports that it triggers although it may not.
    WithoutLeave(ClientId),
}

impl fmt::Display for DvlTriggerEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Asked(client) => write!(f, "{client} asks to trigger the DVL"),
            Self::Began => f.write_str("external DVL triggering began"),
            Self::StopAsked => f.write_str("DVL triggering: the payload must stop, as it asked"),
            Self::StopOrdered => f.write_str("DVL triggering: the vehicle orders the payload to stop"),
            Self::Internal => f.write_str("the DVL is triggered internally"),
            Self::TimedOut => f.write_str("the DVL is triggered internally: the payload did not trigger it"),
            Self::WithoutLeave(client) => write!(f, "{client} says that it triggers the DVL without permission"),
        }
    }
}
