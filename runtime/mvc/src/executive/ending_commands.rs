use core::time::Duration;

use backseat_spi::{Abort, AbortReason, AckStatus, DurationUnit, Kill, StartEmptyMission};

use super::mission::Mission;
use crate::context::Context;
use crate::event::{MissionEvent, MvcEventKind};
use crate::server::answers::Regarding;

/// The longest duration of an empty mission that can be requested, seconds: a year.
const EMPTY_MAX_S: f64 = 365.0 * 86_400.0;

/// Commands of a payload that end behaviors, elements and missions, and start an empty mission (SPI 7.10, 7.11, 7.16,
/// 7.17, 7.20).
impl Mission {
    /// BPRCB. A reserved field that is neither empty nor 0 does not parse.
    pub(crate) fn cancel_current(&mut self, ctx: &mut Context<'_>, re: Regarding) {
        let outcome = self.executive.cancel_current(ctx.now, ctx.vehicle.motion().at);
        done(ctx, re, outcome, MissionEvent::CancelCurrent(re.client));
    }

    /// BPRCE.
    pub(crate) fn cancel_element(&mut self, ctx: &mut Context<'_>, re: Regarding) {
        let outcome = self.executive.cancel_element(ctx.now, ctx.vehicle.motion().at);
        done(ctx, re, outcome, MissionEvent::CancelElement(re.client));
    }

    /// BPABT.
    pub(crate) fn abort(&mut self, ctx: &mut Context<'_>, re: Regarding, request: &Abort) {
        let errors = match request.reason {
            AbortReason::Successful => false,
            AbortReason::Errors => true,
            AbortReason::Other(code) => {
                ctx.invalid(re, &format!("reason {code}: expected 0 or 1"));
                return;
            }
        };
        let outcome = self.executive.abort(errors, request.text.as_str());
        let event = MissionEvent::Abort {
            client: re.client,
            errors,
            text: request.text.clone(),
        };
        done(ctx, re, outcome, event);
    }

    /// BPKIL.
    pub(crate) fn kill(&mut self, ctx: &mut Context<'_>, re: Regarding, request: &Kill) {
        let outcome = self.executive.kill(request.text.as_str());
        done(ctx, re, outcome, MissionEvent::Kill(re.client, request.text.clone()));
    }

    /// BPSEM.
    pub(crate) fn start_empty_mission(&mut self, ctx: &mut Context<'_>, re: Regarding, request: &StartEmptyMission) {
        let unit_s = match request.unit {
            DurationUnit::Hours => 3600.0,
            DurationUnit::Minutes => 60.0,
            DurationUnit::Seconds => 1.0,
            DurationUnit::Other(code) => {
                ctx.invalid(re, &format!("unit {code}: expected 0 to 2"));
                return;
            }
        };
        let seconds = request.duration * unit_s;
        if !(seconds > 0.0 && seconds <= EMPTY_MAX_S) {
            let text = format!("duration {}: expected above 0 and at most a year", request.duration);
            ctx.invalid(re, &text);
            return;
        }
        let most = Duration::from_secs_f64(seconds);
        let outcome = if self.empty_allowed {
            self.executive.start_empty(ctx.now, ctx.vehicle.motion().at, most)
        } else {
            Err("empty missions are not allowed on this vehicle")
        };
        done(ctx, re, outcome, MissionEvent::EmptyMission(re.client, most));
    }
}

/// Answers a command. The log gets the command before the events that it causes.
fn done<E: AsRef<str>>(ctx: &mut Context<'_>, re: Regarding, outcome: Result<(), E>, event: MissionEvent) {
    match outcome {
        Ok(()) => {
            ctx.note(MvcEventKind::Executive(event));
            ctx.acknowledge(re, AckStatus::Succeeded, "");
        }
        Err(why) => ctx.acknowledge(re, AckStatus::Failed, why.as_ref()),
    }
}
