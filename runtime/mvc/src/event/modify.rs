use core::fmt;

use super::fixed::Fixed;

/// What a modify asks for. `None` keeps the value of the behavior (SPI 7.12).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModifyValues {
    /// The heading or the rudder angle.
    pub horizontal: Option<ModifyHorizontal>,
    /// The depth, the altitude, the pitch or the elevator angle.
    pub vertical: Option<ModifyVertical>,
    /// The speed.
    pub speed: Option<ModifySpeed>,
}

impl ModifyValues {
    /// A modify that asks for nothing.
    pub(crate) const NONE: Self = Self {
        horizontal: None,
        vertical: None,
        speed: None,
    };
}

/// The speed that a modify asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ModifySpeed {
    /// Speed through the water, metres a second.
    MetresPerSecond(f64),
    /// Speed of the thruster, revolutions a minute.
    Rpm(f64),
}

/// The horizontal value that a modify asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ModifyHorizontal {
    /// Heading, degrees from true north.
    Heading(f64),
    /// Rudder, degrees, positive to starboard.
    Rudder(f64),
}

/// The vertical value that a modify asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ModifyVertical {
    /// Depth, metres.
    Depth(f64),
    /// Height above the seabed, metres.
    Altitude(f64),
    /// Pitch, degrees, positive up.
    Pitch(f64),
    /// Elevator, degrees, positive up.
    Elevator(f64),
}

/// Why a modify ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModifyEnd {
    /// A payload ended it (BPEMB).
    Ended,
    /// No BPRMB arrived for 5 s.
    Lapsed,
    /// Dynamic requests are no longer allowed.
    ControlLost,
    /// It exceeded a limit of the mission.
    Limit,
    /// The behavior that it modified ended.
    BehaviorEnded,
    /// The mission ended.
    MissionOver,
}

impl fmt::Display for ModifyValues {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.horizontal {
            Some(ModifyHorizontal::Heading(heading)) => write!(f, "heading {} deg", Fixed::<1>(heading))?,
            Some(ModifyHorizontal::Rudder(rudder)) => write!(f, "rudder {} deg", Fixed::<1>(rudder))?,
            None => f.write_str("heading of the behavior")?,
        }
        match self.vertical {
            Some(ModifyVertical::Depth(depth)) => write!(f, ", depth {} m", Fixed::<2>(depth))?,
            Some(ModifyVertical::Altitude(altitude)) => write!(f, ", altitude {} m", Fixed::<2>(altitude))?,
            Some(ModifyVertical::Pitch(pitch)) => write!(f, ", pitch {} deg", Fixed::<1>(pitch))?,
            Some(ModifyVertical::Elevator(elevator)) => write!(f, ", elevator {} deg", Fixed::<1>(elevator))?,
            None => f.write_str(", depth of the behavior")?,
        }
        match self.speed {
            Some(ModifySpeed::MetresPerSecond(speed)) => write!(f, ", speed {} m/s", Fixed::<2>(speed)),
            Some(ModifySpeed::Rpm(rpm)) => write!(f, ", {} rpm", Fixed::<0>(rpm)),
            None => f.write_str(", speed of the behavior"),
        }
    }
}

impl fmt::Display for ModifyEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Ended => "by the payload",
            Self::Lapsed => "5 s without a refresh",
            Self::ControlLost => "control was taken back",
            Self::Limit => "too long or too far",
            Self::BehaviorEnded => "its behavior ended",
            Self::MissionOver => "the mission ended",
        })
    }
}
