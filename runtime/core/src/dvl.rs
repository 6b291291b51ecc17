//! The payload's part in triggering the DVL (SPI 5.6, 7.4; safety requirement 017).

use backseat_spi::DvlTriggering;

use crate::commands::Answer;
use crate::helm::refused;
use crate::ledger::RequestKind;
use crate::machine::Core;
use crate::plugin::{DvlTriggerRequest, PluginId};

/// Where the handshake stands.
#[derive(Debug, Default)]
pub(crate) struct DvlTrigger {}

impl Core {
    pub(crate) fn ask_dvl(&mut self, plugin: PluginId, asked: &DvlTriggerRequest) {
        let request = self.ledger.propose(plugin, asked.tag, RequestKind::DvlTrigger);
        self.reject(request, refused("state", "not offered"));
    }

    pub(crate) fn dvl_answered(&mut self, request: u64, answer: Answer<'_>) {
        let _ = (request, answer);
    }

    /// BFDVT.
    pub(crate) fn dvl_triggering(&mut self, message: &DvlTriggering) {
        self.heard(message.created);
    }

    pub(crate) fn dvl_expired(&mut self) {}

    pub(crate) fn dvl_link_lost(&mut self) {}

    pub(crate) fn dvl_plugin_failed(&mut self, plugin: PluginId) {
        let _ = plugin;
    }
}
