//! Packets through the vehicle's acoustic modem (SPI 9; safety requirement 016).

use backseat_spi::{MediumAccess, PacketReceived, PacketSent};
use backseat_units::Timestamp;

use crate::commands::Answer;
use crate::helm::refused;
use crate::ledger::RequestKind;
use crate::machine::Core;
use crate::plugin::{PacketRequest, PluginId};

/// What is known of the modem.
#[derive(Debug, Default)]
pub(crate) struct Acoustic {
    until: Option<Timestamp>,
}

impl Acoustic {
    /// Whether the payload may send now.
    pub(crate) fn is_open(&self, now: Timestamp) -> bool {
        self.until.is_some_and(|until| now < until)
    }
}

impl Core {
    pub(crate) fn ask_packet(&mut self, plugin: PluginId, asked: PacketRequest) {
        let request = self.ledger.propose(plugin, asked.tag, RequestKind::Packet);
        self.reject(request, refused("state", "not offered"));
    }

    pub(crate) fn packet_answered(&mut self, request: u64, answer: Answer<'_>) {
        let _ = (request, answer);
    }

    /// BFCMA.
    pub(crate) fn window(&mut self, message: &MediumAccess) {
        self.heard(message.created);
    }

    /// BFCPS.
    pub(crate) fn packet_sent(&mut self, message: &PacketSent) {
        self.heard(message.created);
    }

    /// BFCPR.
    pub(crate) fn packet_received(&mut self, message: PacketReceived) {
        self.heard(message.created);
    }

    pub(crate) fn acoustic_expired(&mut self) {}

    pub(crate) fn acoustic_link_lost(&mut self) {
        self.acoustic.until = None;
    }
}
