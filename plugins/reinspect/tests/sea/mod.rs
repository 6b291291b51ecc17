//! A vehicle with a sidescan over a simulated seabed: it flies a lawnmower pattern, and inserted circles between its legs.

use std::collections::VecDeque;

use backseat_acoustics::{Pose as SonarPose, SideScan, SideScanSettings};
use backseat_sdk::units::math::wrap_360;
use backseat_sdk::units::{EastNorth, LocalFrame, Position};
use backseat_sdk::{
    Decimation, EndKind, Ended, Event, Navigation, Outcome, PingNavigation, PingTime, Plugin, Request, SonarChannel,
    SonarPing, SonarSide, State, StepInput, Trackcircle,
};
use backseat_world::{Stream, World};
use reinspect::{Config, Reinspect};

const PINGS_A_STEP: u32 = 4;
const SPEED_MPS: f64 = 1.5;
const ALTITUDE_M: f64 = 9.0;
const SETTINGS: SideScanSettings = SideScanSettings {
    frequency_hz: 410e3,
    range_m: 60.0,
    pulse_s: 25e-6,
    power: 1.0,
    gain_db: 0.0,
    samples: 2000,
    sound_speed_mps: 1500.0,
};

/// Four boxes of 1.2 m or more, and 150 rocks of at most 0.35 m, in 600 x 240 m.
const WORLD: &str = r#"
[origin]
latitude_deg = 42.3
longitude_deg = -70.9
[seabed]
depth_m = 40
slope = 0
meanders = 0
[[targets]]
count = 4
kind = "box"
east_m = [60, 540]
north_m = [10, 230]
length_m = [2, 4]
width_m = [1, 2]
height_m = [1.2, 2]
heading_deg = [0, 360]
strength_db = [-15, -5]
[[targets]]
count = 150
kind = "rock"
east_m = [0, 600]
north_m = [0, 240]
length_m = [0.3, 1.2]
width_m = [0.3, 1.0]
height_m = [0.1, 0.35]
heading_deg = [0, 180]
strength_db = [-30, -15]
"#;

pub(crate) fn config() -> Config {
    serde_json::from_value(serde_json::json!({
        "height_min_m": 0.7,
        "radii_m": [25.0, 20.0, 32.0],
        "altitude_m": ALTITUDE_M,
        "speed_mps": SPEED_MPS,
        "circles_max": 10,
    }))
    .expect("a configuration")
}

/// What the vehicle flies: waypoints.
struct Course {
    tag: Option<u64>,
    points: VecDeque<EastNorth>,
}

pub(crate) struct Trial {
    pub(crate) plugin: Reinspect,
    pub(crate) world: World,
    sonar: SideScan,
    frame: LocalFrame,
    noise: Stream,
    now_ns: u64,
    at: EastNorth,
    heading_deg: f64,
    drift: EastNorth,
    ping: u32,
    plan: VecDeque<Course>,
    inserts: VecDeque<Course>,
    flying: Option<Course>,
    pub(crate) events: Vec<Event>,
    pub(crate) control: bool,
    /// Replaces the answer to a request; `None` accepts it.
    pub(crate) answer: fn(&Trackcircle, u32) -> Option<State>,
    pub(crate) asked: u32,
    pub(crate) circles: Vec<Trackcircle>,
    pub(crate) messages: Vec<String>,
    pub(crate) cancelled: Vec<u64>,
}

impl Trial {
    pub(crate) fn new(seed: u64) -> Self {
        let world = World::new(&toml::from_str(WORLD).expect("it is a world"), seed).expect("it can be drawn");
        // Six legs, 40 m apart: the sidescan sees most of the seabed from two of them.
        let leg = |number: u32| {
            let north_m = 20.0 + 40.0 * f64::from(number);
            let (from_m, to_m) = if number.is_multiple_of(2) {
                (0.0, 600.0)
            } else {
                (600.0, 0.0)
            };
            Course {
                tag: None,
                points: VecDeque::from([EastNorth::new(from_m, north_m), EastNorth::new(to_m, north_m)]),
            }
        };
        Self {
            plugin: Reinspect::new(config()).expect("valid").with_fence(|_| false),
            sonar: SideScan::new(&world, seed, "high"),
            world,
            frame: LocalFrame::new(Position::from_deg(42.3, -70.9).expect("a position")),
            noise: Stream::new(seed, "navigation of the trial"),
            now_ns: 0,
            at: EastNorth::new(-60.0, 20.0),
            heading_deg: 90.0,
            drift: EastNorth::default(),
            ping: 0,
            plan: (0..6).map(leg).collect(),
            inserts: VecDeque::new(),
            flying: None,
            events: Vec::new(),
            control: true,
            answer: |_, _| None,
            asked: 0,
            circles: Vec::new(),
            messages: Vec::new(),
            cancelled: Vec::new(),
        }
    }

    pub(crate) fn local(&self, position: backseat_sdk::Position) -> EastNorth {
        self.frame.to_local(Position::try_from(position).expect("a position"))
    }

    pub(crate) fn open_tags(&self) -> Vec<u64> {
        self.flying
            .iter()
            .chain(&self.inserts)
            .filter_map(|course| course.tag)
            .collect()
    }

    pub(crate) fn is_circling(&self) -> bool {
        self.flying.as_ref().is_some_and(|course| course.tag.is_some())
    }

    fn navigation(&mut self, age_ns: u64, way: EastNorth) -> Navigation {
        let seen = self.at + self.drift + way;
        Navigation {
            age_ns,
            position: self.frame.to_position(seen).into(),
            east: seen.east_m,
            north: seen.north_m,
            depth: 40.0 - ALTITUDE_M,
            altitude: Some(ALTITUDE_M + 0.05 * self.noise.gaussian()),
            heading: wrap_360(self.heading_deg + 0.2 * self.noise.gaussian()),
            ..Navigation::default()
        }
    }

    /// A ping now, with navigation of up to 0.1 s before.
    fn ping(&mut self) {
        self.ping += 1;
        let pose = SonarPose {
            at: self.at,
            depth_m: 40.0 - ALTITUDE_M,
            altitude_m: ALTITUDE_M,
            heading_deg: self.heading_deg,
            pitch_deg: 0.0,
            roll_deg: 0.0,
        };
        let (mut port, mut starboard) = (Vec::new(), Vec::new());
        self.sonar
            .ping(&self.world, &pose, &SETTINGS, self.ping, &mut port, &mut starboard);
        let before_s = 0.1 * self.noise.uniform();
        let velocity = EastNorth::default().offset(self.heading_deg, SPEED_MPS);
        let seen = self.navigation(0, velocity * -before_s);
        let channel = |side, samples: &[u16]| SonarChannel {
            side,
            ground_range: false,
            range: SETTINGS.range_m,
            start_ns: 0,
            sample_ns: 80_000.0,
            recorded: SETTINGS.samples,
            volts_per_step: Some(0.001),
            samples: samples
                .chunks(2)
                .map(|pair| (f32::from(pair[0]) + f32::from(pair[1])) / 2.0)
                .collect(),
        };
        self.events.push(Event::Sidescan(SonarPing {
            age_ns: 0,
            time_source: PingTime::Measured,
            sensor: 2,
            number: self.ping,
            decimation: Decimation::Mean,
            channels: vec![
                channel(SonarSide::Port, &port),
                channel(SonarSide::Starboard, &starboard),
            ],
            navigation: Some(PingNavigation {
                before_ping_ns: (before_s * 1e9) as u64,
                position: seen.position,
                east: seen.east,
                north: seen.north,
                depth: seen.depth,
                altitude: seen.altitude,
                heading: seen.heading,
                roll: 0.0,
                pitch: 0.0,
                velocity_east: Some(velocity.east_m),
                velocity_north: Some(velocity.north_m),
            }),
        }));
    }

    fn tell(&mut self, tag: u64, state: State) {
        self.events.push(Event::Outcome(Outcome { tag, state }));
    }

    fn take(&mut self, request: &Request) {
        match request {
            Request::Trackcircle(circle) => {
                assert!(
                    !self.open_tags().contains(&circle.tag),
                    "the same tag is requested twice"
                );
                self.asked += 1;
                if let Some(state) = (self.answer)(circle, self.asked) {
                    return self.tell(circle.tag, state);
                }
                self.tell(circle.tag, State::Sent);
                self.tell(circle.tag, State::Accepted);
                let centre = self.local(circle.centre);
                let steps = (circle.orbits.abs() * 72.0) as u32;
                let turn_deg = 5.0 * circle.orbits.signum();
                let entry_deg = centre.bearing_deg(self.at);
                let points = (0..=steps)
                    .map(|step| centre.offset(wrap_360(entry_deg + turn_deg * f64::from(step)), circle.radius))
                    .collect();
                self.inserts.push_back(Course {
                    tag: Some(circle.tag),
                    points,
                });
                assert!(self.inserts.len() <= 1, "one at a time");
                self.circles.push(*circle);
            }
            Request::Message(text) => {
                assert!(text.len() <= 256);
                self.messages.push(text.clone());
            }
            Request::Cancel(tag) => {
                self.cancelled.push(*tag);
                self.inserts.retain(|course| course.tag != Some(*tag));
                self.tell(*tag, State::Cancelled);
            }
            other @ (Request::Modify(_)
            | Request::EndModify
            | Request::Trackline(_)
            | Request::GpsHit(_)
            | Request::Topside(_)
            | Request::DvlTrigger(_)
            | Request::Silent(_)
            | Request::Trim(_)
            | Request::Buoyancy(_)
            | Request::Packet(_)
            | Request::Station(_)
            | Request::EndStation
            | Request::SonarAngle(_)
            | Request::Camera(_)
            | Request::Light(_)
            | Request::SonarSet(_)
            | Request::SonarLog(_)
            | Request::Timer(_)) => panic!("{other:?}"),
        }
    }

    /// Moves on for a part of a second. Returns whether there is anything left to fly.
    fn go(&mut self, seconds: f64) -> bool {
        let mut left_m = SPEED_MPS * seconds;
        while left_m > 1e-9 {
            let Some(course) = &mut self.flying else {
                let Some(next) = self.inserts.pop_front().or_else(|| self.plan.pop_front()) else {
                    return false;
                };
                if let Some(tag) = next.tag {
                    self.tell(tag, State::Started);
                }
                self.flying = Some(next);
                continue;
            };
            let Some(&point) = course.points.front() else {
                if let Some(tag) = course.tag {
                    self.tell(tag, State::Ended(Ended::new(EndKind::Done, "flown")));
                }
                self.flying = None;
                continue;
            };
            // It navigates by its estimated position.
            let believed = self.at + self.drift;
            let way_m = believed.distance_m(point);
            if way_m < 0.05 {
                course.points.pop_front();
                continue;
            }
            let step_m = left_m.min(way_m);
            let bearing_deg = believed.bearing_deg(point);
            self.heading_deg = bearing_deg;
            self.at = self.at.offset(bearing_deg, step_m);
            left_m -= step_m;
        }
        true
    }

    /// The input of the next half second. `None` when the survey is over.
    pub(crate) fn input(&mut self) -> Option<StepInput> {
        for _ in 0..PINGS_A_STEP {
            let wander_m = 3.0 / 12_000.0_f64.sqrt();
            self.drift = self.drift + EastNorth::new(self.noise.gaussian(), self.noise.gaussian()) * wander_m;
            if !self.go(0.5 / f64::from(PINGS_A_STEP)) {
                return None;
            }
            self.ping();
        }
        self.now_ns += 500_000_000;
        Some(StepInput {
            now_ns: self.now_ns,
            control: self.control,
            navigation: Some(self.navigation(100_000_000, EastNorth::default())),
            events: std::mem::take(&mut self.events),
            ..StepInput::default()
        })
    }

    pub(crate) fn obey(&mut self, requests: &[Request]) {
        for request in requests {
            self.take(request);
        }
    }

    /// Half a second. Returns whether the survey goes on.
    pub(crate) fn step(&mut self) -> bool {
        let Some(input) = self.input() else { return false };
        let requests = self.plugin.step(&input).expect("a step");
        self.obey(&requests);
        true
    }

    pub(crate) fn run(&mut self) {
        while self.step() {}
    }

    /// Boxes with a circle within a distance of them, and circles without such a box.
    pub(crate) fn score(&self, within_m: f64) -> (usize, usize, usize) {
        let boxes: Vec<EastNorth> = self
            .world
            .targets()
            .iter()
            .filter(|target| target.height_m > 1.0)
            .map(|target| target.at)
            .collect();
        let centres: Vec<EastNorth> = self.circles.iter().map(|circle| self.local(circle.centre)).collect();
        let near =
            |one: &EastNorth, others: &[EastNorth]| others.iter().any(|other| one.distance_m(*other) <= within_m);
        (
            boxes.iter().filter(|at| near(at, &centres)).count(),
            boxes.len(),
            centres.iter().filter(|at| !near(at, &boxes)).count(),
        )
    }
}
