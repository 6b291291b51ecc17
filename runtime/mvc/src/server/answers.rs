use core::time::Duration;
use std::collections::VecDeque;

use backseat_spi::{AckStatus, Acknowledgement, BehaviorId, CommandName, ToVehicle};
use backseat_units::{TimeOfDay, Timestamp};

use crate::event::ClientId;
use crate::faults::{AckFilter, AckStage, FaultKind, NegativeStatus};
use crate::interpretation::Interpretation;

/// The longest text of an answer, characters. It quotes what a client sent, but may not repeat all of it.
const TEXT_MAX: usize = 160;

/// Commands whose own section mentions their acknowledgement (SPI 7.1, 7.3, 7.5, 7.6, 7.8, 7.19, 7.22 to 7.24).
const OF_THEIR_SECTIONS: [&str; 9] = ["LOG", "TOP", "RTK", "RTC", "RCN", "RMP", "SIL", "TRM", "BOY"];

/// How many acknowledgements may be late at once. More are lost.
const LATE_MAX: usize = 4096;

/// The command that an acknowledgement answers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Regarding {
    pub(crate) client: ClientId,
    pub(crate) command: CommandName,
    pub(crate) created: TimeOfDay,
    pub(crate) behavior: Option<BehaviorId>,
    /// The connection that sent the command is gone. Nobody gets the answer, not even a new connection with the same
    /// number.
    pub(crate) muted: bool,
}

impl Regarding {
    /// For a command of a client.
    pub(crate) fn command(client: ClientId, command: &ToVehicle) -> Self {
        Self {
            client,
            command: CommandName::new(command.name()).unwrap_or(CommandName::NAK),
            created: command.created().unwrap_or(TimeOfDay::MIDNIGHT),
            behavior: None,
            muted: false,
        }
    }

    /// The same, for a behavior.
    pub(crate) const fn of(self, behavior: BehaviorId) -> Self {
        Self {
            behavior: Some(behavior),
            ..self
        }
    }
}

/// Which commands are acknowledged, and what goes wrong with acknowledgements.
#[derive(Debug)]
pub(super) struct Answers {
    acknowledges_sections: bool,
    pub(super) echo_decimals: u8,
    /// The faults of acknowledgements that act now, by their place in the fault plan.
    faults: Vec<(usize, FaultKind)>,
    late: VecDeque<Late>,
}

#[derive(Clone, Debug)]
struct Late {
    due: Timestamp,
    client: ClientId,
    message: Acknowledgement,
}

/// What the faults do to an acknowledgement.
pub(super) enum Verdict {
    /// It is sent at once, with this status.
    Says(AckStatus),
    Late(AckStatus, Duration),
    Lost,
}

impl Answers {
    pub(super) const fn new(interpretation: &Interpretation) -> Self {
        Self {
            acknowledges_sections: interpretation.acknowledges_sections,
            echo_decimals: interpretation.echo_decimals,
            faults: Vec::new(),
            late: VecDeque::new(),
        }
    }

    /// Whether the vehicle acknowledges this command and this outcome at all.
    pub(super) fn speaks_of(&self, command: CommandName, status: AckStatus) -> bool {
        let spoken_of = OF_THEIR_SECTIONS.contains(&command.as_str()) || status == AckStatus::Invalid;
        !self.acknowledges_sections || spoken_of
    }

    /// A fault of acknowledgements begins or ends. `index` is its place in the fault plan.
    pub(super) fn fault(&mut self, index: usize, kind: &FaultKind, begins: bool) {
        self.faults.retain(|(place, _)| *place != index);
        if begins {
            let place = self.faults.partition_point(|(other, _)| *other < index);
            self.faults.insert(place, (index, kind.clone()));
        }
    }

    /// The status with which a fault makes the vehicle refuse this command, if one does.
    pub(super) fn refusal(&self, name: CommandName) -> Option<AckStatus> {
        self.faults.iter().find_map(|(_, kind)| {
            if let FaultKind::AcksNegative {
                command,
                status,
                done: false,
            } = kind
                && command.is_none_or(|command| command == name)
            {
                Some(status.as_status())
            } else {
                None
            }
        })
    }

    pub(super) fn verdict(&self, name: CommandName, mut status: AckStatus) -> Verdict {
        let mut delay = Duration::ZERO;
        for (_, kind) in &self.faults {
            if let FaultKind::AcksNegative {
                command,
                status: says,
                done: true,
            } = kind
                && command.is_none_or(|command| command == name)
                && status == AckStatus::Succeeded
            {
                status = says.as_status();
            }
            if let FaultKind::AcksLost(acks) = kind
                && acks.includes(name, status)
            {
                return Verdict::Lost;
            }
            if let FaultKind::AcksLate { acks, delay: by } = kind
                && acks.includes(name, status)
            {
                delay += *by;
            }
        }
        if delay.is_zero() {
            Verdict::Says(status)
        } else {
            Verdict::Late(status, delay)
        }
    }

    pub(super) fn delay(&mut self, due: Timestamp, client: ClientId, message: Acknowledgement) {
        if self.late.len() < LATE_MAX {
            let place = self.late.partition_point(|late| late.due <= due);
            self.late.insert(place, Late { due, client, message });
        }
    }

    /// When the next late acknowledgement is sent; [`Timestamp::MAX`] means never.
    pub(super) fn late_due(&self) -> Timestamp {
        self.late.front().map_or(Timestamp::MAX, |late| late.due)
    }

    pub(super) fn next_late(&mut self, at: Timestamp) -> Option<(ClientId, Acknowledgement)> {
        let late = self.late.pop_front_if(|late| late.due <= at)?;
        Some((late.client, late.message))
    }

    /// Drops the late acknowledgements of a client.
    pub(super) fn forget(&mut self, client: ClientId) {
        self.late.retain(|late| late.client != client);
    }
}

impl AckFilter {
    fn includes(&self, name: CommandName, status: AckStatus) -> bool {
        self.command.is_none_or(|command| command == name)
            && match self.stage {
                AckStage::All => true,
                AckStage::Pending => status == AckStatus::Pending,
                AckStage::Outcome => status != AckStatus::Pending,
            }
    }
}

impl NegativeStatus {
    const fn as_status(self) -> AckStatus {
        match self {
            Self::Invalid => AckStatus::Invalid,
            Self::Failed => AckStatus::Failed,
        }
    }
}

pub(super) fn clipped(text: &str) -> &str {
    let end = text.char_indices().nth(TEXT_MAX).map_or(text.len(), |(at, _)| at);
    text.get(..end).unwrap_or(text)
}
