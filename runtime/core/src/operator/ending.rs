//! The ends of a mission: abort and kill (SPI 7.16, 7.17; safety requirement 012).
//!
//! Neither may be lost. If one is not acknowledged within a second, core sends it again, five times in all. While the
//! link is down, core keeps it for two minutes, and sends it on the next connection right after the subscriptions and
//! the request for the plan. After two minutes its reason is long past, so core drops it. This is the one exception to
//! the rule that nothing is sent twice after a reconnection: it does nothing to end a mission that has ended. A BFMIS
//! that shows the end of the mission settles it too.

use std::time::Duration;

use backseat_spi::{Abort, AbortReason, Kill, Text, ToVehicle};
use backseat_units::Timestamp;

use super::Orders;
use crate::capability::Capabilities;
use crate::context::Context;
use crate::ended::{EndCause, Ended, Failure};
use crate::io::Note;
use crate::ledger::RequestKind;
use crate::order::Order;
use crate::owner::Owner;
use crate::plugin::RequestState;
use crate::refusal::{Reason, Uncontrolled};
use crate::session::commands::{Answer, Command, FIRST_WITHIN, Purpose};
use crate::session::name;
use crate::vehicle::phase::Phase;

/// How many times one is sent on a connection while it is not acknowledged.
const SENT_MAX: u32 = 5;
/// How long one is kept until the link comes back.
const KEPT_FOR: Duration = Duration::from_secs(120);
/// How many characters of a text fit into a vehicle's log and a topside's line.
const TEXT_MAX: usize = 200;

/// An abort or kill that has not ended.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) struct Ending {
    request: u64,
    kind: RequestKind,
    text: Text,
    reason: AbortReason,
    /// How many times it was sent on this connection.
    sent: u32,
    /// A kill has been ordered after this abort. The abort is not sent again, because it would move a vehicle that
    /// should drift.
    superseded: bool,
    until: Timestamp,
}

impl Ending {
    pub(super) fn until(&self) -> Timestamp {
        self.until
    }

    fn is_kill(&self) -> bool {
        self.kind == RequestKind::Kill
    }
}

impl Orders {
    /// [`Order::Abort`] or [`Order::Kill`].
    pub(super) fn order_end(&mut self, cx: &mut Context, capabilities: &mut Capabilities, order: &Order) {
        let (kind, text, reason) = match order {
            Order::Abort { text, errors: true } => (RequestKind::Abort, text, AbortReason::Errors),
            Order::Abort { text, errors: false } => (RequestKind::Abort, text, AbortReason::Successful),
            Order::Kill { text } => (RequestKind::Kill, text, AbortReason::Errors),
            Order::Hold
            | Order::Release
            | Order::CancelAll
            | Order::CancelCurrent
            | Order::CancelElement
            | Order::StartEmptyMission { .. } => return,
        };
        let request = cx.ledger.propose_order(kind);
        if !cx.control.armed {
            return cx.reject(request, Uncontrolled::NotArmed.into());
        }
        if self.endings.iter().any(|ending| ending.kind == kind) {
            return cx.reject(request, Reason::EndingUnderWay.into());
        }
        if kind == RequestKind::Kill {
            for ending in &mut self.endings {
                ending.superseded = true;
            }
        }
        cx.control.mission_ended = true;
        // A character that may not be sent must not prevent an abort. In lower case, because some vehicles take a
        // sentence for another one if its text contains that one's name.
        let text: String = text.to_lowercase().chars().take(TEXT_MAX).collect();
        self.endings.push(Ending {
            request,
            kind,
            text: Text::cleaned(&text),
            reason,
            sent: 0,
            superseded: false,
            until: cx.now + KEPT_FOR,
        });
        if cx.link.is_up() {
            self.send_ending(cx, capabilities, request);
        } else {
            cx.note(Note::Text {
                text: format!(
                    "{kind:?} {request} waits for the link, for {} s at most",
                    KEPT_FOR.as_secs()
                ),
            });
        }
        self.set_timer(cx);
    }

    fn send_ending(&mut self, cx: &mut Context, capabilities: &mut Capabilities, request: u64) {
        let Some(ending) = self.endings.iter().find(|ending| ending.request == request) else {
            return;
        };
        let (text, reason, kill) = (ending.text.clone(), ending.reason, ending.is_kill());
        // No lease is active when it is sent.
        capabilities.end_leases(cx, EndCause::OperatorEndsMission);
        let letters = if kill { "KIL" } else { "ABT" };
        let created = cx.stamper.stamp(cx.now, letters);
        let message = if kill {
            ToVehicle::Kill(Kill { created, text })
        } else {
            ToVehicle::Abort(Abort { created, text, reason })
        };
        let command = Command {
            name: name(letters),
            created: Some(created),
            identifier: None,
            purpose: Purpose::Ending(request),
            deadline: cx.now + FIRST_WITHIN,
            pending: false,
        };
        if !cx.transmit_for(Owner::Operator, &message, Some(command)) {
            self.endings.retain(|ending| ending.request != request);
            return cx.reject(request, Uncontrolled::NotSent.into());
        }
        for ending in &mut self.endings {
            if ending.request == request {
                ending.sent += 1;
            }
        }
        cx.transition(request, RequestState::Sent);
    }

    /// Handles the vehicle's answer to an abort or kill.
    pub(crate) fn ending_answered(
        &mut self,
        cx: &mut Context,
        capabilities: &mut Capabilities,
        request: u64,
        answer: Answer<'_>,
    ) {
        match answer {
            Answer::Pending => cx.transition(request, RequestState::Pending),
            Answer::Done => {
                cx.transition(request, RequestState::Accepted);
                self.end_ending(cx, request, RequestState::Ended(EndCause::Done.into()));
            }
            Answer::Refused(text) => {
                self.end_ending(cx, request, RequestState::Failed(Failure::Vehicle(text.to_owned())))
            }
            Answer::Missing => {
                let ending = self.endings.iter().find(|ending| ending.request == request);
                let Some((kind, sent, superseded)) = ending.map(|ending| (ending.kind, ending.sent, ending.superseded))
                else {
                    return;
                };
                if superseded || sent >= SENT_MAX {
                    return self.end_ending(cx, request, RequestState::TimedOut);
                }
                cx.note(Note::Text {
                    text: format!(
                        "{kind:?} {request} was not acknowledged: sent again, {} of {SENT_MAX}",
                        sent + 1
                    ),
                });
                self.send_ending(cx, capabilities, request);
            }
        }
    }

    fn end_ending(&mut self, cx: &mut Context, request: u64, state: RequestState) {
        self.endings.retain(|ending| ending.request != request);
        cx.transition(request, state);
    }

    pub(super) fn endings_link_lost(&mut self, cx: &mut Context) {
        let sent: Vec<(u64, bool)> = self
            .endings
            .iter()
            .filter(|ending| ending.sent > 0)
            .map(|ending| (ending.request, ending.superseded))
            .collect();
        for (request, superseded) in sent {
            if superseded {
                self.end_ending(cx, request, RequestState::TimedOut);
            } else {
                cx.transition(request, RequestState::Unknown);
            }
        }
    }

    pub(super) fn endings_link_up(&mut self, cx: &mut Context, capabilities: &mut Capabilities) {
        for ending in &mut self.endings {
            ending.sent = 0;
        }
        // The timer at which core would have given them up may be late.
        self.endings_expired(cx);
        let kept: Vec<(u64, bool)> = self
            .endings
            .iter()
            .map(|ending| (ending.request, ending.superseded))
            .collect();
        for (request, superseded) in kept {
            if superseded {
                self.end_ending(cx, request, RequestState::Ended(EndCause::KillOrdered.into()));
            } else {
                self.send_ending(cx, capabilities, request);
            }
        }
    }

    /// Ends those that have waited too long for the link.
    pub(super) fn endings_expired(&mut self, cx: &mut Context) {
        let late: Vec<u64> = self
            .endings
            .iter()
            .filter(|ending| ending.until <= cx.now && (ending.sent == 0 || !cx.link.is_up()))
            .map(|ending| ending.request)
            .collect();
        for request in late {
            self.endings.retain(|ending| ending.request != request);
            let unknown = cx.ledger.get(request).map(|entry| entry.state.clone());
            if unknown == Some(RequestState::Unknown) {
                cx.transition(request, RequestState::TimedOut);
            } else {
                cx.reject(request, Uncontrolled::LinkDownTooLong.into());
            }
        }
    }

    /// A mission that is over settles abort and kill. One that is ending settles an abort only: the vehicle still
    /// moves, so a kill is not done.
    pub(super) fn endings_mission_status(&mut self, cx: &mut Context, status: &str, phase: Phase) {
        let done: Vec<u64> = self
            .endings
            .iter()
            .filter(|ending| match phase {
                Phase::Over => true,
                Phase::Ending => !ending.is_kill(),
                Phase::Running | Phase::Unknown => false,
            })
            .map(|ending| ending.request)
            .collect();
        for request in done {
            self.end_ending(
                cx,
                request,
                RequestState::Ended(Ended::Said(EndCause::MissionIs, status.trim().to_owned())),
            );
        }
    }
}
