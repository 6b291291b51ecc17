//! Commands that have been sent and wait for their acknowledgement (SPI 4.4, 6.21).

use std::time::Duration;

use backseat_spi::{Acknowledgement, BehaviorId, CommandName};
use backseat_units::{TimeOfDay, Timestamp};

/// The first acknowledgement comes within this: they are sent immediately (4.4).
pub(crate) const FIRST_WITHIN: Duration = Duration::from_secs(1);
/// A pending command is settled within 2 s (4.4), and the link's delay.
pub(crate) const SETTLED_WITHIN: Duration = Duration::from_secs(4);
/// A whole plan takes longer on its way (7.19).
pub(crate) const PLAN_WITHIN: Duration = Duration::from_secs(10);

/// What a command was sent for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Purpose {
    /// A subscription of the session, by its place in the list.
    Subscription(usize),
    /// The plan.
    Plan,
    /// A refresh of the lease of this request.
    Lease(u64),
    /// An insert, by its request.
    Insert(u64),
    /// The cancelling of an insert: the cancel's own request if a plugin asked, and the insert's.
    Cancel { cancel: Option<u64>, insert: u64 },
    /// A request that ends with the answer to its one command.
    Request(u64),
    /// Silent mode, by its request.
    Silent(u64),
    /// A trim or buoyancy adjustment, by its request.
    Adjustment(u64),
    /// An acoustic packet, by its request.
    Packet(u64),
    /// The DVL's triggering, by its request.
    DvlTrigger(u64),
    /// A command of a hold, by its request.
    Hold(u64),
    /// Nothing hangs on it.
    Courtesy,
}

/// The vehicle's answer to a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Answer<'a> {
    /// It is working on it (acknowledgement status 3); the first time that it says so.
    Pending,
    /// It has done it.
    Done,
    /// It has refused it or failed at it; its text.
    Refused(&'a str),
    /// None came in time.
    Missing,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Command {
    pub(crate) name: CommandName,
    pub(crate) created: Option<TimeOfDay>,
    pub(crate) identifier: Option<BehaviorId>,
    pub(crate) purpose: Purpose,
    pub(crate) deadline: Timestamp,
    pub(crate) pending: bool,
}

/// The commands under way, oldest first.
#[derive(Debug, Default)]
pub(crate) struct Commands {
    sent: Vec<Command>,
}

/// More than this many at once and the oldest is given up: no peer makes us remember without bound.
const COMMANDS_MAX: usize = 256;

impl Commands {
    pub(crate) fn push(&mut self, command: Command) -> Option<Command> {
        let given_up = (self.sent.len() >= COMMANDS_MAX).then(|| self.sent.remove(0));
        self.sent.push(command);
        given_up
    }

    /// The command that an acknowledgement answers: by name, echoed time and identifier; one that names no command
    /// (`NAK`) answers the oldest. A final answer takes it; a pending one leaves it waiting.
    pub(crate) fn answer(&mut self, ack: &Acknowledgement, pending: bool, now: Timestamp) -> Option<Command> {
        let index = if ack.command.as_str() == "NAK" {
            self.sent.iter().position(|command| !command.pending)?
        } else {
            self.sent
                .iter()
                .position(|command| {
                    command.name == ack.command
                        && command.created.unwrap_or(TimeOfDay::MIDNIGHT) == ack.command_created.truncated_to_millis()
                        && (ack.behavior.is_none()
                            || command.identifier.is_none()
                            || ack.behavior == command.identifier)
                })
                .or_else(|| {
                    // A command that could not be read is refused with no echo of its time: the oldest of its name.
                    (ack.command_created == TimeOfDay::MIDNIGHT)
                        .then(|| self.sent.iter().position(|command| command.name == ack.command))
                        .flatten()
                })?
        };
        if pending {
            let command = &mut self.sent[index];
            if command.pending {
                // Said again, it gives the vehicle no more time.
                return None;
            }
            command.pending = true;
            command.deadline = match command.purpose {
                Purpose::Plan => now + PLAN_WITHIN,
                Purpose::Subscription(_)
                | Purpose::Lease(_)
                | Purpose::Insert(_)
                | Purpose::Cancel { .. }
                | Purpose::Request(_)
                | Purpose::Silent(_)
                | Purpose::Adjustment(_)
                | Purpose::Packet(_)
                | Purpose::DvlTrigger(_)
                | Purpose::Hold(_)
                | Purpose::Courtesy => now + SETTLED_WITHIN,
            };
            Some(*command)
        } else {
            Some(self.sent.remove(index))
        }
    }

    /// Takes a command whose answer is late.
    pub(crate) fn late(&mut self, now: Timestamp) -> Option<Command> {
        let index = self.sent.iter().position(|command| command.deadline <= now)?;
        Some(self.sent.remove(index))
    }

    pub(crate) fn next_deadline(&self) -> Option<Timestamp> {
        self.sent.iter().map(|command| command.deadline).min()
    }

    /// The lease is over: nothing hangs on its refreshes any more.
    pub(crate) fn forget_lease(&mut self) {
        for command in &mut self.sent {
            if matches!(command.purpose, Purpose::Lease(_)) {
                command.purpose = Purpose::Courtesy;
            }
        }
    }

    /// The plan is asked for anew: an earlier series is not it.
    pub(crate) fn forget_plan(&mut self) {
        for command in &mut self.sent {
            if command.purpose == Purpose::Plan {
                command.purpose = Purpose::Courtesy;
            }
        }
    }

    /// The link is gone: no answer comes.
    pub(crate) fn clear(&mut self) {
        self.sent.clear();
    }
}
