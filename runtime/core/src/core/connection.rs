//! The link goes up and down, the plan comes, and acknowledgements complete round trips.

use std::time::Duration;

use backseat_spi::Acknowledgement;

use super::Core;
use super::course;
use super::samples::tell_of_plan;
use crate::context::Context;
use crate::control::ClockSet;
use crate::ended::EndCause;
use crate::io::Note;
use crate::mutations::{Check, is_on};
use crate::refusal::Uncontrolled;
use crate::session::commands::Answer;
use crate::timer::Timer;
use crate::vehicle::expected::Compared;

/// If the plan names an insert that is over, core asks for it again after this time.
const NAMED_AGAIN: Duration = Duration::from_secs(30);

impl Core {
    pub(super) fn link_up(&mut self) {
        let Self {
            cx,
            capabilities,
            orders,
            session,
            ..
        } = self;
        if !cx.vehicle.previous_run.is_none() {
            course::may_be_led(cx, cx.now);
        }
        cx.link.begin(cx.now);
        cx.vehicle.reset();
        cx.control.forget();
        capabilities.station.reset();
        cx.note(Note::LinkUp);
        session.begin(cx);
        orders.link_up(cx, capabilities);
        capabilities.inserts.link_up(cx);
        if cx.control.held && is_on(Check::HoldCancels) {
            // The operator may have set the hold while nothing could be sent.
            capabilities.inserts.take_back_all(cx, None);
            capabilities.inserts.cancel_previous_run(cx);
        }
        session.watch_silence(cx);
        session.beat(cx);
    }

    pub(super) fn link_down(&mut self) {
        let Self {
            cx,
            capabilities,
            orders,
            session,
            ..
        } = self;
        // No BPEMB reaches the vehicle: its own time limit ends the modify (safety requirement 007).
        cx.link.end();
        if cx.arbiter.is_steering() {
            course::may_be_led(cx, cx.now);
        } else if let Some(sent) = capabilities.modify.sent() {
            // The BPEMB of a lease that has just ended may be lost with the link.
            course::may_be_led(cx, sent);
        }
        course::lost(cx);
        cx.vehicle.previous_run.link_lost();
        capabilities.end_leases(cx, Uncontrolled::LinkDown);
        cx.control.forget();
        cx.link.commands.clear();
        cx.vehicle.reset();
        capabilities.link_lost(cx);
        orders.link_lost(cx);
        capabilities.inserts.link_lost(cx);
        cx.doubt_undecided();
        for timer in [Timer::Silence, Timer::Plan, Timer::Status, Timer::Heartbeat] {
            cx.timers.stop(timer);
        }
        if !cx.control.stopping {
            session.connect_again(cx);
        }
    }

    /// Handles the answer to BPRMP: the plan is complete, or core asks for it again.
    pub(super) fn plan_answered(&mut self, answer: Answer<'_>) {
        let Self {
            cx,
            capabilities,
            session,
            ..
        } = self;
        if !session.plan_answered(cx, answer) {
            return;
        }
        cx.vehicle.dive.planned();
        if compare_plan(cx) {
            // Ask once more, because two answers may have come mixed.
            session.ask_for_plan_again(cx);
        }
        capabilities.inserts.resolve_by_plan(cx);
        let vehicle = &mut cx.vehicle;
        vehicle.previous_run.heard_plan(&vehicle.plan);
        tell_of_plan(cx);
        capabilities.inserts.judge_waiting(cx);
        if cx.control.held && is_on(Check::HoldCancels) {
            capabilities.inserts.cancel_previous_run(cx);
            capabilities.inserts.take_back_named(cx);
        }
        if cx.outlook().names_what_is_over() {
            cx.timers.set_unless_set(Timer::Plan, cx.now + NAMED_AGAIN);
        }
    }

    /// Completes the round trip that an acknowledgement ends, if it ends one.
    pub(super) fn round_trip(&mut self, ack: &Acknowledgement) {
        let cx = &mut self.cx;
        let Some(heard) = cx.link.heartbeat.acknowledged(cx.now, ack) else {
            return;
        };
        let utc = cx.utc();
        if let Some(step) = cx.vehicle.navigation.measured(heard.trip, utc, ack.created) {
            let text = format!("the vehicle's clock was set by {:+.3} s", -(step as f64) / 1e9);
            cx.note(Note::Navigation { text });
            let set = ClockSet {
                at: cx.now,
                written: ack.created,
                by_nanos: -step,
            };
            cx.control.clock_set(set);
            cx.vehicle.clock_set(set);
            self.capabilities.end_leases(cx, EndCause::ClockSet);
        }
        if heard.good {
            self.session.is_heard(cx, ack.created);
        }
    }
}

/// Compares the vehicle's complete plan with the expected one. Returns true if they differ, and did not differ at the
/// last comparison.
fn compare_plan(cx: &mut Context) -> bool {
    let Some(expected) = &cx.settings.expected_plan else {
        return false;
    };
    let difference = expected.difference(&cx.vehicle.plan, cx.monitor.envelope.fence().frame());
    let compared = if difference.is_some() {
        Compared::Differs
    } else {
        Compared::Same
    };
    let news = cx.vehicle.compared != compared;
    cx.vehicle.compared = compared;
    if let Some(difference) = difference.filter(|_| news) {
        let text = format!("the vehicle's plan is not the one that was checked: {difference}");
        cx.note(Note::Text { text });
    }
    news && compared == Compared::Differs
}
