use core::fmt;

use crate::event::ClientId;

/// What happens only to a hovering vehicle (SPI 8).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HoveringEvent {
    /// BPSUS: a client suspended the mission.
    Suspended(ClientId),
    /// The suspension ended.
    SuspensionEnded(SuspensionEnd),
    /// The vehicle returns to the place where its mission was suspended.
    Returning,
    /// The mission goes on after the return (true), or because the vehicle did not reach the place in time (false).
    Returned(bool),
    /// BPGHP: the vehicle moves to a place at the hull.
    HullMove {
        /// Metres to the right of midships.
        horizontal_m: f64,
        /// Metres from the waterline, counted as `interpretation.hull_vertical` says.
        vertical_m: f64,
        /// Metres from the hull.
        distance_m: f64,
    },
    /// BPGBP: the vehicle moves to a place near the bottom.
    BottomMove {
        /// Metres along x.
        x_m: f64,
        /// Metres along y.
        y_m: f64,
    },
    /// The vehicle believes that it has reached the place to which it was sent.
    Arrived,
    /// BPSPD: the new speed limit, metres a second.
    SpeedLimit(f64),
    /// BPRNS: the position in relative navigation moved by this much, metres.
    RelativeReset(f64),
    /// BPRBO: this many degrees were added to the inertial bearing.
    BearingOffset(f64),
    /// BPSAN: the sonar turns to this angle, degrees.
    SonarAngle(f64),
    /// BPPTZ: the camera moves, in each direction for this many tenths of a second.
    Camera {
        /// Pan.
        pan: i32,
        /// Tilt.
        tilt: i32,
        /// Zoom.
        zoom: i32,
    },
    /// BPLIT: the light is on (true) or off (false).
    Light(bool),
}

/// Why a suspension ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SuspensionEnd {
    /// A payload resumed the mission (BPRES).
    Resumed,
    /// No BPSUS, BPCON, BPGHP or BPGBP arrived for 2 s.
    Lapsed,
    /// Dynamic requests are no longer allowed, and a suspension needs them.
    ControlLost,
    /// The mission ended.
    MissionOver,
}

impl fmt::Display for HoveringEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Suspended(client) => write!(f, "{client} suspends the mission"),
            Self::SuspensionEnded(why) => write!(f, "suspension ended: {why}"),
            Self::Returning => f.write_str("going back to where the mission was suspended"),
            Self::Returned(true) => {
                f.write_str("the vehicle is back where the mission was suspended: the mission goes on")
            }
            Self::Returned(false) => {
                f.write_str("the vehicle did not reach the place where the mission was suspended: the mission goes on")
            }
            Self::HullMove {
                horizontal_m,
                vertical_m,
                distance_m,
            } => write!(
                f,
                "move to the hull: horizontal {horizontal_m:.2} m, vertical {vertical_m:.2} m, distance {distance_m:.2} m"
            ),
            Self::BottomMove { x_m, y_m } => write!(f, "move over the bottom: x {x_m:.2} m, y {y_m:.2} m"),
            Self::Arrived => f.write_str("arrived where it was sent"),
            Self::SpeedLimit(mps) => write!(f, "hull relative speed limit {mps:.2} m/s"),
            Self::RelativeReset(metres) => write!(f, "relative navigation moved by {metres:.2} m"),
            Self::BearingOffset(deg) => write!(f, "inertial bearing moved by {deg:.2} deg"),
            Self::SonarAngle(deg) => write!(f, "sonar to {deg:.1} deg"),
            Self::Camera { pan, tilt, zoom } => write!(f, "camera moves: pan {pan}, tilt {tilt}, zoom {zoom}"),
            Self::Light(on) => write!(f, "light {}", if *on { "on" } else { "off" }),
        }
    }
}

impl fmt::Display for SuspensionEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Resumed => "resumed by the payload",
            Self::Lapsed => "2 s without a refresh",
            Self::ControlLost => "control was taken back",
            Self::MissionOver => "the mission ended",
        })
    }
}
