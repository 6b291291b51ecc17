//! A controller with scripted clients, a plain sonar, a disk in memory, and a clock that jumps.

use core::time::Duration;
use std::collections::BTreeMap;

use backseat_plc::{
    ClientId, FileEffect, FileId, Ping, Plc, PlcConfig, PlcEvent, PlcEventKind, Pose, SensorKind, Sonar, Stored,
};
use backseat_s7k::plc::{Alarm, Command, CommandId, Generic, Order, Status};
use backseat_s7k::record::{
    Acknowledge, Action, AlarmMode, BluefinRecord, CommandHeader, CommandStatus, MessageType, NavigationField,
    NavigationFrame, NavigationQuality, Record,
};
use backseat_s7k::{
    BluefinChecksum, DeviceId, FRAME_LIMIT, Frame, FrameHeader, FrameWriter, NetworkHeader, SensorIndex, StreamItem,
    StreamReader, Time7k,
};
use backseat_units::{Timestamp, Utc};

/// 2026-11-23T14:00:00Z.
pub(crate) const START: Utc = Utc::from_unix_nanos(1_795_442_400_000_000_000);

/// The indices of the default run list.
pub(crate) const SUB_BOTTOM: SensorIndex = SensorIndex(0);
pub(crate) const LOW: SensorIndex = SensorIndex(1);
pub(crate) const HIGH: SensorIndex = SensorIndex(2);
pub(crate) const BLUEFIN: SensorIndex = SensorIndex(3);

pub(crate) const A: ClientId = ClientId(1);
pub(crate) const B: ClientId = ClientId(2);

/// A sonar whose samples say which ping they are of. Too few, or too many, as the controller must expect.
#[derive(Debug, Default)]
pub(crate) struct Counting {
    pub(crate) pings: Vec<(SensorKind, Ping)>,
}

impl Sonar for Counting {
    fn side_scan(&mut self, sensor: SensorKind, ping: &Ping, port: &mut Vec<u16>, starboard: &mut Vec<u16>) {
        assert!(port.is_empty() && starboard.is_empty());
        self.pings.push((sensor, *ping));
        port.extend((0..ping.samples).map(|sample| (sample % 1000) as u16));
        starboard.push(ping.number as u16);
        port.extend([9; 10]);
    }

    fn sub_bottom(&mut self, ping: &Ping, out: &mut Vec<[i16; 2]>) {
        assert!(out.is_empty());
        self.pings.push((SensorKind::SubBottom, *ping));
        out.extend((0..ping.samples).map(|sample| [(sample % 100) as i16, -(ping.number as i16)]));
    }
}

/// What a client got.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Got {
    Acknowledge(CommandId, SensorIndex, CommandStatus),
    Status(Status),
    Alarm(AlarmMode, Alarm),
    Time(Time7k),
    /// Type, device and record count of a record of a sensor.
    Data(u32, DeviceId, u32),
}

pub(crate) struct Rig {
    pub(crate) plc: Plc,
    pub(crate) sonar: Counting,
    pub(crate) now: Timestamp,
    readers: BTreeMap<ClientId, StreamReader>,
    got: BTreeMap<ClientId, Vec<Got>>,
    /// Every record of a sensor that a client got, whole.
    pub(crate) records: BTreeMap<ClientId, Vec<Vec<u8>>>,
    /// All bytes that the controller sent, in order.
    pub(crate) bytes: Vec<u8>,
    pub(crate) skipped_bytes: u64,
    pub(crate) wrong_checksums: u64,
    pub(crate) closed: Vec<ClientId>,
    pub(crate) files: BTreeMap<String, Vec<u8>>,
    pub(crate) effects: Vec<FileEffect>,
    open: BTreeMap<FileId, String>,
    pub(crate) events: Vec<PlcEvent>,
}

impl Rig {
    /// From the table `[plc]`, without its title.
    pub(crate) fn new(table: &str) -> Self {
        Self::with(table, 7, &Stored::default())
    }

    pub(crate) fn with(table: &str, seed: u64, stored: &Stored) -> Self {
        let config: PlcConfig = toml::from_str(table).expect("a table");
        Self::of(Plc::new(&config, seed, START, stored).expect("a controller"))
    }

    pub(crate) fn of(plc: Plc) -> Self {
        let mut rig = Self {
            plc,
            sonar: Counting::default(),
            now: Timestamp::ZERO,
            readers: BTreeMap::new(),
            got: BTreeMap::new(),
            records: BTreeMap::new(),
            bytes: Vec::new(),
            skipped_bytes: 0,
            wrong_checksums: 0,
            closed: Vec::new(),
            files: BTreeMap::new(),
            effects: Vec::new(),
            open: BTreeMap::new(),
            events: Vec::new(),
        };
        rig.drain();
        rig
    }

    /// A controller whose sensors work, with a verbose client A and a pose.
    pub(crate) fn ready(table: &str) -> Self {
        let mut rig = Self::new(table);
        rig.pose();
        rig.run(5.0);
        rig.connect(A);
        rig.tell(A, Command::Verbose { on: true });
        assert_eq!(rig.take(A), [accepted(CommandId::Verbose)]);
        rig
    }

    pub(crate) fn pose(&mut self) {
        let pose = Pose {
            depth_m: 12.0,
            north_mps: 1.5,
            ..Pose::default()
        };
        self.plc.truth(self.now, pose);
    }

    pub(crate) fn connect(&mut self, client: ClientId) {
        self.readers.insert(client, StreamReader::default());
        self.plc.connect(self.now, client);
        self.drain();
    }

    pub(crate) fn disconnect(&mut self, client: ClientId) {
        self.plc.disconnect(self.now, client);
        self.drain();
    }

    /// Sends bytes as they are.
    pub(crate) fn push(&mut self, client: ClientId, bytes: &[u8]) {
        self.plc.receive(self.now, client, bytes);
        self.drain();
    }

    pub(crate) fn tell(&mut self, client: ClientId, command: Command) {
        self.order(client, SensorIndex::PLC, &Order::Do(command));
    }

    pub(crate) fn order(&mut self, client: ClientId, sensor: SensorIndex, order: &Order) {
        let mut text = String::new();
        order.write(&mut text).expect("a text");
        self.text(client, sensor, order.command().code(), order.action(), &text);
    }

    pub(crate) fn generic(&mut self, client: ClientId, sensor: SensorIndex, command: &Generic) {
        self.order(client, sensor, &Order::Do(Command::generic(command).expect("a text")));
    }

    pub(crate) fn text(&mut self, client: ClientId, sensor: SensorIndex, id: u32, action: Action, text: &str) {
        let record = command_record(sensor, id, action, text);
        self.push(client, &enclosed(&record));
    }

    /// What the client got since the last call.
    pub(crate) fn take(&mut self, client: ClientId) -> Vec<Got> {
        self.got.remove(&client).unwrap_or_default()
    }

    /// The alarms that the client got since the last call: mode and alarm.
    pub(crate) fn alarms(&mut self, client: ClientId) -> Vec<(AlarmMode, Alarm)> {
        let got = self.take(client);
        let alarm = |got| {
            if let Got::Alarm(mode, alarm) = got {
                Some((mode, alarm))
            } else {
                None
            }
        };
        got.into_iter().filter_map(alarm).collect()
    }

    /// Lets time pass, in steps of the controller's own timers.
    pub(crate) fn run(&mut self, seconds: f64) {
        let end = self.now + Duration::from_secs_f64(seconds);
        while let Some(at) = self.plc.poll_timeout().filter(|at| *at <= end) {
            self.now = self.now.max(at);
            self.plc.handle_timeout(self.now, &mut self.sonar);
            self.drain();
        }
        self.now = end;
    }

    /// Lets time pass without the controller: the driver sleeps, and wakes late.
    pub(crate) fn sleep(&mut self, seconds: f64) {
        self.now = self.now + Duration::from_secs_f64(seconds);
        self.plc.handle_timeout(self.now, &mut self.sonar);
        self.drain();
    }

    pub(crate) fn drain(&mut self) {
        let mut out = Vec::new();
        while let Some(client) = self.plc.poll_transmit(&mut out) {
            self.bytes.extend_from_slice(&out);
            if let Some(reader) = self.readers.get_mut(&client) {
                reader.push(&out);
            }
            self.read(client);
        }
        while let Some(client) = self.plc.poll_disconnect() {
            self.closed.push(client);
            self.readers.remove(&client);
        }
        while let Some(effect) = self.plc.poll_file() {
            self.carry_out(effect);
        }
        while let Some(event) = self.plc.poll_event() {
            assert!(!event.kind.to_string().is_empty());
            self.events.push(event);
        }
    }

    fn read(&mut self, client: ClientId) {
        let Some(reader) = self.readers.get_mut(&client) else {
            return;
        };
        let got = self.got.entry(client).or_default();
        while let Some(item) = reader.next() {
            let frame = match item {
                StreamItem::Record(frame) => frame,
                StreamItem::Skipped { bytes, .. } => {
                    self.skipped_bytes += bytes as u64;
                    continue;
                }
            };
            if frame.checksum() != backseat_s7k::Checksum::Valid {
                self.wrong_checksums += 1;
            }
            let header = *frame.header();
            #[expect(clippy::wildcard_enum_match_arm, reason = "all others are data")]
            got.push(match Record::read(&frame).expect("a record") {
                Record::Acknowledge(record, _) => {
                    let Acknowledge {
                        command,
                        sensor,
                        status,
                    } = record;
                    Got::Acknowledge(command, sensor, status)
                }
                Record::Message(record) if record.header.message == MessageType::Status => Got::Status(
                    Status::read(record.header.id, &record.text())
                        .expect("a row")
                        .expect("its text"),
                ),
                Record::Message(record) => {
                    let alarm = Alarm::read(record.header.id, &record.text())
                        .expect("a row")
                        .expect("its text");
                    Got::Alarm(record.header.mode, alarm)
                }
                Record::Time(..) => Got::Time(header.time),
                _ => {
                    self.records.entry(client).or_default().push(frame.bytes().to_vec());
                    Got::Data(header.record_type, header.device, header.record_count)
                }
            });
        }
    }

    fn carry_out(&mut self, effect: FileEffect) {
        self.effects.push(effect.clone());
        match effect {
            FileEffect::Open { file, place, replace } => {
                let place = place.to_string();
                let before = self.files.insert(place.clone(), Vec::new());
                assert!(before.is_none() || replace, "{place}");
                assert!(self.open.insert(file, place).is_none());
            }
            FileEffect::Append { file, bytes } => self.file(file).extend_from_slice(&bytes),
            FileEffect::Patch { file, at, bytes } => {
                let at = at as usize;
                self.file(file)[at..at + bytes.len()].copy_from_slice(&bytes);
            }
            FileEffect::Truncate { file, length } => self.file(file).truncate(length as usize),
            FileEffect::Close { file } => assert!(self.open.remove(&file).is_some()),
        }
    }

    fn file(&mut self, file: FileId) -> &mut Vec<u8> {
        self.files.get_mut(&self.open[&file]).expect("an open file")
    }

    pub(crate) fn open_files(&self) -> Vec<&str> {
        self.open.values().map(String::as_str).collect()
    }

    pub(crate) fn has_event(&self, kind: &PlcEventKind) -> bool {
        self.events.iter().any(|event| event.kind == *kind)
    }
}

pub(crate) fn command_record(sensor: SensorIndex, id: u32, action: Action, text: &str) -> Vec<u8> {
    let mut out = Vec::new();
    let mut frame = FrameWriter::begin(FrameHeader::new(11_000, DeviceId::UNSPECIFIED), &mut out);
    CommandHeader {
        sensor,
        command: CommandId::from(id),
        action,
        bytes: text.len() as u32,
    }
    .write(frame.bytes());
    frame.bytes().extend_from_slice(text.as_bytes());
    frame.finish(FRAME_LIMIT).expect("a short record");
    out
}

/// A record 3100 with a second of navigation: heading 90 degrees, 12.34 m deep, at 42 degrees north, 70 west.
pub(crate) fn navigation_record() -> Vec<u8> {
    let quality = NavigationField::ALL
        .iter()
        .fold(NavigationQuality::default(), |quality, field| quality.with(*field));
    let frame = NavigationFrame {
        quality,
        latitude_rad: 42_f64.to_radians(),
        longitude_rad: (-70_f64).to_radians(),
        depth_m: 12.34,
        yaw_rad: core::f32::consts::FRAC_PI_2,
        pitch_rad: -0.1,
        roll_rad: 0.2,
        ..NavigationFrame::default()
    };
    let time = Time7k::from_utc(START);
    let mut out = Vec::new();
    let mut writer = FrameWriter::begin(FrameHeader::new(3100, DeviceId::BLUEFIN).at(time), &mut out);
    let frames = vec![(time, frame); 25];
    BluefinRecord::compose_navigation(0, &frames, BluefinChecksum::WholePacket, writer.bytes()).expect("25 frames");
    writer.finish(FRAME_LIMIT).expect("a short record");
    out
}

pub(crate) fn enclosed(record: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    NetworkHeader::new(DeviceId::UNSPECIFIED, 0)
        .enclose(record, 60_000, &mut out)
        .expect("a short record");
    out
}

pub(crate) fn frame(bytes: &[u8]) -> Frame<'_> {
    Frame::read(bytes, FRAME_LIMIT).expect("a record")
}

pub(crate) fn accepted(command: CommandId) -> Got {
    Got::Acknowledge(command, SensorIndex::PLC, CommandStatus::Accepted)
}

pub(crate) fn rejected(command: CommandId) -> Got {
    Got::Acknowledge(command, SensorIndex::PLC, CommandStatus::Rejected)
}

/// Alarm 14 as client A gets it.
pub(crate) fn invalid(command: u32, description: &str) -> Got {
    Got::Alarm(
        AlarmMode::Unspecified,
        Alarm::InvalidCommand {
            client: 1,
            command: command.cast_signed(),
            description: Box::from(description),
        },
    )
}
