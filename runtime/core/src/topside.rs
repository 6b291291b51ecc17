//! Messages to and from the topside (SPI 5.5, 7.3).

use backseat_spi::TopsideMessage;

use crate::helm::refused;
use crate::ledger::RequestKind;
use crate::machine::Core;
use crate::plugin::{PluginId, TopsideRequest};

impl Core {
    pub(crate) fn ask_topside(&mut self, plugin: PluginId, asked: &TopsideRequest) {
        let request = self.ledger.propose(plugin, asked.tag, RequestKind::Topside);
        self.reject(request, refused("state", "not offered"));
    }

    pub(crate) fn topside_message(&mut self, message: &TopsideMessage) {
        self.heard(message.created);
    }
}
