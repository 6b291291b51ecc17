use backseat_spi::{BehaviorId, ToVehicle};
use backseat_units::Timestamp;

use crate::session::commands::{Command, FIRST_WITHIN, Purpose};
use crate::session::name;

/// A command of a request that has passed every check.
#[derive(Debug)]
pub(crate) struct Dispatch {
    letters: &'static str,
    message: ToVehicle,
    purpose: Purpose,
    identifier: Option<BehaviorId>,
}

impl Dispatch {
    pub(crate) const fn new(letters: &'static str, message: ToVehicle, purpose: Purpose) -> Self {
        Self {
            letters,
            message,
            purpose,
            identifier: None,
        }
    }

    /// Adds the identifier of the insert that the command names.
    pub(crate) const fn naming(mut self, identifier: BehaviorId) -> Self {
        self.identifier = Some(identifier);
        self
    }

    pub(crate) const fn message(&self) -> &ToVehicle {
        &self.message
    }

    pub(crate) const fn identifier(&self) -> Option<BehaviorId> {
        self.identifier
    }

    /// The record by which its answer is recognised.
    pub(crate) fn command(&self, now: Timestamp) -> Command {
        Command {
            name: name(self.letters),
            created: self.message.created(),
            identifier: self.identifier,
            purpose: self.purpose,
            deadline: now + 2 * FIRST_WITHIN,
            pending: false,
        }
    }
}
