//! Cancels beyond a plugin's own inserts: all inserts, the current behavior, the current element (SPI 7.9 to 7.11).

use backseat_spi::{CancelAll, CancelCurrent, CancelElement, ToVehicle};

use super::{Orders, admit};
use crate::context::Context;
use crate::ended::{EndCause, Failure};
use crate::io::Note;
use crate::ledger::RequestKind;
use crate::monitor::envelope::{End, Insert};
use crate::mutations::{Check, is_on};
use crate::plugin::{Refusal, RequestState};
use crate::refusal::Reason;
use crate::session::commands::{Answer, Purpose};
use crate::session::dispatch::Dispatch;
use crate::vehicle::plan::Element;

impl Orders {
    /// Sends BPRCA. It may cancel another payload's inserts too, so only the operator can order it.
    pub(super) fn order_cancel_all(&mut self, cx: &mut Context) {
        let request = cx.ledger.propose_order(RequestKind::CancelAll);
        if let Err(refusal) = admit(cx) {
            return cx.reject(request, refusal);
        }
        let created = cx.stamper.stamp(cx.now, "RCA");
        let message = ToVehicle::CancelAll(CancelAll { created });
        cx.send_request(request, &Dispatch::new("RCA", message, Purpose::CancelAll(request)));
    }

    /// Handles the vehicle's answer to BPRCA. Our inserts that the vehicle had accepted are cancelled; those that have
    /// begun are not. A GPS hit stays open: BPRCN does not cover it (7.8), and 7.9 does not say whether BPRCA does. An
    /// insert that was not answered stays in doubt: it may have begun, and it may be one that nothing may interrupt
    /// (safety requirement 010). The plan, for which core asks now, and the next begin settle it. They also settle an
    /// accepted insert that interrupts: it begins when it is accepted (7.5), so only its BFMBS was not heard. The same holds
    /// for one that has waited while a message was lost.
    ///
    /// Returns true if the vehicle has cancelled them: core must then ask it what is left of the plan.
    pub(crate) fn cancel_all_answered(&mut self, cx: &mut Context, request: u64, answer: Answer<'_>) -> bool {
        match answer {
            Answer::Pending => cx.transition(request, RequestState::Pending),
            Answer::Missing => cx.transition(request, RequestState::TimedOut),
            Answer::Refused(text) => cx.transition(request, RequestState::Failed(Failure::Vehicle(text.to_owned()))),
            Answer::Done => {
                cx.transition(request, RequestState::Accepted);
                cx.transition(request, RequestState::Ended(EndCause::Done.into()));
                let accepted: Vec<(u64, Insert, bool)> = cx
                    .ledger
                    .iter()
                    .filter(|(_, entry)| entry.state == RequestState::Accepted)
                    .filter_map(|(request, entry)| Some((request, entry.insert?, entry.may_have_begun())))
                    .collect();
                for (request, insert, may_have_begun) in accepted {
                    if insert.surfaces() {
                        cx.note(Note::Text {
                            text: format!(
                                "GPS hit {request} may still be flown: it is not certain that BPRCA covers it"
                            ),
                        });
                    } else if insert.interrupt || may_have_begun {
                        cx.transition(request, RequestState::Unknown);
                    } else {
                        if let Some(identifier) = cx.ledger.get(request).and_then(|entry| entry.identifier) {
                            cx.vehicle.plan.ended(identifier);
                        }
                        cx.transition(request, RequestState::Cancelled);
                    }
                }
                return true;
            }
        }
        false
    }

    /// Sends BPRCB. It has no identifier and ends whatever is current, so core sends it only if that is an insert of
    /// ours.
    pub(super) fn order_cancel_current(&mut self, cx: &mut Context) {
        let request = cx.ledger.propose_order(RequestKind::CancelCurrent);
        if let Err(refusal) = admit(cx).and_then(|()| self.judge_cancel_current(cx)) {
            return cx.reject(request, refusal);
        }
        let created = cx.stamper.stamp(cx.now, "RCB");
        let message = ToVehicle::CancelCurrent(CancelCurrent { created });
        cx.send_request(request, &Dispatch::new("RCB", message, Purpose::Request(request)));
    }

    /// Safety requirements 002 and 020: the order makes the vehicle fly from here to what comes next, so core judges
    /// that way.
    fn judge_cancel_current(&self, cx: &mut Context) -> Result<(), Refusal> {
        let Some(current) = cx.vehicle.named_insert.current() else {
            return Err(Reason::CurrentUnknown.into());
        };
        if !cx.identifiers.is_ours(current) {
            return Err(Reason::CurrentForeign.into());
        }
        if !cx.vehicle.plan.is_complete() {
            return Err(Reason::PlanUnknownNext.into());
        }
        let Some(navigation) = cx.vehicle.navigation.fresh(cx.now) else {
            return Err(Reason::NavigationIsStale.into());
        };
        let chain = cx.outlook().chain();
        let own = cx.ledger.by_identifier(current);
        let mut to: Vec<End> = Vec::new();
        // During a GPS hit the vehicle is on its way up, or down again.
        let mut surfacing = cx.ledger.is_gps_hit(own);
        if let Some((_, next, _)) = chain.iter().find(|(_, _, begun)| !begun) {
            to.push(cx.monitor.envelope.ends(next).0);
            surfacing |= next.surfaces();
        } else {
            to.extend(cx.vehicle.plan.goes_on_to().into_iter().map(End::At));
            let interrupts = chain.iter().any(|(_, insert, begun)| *begun && insert.interrupt);
            if interrupts || own.is_none() {
                // After an interruption the vehicle may go back to what it left: the specification can be read both
                // ways (SPI 7.5).
                let left = cx.vehicle.plan.current();
                to.extend(left.flat_map(|element: &Element| [End::At(element.first()), End::At(element.last())]));
            }
        }
        let (here, passage) = (
            End::At(navigation.local),
            cx.outlook().passage(navigation.depth, surfacing, 0.0),
        );
        // Or the vehicle takes up an insert again that this one has interrupted.
        let onto = cx.outlook().taken_up_after(false);
        for to in to.into_iter().filter(|_| is_on(Check::CancelWay)) {
            cx.monitor.envelope.judge_way((here, to), &passage)?;
        }
        for track in onto.iter().filter(|_| is_on(Check::CancelWay)) {
            cx.monitor.envelope.judge_way_onto((here, track), &passage)?;
        }
        Ok(())
    }

    /// Sends BPRCE. Core judges no way: what comes next is the front seat's own, and the operator knows what it is.
    pub(super) fn order_cancel_element(&mut self, cx: &mut Context) {
        let request = cx.ledger.propose_order(RequestKind::CancelElement);
        if let Err(refusal) = admit(cx) {
            return cx.reject(request, refusal);
        }
        let created = cx.stamper.stamp(cx.now, "RCE");
        let message = ToVehicle::CancelElement(CancelElement { created });
        cx.send_request(request, &Dispatch::new("RCE", message, Purpose::Request(request)));
    }
}
