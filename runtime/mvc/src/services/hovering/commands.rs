use backseat_spi::{
    AckStatus, BearingOffset, BottomPosition, Camera, HullPosition, HullSpeedLimit, Light, RelativeReset, SonarAngle,
    VerticalReference,
};

use super::{Goal, Hovering, Inspector};
use crate::context::Context;
use crate::event::{HoveringEvent, MvcEventKind};
use crate::executive::mission::Mission;
use crate::server::answers::Regarding;
use crate::vehicle::Vertical;

/// How far relative navigation reaches, metres in each direction. Coordinates beyond it are refused.
const REACH_M: f64 = 1000.0;
const NOT_SUSPENDED: &str = "no mission is suspended";
const IGNORED: &str = "ignored: no mission is suspended";

/// The result of a command for hovering vehicles.
enum Answer {
    /// Status 2.
    Done,
    /// Status 1, with the reason.
    Failed(String),
    /// Status 0, with the value and what was expected.
    Invalid(String),
}

impl Hovering {
    /// BPSUS (SPI 8.1).
    pub(crate) fn suspend(&mut self, ctx: &mut Context<'_>, re: Regarding, mission: &mut Mission) {
        self.command(ctx, re, |ctx, state| {
            match mission.suspend(ctx, re.client) {
                Ok(true) => state.stay(ctx.vehicle, ctx.estimate.depth_m),
                Ok(false) => {}
                Err(why) => return failed(why),
            }
            Answer::Done
        });
    }

    /// BPCON (SPI 8.2). It fails if no mission is suspended: the payload no longer controls the vehicle.
    pub(crate) fn keep_suspended(&mut self, ctx: &mut Context<'_>, re: Regarding, mission: &mut Mission) {
        self.command(ctx, re, |ctx, _| {
            if mission.keep_suspended(ctx.now) {
                Answer::Done
            } else {
                failed(NOT_SUSPENDED)
            }
        });
    }

    /// BPRES (SPI 8.3).
    pub(crate) fn resume(&mut self, ctx: &mut Context<'_>, re: Regarding, mission: &mut Mission) {
        self.command(ctx, re, |ctx, _| {
            if mission.resume(ctx.now) {
                Answer::Done
            } else {
                failed(NOT_SUSPENDED)
            }
        });
    }

    /// BPSPD (SPI 8.4). Any speed above 0 is accepted, and the vehicle's greatest speed caps it.
    pub(crate) fn hull_speed_limit(&mut self, ctx: &mut Context<'_>, re: Regarding, request: &HullSpeedLimit) {
        let speed_mps = request.speed_mps;
        self.command(ctx, re, |ctx, state| {
            if speed_mps <= 0.0 {
                return Answer::Invalid(format!("speed_mps {speed_mps}: expected more than 0"));
            }
            state.speed_limit_mps = speed_mps;
            note(ctx, HoveringEvent::SpeedLimit(speed_mps));
            Answer::Done
        });
    }

    /// BPSAN (SPI 8.5).
    pub(crate) fn sonar_angle(&mut self, ctx: &mut Context<'_>, re: Regarding, request: &SonarAngle) {
        let angle_deg = request.angle_deg;
        self.command(ctx, re, |ctx, state| {
            let (least, most) = (state.sonar_min_deg, state.sonar_max_deg);
            if !(least..=most).contains(&angle_deg) {
                return Answer::Failed(format!("the sonar turns from {least} to {most} degrees"));
            }
            state.sonar.turn_to(angle_deg);
            note(ctx, HoveringEvent::SonarAngle(angle_deg));
            Answer::Done
        });
    }

    /// BPGHP (SPI 8.6). An ignored command is acknowledged as failed, because the vehicle does not go there.
    pub(crate) fn hull_position(
        &mut self,
        ctx: &mut Context<'_>,
        re: Regarding,
        mission: &mut Mission,
        request: &HullPosition,
    ) {
        let (horizontal_m, vertical_m, distance_m) = (request.horizontal_m, request.vertical_m, request.distance_m);
        self.command(ctx, re, |ctx, state| {
            // The time limit starts again even if the place is refused, because the payload is alive.
            if !mission.keep_suspended(ctx.now) {
                return failed(IGNORED);
            }
            let depth_m = if ctx.interpretation.hull_vertical_up {
                -vertical_m
            } else {
                vertical_m
            };
            let (safety_m, depth_max_m) = (state.safety_m, ctx.vehicle.performance().depth_max_m);
            if !state.has_hull {
                return failed("there is no hull");
            }
            if !(safety_m..=REACH_M).contains(&distance_m) {
                return Answer::Failed(format!("the distance must be {safety_m} to {REACH_M} m"));
            }
            if !(0.0..=depth_max_m).contains(&depth_m) {
                return Answer::Failed(format!("the depth must be 0 to {depth_max_m} m"));
            }
            if horizontal_m.abs() > REACH_M {
                return out_of_reach();
            }
            let goal = Goal::Hull {
                horizontal_m,
                depth_m,
                distance_m,
            };
            // A payload repeats its goal. The log has one line for all repetitions.
            if state.go(goal) {
                note(
                    ctx,
                    HoveringEvent::HullMove {
                        horizontal_m,
                        vertical_m,
                        distance_m,
                    },
                );
            }
            Answer::Done
        });
    }

    /// BPGBP (SPI 8.7).
    pub(crate) fn bottom_position(
        &mut self,
        ctx: &mut Context<'_>,
        re: Regarding,
        mission: &mut Mission,
        request: &BottomPosition,
    ) {
        let (x_m, y_m, metres, reference) = (request.x_m, request.y_m, request.vertical_m, request.reference);
        self.command(ctx, re, |ctx, state| {
            if !mission.keep_suspended(ctx.now) {
                return failed(IGNORED);
            }
            let (altitude_min_m, depth_max_m) = (ctx.vehicle.altitude_min_m(), ctx.vehicle.performance().depth_max_m);
            let vertical = match reference {
                VerticalReference::Depth if (0.0..=depth_max_m).contains(&metres) => Vertical::Depth(metres),
                VerticalReference::Depth => {
                    return Answer::Failed(format!("the depth must be 0 to {depth_max_m} m"));
                }
                VerticalReference::Altitude if (altitude_min_m..=REACH_M).contains(&metres) => {
                    Vertical::Altitude(metres)
                }
                VerticalReference::Altitude => {
                    return Answer::Failed(format!("the altitude must be {altitude_min_m} to {REACH_M} m"));
                }
            };
            if x_m.abs().max(y_m.abs()) > REACH_M {
                return out_of_reach();
            }
            // A repeated command keeps the bearing of the first. Otherwise the vehicle would turn with the drift of its
            // bearing.
            let bearing_deg = match state.goal {
                Goal::Bottom { bearing_deg, .. } => bearing_deg,
                Goal::Stay { .. } | Goal::Hull { .. } => state.relative.bearing_deg(ctx.vehicle),
            };
            let goal = Goal::Bottom {
                x_m,
                y_m,
                vertical,
                bearing_deg,
            };
            if state.go(goal) {
                note(ctx, HoveringEvent::BottomMove { x_m, y_m });
            }
            Answer::Done
        });
    }

    /// BPRNS (SPI 8.8).
    pub(crate) fn relative_reset(&mut self, ctx: &mut Context<'_>, re: Regarding, request: &RelativeReset) {
        let (x_m, y_m, bearing_deg) = (request.x_m, request.y_m, request.bearing_deg);
        self.command(ctx, re, |ctx, state| {
            if bearing_deg.abs() > 360.0 {
                return Answer::Invalid(format!("bearing_deg {bearing_deg}: expected -360 to 360"));
            }
            if x_m.abs().max(y_m.abs()) > REACH_M {
                return out_of_reach();
            }
            let moved_m = state.reset(x_m, y_m, bearing_deg, ctx.vehicle);
            note(ctx, HoveringEvent::RelativeReset(moved_m));
            Answer::Done
        });
    }

    /// BPRBO (SPI 8.9).
    pub(crate) fn bearing_offset(&mut self, ctx: &mut Context<'_>, re: Regarding, request: &BearingOffset) {
        let offset_deg = request.offset_deg;
        self.command(ctx, re, |ctx, state| {
            if offset_deg.abs() > 360.0 {
                return Answer::Invalid(format!("offset_deg {offset_deg}: expected -360 to 360"));
            }
            state.offset_bearing(offset_deg);
            note(ctx, HoveringEvent::BearingOffset(offset_deg));
            Answer::Done
        });
    }

    /// BPPTZ (SPI 8.10). A value outside -9 to 9 does not parse.
    pub(crate) fn camera(&mut self, ctx: &mut Context<'_>, re: Regarding, request: &Camera) {
        let (pan, tilt, zoom) = (request.pan, request.tilt, request.zoom);
        self.command(ctx, re, |ctx, state| {
            if !state.has_camera {
                return failed("no camera is installed");
            }
            note(ctx, HoveringEvent::Camera { pan, tilt, zoom });
            Answer::Done
        });
    }

    /// BPLIT (SPI 8.11). The number of the light is ignored, as that section says.
    pub(crate) fn light(&mut self, ctx: &mut Context<'_>, re: Regarding, request: &Light) {
        let on = request.on;
        self.command(ctx, re, |ctx, state| {
            if !state.has_light {
                return failed("no light is installed");
            }
            state.light_on = on;
            note(ctx, HoveringEvent::Light(on));
            Answer::Done
        });
    }

    /// Carries out a command for hovering vehicles, and answers it.
    fn command<'a>(
        &mut self,
        ctx: &mut Context<'a>,
        re: Regarding,
        command: impl FnOnce(&mut Context<'a>, &mut Inspector) -> Answer,
    ) {
        let answer = match &mut self.state {
            Some(state) => command(ctx, state),
            None => failed("this vehicle does not hover"),
        };
        match answer {
            Answer::Done => ctx.acknowledge(re, AckStatus::Succeeded, ""),
            Answer::Failed(why) => ctx.acknowledge(re, AckStatus::Failed, &why),
            Answer::Invalid(text) => ctx.invalid(re, &text),
        }
    }
}

fn note(ctx: &mut Context<'_>, event: HoveringEvent) {
    ctx.note(MvcEventKind::Hovering(event));
}

fn failed(why: &str) -> Answer {
    Answer::Failed(why.to_owned())
}

fn out_of_reach() -> Answer {
    Answer::Failed(format!("the place is over {REACH_M} m from the relative origin"))
}
