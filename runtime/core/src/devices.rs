//! Sonar angle, camera and light of a hovering vehicle (SPI 8.5, 8.10, 8.11): each one command, over with its answer.

use backseat_spi::{Camera, Light, SonarAngle, ToVehicle};

use crate::commands::Purpose;
use crate::context::Context;
use crate::ledger::RequestKind;
use crate::limits::Grant;
use crate::plugin::{CameraRequest, LightRequest, PluginId, Refusal, SonarAngleRequest};

/// Sonar, camera and light: nothing is kept of them.
#[derive(Debug, Default)]
pub(crate) struct Devices;

impl Devices {
    pub(crate) fn asked_sonar_angle(&mut self, cx: &mut Context, plugin: PluginId, asked: &SonarAngleRequest) {
        let request = cx.ledger.propose(plugin, asked.tag, RequestKind::SonarAngle);
        let admitted = self.admit(cx, plugin);
        if let Err(refusal) = admitted.and_then(|()| cx.monitor.envelope.admit_sonar_angle(asked)) {
            return cx.reject(request, refusal);
        }
        let message = SonarAngle {
            created: cx.stamper.stamp(cx.now, "SAN"),
            angle_deg: asked.angle_deg,
        };
        self.send(cx, request, "SAN", &ToVehicle::SonarAngle(message));
    }

    pub(crate) fn asked_camera(&mut self, cx: &mut Context, plugin: PluginId, asked: &CameraRequest) {
        let request = cx.ledger.propose(plugin, asked.tag, RequestKind::Camera);
        let admitted = self.admit(cx, plugin);
        if let Err(refusal) = admitted.and_then(|()| cx.monitor.envelope.admit_camera(asked)) {
            return cx.reject(request, refusal);
        }
        let message = Camera {
            created: cx.stamper.stamp(cx.now, "PTZ"),
            pan: asked.pan,
            tilt: asked.tilt,
            zoom: asked.zoom,
        };
        self.send(cx, request, "PTZ", &ToVehicle::Camera(message));
    }

    pub(crate) fn asked_light(&mut self, cx: &mut Context, plugin: PluginId, asked: &LightRequest) {
        let request = cx.ledger.propose(plugin, asked.tag, RequestKind::Light);
        let admitted = self.admit(cx, plugin);
        if let Err(refusal) = admitted.and_then(|()| cx.monitor.envelope.admit_light(asked)) {
            return cx.reject(request, refusal);
        }
        let message = Light {
            created: cx.stamper.stamp(cx.now, "LIT"),
            light: asked.light,
            on: asked.on,
        };
        self.send(cx, request, "LIT", &ToVehicle::Light(message));
    }

    fn admit(&mut self, cx: &mut Context, plugin: PluginId) -> Result<(), Refusal> {
        cx.admit(plugin, Grant::Devices)
    }

    fn send(&mut self, cx: &mut Context, request: u64, letters: &'static str, message: &ToVehicle) {
        // Where it is held back the request has been rejected.
        let _sent = cx.send_request(request, letters, message, Purpose::Request(request));
    }
}
