use backseat_spi::{AckStatus, BehaviorId, CancelBehavior, GpsHit, ModifyBehavior, Trackcircle, Trackline};

use super::inserts::takes_back;
use super::mission::Mission;
use super::modify;
use crate::context::Context;
use crate::event::{MvcEventKind, Refusal, Status};
use crate::plan::insert::Insert;
use crate::server::answers::Regarding;
use crate::server::requests::Asked;

/// Commands of a payload for the plan and for the current behavior (SPI 7.5 to 7.9, 7.12, 7.13, 7.19).
impl Mission {
    /// BPRMB (SPI 7.12).
    pub(crate) fn modify(&mut self, ctx: &mut Context<'_>, re: Regarding, request: &ModifyBehavior) {
        let grid_deg = if ctx.interpretation.heading_is_grid {
            ctx.north.grid_deg
        } else {
            0.0
        };
        let reading = modify::Reading {
            grid_convergence_deg: grid_deg,
            empty_mode: ctx.interpretation.empty_mode,
            current: self.executive.counted(),
        };
        let water_depth_m = ctx.vehicle.motion().water_depth_m;
        let outcome = match modify::read(request, &reading) {
            Ok(values) => self.executive.modify(ctx.now, re.client, values, water_depth_m),
            Err(text) => return ctx.invalid(re, &text),
        };
        match outcome {
            Ok(clipped) => ctx.acknowledge(re, AckStatus::Succeeded, &clipped),
            Err(why) => ctx.acknowledge(re, AckStatus::Failed, why),
        }
    }

    /// BPEMB (SPI 7.13).
    pub(crate) fn end_modify(&mut self, ctx: &mut Context<'_>, re: Regarding) {
        let text = if self.executive.end_modify_asked() {
            ""
        } else {
            "no behavior was modified"
        };
        ctx.acknowledge(re, AckStatus::Succeeded, text);
    }

    /// BPRTK (SPI 7.5).
    pub(crate) fn trackline(&mut self, ctx: &mut Context<'_>, re: Regarding, request: &Trackline) {
        let insert = Insert::trackline(re.client, request, ctx.frame(), ctx.vehicle.performance());
        self.insert(ctx, re.of(request.identifier), insert);
    }

    /// BPRTC (SPI 7.6).
    pub(crate) fn trackcircle(&mut self, ctx: &mut Context<'_>, re: Regarding, request: &Trackcircle) {
        let layout = ctx.interpretation.trackcircle_layout;
        let insert = Insert::trackcircle(re.client, request, layout, ctx.frame(), ctx.vehicle.performance());
        self.insert(ctx, re.of(request.identifier), insert);
    }

    fn insert(&mut self, ctx: &mut Context<'_>, re: Regarding, insert: Result<Insert, String>) {
        if let Some(insert) = valid(ctx, re, insert) {
            self.begin(ctx, re, Asked::Insert(insert));
        }
    }

    /// BPRGP (SPI 7.7). Its section does not say that it may be pending, so the outcome is sent at once (SPI 4.4).
    pub(crate) fn gps_hit(&mut self, ctx: &mut Context<'_>, re: Regarding, request: &GpsHit) {
        let re = re.of(request.identifier);
        let cruise = self.executive.cruise();
        let insert = Insert::gps_hit(re.client, request, ctx.frame(), self.gps, cruise);
        if let Some(insert) = valid(ctx, re, insert) {
            self.decide(ctx, re, Asked::Insert(insert));
        }
    }

    /// BPRCN (SPI 7.8).
    pub(crate) fn cancel(&mut self, ctx: &mut Context<'_>, re: Regarding, request: &CancelBehavior) {
        let id = request.identifier;
        self.begin(ctx, re.of(id), Asked::Cancel(id));
    }

    /// BPRCA (SPI 7.9). It also cancels the inserts that are still pending.
    pub(crate) fn cancel_all(&mut self, ctx: &mut Context<'_>, re: Regarding) {
        let (reading, client) = (*ctx.interpretation, re.client);
        let of = |insert: &Insert| takes_back(&reading, client, insert);
        let waiting = self.executive.cancel_all(client) + ctx.server.take_back(of);
        ctx.acknowledge(re, AckStatus::Succeeded, &format!("{waiting} cancelled"));
    }

    /// BPRMP (SPI 7.19). It is always pending first, whatever the setting is.
    #[expect(
        clippy::unused_self,
        reason = "a command of the mission like the others, answered by `decide`"
    )]
    pub(crate) fn request_plan(&self, ctx: &mut Context<'_>, re: Regarding) {
        ctx.server.begin_pending(ctx.now, re, Asked::Plan);
    }

    fn begin(&mut self, ctx: &mut Context<'_>, re: Regarding, asked: Asked) {
        if let Some(asked) = ctx.server.begin(ctx.now, re, asked) {
            self.decide(ctx, re, asked);
        }
    }

    /// Carries out a request and reports the outcome.
    pub(crate) fn decide(&mut self, ctx: &mut Context<'_>, re: Regarding, asked: Asked) {
        match asked {
            Asked::Insert(insert) => match self.executive.insert(ctx.now, insert, &ctx.estimate) {
                Ok(()) => ctx.acknowledge(re, AckStatus::Succeeded, ""),
                Err(why) => refuse(ctx, re, insert.id, why),
            },
            Asked::TakenBack(id) => refuse(ctx, re, id, Refusal::Cancelled),
            Asked::Cancel(id) => match self.executive.cancel(re.client, id) {
                Ok(()) => ctx.acknowledge(re, AckStatus::Succeeded, ""),
                Err(why) => ctx.acknowledge(re, AckStatus::Failed, why),
            },
            // A running mission has a plan, and so does a loaded one (SPI 7.19: "the currently-executing mission
            // plan").
            Asked::Plan => match self.executive.status() {
                _ if re.muted => {}
                Status::Ready | Status::Running => {
                    let count = self.send_plan(ctx, re.client);
                    ctx.acknowledge(re, AckStatus::Succeeded, &format!("{count} elements"));
                }
                Status::Offline
                | Status::Waiting
                | Status::InvalidDiveFile
                | Status::InvalidWrapupFile
                | Status::WrappingUp
                | Status::Aborting
                | Status::Completed
                | Status::Aborted
                | Status::Stopped => {
                    ctx.acknowledge(re, AckStatus::Failed, "no mission is running");
                }
            },
        }
    }
}

/// Returns the insert if it is valid; otherwise answers that it is not.
fn valid(ctx: &mut Context<'_>, re: Regarding, insert: Result<Insert, String>) -> Option<Insert> {
    match insert {
        Ok(insert) if insert.id.get() == 0 => ctx.invalid(re, "identifier 0: expected 1 or more"),
        Ok(insert) => return Some(insert),
        Err(text) => ctx.invalid(re, &text),
    }
    None
}

fn refuse(ctx: &mut Context<'_>, re: Regarding, id: BehaviorId, why: Refusal) {
    ctx.note(MvcEventKind::InsertRefused(re.client, id, why));
    ctx.acknowledge(re, AckStatus::Failed, &why.to_string());
}
