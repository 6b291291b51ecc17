//! Sending to the vehicle.

use backseat_spi::{BehaviorId, CancelBehavior, ToVehicle};
use backseat_units::TimeOfDay;

use super::Context;
use crate::io::{Note, Output};
use crate::monitor::limits::Grant;
use crate::owner::Owner;
use crate::plugin::RequestState;
use crate::refusal::Uncontrolled;
use crate::session::commands::{Command, FIRST_WITHIN, Purpose};
use crate::session::dispatch::Dispatch;
use crate::session::name;

impl Context {
    /// Sends a message on the runtime's own account.
    pub(crate) fn transmit(&mut self, message: &ToVehicle, command: Option<Command>) -> bool {
        self.pass(None, message, command)
    }

    /// Sends a message for the owner of a request.
    pub(crate) fn transmit_for(&mut self, owner: Owner, message: &ToVehicle, command: Option<Command>) -> bool {
        self.pass(Some(owner), message, command)
    }

    /// Sends a request's command. If it cannot be sent, rejects the request and returns false.
    pub(crate) fn send(&mut self, request: u64, dispatch: &Dispatch) -> bool {
        let owner = self.ledger.get(request).map(|entry| entry.owner);
        let command = dispatch.command(self.now);
        let sent = owner.is_some_and(|owner| self.pass(Some(owner), dispatch.message(), Some(command)));
        if !sent {
            self.reject(request, Uncontrolled::NotSent.into());
        }
        sent
    }

    /// As [`Context::send`], for a request of which core keeps nothing but the state.
    pub(crate) fn send_request(&mut self, request: u64, dispatch: &Dispatch) -> bool {
        let sent = self.send(request, dispatch);
        if sent {
            self.transition(request, RequestState::Sent);
        }
        sent
    }

    /// A command on whose answer nothing depends; a refusal is logged.
    pub(crate) fn courtesy(&self, command: &'static str, created: Option<TimeOfDay>) -> Command {
        Command {
            name: name(command),
            created,
            identifier: None,
            purpose: Purpose::Courtesy,
            deadline: self.now + 2 * FIRST_WITHIN,
            pending: false,
        }
    }

    /// Sends a cancel of an insert, for the request `cancel` or on the runtime's own account. Returns false if it could
    /// not be sent.
    pub(crate) fn send_cancel(&mut self, cancel: Option<u64>, insert: u64, identifier: BehaviorId) -> bool {
        let created = self.stamper.stamp(self.now, "RCN");
        let command = Command {
            name: name("RCN"),
            created: Some(created),
            identifier: Some(identifier),
            purpose: Purpose::Cancel { cancel, insert },
            deadline: self.now + 2 * FIRST_WITHIN,
            pending: false,
        };
        self.transmit(
            &ToVehicle::CancelBehavior(CancelBehavior { created, identifier }),
            Some(command),
        )
    }

    /// Asks the driver to reserve more if few identifiers are left, or if the reservation allows for fewer further
    /// inserts than may be open at once.
    pub(crate) fn reserve(&mut self) {
        let ahead = self.monitor.limits().inserts_open_max.max(1);
        let may = |grant| if self.plugins.any_has(grant) { ahead } else { 0 };
        let ahead = [may(Grant::Insert), may(Grant::Surface)];
        if let Some(reservation) = self.identifiers.reserve(self.now, ahead) {
            self.outbox.push(Output::Reserve(reservation));
        }
    }

    /// Asks the gate, encodes a message, and notes which answer to expect. Nothing is sent to the vehicle from anywhere
    /// else.
    pub(crate) fn pass(&mut self, owner: Option<Owner>, message: &ToVehicle, command: Option<Command>) -> bool {
        if !self.gate(message).lets_through(owner, message) {
            return false;
        }
        let mut bytes = Vec::with_capacity(96);
        if let Err(error) = message.encode(&mut bytes) {
            self.note(Note::Text {
                text: format!("{} was not sent: {error}", message.name()),
            });
            return false;
        }
        if let Some(command) = command {
            if !self.link.commands.push(command) {
                self.note(Note::Text {
                    text: format!("{} was not sent: too many commands wait for an answer", message.name()),
                });
                return false;
            }
            if let Purpose::Cancel { insert, .. } = command.purpose {
                self.ledger.cancel_sent(self.now, Some(insert));
            } else if matches!(command.purpose, Purpose::CancelAll(_)) {
                self.ledger.cancel_sent(self.now, None);
            }
            let early = command.purpose == Purpose::Early;
            self.link.heartbeat.left(self.now, command.name, command.created, early);
        }
        self.outbox.push(Output::Send(bytes));
        true
    }
}
