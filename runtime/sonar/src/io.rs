use backseat_units::Utc;
use serde::{Deserialize, Serialize};

use crate::event::Event;
use crate::order::Order;
use crate::ping::{PingGrant, SonarPing};
use crate::vehicle::{VehicleNavigation, VehicleSoundSpeed};

/// The driver's name for an order, which comes back with the outcome.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Ticket(pub u64);

/// What the driver knows at the start.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// UTC at [`backseat_units::Timestamp::ZERO`].
    pub utc_at_start: Utc,
    /// The pings that plugins may see, at most 16. Pings of a sensor without a grant are not passed on.
    pub grants: Vec<PingGrant>,
}

/// What a driver passes to the client.
#[derive(Clone, Debug, PartialEq)]
pub enum Input<'a> {
    /// The connection is up.
    Connected,
    /// The connection is lost, could not be made, or was reset as [`Output::Disconnect`] asked.
    Lost,
    /// Bytes from the controller, cut anywhere.
    Received(&'a [u8]),
    /// An order.
    Order(Ticket, Order),
    /// A navigation solution of the vehicle.
    Navigation(VehicleNavigation),
    /// A speed of sound of the vehicle.
    SoundSpeed(VehicleSoundSpeed),
    /// Our computer's clock was set: by how many nanoseconds in all since the start.
    UtcSet(i64),
    /// The time that `poll_timeout` returned has come.
    Timeout,
}

/// What the client asks the driver to do.
#[derive(Clone, Debug, PartialEq)]
pub enum Output {
    /// Connect to the controller now, with a time-out of the driver's own, and report `Connected` or `Lost`.
    Connect,
    /// Reset the connection, or stop trying to connect, and report `Lost`. Do not wait for what is in its buffers.
    Disconnect,
    /// Write this to the controller. If it cannot be written within seconds, report `Lost`.
    Send(Vec<u8>),
    /// A ping for plugins.
    Ping(SonarPing),
    /// What happened, for plugins, for the log and for BPSTS.
    Event(Event),
    /// The client has ended after a shutdown: it needs no further input.
    Finished,
}
