use core::fmt;

use crate::event::ClientId;

/// What happens to a hovering vehicle alone (SPI 8).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HoveringEvent {
    /// BPSUS: the mission is suspended.
    Suspended(ClientId),
    /// The suspension ended.
    SuspensionEnded(SuspensionEnd),
    /// The vehicle returns to where its mission was suspended.
    Returning,
    /// The mission goes on after the return; false where the place was not reached in time.
    Returned(bool),
    /// BPGHP: towards a place on the hull.
    HullMove {
        /// Metres to the right of midships.
        horizontal_m: f64,
        /// Metres, as the interface counts them.
        vertical_m: f64,
        /// Metres from the hull.
        distance_m: f64,
    },
    /// BPGBP: towards a place near the bottom.
    BottomMove {
        /// Metres along x.
        x_m: f64,
        /// Metres along y.
        y_m: f64,
    },
    /// The vehicle believes that it is where it was sent.
    Arrived,
    /// BPSPD: the limit for moves, metres a second.
    SpeedLimit(f64),
    /// BPRNS: the vehicle's idea of its place moved by so many metres.
    RelativeReset(f64),
    /// BPRBO: so many degrees were added to its bearing.
    BearingOffset(f64),
    /// BPSAN: the sonar turns to this angle, degrees.
    SonarAngle(f64),
    /// BPPTZ: the camera moves for so many tenths of a second.
    Camera {
        /// Pan.
        pan: i32,
        /// Tilt.
        tilt: i32,
        /// Zoom.
        zoom: i32,
    },
    /// BPLIT: the light is on, or off.
    Light(bool),
}

/// Why a suspension ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SuspensionEnd {
    /// BPRES.
    Resumed,
    /// No BPSUS, BPCON, BPGHP or BPGBP came for 2 s.
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
            Self::Returning => f.write_str("back to where the mission was suspended"),
            Self::Returned(true) => f.write_str("back where the mission was suspended: it goes on"),
            Self::Returned(false) => f.write_str("where the mission was suspended is out of reach: it goes on"),
            Self::HullMove {
                horizontal_m,
                vertical_m,
                distance_m,
            } => write!(
                f,
                "to the hull at {horizontal_m:.2} m, {vertical_m:.2} m, {distance_m:.2} m off"
            ),
            Self::BottomMove { x_m, y_m } => write!(f, "to the bottom at x {x_m:.2} m, y {y_m:.2} m"),
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
