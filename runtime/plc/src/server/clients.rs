use core::time::Duration;
use std::collections::{BTreeSet, VecDeque};

use backseat_s7k::plc::CommandId;
use backseat_s7k::record::{Action, CommandRecord, Record};
use backseat_s7k::{Checksum, DeviceId, NetworkHeader, SensorIndex, StreamItem, StreamReader};
use backseat_units::Timestamp;

use super::ALARM_MAX;
use super::ignored::Ignored;
use crate::config::PlcConfig;
use crate::event::{ClientId, PlcEventKind};
use crate::interpretation::{AlarmsAtConnect, InterpretationConfig, VerboseAtConnect};

/// Room for messages beyond what data may fill, bytes: a client that reads little data still hears of alarms.
const MESSAGE_ROOM: usize = 64 << 10;

/// The most subscriptions of a client.
const SUBSCRIPTIONS_MAX: usize = 256;

/// The log has at most one line about a client's unusable input, and one about its lost records, in this time.
const REPORT_EVERY: Duration = Duration::from_secs(1);

/// What kind of record is sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Weight {
    /// Sensor data.
    Data,
    /// An acknowledgement, a status, an alarm or a time.
    Message,
}

/// What a client sent.
#[derive(Debug)]
pub(crate) enum Received {
    Command(Request),
    /// A record that is not for the controller, whole.
    Other(Vec<u8>),
}

/// A command as it came.
#[derive(Debug)]
pub(crate) struct Request {
    pub(crate) command: CommandId,
    pub(crate) sensor: SensorIndex,
    pub(crate) action: Action,
    /// Its text; or why the record, whose command can be told, cannot be read.
    pub(crate) text: Result<String, String>,
}

#[derive(Debug)]
struct Client {
    id: ClientId,
    reader: StreamReader,
    /// What it sent while the controller stalls.
    unread: Vec<u8>,
    out: Vec<u8>,
    blocked: bool,
    transmission: u16,
    subscriptions: BTreeSet<(i32, u32)>,
    /// The alarms that it gets, a bit each.
    alarms: u32,
    verbose: bool,
    /// What could not be used, and records that were lost, since the last report; and the bytes that its reader had
    /// skipped then.
    ignored: Ignored,
    skipped: u64,
    lost: u64,
    ignored_from: Timestamp,
    lost_from: Timestamp,
}

impl Client {
    /// Whether anything waits for the next report of what could not be used.
    fn has_ignored(&self) -> bool {
        !self.ignored.is_none() || self.reader.counts().skipped_bytes > self.skipped
    }
}

/// The table of clients.
#[derive(Debug)]
pub(crate) struct Clients {
    clients: Vec<Client>,
    clients_max: usize,
    send_max: usize,
    receive_max: usize,
    record_max: usize,
    packet_max: usize,
    version: u16,
    alarms: u32,
    verbose: bool,
    stalled: bool,
    /// Clients that were cut off and that the driver has not fetched.
    gone: VecDeque<ClientId>,
    /// What is still sent to clients that were cut off.
    unsent: VecDeque<(ClientId, Vec<u8>)>,
    /// Where the next search for something to send begins, so that each client has its turn.
    turn: usize,
}

impl Clients {
    pub(super) fn new(config: &PlcConfig, reading: &InterpretationConfig) -> Self {
        Self {
            clients: Vec::new(),
            clients_max: config.clients_max as usize,
            send_max: config.send_buffer_bytes as usize,
            receive_max: config.receive_buffer_bytes as usize,
            record_max: config.record_max_bytes as usize,
            packet_max: config.packet_size_bytes as usize,
            version: config.protocol_version,
            alarms: match reading.alarms_at_connect {
                AlarmsAtConnect::Off => 0,
                AlarmsAtConnect::On | AlarmsAtConnect::Seed => u32::MAX,
            },
            verbose: reading.verbose_at_connect == VerboseAtConnect::Verbose,
            stalled: false,
            gone: VecDeque::new(),
            unsent: VecDeque::new(),
            turn: 0,
        }
    }

    /// False if there is no room.
    pub(super) fn connect(&mut self, id: ClientId) -> bool {
        self.disconnect(id);
        self.gone.retain(|gone| *gone != id);
        if self.clients.len() >= self.clients_max {
            return false;
        }
        self.clients.push(Client {
            id,
            reader: StreamReader::new(self.record_max),
            unread: Vec::new(),
            out: Vec::new(),
            blocked: false,
            transmission: 0,
            subscriptions: BTreeSet::new(),
            alarms: self.alarms,
            verbose: self.verbose,
            ignored: Ignored::default(),
            skipped: 0,
            lost: 0,
            ignored_from: Timestamp::ZERO,
            lost_from: Timestamp::ZERO,
        });
        true
    }

    /// False if the client is not known.
    pub(super) fn disconnect(&mut self, id: ClientId) -> bool {
        let before = self.clients.len();
        self.clients.retain(|client| client.id != id);
        self.clients.len() < before
    }

    /// Closes a client's connection. With `flush`, what waits for it is still sent, unless its connection takes no bytes.
    pub(super) fn cut_off(&mut self, id: ClientId, flush: bool) {
        if flush
            && let Some(client) = self
                .client(id)
                .filter(|client| !client.blocked && !client.out.is_empty())
        {
            let bytes = core::mem::take(&mut client.out);
            self.unsent.push_back((id, bytes));
        }
        self.disconnect(id);
        // The limit keeps this from growing if the driver never fetches it.
        if self.gone.len() < 1024 {
            self.gone.push_back(id);
        }
    }

    pub(super) fn first(&self) -> Option<ClientId> {
        self.clients.first().map(|client| client.id)
    }

    pub(crate) fn poll_disconnect(&mut self) -> Option<ClientId> {
        self.gone.pop_front()
    }

    pub(crate) fn all(&self) -> Vec<ClientId> {
        self.clients.iter().map(|client| client.id).collect()
    }

    fn client(&mut self, id: ClientId) -> Option<&mut Client> {
        self.clients.iter_mut().find(|client| client.id == id)
    }

    pub(crate) fn set_stalled(&mut self, stalled: bool) {
        self.stalled = stalled;
    }

    pub(crate) fn set_blocked(&mut self, id: ClientId, blocked: bool) {
        if let Some(client) = self.client(id) {
            client.blocked = blocked;
        }
    }

    /// How many bytes the controller takes of a client now.
    pub(crate) fn room(&self, id: ClientId) -> usize {
        let client = self.clients.iter().find(|client| client.id == id);
        client.map_or(0, |client| self.receive_max.saturating_sub(client.unread.len()))
    }

    /// Keeps what a client sends while the controller stalls.
    pub(crate) fn keep(&mut self, id: ClientId, bytes: &[u8]) {
        let room = self.room(id);
        let (kept, lost) = bytes.split_at(room.min(bytes.len()));
        if let Some(client) = self.client(id) {
            client.unread.extend_from_slice(kept);
            client.ignored.bytes += lost.len() as u64;
        }
    }

    /// What a client sent while the controller stalled.
    pub(crate) fn take_unread(&mut self, id: ClientId) -> Vec<u8> {
        self.client(id)
            .map(|client| core::mem::take(&mut client.unread))
            .unwrap_or_default()
    }

    pub(crate) fn push(&mut self, id: ClientId, bytes: &[u8]) {
        if let Some(client) = self.client(id) {
            client.reader.push(bytes);
        }
    }

    /// The next usable thing that a client sent.
    pub(crate) fn next_received(&mut self, id: ClientId) -> Option<Received> {
        let client = self.client(id)?;
        loop {
            let frame = match client.reader.next()? {
                StreamItem::Skipped { why, .. } => {
                    client.ignored.skipped(&why);
                    continue;
                }
                StreamItem::Record(frame) => frame,
            };
            let record_type = frame.header().record_type;
            if let Checksum::Wrong { stored, computed } = frame.checksum() {
                client.ignored.wrong_checksum(record_type, computed, stored);
                continue;
            }
            match (record_type, Record::read(&frame)) {
                // A controller's own messages, as an echo might send them, are ignored.
                (11_001 | 11_002, _) => client.ignored.records += 1,
                (_, Ok(Record::Command(command))) => {
                    let rest = command.rest();
                    let text = if rest.iter().all(|byte| *byte == 0) {
                        Ok(command.text().into_owned())
                    } else {
                        Err(format!(
                            "{} bytes follow the text of {}",
                            rest.len(),
                            command.header.bytes
                        ))
                    };
                    return Some(Received::Command(Request {
                        command: command.header.command,
                        sensor: command.header.sensor,
                        action: command.header.action,
                        text,
                    }));
                }
                (11_000, Err(error)) => match CommandRecord::addressed(&frame) {
                    Some((command, sensor)) => {
                        return Some(Received::Command(Request {
                            command,
                            sensor,
                            action: Action::Unspecified,
                            text: Err(error.to_string()),
                        }));
                    }
                    None => client.ignored.records += 1,
                },
                _ => return Some(Received::Other(frame.bytes().to_vec())),
            }
        }
    }

    /// Counts a record of a client that cannot be used.
    pub(crate) fn count_ignored(&mut self, id: ClientId) {
        if let Some(client) = self.client(id) {
            client.ignored.records += 1;
        }
    }

    /// What is to be reported of a client's unusable input and lost records.
    pub(super) fn reports(&mut self, now: Timestamp, id: ClientId) -> Vec<PlcEventKind> {
        let mut reports = Vec::new();
        let Some(client) = self.client(id) else { return reports };
        let skipped = client.reader.counts().skipped_bytes;
        if client.has_ignored() && now >= client.ignored_from {
            let mut what = Box::new(core::mem::take(&mut client.ignored));
            what.bytes += skipped - client.skipped;
            client.skipped = skipped;
            client.ignored_from = now + REPORT_EVERY;
            reports.push(PlcEventKind::Ignored { client: id, what });
        }
        if client.lost > 0 && now >= client.lost_from {
            let records = core::mem::take(&mut client.lost);
            client.lost_from = now + REPORT_EVERY;
            reports.push(PlcEventKind::Lost { client: id, records });
        }
        reports
    }

    /// When the next report is due.
    pub(super) fn report_due(&self) -> Option<Timestamp> {
        let due = |client: &Client| {
            let ignored = client.has_ignored().then_some(client.ignored_from);
            let lost = (client.lost > 0).then_some(client.lost_from);
            [ignored, lost].into_iter().flatten().min()
        };
        self.clients.iter().filter_map(due).min()
    }

    /// Whether nothing tells where a client's next record begins.
    pub(crate) fn is_astray(&self, id: ClientId) -> bool {
        self.clients
            .iter()
            .any(|client| client.id == id && client.reader.is_astray())
    }

    /// Returns false if the client has too many subscriptions.
    pub(crate) fn subscribe(&mut self, id: ClientId, sensor: SensorIndex, record_type: u32) -> bool {
        let Some(client) = self.client(id) else { return false };
        let key = (sensor.0, record_type);
        if client.subscriptions.len() >= SUBSCRIPTIONS_MAX && !client.subscriptions.contains(&key) {
            return false;
        }
        client.subscriptions.insert(key);
        true
    }

    /// Returns false if there is no such subscription.
    pub(crate) fn unsubscribe(&mut self, id: ClientId, sensor: SensorIndex, record_type: u32) -> bool {
        self.client(id)
            .is_some_and(|client| client.subscriptions.remove(&(sensor.0, record_type)))
    }

    /// Withdraws all subscriptions to a sensor that leaves the run list.
    pub(crate) fn forget_sensor(&mut self, sensor: SensorIndex) {
        for client in &mut self.clients {
            client.subscriptions.retain(|(index, _)| *index != sensor.0);
        }
    }

    pub(super) fn subscribers(&self, sensor: SensorIndex, record_type: u32) -> Vec<ClientId> {
        let subscribed = |client: &&Client| client.subscriptions.contains(&(sensor.0, record_type));
        self.clients.iter().filter(subscribed).map(|client| client.id).collect()
    }

    /// Switches an alarm for a client; false if there is no alarm of this number.
    pub(crate) fn switch_alarm(&mut self, id: ClientId, alarm: i32, on: bool) -> bool {
        if !(0..=ALARM_MAX).contains(&alarm) {
            return false;
        }
        if let Some(client) = self.client(id) {
            let bit = 1 << alarm;
            client.alarms = if on { client.alarms | bit } else { client.alarms & !bit };
        }
        true
    }

    /// The clients that get this alarm.
    pub(super) fn alarmed(&self, alarm: i32) -> Vec<ClientId> {
        let on = |client: &&Client| client.alarms >> alarm & 1 == 1;
        self.clients.iter().filter(on).map(|client| client.id).collect()
    }

    pub(crate) fn set_verbose(&mut self, id: ClientId, verbose: bool) {
        if let Some(client) = self.client(id) {
            client.verbose = verbose;
        }
    }

    pub(crate) fn is_verbose(&self, id: ClientId) -> bool {
        self.clients.iter().any(|client| client.id == id && client.verbose)
    }

    /// Sends a record to a client, or counts it as lost if too much waits for the client.
    pub(super) fn send(&mut self, id: ClientId, source: DeviceId, record: &[u8], weight: Weight) {
        let (packet_max, version) = (self.packet_max, self.version);
        let limit = match weight {
            Weight::Data => self.send_max,
            Weight::Message => self.send_max + MESSAGE_ROOM,
        };
        let Some(client) = self.client(id) else { return };
        let packets = record
            .len()
            .div_ceil(packet_max.max(NetworkHeader::SIZE + 1) - NetworkHeader::SIZE);
        if client.out.len() + record.len() + packets * NetworkHeader::SIZE > limit {
            client.lost += 1;
            return;
        }
        let header = NetworkHeader {
            version,
            ..NetworkHeader::new(source, client.transmission)
        };
        client.transmission = client.transmission.wrapping_add(1);
        let enclosed = header.enclose(record, packet_max, &mut client.out);
        debug_assert!(enclosed.is_ok(), "{enclosed:?}");
    }

    /// Puts bytes between the records of a client, as far as there is room.
    pub(super) fn insert(&mut self, id: ClientId, bytes: &[u8]) {
        let limit = self.send_max;
        if let Some(client) = self.client(id)
            && client.out.len() + bytes.len() <= limit
        {
            client.out.extend_from_slice(bytes);
        }
    }

    /// One write: all bytes that wait for one client. The buffers are swapped, so that neither is allocated again.
    pub(crate) fn poll_transmit(&mut self, out: &mut Vec<u8>) -> Option<ClientId> {
        let count = self.clients.len();
        if self.stalled {
            return None;
        }
        if let Some((id, bytes)) = self.unsent.pop_front() {
            *out = bytes;
            return Some(id);
        }
        for step in 0..count {
            let at = (self.turn + step) % count;
            let ready = |client: &&mut Client| !client.out.is_empty() && !client.blocked;
            if let Some(client) = self.clients.get_mut(at).filter(ready) {
                self.turn = at + 1;
                out.clear();
                core::mem::swap(out, &mut client.out);
                return Some(client.id);
            }
        }
        None
    }

    /// How many bytes wait for a client.
    pub(crate) fn waiting(&self, id: ClientId) -> usize {
        let client = self.clients.iter().find(|client| client.id == id);
        client.map_or(0, |client| client.out.len())
    }
}
