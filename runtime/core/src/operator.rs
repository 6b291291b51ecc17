//! What only the operator may order, directly or by a policy of the mission file: cancels beyond a plugin's own
//! inserts, abort and kill, an empty mission (SPI 7.9, 7.10, 7.11, 7.16, 7.17, 7.20; safety requirement 012).
//!
//! Every order is a request of the operator in the ledger. The submodules carry orders out: the ends of a mission
//! (`ending`), the cancels (`cancels`), the empty mission (`empty`), and the policies (`policies`).

use backseat_units::Timestamp;

use crate::capability::Capabilities;
use crate::context::Context;
use crate::io::{Note, Operator, Output};
use crate::ledger::RequestKind;
use crate::mutations::{Check, is_on};
use crate::order::Order;
use crate::plugin::Refusal;
use crate::refusal::{Reason, Uncontrolled};
use crate::timer::Timer;
use crate::vehicle::phase::Phase;

mod cancels;
mod empty;
mod ending;
mod policies;

use empty::EmptyMission;
pub(crate) use ending::Ending;
use policies::Stale;

/// The state of the operator's orders.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Orders {
    /// Aborts and kills that have not ended; at most one of each.
    endings: Vec<Ending>,
    /// The empty mission that is being started.
    empty: Option<EmptyMission>,
    /// There has been a connection.
    connected: bool,
    /// Since when navigation has been stale, and up to which time policies have acted on that.
    stale: Option<Stale>,
}

impl Orders {
    /// Does what an act of the operator demands.
    pub(crate) fn act(&mut self, cx: &mut Context, capabilities: &mut Capabilities, act: Operator) {
        if act != Operator::Hold {
            cx.note(Note::Operator { act: act.clone() });
        }
        match act {
            // A hold overrides every plugin (safety requirement 015).
            Operator::Hold => {
                cx.control.held = is_on(Check::OperatorHold);
                cx.control.held_at = Some(cx.now);
                cx.vehicle.previous_run.held();
                capabilities.end_controlled(cx, Uncontrolled::OperatorHolds);
                if is_on(Check::HoldCancels) {
                    capabilities.inserts.take_back_all(cx, None);
                    capabilities.inserts.cancel_previous_run(cx);
                }
                // The note comes last: the driver keeps the hold on a disk, and the requests that it ends must not wait
                // for that.
                cx.note(Note::Operator { act: Operator::Hold });
            }
            Operator::Release => {
                cx.control.held = false;
                cx.control.mission_ended = false;
            }
            Operator::Stop => {
                capabilities.end_controlled(cx, Uncontrolled::RunEnding);
                cx.control.stopping = true;
                cx.outbox.push(Output::Finish);
            }
            Operator::Order(order) => self.order(cx, capabilities, &order),
        }
    }

    /// Carries out an order that the operator gave in advance: a policy's, or a plugin's `on_failure`. If the mission
    /// is ending or over, an abort is rejected: it could disturb the vehicle's wrap-up, and nobody is there to want it
    /// anyway.
    pub(crate) fn order_in_advance(&mut self, cx: &mut Context, capabilities: &mut Capabilities, order: &Order) {
        let reason = match cx.vehicle.phase {
            Phase::Ending => Reason::MissionEnding,
            Phase::Over => Reason::NoMission,
            Phase::Unknown | Phase::Running => return self.order(cx, capabilities, order),
        };
        if let Order::Abort { .. } = order {
            let request = cx.ledger.propose_order(RequestKind::Abort);
            cx.reject(request, reason.into());
        } else {
            self.order(cx, capabilities, order);
        }
    }

    /// Carries out an order of the operator.
    pub(crate) fn order(&mut self, cx: &mut Context, capabilities: &mut Capabilities, order: &Order) {
        match order {
            Order::Hold => self.act(cx, capabilities, Operator::Hold),
            Order::Release => self.act(cx, capabilities, Operator::Release),
            Order::CancelAll => self.order_cancel_all(cx),
            Order::CancelCurrent => self.order_cancel_current(cx),
            Order::CancelElement => self.order_cancel_element(cx),
            Order::Abort { .. } | Order::Kill { .. } => self.order_end(cx, capabilities, order),
            Order::StartEmptyMission { duration_s } => self.order_empty_mission(cx, capabilities, *duration_s),
        }
    }

    /// The link is gone. An abort or kill is kept and sent again later, and a mission that is being started may still
    /// report that it runs. Cancels are not kept, because they might cancel something else by then.
    pub(crate) fn link_lost(&mut self, cx: &mut Context) {
        cx.vehicle.named_insert.invalidate_after_loss();
        cx.vehicle.phase = Phase::Unknown;
        self.endings_link_lost(cx);
        self.empty_mission_link_lost(cx);
        self.set_timer(cx);
    }

    /// The link is up: sends what was kept.
    pub(crate) fn link_up(&mut self, cx: &mut Context, capabilities: &mut Capabilities) {
        self.connected = true;
        self.endings_link_up(cx, capabilities);
        self.set_timer(cx);
    }

    /// A mission status (BFMIS).
    pub(crate) fn heard_mission_status(&mut self, cx: &mut Context, status: &str) {
        let phase = Phase::of(status);
        cx.vehicle.phase = phase;
        match phase {
            Phase::Running => self.empty_mission_runs(cx),
            Phase::Ending | Phase::Over => {
                cx.vehicle.named_insert.forget();
                cx.control.mission_ended = false;
            }
            Phase::Unknown => {}
        }
        self.endings_mission_status(cx, status, phase);
        self.set_timer(cx);
    }

    /// An order has waited too long.
    pub(crate) fn timed_out(&mut self, cx: &mut Context) {
        self.endings_expired(cx);
        self.empty_mission_expired(cx);
        self.set_timer(cx);
    }

    fn set_timer(&mut self, cx: &mut Context) {
        let waiting = (!cx.link.is_up()).then(|| self.endings.iter().map(Ending::until).min());
        let empty = self.empty.and_then(EmptyMission::deadline);
        let first: Option<Timestamp> = waiting.flatten().into_iter().chain(empty).min();
        cx.timers.set_or_stop(Timer::Order, first);
    }
}

/// What an order needs that changes the running mission: an armed runtime with control.
fn admit(cx: &Context) -> Result<(), Refusal> {
    if !cx.control.armed {
        return Err(Uncontrolled::NotArmed.into());
    }
    match cx.lost_because() {
        Some(reason) => Err(reason.into()),
        None => Ok(()),
    }
}
