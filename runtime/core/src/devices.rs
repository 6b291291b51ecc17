//! Sonar angle, camera and light of a hovering vehicle (SPI 8.5, 8.10, 8.11): each one command, over with its answer.

use backseat_spi::{Camera, Light, SonarAngle, ToVehicle};

use crate::commands::Purpose;
use crate::ledger::RequestKind;
use crate::limits::Grant;
use crate::machine::Core;
use crate::plugin::{CameraRequest, LightRequest, PluginId, Refusal, SonarAngleRequest};

impl Core {
    pub(crate) fn ask_sonar_angle(&mut self, plugin: PluginId, asked: &SonarAngleRequest) {
        let request = self.cx.ledger.propose(plugin, asked.tag, RequestKind::SonarAngle);
        let admitted = self.admit_device(plugin);
        if let Err(refusal) = admitted.and_then(|()| self.cx.envelope.admit_sonar_angle(asked)) {
            return self.cx.reject(request, refusal);
        }
        let message = SonarAngle {
            created: self.cx.stamper.stamp(self.cx.now, "SAN"),
            angle_deg: asked.angle_deg,
        };
        self.send_device(request, "SAN", &ToVehicle::SonarAngle(message));
    }

    pub(crate) fn ask_camera(&mut self, plugin: PluginId, asked: &CameraRequest) {
        let request = self.cx.ledger.propose(plugin, asked.tag, RequestKind::Camera);
        let admitted = self.admit_device(plugin);
        if let Err(refusal) = admitted.and_then(|()| self.cx.envelope.admit_camera(asked)) {
            return self.cx.reject(request, refusal);
        }
        let message = Camera {
            created: self.cx.stamper.stamp(self.cx.now, "PTZ"),
            pan: asked.pan,
            tilt: asked.tilt,
            zoom: asked.zoom,
        };
        self.send_device(request, "PTZ", &ToVehicle::Camera(message));
    }

    pub(crate) fn ask_light(&mut self, plugin: PluginId, asked: &LightRequest) {
        let request = self.cx.ledger.propose(plugin, asked.tag, RequestKind::Light);
        let admitted = self.admit_device(plugin);
        if let Err(refusal) = admitted.and_then(|()| self.cx.envelope.admit_light(asked)) {
            return self.cx.reject(request, refusal);
        }
        let message = Light {
            created: self.cx.stamper.stamp(self.cx.now, "LIT"),
            light: asked.light,
            on: asked.on,
        };
        self.send_device(request, "LIT", &ToVehicle::Light(message));
    }

    fn admit_device(&mut self, plugin: PluginId) -> Result<(), Refusal> {
        self.cx.admit(plugin, Grant::Devices)
    }

    fn send_device(&mut self, request: u64, letters: &'static str, message: &ToVehicle) {
        // Where it is held back the request has been rejected.
        let _sent = self
            .cx
            .send_request(request, letters, message, Purpose::Request(request));
    }
}
