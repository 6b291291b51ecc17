//! Sonar angle, camera and light of a hovering vehicle (SPI 8.5, 8.10, 8.11).

use crate::helm::refused;
use crate::ledger::RequestKind;
use crate::machine::Core;
use crate::plugin::{CameraRequest, LightRequest, PluginId, SonarAngleRequest};

impl Core {
    pub(crate) fn ask_sonar_angle(&mut self, plugin: PluginId, asked: &SonarAngleRequest) {
        let request = self.ledger.propose(plugin, asked.tag, RequestKind::SonarAngle);
        self.reject(request, refused("state", "not offered"));
    }

    pub(crate) fn ask_camera(&mut self, plugin: PluginId, asked: &CameraRequest) {
        let request = self.ledger.propose(plugin, asked.tag, RequestKind::Camera);
        self.reject(request, refused("state", "not offered"));
    }

    pub(crate) fn ask_light(&mut self, plugin: PluginId, asked: &LightRequest) {
        let request = self.ledger.propose(plugin, asked.tag, RequestKind::Light);
        self.reject(request, refused("state", "not offered"));
    }
}
