//! Commands that have been sent and wait for their acknowledgement (SPI 4.4, 6.21).

use std::collections::VecDeque;
use std::time::Duration;

use backseat_spi::{AckStatus, Acknowledgement, BehaviorId, CommandName};
use backseat_units::{TimeOfDay, Timestamp};

use crate::session::subscriptions::{ACKNOWLEDGEMENTS, is_always_needed};

/// The first acknowledgement comes within this time: the vehicle sends it immediately (4.4).
pub(crate) const FIRST_WITHIN: Duration = Duration::from_secs(1);
/// The vehicle settles a pending command within 2 s (4.4). The rest is for the delay of the link.
pub(crate) const SETTLED_WITHIN: Duration = Duration::from_secs(4);
/// The vehicle settles silent mode within 2 s, or within 4 s if the tailcone still turns (7.22). The rest is for the
/// delay of the link.
pub(crate) const SILENT_WITHIN: Duration = Duration::from_secs(6);
/// A whole plan takes longer to arrive (7.19).
pub(crate) const PLAN_WITHIN: Duration = Duration::from_secs(10);

/// What a command was sent for.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) enum Purpose {
    /// A command sent before the subscription to acknowledgements. Some vehicles answer it anyway.
    Early,
    /// A beat of the heartbeat: BPLOG,ACK,ON.
    Beat,
    /// A subscription of the session, by its place in the list.
    Subscription(usize),
    /// The plan.
    Plan,
    /// A refresh of the lease of this request.
    Lease(u64),
    /// An insert, by its request.
    Insert(u64),
    /// A cancel of an insert: the cancel's own request, if a plugin asked for it, and the insert's request.
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
    /// A command of the DVL trigger handshake, by its request.
    DvlTrigger(u64),
    /// A command of station keeping, by its request.
    Station(u64),
    /// The operator's cancel of all inserts, by its request.
    CancelAll(u64),
    /// The operator's abort or kill, by its request.
    Ending(u64),
    /// The start of an empty mission, by its request.
    EmptyMission(u64),
    /// The command that restores the vehicle's own speed limit after station keeping, by the request for that station
    /// keeping.
    SpeedRestored(u64),
    /// A command on whose answer nothing depends.
    Courtesy,
}

/// The vehicle's answer to a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Answer<'a> {
    /// The vehicle is working on it (acknowledgement status 3). Only the first such acknowledgement is passed on.
    Pending,
    /// The vehicle has done it.
    Done,
    /// The vehicle has refused it or failed at it, with this text.
    Refused(&'a str),
    /// No answer came in time.
    Missing,
}

#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) struct Command {
    pub(crate) name: CommandName,
    pub(crate) created: Option<TimeOfDay>,
    pub(crate) identifier: Option<BehaviorId>,
    pub(crate) purpose: Purpose,
    pub(crate) deadline: Timestamp,
    pub(crate) pending: bool,
}

/// What an acknowledgement says about the command that it answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Found {
    /// The vehicle is working on the command, which goes on waiting.
    NotSettled,
    /// This is the final answer.
    Settled {
        /// The acknowledgement names the command: by its time, or a subscription by its message. One that does not is
        /// taken for the answer to the oldest that it can belong to.
        named: bool,
    },
    /// The vehicle has refused this command, or has not understood it or another one ([`is_sent_again`]). The command goes
    /// on waiting as if there were no answer: its real answer may still come, and otherwise its deadline does.
    NotUnderstood,
    /// The vehicle has accepted an insert that it had refused before.
    AfterRefusal,
}

/// The commands that wait for an answer, oldest first.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Commands {
    sent: Vec<Command>,
    /// Commands that the vehicle may not have understood ([`Found::NotUnderstood`]). Only an acknowledgement that echoes
    /// their time answers them.
    not_understood: Vec<Command>,
    /// Inserts that the vehicle has refused, until their deadline, at which this is forgotten.
    refused: VecDeque<Command>,
    /// On this connection the vehicle has answered a command that was sent before the subscription to acknowledgements.
    answers_early: bool,
}

/// How many commands are remembered at once: no peer can make us remember without bound.
const COMMANDS_MAX: usize = 256;
/// How long and how many refused inserts are remembered, in case the vehicle accepts one after all.
const REFUSED_FOR: Duration = Duration::from_secs(10);
const REFUSED_MAX: usize = 64;

/// The name in the acknowledgement of a subscription. A subscription has no time that its acknowledgement could echo.
const LOG: &str = "LOG";

impl Commands {
    /// Remembers a command that is about to be sent. Returns false if there is no room: the command must then not be
    /// sent, because whatever depends on its answer would never end. If there is no room, a command on whose answer
    /// nothing depends gives up its place, or is sent without being remembered. The end of a mission always has room;
    /// there are two at most.
    pub(crate) fn push(&mut self, command: Command) -> bool {
        if self.sent.len() + self.not_understood.len() >= COMMANDS_MAX {
            let idle = self.sent.iter().position(|sent| sent.purpose == Purpose::Courtesy);
            match (idle, command.purpose) {
                (Some(idle), _) => {
                    self.sent.remove(idle);
                }
                (None, Purpose::Courtesy | Purpose::Early | Purpose::Beat) => return true,
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
                    | Purpose::Station(_)
                    | Purpose::SpeedRestored(_)
                    | Purpose::CancelAll(_)
                    | Purpose::EmptyMission(_),
                ) => return false,
            }
        }
        self.sent.push(command);
        true
    }

    /// Finds the command that an acknowledgement answers, by name, echoed time and identifier. An acknowledgement that
    /// names no command (`NAK`) answers the oldest command that is not pending. A final answer removes the command, any
    /// other leaves it waiting. [`Purpose::Subscription`] is an index into `subscriptions`.
    pub(crate) fn answer(
        &mut self,
        ack: &Acknowledgement,
        now: Timestamp,
        subscriptions: &[&str],
    ) -> Option<(Command, Found)> {
        let (index, named) = if ack.command == CommandName::NAK {
            (self.sent.iter().position(|command| !command.pending)?, false)
        } else if ack.command.as_str() == LOG {
            self.subscription(ack, subscriptions)?
        } else {
            if let Some(index) = self.not_understood.iter().position(|command| echoes(ack, command)) {
                let command = self.not_understood.remove(index);
                self.sent.push(command);
            }
            match self.sent.iter().position(|command| echoes(ack, command)) {
                Some(index) => (index, true),
                None if matches!(ack.status, AckStatus::Succeeded | AckStatus::Pending) => {
                    return Some((self.take_refused(ack, now)?, Found::AfterRefusal));
                }
                // The refusal of a command that the vehicle could not read echoes no time: it answers the oldest
                // command of that name. No other acknowledgement may lack the echo, or a late one would confirm a
                // later command.
                None if ack.status == AckStatus::Invalid && ack.command_created.is_none() => {
                    (self.sent.iter().position(|command| command.name == ack.command)?, false)
                }
                None => return None,
            }
        };
        let command = &mut self.sent[index];
        self.answers_early |= command.purpose == Purpose::Early;
        match ack.status {
            AckStatus::Invalid | AckStatus::Failed if is_sent_again(command.purpose, ack, named) => {
                let command = self.sent.remove(index);
                self.not_understood.push(command);
                return Some((command, Found::NotUnderstood));
            }
            AckStatus::Invalid | AckStatus::Failed | AckStatus::Other(_) => {
                let command = self.sent.remove(index);
                if named && matches!(command.purpose, Purpose::Insert(_)) {
                    self.remember_refused(command, now);
                }
                return Some((command, Found::Settled { named }));
            }
            // The first of the two acknowledgements of silent mode confirms the receipt. Its status need not be pending
            // (7.22).
            AckStatus::Succeeded if command.pending || !matches!(command.purpose, Purpose::Silent(_)) => {
                return Some((self.sent.remove(index), Found::Settled { named }));
            }
            AckStatus::Succeeded | AckStatus::Pending => {}
        }
        if command.pending {
            // A repeated pending acknowledgement gives the vehicle no more time.
            return None;
        }
        command.pending = true;
        command.deadline = match command.purpose {
            Purpose::Plan => now + PLAN_WITHIN,
            Purpose::Silent(_) => now + SILENT_WITHIN,
            Purpose::Early
            | Purpose::Beat
            | Purpose::Subscription(_)
            | Purpose::Lease(_)
            | Purpose::Insert(_)
            | Purpose::Cancel { .. }
            | Purpose::Request(_)
            | Purpose::Topside(_)
            | Purpose::Adjustment(_)
            | Purpose::Packet(_)
            | Purpose::DvlTrigger(_)
            | Purpose::Station(_)
            | Purpose::CancelAll(_)
            | Purpose::Ending(_)
            | Purpose::EmptyMission(_)
            | Purpose::SpeedRestored(_)
            | Purpose::Courtesy => now + SETTLED_WITHIN,
        };
        Some((*command, Found::NotSettled))
    }

    fn remember_refused(&mut self, command: Command, now: Timestamp) {
        self.refused.retain(|refused| refused.deadline > now);
        if self.refused.len() >= REFUSED_MAX {
            self.refused.pop_front();
        }
        let deadline = now + REFUSED_FOR;
        self.refused.push_back(Command { deadline, ..command });
    }

    fn take_refused(&mut self, ack: &Acknowledgement, now: Timestamp) -> Option<Command> {
        self.refused.retain(|refused| refused.deadline > now);
        let index = self.refused.iter().position(|refused| echoes(ack, refused))?;
        self.refused.remove(index)
    }

    /// Finds the subscription that an acknowledgement answers: the one that its text names, otherwise the oldest. The
    /// second value is whether the text names it.
    ///
    /// Commands that were sent before the subscription to acknowledgements count only if the vehicle answers such
    /// commands. It answers in order, so it has then answered BPVER before any subscription. If they always counted,
    /// each answer would be taken for the answer to the previous subscription.
    fn subscription(&mut self, ack: &Acknowledgement, subscriptions: &[&str]) -> Option<(usize, bool)> {
        if !self.answers_early {
            self.sent.retain(|command| command.purpose != Purpose::Early);
        }
        let subject = |command: &Command| match command.purpose {
            Purpose::Subscription(index) => subscriptions.get(index).copied(),
            // The first message of the list is subscribed before acknowledgements are.
            Purpose::Early => subscriptions.first().copied(),
            Purpose::Beat => Some(ACKNOWLEDGEMENTS),
            Purpose::Plan
            | Purpose::Lease(_)
            | Purpose::Insert(_)
            | Purpose::Cancel { .. }
            | Purpose::Request(_)
            | Purpose::Topside(_)
            | Purpose::Silent(_)
            | Purpose::Adjustment(_)
            | Purpose::Packet(_)
            | Purpose::DvlTrigger(_)
            | Purpose::Station(_)
            | Purpose::SpeedRestored(_)
            | Purpose::CancelAll(_)
            | Purpose::Ending(_)
            | Purpose::EmptyMission(_)
            | Purpose::Courtesy => None,
        };
        let waiting = || self.sent.iter().filter(|command| command.name == ack.command);
        let text = ack.text.as_str();
        let mut named = waiting().filter_map(subject).filter(|subject| names(text, subject));
        let named = match (named.next(), named.next()) {
            (Some(one), None) => Some(one),
            // The same message may be subscribed twice. A text with two different messages names neither.
            (Some(one), Some(other)) if one == other && named.all(|more| more == one) => Some(one),
            (Some(_), Some(_)) | (None, _) => None,
        };
        let index = self.sent.iter().position(|command| {
            command.name == ack.command && named.is_none_or(|named| subject(command) == Some(named))
        });
        Some((index?, named.is_some()))
    }

    /// Whether a BPLOG waits for its answer.
    pub(crate) fn awaits_log(&self) -> bool {
        let mut all = self.sent.iter().chain(&self.not_understood);
        all.any(|command| command.name.as_str() == LOG)
    }

    /// A command of this purpose is sent anew: nothing depends on the answers to the earlier ones any more.
    pub(crate) fn supersede(&mut self, purpose: Purpose) {
        for command in self.sent.iter_mut().chain(&mut self.not_understood) {
            if command.purpose == purpose {
                command.purpose = Purpose::Courtesy;
            }
        }
    }

    /// Removes and returns a command whose answer is late.
    pub(crate) fn late(&mut self, now: Timestamp) -> Option<Command> {
        let late = |command: &Command| command.deadline <= now;
        if let Some(index) = self.not_understood.iter().position(late) {
            return Some(self.not_understood.remove(index));
        }
        let index = self.sent.iter().position(late)?;
        Some(self.sent.remove(index))
    }

    pub(crate) fn next_deadline(&self) -> Option<Timestamp> {
        let all = self.sent.iter().chain(&self.not_understood);
        all.map(|command| command.deadline).min()
    }

    /// The lease is over: nothing depends on the answers to its refreshes any more.
    pub(crate) fn forget_lease(&mut self) {
        for command in &mut self.sent {
            if matches!(command.purpose, Purpose::Lease(_)) {
                command.purpose = Purpose::Courtesy;
            }
        }
    }

    /// Station keeping is over: nothing depends on the answers to its commands any more.
    pub(crate) fn forget_station(&mut self) {
        for command in &mut self.sent {
            if matches!(command.purpose, Purpose::Station(_)) {
                command.purpose = Purpose::Courtesy;
            }
        }
    }

    /// We ask for the plan again: the answer to an earlier request does not count any more.
    pub(crate) fn forget_plan(&mut self) {
        for command in &mut self.sent {
            if command.purpose == Purpose::Plan {
                command.purpose = Purpose::Courtesy;
            }
        }
    }

    /// The link is gone: no answer will come.
    pub(crate) fn clear(&mut self) {
        self.sent.clear();
        self.not_understood.clear();
        self.refused.clear();
        self.answers_early = false;
    }
}

/// Whether an acknowledgement echoes a command's name, time and identifier. A command or an acknowledgement may lack the
/// identifier.
fn echoes(ack: &Acknowledgement, command: &Command) -> bool {
    command.name == ack.command
        && command
            .created
            .is_some_and(|created| ack.command_created.echoes(created))
        && (ack.behavior.is_none() || command.identifier.is_none() || ack.behavior == command.identifier)
}

/// Whether a refusal is no answer to a command that core sends again, or cancels, if it is not answered. It is none if it
/// does not name the command: it may have been meant for another one, and this one may be flown; or the line was damaged
/// on its way.
fn is_sent_again(purpose: Purpose, ack: &Acknowledgement, named: bool) -> bool {
    match purpose {
        // Core goes on asking for the messages that it needs. Another one may not exist on this vehicle, so a refusal
        // ends its subscription.
        Purpose::Subscription(index) => ack.command == CommandName::NAK || is_always_needed(index),
        Purpose::Insert(_) | Purpose::Cancel { cancel: None, .. } | Purpose::Ending(_) => !named,
        Purpose::Early
        | Purpose::Beat
        | Purpose::Plan
        | Purpose::Lease(_)
        | Purpose::Cancel { cancel: Some(_), .. }
        | Purpose::Request(_)
        | Purpose::Topside(_)
        | Purpose::Silent(_)
        | Purpose::Adjustment(_)
        | Purpose::Packet(_)
        | Purpose::DvlTrigger(_)
        | Purpose::Station(_)
        | Purpose::SpeedRestored(_)
        | Purpose::CancelAll(_)
        | Purpose::EmptyMission(_)
        | Purpose::Courtesy => false,
    }
}

/// Whether a text has a message's name among its words, as `NVG` or `BFNVG`.
fn names(text: &str, message: &str) -> bool {
    text.split(|character: char| !character.is_ascii_alphanumeric())
        .any(|word| word.strip_prefix("BF").unwrap_or(word) == message)
}

#[cfg(test)]
mod tests {
    use super::*;
    use backseat_spi::{EchoedTime, Text};

    const MESSAGES: [&str; 4] = ["CTL", "ACK", "MIS", "CTL"];

    fn command(letters: &str, created: Option<TimeOfDay>, purpose: Purpose, deadline_s: u64) -> Command {
        Command {
            name: CommandName::new(letters).unwrap(),
            created,
            identifier: None,
            purpose,
            deadline: Timestamp::from_secs(deadline_s),
            pending: false,
        }
    }

    fn ack(letters: &str, echoed: TimeOfDay, status: AckStatus, text: &str) -> Acknowledgement {
        Acknowledgement {
            created: TimeOfDay::MIDNIGHT,
            command: CommandName::new(letters).unwrap(),
            command_created: EchoedTime::of(echoed),
            behavior: None,
            status,
            text: Text::cleaned(text),
        }
    }

    fn at(millis: u64) -> TimeOfDay {
        TimeOfDay::from_nanos(millis * 1_000_000).unwrap()
    }

    /// The commands that begin a connection.
    fn begun() -> Commands {
        let mut commands = Commands::default();
        commands.push(command("VER", Some(at(1)), Purpose::Early, 2));
        commands.push(command("LOG", None, Purpose::Early, 2));
        for index in 1..MESSAGES.len() {
            commands.push(command("LOG", None, Purpose::Subscription(index), 2));
        }
        commands
    }

    fn answered(commands: &mut Commands, ack: &Acknowledgement) -> Option<Purpose> {
        let command = commands.answer(ack, Timestamp::ZERO, &MESSAGES);
        command.map(|(command, _)| command.purpose)
    }

    #[test]
    fn without_early_answers_the_first_answer_is_to_the_first_subscription() {
        let mut commands = begun();
        for index in 1..MESSAGES.len() {
            let log = ack("LOG", TimeOfDay::MIDNIGHT, AckStatus::Succeeded, "log set");
            assert_eq!(answered(&mut commands, &log), Some(Purpose::Subscription(index)));
        }
        assert_eq!(commands.next_deadline(), None);
    }

    #[test]
    fn with_early_answers_the_first_answer_is_to_the_first_command() {
        for first in [
            ack("VER", at(1), AckStatus::Succeeded, ""),
            ack("NAK", TimeOfDay::MIDNIGHT, AckStatus::Invalid, "what"),
        ] {
            let mut commands = begun();
            assert_eq!(answered(&mut commands, &first), Some(Purpose::Early));
            let log = ack("LOG", TimeOfDay::MIDNIGHT, AckStatus::Succeeded, "log set");
            assert_eq!(answered(&mut commands, &log), Some(Purpose::Early));
            for index in 1..MESSAGES.len() {
                assert_eq!(answered(&mut commands, &log), Some(Purpose::Subscription(index)));
            }
        }
    }

    #[test]
    fn an_answer_is_to_the_subscription_that_it_names() {
        let mut commands = begun();
        let log = |text| ack("LOG", TimeOfDay::MIDNIGHT, AckStatus::Failed, text);
        assert_eq!(
            answered(&mut commands, &log("no BFMIS here")),
            Some(Purpose::Subscription(2))
        );
        assert_eq!(answered(&mut commands, &log("CTL ON")), Some(Purpose::Subscription(3)));
        assert_eq!(answered(&mut commands, &log("ACK")), Some(Purpose::Subscription(1)));
        assert_eq!(answered(&mut commands, &log("ACK")), None);
        let mut commands = begun();
        assert_eq!(
            answered(&mut commands, &log("either MIS or CTL")),
            Some(Purpose::Subscription(1))
        );
    }

    #[test]
    fn only_the_refusal_of_an_unreadable_command_may_lack_the_echo() {
        let mut commands = Commands::default();
        commands.push(command("RMB", Some(at(7)), Purpose::Lease(1), 2));
        commands.push(command("RMB", Some(at(8)), Purpose::Lease(2), 2));
        let late = |echoed, status| ack("RMB", echoed, status, "");
        assert_eq!(answered(&mut commands, &late(at(6), AckStatus::Succeeded)), None);
        assert_eq!(
            answered(&mut commands, &late(TimeOfDay::MIDNIGHT, AckStatus::Succeeded)),
            None
        );
        assert_eq!(
            answered(&mut commands, &late(at(8), AckStatus::Succeeded)),
            Some(Purpose::Lease(2))
        );
        let unread = late(TimeOfDay::MIDNIGHT, AckStatus::Invalid);
        assert_eq!(answered(&mut commands, &unread), Some(Purpose::Lease(1)));
    }

    fn insert(purpose: Purpose) -> Command {
        command("RTK", None, purpose, 0)
    }

    #[test]
    fn a_command_with_consequences_is_never_dropped_for_lack_of_room() {
        let mut commands = Commands::default();
        assert!(commands.push(insert(Purpose::Courtesy)));
        for request in 0..COMMANDS_MAX as u64 {
            assert!(commands.push(insert(Purpose::Insert(request))), "{request}");
        }
        assert!(
            !commands.push(insert(Purpose::Insert(999))),
            "not sent, because there is no room"
        );
        assert!(commands.push(insert(Purpose::Courtesy)), "sent, but not remembered");
        assert!(commands.push(insert(Purpose::Ending(1000))));
        let mut late = Vec::new();
        while let Some(command) = commands.late(Timestamp::ZERO) {
            late.push(command.purpose);
        }
        let mut expected: Vec<Purpose> = (0..COMMANDS_MAX as u64).map(Purpose::Insert).collect();
        expected.push(Purpose::Ending(1000));
        assert_eq!(late, expected);
    }
}
