use backseat_sdk::sonar::{Detector, Look, Sightings, Verdict};
use backseat_sdk::units::EastNorth;
use backseat_sdk::{
    Description, Event, Grant, Outcome, Plugin, Position, Request, Restored, SonarEvent, SonarPing, StepInput, Topic,
    Topside, Trackcircle, Transport, fence, log, measures,
};
use serde::{Deserialize, Serialize};

use crate::config::Config;
use crate::inspection::{Inspection, Inspections, Turn};

const PERIOD_NS: u64 = 500_000_000;
/// How many objects are kept.
const OBJECTS_MAX: usize = 200;
/// Tags of messages to the topside begin here: those of circles are less.
const TOPSIDE_TAGS: u64 = 1 << 48;

/// Circles what the sidescan shows on the seabed.
#[derive(Debug)]
pub struct Reinspect {
    config: Config,
    state: State,
    /// Whether the fence refuses a request for its geometry.
    misfits: fn(&Request) -> bool,
}

/// The state that a new instance needs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct State {
    detector: Detector,
    sightings: Sightings,
    inspections: Inspections,
    control: bool,
    shut_down: bool,
    cap_told: bool,
    messages: u64,
    pings: u64,
    /// Pings without a place.
    lost_pings: u64,
}

impl Plugin for Reinspect {
    type Config = Config;

    fn describe() -> Description {
        Description {
            name: "reinspect".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            step_period_ns: PERIOD_NS,
            topics: vec![Topic::Sidescan, Topic::Sonar],
            grants: vec![Grant::Insert],
        }
    }

    fn new(config: Config) -> Result<Self, String> {
        config.validate().map_err(|error| error.to_string())?;
        let detector = Detector::new(config.detector).map_err(|error| error.to_string())?;
        let state = State {
            detector,
            sightings: Sightings::new(config.error_m, OBJECTS_MAX),
            inspections: Inspections::default(),
            control: false,
            shut_down: false,
            cap_told: false,
            messages: 0,
            pings: 0,
            lost_pings: 0,
        };
        Ok(Self {
            config,
            state,
            misfits: |request| fence::check(request).is_err(),
        })
    }

    fn step(&mut self, input: &StepInput) -> Result<Vec<Request>, String> {
        let mut requests = Vec::new();
        self.note_control(input.control);
        for event in &input.events {
            match event {
                Event::Sidescan(ping) => self.see(ping),
                Event::Outcome(outcome) => self.hear(outcome, input, &mut requests),
                Event::Restored(restored) => self.note_restored(restored, input.now_ns, &mut requests),
                Event::Sonar(SonarEvent::Ready(ready)) => log::info!("sonar {}", if *ready { "ready" } else { "lost" }),
                Event::Shutdown => {
                    log::info!("power goes off soon: making no more requests");
                    self.state.shut_down = true;
                }
                Event::Sonar(_)
                | Event::SubBottom(_)
                | Event::Control(_)
                | Event::Ctd(_)
                | Event::MissionCommand(_)
                | Event::BehaviorBegan(_)
                | Event::BehaviorEnded(_)
                | Event::Timer(_)
                | Event::LoggingBegan(_)
                | Event::LoggingEnded(_)
                | Event::TopsideMessage(_)
                | Event::DvlTrigger(_)
                | Event::Window(_)
                | Event::Packet(_)
                | Event::Plan(_)
                | Event::Sample(_) => {}
            }
        }
        if let Some(navigation) = input.navigation.as_ref()
            && input.control
            && !self.state.shut_down
        {
            requests.extend(self.circle(navigation.local(), input.now_ns));
        }
        Ok(requests)
    }

    backseat_sdk::keep!(state);
}

impl Reinspect {
    /// The objects that the imagery has shown so far.
    #[must_use]
    pub fn sightings(&self) -> &Sightings {
        &self.state.sightings
    }

    /// Replaces the fence by `misfits`, because tests on the host have no fence.
    #[must_use]
    pub fn with_fence(mut self, misfits: fn(&Request) -> bool) -> Self {
        self.misfits = misfits;
        self
    }

    fn see(&mut self, ping: &SonarPing) {
        if self.config.sensor.is_some_and(|sensor| sensor != ping.sensor) {
            return;
        }
        self.state.pings += 1;
        let Some(look) = Look::of(ping) else {
            self.state.lost_pings += 1;
            if self.state.lost_pings.is_power_of_two() {
                log::warn!("{} pings without navigation", self.state.lost_pings);
            }
            return;
        };
        for contact in self.state.detector.look(&look) {
            let Some(object) = self.state.sightings.add(&contact) else {
                continue;
            };
            if self.config.wants(object) {
                log::info!(
                    "contact {}: {:.1} m high, {:.1} m long, {:.0} m abeam, score {:.0}, {} lines",
                    object.number,
                    contact.height_m,
                    contact.length_m,
                    contact.ground_m,
                    contact.score,
                    object.lines()
                );
            }
        }
        let nearest_m = self.state.detector.altitude_m().unwrap_or_default() * self.config.detector.nadir;
        let farthest_m = look
            .port
            .iter()
            .chain(&look.starboard)
            .map(|strip| strip.end_m)
            .fold(0.0, f64::max)
            .min(self.config.detector.range_m);
        if let Some(inspection) = self.state.inspections.flown_now() {
            inspection
                .aspects
                .look(&look.pose, self.state.detector.hits(), nearest_m, farthest_m);
        }
    }

    fn note_control(&mut self, control: bool) {
        if control == self.state.control {
            return;
        }
        self.state.control = control;
        let count = self.state.inspections.list.len();
        if control {
            log::info!("control: {count} circles so far");
        } else {
            log::info!("control lost: making no requests; {count} circles so far");
        }
    }

    /// The circle to request now, if there is one.
    fn circle(&mut self, here: EastNorth, now_ns: u64) -> Option<Request> {
        if self.state.inspections.is_queued() {
            return None;
        }
        let (index, not_before_ns) = match self.state.inspections.waiting() {
            Some(waiting) => waiting,
            None => (self.choose(here)?, 0),
        };
        if now_ns < not_before_ns {
            return None;
        }
        // The first radius that fits in the fence.
        let radii = self.config.radii_m.len();
        loop {
            let request = self.request(&self.state.inspections.list[index], 0);
            if !(self.misfits)(&request) {
                break;
            }
            let inspection = &mut self.state.inspections.list[index];
            let number = inspection.number;
            if let Turn::Dropped(_) = inspection.next_radius("no circle around it is inside the fence", radii) {
                log::warn!("contact {number}: no circle around it is inside the fence");
                return None;
            }
        }
        let tag = self.state.inspections.list[index].ask();
        Some(self.request(&self.state.inspections.list[index], tag))
    }

    /// The good object nearest to the vehicle that has no circle yet.
    fn choose(&mut self, here: EastNorth) -> Option<usize> {
        let State {
            sightings, inspections, ..
        } = &self.state;
        let nearest = sightings
            .objects()
            .iter()
            .filter(|object| self.config.wants(object) && !inspections.near(object.at, self.config.apart_m))
            .min_by(|one, other| one.at.distance_m(here).total_cmp(&other.at.distance_m(here)))?;
        if inspections.counted() >= self.config.circles_max as usize {
            if !self.state.cap_told {
                log::warn!("contact {} is not circled: circles_max is reached", nearest.number);
                self.state.cap_told = true;
            }
            return None;
        }
        log::info!(
            "contact {}: {:.1} m high at {:.6} {:.6}, seen from {} lines: requesting a circle",
            nearest.number,
            nearest.height_m,
            nearest.latitude_deg,
            nearest.longitude_deg,
            nearest.lines()
        );
        let nearest = nearest.clone();
        Some(self.state.inspections.add(&nearest, self.config.error_m))
    }

    fn request(&self, inspection: &Inspection, tag: u64) -> Request {
        let last = self.config.radii_m.len() - 1;
        Request::Trackcircle(Trackcircle {
            tag,
            centre: Position {
                latitude: inspection.latitude_deg,
                longitude: inspection.longitude_deg,
            },
            radius: self.config.radii_m[inspection.radius.min(last)],
            orbits: self.config.orbits,
            vertical: self.config.vertical(),
            speed: self.config.speed_mps,
            entry_angle: None,
            interrupt: self.config.interrupt,
        })
    }

    fn hear(&mut self, outcome: &Outcome, input: &StepInput, requests: &mut Vec<Request>) {
        let radii = self.config.radii_m.len();
        let misfits = self.misfits;
        let requested = self
            .state
            .inspections
            .of(outcome.tag)
            .map(|index| self.request(&self.state.inspections.list[index], outcome.tag));
        let fits_not = |_: &Inspection| requested.as_ref().is_some_and(misfits);
        let heard = self.state.inspections.hear(
            outcome.tag,
            &outcome.state,
            input.now_ns,
            input.control,
            radii,
            fits_not,
        );
        let Some((index, turn)) = heard else { return };
        let number = self.state.inspections.list[index].number;
        match turn {
            Turn::Quiet => {}
            Turn::Began => log::info!("contact {number}: circle begun"),
            Turn::Flown(verdict) => self.conclude(index, &verdict, requests),
            Turn::Again(why) => log::warn!("contact {number}: the circle will be requested again: {why}"),
            Turn::Radius(why) => log::warn!("contact {number}: another radius will be tried: {why}"),
            Turn::Dropped(why) => log::warn!("contact {number}: given up: {why}"),
        }
    }

    /// Reports what a circle has shown.
    fn conclude(&mut self, index: usize, verdict: &Verdict, requests: &mut Vec<Request>) {
        let inspection = &self.state.inspections.list[index];
        let word = if verdict.seen >= self.config.aspects_min && verdict.height_m >= 0.75 * self.config.height_min_m {
            "confirmed"
        } else if verdict.looked >= self.config.aspects_min {
            "rejected"
        } else {
            "undecided"
        };
        let text = format!(
            "contact {} {word} at {:.6} {:.6} by {} of {} aspects: {:.1} m high and {:.1} m before",
            inspection.number,
            inspection.latitude_deg,
            inspection.longitude_deg,
            verdict.seen,
            verdict.looked,
            verdict.height_m,
            inspection.height_m
        );
        log::info!("{text}");
        measures::publish("height", verdict.height_m, "m");
        requests.push(Request::Message(text.clone()));
        if self.config.topside {
            self.state.messages += 1;
            requests.push(Request::Topside(Topside {
                tag: TOPSIDE_TAGS + self.state.messages,
                slowest: Transport::AcousticModem,
                text,
            }));
        }
    }

    fn note_restored(&mut self, restored: &Restored, now_ns: u64, requests: &mut Vec<Request>) {
        log::warn!(
            "a new instance: {} steps were lost, {} requests are open",
            restored.lost_steps,
            restored.open.len()
        );
        // Tags that were used since the snapshot are not used again.
        self.state.messages += 1000;
        let circles: Vec<u64> = restored
            .open
            .iter()
            .copied()
            .filter(|tag| *tag < TOPSIDE_TAGS)
            .collect();
        self.state.inspections.restored(&circles, now_ns);
        requests.extend(self.state.inspections.strays.iter().map(|tag| Request::Cancel(*tag)));
    }
}
