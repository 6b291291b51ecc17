//! Silent mode (SPI 7.22; safety requirement 018).

use crate::commands::Answer;
use crate::helm::refused;
use crate::ledger::RequestKind;
use crate::machine::Core;
use crate::plugin::{PluginId, SilentRequest};

/// What is known of the vehicle's silence.
#[derive(Debug, Default)]
pub(crate) struct Silent {}

impl Core {
    pub(crate) fn ask_silent(&mut self, plugin: PluginId, asked: &SilentRequest) {
        let request = self.ledger.propose(plugin, asked.tag, RequestKind::Silent);
        self.reject(request, refused("state", "not offered"));
    }

    pub(crate) fn silent_answered(&mut self, request: u64, answer: Answer<'_>) {
        let _ = (request, answer);
    }

    /// The five minutes are over.
    pub(crate) fn silent_expired(&mut self) {}

    pub(crate) fn silent_link_lost(&mut self) {}
}
