//! What the vehicle flies before an insert that waits its turn, and whether the way from there still holds (safety
//! requirement 002).
//!
//! An insert that interrupts nothing is flown after the current behavior. That may be over sooner than its path is: a
//! behavior of the plan has a time limit that no sentence tells, and a lease delays it. And it may be another one by
//! the time that the insert arrives, or than the insert was judged for, where vehicles differ in the place that they give
//! it (SPI 7.5).

use crate::capability::insert::Inserts;
use crate::context::Context;
use crate::monitor::envelope::Insert;
use crate::mutations::{Check, is_on};

impl Inserts {
    /// The plan is flown on, or is known anew: an insert that waits and whose way does not hold from there is called
    /// back. What comes after it has then another way.
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
                // The rest comes after it.
                break;
            };
            self.call_back(cx, *request, &format!("its way no longer holds: {}", refusal.detail()));
            if insert.surfaces() {
                return;
            }
        }
        for open in chain.iter().rev() {
            // What has begun and what interrupts is flown before all that waits.
            if !waits(cx, open) {
                continue;
            }
            let Err(refusal) = cx.outlook().judge_way_on(&open.1) else {
                return;
            };
            let text = format!("its way on no longer holds: {}", refusal.detail());
            self.call_back(cx, open.0, &text);
        }
    }
}
