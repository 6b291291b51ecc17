//! A 7k client on a plain socket.

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use backseat_s7k::plc::{Alarm, Command, CommandId, Generic, Order, Status};
use backseat_s7k::record::{
    AlarmMode, BluefinRecord, CommandHeader, CommandStatus, MessageType, NavigationField, NavigationFrame,
    NavigationQuality, Record,
};
use backseat_s7k::{
    BluefinChecksum, DeviceId, FRAME_LIMIT, FrameHeader, FrameWriter, NetworkHeader, SensorIndex, StreamItem,
    StreamReader, Time7k,
};
use backseat_suite::eventually;
use backseat_units::Utc;

const SOON: Duration = Duration::from_secs(30);

/// The sonars: index in the default run list, device and record.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sonar {
    index: i32,
    device: DeviceId,
    record_type: u32,
    sample_m: f64,
}

pub(super) const SUB_BOTTOM: Sonar = Sonar {
    index: 0,
    device: DeviceId::SUB_BOTTOM,
    record_type: 3001,
    sample_m: 0.03,
};
pub(super) const LOW: Sonar = Sonar {
    index: 1,
    device: DeviceId::SIDESCAN_LOW,
    record_type: 3000,
    sample_m: 0.03,
};
pub(super) const HIGH: Sonar = Sonar {
    index: 2,
    device: DeviceId::SIDESCAN_HIGH,
    record_type: 3000,
    sample_m: 0.015,
};

/// A ping: its device, its number, and the amplitudes of its first channel.
struct Ping {
    device: DeviceId,
    number: u32,
    amplitudes: Vec<f32>,
}

pub(super) struct Client {
    stream: TcpStream,
    reader: StreamReader,
    open: bool,
    pings: Vec<Ping>,
    acknowledged: Vec<(CommandId, CommandStatus)>,
    statuses: Vec<Status>,
    alarms: Vec<(AlarmMode, Alarm)>,
}

/// Floods until it is dropped.
pub(super) struct Flood {
    ends: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Drop for Flood {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Relaxed);
        let ended = self.thread.take().map(JoinHandle::join);
        assert!(ended.is_none_or(|ended| ended.is_ok()), "the flood has failed");
    }
}

impl Client {
    pub(super) fn connect(address: &str) -> Self {
        let stream = TcpStream::connect(address).expect("the controller listens");
        let short = Some(Duration::from_millis(20));
        stream.set_read_timeout(short).expect("a time that is not zero");
        stream.set_nodelay(true).expect("a socket");
        Self {
            stream,
            reader: StreamReader::default(),
            open: true,
            pings: Vec::new(),
            acknowledged: Vec::new(),
            statuses: Vec::new(),
            alarms: Vec::new(),
        }
    }

    pub(super) fn send(&mut self, record: &[u8]) {
        self.stream.write_all(&enclosed(record)).expect("the controller reads");
    }

    /// The bytes of a command to the controller, as they go onto the wire.
    pub(super) fn command(command: &Command) -> Vec<u8> {
        enclosed(&order(SensorIndex::PLC, &Order::Do(command.clone())))
    }

    pub(super) fn tell(&mut self, command: Command) {
        self.send(&order(SensorIndex::PLC, &Order::Do(command)));
    }

    pub(super) fn set(&mut self, sonar: Sonar, generic: &Generic) {
        let command = Command::generic(generic).expect("a text");
        self.send(&order(SensorIndex(sonar.index), &Order::Do(command)));
    }

    pub(super) fn subscribe(&mut self, sonar: Sonar) {
        self.tell(Command::Subscribe {
            sensor: SensorIndex(sonar.index),
            record_type: sonar.record_type,
        });
    }

    /// Writes these bytes over and over, in a thread, and reads nothing.
    pub(super) fn floods(mut self, bytes: Vec<u8>) -> Flood {
        let ends = Arc::new(AtomicBool::new(false));
        let told = Arc::clone(&ends);
        let short = Some(Duration::from_millis(100));
        self.stream.set_write_timeout(short).expect("a time that is not zero");
        let thread = std::thread::spawn(move || {
            while !told.load(Ordering::Relaxed) {
                // Only whole records, as long as the controller reads.
                match self.stream.write_all(&bytes) {
                    Ok(()) => {}
                    Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
                    Err(_) => return,
                }
            }
        });
        Flood {
            ends,
            thread: Some(thread),
        }
    }

    /// Reads once, and sorts what came.
    fn read(&mut self) {
        let mut buffer = vec![0; 64 * 1024];
        match self.stream.read(&mut buffer) {
            Ok(0) => self.open = false,
            Ok(count) => self.reader.push(&buffer[..count]),
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
            Err(_) => self.open = false,
        }
        while let Some(item) = self.reader.next() {
            let StreamItem::Record(frame) = item else {
                panic!("{item:?}");
            };
            let device = frame.header().device;
            match Record::read(&frame).expect("a record of the format") {
                Record::SideScan(imagery) | Record::SubBottom(imagery) => {
                    let mut amplitudes = Vec::new();
                    if let Some(channel) = imagery.channels().next() {
                        imagery.samples(&channel).amplitudes(&mut amplitudes);
                    }
                    self.pings.push(Ping {
                        device,
                        number: imagery.header.ping,
                        amplitudes,
                    });
                }
                Record::Acknowledge(record, _) => self.acknowledged.push((record.command, record.status)),
                Record::Message(record) if record.header.message == MessageType::Status => {
                    let status = Status::read(record.header.id, &record.text());
                    self.statuses.push(status.expect("a status").expect("its text"));
                }
                Record::Message(record) => {
                    let alarm = Alarm::read(record.header.id, &record.text());
                    self.alarms
                        .push((record.header.mode, alarm.expect("an alarm").expect("its text")));
                }
                Record::Time(..)
                | Record::Bluefin(_)
                | Record::FileHeader(_)
                | Record::Catalog(_)
                | Record::Command(_)
                | Record::Other(_) => {}
            }
        }
    }

    /// Waits for an acknowledgement.
    pub(super) fn answers(&mut self, command: CommandId, status: CommandStatus) {
        eventually(
            SOON,
            || {
                self.read();
                self.acknowledged.contains(&(command, status)).then_some(())
            },
            || format!("{command:?} is not acknowledged with {status:?}"),
        );
    }

    /// Waits for a status.
    pub(super) fn solicits<T>(&mut self, is: impl Fn(&Status) -> Option<T>) -> T {
        let found = eventually(
            SOON,
            || {
                self.read();
                self.statuses.iter().find_map(&is)
            },
            || "the status does not come".to_owned(),
        );
        self.statuses.clear();
        found
    }

    /// Waits for an alarm.
    pub(super) fn alarm(&mut self, is: impl Fn(&Alarm) -> bool) -> (AlarmMode, Alarm) {
        eventually(
            SOON,
            || {
                self.read();
                self.alarms.iter().find(|(_, alarm)| is(alarm)).cloned()
            },
            || "the alarm does not come".to_owned(),
        )
    }

    /// Waits until the controller closes the connection.
    pub(super) fn is_cut_off(&mut self) {
        eventually(
            SOON,
            || {
                self.read();
                (!self.open).then_some(())
            },
            || "still connected".to_owned(),
        );
    }

    fn of(&self, sonar: Sonar) -> impl Iterator<Item = &Ping> {
        self.pings.iter().filter(move |ping| ping.device == sonar.device)
    }

    /// How many pings of a sonar came.
    pub(super) fn count(&self, sonar: Sonar) -> usize {
        self.of(sonar).count()
    }

    /// Waits until so many pings of a sonar have come, and then for one more.
    pub(super) fn hears(&mut self, sonar: Sonar, count: usize) {
        let count = count.max(self.count(sonar) + 1);
        eventually(
            SOON,
            || {
                self.read();
                (self.count(sonar) >= count).then_some(())
            },
            || format!("not {count} pings of {sonar:?}"),
        );
    }

    /// Whether no ping of a sonar is missing.
    pub(super) fn pings_are_in_a_row(&self, sonar: Sonar) -> bool {
        let numbers: Vec<u32> = self.of(sonar).map(|ping| ping.number).collect();
        numbers.windows(2).all(|pair| pair[1] == pair[0] + 1)
    }

    /// The slant range of the greatest amplitude of the last ping, m, and the amplitude.
    pub(super) fn brightest(&self, sonar: Sonar) -> (f64, f32) {
        let ping = self.of(sonar).last().expect("a ping");
        let samples = ping.amplitudes.iter().copied().enumerate();
        let (place, steps) = samples.max_by(|one, other| one.1.total_cmp(&other.1)).expect("samples");
        (place as f64 * sonar.sample_m, steps)
    }
}

fn order(sensor: SensorIndex, order: &Order) -> Vec<u8> {
    let mut text = String::new();
    order.write(&mut text).expect("a text");
    let mut out = Vec::new();
    let mut frame = FrameWriter::begin(FrameHeader::new(11_000, DeviceId::UNSPECIFIED), &mut out);
    CommandHeader {
        sensor,
        command: order.command(),
        action: order.action(),
        bytes: u32::try_from(text.len()).expect("a short text"),
    }
    .write(frame.bytes());
    frame.bytes().extend_from_slice(text.as_bytes());
    frame.finish(FRAME_LIMIT).expect("a short record");
    out
}

/// A record 3100: the vehicle is at this place and so deep, and heads north.
pub(super) fn navigation(latitude_deg: f64, longitude_deg: f64, depth_m: f64) -> Vec<u8> {
    let quality = NavigationField::ALL
        .iter()
        .fold(NavigationQuality::default(), |quality, field| quality.with(*field));
    let frame = NavigationFrame {
        quality,
        latitude_rad: latitude_deg.to_radians(),
        longitude_rad: longitude_deg.to_radians(),
        depth_m,
        ..NavigationFrame::default()
    };
    let mut out = Vec::new();
    let mut writer = FrameWriter::begin(FrameHeader::new(3100, DeviceId::BLUEFIN), &mut out);
    let now = Utc::from_unix_nanos(1_780_000_000_000_000_000);
    let frames = [(Time7k::from_utc(now), frame)];
    BluefinRecord::compose_navigation(0, &frames, BluefinChecksum::WholePacket, writer.bytes()).expect("a frame");
    writer.finish(FRAME_LIMIT).expect("a short record");
    out
}

fn enclosed(record: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    NetworkHeader::new(DeviceId::UNSPECIFIED, 0)
        .enclose(record, 60_000, &mut out)
        .expect("a short record");
    out
}
