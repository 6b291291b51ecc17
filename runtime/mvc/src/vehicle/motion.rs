use backseat_units::EastNorth;

use super::sixdof::Actuators;

/// The true position, attitude and motion of the vehicle after a step, and the sea at its position.
#[derive(Clone, Debug)]
pub(crate) struct Motion {
    pub(crate) at: EastNorth,
    pub(crate) depth_m: f64,
    /// Degrees from the frame's north, in [0, 360).
    pub(crate) heading_deg: f64,
    /// Along its own axis.
    pub(crate) surge_mps: f64,
    /// To starboard. A torpedo has some for a while after the current changes.
    pub(crate) sway_mps: f64,
    /// Depth rate, positive down.
    pub(crate) heave_mps: f64,
    pub(crate) yaw_rate_dps: f64,
    pub(crate) pitch_deg: f64,
    pub(crate) pitch_rate_dps: f64,
    pub(crate) roll_deg: f64,
    pub(crate) roll_rate_dps: f64,
    /// Velocity of the water where the vehicle is, east and north.
    pub(crate) current: (f64, f64),
    /// Velocity over ground, east and north.
    pub(crate) ground: (f64, f64),
    pub(crate) water_depth_m: f64,
    pub(crate) gradient: EastNorth,
    pub(crate) grounded: bool,
    /// The state of the tailcone; `None` for a vehicle that hovers.
    pub(crate) tail: Option<Tail>,
}

impl Motion {
    /// At rest over ground, before the water at this position has been read.
    pub(super) fn at_rest(at: EastNorth, depth_m: f64, heading_deg: f64) -> Self {
        Self {
            at,
            depth_m,
            heading_deg,
            surge_mps: 0.0,
            sway_mps: 0.0,
            heave_mps: 0.0,
            yaw_rate_dps: 0.0,
            pitch_deg: 0.0,
            pitch_rate_dps: 0.0,
            roll_deg: 0.0,
            roll_rate_dps: 0.0,
            current: (0.0, 0.0),
            ground: (0.0, 0.0),
            water_depth_m: f64::INFINITY,
            gradient: EastNorth::default(),
            grounded: false,
            tail: None,
        }
    }
}

/// Rudder, elevator and thruster: their state, and what they were ordered to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Tail {
    pub(crate) now: Actuators,
    pub(crate) ordered: Actuators,
}
