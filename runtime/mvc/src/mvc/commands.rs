use backseat_spi::{BehaviorId, ToVehicle};
use backseat_units::Timestamp;

use super::Mvc;
use super::steps::Parts;
use crate::event::{ClientId, MvcEventKind};
use crate::server::answers::Regarding;

impl Mvc {
    /// Passes a command to the part of the vehicle that carries it out.
    pub(super) fn command(&mut self, now: Timestamp, client: ClientId, command: ToVehicle) {
        let re = Regarding::command(client, &command);
        if !matches!(command, ToVehicle::Unknown(_))
            && let Some(status) = self.server.refusal(re.command)
        {
            let re = Regarding {
                behavior: insert_of(&command),
                ..re
            };
            self.server.acknowledge(now, re, status, "the vehicle cannot do it now");
            return;
        }
        let Parts {
            mut ctx,
            mission,
            sensors,
            services,
        } = self.parts(now);
        let ctx = &mut ctx;
        match command {
            ToVehicle::Unknown(unknown) => ctx.server.no_command(now, re, &unknown),
            ToVehicle::LoggingControl(request) => {
                let topics = ctx.server.switch(now, re, request.message, request.on);
                if ctx.interpretation.control_replay {
                    mission.replay(ctx, client, topics);
                }
            }
            ToVehicle::PayloadVersion(message) => ctx.hear(re, MvcEventKind::PayloadVersion(client, message.version)),
            ToVehicle::PayloadStatus(message) => {
                let (ok, text) = (message.ok, message.text);
                ctx.hear(re, MvcEventKind::PayloadStatus { client, ok, text });
            }
            ToVehicle::LogMessage(message) => ctx.hear(re, MvcEventKind::PayloadMessage(client, message.text)),

            ToVehicle::ModifyBehavior(request) => mission.modify(ctx, re, &request),
            ToVehicle::EndModify(_) => mission.end_modify(ctx, re),
            ToVehicle::Trackline(request) => mission.trackline(ctx, re, &request),
            ToVehicle::Trackcircle(request) => mission.trackcircle(ctx, re, &request),
            ToVehicle::GpsHit(request) => mission.gps_hit(ctx, re, &request),
            ToVehicle::CancelBehavior(request) => mission.cancel(ctx, re, &request),
            ToVehicle::CancelAll(_) => mission.cancel_all(ctx, re),
            ToVehicle::RequestPlan(_) => mission.request_plan(ctx, re),
            // An adjustment is the current behavior while it runs (SPI 7.23, 7.24).
            ToVehicle::CancelCurrent(_) if services.adjustment.is_asked_for() => services.adjustment.cancel(ctx, re),
            ToVehicle::CancelCurrent(_) => mission.cancel_current(ctx, re),
            ToVehicle::CancelElement(_) => mission.cancel_element(ctx, re),
            ToVehicle::Abort(request) => mission.abort(ctx, re, &request),
            ToVehicle::Kill(request) => mission.kill(ctx, re, &request),
            ToVehicle::StartEmptyMission(request) => mission.start_empty_mission(ctx, re, &request),

            ToVehicle::SilentMode(request) => services.silent_mode(ctx, re, &request),
            ToVehicle::TrimAdjustment(_) => services.adjustment.trim(ctx, re),
            ToVehicle::BuoyancyAdjustment(_) => services.adjustment.buoyancy(ctx, re),
            ToVehicle::DvlTriggerRequest(request) => services.dvl_trigger.request(ctx, re, &request),
            ToVehicle::TopsideText(request) => services.topside.text(ctx, re, &request),
            ToVehicle::TopsideRelay(request) => services.topside.relay(ctx, re, &request),
            ToVehicle::Packet(request) => services.acoustic.packet(ctx, re, &request),

            ToVehicle::PositionFix(request) => sensors.position_fix(ctx, re, &request),
            ToVehicle::PayloadCtd(request) => sensors.payload_ctd(ctx, re, &request),

            ToVehicle::Suspend(_) => services.hovering.suspend(ctx, re, mission),
            ToVehicle::Continue(_) => services.hovering.keep_suspended(ctx, re, mission),
            ToVehicle::Resume(_) => services.hovering.resume(ctx, re, mission),
            ToVehicle::HullPosition(request) => services.hovering.hull_position(ctx, re, mission, &request),
            ToVehicle::BottomPosition(request) => services.hovering.bottom_position(ctx, re, mission, &request),
            ToVehicle::HullSpeedLimit(request) => services.hovering.hull_speed_limit(ctx, re, &request),
            ToVehicle::SonarAngle(request) => services.hovering.sonar_angle(ctx, re, &request),
            ToVehicle::RelativeReset(request) => services.hovering.relative_reset(ctx, re, &request),
            ToVehicle::BearingOffset(request) => services.hovering.bearing_offset(ctx, re, &request),
            ToVehicle::Camera(request) => services.hovering.camera(ctx, re, &request),
            ToVehicle::Light(request) => services.hovering.light(ctx, re, &request),
        }
    }
}

/// The insert that a command concerns. The command's acknowledgement names it.
fn insert_of(command: &ToVehicle) -> Option<BehaviorId> {
    if let ToVehicle::Trackline(request) = command {
        Some(request.identifier)
    } else if let ToVehicle::Trackcircle(request) = command {
        Some(request.identifier)
    } else if let ToVehicle::GpsHit(request) = command {
        Some(request.identifier)
    } else if let ToVehicle::CancelBehavior(request) = command {
        Some(request.identifier)
    } else {
        None
    }
}
