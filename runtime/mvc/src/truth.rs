use backseat_spi::BehaviorId;
use backseat_units::{EastNorth, Position, Timestamp};

/// The true state of the vehicle, without any sensor's error. A judge sees it; a payload never does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// The time of the step that led to this state.
    pub time: Timestamp,
    /// Where it is on the globe.
    pub position: Position,
    /// Where it is in the world's frame.
    pub local: EastNorth,
    /// Where the vehicle believes that it is, in the world's frame. It steers by this.
    pub believed: EastNorth,
    /// Depth, metres.
    pub depth_m: f64,
    /// The depth at which the vehicle believes that it is, metres.
    pub believed_depth_m: f64,
    /// Height above the seabed, metres.
    pub altitude_m: f64,
    /// Depth of the water there, metres.
    pub water_depth_m: f64,
    /// Heading, degrees from true north, in [0, 360).
    pub heading_deg: f64,
    /// Pitch, degrees, bow up.
    pub pitch_deg: f64,
    /// Roll, degrees, starboard down.
    pub roll_deg: f64,
    /// Speed through the water, metres a second.
    pub speed_mps: f64,
    /// Velocity over ground, metres a second towards the frame's east.
    pub east_mps: f64,
    /// Velocity over ground, metres a second towards the frame's north.
    pub north_mps: f64,
    /// Depth rate, metres a second, positive down.
    pub down_mps: f64,
    /// What the vehicle is doing.
    pub activity: Activity,
    /// Whether the payload has control, as the last BFCTL said.
    pub control: bool,
}

/// What is true of a hovering vehicle in addition to its [`Truth`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HoveringTruth {
    /// Distance from the ship's nearest plate, metres, negative inside; `None` without a ship.
    pub clearance_m: Option<f64>,
    /// Where it is in the frame of relative navigation, metres towards the target.
    pub x_m: f64,
    /// Where it is in the frame of relative navigation, metres to the right of the target.
    pub y_m: f64,
    /// Where it points in the frame of relative navigation, degrees clockwise from the target, in [-180, 180).
    pub bearing_deg: f64,
    /// Speed through the water to starboard, metres a second.
    pub sway_mps: f64,
    /// When the suspension of its mission lapses unless a payload refreshes it; `None` if nothing is suspended.
    pub suspended_until: Option<Timestamp>,
    /// The speed limit that BPSPD sets, metres a second.
    pub speed_limit_mps: f64,
    /// Whether its light is on.
    pub light_on: bool,
}

/// What the vehicle is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Activity {
    /// Its mission has not started.
    Waiting,
    /// It flies an element of its plan, unmodified.
    Plan {
        /// The behavior's number in the plan, from 1; 0 while an empty mission waits for the payload.
        number: u32,
    },
    /// It flies an insert, unmodified.
    Insert {
        /// The insert's identifier.
        id: BehaviorId,
    },
    /// A payload modifies what it flies.
    Modified {
        /// The element's number if the payload modifies an element of the plan.
        number: Option<u32>,
        /// The insert's identifier if the payload modifies an insert.
        id: Option<BehaviorId>,
    },
    /// A payload has suspended the mission and steers the vehicle (SPI 8).
    Suspended,
    /// It climbs to the surface after its mission.
    WrappingUp,
    /// Its mission is over; it drifts.
    Stopped,
}
