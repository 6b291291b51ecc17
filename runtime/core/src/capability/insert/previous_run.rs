//! Inserts that a previous run has left in the vehicle, taken back under the operator's hold.

use std::time::Duration;

use backseat_spi::{BehaviorId, CancelBehavior, ToVehicle};

use super::Inserts;
use crate::context::Context;
use crate::io::Note;
use crate::mutations::{Check, is_on};
use crate::timer::Timer;

/// How often a cancel is sent on a connection.
const SENT_MAX: u32 = 5;
/// How long after a cancel the plan is looked at again.
const AGAIN_AFTER: Duration = Duration::from_secs(2);

impl Inserts {
    /// The operator holds: what a previous run has left in the plan is taken back too. What cannot be (a GPS hit) the
    /// vehicle refuses.
    pub(crate) fn cancel_previous_run(&mut self, cx: &mut Context) {
        let waiting = cx.vehicle.previous_run.waiting(SENT_MAX);
        for identifier in &waiting {
            self.take_back(cx, *identifier);
        }
        if !waiting.is_empty() {
            cx.timers.set(Timer::Plan, cx.now + AGAIN_AFTER);
        }
    }

    /// The vehicle's plan names an insert, before the plan has come whole: under the operator's hold it is taken back at
    /// once.
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
            let text = format!("insert {identifier} of a previous run is taken back");
            cx.note(Note::Text { text });
        }
    }
}
