use std::collections::VecDeque;

use backseat_spi::{CommandName, Framer, FromVehicle, Policy, Sentence, Text, ToVehicle};

use crate::event::{ClientId, DropReason};

/// How much may wait for a client, bytes: a long plan fits twice, a client that never reads is cut off.
const BACKLOG_MAX: usize = 4 << 20;

/// The names of the status messages in BPLOG, in the order of [`Topic`]. What this vehicle has no sensor for can be
/// switched on and never comes, as on a vehicle without the sensor.
const TOPICS: [&str; 27] = [
    "NVG", "NVR", "MBS", "MBE", "MIS", "CTL", "ACK", "CTD", "PLN", "TEL", "SVS", "RCM", "RDP", "RVL", "RBS", "ERC",
    "DVL", "DV2", "IMU", "RNV", "PIT", "CNV", "TRM", "BOY", "CMA", "CPS", "CPR",
];

/// The command messages (SPI 5), which are always on.
const ALWAYS_ON: [&str; 7] = ["MSC", "SHT", "BDL", "SDL", "TOP", "DVT", "VER"];

/// A status message that a payload can switch on (SPI 6, 9), a bit each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Topic {
    Navigation,
    Velocity,
    BehaviorBegin,
    BehaviorEnd,
    Mission,
    Control,
    Acknowledgement,
    Ctd,
    Plan,
    Telemetry,
    SoundVelocity,
    Compass,
    DepthSensor,
    VehicleSpeed,
    Battery,
    ElevatorRudder,
    Dvl,
    DvlExtended,
    Imu,
    RelativeNavigation,
    PitchServo,
    CartesianNavigation,
    Trim,
    Buoyancy,
    MediumAccess,
    PacketSent,
    PacketReceived,
}

impl Topic {
    pub(crate) const fn bit(self) -> u32 {
        1 << self as u32
    }
}

const ALL: u32 = ((1 << TOPICS.len()) - 1) & !Topic::Acknowledgement.bit();

/// What BPLOG's first field names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Named {
    Topics(u32),
    AlwaysOn,
    Unknown,
}

pub(crate) fn named(message: &str) -> Named {
    if message == "ALL" {
        return Named::Topics(ALL);
    }
    match TOPICS.iter().position(|name| *name == message) {
        Some(bit) => Named::Topics(1 << bit),
        None if ALWAYS_ON.contains(&message) => Named::AlwaysOn,
        None => Named::Unknown,
    }
}

/// What came from a client.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Received {
    Command(ToVehicle),
    /// A command that does not parse: its name, and which field is at fault.
    Malformed(CommandName, Text),
}

#[derive(Debug)]
struct Client {
    id: ClientId,
    framer: Framer,
    topics: u32,
    out: Vec<u8>,
}

/// The table of clients: what each has switched on, what it has sent, what is due to it.
#[derive(Debug)]
pub(crate) struct Server {
    clients: Vec<Client>,
    clients_max: usize,
    /// Clients that the server has cut off and the driver has not yet heard of.
    gone: VecDeque<ClientId>,
    /// What the server has cut off since last asked, and why.
    pub(crate) dropped: VecDeque<(ClientId, DropReason)>,
    /// All that any client has switched on.
    topics: u32,
    scratch: Vec<u8>,
}

impl Server {
    pub(crate) fn new(clients_max: u32) -> Self {
        Self {
            clients: Vec::new(),
            clients_max: clients_max as usize,
            gone: VecDeque::new(),
            dropped: VecDeque::new(),
            topics: 0,
            scratch: Vec::with_capacity(512),
        }
    }

    /// Adds a client; false where there is no room, and the client is cut off.
    pub(crate) fn connect(&mut self, id: ClientId, topics: u32) -> bool {
        self.disconnect(id);
        self.gone.retain(|gone| *gone != id);
        if self.clients.len() >= self.clients_max {
            self.cut_off(id, DropReason::TooMany);
            return false;
        }
        self.clients.push(Client {
            id,
            framer: Framer::new(Policy::FromPayload),
            topics,
            out: Vec::new(),
        });
        self.topics |= topics;
        true
    }

    /// Forgets a client; false where it was not known.
    pub(crate) fn disconnect(&mut self, id: ClientId) -> bool {
        let before = self.clients.len();
        self.clients.retain(|client| client.id != id);
        self.topics = self.clients.iter().fold(0, |topics, client| topics | client.topics);
        self.clients.len() != before
    }

    pub(crate) fn cut_off(&mut self, id: ClientId, reason: DropReason) {
        self.disconnect(id);
        // A driver that never asks must not make this grow.
        if self.gone.len() < 1024 {
            self.gone.push_back(id);
        }
        self.dropped.push_back((id, reason));
    }

    pub(crate) fn cut_off_all(&mut self, reason: DropReason) {
        while let Some(id) = self.clients.first().map(|client| client.id) {
            self.cut_off(id, reason);
        }
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
                    Received::Malformed(name, Text::cleaned(&fault))
                }
            },
            Err(error) => {
                let name = CommandName::new(sentence.name()).unwrap_or(CommandName::NAK);
                Received::Malformed(name, Text::cleaned(&error.to_string()))
            }
        })
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

    /// Whether any client has switched it on.
    pub(crate) const fn wanted(&self, topics: u32) -> bool {
        self.topics & topics != 0
    }

    /// Sends to one client. An error is the name of the message that cannot be written.
    pub(crate) fn send(&mut self, id: ClientId, message: &FromVehicle) -> Result<(), Box<str>> {
        let Some(client) = self.client(id) else { return Ok(()) };
        let encoded = message.encode(&mut client.out).map_err(|_| Box::from(message.name()));
        if client.out.len() > BACKLOG_MAX {
            self.cut_off(id, DropReason::Backlog);
        }
        encoded
    }

    /// Sends to every client that has switched it on, or to all.
    pub(crate) fn publish(&mut self, topic: Option<Topic>, message: &FromVehicle) -> Result<(), Box<str>> {
        self.scratch.clear();
        message
            .encode(&mut self.scratch)
            .map_err(|_| Box::from(message.name()))?;
        let mut full = None;
        for client in &mut self.clients {
            if topic.is_none_or(|topic| client.topics & topic.bit() != 0) {
                client.out.extend_from_slice(&self.scratch);
                if client.out.len() > BACKLOG_MAX {
                    full = Some(client.id);
                }
            }
        }
        // Another one that is full is found at its next message.
        if let Some(id) = full {
            self.cut_off(id, DropReason::Backlog);
        }
        Ok(())
    }

    /// One write: all that is due to one client. Its buffer is swapped, so that neither is allocated anew.
    pub(crate) fn poll_transmit(&mut self, out: &mut Vec<u8>) -> Option<ClientId> {
        let client = self.clients.iter_mut().find(|client| !client.out.is_empty())?;
        out.clear();
        core::mem::swap(out, &mut client.out);
        Some(client.id)
    }

    fn client(&mut self, id: ClientId) -> Option<&mut Client> {
        self.clients.iter_mut().find(|client| client.id == id)
    }
}

/// What is wrong with a reserved field, which "must be empty or 0" (SPI 7.3, 7.10, 7.11); a comma in
/// the text of a BPTOP spills into it. Decoding skips it.
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
