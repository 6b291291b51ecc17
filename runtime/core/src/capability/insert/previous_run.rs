//! Inserts that a previous run has left in the vehicle, and that the runtime cancels under the operator's hold.

use std::time::Duration;

use backseat_spi::{BehaviorId, CancelBehavior, ToVehicle};

use super::Inserts;
use crate::context::Context;
use crate::io::Note;
use crate::mutations::{Check, is_on};
use crate::timer::Timer;

/// How often the cancel of an insert is sent on a connection.
const SENT_MAX: u32 = 5;
/// How long after a cancel core asks for the plan again.
const AGAIN_AFTER: Duration = Duration::from_secs(2);

impl Inserts {
    /// The operator holds: cancels what a previous run has left in the plan, too. The vehicle refuses the cancel of a
    /// GPS hit, which cannot be cancelled.
    pub(crate) fn cancel_previous_run(&mut self, cx: &mut Context) {
        let waiting = cx.vehicle.previous_run.waiting(SENT_MAX);
        for identifier in &waiting {
            self.take_back(cx, *identifier);
        }
        if !waiting.is_empty() {
            cx.timers.set(Timer::Plan, cx.now + AGAIN_AFTER);
        }
    }

    /// The vehicle's plan names an insert, before the plan is complete: under the operator's hold, cancels it at once.
    pub(crate) fn previous_run_named(&mut self, cx: &mut Context, identifier: Option<BehaviorId>) {
        let Some(identifier) = identifier.filter(|identifier| cx.vehicle.previous_run.includes(*identifier)) else {
            return;
        };
        let is_new = cx.vehicle.previous_run.named(identifier);
        if is_new && cx.control.held && is_on(Check::HoldCancels) {
            self.take_back(cx, identifier);
            cx.timers.set(Timer::Plan, cx.now + AGAIN_AFTER);
        }
    }

    fn take_back(&mut self, cx: &mut Context, identifier: BehaviorId) {
        let created = cx.stamper.stamp(cx.now, "RCN");
        let command = cx.courtesy("RCN", Some(created));
        let message = ToVehicle::CancelBehavior(CancelBehavior { created, identifier });
        if cx.transmit(&message, Some(command)) {
            cx.vehicle.previous_run.taken_back(identifier);
            let text = format!("insert {identifier} of a previous run is cancelled");
            cx.note(Note::Text { text });
        }
    }
}
