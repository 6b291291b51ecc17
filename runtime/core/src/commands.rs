//! Commands that have been sent and wait for their acknowledgement (SPI 4.4, 6.21).

use std::time::Duration;

use backseat_spi::{AckStatus, Acknowledgement, BehaviorId, CommandName};
use backseat_units::{TimeOfDay, Timestamp};

/// The first acknowledgement comes within this: they are sent immediately (4.4).
pub(crate) const FIRST_WITHIN: Duration = Duration::from_secs(1);
/// A pending command is settled within 2 s (4.4), and the link's delay.
pub(crate) const SETTLED_WITHIN: Duration = Duration::from_secs(4);
/// Silent mode is settled within 2 s, and 2 s more where the tailcone still turns (7.22), and the link's delay.
pub(crate) const SILENT_WITHIN: Duration = Duration::from_secs(6);
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
    /// A message to the topside, by its request.
    Topside(u64),
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
    /// The operator's cancel of all inserts, by its request.
    CancelAll(u64),
    /// The operator's abort or kill, by its request.
    Ending(u64),
    /// The start of an empty mission, by its request.
    EmptyMission(u64),
    /// The vehicle's own speed limit after a hold, by the hold's request.
    SpeedRestored(u64),
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

/// More than this many at once are not remembered: no peer makes us remember without bound.
const COMMANDS_MAX: usize = 256;

impl Commands {
    /// Remembers a command that is to be sent. False where there is no room for its answer, so that it must not be sent:
    /// what hangs on it would never end. One on which nothing hangs makes room and needs none; the end of a mission, of
    /// which there are two at most, always finds it.
    pub(crate) fn push(&mut self, command: Command) -> bool {
        if self.sent.len() >= COMMANDS_MAX {
            let idle = self.sent.iter().position(|sent| sent.purpose == Purpose::Courtesy);
            match (idle, command.purpose) {
                (Some(idle), _) => {
                    self.sent.remove(idle);
                }
                (None, Purpose::Courtesy) => return true,
                (None, Purpose::Ending(_)) => {}
                (
                    None,
                    Purpose::Subscription(_)
                    | Purpose::Plan
                    | Purpose::Lease(_)
                    | Purpose::Insert(_)
                    | Purpose::Cancel { .. }
                    | Purpose::Request(_)
                    | Purpose::Topside(_)
                    | Purpose::Silent(_)
                    | Purpose::Adjustment(_)
                    | Purpose::Packet(_)
                    | Purpose::DvlTrigger(_)
                    | Purpose::Hold(_)
                    | Purpose::SpeedRestored(_)
                    | Purpose::CancelAll(_)
                    | Purpose::EmptyMission(_),
                ) => return false,
            }
        }
        self.sent.push(command);
        true
    }

    /// The command that an acknowledgement answers: by name, echoed time and identifier; one that names no command
    /// (`NAK`) answers the oldest. With it, whether it is settled: a final answer takes it, another leaves it waiting.
    pub(crate) fn answer(&mut self, ack: &Acknowledgement, now: Timestamp) -> Option<(Command, bool)> {
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
        let command = &mut self.sent[index];
        let settled = match ack.status {
            AckStatus::Pending => false,
            // The first of two acknowledgements of silent mode tells of the receipt, and need not say pending (7.22).
            AckStatus::Succeeded => command.pending || !matches!(command.purpose, Purpose::Silent(_)),
            AckStatus::Invalid | AckStatus::Failed | AckStatus::Other(_) => true,
        };
        if settled {
            Some((self.sent.remove(index), true))
        } else {
            if command.pending {
                // Said again, it gives the vehicle no more time.
                return None;
            }
            command.pending = true;
            command.deadline = match command.purpose {
                Purpose::Plan => now + PLAN_WITHIN,
                Purpose::Silent(_) => now + SILENT_WITHIN,
                Purpose::Subscription(_)
                | Purpose::Lease(_)
                | Purpose::Insert(_)
                | Purpose::Cancel { .. }
                | Purpose::Request(_)
                | Purpose::Topside(_)
                | Purpose::Adjustment(_)
                | Purpose::Packet(_)
                | Purpose::DvlTrigger(_)
                | Purpose::Hold(_)
                | Purpose::CancelAll(_)
                | Purpose::Ending(_)
                | Purpose::EmptyMission(_)
                | Purpose::SpeedRestored(_)
                | Purpose::Courtesy => now + SETTLED_WITHIN,
            };
            Some((*command, false))
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

    /// The hold is over: nothing hangs on its commands any more.
    pub(crate) fn forget_hold(&mut self) {
        for command in &mut self.sent {
            if matches!(command.purpose, Purpose::Hold(_)) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::name;

    fn command(purpose: Purpose) -> Command {
        Command {
            name: name("RTK"),
            created: None,
            identifier: None,
            purpose,
            deadline: Timestamp::ZERO,
            pending: false,
        }
    }

    #[test]
    fn what_hangs_on_a_command_is_never_forgotten_for_want_of_room() {
        let mut commands = Commands::default();
        assert!(commands.push(command(Purpose::Courtesy)));
        for request in 0..COMMANDS_MAX as u64 {
            assert!(commands.push(command(Purpose::Insert(request))), "{request}");
        }
        assert!(!commands.push(command(Purpose::Insert(999))), "it is not sent then");
        assert!(
            commands.push(command(Purpose::Courtesy)),
            "it is sent, and its answer is nobody's"
        );
        assert!(commands.push(command(Purpose::Ending(1000))));
        let mut late = Vec::new();
        while let Some(command) = commands.late(Timestamp::ZERO) {
            late.push(command.purpose);
        }
        let mut expected: Vec<Purpose> = (0..COMMANDS_MAX as u64).map(Purpose::Insert).collect();
        expected.push(Purpose::Ending(1000));
        assert_eq!(late, expected);
    }
}
