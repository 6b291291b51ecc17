//! Station keeping, the lease of a hovering vehicle: its mission is suspended, and it stays where it is or moves (SPI
//! 8; safety requirement 005).
//!
//! Station keeping sends BPSUS and, for a move, BPSPD and then BPGHP or BPGBP, each after the acknowledgement of the
//! one before. BPCON keeps it alive. Core sets the speed limit of every move itself, and relies on no limit that
//! somebody left. Whatever ends station keeping, core gives the vehicle its own speed limit back, sends BPRES, and
//! nothing after it.

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
use crate::mutations::{Check, is_on};
use crate::plugin::{PluginId, Refusal, RequestState, StationRequest, StationTarget};
use crate::refusal::{Figure, Reason};
use crate::session::commands::{Answer, Command, FIRST_WITHIN, Purpose};
use crate::session::name;
use crate::timer::Timer;

mod relative;
mod speed;

use speed::SpeedLimit;

/// The vehicle resumes its mission after 2 s (8.1).
const REFRESH_EVERY: Duration = Duration::from_millis(500);
/// If the last message is older than this, a refresh is too late: station keeping ends.
const REFRESH_AT_MOST: Duration = Duration::from_secs(1);
/// Station keeping that begins or changes is sent at once, at 5 Hz at most.
const REFRESH_AT_LEAST: Duration = Duration::from_millis(200);

/// The most places to remember at which the mission was suspended, and to which the vehicle may return.
const LEFT_MAX: usize = 16;

/// The state of station keeping.
#[derive(Debug)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Station {
    keeping: Option<Keeping>,
    limit: SpeedLimit,
    /// When the last BPSUS, BPSPD, BPGHP or BPGBP was sent, for any request.
    steered: Option<Timestamp>,
}

/// The plugin for which the vehicle keeps its station, and how.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) struct Keeping {
    plugin: PluginId,
    request: u64,
    tag: u64,
    target: StationTarget,
    speed_mps: Option<f64>,
    hover: Hover,
    stage: Stage,
    /// Where the mission was suspended; known once BPSUS was sent.
    suspended: Option<Suspended>,
    /// The last move that was sent: the vehicle is on its way there.
    flown: Option<Hover>,
    /// When the last BPSUS, BPCON, BPGHP or BPGBP was sent.
    sent: Option<Timestamp>,
}

/// How far the newest request of station keeping has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
enum Stage {
    /// Its first message is due.
    Due,
    /// BPSUS was sent.
    Suspending,
    /// BPSPD was sent, for this request.
    Limiting(u64),
    /// BPGHP or BPGBP was sent, for this request.
    Moving(u64),
    /// Every message is acknowledged.
    Standing,
}

impl Station {
    pub(crate) fn new() -> Self {
        Self {
            keeping: None,
            limit: SpeedLimit::default(),
            steered: None,
        }
    }

    /// The plugin for which the vehicle keeps its station.
    pub(crate) fn kept_for(&self) -> Option<PluginId> {
        self.keeping.map(|keeping| keeping.plugin)
    }

    /// The connection is new or lost: forgets what answers have said of the speed limit.
    pub(crate) fn reset(&mut self) {
        self.limit.restoring = None;
        self.limit.known_mps = None;
    }

    /// When the next message that begins or changes station keeping may leave.
    fn free_at(&self) -> Timestamp {
        self.steered
            .map_or(Timestamp::ZERO, |steered| steered + REFRESH_AT_LEAST)
    }
}

impl Station {
    /// A request replaces the current one, if there is one. Returns the replaced one.
    pub(crate) fn adopt(
        &mut self,
        cx: &mut Context,
        plugin: PluginId,
        request: u64,
        asked: &StationRequest,
        hover: Hover,
    ) -> Option<Keeping> {
        let before = self.keeping;
        cx.arbiter.take(cx.now, plugin, LeaseKind::Station);
        let mut keeping = Keeping {
            plugin,
            request,
            tag: asked.tag,
            target: asked.target,
            speed_mps: asked.speed_mps,
            hover,
            stage: Stage::Due,
            suspended: None,
            flown: None,
            sent: None,
        };
        if let Some(before) = before {
            let changed = before.target != asked.target || before.speed_mps != asked.speed_mps;
            keeping.stage = match before.stage {
                // A change is sent after the acknowledgement.
                Stage::Suspending => Stage::Suspending,
                Stage::Due | Stage::Limiting(_) | Stage::Moving(_) | Stage::Standing if changed => Stage::Due,
                stage @ (Stage::Due | Stage::Limiting(_) | Stage::Moving(_) | Stage::Standing) => stage,
            };
            keeping.suspended = before.suspended;
            keeping.flown = before.flown;
            keeping.sent = before.sent;
        }
        self.keeping = Some(keeping);
        cx.timers.set(Timer::StationTerm, cx.now + asked.duration);
        before
    }

    /// Sends the first message of adopted station keeping, or what has changed.
    pub(crate) fn begin(&mut self, cx: &mut Context, before: Option<Keeping>) {
        if let Some(before) = before {
            let same = |keeping: Keeping| before.plugin == keeping.plugin && before.tag == keeping.tag;
            if self.keeping.is_some_and(same) {
                cx.transition_quietly(before.request, RequestState::Ended(EndCause::Replaced.into()));
            } else {
                cx.transition(before.request, RequestState::Ended(EndCause::OtherStation.into()));
            }
        }
        self.watch_relative(cx);
        self.drive(cx);
    }

    /// Checks a request and returns what station keeping sends.
    pub(crate) fn check(&self, cx: &Context, plugin: PluginId, asked: &StationRequest) -> Result<Hover, Refusal> {
        cx.outlook().admit_beside_gps_hit()?;
        if cx.vehicle.suspended.len() >= LEFT_MAX {
            return Err(Figure::Suspensions.over(LEFT_MAX as f64 + 1.0, LEFT_MAX as f64));
        }
        let mut hover = cx.monitor.envelope.admit_station(asked)?;
        cx.cap_steering(plugin, asked.duration)?;
        // SPI has no command to stop. To stop a vehicle that was sent somewhere, core sends it to where it is.
        if hover.aim.is_none()
            && let Some(keeping) = &self.keeping
            && let Some(last) = keeping.flown.and_then(|flown| flown.aim)
        {
            hover.aim = match keeping.target {
                StationTarget::Here => keeping.hover.aim,
                StationTarget::Hull { .. } | StationTarget::Bottom { .. } => Some(aim_at_here(&last, self.here(cx)?)?),
            };
            hover.speed_mps = asked.speed_mps.unwrap_or(keeping.hover.speed_mps);
        }
        self.judge_hover(cx, &hover)?;
        Ok(hover)
    }

    /// Judges station keeping in full, with what core knows now.
    fn judge_hover(&self, cx: &Context, hover: &Hover) -> Result<f64, Refusal> {
        self.with_surroundings(cx, |around| cx.monitor.envelope.judge_station(hover, around))
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
            .chain(self.keeping.and_then(|keeping| keeping.suspended))
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

    /// Sends what is due, and sets when to come back.
    fn drive(&mut self, cx: &mut Context) {
        let Some(keeping) = self.keeping else { return };
        if keeping.sent.is_some_and(|sent| cx.now.since(sent) > REFRESH_AT_MOST)
            && is_on(Check::LateWake)
            && is_on(Check::StationCadence)
        {
            return self.end(cx, EndCause::NotRefreshed);
        }
        if !self.prevent(cx) {
            return;
        }
        if keeping.stage == Stage::Due && cx.now >= self.free_at() {
            self.advance(cx);
        }
        if let Some(keeping) = self.keeping
            && keeping.sent.is_some_and(|sent| cx.now.since(sent) >= refresh_every())
        {
            let created = cx.stamper.stamp(cx.now, "CON");
            self.send(cx, "CON", &ToVehicle::Continue(Continue { created }));
        }
        let Some(keeping) = self.keeping else { return };
        let refresh = keeping.sent.map(|sent| sent + refresh_every());
        let due = (keeping.stage == Stage::Due).then(|| self.free_at().max(cx.now));
        let next = refresh.into_iter().chain(due).min();
        cx.timers.set_or_stop(Timer::Station, next);
    }

    /// A sample is new, time has passed, or something is about to be sent: judges station keeping in full, and ends it
    /// if it fails. It does so even if it has done so at this moment: a message of the same read may have changed since
    /// what core knows. Until a changed move is sent, the vehicle flies the one before, so both are judged. The
    /// judgement is a few comparisons. False if no station keeping is left.
    pub(crate) fn prevent(&mut self, cx: &mut Context) -> bool {
        let Some(keeping) = self.keeping else { return false };
        let flown = keeping.flown.filter(|flown| *flown != keeping.hover);
        let judged = || {
            self.judge_hover(cx, &keeping.hover)?;
            flown.map_or(Ok(0.0), |flown| self.judge_hover(cx, &flown))
        };
        if is_on(Check::StationJudged)
            && let Err(refusal) = judged()
        {
            self.end(cx, refusal);
            return false;
        }
        true
    }

    /// Sends the next message that leads to what is asked for. Station keeping has been judged at this moment.
    fn advance(&mut self, cx: &mut Context) {
        let Some(keeping) = self.keeping else { return };
        if keeping.suspended.is_none() {
            let here = self.here(cx).unwrap_or_default();
            let created = cx.stamper.stamp(cx.now, "SUS");
            if self.send(cx, "SUS", &ToVehicle::Suspend(Suspend { created })) {
                self.set_stage(Stage::Suspending);
                if let Some(keeping) = &mut self.keeping {
                    keeping.suspended = Some(here);
                }
            }
            return;
        }
        let Some(aim) = keeping.hover.aim else {
            return self.stands(cx, keeping.request);
        };
        if self.limit.known_mps != Some(keeping.hover.speed_mps) {
            let created = cx.stamper.stamp(cx.now, "SPD");
            let speed_mps = keeping.hover.speed_mps;
            // Set before the message is sent: from then on the vehicle may have this limit, whatever happens.
            self.limit = SpeedLimit {
                known_mps: None,
                changed: self.limit.changed || cx.monitor.limits().speed_default_mps() != Some(speed_mps),
                restoring: None,
            };
            let limit = ToVehicle::HullSpeedLimit(HullSpeedLimit { created, speed_mps });
            if self.send(cx, "SPD", &limit) {
                self.set_stage(Stage::Limiting(keeping.request));
            }
            return;
        }
        let (letters, message) = self.move_to(cx, aim);
        if self.send(cx, letters, &message) {
            self.set_stage(Stage::Moving(keeping.request));
            if let Some(keeping) = &mut self.keeping {
                keeping.flown = Some(keeping.hover);
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

    /// Sends a message of station keeping. False if that ended it.
    fn send(&mut self, cx: &mut Context, letters: &'static str, message: &ToVehicle) -> bool {
        let Some(keeping) = self.keeping else { return false };
        let command = Command {
            name: name(letters),
            created: message.created(),
            identifier: None,
            purpose: Purpose::Station(keeping.request),
            deadline: cx.now + FIRST_WITHIN,
            pending: false,
        };
        if !cx.transmit_for(keeping.plugin.into(), message, Some(command)) {
            self.end(cx, EndCause::NotSent);
            return false;
        }
        let refreshes = letters != "SPD";
        let steers = letters != "CON";
        if steers {
            self.steered = Some(cx.now);
        }
        if let Some(keeping) = &mut self.keeping
            && refreshes
        {
            keeping.sent = Some(cx.now);
        }
        // A request that changes nothing is sent with the next BPCON. One whose own message still waits is not.
        if steers || keeping.stage == Stage::Standing {
            cx.transition(keeping.request, RequestState::Sent);
        }
        // The event may have made its plugin fail.
        self.keeping.is_some_and(|now| now.request == keeping.request)
    }

    fn set_stage(&mut self, stage: Stage) {
        if let Some(keeping) = &mut self.keeping {
            keeping.stage = stage;
        }
    }

    /// Everything that a request of station keeping needs is acknowledged.
    fn stands(&mut self, cx: &mut Context, request: u64) {
        self.set_stage(Stage::Standing);
        if self.keeping.is_some_and(|keeping| keeping.request == request) {
            cx.transition(request, RequestState::Accepted);
        }
    }

    /// The plugin ends its own station keeping.
    pub(crate) fn asked_end(&mut self, cx: &mut Context, plugin: PluginId) {
        if self.kept_for() == Some(plugin) {
            self.end(cx, EndCause::PluginEnded);
        }
    }

    /// Forgets the places to which the vehicle has now returned. Only a vehicle without station keeping returns.
    fn watch_return(&mut self, cx: &mut Context) {
        if self.keeping.is_some() || cx.vehicle.suspended.is_empty() {
            return;
        }
        let Some(limits) = &cx.monitor.limits().station else {
            return;
        };
        let within_m = 2.0 * limits.position_error_m;
        if let Ok(here) = self.here(cx) {
            cx.vehicle
                .suspended
                .retain(|suspended| !suspended.is_near(&here, within_m));
        }
    }

    /// Ends station keeping, if there is one: sends the vehicle's own speed limit and BPRES if the link is up, and
    /// nothing after them.
    pub(crate) fn end(&mut self, cx: &mut Context, end: impl Into<Ended>) {
        let end = end.into();
        self.close(cx, end.clone(), RequestState::Ended(end));
    }

    fn close(&mut self, cx: &mut Context, end: Ended, state: RequestState) {
        let Some(keeping) = self.keeping.take() else { return };
        cx.vehicle.suspended.extend(keeping.suspended);
        cx.arbiter.release(cx.now, LeaseKind::Station);
        for timer in [Timer::Station, Timer::StationTerm, Timer::Relative] {
            cx.timers.stop(timer);
        }
        cx.link.commands.forget_station();
        if keeping.sent.is_some() {
            cx.monitor.permits.station_ends = true;
            self.restore_speed(cx, keeping.request);
            // A BPRES that is not answered is not repeated: the vehicle resumes its mission by itself after 2 s (8.1).
            let created = cx.stamper.stamp(cx.now, "RES");
            let command = cx.courtesy("RES", Some(created));
            if is_on(Check::StationEndSaid) {
                cx.transmit(&ToVehicle::Resume(Resume { created }), Some(command));
            }
            cx.monitor.permits.station_ends = false;
        }
        let proposed = cx
            .ledger
            .get(keeping.request)
            .is_some_and(|entry| matches!(entry.state, RequestState::Rejected(_)));
        // A request that was never sent cannot have been refused or left unanswered.
        let state = if proposed {
            RequestState::Ended(end.clone())
        } else {
            state
        };
        cx.transition(keeping.request, state);
        cx.note(Note::LeaseEnded {
            plugin: keeping.plugin,
            reason: end,
        });
    }

    /// An answer to a message of the current station keeping.
    pub(crate) fn answered(&mut self, cx: &mut Context, request: u64, command: CommandName, answer: Answer<'_>) {
        let Some(keeping) = self.keeping else { return };
        let newest = keeping.request == request;
        let state_for = |end: &Ended, state: RequestState| {
            if newest {
                state
            } else {
                // The request is an older one of station keeping that goes on. What the answer says of the vehicle
                // counts.
                RequestState::Ended(end.clone())
            }
        };
        match answer {
            Answer::Pending if newest => cx.transition(request, RequestState::Pending),
            Answer::Pending => {}
            Answer::Done => self.acknowledged(cx, request, command.as_str(), keeping.stage),
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
                let speed_mps = self.keeping.map(|keeping| keeping.hover.speed_mps);
                self.limit = SpeedLimit {
                    known_mps: speed_mps,
                    changed: speed_mps != cx.monitor.limits().speed_default_mps(),
                    restoring: None,
                };
                self.goes_on(cx);
            }
            ("GHP" | "GBP", Stage::Moving(of)) if of == request => self.stands(cx, request),
            ("CON", Stage::Standing) => self.stands(cx, request),
            // The message was overtaken by another one.
            (_, Stage::Due | Stage::Suspending | Stage::Limiting(_) | Stage::Moving(_) | Stage::Standing) => {}
        }
    }

    /// The next message may leave. Station keeping is judged again first, because the vehicle has moved meanwhile.
    fn goes_on(&mut self, cx: &mut Context) {
        if self.prevent(cx) {
            self.advance(cx);
            self.drive(cx);
        }
    }

    /// The next BPCON, or a change, is due.
    pub(crate) fn refresh(&mut self, cx: &mut Context) {
        self.drive(cx);
    }

    pub(crate) fn plugin_failed(&mut self, cx: &mut Context, plugin: PluginId) {
        if self.kept_for() == Some(plugin) {
            self.end(cx, EndCause::PluginFailed);
        }
    }
}

/// How long after a refresh the next is due.
fn refresh_every() -> Duration {
    if is_on(Check::StationCadence) {
        REFRESH_EVERY
    } else {
        3 * REFRESH_EVERY
    }
}
