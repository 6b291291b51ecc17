use core::time::Duration;
use std::collections::VecDeque;
use std::net::SocketAddr;

use backseat_spi::{CommandName, FrameCounts, Framer, FromVehicle, Policy, Sentence, Text, ToVehicle};
use backseat_units::{TimeOfDay, Timestamp};

use crate::event::{ClientId, DropReason};
use crate::file::{LineEnd, SpiConfig};
use crate::server::roles::{Roles, Seat};
use crate::server::time_of_day;
use crate::server::topics::Topic;

/// How many bytes may wait for a client. A long plan fits twice; a client that never reads is cut off.
const BACKLOG_MAX: usize = 4 << 20;

/// What a client sent.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Received {
    Command(ToVehicle),
    /// A command that does not parse: its name, its time if that can be read, and which field is wrong.
    Malformed(CommandName, TimeOfDay, Text),
}

impl Received {
    /// The command's name; [`CommandName::NAK`] for a sentence that is no command.
    pub(crate) fn name(&self) -> CommandName {
        match self {
            Self::Command(command) => CommandName::new(command.name()).unwrap_or(CommandName::NAK),
            Self::Malformed(name, _, _) => *name,
        }
    }
}

/// The time of a sentence that does not parse; midnight if that cannot be read either.
fn created(sentence: &Sentence<'_>) -> TimeOfDay {
    let first = sentence.fields().next();
    first.and_then(time_of_day).unwrap_or(TimeOfDay::MIDNIGHT)
}

#[derive(Debug)]
struct Client {
    id: ClientId,
    framer: Framer,
    topics: u32,
    /// Which of the server's roles it holds.
    role: Option<usize>,
    out: Vec<u8>,
    /// The framer's counts at the last log line about invalid input, and when the next line may come.
    told: FrameCounts,
    tell_from: Timestamp,
    /// The framer's counts at the end of the last line.
    line: FrameCounts,
}

/// The log has at most one line about a client's invalid input in this time.
const IGNORED_EVERY: Duration = Duration::from_secs(1);

const fn without_sentences(counts: FrameCounts) -> FrameCounts {
    FrameCounts {
        sentences: 0,
        checksum_absent: 0,
        ..counts
    }
}

/// The table of clients: what each has switched on, what it has sent, and what waits for it.
#[derive(Debug)]
pub(crate) struct Clients {
    clients: Vec<Client>,
    clients_max: usize,
    roles: Roles,
    /// Clients that the server has cut off and that the driver has not fetched yet.
    gone: VecDeque<ClientId>,
    /// The clients that the server has cut off since the last call, why, and the role that became free.
    dropped: VecDeque<(ClientId, DropReason, Option<Box<str>>)>,
    /// All topics that any client has switched on.
    topics: u32,
    /// Where the next search for something to send begins, so that each client has its turn.
    turn: usize,
    line_end: LineEnd,
    scratch: Vec<u8>,
}

impl Clients {
    pub(crate) fn new(config: &SpiConfig) -> Self {
        Self {
            clients: Vec::new(),
            clients_max: config.clients_max as usize,
            roles: Roles::new(config),
            gone: VecDeque::new(),
            dropped: VecDeque::new(),
            topics: 0,
            turn: 0,
            line_end: config.line_end,
            scratch: Vec::with_capacity(512),
        }
    }

    /// Adds a client. Returns false if there is no room or no role for it; it is then cut off.
    pub(crate) fn connect(&mut self, id: ClientId, address: Option<SocketAddr>, topics: u32) -> bool {
        self.disconnect(id);
        self.gone.retain(|gone| *gone != id);
        if self.clients.len() >= self.clients_max {
            self.cut_off(id, DropReason::TooMany);
            return false;
        }
        let held = |role: usize| self.clients.iter().any(|client| client.role == Some(role));
        let role = match self.roles.seat(address, held) {
            Seat::Role(role) => Some(role),
            Seat::Stranger => None,
            Seat::Refused(reason) => {
                self.cut_off(id, reason);
                return false;
            }
        };
        self.clients.push(Client {
            id,
            framer: Framer::new(Policy::FromPayload),
            topics,
            role,
            out: Vec::new(),
            told: FrameCounts::default(),
            tell_from: Timestamp::ZERO,
            line: FrameCounts::default(),
        });
        self.topics |= topics;
        true
    }

    /// The role that a client holds.
    pub(crate) fn role_of(&self, id: ClientId) -> Option<&str> {
        let client = self.clients.iter().find(|client| client.id == id)?;
        self.roles.name(client.role?)
    }

    /// The client that holds a role.
    pub(crate) fn holder(&self, role: &str) -> Option<ClientId> {
        let holds = |client: &&Client| client.role.and_then(|held| self.roles.name(held)) == Some(role);
        self.clients.iter().find(holds).map(|client| client.id)
    }

    /// Forgets a client, and returns the role that became free; `None` if the client was not known.
    pub(crate) fn disconnect(&mut self, id: ClientId) -> Option<Option<Box<str>>> {
        let at = self.clients.iter().position(|client| client.id == id)?;
        let client = self.clients.remove(at);
        self.topics = self.clients.iter().fold(0, |topics, client| topics | client.topics);
        Some(client.role.and_then(|role| self.roles.name(role)).map(Box::from))
    }

    pub(crate) fn cut_off(&mut self, id: ClientId, reason: DropReason) {
        let role = self.disconnect(id).flatten();
        // The limit keeps this from growing if the driver never fetches it.
        if self.gone.len() < 1024 {
            self.gone.push_back(id);
        }
        self.dropped.push_back((id, reason, role));
    }

    pub(crate) fn cut_off_all(&mut self, reason: DropReason) {
        while let Some(id) = self.clients.first().map(|client| client.id) {
            self.cut_off(id, reason);
        }
    }

    /// The next client that the server has cut off, why, and the role that became free.
    pub(crate) fn next_dropped(&mut self) -> Option<(ClientId, DropReason, Option<Box<str>>)> {
        self.dropped.pop_front()
    }

    pub(crate) fn poll_disconnect(&mut self) -> Option<ClientId> {
        self.gone.pop_front()
    }

    pub(crate) fn push(&mut self, id: ClientId, bytes: &[u8]) {
        if let Some(client) = self.client(id) {
            client.framer.push(bytes);
        }
    }

    pub(crate) fn next_received(&mut self, id: ClientId) -> Option<Received> {
        let client = self.client(id)?;
        let sentence = client.framer.next_sentence()?;
        Some(match ToVehicle::decode(&sentence) {
            Ok(command) => match reserved_fault(&command, &sentence) {
                None => Received::Command(command),
                Some(fault) => {
                    let name = CommandName::new(sentence.name()).unwrap_or(CommandName::NAK);
                    Received::Malformed(name, created(&sentence), Text::cleaned(&fault))
                }
            },
            Err(error) => {
                let name = CommandName::new(sentence.name()).unwrap_or(CommandName::NAK);
                Received::Malformed(name, created(&sentence), Text::cleaned(&error.to_string()))
            }
        })
    }

    /// Call it after a client has ended a line and its sentence has been taken. Returns whether the line was not one: it
    /// has no `$`, or no name after it. A sentence with a wrong checksum is one.
    pub(crate) fn ends_broken_line(&mut self, id: ClientId) -> bool {
        let Some(client) = self.client(id) else { return false };
        let (counts, before) = (client.framer.counts(), client.line);
        client.line = counts;
        let outside = |counts: FrameCounts| counts.noise_bytes + counts.malformed + counts.not_utf8 + counts.too_long;
        let sentences = |counts: FrameCounts| counts.sentences + counts.checksum_invalid;
        outside(counts) > outside(before) && sentences(counts) == sentences(before)
    }

    /// The invalid input of a client since the last line about it, in words; at most one line a second.
    pub(crate) fn ignored(&mut self, now: Timestamp, id: ClientId) -> Option<Text> {
        let client = self.client(id)?;
        let (counts, told) = (client.framer.counts(), client.told);
        if now < client.tell_from || without_sentences(counts) == without_sentences(told) {
            return None;
        }
        (client.told, client.tell_from) = (counts, now + IGNORED_EVERY);
        let parts = [
            (
                counts.checksum_invalid - told.checksum_invalid,
                "with a wrong checksum (`backseat spi decode` names the right one)",
            ),
            (counts.malformed - told.malformed, "without a name"),
            (counts.too_long - told.too_long, "too long"),
            (counts.not_utf8 - told.not_utf8, "not UTF-8"),
            (counts.cut_short - told.cut_short, "cut short"),
            (counts.overflowed - told.overflowed, "too many at once"),
            (
                counts.noise_bytes - told.noise_bytes,
                "bytes outside of a sentence (it begins with a dollar sign)",
            ),
        ];
        let parts: Vec<String> = parts
            .iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| format!("{count} {what}"))
            .collect();
        Some(Text::cleaned(&parts.join("; ")))
    }

    pub(crate) fn switch(&mut self, id: ClientId, topics: u32, on: bool) {
        if let Some(client) = self.client(id) {
            client.topics = if on {
                client.topics | topics
            } else {
                client.topics & !topics
            };
        }
        self.topics = self.clients.iter().fold(0, |topics, client| topics | client.topics);
    }

    pub(crate) fn has(&self, id: ClientId, topic: Topic) -> bool {
        self.clients
            .iter()
            .any(|client| client.id == id && client.topics & topic.bit() != 0)
    }

    /// Whether any client has switched on one of these.
    pub(crate) const fn wanted(&self, topics: u32) -> bool {
        self.topics & topics != 0
    }

    /// Sends a message to one client. An error is the name of a message that cannot be encoded.
    pub(crate) fn send(&mut self, id: ClientId, message: &FromVehicle) -> Result<(), Box<str>> {
        let line_end = self.line_end;
        let Some(client) = self.client(id) else { return Ok(()) };
        let encoded = message.encode(&mut client.out).map_err(|_| Box::from(message.name()));
        if encoded.is_ok() {
            end_line(&mut client.out, line_end);
        }
        if client.out.len() > BACKLOG_MAX {
            self.cut_off(id, DropReason::Backlog);
        }
        encoded
    }

    /// Sends a message to every client that has switched on its topic, or to all clients if it has no topic.
    pub(crate) fn publish(&mut self, topic: Option<Topic>, message: &FromVehicle) -> Result<(), Box<str>> {
        self.scratch.clear();
        message
            .encode(&mut self.scratch)
            .map_err(|_| Box::from(message.name()))?;
        end_line(&mut self.scratch, self.line_end);
        let mut full = Vec::new();
        for client in &mut self.clients {
            if topic.is_none_or(|topic| client.topics & topic.bit() != 0) {
                client.out.extend_from_slice(&self.scratch);
                if client.out.len() > BACKLOG_MAX {
                    full.push(client.id);
                }
            }
        }
        for id in full {
            self.cut_off(id, DropReason::Backlog);
        }
        Ok(())
    }

    /// One write: all bytes that wait for one client. The buffers are swapped, so neither is allocated again.
    pub(crate) fn poll_transmit(&mut self, out: &mut Vec<u8>) -> Option<ClientId> {
        let count = self.clients.len();
        for step in 0..count {
            let at = (self.turn + step) % count;
            if let Some(client) = self.clients.get_mut(at).filter(|client| !client.out.is_empty()) {
                self.turn = at + 1;
                out.clear();
                core::mem::swap(out, &mut client.out);
                return Some(client.id);
            }
        }
        None
    }

    fn client(&mut self, id: ClientId) -> Option<&mut Client> {
        self.clients.iter_mut().find(|client| client.id == id)
    }
}

/// Adds what the vehicle sends after the end of a sentence.
fn end_line(out: &mut Vec<u8>, line_end: LineEnd) {
    match line_end {
        LineEnd::Crlf => {}
        LineEnd::CrlfLf => out.push(b'\n'),
    }
}

/// What is wrong with a reserved field, which "must be empty or 0" (SPI 7.3, 7.10, 7.11). A comma in the text of a
/// BPTOP moves part of the text into it. Decoding skips the field.
fn reserved_fault(command: &ToVehicle, sentence: &Sentence<'_>) -> Option<String> {
    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "the other commands have no reserved field"
    )]
    let index = match command {
        ToVehicle::TopsideText(_) => 3,
        ToVehicle::CancelCurrent(_) | ToVehicle::CancelElement(_) => 1,
        _ => return None,
    };
    let field = sentence.fields().nth(index)?.trim();
    let zero = field.is_empty() || field.parse::<f64>().is_ok_and(|number| number == 0.0);
    (!zero).then(|| format!("reserved field {field}: expected empty or 0"))
}
