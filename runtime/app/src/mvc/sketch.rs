use std::collections::BTreeMap;

use backseat_mvc::{Mvc, MvcEventKind};
use backseat_sim::{Trace, vehicle_map};
use backseat_spi::{BehaviorId, Sentence, ToVehicle};

/// How many inserts may wait for the vehicle's answer, and how many are drawn.
const INSERTS_MAX: usize = 1000;

/// What the map of a run of the vehicle needs, collected while it runs.
#[derive(Debug, Default)]
pub(crate) struct Sketch {
    trace: Trace,
    /// Inserts that clients have asked for, by their identifiers.
    asked: BTreeMap<BehaviorId, ToVehicle>,
}

impl Sketch {
    /// The vehicle has taken a step.
    pub(crate) fn step(&mut self, vehicle: &Mvc) {
        self.trace.truth(&vehicle.truth());
    }

    /// A client's line has arrived.
    pub(crate) fn received(&mut self, line: &[u8]) {
        let line = line.trim_ascii();
        if !line.starts_with(b"$BPRT") && !line.starts_with(b"$BPRG") {
            return;
        }
        let sentence = std::str::from_utf8(line)
            .ok()
            .and_then(|line| Sentence::parse(line).ok());
        let message = sentence.and_then(|sentence| ToVehicle::decode(&sentence).ok());
        let id = match &message {
            Some(ToVehicle::Trackline(line)) => line.identifier,
            Some(ToVehicle::Trackcircle(circle)) => circle.identifier,
            Some(ToVehicle::GpsHit(hit)) => hit.identifier,
            Some(_) | None => return,
        };
        if self.asked.len() >= INSERTS_MAX {
            self.asked.pop_first();
        }
        self.asked.extend(message.map(|message| (id, message)));
    }

    /// Something has happened in the vehicle.
    pub(crate) fn event(&mut self, kind: &MvcEventKind) {
        if let MvcEventKind::InsertAccepted(_, id) = kind
            && let Some(message) = self.asked.remove(id)
            && self.trace.inserts.len() < INSERTS_MAX
        {
            self.trace.inserts.push(message);
        }
    }

    /// The map, as SVG.
    pub(crate) fn draw(&self, name: &str, seed: u64, clients: u32, vehicle: &Mvc) -> String {
        let minutes = vehicle.truth().time.as_secs_f64() / 60.0;
        let plural = if clients == 1 { "" } else { "s" };
        let subtitle = format!(
            "seed {seed}, {} after {minutes:.0} min; {clients} client{plural}",
            vehicle.mission_status().name()
        );
        vehicle_map(name, &subtitle, "", &self.trace, vehicle)
    }
}
