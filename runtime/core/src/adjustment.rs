//! Trim and buoyancy adjustments, to their final status (SPI 6.22, 6.23, 7.23, 7.24).

use backseat_spi::{BuoyancyStatus, TrimStatus};

use crate::commands::Answer;
use crate::helm::refused;
use crate::ledger::RequestKind;
use crate::machine::Core;
use crate::plugin::PluginId;

/// What is known of the adjustments.
#[derive(Debug, Default)]
pub(crate) struct Adjustments {}

impl Core {
    /// `kind` is [`RequestKind::Trim`] or [`RequestKind::Buoyancy`].
    pub(crate) fn ask_adjustment(&mut self, plugin: PluginId, tag: u64, kind: RequestKind) {
        let request = self.ledger.propose(plugin, tag, kind);
        self.reject(request, refused("state", "not offered"));
    }

    pub(crate) fn adjustment_answered(&mut self, request: u64, answer: Answer<'_>) {
        let _ = (request, answer);
    }

    pub(crate) fn trim_status(&mut self, message: &TrimStatus) {
        self.heard(message.created);
    }

    pub(crate) fn buoyancy_status(&mut self, message: &BuoyancyStatus) {
        self.heard(message.created);
    }

    pub(crate) fn adjustment_expired(&mut self) {}

    pub(crate) fn adjustments_link_lost(&mut self) {}
}
