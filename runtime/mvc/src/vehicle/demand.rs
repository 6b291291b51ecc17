use super::sixdof::Throttle;

/// What moves the vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Drive {
    /// Held where it is: before its mission.
    Held,
    Under(Demand),
    /// Any way, as only a hovering vehicle can.
    Hover(HoverDemand),
    /// Nothing: it drifts and floats up.
    Adrift,
}

/// What the vehicle is asked to hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Demand {
    pub(crate) turn: Turn,
    pub(crate) vertical: Vertical,
    pub(crate) throttle: Throttle,
}

/// What the vehicle turns to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Turn {
    /// Degrees from the frame's north.
    Heading(f64),
    /// Degrees of rudder, positive to starboard (SPI 6.12), held.
    Rudder(f64),
}

/// What the vehicle holds vertically.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Vertical {
    Depth(f64),
    Altitude(f64),
    /// Degrees, positive up.
    Pitch(f64),
    /// Degrees of elevator, held; positive lifts the nose (SPI 6.12).
    Elevator(f64),
}

/// What a hovering vehicle is asked to do where it does not steer like a torpedo: any velocity under any heading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct HoverDemand {
    /// Velocity over ground, metres a second east and north, before the limits.
    pub(crate) ground: (f64, f64),
    pub(crate) vertical: Vertical,
    /// Degrees from the frame's north.
    pub(crate) heading_deg: f64,
    /// The most over ground, in all directions together, metres a second.
    pub(crate) speed_max_mps: f64,
}

impl Throttle {
    /// Whether the thruster turns ahead at all.
    pub(crate) fn is_on(self) -> bool {
        match self {
            Self::Speed(amount) | Self::Rpm(amount) => amount > 0.0,
        }
    }
}
