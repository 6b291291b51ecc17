use core::time::Duration;

use backseat_spi::{AckStatus, FromVehicle};
use backseat_units::{EastNorth, LocalFrame, TimeOfDay, Timestamp, utm_convergence_deg};
use backseat_world::World;

use crate::estimate::Estimate;
use crate::event::{MvcEventKind, Status};
use crate::interpretation::Interpretation;
use crate::server::Server;
use crate::server::answers::Regarding;
use crate::server::topics::Topic;
use crate::vehicle::Vehicle;

/// What a part of the vehicle receives with each call, and through which it replies. A part never sees the other parts;
/// it knows of them only what is here.
#[derive(Debug)]
pub(crate) struct Context<'a> {
    pub(crate) now: Timestamp,
    /// Time between two steps of the vehicle.
    pub(crate) period: Duration,
    pub(crate) world: &'a World,
    pub(crate) vehicle: &'a Vehicle,
    pub(crate) north: North,
    pub(crate) estimate: Estimate,
    pub(crate) interpretation: &'a Interpretation,
    pub(crate) mission: Status,
    pub(crate) quiet: Quiet,
    pub(crate) server: &'a mut Server,
}

/// Angles from true north at the vehicle's place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct North {
    /// To the north of the world's frame.
    pub(crate) frame_deg: f64,
    /// To the north of the UTM grid.
    pub(crate) grid_deg: f64,
}

impl North {
    pub(crate) fn at(place: EastNorth, frame: &LocalFrame) -> Self {
        let position = frame.to_position(place);
        Self {
            frame_deg: frame.convergence_deg(position),
            grid_deg: utm_convergence_deg(position),
        }
    }
}

/// How quiet the vehicle is (SPI 7.22).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Quiet {
    pub(crate) silent: bool,
    /// Silent, or about to become silent.
    pub(crate) commanded: bool,
    /// The thruster is on.
    pub(crate) driven: bool,
    /// The tailcone spins, driven or not.
    pub(crate) spinning: bool,
}

impl Context<'_> {
    pub(crate) const fn frame(&self) -> &LocalFrame {
        self.world.frame()
    }

    pub(crate) fn stamp(&self) -> TimeOfDay {
        self.server.stamp(self.now)
    }

    pub(crate) fn note(&mut self, kind: MvcEventKind) {
        self.server.note(self.now, kind);
    }

    pub(crate) const fn wanted(&self, topics: u32) -> bool {
        self.server.wanted(topics)
    }

    /// Sends a message to every client that has switched on its topic, or to all clients if it has no topic.
    pub(crate) fn publish(&mut self, topic: Option<Topic>, message: &FromVehicle) {
        self.server.publish(self.now, topic, message);
    }

    pub(crate) fn acknowledge(&mut self, re: Regarding, status: AckStatus, text: &str) {
        self.server.acknowledge(self.now, re, status, text);
    }

    /// Logs what a payload said, and acknowledges it. Nothing else follows from it.
    pub(crate) fn hear(&mut self, re: Regarding, said: MvcEventKind) {
        self.note(said);
        self.acknowledge(re, AckStatus::Succeeded, "");
    }

    pub(crate) fn invalid(&mut self, re: Regarding, text: &str) {
        self.server.invalid(self.now, re, text);
    }
}
