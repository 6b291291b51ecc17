//! Leases of a hovering vehicle: its mission suspended, the vehicle held or moved (SPI 8; safety requirement 005).

use backseat_spi::{CartesianNavigation, CommandName, RelativeNavigation};

use crate::commands::Answer;
use crate::helm::refused;
use crate::ledger::RequestKind;
use crate::machine::Core;
use crate::plugin::{CartesianSample, HoldRequest, PluginId, RelativeSample};

/// Where the hold stands, and where the vehicle is relative to its target.
#[derive(Debug, Default)]
pub(crate) struct Hull {}

impl Hull {
    /// The newest relative navigation, while it is fresh.
    pub(crate) fn relative(&self) -> Option<RelativeSample> {
        None
    }

    /// The newest Cartesian navigation, while it is fresh.
    pub(crate) fn cartesian(&self) -> Option<CartesianSample> {
        None
    }
}

impl Core {
    pub(crate) fn ask_hold(&mut self, plugin: PluginId, asked: &HoldRequest) {
        let request = self.ledger.propose(plugin, asked.tag, RequestKind::Hold);
        self.reject(request, refused("state", "not offered"));
    }

    /// The plugin ends its own hold.
    pub(crate) fn ask_end_hold(&mut self, plugin: PluginId) {
        let _ = plugin;
    }

    /// Ends the hold, if there is one: BPRES where the link is up, then silence.
    pub(crate) fn end_hold(&mut self, reason: &str) {
        let _ = reason;
    }

    pub(crate) fn hold_answered(&mut self, request: u64, command: CommandName, answer: Answer<'_>) {
        let _ = (request, command, answer);
    }

    /// BFRNV.
    pub(crate) fn relative_navigated(&mut self, message: &RelativeNavigation) {
        self.heard(message.created);
    }

    /// BFCNV.
    pub(crate) fn cartesian_navigated(&mut self, message: &CartesianNavigation) {
        self.heard(message.created);
    }

    /// The next BPCON is due.
    pub(crate) fn refresh_hold(&mut self) {}

    /// Relative navigation may have become stale.
    pub(crate) fn relative_expired(&mut self) {}

    pub(crate) fn hold_plugin_failed(&mut self, plugin: PluginId) {
        let _ = plugin;
    }
}
