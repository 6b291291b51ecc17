//! A plume in the sea, and a vehicle that flies inserts in their order, with transits and leads.

use std::collections::VecDeque;

use backseat_sdk::units::math::{TAU, exp, ln, sin_cos};
use backseat_sdk::units::{EastNorth, LocalFrame, Position};
use backseat_sdk::{Ctd, Event, Navigation, Outcome, Plugin, Request, State, StepInput, Trackcircle};
use backseat_sdk::{EndKind, Ended};
use plume::{Config, Plume};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng as _, SeedableRng as _};

const LEAD_M: f64 = 40.0;
const DEPTH_M: f64 = 15.0;

pub(crate) struct Chance(ChaCha8Rng);

impl Chance {
    pub(crate) fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    pub(crate) fn within(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * ((self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64)
    }

    pub(crate) fn gaussian(&mut self) -> f64 {
        let (sin, _) = sin_cos(TAU * self.within(0.0, 1.0));
        (-2.0 * ln(1.0 - self.within(0.0, 1.0))).sqrt() * sin
    }
}

pub(crate) struct Field {
    pub(crate) centre: EastNorth,
    sigma_m: (f64, f64),
    turn: (f64, f64),
    pub(crate) amplitude_c: f64,
    gradient: EastNorth,
    start: EastNorth,
    spacing_m: f64,
}

impl Field {
    pub(crate) fn drawn(seed: u64) -> Self {
        let mut chance = Chance::new(seed);
        let round = chance.within(0.0, 1.0) < 0.5;
        let first_m = chance.within(60.0, 150.0);
        let second_m = chance.within(60.0, 150.0);
        Self {
            centre: EastNorth::new(chance.within(-290.0, 290.0), chance.within(-240.0, 240.0)),
            sigma_m: (first_m, if round { first_m } else { second_m }),
            turn: sin_cos(chance.within(0.0, TAU)),
            amplitude_c: chance.within(0.5, 2.0),
            gradient: EastNorth::new(chance.within(-4e-4, 4e-4), chance.within(-4e-4, 4e-4)),
            start: EastNorth::new(chance.within(-600.0, 600.0), chance.within(-600.0, 600.0)),
            spacing_m: chance.within(60.0, 80.0),
        }
    }

    fn temperature_c(&self, at: EastNorth) -> f64 {
        let from = at - self.centre;
        let (sin, cos) = self.turn;
        let x = (from.east_m * cos + from.north_m * sin) / self.sigma_m.0;
        let y = (from.north_m * cos - from.east_m * sin) / self.sigma_m.1;
        let slow = self.gradient.east_m * at.east_m + self.gradient.north_m * at.north_m;
        12.0 + slow + self.amplitude_c * exp(-0.5 * (x * x + y * y))
    }
}

pub(crate) fn config(field: &Field) -> Config {
    serde_json::from_value(serde_json::json!({
        "box": { "centre": [42.3, -70.6], "width_m": 600.0, "height_m": 500.0 },
        "line_spacing_m": field.spacing_m,
        "depth_m": DEPTH_M,
        "speed_mps": 1.5,
    }))
    .unwrap()
}

/// What the vehicle flies: waypoints, then the end.
struct Insert {
    tag: u64,
    points: VecDeque<EastNorth>,
}

pub(crate) struct Trial {
    field: Field,
    pub(crate) plugin: Plume,
    frame: LocalFrame,
    chance: Chance,
    now_ns: u64,
    at: EastNorth,
    drift: EastNorth,
    velocity: EastNorth,
    queue: VecDeque<Insert>,
    flying: Option<Insert>,
    pub(crate) events: Vec<Event>,
    pub(crate) control: bool,
    /// Replaces the answer to a request; `None` accepts it.
    pub(crate) answer: fn(&Request, u32) -> Option<State>,
    pub(crate) asked: u32,
    /// Half seconds with none of our legs to fly, between the end of the first leg and the circle.
    pub(crate) gaps: u32,
    pub(crate) circle: Option<Trackcircle>,
    pub(crate) messages: Vec<String>,
    pub(crate) flown: Vec<u64>,
    pub(crate) most_open: usize,
    pub(crate) done: bool,
}

impl Trial {
    pub(crate) fn new(seed: u64) -> Self {
        let field = Field::drawn(seed);
        let plugin = Plume::new(config(&field)).unwrap();
        Self {
            frame: LocalFrame::new(Position::from_deg(42.3, -70.6).unwrap()),
            chance: Chance::new(seed ^ 0x5ea),
            now_ns: 0,
            at: field.start,
            drift: EastNorth::default(),
            velocity: EastNorth::default(),
            queue: VecDeque::new(),
            flying: None,
            events: Vec::new(),
            control: true,
            answer: |_, _| None,
            asked: 0,
            gaps: 0,
            circle: None,
            messages: Vec::new(),
            flown: Vec::new(),
            most_open: 0,
            done: false,
            field,
            plugin,
        }
    }

    pub(crate) fn field(&self) -> &Field {
        &self.field
    }

    pub(crate) fn input(&mut self) -> StepInput {
        let drift_m = 4.0 / (7200.0f64).sqrt();
        let chance = &mut self.chance;
        self.drift = self.drift + EastNorth::new(chance.gaussian(), chance.gaussian()) * drift_m;
        let mut events = std::mem::take(&mut self.events);
        if self.now_ns.is_multiple_of(1_000_000_000) {
            // Measured a short time ago, at the vehicle's position of then.
            let age_s = chance.within(0.0, 0.4);
            let there = self.at - self.velocity * age_s;
            events.push(Event::Ctd(Ctd {
                age_ns: (age_s * 1e9) as u64,
                conductivity: 40_000.0,
                temperature: self.field.temperature_c(there) + 0.02 * chance.gaussian(),
                pressure: 250.0,
            }));
        }
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
                depth: DEPTH_M + 0.1 * chance.gaussian(),
                velocity_east: self.velocity.east_m + 0.01 * chance.gaussian(),
                velocity_north: self.velocity.north_m + 0.01 * chance.gaussian(),
                ..Navigation::default()
            }),
            events,
            ..StepInput::default()
        }
    }

    fn local(&self, position: backseat_sdk::Position) -> EastNorth {
        self.frame.to_local(Position::try_from(position).unwrap())
    }

    pub(crate) fn circle_off_m(&self) -> f64 {
        self.circle.as_ref().map_or(f64::INFINITY, |circle| {
            self.local(circle.centre).distance_m(self.field.centre)
        })
    }

    fn tell(&mut self, tag: u64, state: State) {
        self.events.push(Event::Outcome(Outcome { tag, state }));
    }

    fn take(&mut self, request: &Request) {
        let (tag, points) = match request {
            Request::Trackline(line) => {
                let (start, end) = (self.local(line.start), self.local(line.end));
                let lead = (end - start) * (LEAD_M / start.distance_m(end));
                (line.tag, VecDeque::from([start - lead, end + lead]))
            }
            Request::Trackcircle(circle) => {
                let centre = self.local(circle.centre);
                let entry_deg = circle.entry_angle.unwrap();
                let steps = (circle.orbits * 36.0) as u32;
                let points = (0..=steps)
                    .map(|step| centre.offset(entry_deg + 10.0 * f64::from(step), circle.radius))
                    .collect();
                self.circle = Some(*circle);
                (circle.tag, points)
            }
            Request::Message(text) => {
                assert!(text.len() <= 256);
                self.messages.push(text.clone());
                self.done |= text.ends_with("done");
                return;
            }
            Request::Cancel(tag) => {
                self.queue.retain(|insert| insert.tag != *tag);
                return self.tell(*tag, State::Cancelled);
            }
            other => panic!("{other:?}"),
        };
        assert!(!self.open_tags().contains(&tag), "the same leg is requested twice");
        self.asked += 1;
        match (self.answer)(request, self.asked) {
            Some(state) => {
                if matches!(request, Request::Trackcircle(_)) {
                    self.circle = None;
                }
                self.tell(tag, state);
            }
            None => {
                self.tell(tag, State::Sent);
                self.tell(tag, State::Accepted);
                self.queue.push_back(Insert { tag, points });
            }
        }
        self.most_open = self.most_open.max(self.open_tags().len());
    }

    pub(crate) fn open_tags(&self) -> Vec<u64> {
        self.flying.iter().chain(&self.queue).map(|insert| insert.tag).collect()
    }

    /// Flies for half a second.
    pub(crate) fn fly(&mut self, requests: &[Request]) {
        for request in requests {
            self.take(request);
        }
        let mut left_m = 0.75f64;
        let before = self.at;
        while left_m > 0.0 {
            let Some(insert) = &mut self.flying else {
                match self.queue.pop_front() {
                    Some(next) => {
                        let tag = next.tag;
                        self.flying = Some(next);
                        self.tell(tag, State::Started);
                        continue;
                    }
                    None => {
                        self.gaps += u32::from(!self.flown.is_empty() && self.circle.is_none() && self.control);
                        break;
                    }
                }
            };
            let Some(&point) = insert.points.front() else {
                let tag = insert.tag;
                self.flying = None;
                self.flown.push(tag);
                self.tell(tag, State::Ended(Ended::new(EndKind::Done, "flown")));
                continue;
            };
            // It navigates by its estimated position.
            let believed = self.at + self.drift;
            let way_m = believed.distance_m(point);
            let step_m = left_m.min(way_m);
            self.at = self.at.offset(believed.bearing_deg(point), step_m);
            left_m -= step_m;
            if way_m <= step_m + 1e-9 {
                insert.points.pop_front();
            }
        }
        self.velocity = (self.at - before) * 2.0;
        self.now_ns += 500_000_000;
    }

    pub(crate) fn step(&mut self) {
        let input = self.input();
        let requests = self.plugin.step(&input).unwrap();
        self.fly(&requests);
    }

    /// Runs until the plugin reports that it is done; returns how many seconds that took.
    pub(crate) fn run(&mut self) -> u64 {
        for _ in 0..2 * 3 * 3600 {
            self.step();
            if self.done {
                break;
            }
        }
        self.now_ns / 1_000_000_000
    }
}
