//! The command under way. Commands are said one at a time, because acknowledgements carry no ticket.

use std::collections::BTreeMap;
use std::time::Duration;

use backseat_s7k::SensorIndex;
use backseat_s7k::record::{Acknowledge, CommandStatus};
use backseat_units::Timestamp;

use crate::job::{End, Job, Origin, Step};
use crate::logging::FileDetails;

/// How long acknowledgements of repeated commands are waited for.
const OWED: Duration = Duration::from_secs(10);

/// A command that was sent, and what has come back.
#[derive(Debug)]
pub(crate) struct Exchange {
    pub(crate) job: Job,
    pub(crate) step: Step,
    sends: u32,
    sent_at: Timestamp,
    acknowledged: bool,
    answered: bool,
    /// Acknowledgements of this command that came, also those that it did not need.
    acknowledgements: u32,
}

/// The command under way, if any, and the acknowledgements that may still come for earlier ones.
///
/// An acknowledgement answers the oldest command of its kind to its target (Volume III, 2.6 names no order and no
/// ticket). A command that was sent twice may be acknowledged twice, and the second acknowledgement must not count for
/// another command of the same kind. So each surplus sending is owed one acknowledgement for ten seconds. If it never
/// comes, the next command of the kind takes one sending more.
#[derive(Debug, Default)]
pub(crate) struct Exchanges {
    current: Option<Exchange>,
    owed: BTreeMap<(u32, i32), (u32, Timestamp)>,
}

/// What an acknowledgement or a status did.
#[derive(Debug, PartialEq)]
pub(crate) enum Heard {
    /// It answers nothing that waits.
    Nothing,
    /// It belongs to the command under way, which waits for more.
    Part,
    /// The command under way has ended.
    Ended(End),
}

/// What to do when an answer is late.
#[derive(Debug, PartialEq)]
pub(crate) enum Late {
    /// Send the command again.
    Again,
    /// Give it up.
    Ended(End),
}

impl Exchanges {
    pub(crate) const fn is_idle(&self) -> bool {
        self.current.is_none()
    }

    pub(crate) const fn current(&self) -> Option<&Exchange> {
        self.current.as_ref()
    }

    /// When the answer is late.
    pub(crate) fn deadline(&self) -> Option<Timestamp> {
        let current = self.current.as_ref()?;
        Some(current.sent_at + current.step.timeout)
    }

    /// The command has just been sent for the first time.
    pub(crate) fn begin(&mut self, now: Timestamp, job: Job, step: Step) {
        self.owed.retain(|_, (_, until)| *until > now);
        self.current = Some(Exchange {
            job,
            step,
            sends: 1,
            sent_at: now,
            acknowledged: false,
            answered: false,
            acknowledgements: 0,
        });
    }

    /// The command has just been sent again.
    pub(crate) fn sent_again(&mut self, now: Timestamp) {
        if let Some(current) = &mut self.current {
            current.sends += 1;
            current.sent_at = now;
        }
    }

    /// Ends the command under way.
    pub(crate) fn take(&mut self, now: Timestamp) -> Option<(Job, Step)> {
        let current = self.current.take()?;
        let surplus = current.sends.saturating_sub(current.acknowledgements);
        if surplus > 0 {
            let owed = self.owed.entry(current.step.key()).or_insert((0, now + OWED));
            owed.0 = owed.0.saturating_add(surplus);
        }
        Some((current.job, current.step))
    }

    /// A new connection: nothing is owed.
    pub(crate) fn forget(&mut self) {
        self.owed.clear();
    }

    /// When the command under way was sent, if it was sent once: the time from which a round trip counts.
    pub(crate) fn round_trip_of(&self, acknowledge: &Acknowledge) -> Option<Timestamp> {
        let current = self
            .current
            .as_ref()
            .filter(|current| current.is_answered_by(acknowledge))?;
        let once = current.sends == 1 && current.acknowledgements == 0;
        let owes = self.owed.contains_key(&current.step.key());
        (once && !owes).then_some(current.sent_at)
    }

    /// Takes an acknowledgement.
    pub(crate) fn acknowledge(&mut self, acknowledge: &Acknowledge) -> Heard {
        let Some(current) = &mut self.current else {
            return Heard::Nothing;
        };
        if !current.is_answered_by(acknowledge) {
            return Heard::Nothing;
        }
        // What a command solicits proves more than its acknowledgement, so nothing can be mistaken there. A new connection
        // is said many commands of one kind, and there the time counts more than to know which one was rejected.
        if current.step.expects.is_none()
            && current.job.origin != Origin::Setup
            && let Some((owed, _)) = self.owed.get_mut(&current.step.key())
        {
            *owed -= 1;
            if *owed == 0 {
                self.owed.remove(&current.step.key());
            }
            return Heard::Nothing;
        }
        current.acknowledgements += 1;
        match acknowledge.status {
            CommandStatus::Rejected => Heard::Ended(End::Rejected),
            CommandStatus::Unknown => Heard::Ended(End::Unknown),
            CommandStatus::Accepted => {
                current.acknowledged = true;
                if current.is_complete() {
                    Heard::Ended(End::Accepted)
                } else {
                    Heard::Part
                }
            }
            CommandStatus::Other(_) => Heard::Nothing,
        }
    }

    /// Takes a status. In quiet mode no acknowledgement comes beside it.
    pub(crate) fn status(&mut self, id: i32, verbose: bool) -> Heard {
        let Some(current) = self.current.as_mut().filter(|current| current.step.expects == Some(id)) else {
            return Heard::Nothing;
        };
        current.answered = true;
        if current.is_complete() || !verbose {
            Heard::Ended(End::Accepted)
        } else {
            Heard::Part
        }
    }

    /// The state of logging has come. The job that asks for it keeps it for its outcome.
    pub(crate) fn note_details(&mut self, id: i32, details: &FileDetails) {
        if let Some(current) = self.current.as_mut().filter(|current| current.step.expects == Some(id)) {
            current.job.details = Some(details.clone());
        }
    }

    /// The answer is late.
    pub(crate) fn late(&mut self) -> Option<Late> {
        let current = self.current.as_ref()?;
        Some(if current.answered {
            // The acknowledgement is lost, and the answer proves that the command arrived.
            Late::Ended(End::Accepted)
        } else if current.sends < current.step.sends {
            Late::Again
        } else if current.acknowledged {
            Late::Ended(End::NoAnswer)
        } else {
            Late::Ended(End::Silent)
        })
    }
}

impl Exchange {
    fn is_answered_by(&self, acknowledge: &Acknowledge) -> bool {
        acknowledge.command == self.step.command()
            && (acknowledge.sensor == self.step.target || Some(acknowledge.sensor) == self.step.subject)
    }

    const fn is_complete(&self) -> bool {
        self.acknowledged && (self.answered || self.step.expects.is_none())
    }

    /// Whether the controller has acknowledged the command, or done what it asks for.
    pub(crate) const fn is_heard(&self) -> bool {
        self.acknowledged || self.answered
    }
}

impl Step {
    fn key(&self) -> (u32, i32) {
        let SensorIndex(sensor) = self.target;
        (self.command().code(), sensor)
    }
}
