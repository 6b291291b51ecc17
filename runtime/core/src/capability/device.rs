//! Sonar angle, camera and light of a hovering vehicle (SPI 8.5, 8.10, 8.11). Each request is one command, and ends
//! with its answer.

use backseat_spi::{Camera, Light, SonarAngle, ToVehicle};

use crate::context::Context;
use crate::plugin::{CameraRequest, LightRequest, Refusal, SonarAngleRequest};
use crate::session::commands::Purpose;
use crate::session::dispatch::Dispatch;

/// Checks a request for the sonar's angle and returns what to send.
pub(crate) fn sonar_angle(cx: &mut Context, request: u64, asked: &SonarAngleRequest) -> Result<Dispatch, Refusal> {
    cx.monitor.envelope.admit_sonar_angle(asked)?;
    let message = ToVehicle::SonarAngle(SonarAngle {
        created: cx.stamper.stamp(cx.now, "SAN"),
        angle_deg: asked.angle_deg,
    });
    Ok(Dispatch::new("SAN", message, Purpose::Request(request)))
}

/// Checks a request for the camera and returns what to send.
pub(crate) fn camera(cx: &mut Context, request: u64, asked: &CameraRequest) -> Result<Dispatch, Refusal> {
    cx.monitor.envelope.admit_camera(asked)?;
    let message = ToVehicle::Camera(Camera {
        created: cx.stamper.stamp(cx.now, "PTZ"),
        pan: asked.pan,
        tilt: asked.tilt,
        zoom: asked.zoom,
    });
    Ok(Dispatch::new("PTZ", message, Purpose::Request(request)))
}

/// Checks a request for a light and returns what to send.
pub(crate) fn light(cx: &mut Context, request: u64, asked: &LightRequest) -> Result<Dispatch, Refusal> {
    cx.monitor.envelope.admit_light(asked)?;
    let message = ToVehicle::Light(Light {
        created: cx.stamper.stamp(cx.now, "LIT"),
        light: asked.light,
        on: asked.on,
    });
    Ok(Dispatch::new("LIT", message, Purpose::Request(request)))
}
