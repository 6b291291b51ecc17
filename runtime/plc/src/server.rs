//! The server side of the protocol: who is connected, what each client gets, the controller's clock and its alarms.
//!
//! Every part of the controller sends through the server.

mod clients;
mod ignored;

use std::collections::BTreeMap;

use backseat_s7k::plc::{Alarm, CommandId, Status};
use backseat_s7k::record::{Acknowledge, AlarmMode, CommandStatus, MessageHeader, MessageType, TimeMessage};
use backseat_s7k::{DeviceId, FRAME_LIMIT, FrameHeader, FrameWriter, Reserved, SensorIndex, Time7k};
use backseat_units::{Timestamp, Utc};
use backseat_world::Stream;

use crate::clock::Clock;
use crate::config::PlcConfig;
use crate::event::{ClientId, DropReason, Log, PlcEvent, PlcEventKind};
use crate::interpretation::{ClientAlarms, EventAlarmMode, InterpretationConfig};

use crate::sonar::SensorKind;
use clients::{Clients, Weight};

pub(crate) use clients::{Received, Request};
pub use ignored::Ignored;

/// Seconds between UTC and atomic time, since 2017.
const LEAP_SECONDS: i8 = 37;

/// The greatest number of an alarm in Table 18.
pub(crate) const ALARM_MAX: i32 = 15;

/// The clients with the bytes that wait for them, the clock, the alarms and the log.
#[derive(Debug)]
pub(crate) struct Server {
    pub(crate) clients: Clients,
    pub(crate) clock: Clock,
    reading: InterpretationConfig,
    /// The active alarms by number and sensor; -1 is the controller.
    active: BTreeMap<(i32, i32), Alarm>,
    log: Log,
    /// How many records of each type and device there were.
    counts: BTreeMap<(u32, DeviceId), u32>,
    version: u16,
    wrong_checksum_chance: f64,
    dice: Stream,
    /// The record being composed, to keep its memory.
    scratch: Vec<u8>,
}

impl Server {
    pub(crate) fn new(config: &PlcConfig, reading: InterpretationConfig, seed: u64, utc: Utc) -> Self {
        let mut stream = Stream::new(seed, "plc clock");
        let offset_s = config.clock_offset_s.draw(&mut stream);
        let drift_ppm = config.clock_drift_ppm.draw(&mut stream);
        Self {
            clients: Clients::new(config, &reading),
            clock: Clock::new(utc, offset_s, drift_ppm),
            reading,
            active: BTreeMap::new(),
            log: Log::default(),
            counts: BTreeMap::new(),
            version: config.protocol_version,
            wrong_checksum_chance: 0.0,
            dice: Stream::new(seed, "plc link"),
            scratch: Vec::new(),
        }
    }

    pub(crate) fn connect(&mut self, now: Timestamp, client: ClientId) {
        if self.clients.connect(client) {
            self.note(now, PlcEventKind::Connected(client));
        } else {
            self.cut_off(now, client, DropReason::TooMany);
        }
    }

    pub(crate) fn disconnect(&mut self, now: Timestamp, client: ClientId) {
        self.report_rest(now, client);
        if self.clients.disconnect(client) {
            self.note(now, PlcEventKind::Disconnected(client));
        }
    }

    /// Closes a client's connection. What waits for it is lost, but not at a shutdown.
    pub(crate) fn cut_off(&mut self, now: Timestamp, client: ClientId, why: DropReason) {
        self.report_rest(now, client);
        self.clients.cut_off(client, why == DropReason::ShutDown);
        self.note(now, PlcEventKind::Dropped(client, why));
    }

    pub(crate) fn cut_off_all(&mut self, now: Timestamp, why: DropReason) {
        while let Some(client) = self.clients.first() {
            self.cut_off(now, client, why);
        }
    }

    pub(crate) fn note(&mut self, at: Timestamp, kind: PlcEventKind) {
        self.log.note(at, kind);
    }

    pub(crate) fn poll_event(&mut self) -> Option<PlcEvent> {
        self.log.poll()
    }

    pub(crate) fn set_wrong_checksum_chance(&mut self, chance: f64) {
        self.wrong_checksum_chance = chance;
    }

    /// The time on the controller's clock.
    pub(crate) fn time(&self, now: Timestamp) -> Time7k {
        Time7k::from_utc(self.clock.utc(now))
    }

    /// Reports what of a client could not be read or was lost, at most once a second.
    pub(crate) fn report(&mut self, now: Timestamp, client: ClientId) {
        for kind in self.clients.reports(now, client) {
            self.note(now, kind);
        }
    }

    /// When the next report is due of what waits for its second to be over.
    pub(crate) fn report_due(&self) -> Option<Timestamp> {
        self.clients.report_due()
    }

    /// Reports what waits for its second to be over, and is due.
    pub(crate) fn report_all(&mut self, now: Timestamp) {
        for client in self.clients.all() {
            self.report(now, client);
        }
    }

    /// Reports all that is left to report of a client whose connection ends.
    fn report_rest(&mut self, now: Timestamp, client: ClientId) {
        for kind in self.clients.reports(Timestamp::MAX, client) {
            self.note(now, kind);
        }
    }

    /// Composes a record.
    pub(crate) fn record(
        &mut self,
        time: Time7k,
        record_type: u32,
        device: DeviceId,
        write: impl FnOnce(&mut FrameWriter<'_>),
    ) -> Vec<u8> {
        let count = self.counts.entry((record_type, device)).or_insert(0);
        let mut header = FrameHeader::new(record_type, device).at(time).counted(*count);
        *count = count.wrapping_add(1);
        if self.version == 5 {
            header = header.version_5();
        }
        let mut out = core::mem::take(&mut self.scratch);
        out.clear();
        let mut frame = FrameWriter::begin(header, &mut out);
        write(&mut frame);
        // Nothing that the controller composes is near this limit: see `SAMPLES_MAX`.
        let fits = frame.finish(FRAME_LIMIT);
        debug_assert!(fits.is_ok(), "{fits:?}");
        out
    }

    /// Gives the memory of a composed record back.
    fn recycle(&mut self, record: Vec<u8>) {
        self.scratch = record;
    }

    /// Falsifies the record's checksum where a fault says so.
    fn falsify(&mut self, record: &mut [u8]) {
        if self.wrong_checksum_chance > 0.0
            && self.dice.uniform() < self.wrong_checksum_chance
            && let Some(last) = record.last_mut()
        {
            *last = last.wrapping_add(1);
        }
    }

    /// Sends a record of a sensor to the clients that subscribed to it.
    pub(crate) fn publish(&mut self, now: Timestamp, sensor: SensorIndex, kind: SensorKind, mut record: Vec<u8>) {
        self.falsify(&mut record);
        for client in self.clients.subscribers(sensor, kind.record_type()) {
            self.clients.send(client, kind.device(), &record, Weight::Data);
            self.report(now, client);
        }
        self.recycle(record);
    }

    fn send(&mut self, now: Timestamp, clients: &[ClientId], mut record: Vec<u8>) {
        self.falsify(&mut record);
        for client in clients {
            self.clients
                .send(*client, DeviceId::UNSPECIFIED, &record, Weight::Message);
            self.report(now, *client);
        }
        self.recycle(record);
    }

    pub(crate) fn acknowledge(
        &mut self,
        now: Timestamp,
        client: ClientId,
        command: CommandId,
        sensor: SensorIndex,
        status: CommandStatus,
    ) {
        let acknowledge = Acknowledge {
            command,
            sensor,
            status,
        };
        let time = self.time(now);
        let record = self.record(time, 11_001, DeviceId::UNSPECIFIED, |frame| {
            acknowledge.write(frame.bytes());
        });
        self.send(now, &[client], record);
    }

    /// Sends a status to a client.
    pub(crate) fn status(&mut self, now: Timestamp, client: ClientId, status: Status) {
        let record = self.status_record(now, &status);
        self.send(now, &[client], record);
        self.note(now, PlcEventKind::Status(Some(client), Box::new(status)));
    }

    /// Sends a status to all clients.
    pub(crate) fn status_to_all(&mut self, now: Timestamp, status: Status) {
        let record = self.status_record(now, &status);
        let clients = self.clients.all();
        self.send(now, &clients, record);
        self.note(now, PlcEventKind::Status(None, Box::new(status)));
    }

    /// Sends a status to all clients so many times, as a fault does. The log has the fault, and not each record.
    pub(crate) fn flood(&mut self, now: Timestamp, status: &Status, records: usize) {
        let clients = self.clients.all();
        for _ in 0..records {
            let record = self.status_record(now, status);
            self.send(now, &clients, record);
        }
    }

    fn status_record(&mut self, now: Timestamp, status: &Status) -> Vec<u8> {
        let mut text = String::new();
        // All values were checked where they came from, so that they can be written.
        let written = status.write(&mut text);
        debug_assert!(written.is_ok(), "{written:?}");
        self.message(now, MessageType::Status, AlarmMode::Unspecified, status.id(), &text)
    }

    fn message(&mut self, now: Timestamp, message: MessageType, mode: AlarmMode, id: i32, text: &str) -> Vec<u8> {
        let header = MessageHeader {
            message,
            mode,
            id,
            bytes: u32::try_from(text.len()).unwrap_or(0),
        };
        let time = self.time(now);
        self.record(time, 11_002, DeviceId::UNSPECIFIED, |frame| {
            header.write(frame.bytes());
            frame.bytes().extend_from_slice(text.as_bytes());
        })
    }

    fn alarm(&mut self, now: Timestamp, clients: &[ClientId], alarm: &Alarm, mode: AlarmMode) {
        let mut text = String::new();
        let written = alarm.write(&mut text);
        debug_assert!(written.is_ok(), "{written:?}");
        let record = self.message(now, MessageType::Alarm, mode, alarm.id(), &text);
        self.send(now, clients, record);
    }

    /// Makes an alarm active, unless it is.
    pub(crate) fn raise(&mut self, now: Timestamp, sensor: SensorIndex, alarm: Alarm) {
        let key = (alarm.id(), sensor.0);
        if self.active.contains_key(&key) {
            return;
        }
        let clients = self.clients.alarmed(alarm.id());
        self.alarm(now, &clients, &alarm, AlarmMode::Active);
        self.note(now, PlcEventKind::Raised(Box::new(alarm.clone())));
        self.active.insert(key, alarm);
    }

    /// Ends an alarm, if it is active. After the last one comes alarm 0.
    pub(crate) fn clear(&mut self, now: Timestamp, id: i32, sensor: SensorIndex) {
        let Some(alarm) = self.active.remove(&(id, sensor.0)) else {
            return;
        };
        let clients = self.clients.alarmed(id);
        self.alarm(now, &clients, &alarm, AlarmMode::Clear);
        self.note(now, PlcEventKind::Cleared(Box::new(alarm)));
        if self.active.is_empty() {
            let clients = self.clients.alarmed(0);
            self.alarm(now, &clients, &Alarm::AllClear {}, AlarmMode::Clear);
        }
    }

    /// Ends the alarms of a sensor that leaves the run list.
    pub(crate) fn clear_sensor(&mut self, now: Timestamp, sensor: SensorIndex) {
        for id in 0..=ALARM_MAX {
            self.clear(now, id, sensor);
        }
    }

    pub(crate) fn is_active(&self, id: i32, sensor: SensorIndex) -> bool {
        self.active.contains_key(&(id, sensor.0))
    }

    /// An alarm without duration, to all clients.
    pub(crate) fn warn(&mut self, now: Timestamp, alarm: Alarm) {
        let clients = self.clients.alarmed(alarm.id());
        self.warn_these(now, &clients, alarm);
    }

    /// An alarm about what one client did.
    pub(crate) fn warn_about(&mut self, now: Timestamp, client: ClientId, alarm: Alarm) {
        let mut clients = self.clients.alarmed(alarm.id());
        if self.reading.client_alarms == ClientAlarms::Own {
            clients.retain(|alarmed| *alarmed == client);
        }
        self.warn_these(now, &clients, alarm);
    }

    fn warn_these(&mut self, now: Timestamp, clients: &[ClientId], alarm: Alarm) {
        let mode = match self.reading.event_alarm_mode {
            EventAlarmMode::Active => AlarmMode::Active,
            EventAlarmMode::Unspecified | EventAlarmMode::Seed => AlarmMode::Unspecified,
        };
        self.alarm(now, clients, &alarm, mode);
        self.note(now, PlcEventKind::Warned(Box::new(alarm)));
    }

    /// Sends the active alarms to a client, a record each, or alarm 0. The client asked for them, so that it gets those
    /// too that it switched off.
    pub(crate) fn report_alarms(&mut self, now: Timestamp, client: ClientId) {
        let active: Vec<Alarm> = self.active.values().cloned().collect();
        for alarm in &active {
            self.alarm(now, &[client], alarm, AlarmMode::Active);
        }
        if active.is_empty() {
            self.alarm(now, &[client], &Alarm::AllClear {}, AlarmMode::Clear);
        }
    }

    /// Sends a time message to all clients.
    pub(crate) fn time_message(&mut self, now: Timestamp) {
        let message = TimeMessage {
            leap_second_offset_s: LEAP_SECONDS,
            pulse_flag: 0,
            port: 0,
            reserved_1: Reserved::default(),
            reserved_2: Reserved::default(),
        };
        let time = self.time(now);
        let record = self.record(time, 7400, DeviceId::UNSPECIFIED, |frame| message.write(frame.bytes()));
        let clients = self.clients.all();
        self.send(now, &clients, record);
    }

    /// Puts random bytes between the records that each client gets.
    pub(crate) fn garbage(&mut self, now: Timestamp, bytes: usize) {
        for client in self.clients.all() {
            let garbage: Vec<u8> = (0..bytes).map(|_| (self.dice.next_u64() & 0xFF) as u8).collect();
            self.clients.insert(client, &garbage);
            self.report(now, client);
        }
    }
}
