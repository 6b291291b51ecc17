//! A payload controller in a drawn world, with one client and a clock that jumps.

use core::time::Duration;
use std::path::Path;

use backseat_mission::{Layers, Mission};
use backseat_plc::{ClientId, Plc, Pose, SensorKind, Stored};
use backseat_s7k::plc::{Command, Generic, Order};
use backseat_s7k::record::{CommandHeader, Imagery, Record};
use backseat_s7k::{
    DeviceId, FRAME_LIMIT, FrameHeader, FrameWriter, NetworkHeader, SensorIndex, StreamItem, StreamReader,
};
use backseat_scenario::{Scenario, ScenarioError, Soundings};
use backseat_units::{EastNorth, Timestamp};
use backseat_world::World;

/// What every world of these tests needs: a level seabed 40 m deep.
pub(crate) const LEVEL: &str = "
[start]
utc = 2026-11-23T14:00:00Z
[origin]
latitude_deg = 42.35
longitude_deg = -70.70
[[plan]]
kind = \"waypoint\"
at = { east_m = 0, north_m = 50 }
depth_m = 5
speed_mps = 1.5
[seabed]
depth_m = 40
slope = 0
meanders = 0
bottom = \"sand\"
";

/// A scenario with this `world.toml`.
pub(crate) fn scenario(world: &str) -> Result<Scenario, ScenarioError> {
    let original = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/missions/charted");
    let folder = tempfile::tempdir().unwrap();
    for file in ["mission.toml", "fence.geojson"] {
        std::fs::copy(original.join(file), folder.path().join(file)).unwrap();
    }
    std::fs::write(folder.path().join("world.toml"), world).unwrap();
    Scenario::load(&Mission::load(folder.path(), &Layers::default()).unwrap())
}

/// The samples of one ping as a client got them: of each channel, amplitudes in steps of the converter.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Heard {
    pub(crate) channels: Vec<Vec<f32>>,
}

const CLIENT: ClientId = ClientId(1);

/// A controller that works, with a client.
pub(crate) struct Dive {
    plc: Plc,
    soundings: Soundings<World>,
    now: Timestamp,
    reader: StreamReader,
    /// All bytes that the client got.
    pub(crate) bytes: Vec<u8>,
    heard: Vec<Heard>,
}

impl Dive {
    pub(crate) fn new(world: &str, seed: u64) -> Self {
        let scenario = scenario(world).unwrap();
        let utc = scenario.world.start.utc;
        let mut dive = Self {
            plc: scenario.controller(seed, utc, &Stored::default()).unwrap().unwrap(),
            soundings: scenario.soundings(seed).unwrap(),
            now: Timestamp::ZERO,
            reader: StreamReader::default(),
            bytes: Vec::new(),
            heard: Vec::new(),
        };
        dive.run(5.0);
        dive.plc.connect(dive.now, CLIENT);
        dive
    }

    /// The vehicle is so high over the seabed, and heads north.
    pub(crate) fn at(&mut self, at: EastNorth, altitude_m: f64) {
        let pose = Pose {
            at,
            depth_m: 40.0 - altitude_m,
            ..Pose::default()
        };
        self.pose(pose);
    }

    pub(crate) fn pose(&mut self, pose: Pose) {
        self.plc.truth(self.now, pose);
    }

    pub(crate) fn tell(&mut self, command: Command) {
        self.order(SensorIndex::PLC, &Order::Do(command));
    }

    pub(crate) fn set(&mut self, kind: SensorKind, generic: &Generic) {
        self.order(index(kind), &Order::Do(Command::generic(generic).unwrap()));
    }

    fn order(&mut self, sensor: SensorIndex, order: &Order) {
        let mut text = String::new();
        order.write(&mut text).unwrap();
        let mut record = Vec::new();
        let mut frame = FrameWriter::begin(FrameHeader::new(11_000, DeviceId::UNSPECIFIED), &mut record);
        let header = CommandHeader {
            sensor,
            command: order.command(),
            action: order.action(),
            bytes: text.len() as u32,
        };
        header.write(frame.bytes());
        frame.bytes().extend_from_slice(text.as_bytes());
        frame.finish(FRAME_LIMIT).unwrap();
        let mut bytes = Vec::new();
        let network = NetworkHeader::new(DeviceId::UNSPECIFIED, 0);
        network.enclose(&record, 60_000, &mut bytes).unwrap();
        self.plc.receive(self.now, CLIENT, &bytes);
        self.drain();
    }

    /// Subscribes to a sensor that pings for so long, and returns what the client got of it.
    pub(crate) fn listen(&mut self, kind: SensorKind, seconds: f64) -> Vec<Heard> {
        self.tell(Command::Subscribe {
            sensor: index(kind),
            record_type: kind.record_type(),
        });
        self.set(kind, &Generic::Ping { on: true });
        self.run(seconds);
        self.set(kind, &Generic::Ping { on: false });
        self.run(2.0);
        core::mem::take(&mut self.heard)
    }

    fn run(&mut self, seconds: f64) {
        let end = self.now + Duration::from_secs_f64(seconds);
        while let Some(at) = self.plc.poll_timeout().filter(|at| *at <= end) {
            self.now = self.now.max(at);
            self.plc.handle_timeout(self.now, &mut self.soundings);
            self.drain();
        }
        self.now = end;
    }

    fn drain(&mut self) {
        let mut out = Vec::new();
        while self.plc.poll_transmit(&mut out).is_some() {
            self.bytes.extend_from_slice(&out);
            self.reader.push(&out);
        }
        while let Some(item) = self.reader.next() {
            let StreamItem::Record(frame) = item else {
                panic!("{item:?}");
            };
            if let Ok(Record::SideScan(imagery) | Record::SubBottom(imagery)) = Record::read(&frame) {
                self.heard.push(samples(&imagery));
            }
        }
        while self.plc.poll_file().is_some() || self.plc.poll_event().is_some() {}
    }
}

fn samples(imagery: &Imagery<'_>) -> Heard {
    let amplitudes = |channel| {
        let mut out = Vec::new();
        imagery.samples(&channel).amplitudes(&mut out);
        out
    };
    Heard {
        channels: imagery.channels().map(amplitudes).collect(),
    }
}

/// Its place in the default run list.
fn index(kind: SensorKind) -> SensorIndex {
    let place = SensorKind::ALL.into_iter().position(|other| other == kind).unwrap();
    SensorIndex(place as i32)
}

/// For each sample of a channel, the root of the mean square over the pings: speckle averages out.
pub(crate) fn levels(pings: &[Heard], channel: usize) -> Vec<f64> {
    let squares = |sample: usize| {
        let level = |heard: &Heard| f64::from(heard.channels[channel][sample]);
        let square = |heard: &Heard| level(heard) * level(heard);
        (pings.iter().map(square).sum::<f64>() / pings.len() as f64).sqrt()
    };
    (0..pings[0].channels[channel].len()).map(squares).collect()
}
