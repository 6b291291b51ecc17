use super::sixdof::Throttle;

/// What moves the vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Drive {
    /// Held in place, before its mission.
    Held,
    Under(Demand),
    /// In any direction. Only a hovering vehicle can do that.
    Hover(HoverDemand),
    /// Nothing moves it: it drifts and floats up.
    Adrift,
}

/// The heading, depth and speed that the vehicle must hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Demand {
    pub(crate) turn: Turn,
    pub(crate) vertical: Vertical,
    pub(crate) throttle: Throttle,
}

/// How the vehicle turns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Turn {
    /// Degrees from the frame's north.
    Heading(f64),
    /// A fixed rudder angle, degrees, positive to starboard (SPI 6.12).
    Rudder(f64),
}

/// What the vehicle holds vertically.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Vertical {
    Depth(f64),
    Altitude(f64),
    /// Degrees, positive up.
    Pitch(f64),
    /// A fixed elevator angle, degrees, positive lifts the nose (SPI 6.12).
    Elevator(f64),
}

/// The demand on a hovering vehicle that does not steer like a torpedo: any velocity with any heading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct HoverDemand {
    /// Velocity over ground, metres a second east and north, before the limits.
    pub(crate) ground: (f64, f64),
    pub(crate) vertical: Vertical,
    /// Degrees from the frame's north.
    pub(crate) heading_deg: f64,
    /// The greatest speed over ground, of all three directions together, metres a second.
    pub(crate) speed_max_mps: f64,
}

impl Throttle {
    /// Whether the thruster turns ahead.
    pub(crate) fn is_on(self) -> bool {
        match self {
            Self::Speed(amount) | Self::Rpm(amount) => amount > 0.0,
        }
    }
}
