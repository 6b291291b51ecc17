//! Leases of a hovering vehicle: its mission suspended, the vehicle held or moved (SPI 8; safety requirement 005).
//!
//! A hold goes out as BPSUS, then BPSPD where it moves, then BPGHP or BPGBP, each after the acknowledgement of the one
//! before, and is kept alive by BPCON. The speed limit of a move is always known: one that somebody left is not
//! inherited. Whatever ends the hold, the vehicle gets its own speed limit back, then BPRES, then silence.

use std::time::Duration;

use backseat_spi::{
    BottomPosition, CommandName, Continue, HullPosition, HullSpeedLimit, Resume, Suspend, ToVehicle, VerticalReference,
};
use backseat_units::Timestamp;

use crate::arbiter::LeaseKind;
use crate::context::Context;
use crate::ended::{EndCause, Ended, Failure};
use crate::io::Note;
use crate::monitor::envelope::{Aim, Hover, Surroundings, Suspended, Vertical, aim_at_here};
use crate::plugin::{HoldRequest, HoldTarget, PluginId, Refusal, RequestState};
use crate::refusal::{Figure, Reason};
use crate::session::commands::{Answer, Command, FIRST_WITHIN, Purpose};
use crate::session::name;
use crate::switches::{Check, is_on};
use crate::timer::Timer;

mod relative;
mod speed;

use speed::SpeedLimit;

/// The vehicle takes its mission up again after 2 s (8.1).
const REFRESH_EVERY: Duration = Duration::from_millis(500);
/// Past this since the last one it is too late to refresh: the hold ends.
const REFRESH_AT_MOST: Duration = Duration::from_secs(1);
/// A hold that begins or changes is sent at once, at 5 Hz at most.
const REFRESH_AT_LEAST: Duration = Duration::from_millis(200);

/// So many places are kept where the mission may stand suspended.
const LEFT_MAX: usize = 16;

/// Where the hold stands, and where the vehicle is relative to its target.
#[derive(Debug)]
pub(crate) struct Station {
    hold: Option<Hold>,
    limit: SpeedLimit,
    /// When the last BPSUS, or the last BPSPD, BPGHP or BPGBP of a hold left, of any hold.
    steered: Option<Timestamp>,
}

/// Who holds the vehicle, and how.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hold {
    plugin: PluginId,
    request: u64,
    tag: u64,
    target: HoldTarget,
    speed_mps: Option<f64>,
    hover: Hover,
    stage: Stage,
    /// Where the mission was suspended, once BPSUS has left.
    suspended: Option<Suspended>,
    /// The last move that has left.
    sent_aim: Option<Aim>,
    /// When the last BPSUS, BPCON, BPGHP or BPGBP left.
    sent: Option<Timestamp>,
    /// When the hold was last judged.
    judged: Timestamp,
}

/// How far the newest request of the hold has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// Its first message is due.
    Due,
    /// BPSUS has left.
    Suspending,
    /// BPSPD has left, for this request.
    Limiting(u64),
    /// BPGHP or BPGBP has left, for this request.
    Moving(u64),
    /// All of it is acknowledged.
    Standing,
}

impl Station {
    pub(crate) fn new() -> Self {
        Self {
            hold: None,
            limit: SpeedLimit::default(),
            steered: None,
        }
    }

    /// Who holds the vehicle.
    pub(crate) fn holder(&self) -> Option<PluginId> {
        self.hold.map(|hold| hold.plugin)
    }

    /// The connection is new or gone: its samples and answers are.
    pub(crate) fn reset(&mut self) {
        self.limit.restoring = None;
        self.limit.known_mps = None;
    }

    /// When the next message that begins or changes a hold may leave.
    fn free_at(&self) -> Timestamp {
        self.steered
            .map_or(Timestamp::ZERO, |steered| steered + REFRESH_AT_LEAST)
    }
}

impl Station {
    /// A request takes the place of the hold that stands, if there is one, which is returned.
    pub(crate) fn adopt(
        &mut self,
        cx: &mut Context,
        plugin: PluginId,
        request: u64,
        asked: &HoldRequest,
        hover: Hover,
    ) -> Option<Hold> {
        let before = self.hold;
        cx.arbiter.take(cx.now, plugin, LeaseKind::Station);
        let mut hold = Hold {
            plugin,
            request,
            tag: asked.tag,
            target: asked.target,
            speed_mps: asked.speed_mps,
            hover,
            stage: Stage::Due,
            suspended: None,
            sent_aim: None,
            sent: None,
            judged: cx.now,
        };
        if let Some(before) = before {
            let changed = before.target != asked.target || before.speed_mps != asked.speed_mps;
            hold.stage = match before.stage {
                // What has changed meanwhile follows the acknowledgement.
                Stage::Suspending => Stage::Suspending,
                Stage::Due | Stage::Limiting(_) | Stage::Moving(_) | Stage::Standing if changed => Stage::Due,
                stage @ (Stage::Due | Stage::Limiting(_) | Stage::Moving(_) | Stage::Standing) => stage,
            };
            hold.suspended = before.suspended;
            hold.sent_aim = before.sent_aim;
            hold.sent = before.sent;
        }
        self.hold = Some(hold);
        cx.timers.set(Timer::HoldTerm, cx.now + asked.duration);
        before
    }

    /// Sends the first message of station keeping that has been adopted, or what has changed.
    pub(crate) fn begin(&mut self, cx: &mut Context, before: Option<Hold>) {
        if let Some(before) = before {
            let same = |hold: Hold| before.plugin == hold.plugin && before.tag == hold.tag;
            if self.hold.is_some_and(same) {
                cx.transition_quietly(before.request, RequestState::Ended(EndCause::Replaced.into()));
            } else {
                cx.transition(before.request, RequestState::Ended(EndCause::OtherStation.into()));
            }
        }
        self.watch_relative(cx);
        self.drive(cx);
    }

    /// What a request sends, where that may stand.
    pub(crate) fn check(&self, cx: &Context, plugin: PluginId, asked: &HoldRequest) -> Result<Hover, Refusal> {
        cx.outlook().admit_beside_gps_hit()?;
        if cx.vehicle.suspended.len() >= LEFT_MAX {
            return Err(Figure::Suspensions.over(LEFT_MAX as f64 + 1.0, LEFT_MAX as f64));
        }
        let mut hover = cx.monitor.envelope.admit_hold(asked)?;
        cx.cap_steering(plugin, asked.duration)?;
        // There is no command to stop: a vehicle that has been sent somewhere is sent to where it is.
        if hover.aim.is_none()
            && let Some(hold) = &self.hold
            && let Some(last) = &hold.sent_aim
        {
            hover.aim = match hold.target {
                HoldTarget::Here => hold.hover.aim,
                HoldTarget::Hull { .. } | HoldTarget::Bottom { .. } => Some(aim_at_here(last, self.here(cx)?)?),
            };
            hover.speed_mps = asked.speed_mps.unwrap_or(hold.hover.speed_mps);
        }
        self.judge_hover(cx, &hover)?;
        Ok(hover)
    }

    /// The whole judgement of a hold, with what is known at this moment.
    fn judge_hover(&self, cx: &Context, hover: &Hover) -> Result<f64, Refusal> {
        self.with_surroundings(cx, |around| cx.monitor.envelope.judge_hold(hover, around))
    }

    fn here(&self, cx: &Context) -> Result<Suspended, Refusal> {
        self.with_surroundings(cx, |around| Ok(around.here()))
    }

    fn with_surroundings<T>(
        &self,
        cx: &Context,
        ask: impl FnOnce(&Surroundings<'_>) -> Result<T, Refusal>,
    ) -> Result<T, Refusal> {
        let Some(navigation) = cx.vehicle.navigation.fresh(cx.now) else {
            return Err(Reason::NavigationIsStale.into());
        };
        let (relative, cartesian) = (cx.vehicle.relative.steady(cx.now), cx.vehicle.cartesian.steady(cx.now));
        let suspended: Vec<Suspended> = cx
            .vehicle
            .suspended
            .iter()
            .copied()
            .chain(self.hold.and_then(|hold| hold.suspended))
            .collect();
        ask(&Surroundings {
            relative: relative.as_ref(),
            cartesian: cartesian.as_ref(),
            navigation,
            lock: cx.vehicle.navigation.bottom_lock(cx.now),
            suspended: &suspended,
            now: cx.now,
        })
    }

    /// Sends what is due of the hold, and sets when to come back.
    fn drive(&mut self, cx: &mut Context) {
        let Some(hold) = self.hold else { return };
        if hold.sent.is_some_and(|sent| cx.now.since(sent) > REFRESH_AT_MOST)
            && is_on(Check::LateWake)
            && is_on(Check::HoldCadence)
        {
            return self.end(cx, EndCause::NotRefreshed);
        }
        if !self.is_sound(cx) {
            return;
        }
        if hold.stage == Stage::Due && cx.now >= self.free_at() {
            self.advance(cx);
        }
        if let Some(hold) = self.hold
            && hold.sent.is_some_and(|sent| cx.now.since(sent) >= refresh_every())
        {
            let created = cx.stamper.stamp(cx.now, "CON");
            self.send(cx, "CON", &ToVehicle::Continue(Continue { created }));
        }
        let Some(hold) = self.hold else { return };
        let refresh = hold.sent.map(|sent| sent + refresh_every());
        let due = (hold.stage == Stage::Due).then(|| self.free_at().max(cx.now));
        let next = refresh.into_iter().chain(due).min();
        cx.timers.set_or_stop(Timer::Hold, next);
    }

    /// Judges the hold anew where that is older than this moment; ends it where it does not hold.
    fn is_sound(&mut self, cx: &mut Context) -> bool {
        let Some(hold) = self.hold else { return false };
        hold.judged == cx.now || self.prevent(cx)
    }

    /// A sample is new, or time has passed: the hold is judged in full, and ends where it does not hold. Its checks are
    /// a few comparisons, so that each sample is worth one. False where no hold stands after it.
    pub(crate) fn prevent(&mut self, cx: &mut Context) -> bool {
        let Some(hold) = self.hold else { return false };
        if is_on(Check::HoldJudged)
            && let Err(refusal) = self.judge_hover(cx, &hold.hover)
        {
            self.end(cx, refusal);
            return false;
        }
        if let Some(hold) = &mut self.hold {
            hold.judged = cx.now;
        }
        true
    }

    /// Sends the next message on the way to what is asked; the hold has been judged at this moment.
    fn advance(&mut self, cx: &mut Context) {
        let Some(hold) = self.hold else { return };
        if hold.suspended.is_none() {
            let here = self.here(cx).unwrap_or_default();
            let created = cx.stamper.stamp(cx.now, "SUS");
            if self.send(cx, "SUS", &ToVehicle::Suspend(Suspend { created })) {
                self.set_stage(Stage::Suspending);
                if let Some(hold) = &mut self.hold {
                    hold.suspended = Some(here);
                }
            }
            return;
        }
        let Some(aim) = hold.hover.aim else {
            return self.stands(cx, hold.request);
        };
        if self.limit.known_mps != Some(hold.hover.speed_mps) {
            let created = cx.stamper.stamp(cx.now, "SPD");
            let speed_mps = hold.hover.speed_mps;
            // Before it is sent: what is sent may have come through.
            self.limit = SpeedLimit {
                known_mps: None,
                changed: self.limit.changed || cx.monitor.limits().speed_default_mps() != Some(speed_mps),
                restoring: None,
            };
            let limit = ToVehicle::HullSpeedLimit(HullSpeedLimit { created, speed_mps });
            if self.send(cx, "SPD", &limit) {
                self.set_stage(Stage::Limiting(hold.request));
            }
            return;
        }
        let (letters, message) = self.move_to(cx, aim);
        if self.send(cx, letters, &message) {
            self.set_stage(Stage::Moving(hold.request));
            if let Some(hold) = &mut self.hold {
                hold.sent_aim = Some(aim);
            }
        }
    }

    fn move_to(&mut self, cx: &mut Context, aim: Aim) -> (&'static str, ToVehicle) {
        match aim {
            Aim::Hull {
                horizontal_m,
                vertical_m,
                distance_m,
            } => {
                let created = cx.stamper.stamp(cx.now, "GHP");
                let message = HullPosition {
                    created,
                    horizontal_m,
                    vertical_m,
                    distance_m,
                };
                ("GHP", ToVehicle::HullPosition(message))
            }
            Aim::Bottom { x_m, y_m, vertical } => {
                let created = cx.stamper.stamp(cx.now, "GBP");
                let (reference, vertical_m) = match vertical {
                    Vertical::Depth(depth) => (VerticalReference::Depth, depth.as_m()),
                    Vertical::Altitude(altitude) => (VerticalReference::Altitude, altitude.as_m()),
                };
                let message = BottomPosition {
                    created,
                    x_m,
                    y_m,
                    reference,
                    vertical_m,
                };
                ("GBP", ToVehicle::BottomPosition(message))
            }
        }
    }

    /// Sends a message of the hold. False where the hold is over for it.
    fn send(&mut self, cx: &mut Context, letters: &'static str, message: &ToVehicle) -> bool {
        let Some(hold) = self.hold else { return false };
        let command = Command {
            name: name(letters),
            created: message.created(),
            identifier: None,
            purpose: Purpose::Hold(hold.request),
            deadline: cx.now + FIRST_WITHIN,
            pending: false,
        };
        if !cx.transmit_for(hold.plugin.into(), message, Some(command)) {
            self.end(cx, EndCause::NotSent);
            return false;
        }
        let refreshes = letters != "SPD";
        let steers = letters != "CON";
        if steers {
            self.steered = Some(cx.now);
        }
        if let Some(hold) = &mut self.hold
            && refreshes
        {
            hold.sent = Some(cx.now);
        }
        // A request that changes nothing goes out with the next BPCON; one whose own message waits does not.
        if steers || hold.stage == Stage::Standing {
            cx.transition(hold.request, RequestState::Sent);
        }
        // Its plugin may have failed of the event.
        self.hold.is_some_and(|now| now.request == hold.request)
    }

    fn set_stage(&mut self, stage: Stage) {
        if let Some(hold) = &mut self.hold {
            hold.stage = stage;
        }
    }

    /// All that a request of the hold needs is acknowledged.
    fn stands(&mut self, cx: &mut Context, request: u64) {
        self.set_stage(Stage::Standing);
        if self.hold.is_some_and(|hold| hold.request == request) {
            cx.transition(request, RequestState::Accepted);
        }
    }

    /// The plugin ends its own hold.
    pub(crate) fn asked_end(&mut self, cx: &mut Context, plugin: PluginId) {
        if self.holder() == Some(plugin) {
            self.end(cx, EndCause::PluginEnded);
        }
    }

    /// The vehicle is where it may have returned to. One without a hold is.
    fn watch_return(&mut self, cx: &mut Context) {
        if self.hold.is_some() || cx.vehicle.suspended.is_empty() {
            return;
        }
        let Some(limits) = &cx.monitor.limits().hull else {
            return;
        };
        let within_m = 2.0 * limits.position_error_m;
        if let Ok(here) = self.here(cx) {
            cx.vehicle
                .suspended
                .retain(|suspended| !suspended.is_near(&here, within_m));
        }
    }

    /// Ends the hold, if there is one: the vehicle's own speed limit and BPRES where the link is up, then silence.
    pub(crate) fn end(&mut self, cx: &mut Context, end: impl Into<Ended>) {
        let end = end.into();
        self.close(cx, end.clone(), RequestState::Ended(end));
    }

    fn close(&mut self, cx: &mut Context, end: Ended, state: RequestState) {
        let Some(hold) = self.hold.take() else { return };
        cx.vehicle.suspended.extend(hold.suspended);
        cx.arbiter.release(cx.now, LeaseKind::Station);
        for timer in [Timer::Hold, Timer::HoldTerm, Timer::Relative] {
            cx.timers.stop(timer);
        }
        cx.link.commands.forget_hold();
        if hold.sent.is_some() {
            cx.monitor.permits.station_ends = true;
            self.restore_speed(cx, hold.request);
            // One that is not answered needs no second: the vehicle takes its mission up by itself after 2 s (8.1).
            let created = cx.stamper.stamp(cx.now, "RES");
            let command = cx.courtesy("RES", Some(created));
            if is_on(Check::HoldEndSaid) {
                cx.transmit(&ToVehicle::Resume(Resume { created }), Some(command));
            }
            cx.monitor.permits.station_ends = false;
        }
        let proposed = cx
            .ledger
            .get(hold.request)
            .is_some_and(|entry| matches!(entry.state, RequestState::Rejected(_)));
        // What has not been sent cannot have been refused or left unanswered.
        let state = if proposed {
            RequestState::Ended(end.clone())
        } else {
            state
        };
        cx.transition(hold.request, state);
        cx.note(Note::LeaseEnded {
            plugin: hold.plugin,
            reason: end,
        });
    }

    /// An answer to a message of the hold that stands.
    pub(crate) fn answered(&mut self, cx: &mut Context, request: u64, command: CommandName, answer: Answer<'_>) {
        let Some(hold) = self.hold else { return };
        let newest = hold.request == request;
        let state_for = |end: &Ended, state: RequestState| {
            if newest {
                state
            } else {
                // An older request of a hold that goes on: what it says of the vehicle counts all the same.
                RequestState::Ended(end.clone())
            }
        };
        match answer {
            Answer::Pending if newest => cx.transition(request, RequestState::Pending),
            Answer::Pending => {}
            Answer::Done => self.acknowledged(cx, request, command.as_str(), hold.stage),
            Answer::Refused(text) => {
                let end = Ended::Said(EndCause::VehicleRefused, text.to_owned());
                let state = state_for(&end, RequestState::Failed(Failure::Vehicle(text.to_owned())));
                self.close(cx, end, state);
            }
            Answer::Missing => {
                let end = Ended::By(EndCause::NotAcknowledged);
                let state = state_for(&end, RequestState::TimedOut);
                self.close(cx, end, state);
            }
        }
    }

    fn acknowledged(&mut self, cx: &mut Context, request: u64, command: &str, stage: Stage) {
        match (command, stage) {
            ("SUS", Stage::Suspending) => self.goes_on(cx),
            ("SPD", Stage::Limiting(of)) if of == request => {
                let speed_mps = self.hold.map(|hold| hold.hover.speed_mps);
                self.limit = SpeedLimit {
                    known_mps: speed_mps,
                    changed: speed_mps != cx.monitor.limits().speed_default_mps(),
                    restoring: None,
                };
                self.goes_on(cx);
            }
            ("GHP" | "GBP", Stage::Moving(of)) if of == request => self.stands(cx, request),
            ("CON", Stage::Standing) => self.stands(cx, request),
            // Of a message that another has overtaken.
            (_, Stage::Due | Stage::Suspending | Stage::Limiting(_) | Stage::Moving(_) | Stage::Standing) => {}
        }
    }

    /// The next message of the hold may leave; the vehicle has moved on meanwhile.
    fn goes_on(&mut self, cx: &mut Context) {
        if self.is_sound(cx) {
            self.advance(cx);
            self.drive(cx);
        }
    }

    /// The next BPCON is due, or what has changed.
    pub(crate) fn refresh(&mut self, cx: &mut Context) {
        self.drive(cx);
    }

    pub(crate) fn plugin_failed(&mut self, cx: &mut Context, plugin: PluginId) {
        if self.holder() == Some(plugin) {
            self.end(cx, EndCause::PluginFailed);
        }
    }
}

/// How long after a refresh the next is due.
fn refresh_every() -> Duration {
    if is_on(Check::HoldCadence) {
        REFRESH_EVERY
    } else {
        3 * REFRESH_EVERY
    }
}
