use core::fmt;

use backseat_spi::FrameSentStatus;

use super::client::ClientId;

/// What happened on the acoustic modem.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AcousticEvent {
    /// The payload's window began, and BFCMA was sent.
    WindowBegan,
    /// The payload's window ended.
    WindowEnded,
    /// A window was skipped because the vehicle is silent.
    WindowSkipped,
    /// A payload's packet is queued.
    Queued(ClientId, u32),
    /// A payload's packet was ignored because it arrived outside a window.
    Ignored(ClientId, u32),
    /// A packet was sent to a modem, which heard it or did not.
    Sent {
        /// The identifier of its request.
        request: u32,
        /// The address of the modem that it was for.
        destination: u32,
        /// Whether that modem heard it.
        heard: bool,
        /// The status of its frames, as BFCPS reports it.
        status: FrameSentStatus,
    },
    /// A packet was not sent, because its window ended or the vehicle is silent.
    NotSent(u32),
    /// A packet arrived from the modem with this address.
    Received(u32),
    /// A packet from the modem with this address was not heard.
    NotHeard(u32),
}

impl fmt::Display for AcousticEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::WindowBegan => f.write_str("acoustic window began"),
            Self::WindowEnded => f.write_str("acoustic window ended"),
            Self::WindowSkipped => f.write_str("acoustic window skipped: the vehicle is silent"),
            Self::Queued(client, request) => write!(f, "packet {request} of {client} queued"),
            Self::Ignored(client, request) => write!(f, "packet {request} of {client} ignored: outside a window"),
            Self::Sent {
                request,
                destination,
                heard,
                status,
            } => {
                let heard = if *heard { "heard" } else { "not heard" };
                write!(f, "packet {request} sent to modem {destination}, {heard}")?;
                match status {
                    FrameSentStatus::Acked => f.write_str(", acknowledged"),
                    FrameSentStatus::Unset
                    | FrameSentStatus::Unacknowledged
                    | FrameSentStatus::FailedToSend
                    | FrameSentStatus::Other(_) => Ok(()),
                }
            }
            Self::NotSent(request) => write!(f, "packet {request} was not sent"),
            Self::Received(source) => write!(f, "packet from modem {source} received"),
            Self::NotHeard(source) => write!(f, "packet from modem {source} was not heard"),
        }
    }
}
