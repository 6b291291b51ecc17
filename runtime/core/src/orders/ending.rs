//! The ends of a mission: abort and kill (SPI 7.16, 7.17; safety requirement 012).
//!
//! Neither must be lost. One that is not acknowledged within a second is sent again, five times in all. While the link is
//! down it is kept for two minutes, and sent as the first thing that can be acknowledged on the next connection: no later,
//! for what it was meant for is long over then. That is the one exception to sending nothing twice after a reconnect: to end
//! what has ended does nothing. A BFMIS that shows the mission's end settles it too.

use std::time::Duration;

use backseat_spi::{Abort, AbortReason, Kill, Text, ToVehicle};
use backseat_units::Timestamp;

use super::Order;
use crate::commands::{Answer, Command, FIRST_WITHIN, Purpose};
use crate::helm::refused;
use crate::io::Note;
use crate::ledger::RequestKind;
use crate::machine::Core;
use crate::owner::Owner;
use crate::phase::Phase;
use crate::plugin::RequestState;
use crate::session::name;

/// How often one is sent on a connection while it is not acknowledged.
const SENT_MAX: u32 = 5;
/// How long one waits for the link to come back.
const KEPT_FOR: Duration = Duration::from_secs(120);
/// What a vehicle's log and a topside's line hold of a text.
const TEXT_MAX: usize = 200;

/// An abort or kill that is not at its end.
#[derive(Clone, Debug)]
pub(crate) struct Ending {
    request: u64,
    kind: RequestKind,
    text: Text,
    reason: AbortReason,
    /// How often it was sent on this connection.
    sent: u32,
    /// A kill has been ordered after this abort: it is not sent again, or it would move a vehicle that was to drift.
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

impl Core {
    /// [`Order::Abort`] or [`Order::Kill`].
    pub(super) fn order_end(&mut self, order: &Order) {
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
        let request = self.propose_order(kind);
        if !self.cx.start.armed {
            return self.cx.reject(request, refused("control", "the runtime is not armed"));
        }
        if self.orders.endings.iter().any(|ending| ending.kind == kind) {
            return self.cx.reject(request, refused("state", "one is under way already"));
        }
        if kind == RequestKind::Kill {
            for ending in &mut self.orders.endings {
                ending.superseded = true;
            }
        }
        self.cx.mission_ended = true;
        // A character that may not be sent must not keep an abort from being sent. In lower case: there are vehicles that
        // take a sentence for the one whose name its text contains.
        let text: String = text.to_lowercase().chars().take(TEXT_MAX).collect();
        self.orders.endings.push(Ending {
            request,
            kind,
            text: Text::cleaned(&text),
            reason,
            sent: 0,
            superseded: false,
            until: self.cx.now + KEPT_FOR,
        });
        if self.cx.session.is_up() {
            self.send_ending(request);
        } else {
            self.cx.note(Note::Text {
                text: format!(
                    "{kind:?} {request} waits for the link, for {} s at most",
                    KEPT_FOR.as_secs()
                ),
            });
        }
        self.set_order_timer();
    }

    fn send_ending(&mut self, request: u64) {
        let Some(ending) = self.orders.endings.iter().find(|ending| ending.request == request) else {
            return;
        };
        let (text, reason, kill) = (ending.text.clone(), ending.reason, ending.is_kill());
        // Nothing that steers stands when it leaves.
        self.modify.end(&mut self.cx, "the operator ends the mission");
        self.station.end(&mut self.cx, "the operator ends the mission");
        let letters = if kill { "KIL" } else { "ABT" };
        let created = self.cx.stamper.stamp(self.cx.now, letters);
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
            deadline: self.cx.now + FIRST_WITHIN,
            pending: false,
        };
        if !self.cx.transmit_for(Owner::Operator, &message, Some(command)) {
            self.orders.endings.retain(|ending| ending.request != request);
            return self.cx.reject(request, refused("control", "it could not be sent"));
        }
        for ending in &mut self.orders.endings {
            if ending.request == request {
                ending.sent += 1;
            }
        }
        self.cx.transition(request, RequestState::Sent);
    }

    /// The vehicle's answer to an abort or kill.
    pub(crate) fn ending_answered(&mut self, request: u64, answer: Answer<'_>) {
        match answer {
            Answer::Pending => self.cx.transition(request, RequestState::Pending),
            Answer::Done => {
                self.cx.transition(request, RequestState::Accepted);
                self.end_ending(request, RequestState::Ended("done".to_owned()));
            }
            Answer::Refused(text) => self.end_ending(request, RequestState::Failed(text.to_owned())),
            Answer::Missing => {
                let ending = self.orders.endings.iter().find(|ending| ending.request == request);
                let Some((kind, sent, superseded)) = ending.map(|ending| (ending.kind, ending.sent, ending.superseded))
                else {
                    return;
                };
                if superseded || sent >= SENT_MAX {
                    return self.end_ending(request, RequestState::TimedOut);
                }
                self.cx.note(Note::Text {
                    text: format!(
                        "{kind:?} {request} was not acknowledged: sent again, {} of {SENT_MAX}",
                        sent + 1
                    ),
                });
                self.send_ending(request);
            }
        }
    }

    fn end_ending(&mut self, request: u64, state: RequestState) {
        self.orders.endings.retain(|ending| ending.request != request);
        self.cx.transition(request, state);
    }

    pub(super) fn endings_link_lost(&mut self) {
        let sent: Vec<(u64, bool)> = self
            .orders
            .endings
            .iter()
            .filter(|ending| ending.sent > 0)
            .map(|ending| (ending.request, ending.superseded))
            .collect();
        for (request, superseded) in sent {
            if superseded {
                self.end_ending(request, RequestState::TimedOut);
            } else {
                self.cx.transition(request, RequestState::Unknown);
            }
        }
    }

    pub(super) fn endings_link_up(&mut self) {
        for ending in &mut self.orders.endings {
            ending.sent = 0;
        }
        // The wake-up that would have given them up may be late.
        self.endings_expired();
        let kept: Vec<(u64, bool)> = self
            .orders
            .endings
            .iter()
            .map(|ending| (ending.request, ending.superseded))
            .collect();
        for (request, superseded) in kept {
            if superseded {
                let text = "a kill took its place before it could be sent".to_owned();
                self.end_ending(request, RequestState::Ended(text));
            } else {
                self.send_ending(request);
            }
        }
    }

    /// Those that have waited for the link for too long.
    pub(super) fn endings_expired(&mut self) {
        let late: Vec<u64> = self
            .orders
            .endings
            .iter()
            .filter(|ending| ending.until <= self.cx.now && (ending.sent == 0 || !self.cx.session.is_up()))
            .map(|ending| ending.request)
            .collect();
        for request in late {
            self.orders.endings.retain(|ending| ending.request != request);
            let unknown = self.cx.ledger.get(request).map(|entry| entry.state.clone());
            if unknown == Some(RequestState::Unknown) {
                self.cx.transition(request, RequestState::TimedOut);
            } else {
                let text = format!("the link was down for {} s: order it again", KEPT_FOR.as_secs());
                self.cx.reject(request, refused("control", &text));
            }
        }
    }

    /// A mission that ends has been ended; one that wraps up moves yet, and a kill is not done with.
    pub(super) fn endings_mission_status(&mut self, status: &str, phase: Phase) {
        let done: Vec<u64> = self
            .orders
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
                request,
                RequestState::Ended(format!("the mission is {}", status.trim())),
            );
        }
    }
}
