use core::fmt;

use super::client::ClientId;

/// What happened to silent mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SilenceEvent {
    /// A client has asked for it: the devices are being quieted.
    Asked(ClientId),
    /// The vehicle is silent.
    Began,
    /// It could not be entered: why.
    Failed(&'static str),
    /// It ended at a payload's request.
    Ended,
    /// It ended by itself.
    TimedOut,
    /// The mission's wrap-up, a powered ascent, ended it.
    WrapUp,
}

impl fmt::Display for SilenceEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Asked(client) => write!(f, "{client} asks for silence"),
            Self::Began => f.write_str("silent mode began"),
            Self::Failed(why) => write!(f, "silent mode was not entered: {why}"),
            Self::Ended => f.write_str("silent mode ended: asked for"),
            Self::TimedOut => f.write_str("silent mode ended: timed out"),
            Self::WrapUp => f.write_str("silent mode ended: the mission wraps up"),
        }
    }
}
