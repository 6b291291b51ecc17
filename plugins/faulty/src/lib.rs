//! A plugin that misbehaves, for tests. Its configuration selects the fault.
//!
//! Until its fault begins it behaves well: each second it requests a modify of 5 s, or station keeping for 5 s.

use backseat_sdk::units::EastNorth;
use backseat_sdk::{
    Description, FRAME_BYTES, FRAMES, Modify, Plugin, Position, Request, StationTarget, StepInput, TEXT_BYTES,
    Trackline, Vertical, fence, log, measures,
};
use serde::Deserialize;
use serde::de::IntoDeserializer as _;
use serde::de::value::Error as NoFault;

mod requests;

use requests::{packet, topside};

/// The plugin's settings, from the mission file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// The fault.
    #[serde(default)]
    pub fault: Fault,
    /// When the fault begins, seconds since the plugin's first step.
    #[serde(default)]
    pub after_s: f64,
    /// Until the fault begins, request station keeping of a hovering vehicle instead of modifies.
    #[serde(default)]
    pub station: bool,
    /// True heading of the modify, degrees.
    #[serde(default)]
    pub heading_deg: f64,
    /// Depth of every request, metres.
    #[serde(default = "default_depth_m")]
    pub depth_m: f64,
    /// Speed of every request, metres per second.
    #[serde(default = "default_speed_mps")]
    pub speed_mps: f64,
    /// The destination of `cross_fence`, metres east in the mission's local frame.
    #[serde(default = "default_target_m")]
    pub target_east_m: f64,
    /// The destination of `cross_fence`, metres north in the mission's local frame.
    #[serde(default = "default_target_m")]
    pub target_north_m: f64,
    /// Its tracklines do not interrupt the current behavior, but are flown after it.
    #[serde(default)]
    pub after_current: bool,
}

fn default_depth_m() -> f64 {
    10.0
}

fn default_speed_mps() -> f64 {
    1.5
}

fn default_target_m() -> f64 {
    20_000.0
}

/// The kinds of faults.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fault {
    /// No fault.
    #[default]
    None,
    /// It panics.
    Trap,
    /// It never returns.
    Loop,
    /// It allocates memory until there is none.
    Grow,
    /// It returns 10,000 requests.
    Flood,
    /// Its values are NaN.
    Nan,
    /// Its values are infinite.
    Infinite,
    /// Its values are the largest that exist.
    Huge,
    /// It requests a trackline that begins at latitude 91.
    #[serde(rename = "latitude_91")]
    Latitude91,
    /// It returns an error.
    Error,
    /// It logs 1,000 lines.
    LogFlood,
    /// It publishes 1,000 values, then one that is not finite, and one under 16 KiB of name.
    PublishFlood,
    /// It requests a message of 16 MiB.
    HugeString,
    /// Its snapshot is 2 MiB.
    BigSnapshot,
    /// It makes one request that would last for a year, and none after that.
    Stale,
    /// It requests opposite headings in the same step, ends them again, and uses one tag for all.
    Contradict,
    /// It requests a trackline to the target and a modify towards it, whatever the fence says.
    CrossFence,
    /// It sends 100 messages to the topside.
    TopsideFlood,
    /// It sends 100 acoustic packets.
    PacketFlood,
    /// It requests 100 GPS hits.
    GpsFlood,
    /// It switches the light 100 times.
    LightFlood,
    /// Its packet has nine frames.
    NineFrames,
    /// Its packet has a frame of 10 KiB.
    LongFrame,
    /// Its packet has no frames.
    NoFrames,
    /// Its message to the topside is a byte too long.
    LongTopside,
    /// Its texts contain the characters that delimit sentences, and a whole sentence.
    ReservedText,
    /// It moves the camera by 1000.
    #[serde(rename = "camera_1000")]
    Camera1000,
    /// It requests what needs the vehicle's permission, without having it: packets, the DVL's trigger, silence under
    /// way, station keeping of a vehicle that does not hover.
    Uninvited,
    /// It calls itself without end.
    Recursion,
}

impl Fault {
    /// All faults by their names in a mission file, so that a test can run each.
    #[must_use]
    pub fn names() -> Vec<String> {
        let refused: Result<Self, NoFault> = Self::deserialize("?".into_deserializer());
        // The error is "unknown variant `?`, expected one of `none`, `trap`, ...", so every second piece is a name.
        let told = refused.err().map(|error| error.to_string()).unwrap_or_default();
        told.split('`').skip(3).step_by(2).map(str::to_owned).collect()
    }
}

/// Calls itself until its stack is full.
#[inline(never)]
fn deeper(calls: u64) -> u64 {
    let room = std::hint::black_box([calls; 64]);
    if std::hint::black_box(calls) == u64::MAX {
        return room[0];
    }
    deeper(calls + 1).max(room[63])
}

/// A plugin that misbehaves.
#[derive(Debug)]
pub struct Faulty {
    config: Config,
    first_ns: Option<u64>,
    /// Whether the fault has begun.
    begun: bool,
    tag: u64,
}

const SECOND_NS: u64 = 1_000_000_000;
/// As many requests in a step as exceed the mission's limits but not the host's.
const FLOOD: usize = 200;
const YEAR_NS: u64 = 365 * 86_400 * SECOND_NS;

impl Plugin for Faulty {
    type Config = Config;

    fn describe() -> Description {
        Description {
            name: "faulty".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            step_period_ns: SECOND_NS,
            topics: vec![],
            grants: vec![],
        }
    }

    fn new(config: Config) -> Result<Self, String> {
        Ok(Self {
            config,
            first_ns: None,
            begun: false,
            tag: 0,
        })
    }

    fn step(&mut self, input: &StepInput) -> Result<Vec<Request>, String> {
        let first_ns = *self.first_ns.get_or_insert(input.now_ns);
        let elapsed_s = input.now_ns.saturating_sub(first_ns) as f64 / 1e9;
        let first_time = !self.begun;
        self.begun = self.config.fault != Fault::None && elapsed_s >= self.config.after_s;
        if !self.begun {
            return Ok(vec![self.steady()]);
        }
        match self.config.fault {
            Fault::None | Fault::BigSnapshot => Ok(vec![self.steady()]),
            Fault::Trap => panic!("faulty was told to panic"),
            Fault::Loop => loop {
                std::hint::black_box(&mut self.tag);
            },
            Fault::Grow => {
                let mut hoard: Vec<Vec<u8>> = Vec::new();
                loop {
                    // A failed allocation aborts.
                    hoard.push(std::hint::black_box(Vec::with_capacity(1 << 20)));
                }
            }
            Fault::Flood => Ok((0..10_000).map(|_| self.steady()).collect()),
            Fault::Nan => Ok(self.figures(f64::NAN)),
            Fault::Infinite => Ok(self.figures(f64::INFINITY)),
            Fault::Huge => Ok(self.figures(f64::MAX)),
            Fault::Latitude91 => {
                let start = Position {
                    latitude: 91.0,
                    longitude: 0.0,
                };
                Ok(vec![self.line(
                    start,
                    Position {
                        latitude: 42.0,
                        longitude: -70.0,
                    },
                )])
            }
            Fault::Error => Err("faulty was told to fail".into()),
            Fault::LogFlood => {
                for line in 0..1_000 {
                    log::info!("line {line}");
                }
                Ok(vec![self.steady()])
            }
            Fault::PublishFlood => {
                for index in 0..1_000 {
                    measures::publish("index", f64::from(index), "");
                }
                measures::publish("index", f64::NAN, "");
                measures::publish(&"Name".repeat(1 << 12), 1.0, "m");
                Ok(vec![self.steady()])
            }
            Fault::HugeString => Ok(vec![Request::Message("x".repeat(16 << 20))]),
            Fault::Stale => {
                let lasting = self.modify(self.config.heading_deg, YEAR_NS);
                Ok(if first_time { vec![lasting] } else { vec![] })
            }
            Fault::Contradict => Ok(self.contradictions()),
            Fault::CrossFence => Ok(self.cross_fence(input)),
            Fault::TopsideFlood => Ok(self.many(|tag| topside(tag, "again"))),
            Fault::PacketFlood => Ok(self.many(|tag| packet(tag, 1, 32))),
            Fault::GpsFlood => {
                let position = input
                    .navigation
                    .map_or(requests::ORIGIN, |navigation| navigation.position);
                Ok(self.many(|tag| requests::gps_hit(tag, position)))
            }
            Fault::LightFlood => Ok(self.many(|tag| requests::light(tag, tag.is_multiple_of(2)))),
            Fault::NineFrames => Ok(vec![packet(self.next_tag(), FRAMES + 1, 1)]),
            Fault::LongFrame => Ok(vec![packet(self.next_tag(), 1, 10 * FRAME_BYTES)]),
            Fault::NoFrames => Ok(vec![packet(self.next_tag(), 0, 0)]),
            Fault::LongTopside => Ok(vec![topside(self.next_tag(), &"x".repeat(TEXT_BYTES + 1))]),
            Fault::ReservedText => Ok(requests::RESERVED
                .iter()
                .flat_map(|text| [topside(self.next_tag(), text), Request::Message((*text).into())])
                .collect()),
            Fault::Camera1000 => Ok(vec![requests::camera(self.next_tag(), 1000)]),
            Fault::Uninvited => Ok(requests::uninvited(|| self.next_tag())),
            Fault::Recursion => Err(format!("{} calls", deeper(1))),
        }
    }

    fn snapshot(&self) -> Vec<u8> {
        if self.begun && self.config.fault == Fault::BigSnapshot {
            return vec![0; 2 << 20];
        }
        let first_ns = self.first_ns.unwrap_or(u64::MAX);
        [first_ns.to_le_bytes(), self.tag.to_le_bytes()].concat()
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), String> {
        let (first_ns, tag) = state.split_first_chunk::<8>().ok_or("no time of the first step")?;
        let tag = tag.try_into().map_err(|_| "no tag")?;
        self.first_ns = Some(u64::from_le_bytes(*first_ns)).filter(|first_ns| *first_ns != u64::MAX);
        self.tag = u64::from_le_bytes(tag);
        Ok(())
    }
}

backseat_sdk::export!(Faulty);

impl Faulty {
    fn next_tag(&mut self) -> u64 {
        self.tag += 1;
        self.tag
    }

    fn steady(&mut self) -> Request {
        if self.config.station {
            return requests::station(self.next_tag(), StationTarget::Here, None);
        }
        self.modify(self.config.heading_deg, 5 * SECOND_NS)
    }

    fn modify(&mut self, heading: f64, duration_ns: u64) -> Request {
        let vertical = Vertical::Depth(self.config.depth_m);
        Request::Modify(Modify {
            tag: self.next_tag(),
            heading,
            vertical,
            speed: self.config.speed_mps,
            duration_ns,
        })
    }

    fn line(&mut self, start: Position, end: Position) -> Request {
        Request::Trackline(Trackline {
            tag: self.next_tag(),
            start,
            end,
            vertical: Vertical::Depth(self.config.depth_m),
            speed: self.config.speed_mps,
            interrupt: !self.config.after_current,
        })
    }

    /// Every kind of request with `value` for all of its values.
    fn figures(&mut self, value: f64) -> Vec<Request> {
        requests::with_figure(value, || self.next_tag())
    }

    /// Many requests of one kind, each with its own tag.
    fn many(&mut self, request: impl Fn(u64) -> Request) -> Vec<Request> {
        (0..FLOOD).map(|_| request(self.next_tag())).collect()
    }

    fn contradictions(&mut self) -> Vec<Request> {
        let vertical = Vertical::Depth(self.config.depth_m);
        let modify = |heading| {
            let (speed, duration_ns) = (self.config.speed_mps, 5 * SECOND_NS);
            Request::Modify(Modify {
                tag: 1,
                heading,
                vertical,
                speed,
                duration_ns,
            })
        };
        vec![
            modify(0.0),
            modify(180.0),
            Request::EndModify,
            modify(90.0),
            Request::Cancel(1),
            Request::Cancel(u64::MAX),
        ]
    }

    fn cross_fence(&mut self, input: &StepInput) -> Vec<Request> {
        let Some(navigation) = &input.navigation else {
            return vec![self.steady()];
        };
        let target = EastNorth::new(self.config.target_east_m, self.config.target_north_m);
        let bearing_deg = navigation.local().bearing_deg(target);
        let line = self.line(navigation.position, navigation.position_of(target));
        match fence::check(&line) {
            Ok(metres) => log::info!("the fence holds by {metres:.1} m"),
            Err(refusal) => log::warn!("the fence says {}", refusal.text),
        }
        vec![line, self.modify(bearing_deg, 5 * SECOND_NS)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_fault_has_a_name() {
        let names = Fault::names();
        assert_eq!(names.first().map(String::as_str), Some("none"));
        assert_eq!(names.last().map(String::as_str), Some("recursion"));
        assert!(names.iter().any(|name| name == "latitude_91"), "{names:?}");
        for name in names {
            let fault: Result<Fault, NoFault> = Fault::deserialize(name.as_str().into_deserializer());
            assert!(fault.is_ok(), "{name}");
        }
    }

    #[test]
    fn it_behaves_until_its_fault_comes() {
        let config = Config {
            fault: Fault::Error,
            after_s: 2.0,
            station: false,
            heading_deg: 45.0,
            depth_m: 10.0,
            speed_mps: 1.5,
            target_east_m: 0.0,
            target_north_m: 0.0,
            after_current: false,
        };
        let mut plugin = Faulty::new(config).unwrap();
        let at = |second: u64| StepInput {
            now_ns: (100 + second) * SECOND_NS,
            ..StepInput::default()
        };
        assert!(plugin.step(&at(0)).is_ok());
        assert!(plugin.step(&at(1)).is_ok());
        assert!(plugin.step(&at(2)).is_err());
    }
}
