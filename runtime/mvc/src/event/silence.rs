use core::fmt;

use super::client::ClientId;

/// What happened to silent mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SilenceEvent {
    /// A client asked for it, and the devices are becoming quiet.
    Asked(ClientId),
    /// The vehicle is silent.
    Began,
    /// It did not begin, for this reason.
    Failed(&'static str),
    /// It ended at a payload's request.
    Ended,
    /// It ended because its time limit was over.
    TimedOut,
    /// The mission's wrap-up ended it, because the vehicle climbs under power.
    WrapUp,
}

impl fmt::Display for SilenceEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Asked(client) => write!(f, "{client} asks for silent mode"),
            Self::Began => f.write_str("silent mode began"),
            Self::Failed(why) => write!(f, "silent mode did not begin: {why}"),
            Self::Ended => f.write_str("silent mode ended: a payload asked for it"),
            Self::TimedOut => f.write_str("silent mode ended: timed out"),
            Self::WrapUp => f.write_str("silent mode ended: the mission wraps up"),
        }
    }
}
