use core::fmt;

use backseat_spi::{RelayedText, Text, Transport};

use super::client::ClientId;

/// What passed between the payloads and the topside.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TopsideEvent {
    /// A payload's message waits for its delivery.
    Queued(ClientId, Text),
    /// A payload's message was delivered to the topside, over this link.
    Delivered(Transport, Text),
    /// A message from the topside went to the payloads, or to the one with this role.
    Received(Transport, Option<Box<str>>, Text),
    /// A payload relayed a message that it received with its own modem.
    Relayed(ClientId, Transport, RelayedText),
}

impl fmt::Display for TopsideEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Queued(client, text) => write!(f, "{client} sends to the topside: {text}"),
            Self::Delivered(transport, text) => write!(f, "delivered to the topside by {}: {text}", name(*transport)),
            Self::Received(transport, Some(role), text) => {
                write!(f, "message from the topside to {role} by {}: {text}", name(*transport))
            }
            Self::Received(transport, None, text) => {
                write!(f, "message from the topside by {}: {text}", name(*transport))
            }
            Self::Relayed(client, transport, text) => {
                write!(f, "{client} relays from the topside by {}: {text}", name(*transport))
            }
        }
    }
}

const fn name(transport: Transport) -> &'static str {
    match transport {
        Transport::Ethernet => "ethernet",
        Transport::Wifi => "802.11",
        Transport::RfModem => "RF modem",
        Transport::AcousticModem => "acoustic modem",
        Transport::Other(_) => "unknown link",
    }
}
