//! A scripted payload controller, in memory: it reads what the client sends and answers by the specification, unless
//! the test says otherwise.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use backseat_s7k::plc::{Alarm, Command, CommandId, Order, Status};
use backseat_s7k::record::{
    Acknowledge, AlarmMode, BluefinData, CommandRecord, CommandStatus, EnvironmentFrame, MessageHeader, MessageType,
    NavigationFrame, Record,
};
use backseat_s7k::{
    BluefinChecksum, DeviceId, FrameHeader, FrameWriter, NetworkHeader, SensorIndex, StreamItem, StreamReader, Time7k,
};
use backseat_units::Utc;

/// How the controller answers a command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Answer {
    /// Acknowledgement, then the status.
    Normal,
    /// The status, then the acknowledgement.
    StatusFirst,
    /// Nothing, and nothing is done.
    Nothing,
    /// The status alone.
    StatusOnly,
    /// The acknowledgement alone.
    AcknowledgementOnly,
    /// It is rejected.
    Rejected,
    /// It is not known.
    Unknown,
    /// As usual, after so many milliseconds.
    After(u64),
}

pub(crate) struct Controller {
    reader: StreamReader,
    /// Answers to the next commands of a number, in order; then [`Answer::Normal`].
    pub(crate) script: BTreeMap<u32, VecDeque<Answer>>,
    /// Answers to all commands of a number.
    pub(crate) always: BTreeMap<u32, Answer>,
    /// Commands in order, as `id target "text"`.
    pub(crate) heard: Vec<String>,
    /// Frames of navigation with their times, a list a record.
    pub(crate) navigation: Vec<Vec<(Time7k, NavigationFrame)>>,
    pub(crate) environment: Vec<Vec<(Time7k, EnvironmentFrame)>>,
    /// Bytes of the vehicle's records as they came.
    pub(crate) vehicle_bytes: Vec<Vec<u8>>,
    /// How far its clock is from ours.
    pub(crate) offset_nanos: i64,
    pub(crate) verbose: bool,
    pub(crate) logging: bool,
    pub(crate) file: String,
    pub(crate) alarms: Vec<(i32, String)>,
    pub(crate) health: String,
    pub(crate) shut_down: bool,
    pub(crate) tells_shutdown: bool,
}

impl Default for Controller {
    fn default() -> Self {
        Self {
            reader: StreamReader::default(),
            script: BTreeMap::new(),
            always: BTreeMap::new(),
            heard: Vec::new(),
            navigation: Vec::new(),
            environment: Vec::new(),
            vehicle_bytes: Vec::new(),
            offset_nanos: 0,
            verbose: true,
            logging: false,
            file: "D:\\log\\auto.s7k".to_owned(),
            alarms: Vec::new(),
            health: "Sensors: 2, 0, 1, 1, 1".to_owned(),
            shut_down: false,
            tells_shutdown: true,
        }
    }
}

impl Controller {
    pub(crate) fn answer(&mut self, command: CommandId, answers: impl IntoIterator<Item = Answer>) {
        self.script.entry(command.code()).or_default().extend(answers);
    }

    pub(crate) fn time(&self, utc: Utc) -> Time7k {
        Time7k::from_utc(Utc::from_unix_nanos(
            utc.as_unix_nanos().checked_add_signed(self.offset_nanos).unwrap(),
        ))
    }

    /// A new connection.
    pub(crate) fn connected(&mut self) {
        self.reader = StreamReader::default();
    }

    /// Takes what the client sends. Returns what to send back, and after how long.
    pub(crate) fn receive(&mut self, utc: Utc, bytes: &[u8]) -> Vec<(Duration, Vec<u8>)> {
        let mut reader = std::mem::take(&mut self.reader);
        let mut out = Vec::new();
        reader.push(bytes);
        while let Some(item) = reader.next() {
            let StreamItem::Record(frame) = item else {
                panic!("the client sends whole records: {item:?}");
            };
            assert!(matches!(frame.checksum(), backseat_s7k::Checksum::Valid));
            match Record::read(&frame).unwrap() {
                Record::Command(command) => out.extend(self.command(utc, &command)),
                Record::Bluefin(record) => {
                    assert_eq!(frame.header().device, DeviceId::BLUEFIN);
                    self.vehicle_bytes.push(frame.bytes().to_vec());
                    let (mut navigation, mut environment) = (Vec::new(), Vec::new());
                    for frame in record.frames() {
                        assert_eq!(frame.checksum_matches(BluefinChecksum::WholePacket), Some(true));
                        match frame.data {
                            BluefinData::Navigation(data) => navigation.push((frame.header.time, data)),
                            BluefinData::Environment(data) => environment.push((frame.header.time, data)),
                            BluefinData::Other(_) => panic!("a frame of neither kind"),
                        }
                    }
                    if environment.is_empty() {
                        self.navigation.push(navigation);
                    } else {
                        self.environment.push(environment);
                    }
                }
                other => panic!("the client sends commands and vehicle data only: {other:?}"),
            }
        }
        self.reader = reader;
        out
    }

    fn command(&mut self, utc: Utc, record: &CommandRecord<'_>) -> Vec<(Duration, Vec<u8>)> {
        let header = record.header;
        let id = header.command;
        self.heard
            .push(format!("{} {} {:?}", id.code(), header.sensor, record.text()));
        let scripted = self.script.get_mut(&id.code()).and_then(VecDeque::pop_front);
        let answer = scripted
            .or(self.always.get(&id.code()).copied())
            .unwrap_or(Answer::Normal);
        let order = Order::read(id, header.action, &record.text()).unwrap();
        let refused = match answer {
            Answer::Nothing => return Vec::new(),
            Answer::Rejected => Some(CommandStatus::Rejected),
            Answer::Unknown => Some(CommandStatus::Unknown),
            _ => None,
        };
        let delay = match answer {
            Answer::After(millis) => Duration::from_millis(millis),
            _ => Duration::ZERO,
        };
        let mut statuses = Vec::new();
        if refused.is_none() {
            statuses = self.carry_out(utc, &order);
        }
        let status = refused.unwrap_or(CommandStatus::Accepted);
        let acknowledgement = (self.verbose && answer != Answer::StatusOnly)
            .then(|| acknowledgement(self.time(utc), id, header.sensor, status));
        if answer == Answer::AcknowledgementOnly {
            statuses.clear();
        }
        let mut out: Vec<Vec<u8>> = acknowledgement.into_iter().chain(statuses).collect();
        if answer == Answer::StatusFirst {
            out.rotate_left(1);
        }
        out.into_iter().map(|bytes| (delay, bytes)).collect()
    }

    /// Does what a command says. Returns the statuses that it solicits.
    fn carry_out(&mut self, utc: Utc, order: &Order) -> Vec<Vec<u8>> {
        let time = self.time(utc);
        let status = |id: i32, text: &str| vec![message(time, MessageType::Status, AlarmMode::Unspecified, id, text)];
        match order {
            Order::Do(Command::Verbose { on }) => {
                self.verbose = *on;
                Vec::new()
            }
            Order::Do(Command::TimeSync { time }) => {
                let set = time.to_utc().unwrap().as_unix_nanos();
                self.offset_nanos = i64::try_from(i128::from(set) - i128::from(utc.as_unix_nanos())).unwrap();
                Vec::new()
            }
            Order::Do(Command::Version {}) => status(0, "1.0203"),
            Order::Do(Command::Modules {}) => status(1, "Modules: 1, Module = 1, EdgeTech.dll, 1.0100"),
            Order::Do(Command::RunList {}) => status(
                2,
                "Sensors: 2, Sensor = 0, 11001, 1, 5, 0, 20, LF sidescan, Sensor = 1, 11000, 2, 6, 0, 0, SBP",
            ),
            Order::Do(Command::Logging { on }) => {
                self.logging = *on;
                Vec::new()
            }
            Order::Do(Command::Switch { name }) => {
                self.file = format!("D:\\log\\{name}");
                Vec::new()
            }
            Order::Do(Command::ReportLogging {}) => {
                let details = Status::FileDetails {
                    on: self.logging,
                    file: self.file.clone().into_boxed_str(),
                    size_mb: 1.5,
                };
                let mut text = String::new();
                details.write(&mut text).unwrap();
                status(3, &text)
            }
            Order::Get(CommandId::LoggingSetup) => status(5, "LoggingSetup = 100, 10, D:\\log"),
            Order::Do(Command::Health {}) => status(6, &self.health.clone()),
            Order::Do(Command::ReportAlarms {}) => {
                let active =
                    |(id, text): &(i32, String)| message(time, MessageType::Alarm, AlarmMode::Active, *id, text);
                self.alarms.iter().map(active).collect()
            }
            Order::Do(Command::Generic { text }) if &**text == "PulseFiles" => status(4, "PulseFiles: 2, CW, FM 4-24"),
            Order::Do(Command::Shutdown { .. }) => {
                self.shut_down = true;
                if self.tells_shutdown { status(7, "") } else { Vec::new() }
            }
            _ => Vec::new(),
        }
    }
}

/// A record in its network frame.
pub(crate) fn framed(header: FrameHeader, body: &[u8]) -> Vec<u8> {
    enclosed(&record(header, body))
}

pub(crate) fn record(header: FrameHeader, body: &[u8]) -> Vec<u8> {
    let mut record = Vec::new();
    let mut writer = FrameWriter::begin(header, &mut record);
    writer.bytes().extend_from_slice(body);
    writer.finish(64 << 20).unwrap();
    record
}

pub(crate) fn enclosed(record: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    NetworkHeader::new(DeviceId::UNSPECIFIED, 0)
        .enclose(record, 1 << 20, &mut out)
        .unwrap();
    out
}

pub(crate) fn acknowledgement(time: Time7k, command: CommandId, sensor: SensorIndex, status: CommandStatus) -> Vec<u8> {
    let mut body = Vec::new();
    Acknowledge {
        command,
        sensor,
        status,
    }
    .write(&mut body);
    framed(FrameHeader::new(11_001, DeviceId::UNSPECIFIED).at(time), &body)
}

pub(crate) fn message(time: Time7k, message: MessageType, mode: AlarmMode, id: i32, text: &str) -> Vec<u8> {
    let mut body = Vec::new();
    MessageHeader {
        message,
        mode,
        id,
        bytes: u32::try_from(text.len()).unwrap(),
    }
    .write(&mut body);
    body.extend_from_slice(text.as_bytes());
    framed(FrameHeader::new(11_002, DeviceId::UNSPECIFIED).at(time), &body)
}

pub(crate) fn alarm(mode: AlarmMode, alarm: &Alarm) -> Vec<u8> {
    let mut text = String::new();
    alarm.write(&mut text).unwrap();
    message(Time7k::NONE, MessageType::Alarm, mode, alarm.id(), &text)
}
