use backseat_core::plugin::{Refusal, Request, RequestState};
use backseat_core::{Note, RequestKind};
use backseat_mvc::{Activity, Truth};
use backseat_plc::{Ping, SensorKind};
use backseat_spi::{Framer, Policy, ToVehicle};
use backseat_units::{EastNorth, Position, Timestamp};
use serde::Serialize;

/// Who flies the vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Steering {
    /// The front seat, by its own plan.
    Plan,
    /// A plugin, by a modify.
    Modify,
    /// The front seat, by a plugin's insert.
    Insert,
    /// Nobody: before and after the mission, and while it is suspended.
    Nobody,
}

/// Where the vehicle truly was.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Sample {
    /// When.
    pub at: Timestamp,
    /// In the world's frame.
    pub local: EastNorth,
    /// On the globe.
    pub position: Position,
    /// Below the surface, metres.
    pub depth_m: f64,
    /// The depth of the water there, metres.
    pub water_depth_m: f64,
    /// Who flew it.
    pub steering: Steering,
}

/// A ping of a sidescan, and where the vehicle truly was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sounding {
    /// When.
    pub at: Timestamp,
    /// The sonar.
    pub sensor: SensorKind,
    /// Its range along the slant, metres.
    pub range_m: f64,
    /// In the world's frame.
    pub local: EastNorth,
    /// Below the surface, metres.
    pub depth_m: f64,
    /// Clockwise from the frame's north, degrees.
    pub heading_deg: f64,
}

/// A request that was rejected.
#[derive(Clone, Debug, PartialEq)]
pub struct Rejected {
    /// When.
    pub at: Timestamp,
    /// Where core believed the vehicle to be.
    pub from: Option<Position>,
    /// The request, if a plugin's newest step asked for it.
    pub request: Option<Request>,
    /// The kind of the request.
    pub kind: RequestKind,
    /// Why it was refused.
    pub refusal: Refusal,
}

/// What a run records for its picture and its expectations: the vehicle's true track once a second, the inserts that
/// were sent, and the requests that were rejected.
#[derive(Debug, Default)]
pub struct Trace {
    /// Once a second, oldest first.
    pub samples: Vec<Sample>,
    /// A ping of each sidescan once a second, oldest first; none while it does not transmit.
    pub soundings: Vec<Sounding>,
    /// Every insert that was sent, as it was written.
    pub inserts: Vec<ToVehicle>,
    /// The first thousand rejections.
    pub rejected: Vec<Rejected>,
    /// The first thousand notes about navigation.
    pub navigation: Vec<(Timestamp, String)>,
    /// An abort or a kill was ordered for the operator. Whatever came of it, plugins do not steer any more.
    pub ending_ordered: bool,
    next_sample: Timestamp,
    asked: Vec<(u64, Request)>,
}

/// How many rejections are kept.
const REJECTED_MAX: usize = 1000;
/// How many notes about navigation are kept.
const NAVIGATION_MAX: usize = 1000;

impl Trace {
    /// Takes a sample, if the last one is a second old. Returns whether it took one.
    pub fn truth(&mut self, truth: &Truth) -> bool {
        if truth.time < self.next_sample {
            return false;
        }
        self.next_sample = Timestamp::from_secs(truth.time.as_nanos() / 1_000_000_000 + 1);
        let steering = match truth.activity {
            Activity::Plan { .. } => Steering::Plan,
            Activity::Insert { .. } => Steering::Insert,
            Activity::Modified { .. } => Steering::Modify,
            Activity::Waiting | Activity::Suspended | Activity::WrappingUp | Activity::Stopped => Steering::Nobody,
        };
        self.samples.push(Sample {
            at: truth.time,
            local: truth.local,
            position: truth.position,
            depth_m: truth.depth_m,
            water_depth_m: truth.water_depth_m,
            steering,
        });
        true
    }

    /// Keeps a ping, if the last one of the same sonar that it kept is of another second.
    pub(crate) fn sounding(&mut self, sensor: SensorKind, ping: &Ping) {
        let second = |at: Timestamp| at.as_nanos() / 1_000_000_000;
        let last = self.soundings.iter().rev().find(|sounding| sounding.sensor == sensor);
        if ping.power_percent <= 0.0 || last.is_some_and(|last| second(last.at) == second(ping.time)) {
            return;
        }
        self.soundings.push(Sounding {
            at: ping.time,
            sensor,
            range_m: ping.range_m,
            local: ping.pose.at,
            depth_m: ping.pose.depth_m,
            heading_deg: ping.pose.heading_deg,
        });
    }

    /// Keeps the inserts among the complete sentences that we send.
    pub(crate) fn sent(&mut self, bytes: &[u8]) {
        if !bytes.starts_with(b"$BPRT") && !bytes.starts_with(b"$BPRG") {
            return;
        }
        let mut framer = Framer::new(Policy::FromPayload);
        framer.push(bytes);
        while let Some(sentence) = framer.next_sentence() {
            if let Ok(message @ (ToVehicle::Trackline(_) | ToVehicle::Trackcircle(_) | ToVehicle::GpsHit(_))) =
                ToVehicle::decode(&sentence)
            {
                self.inserts.push(message);
            }
        }
    }

    /// Keeps what a plugin's step asks for, before core judges it.
    pub(crate) fn asked(&mut self, requests: &[Request]) {
        self.asked.clear();
        for request in requests {
            let tag = match request {
                Request::Modify(modify) => modify.tag,
                Request::Trackline(line) => line.tag,
                Request::Trackcircle(circle) => circle.tag,
                Request::GpsHit(hit) => hit.tag,
                Request::Topside(message) => message.tag,
                Request::DvlTrigger(trigger) => trigger.tag,
                Request::Silent(silent) => silent.tag,
                Request::Trim(tag) | Request::Buoyancy(tag) => *tag,
                Request::Packet(packet) => packet.tag,
                Request::Station(station) => station.tag,
                Request::SonarAngle(sonar) => sonar.tag,
                Request::Camera(camera) => camera.tag,
                Request::Light(light) => light.tag,
                Request::SonarSet(set) => set.tag,
                Request::SonarLog(log) => log.tag,
                Request::EndModify
                | Request::Cancel(_)
                | Request::Message(_)
                | Request::EndStation
                | Request::Timer { .. } => continue,
            };
            self.asked.push((tag, request.clone()));
        }
    }

    pub(crate) fn note(&mut self, at: Timestamp, note: &Note, from: Option<Position>) {
        if let Note::Navigation { text } = note
            && self.navigation.len() < NAVIGATION_MAX
        {
            self.navigation.push((at, text.clone()));
        }
        let Note::Request(transition) = note else { return };
        self.ending_ordered |= matches!(transition.kind, RequestKind::Abort | RequestKind::Kill);
        let RequestState::Rejected(refusal) = &transition.state else {
            return;
        };
        if self.rejected.len() < REJECTED_MAX {
            self.rejected.push(Rejected {
                at,
                from,
                request: self
                    .asked
                    .iter()
                    .find(|(tag, _)| *tag == transition.tag)
                    .map(|(_, request)| request.clone()),
                kind: transition.kind,
                refusal: refusal.clone(),
            });
        }
    }
}
