//! The server side of the interface: who is connected and what each client receives, the vehicle's log and its clock.
//!
//! Every part of the vehicle sends its messages through the server. What clients ask for leaves the server here, and
//! [`crate::Mvc`] routes it.

pub(crate) mod answers;
mod clients;
mod log;
pub(crate) mod requests;
mod roles;
pub(crate) mod topics;

use std::net::SocketAddr;

use backseat_spi::{
    AckStatus, Acknowledgement, CommandName, EchoedTime, FromVehicle, Text, UnknownMessage, VehicleVersion,
};
use backseat_units::{TimeOfDay, Timestamp, Utc};

use self::answers::{Answers, Regarding, Verdict, clipped};
use self::clients::Clients;
use self::log::Log;
use self::requests::{Requests, Work};
use self::topics::{Named, Topic, named};
use crate::event::{ClientId, DropReason, MvcEvent, MvcEventKind};
use crate::faults::FaultKind;
use crate::file::{Profile, WorldFile};
use crate::interpretation::Interpretation;
use crate::plan::insert::Insert;
use crate::script::rules::Seen;

pub(crate) use self::clients::Received;

/// The clients with the bytes that wait for them, the log and the clock.
#[derive(Debug)]
pub(crate) struct Server {
    clients: Clients,
    log: Log,
    answers: Answers,
    requests: Requests,
    utc_at_start: Utc,
    version: Text,
    profile: Profile,
    acknowledge_text: Box<str>,
    all_is_navigation: bool,
    unknown_is_named: bool,
    /// Clients that have been cut off, and of which the rest of the vehicle does not know yet.
    left: Vec<ClientId>,
    /// What rules of a script may wait for, since they were told last.
    seen: Vec<(Timestamp, Seen)>,
}

impl Server {
    pub(crate) fn new(file: &WorldFile, interpretation: &Interpretation, seed: u64) -> Self {
        let ahead_ns = (file.start.clock_ahead_s * 1e9) as i64;
        let utc_at_start = file.start.utc.as_unix_nanos().saturating_add_signed(ahead_ns);
        Self {
            clients: Clients::new(&file.spi),
            log: Log::default(),
            answers: Answers::new(interpretation),
            requests: Requests::new(&file.spi, seed),
            utc_at_start: Utc::from_unix_nanos(utc_at_start),
            version: Text::cleaned(&file.spi.version),
            profile: file.spi.profile,
            acknowledge_text: file.spi.acknowledge_text.as_str().into(),
            all_is_navigation: interpretation.all_is_navigation,
            unknown_is_named: interpretation.unknown_is_named,
            left: Vec::new(),
            seen: Vec::new(),
        }
    }

    /// A client that is not known has connected. It gets the role for its address (SPI 4.1), and BFVER with the
    /// interface version (SPI 5.7). If there is no room or no role for it, it is cut off.
    pub(crate) fn connect(&mut self, now: Timestamp, client: ClientId, address: Option<SocketAddr>) {
        let topics = match self.profile {
            Profile::Spec => 0,
            Profile::Field => Topic::Control.bit() | Topic::Mission.bit(),
        };
        if self.clients.connect(client, address, topics) {
            self.note(now, MvcEventKind::Connected(client));
            if let Some(role) = self.clients.role_of(client).map(Box::from) {
                self.note(now, MvcEventKind::RoleGiven(client, role));
            }
            let (created, version) = (self.stamp(now), self.version.clone());
            self.send(now, client, &VehicleVersion { created, version }.into());
        }
    }

    /// A client's connection is gone. Forgets the client's subscriptions and the bytes that wait for it.
    pub(crate) fn disconnect(&mut self, now: Timestamp, client: ClientId) {
        self.mute(client);
        if let Some(role) = self.clients.disconnect(client) {
            self.note(now, MvcEventKind::Disconnected(client));
            if let Some(role) = role {
                self.note(now, MvcEventKind::RoleReleased(client, role));
            }
        }
    }

    pub(crate) fn cut_off(&mut self, client: ClientId, reason: DropReason) {
        self.clients.cut_off(client, reason);
    }

    pub(crate) fn cut_off_all(&mut self, reason: DropReason) {
        self.clients.cut_off_all(reason);
    }

    /// Logs which clients have been cut off.
    pub(crate) fn settle(&mut self, now: Timestamp) {
        while let Some((client, reason, role)) = self.clients.next_dropped() {
            self.mute(client);
            self.left.push(client);
            self.note(now, MvcEventKind::Dropped(client, reason));
            if let Some(role) = role {
                self.note(now, MvcEventKind::RoleReleased(client, role));
            }
        }
    }

    /// The next client that has been cut off. The rest of the vehicle must forget it.
    pub(crate) fn next_left(&mut self) -> Option<ClientId> {
        self.left.pop()
    }

    fn mute(&mut self, client: ClientId) {
        self.answers.forget(client);
        self.requests.mute(client);
    }

    /// The role that a client holds (SPI 4.1).
    pub(crate) fn role_of(&self, client: ClientId) -> Option<&str> {
        self.clients.role_of(client)
    }

    pub(crate) fn push(&mut self, client: ClientId, bytes: &[u8]) {
        self.clients.push(client, bytes);
    }

    pub(crate) fn next_received(&mut self, client: ClientId) -> Option<Received> {
        self.clients.next_received(client)
    }

    /// Whether the line that a client has just ended is not a sentence.
    pub(crate) fn ends_broken_line(&mut self, client: ClientId) -> bool {
        self.clients.ends_broken_line(client)
    }

    /// Logs the input of a client that is no valid sentence.
    pub(crate) fn note_ignored(&mut self, now: Timestamp, client: ClientId) {
        if let Some(what) = self.clients.ignored(now, client) {
            self.note(now, MvcEventKind::Ignored(client, what));
        }
    }

    pub(crate) fn poll_transmit(&mut self, out: &mut Vec<u8>) -> Option<ClientId> {
        self.clients.poll_transmit(out)
    }

    pub(crate) fn poll_disconnect(&mut self) -> Option<ClientId> {
        self.clients.poll_disconnect()
    }

    pub(crate) fn poll_event(&mut self, last_step: Timestamp) -> Option<MvcEvent> {
        self.log.poll(last_step)
    }

    /// UTC by the vehicle's clock, as its sentences carry it.
    pub(crate) fn utc(&self, now: Timestamp) -> Utc {
        self.utc_at_start + now.since(Timestamp::ZERO)
    }

    pub(crate) fn stamp(&self, now: Timestamp) -> TimeOfDay {
        self.utc(now).time_of_day()
    }

    /// Sets the vehicle's clock forward by this much, or back if negative.
    pub(crate) fn step_clock(&mut self, nanos: i64) {
        let utc = self.utc_at_start.as_unix_nanos().saturating_add_signed(nanos);
        self.utc_at_start = Utc::from_unix_nanos(utc);
    }

    pub(crate) fn note(&mut self, at: Timestamp, kind: MvcEventKind) {
        if let MvcEventKind::BehaviorBegan(behavior) = kind {
            self.seen.push((at, Seen::Began(behavior)));
        } else if let MvcEventKind::Connected(_) = kind {
            self.seen.push((at, Seen::Connected));
        }
        self.log.note(at, kind);
    }

    /// Removes and returns what rules of a script may wait for, in order.
    pub(crate) fn take_seen(&mut self) -> Vec<(Timestamp, Seen)> {
        core::mem::take(&mut self.seen)
    }

    /// Whether any client has switched on one of these.
    pub(crate) const fn wanted(&self, topics: u32) -> bool {
        self.clients.wanted(topics)
    }

    /// Whether this client has switched it on.
    pub(crate) fn has(&self, client: ClientId, topic: Topic) -> bool {
        self.clients.has(client, topic)
    }

    pub(crate) fn send(&mut self, now: Timestamp, client: ClientId, message: &FromVehicle) {
        if let Err(name) = self.clients.send(client, message) {
            self.note(now, MvcEventKind::NotEncoded(name));
        }
    }

    /// Sends a message to every client that has switched on its topic, or to all clients if it has no topic.
    pub(crate) fn publish(&mut self, now: Timestamp, topic: Option<Topic>, message: &FromVehicle) {
        if let Err(name) = self.clients.publish(topic, message) {
            self.note(now, MvcEventKind::NotEncoded(name));
        }
    }

    /// Sends a command message (SPI 5) to the client that holds a role, or to all clients without a role.
    pub(crate) fn order(&mut self, now: Timestamp, role: Option<&str>, message: &FromVehicle) {
        let Some(role) = role else {
            self.publish(now, None, message);
            return;
        };
        match self.clients.holder(role) {
            Some(client) => self.send(now, client, message),
            None => self.note(
                now,
                MvcEventKind::NobodyHolds {
                    role: role.into(),
                    message: message.name().into(),
                },
            ),
        }
        self.settle(now);
    }

    /// BPLOG (SPI 7.1). Returns what it switched on.
    pub(crate) fn switch(&mut self, now: Timestamp, re: Regarding, message: Text, on: bool) -> u32 {
        let topics = match named(message.as_str(), self.all_is_navigation) {
            Named::Topics(topics) => topics,
            Named::AlwaysOn if on => 0,
            Named::AlwaysOn => {
                self.acknowledge(now, re, AckStatus::Failed, "command messages are always on");
                return 0;
            }
            Named::Unknown => {
                let text = format!("message {message}: expected a message of the vehicle or ALL");
                self.invalid(now, re, &text);
                return 0;
            }
        };
        let client = re.client;
        self.clients.switch(client, topics, on);
        self.note(now, MvcEventKind::Subscribed { client, message, on });
        self.acknowledge(now, re, AckStatus::Succeeded, "");
        if on { topics } else { 0 }
    }

    /// Sends BFACK (SPI 6.21) if the client has switched it on.
    pub(crate) fn acknowledge(&mut self, now: Timestamp, re: Regarding, status: AckStatus, text: &str) {
        if re.muted || !self.has(re.client, Topic::Acknowledgement) || !self.answers.speaks_of(re.command, status) {
            return;
        }
        let (status, delay) = match self.answers.verdict(re.command, status) {
            Verdict::Says(status) => (status, None),
            Verdict::Late(status, delay) => (status, Some(delay)),
            Verdict::Lost => return,
        };
        let text = if text.is_empty() && status == AckStatus::Succeeded {
            &self.acknowledge_text
        } else {
            text
        };
        let message = Acknowledgement {
            created: self.stamp(now),
            command: re.command,
            command_created: EchoedTime::with_decimals(re.created, self.answers.echo_decimals),
            // On the wire, 0 means that there is no behavior.
            behavior: re.behavior.filter(|id| id.get() != 0),
            status,
            text: Text::cleaned(clipped(text)),
        };
        match delay {
            None => self.send(now, re.client, &message.into()),
            Some(delay) => self.answers.delay(now + delay, re.client, message),
        }
    }

    /// Answers a command with a value that has no meaning.
    pub(crate) fn invalid(&mut self, now: Timestamp, re: Regarding, text: &str) {
        self.note(
            now,
            MvcEventKind::CommandInvalid(re.client, re.command, Text::cleaned(clipped(text))),
        );
        self.acknowledge(now, re, AckStatus::Invalid, text);
    }

    /// Answers a command that does not parse. The answer names the command, and repeats its time if that can be read.
    pub(crate) fn malformed(
        &mut self,
        now: Timestamp,
        client: ClientId,
        (command, created): (CommandName, TimeOfDay),
        text: &str,
    ) {
        let re = Regarding {
            client,
            command,
            created,
            behavior: None,
            muted: false,
        };
        self.invalid(now, re, text);
    }

    /// Answers a sentence that is not a command. A name that BFACK cannot repeat, because it has not three letters, is
    /// `NAK` in any case.
    pub(crate) fn no_command(&mut self, now: Timestamp, re: Regarding, sentence: &UnknownMessage) {
        let text = format!("{} is no command", sentence.name().chars().take(20).collect::<String>());
        let named = CommandName::new(sentence.name()).ok().filter(|_| self.unknown_is_named);
        let time = sentence.fields().next().and_then(time_of_day);
        let re = Regarding {
            command: named.unwrap_or(CommandName::NAK),
            created: named.and(time).unwrap_or(TimeOfDay::MIDNIGHT),
            ..re
        };
        self.invalid(now, re, &text);
    }

    /// Answers a line that is not a sentence, if this vehicle does.
    pub(crate) fn no_sentence(&mut self, now: Timestamp, client: ClientId) {
        self.malformed(
            now,
            client,
            (CommandName::NAK, TimeOfDay::MIDNIGHT),
            "no header of a command matches this line",
        );
    }

    /// The status with which a fault makes the vehicle refuse this command, if one does.
    pub(crate) fn refusal(&self, command: CommandName) -> Option<AckStatus> {
        self.answers.refusal(command)
    }

    /// A fault of acknowledgements begins or ends. `index` is its place in the fault plan.
    pub(crate) fn fault(&mut self, index: usize, kind: &FaultKind, begins: bool) {
        self.answers.fault(index, kind, begins);
    }

    /// When the next late acknowledgement is sent; [`Timestamp::MAX`] means never.
    pub(crate) fn late_due(&self) -> Timestamp {
        self.answers.late_due()
    }

    /// Sends the acknowledgements that a fault has delayed until now.
    pub(crate) fn send_late(&mut self, now: Timestamp) {
        while let Some((client, message)) = self.answers.next_late(now) {
            let created = self.stamp(now);
            self.send(now, client, &Acknowledgement { created, ..message }.into());
        }
    }

    /// Starts a request. Returns it if it is to be decided at once; otherwise it is pending.
    #[must_use]
    pub(crate) fn begin<W: Into<Work>>(&mut self, now: Timestamp, re: Regarding, work: W) -> Option<W> {
        if self.requests.is_immediate() {
            return Some(work);
        }
        self.begin_pending(now, re, work);
        None
    }

    /// Starts a request that is always pending first.
    pub(crate) fn begin_pending(&mut self, now: Timestamp, re: Regarding, work: impl Into<Work>) {
        if self.requests.is_full(re.client) {
            self.acknowledge(now, re, AckStatus::Failed, "too many requests are pending");
            return;
        }
        self.acknowledge(now, re, AckStatus::Pending, "");
        self.requests.push(now, re, work.into());
    }

    /// The next request whose outcome is due.
    pub(crate) fn next_due(&mut self, now: Timestamp) -> Option<(Regarding, Work)> {
        self.requests.next_due(now)
    }

    /// Cancels the pending inserts for which `of` is true, and returns how many.
    pub(crate) fn take_back(&mut self, of: impl Fn(&Insert) -> bool) -> usize {
        self.requests.take_back(of)
    }
}

/// A time as sentences have it, `hhmmss.sss`.
pub(super) fn time_of_day(field: &str) -> Option<TimeOfDay> {
    let (hour, minute, second) = (field.get(..2)?, field.get(2..4)?, field.get(4..)?);
    format!("{hour}:{minute}:{second}").parse().ok()
}
