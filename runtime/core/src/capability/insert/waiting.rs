//! What the vehicle flies before a waiting insert, and whether the way from there is still inside the fence (safety
//! requirement 002).
//!
//! The vehicle flies an insert that interrupts nothing after the current behavior. That behavior may be over before its
//! path is flown: a behavior of the plan has a time limit that SPI does not report, and a lease delays it. And the
//! vehicle may fly the insert after another behavior than the one it was judged for: because the behavior has changed
//! when the insert arrives, or because vehicles differ in where they put an insert in their plan (SPI 7.5).

use crate::capability::insert::Inserts;
use crate::context::Context;
use crate::monitor::envelope::Insert;
use crate::mutations::{Check, is_on};

impl Inserts {
    /// The vehicle goes on in its plan, or its plan is known anew: cancels each waiting insert whose way from there is
    /// no longer inside the fence. What comes after a cancelled insert then has another way.
    pub(crate) fn judge_waiting(&mut self, cx: &mut Context) {
        if !cx.vehicle.plan.is_complete() || !is_on(Check::InsertWayTo) {
            return;
        }
        let mut before = Vec::new();
        let chain = cx.outlook().chain();
        let waits = |cx: &Context, (request, insert, begun): &(u64, Insert, bool)| {
            !begun && !insert.interrupt && !cx.ledger.is_recalled(*request)
        };
        for open in &chain {
            let (request, insert, _) = open;
            if !waits(cx, open) {
                before.push(*open);
                continue;
            }
            let Err(refusal) = cx.outlook().judge_way_to(&before, insert) else {
                // All others come after it.
                break;
            };
            self.call_back(
                cx,
                *request,
                &format!("the way to it is no longer allowed: {}", refusal.detail()),
            );
            if insert.surfaces() {
                return;
            }
        }
        for open in chain.iter().rev() {
            // What has begun, and what interrupts, is flown before everything that waits.
            if !waits(cx, open) {
                continue;
            }
            let Err(refusal) = cx.outlook().judge_way_on(&open.1) else {
                return;
            };
            let text = format!("the way on from it is no longer allowed: {}", refusal.detail());
            self.call_back(cx, open.0, &text);
        }
    }
}
