//! A seabed of varying depth, a sidescan that hears it, and a vehicle that flies inserts in their order at a constant
//! depth, with transits and leads.

use std::collections::VecDeque;

use backseat_acoustics::{Pose, SideScan, SideScanSettings};
use backseat_sdk::units::math::{TAU, ln, sin_cos, wrap_180};
use backseat_sdk::units::{EastNorth, LocalFrame, Position};
use backseat_sdk::{
    AltitudeSource, Decimation, EndKind, Ended, Event, Navigation, Outcome, PingNavigation, PingTime, Plugin, Request,
    SonarChannel, SonarEvent, SonarPing, SonarSetting, SonarSide, State, StepInput, Swath,
};
use backseat_world::World;
use coverage::{Config, Coverage};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng as _, SeedableRng as _};

const LEAD_M: f64 = 25.0;
pub(crate) const DEPTH_M: f64 = 15.0;
const SPEED_MPS: f64 = 1.8;
const SENSOR: i32 = 2;
const BINS: u32 = 256;
/// The area that all trials survey: half of its length to the east and of its width to the north.
pub(crate) const HALF: EastNorth = EastNorth::new(400.0, 300.0);
const CENTRE: (f64, f64) = (42.3, -70.6);
/// Half of the angle straight below the vehicle that no beam sees, degrees.
const NADIR_DEG: f64 = 32.5;

struct Chance(ChaCha8Rng);

impl Chance {
    fn within(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * ((self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64)
    }

    fn gaussian(&mut self) -> f64 {
        let (sin, _) = sin_cos(TAU * self.within(0.0, 1.0));
        (-2.0 * ln(1.0 - self.within(0.0, 1.0))).sqrt() * sin
    }
}

pub(crate) fn config() -> serde_json::Value {
    serde_json::json!({
        "area": { "centre": [CENTRE.0, CENTRE.1], "length_m": 2.0 * HALF.east_m, "width_m": 2.0 * HALF.north_m, "bearing_deg": 90.0 },
        "lines_deg": 90.0,
        "sensor": SENSOR,
        "range_m": 75.0,
        "first_altitude_m": 25.0,
        "depth_m": DEPTH_M,
        "speed_mps": SPEED_MPS,
    })
}

pub(crate) fn plugin(config: serde_json::Value) -> Coverage {
    let config: Config = serde_json::from_value(config).unwrap();
    Coverage::new(config).unwrap().with_fence(|_| None)
}

fn world(seed: u64, seabed: &str) -> World {
    let text = format!(
        "[origin]\nlatitude_deg = {}\nlongitude_deg = {}\n[seabed]\n{seabed}\n",
        CENTRE.0, CENTRE.1
    );
    World::new(&toml::from_str(&text).unwrap(), seed).unwrap()
}

/// A shelf with banks: 15 to 50 m below the vehicle.
pub(crate) const SHELF: &str = "depth_m = [40, 50]\nslope = [0.01, 0.03]\nmeanders = 2\nmeander_slope = 0.01\nbanks = 4\n\
    bank_height_m = [5, 14]\nbank_radius_m = [60, 150]\nbank_east_m = [-400, 400]\nbank_north_m = [-300, 300]\ndepth_min_m = 25";

/// A slope across the lines: 10 to 60 m below the vehicle.
pub(crate) const SLOPE: &str = "depth_m = [42, 52]\nslope = [0.04, 0.06]\ndownslope_deg = [-20, 20]\nmeanders = 3\n\
    meander_slope = 0.015\nmeander_wavelength_m = [500, 1500]\ndepth_min_m = 25";

/// What the vehicle flies: waypoints, then the end.
struct Insert {
    tag: u64,
    points: VecDeque<EastNorth>,
}

/// What the sonar gives to the plugin.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Gives {
    Pings,
    /// The runtime's reports of the swath alone.
    Swaths,
    Nothing,
}

pub(crate) struct Trial {
    pub(crate) plugin: Coverage,
    world: World,
    sonar: SideScan,
    frame: LocalFrame,
    chance: Chance,
    now_ns: u64,
    at: EastNorth,
    /// Error of navigation.
    drift: EastNorth,
    velocity: EastNorth,
    heading_deg: f64,
    queue: VecDeque<Insert>,
    flying: Option<Insert>,
    pub(crate) events: Vec<Event>,
    pub(crate) control: bool,
    /// Replaces the answer to a request; `None` accepts it.
    pub(crate) answer: fn(&Request, u32) -> Option<State>,
    /// What the sonar gives.
    pub(crate) gives: Gives,
    pub(crate) asked: u32,
    pub(crate) settings: Vec<SonarSetting>,
    pub(crate) lines: Vec<(EastNorth, EastNorth)>,
    /// Seconds with none of our lines to fly, after the first one.
    pub(crate) gaps: u32,
    pub(crate) messages: Vec<String>,
    pub(crate) most_open: usize,
    pub(crate) way_m: f64,
    pub(crate) done: bool,
    pub(crate) range_m: f64,
    pub(crate) power: f64,
    ping: u32,
    buffers: (Vec<u16>, Vec<u16>),
    seen: Vec<bool>,
}

/// The side of a cell of the truth, metres.
const CELL_M: f64 = 4.0;

impl Trial {
    pub(crate) fn new(seed: u64, seabed: &str, plugin: Coverage) -> Self {
        let world = world(seed, seabed);
        let mut chance = Chance(ChaCha8Rng::seed_from_u64(seed ^ 0x5ea));
        let cells = (2.0 * HALF.east_m / CELL_M) * (2.0 * HALF.north_m / CELL_M);
        Self {
            plugin,
            sonar: SideScan::new(&world, seed, "high"),
            world,
            frame: LocalFrame::new(Position::from_deg(CENTRE.0, CENTRE.1).unwrap()),
            now_ns: 0,
            at: EastNorth::new(chance.within(-700.0, 700.0), chance.within(-600.0, 600.0)),
            drift: EastNorth::default(),
            velocity: EastNorth::default(),
            heading_deg: 0.0,
            queue: VecDeque::new(),
            flying: None,
            events: Vec::new(),
            control: true,
            answer: |_, _| None,
            gives: Gives::Pings,
            asked: 0,
            settings: Vec::new(),
            lines: Vec::new(),
            gaps: 0,
            messages: Vec::new(),
            most_open: 0,
            way_m: 0.0,
            done: false,
            range_m: 75.0,
            power: 100.0,
            ping: 0,
            buffers: (Vec::new(), Vec::new()),
            seen: vec![false; cells as usize],
            chance,
        }
    }

    fn altitude_m(&self, at: EastNorth) -> f64 {
        self.world.water_depth_m(at) - DEPTH_M
    }

    pub(crate) fn input(&mut self) -> StepInput {
        let drift_m = 2.0 / (7200.0f64).sqrt();
        self.drift = self.drift + EastNorth::new(self.chance.gaussian(), self.chance.gaussian()) * drift_m;
        let mut events = std::mem::take(&mut self.events);
        match self.gives {
            Gives::Pings => events.extend([500_000_000, 0].map(|age_ns| Event::Sidescan(self.ping(age_ns)))),
            Gives::Swaths => events.push(self.swath()),
            Gives::Nothing => {}
        }
        self.see();
        let age_s = 0.1;
        let seen = self.at + self.drift - self.velocity * age_s;
        StepInput {
            now_ns: self.now_ns,
            control: self.control,
            navigation: Some(Navigation {
                age_ns: (age_s * 1e9) as u64,
                position: self.frame.to_position(seen).into(),
                east: seen.east_m + 1000.0,
                north: seen.north_m - 500.0,
                depth: DEPTH_M,
                altitude: Some(self.altitude_m(self.at)),
                heading: self.heading_deg,
                velocity_east: self.velocity.east_m + 0.01 * self.chance.gaussian(),
                velocity_north: self.velocity.north_m + 0.01 * self.chance.gaussian(),
                ..Navigation::default()
            }),
            events,
            ..StepInput::default()
        }
    }

    /// A ping of some time ago.
    fn ping(&mut self, age_ns: u64) -> SonarPing {
        self.ping += 1;
        let there = self.at - self.velocity * (age_ns as f64 * 1e-9);
        let altitude_m = self.altitude_m(there);
        let settings = SideScanSettings {
            frequency_hz: 410e3,
            range_m: self.range_m,
            pulse_s: 50e-6,
            power: self.power / 100.0,
            gain_db: 0.0,
            samples: BINS,
            sound_speed_mps: 1500.0,
        };
        let pose = Pose {
            at: there,
            depth_m: DEPTH_M,
            altitude_m,
            heading_deg: self.heading_deg,
            pitch_deg: 0.0,
            roll_deg: 0.0,
        };
        let (port, starboard) = &mut self.buffers;
        self.sonar
            .ping(&self.world, &pose, &settings, self.ping, port, starboard);
        let channel = |side, samples: &[u16]| SonarChannel {
            side,
            ground_range: false,
            range: self.range_m,
            start_ns: 0,
            sample_ns: self.range_m / f64::from(BINS) / 750.0 * 1e9,
            recorded: BINS,
            volts_per_step: Some(1.0 / 4096.0),
            samples: samples.iter().map(|sample| f32::from(*sample)).collect(),
        };
        let seen = there + self.drift;
        SonarPing {
            age_ns,
            time_source: PingTime::Measured,
            sensor: SENSOR,
            number: self.ping,
            decimation: Decimation::Mean,
            channels: vec![channel(SonarSide::Port, port), channel(SonarSide::Starboard, starboard)],
            navigation: Some(PingNavigation {
                before_ping_ns: 50_000_000,
                position: self.frame.to_position(seen).into(),
                east: seen.east_m,
                north: seen.north_m,
                depth: DEPTH_M,
                altitude: Some(altitude_m),
                heading: self.heading_deg,
                roll: 0.0,
                pitch: 0.0,
                velocity_east: None,
                velocity_north: None,
            }),
        }
    }

    fn swath(&self) -> Event {
        let altitude_m = self.altitude_m(self.at);
        let reach_m = (self.range_m * self.range_m - altitude_m * altitude_m).max(0.0).sqrt();
        Event::Sonar(SonarEvent::Swath(Swath {
            sensor: SENSOR,
            number: self.ping,
            port: reach_m,
            starboard: reach_m,
            altitude: Some(altitude_m),
            source: AltitudeSource::BottomLock,
        }))
    }

    /// Flies lines in their order, without the plugin.
    pub(crate) fn mow(&mut self, lines: impl IntoIterator<Item = (EastNorth, EastNorth)>) {
        for (tag, (start, end)) in (1..).zip(lines) {
            let lead = (end - start) * (LEAD_M / start.distance_m(end));
            self.lines.push((start, end));
            self.queue.push_back(Insert {
                tag,
                points: [start - lead, end + lead].into(),
            });
        }
        while !self.queue.is_empty() || self.flying.is_some() {
            self.see();
            self.fly(&[]);
            self.events.clear();
        }
    }

    /// Marks the cells abeam that the sonar truly sees now: within its range along the slant, over the true seabed.
    fn see(&mut self) {
        if self.power == 0.0 {
            return;
        }
        let (sin, cos) = sin_cos(self.heading_deg.to_radians());
        let (below_m, half_m) = (self.altitude_m(self.at), 0.5 * SPEED_MPS + 0.1);
        let gap_m = below_m * (sin_cos(NADIR_DEG.to_radians()).0 / sin_cos(NADIR_DEG.to_radians()).1);
        let columns = (2.0 * HALF.east_m / CELL_M) as usize;
        for index in 0..self.seen.len() {
            let middle = |cell: usize, half_m: f64| (cell as f64 + 0.5) * CELL_M - half_m;
            let cell = EastNorth::new(
                middle(index % columns, HALF.east_m),
                middle(index / columns, HALF.north_m),
            );
            let from = cell - self.at;
            let (ahead_m, out_m) = (
                from.east_m * sin + from.north_m * cos,
                (from.east_m * cos - from.north_m * sin).abs(),
            );
            if ahead_m.abs() <= half_m && out_m >= gap_m && out_m < self.range_m {
                let down_m = self.altitude_m(cell);
                self.seen[index] |= out_m * out_m + down_m * down_m <= self.range_m * self.range_m;
            }
        }
    }

    /// The part of the area that was truly seen.
    pub(crate) fn part(&self) -> f64 {
        self.seen.iter().filter(|seen| **seen).count() as f64 / self.seen.len() as f64
    }

    fn local(&self, position: backseat_sdk::Position) -> EastNorth {
        self.frame.to_local(Position::try_from(position).unwrap())
    }

    fn tell(&mut self, tag: u64, state: State) {
        self.events.push(Event::Outcome(Outcome { tag, state }));
    }

    fn take(&mut self, request: &Request) {
        let done = || State::Ended(Ended::new(EndKind::Done, "done"));
        match request {
            Request::Trackline(line) => {
                assert!(
                    !self.open_tags().contains(&line.tag),
                    "the same line is requested twice"
                );
                self.asked += 1;
                match (self.answer)(request, self.asked) {
                    Some(state) => self.tell(line.tag, state),
                    None => {
                        let (start, end) = (self.local(line.start), self.local(line.end));
                        let lead = (end - start) * (LEAD_M / start.distance_m(end));
                        self.lines.push((start, end));
                        self.tell(line.tag, State::Sent);
                        self.tell(line.tag, State::Accepted);
                        self.queue.push_back(Insert {
                            tag: line.tag,
                            points: [start - lead, end + lead].into(),
                        });
                    }
                }
                self.most_open = self.most_open.max(self.open_tags().len());
            }
            Request::SonarSet(set) => {
                assert_eq!(set.sensor, SENSOR);
                self.settings.push(set.setting.clone());
                match (self.answer)(request, self.asked) {
                    Some(state) => return self.tell(set.tag, state),
                    None => self.tell(set.tag, done()),
                }
                match set.setting {
                    SonarSetting::Range(range_m) => self.range_m = range_m,
                    SonarSetting::Power(percent) => self.power = percent,
                    _ => panic!("{set:?}"),
                }
            }
            Request::Message(text) => {
                assert!(text.len() <= 256);
                self.done |= text.ends_with("done");
                self.messages.push(text.clone());
            }
            Request::Cancel(tag) => {
                self.queue.retain(|insert| insert.tag != *tag);
                self.tell(*tag, State::Cancelled);
            }
            other => panic!("{other:?}"),
        }
    }

    pub(crate) fn open_tags(&self) -> Vec<u64> {
        self.flying.iter().chain(&self.queue).map(|insert| insert.tag).collect()
    }

    /// Flies for a second.
    pub(crate) fn fly(&mut self, requests: &[Request]) {
        for request in requests {
            self.take(request);
        }
        let mut left_m = SPEED_MPS;
        let before = self.at;
        while left_m > 1e-9 {
            let Some(insert) = &mut self.flying else {
                match self.queue.pop_front() {
                    Some(next) => {
                        self.tell(next.tag, State::Started);
                        self.flying = Some(next);
                        continue;
                    }
                    None => {
                        self.gaps += u32::from(!self.lines.is_empty() && self.control && !self.done);
                        break;
                    }
                }
            };
            let Some(&point) = insert.points.front() else {
                let tag = insert.tag;
                self.flying = None;
                self.tell(tag, State::Ended(Ended::new(EndKind::Done, "flown")));
                continue;
            };
            // It navigates by its estimated position, and turns at 6 degrees a second.
            let believed = self.at + self.drift;
            let way_m = believed.distance_m(point);
            let bearing_deg = believed.bearing_deg(point);
            let turn_deg = wrap_180(bearing_deg - self.heading_deg);
            let step_m = left_m.min(way_m);
            let turned_deg = turn_deg.clamp(-6.0 * step_m / SPEED_MPS, 6.0 * step_m / SPEED_MPS);
            self.heading_deg += turned_deg;
            self.at = self.at.offset(self.heading_deg, step_m.max(0.05));
            left_m -= step_m.max(0.05);
            // Within the turning circle, a point counts as reached.
            if way_m <= step_m + 1.0 || (way_m < 40.0 && turn_deg.abs() > 80.0) {
                insert.points.pop_front();
            }
        }
        self.velocity = self.at - before;
        if !self.lines.is_empty() && !self.done {
            self.way_m += self.at.distance_m(before);
        }
        self.now_ns += 1_000_000_000;
    }

    pub(crate) fn step(&mut self) {
        let input = self.input();
        let requests = self.plugin.step(&input).unwrap();
        self.fly(&requests);
    }

    /// Runs until the plugin reports that it is done, and has flown what it has requested.
    pub(crate) fn run(&mut self) {
        for _ in 0..8 * 3600 {
            self.step();
            if self.done && self.open_tags().is_empty() {
                return;
            }
        }
    }
}
