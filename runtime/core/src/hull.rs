//! Leases of a hovering vehicle: its mission suspended, the vehicle held or moved (SPI 8; safety requirement 005).
//!
//! A hold goes out as BPSUS, then BPSPD where it moves, then BPGHP or BPGBP, each after the acknowledgement of the one
//! before, and is kept alive by BPCON. The speed limit of a move is always known: one that somebody left is not
//! inherited. Whatever ends the hold, the vehicle gets its own speed limit back, then BPRES, then silence.

use std::time::Duration;

use backseat_spi::{
    BottomPosition, CommandName, Continue, HullPosition, HullSpeedLimit, Resume, Suspend, ToVehicle, VerticalReference,
};
use backseat_units::{EastNorth, Timestamp};

use crate::arbiter::LeaseKind;
use crate::commands::{Answer, Command, FIRST_WITHIN, Purpose};
use crate::context::Context;
use crate::envelope::{Aim, Hover, Surroundings, Suspended, Vertical, aim_at_here};
use crate::helm::refused;
use crate::io::Note;
use crate::ledger::RequestKind;
use crate::limits::Grant;
use crate::machine::Core;
use crate::plugin::{HoldRequest, HoldTarget, PluginId, Refusal, RequestState};
use crate::session::name;
use crate::switches::{Check, is_on};
use crate::timer::Timer;

mod speed;
mod track;

use speed::SpeedLimit;
pub(crate) use track::Track;

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
pub(crate) struct Hull {
    hold: Option<Hold>,
    limit: SpeedLimit,
    /// When the last BPSUS, or the last BPSPD, BPGHP or BPGBP of a hold left, of any hold.
    steered: Option<Timestamp>,
}

/// Who holds the vehicle, and how.
#[derive(Clone, Copy, Debug)]
struct Hold {
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

impl Hull {
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

impl Core {
    pub(crate) fn ask_hold(&mut self, plugin: PluginId, asked: &HoldRequest) {
        let request = self.cx.ledger.propose(plugin, asked.tag, RequestKind::Hold);
        let hover = match self.admit_hold(plugin, asked) {
            Ok(hover) => hover,
            Err(refusal) => return self.cx.reject(request, refusal),
        };
        let before = self.hull.hold;
        self.cx.arbiter.take(self.cx.now, plugin, LeaseKind::Station);
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
            judged: self.cx.now,
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
        self.hull.hold = Some(hold);
        self.cx.timers.set(Timer::HoldTerm, self.cx.now + asked.duration);
        // BPEMB comes before BPSUS. The hold stands already, for a plugin that fails of the events ends it.
        self.end_lease("a hold took its place");
        if let Some(before) = before {
            if before.plugin == plugin && before.tag == asked.tag {
                self.cx
                    .transition_quietly(before.request, RequestState::Ended("replaced".to_owned()));
            } else {
                let reason = "another hold took its place";
                self.cx
                    .transition(before.request, RequestState::Ended(reason.to_owned()));
            }
        }
        self.watch_relative();
        self.drive_hold();
    }

    fn admit_hold(&mut self, plugin: PluginId, asked: &HoldRequest) -> Result<Hover, Refusal> {
        self.cx.admit(plugin, Grant::Hull)?;
        self.cx.arbiter.arbitrate(plugin, LeaseKind::Station)?;
        self.cx.admit_beside_gps_hit()?;
        if self.cx.suspended.len() >= LEFT_MAX {
            let text = format!("the mission may stand suspended at {LEFT_MAX} places, the most that are kept");
            return Err(refused("cap", &text));
        }
        let mut hover = self.cx.envelope.admit_hold(asked)?;
        self.cx.cap_steering(plugin, asked.duration)?;
        // There is no command to stop: a vehicle that has been sent somewhere is sent to where it is.
        if hover.aim.is_none()
            && let Some(hold) = &self.hull.hold
            && let Some(last) = &hold.sent_aim
        {
            hover.aim = match hold.target {
                HoldTarget::Here => hold.hover.aim,
                HoldTarget::Hull { .. } | HoldTarget::Bottom { .. } => Some(aim_at_here(last, self.here()?)?),
            };
            hover.speed_mps = asked.speed_mps.unwrap_or(hold.hover.speed_mps);
        }
        self.judge_hover(&hover)?;
        Ok(hover)
    }

    /// The whole judgement of a hold, with what is known at this moment.
    fn judge_hover(&self, hover: &Hover) -> Result<f64, Refusal> {
        self.with_surroundings(|around| self.cx.envelope.judge_hold(hover, around))
    }

    fn here(&self) -> Result<Suspended, Refusal> {
        self.with_surroundings(|around| Ok(around.here()))
    }

    fn with_surroundings<T>(&self, ask: impl FnOnce(&Surroundings<'_>) -> Result<T, Refusal>) -> Result<T, Refusal> {
        let Some(navigation) = self.cx.tracker.fresh(self.cx.now) else {
            return Err(refused("navigation", "navigation is stale"));
        };
        let (relative, cartesian) = (
            self.cx.relative.steady(self.cx.now),
            self.cx.cartesian.steady(self.cx.now),
        );
        let suspended: Vec<Suspended> = self
            .cx
            .suspended
            .iter()
            .copied()
            .chain(self.hull.hold.and_then(|hold| hold.suspended))
            .collect();
        ask(&Surroundings {
            relative: relative.as_ref(),
            cartesian: cartesian.as_ref(),
            navigation,
            lock: self.cx.tracker.bottom_lock(self.cx.now),
            suspended: &suspended,
            now: self.cx.now,
        })
    }

    /// Sends what is due of the hold, and sets when to come back.
    fn drive_hold(&mut self) {
        let Some(hold) = self.hull.hold else { return };
        if hold.sent.is_some_and(|sent| self.cx.now.since(sent) > REFRESH_AT_MOST)
            && is_on(Check::LateWake)
            && is_on(Check::HoldCadence)
        {
            return self.end_hold("it was not refreshed in time");
        }
        if !self.hold_is_sound() {
            return;
        }
        if hold.stage == Stage::Due && self.cx.now >= self.hull.free_at() {
            self.advance_hold();
        }
        if let Some(hold) = self.hull.hold
            && hold.sent.is_some_and(|sent| self.cx.now.since(sent) >= refresh_every())
        {
            let created = self.cx.stamper.stamp(self.cx.now, "CON");
            self.send_hold("CON", &ToVehicle::Continue(Continue { created }));
        }
        let Some(hold) = self.hull.hold else { return };
        let refresh = hold.sent.map(|sent| sent + refresh_every());
        let due = (hold.stage == Stage::Due).then(|| self.hull.free_at().max(self.cx.now));
        let next = refresh.into_iter().chain(due).min();
        self.cx.timers.set_or_stop(Timer::Hold, next);
    }

    /// Judges the hold anew where that is older than this moment; ends it where it does not hold.
    fn hold_is_sound(&mut self) -> bool {
        let Some(hold) = self.hull.hold else { return false };
        hold.judged == self.cx.now || self.prevent_hold()
    }

    /// A sample is new, or time has passed: the hold is judged in full, and ends where it does not hold. Its checks are
    /// a few comparisons, so that each sample is worth one. False where no hold stands after it.
    pub(crate) fn prevent_hold(&mut self) -> bool {
        let Some(hold) = self.hull.hold else { return false };
        if is_on(Check::HoldJudged)
            && let Err(refusal) = self.judge_hover(&hold.hover)
        {
            self.end_hold(&refusal.text);
            return false;
        }
        if let Some(hold) = &mut self.hull.hold {
            hold.judged = self.cx.now;
        }
        true
    }

    /// Sends the next message on the way to what is asked; the hold has been judged at this moment.
    fn advance_hold(&mut self) {
        let Some(hold) = self.hull.hold else { return };
        if hold.suspended.is_none() {
            let here = self.here().unwrap_or_default();
            let created = self.cx.stamper.stamp(self.cx.now, "SUS");
            if self.send_hold("SUS", &ToVehicle::Suspend(Suspend { created })) {
                self.set_stage(Stage::Suspending);
                if let Some(hold) = &mut self.hull.hold {
                    hold.suspended = Some(here);
                }
            }
            return;
        }
        let Some(aim) = hold.hover.aim else {
            return self.hold_stands(hold.request);
        };
        if self.hull.limit.known_mps != Some(hold.hover.speed_mps) {
            let created = self.cx.stamper.stamp(self.cx.now, "SPD");
            let speed_mps = hold.hover.speed_mps;
            // Before it is sent: what is sent may have come through.
            self.hull.limit = SpeedLimit {
                known_mps: None,
                changed: self.hull.limit.changed || self.cx.speed_default_mps() != Some(speed_mps),
                restoring: None,
            };
            let limit = ToVehicle::HullSpeedLimit(HullSpeedLimit { created, speed_mps });
            if self.send_hold("SPD", &limit) {
                self.set_stage(Stage::Limiting(hold.request));
            }
            return;
        }
        let (letters, message) = self.move_to(aim);
        if self.send_hold(letters, &message) {
            self.set_stage(Stage::Moving(hold.request));
            if let Some(hold) = &mut self.hull.hold {
                hold.sent_aim = Some(aim);
            }
        }
    }

    fn move_to(&mut self, aim: Aim) -> (&'static str, ToVehicle) {
        match aim {
            Aim::Hull {
                horizontal_m,
                vertical_m,
                distance_m,
            } => {
                let created = self.cx.stamper.stamp(self.cx.now, "GHP");
                let message = HullPosition {
                    created,
                    horizontal_m,
                    vertical_m,
                    distance_m,
                };
                ("GHP", ToVehicle::HullPosition(message))
            }
            Aim::Bottom { x_m, y_m, vertical } => {
                let created = self.cx.stamper.stamp(self.cx.now, "GBP");
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
    fn send_hold(&mut self, letters: &'static str, message: &ToVehicle) -> bool {
        let Some(hold) = self.hull.hold else { return false };
        let command = Command {
            name: name(letters),
            created: message.created(),
            identifier: None,
            purpose: Purpose::Hold(hold.request),
            deadline: self.cx.now + FIRST_WITHIN,
            pending: false,
        };
        if !self.cx.transmit_for(hold.plugin.into(), message, Some(command)) {
            self.end_hold("it could not be sent");
            return false;
        }
        let refreshes = letters != "SPD";
        let steers = letters != "CON";
        if steers {
            self.hull.steered = Some(self.cx.now);
        }
        if let Some(hold) = &mut self.hull.hold
            && refreshes
        {
            hold.sent = Some(self.cx.now);
        }
        // A request that changes nothing goes out with the next BPCON; one whose own message waits does not.
        if steers || hold.stage == Stage::Standing {
            self.cx.transition(hold.request, RequestState::Sent);
        }
        // Its plugin may have failed of the event.
        self.hull.hold.is_some_and(|now| now.request == hold.request)
    }

    fn set_stage(&mut self, stage: Stage) {
        if let Some(hold) = &mut self.hull.hold {
            hold.stage = stage;
        }
    }

    /// All that a request of the hold needs is acknowledged.
    fn hold_stands(&mut self, request: u64) {
        self.set_stage(Stage::Standing);
        if self.hull.hold.is_some_and(|hold| hold.request == request) {
            self.cx.transition(request, RequestState::Accepted);
        }
    }

    /// The plugin ends its own hold.
    pub(crate) fn ask_end_hold(&mut self, plugin: PluginId) {
        if self.hull.holder() == Some(plugin) {
            self.end_hold("its plugin ended it");
        }
    }

    /// The vehicle is where it may have returned to. One without a hold is.
    fn watch_return(&mut self) {
        if self.hull.hold.is_some() || self.cx.suspended.is_empty() {
            return;
        }
        let Some(limits) = &self.cx.envelope.limits().hull else {
            return;
        };
        let within_m = 2.0 * limits.position_error_m;
        if let Ok(here) = self.here() {
            self.cx
                .suspended
                .retain(|suspended| !suspended.is_near(&here, within_m));
        }
    }

    /// Ends the hold, if there is one: the vehicle's own speed limit and BPRES where the link is up, then silence.
    pub(crate) fn end_hold(&mut self, reason: &str) {
        self.close_hold(reason, RequestState::Ended(reason.to_owned()));
    }

    fn close_hold(&mut self, reason: &str, state: RequestState) {
        let Some(hold) = self.hull.hold.take() else { return };
        self.cx.suspended.extend(hold.suspended);
        self.cx.arbiter.release(self.cx.now, LeaseKind::Station);
        for timer in [Timer::Hold, Timer::HoldTerm, Timer::Relative] {
            self.cx.timers.stop(timer);
        }
        self.cx.commands.forget_hold();
        if hold.sent.is_some() {
            self.cx.permits.station_ends = true;
            self.restore_speed(hold.request);
            // One that is not answered needs no second: the vehicle takes its mission up by itself after 2 s (8.1).
            let created = self.cx.stamper.stamp(self.cx.now, "RES");
            let command = self.cx.courtesy("RES", Some(created));
            if is_on(Check::HoldEndSaid) {
                self.cx.transmit(&ToVehicle::Resume(Resume { created }), Some(command));
            }
            self.cx.permits.station_ends = false;
        }
        let proposed = self
            .cx
            .ledger
            .get(hold.request)
            .is_some_and(|entry| matches!(entry.state, RequestState::Rejected(_)));
        // What has not been sent cannot have been refused or left unanswered.
        let state = if proposed {
            RequestState::Ended(reason.to_owned())
        } else {
            state
        };
        self.cx.transition(hold.request, state);
        self.cx.note(Note::LeaseEnded {
            plugin: hold.plugin,
            reason: reason.to_owned(),
        });
    }

    /// An answer to a message of the hold that stands.
    pub(crate) fn hold_answered(&mut self, request: u64, command: CommandName, answer: Answer<'_>) {
        let Some(hold) = self.hull.hold else { return };
        let newest = hold.request == request;
        let end = |reason: &str, state: RequestState| {
            if newest {
                state
            } else {
                // An older request of a hold that goes on: what it says of the vehicle counts all the same.
                RequestState::Ended(reason.to_owned())
            }
        };
        match answer {
            Answer::Pending if newest => self.cx.transition(request, RequestState::Pending),
            Answer::Pending => {}
            Answer::Done => self.hold_acknowledged(request, command.as_str(), hold.stage),
            Answer::Refused(text) => {
                let reason = format!("the vehicle refused it: {text}");
                let state = end(&reason, RequestState::Failed(text.to_owned()));
                self.close_hold(&reason, state);
            }
            Answer::Missing => {
                let reason = "the vehicle did not acknowledge it";
                self.close_hold(reason, end(reason, RequestState::TimedOut));
            }
        }
    }

    fn hold_acknowledged(&mut self, request: u64, command: &str, stage: Stage) {
        match (command, stage) {
            ("SUS", Stage::Suspending) => self.hold_goes_on(),
            ("SPD", Stage::Limiting(of)) if of == request => {
                let speed_mps = self.hull.hold.map(|hold| hold.hover.speed_mps);
                self.hull.limit = SpeedLimit {
                    known_mps: speed_mps,
                    changed: speed_mps != self.cx.speed_default_mps(),
                    restoring: None,
                };
                self.hold_goes_on();
            }
            ("GHP" | "GBP", Stage::Moving(of)) if of == request => self.hold_stands(request),
            ("CON", Stage::Standing) => self.hold_stands(request),
            // Of a message that another has overtaken.
            (_, Stage::Due | Stage::Suspending | Stage::Limiting(_) | Stage::Moving(_) | Stage::Standing) => {}
        }
    }

    /// The next message of the hold may leave; the vehicle has moved on meanwhile.
    fn hold_goes_on(&mut self) {
        if self.hold_is_sound() {
            self.advance_hold();
            self.drive_hold();
        }
    }

    /// The next BPCON is due, or what has changed.
    pub(crate) fn refresh_hold(&mut self) {
        self.drive_hold();
    }

    pub(crate) fn hold_plugin_failed(&mut self, plugin: PluginId) {
        if self.hull.holder() == Some(plugin) {
            self.end_hold("its plugin failed");
        }
    }
}

impl Context {
    /// The mission has gone on, for a behaviour has begun or it is over.
    pub(crate) fn mission_goes_on(&mut self) {
        self.suspended.clear();
    }

    /// Where the vehicle may return to before its mission goes on.
    pub(crate) fn returns_to(&self) -> impl Iterator<Item = EastNorth> + '_ {
        self.suspended.iter().filter_map(|suspended| suspended.local)
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
