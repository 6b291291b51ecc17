pub(crate) mod course;
pub(crate) mod insert;
pub(crate) mod soundings;

use core::time::Duration;

pub(crate) use backseat_plan::PayloadText;
use backseat_plan::{Course, PlanElement, PlanEntry, PlannedVertical, with_leads};
use backseat_units::{EastNorth, LocalFrame};

use crate::error::MvcError;
use crate::file::VehicleConfig;
use crate::vehicle::Vertical;

/// What a behavior flies, in the world's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Shape {
    Waypoint {
        to: EastNorth,
    },
    Trackline {
        start: EastNorth,
        end: EastNorth,
    },
    /// The vehicle holds a heading, counted from true north.
    Setpoint {
        heading_deg: f64,
        duration: Duration,
    },
    Trackcircle {
        centre: EastNorth,
        radius_m: f64,
        orbits: f64,
        entry_deg: Option<f64>,
    },
    /// The vehicle goes to a place, surfaces, and goes on once it has a fix (SPI 7.7).
    GpsHit {
        at: EastNorth,
        /// Whether the vehicle surfaces by itself; otherwise the payload brings it up.
        climbs: bool,
        times: GpsTimes,
    },
    /// The vehicle sends a text to the payload. The behavior ends as soon as it begins.
    Command,
    /// What an empty mission does while the payload asks for nothing: it drifts, without an end.
    Idle,
}

/// How long a GPS hit takes. SPI 7.7 ignores the times in BPRGP, so these are the vehicle's defaults.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GpsTimes {
    /// How long the antenna must be out of the water before there is a fix.
    pub(crate) fix: Duration,
    /// How long after the arrival at the place the GPS hit gives up without a fix.
    pub(crate) within: Duration,
}

impl Shape {
    /// The behavior type that BFMBS and BFMBE carry (SPI 6.9).
    pub(crate) const fn kind(&self) -> &'static str {
        match self {
            Self::Waypoint { .. } => "waypoint",
            Self::Trackline { .. } => "trackline",
            Self::Setpoint { .. } => "setpoint",
            Self::Trackcircle { .. } => "trackcircle",
            Self::GpsHit { .. } => "gps",
            Self::Command => "command",
            Self::Idle => "setpoint",
        }
    }

    /// Whether it is a trackline or a trackcircle, before which inserts are flown (SPI 7.5).
    pub(crate) const fn is_leg(&self) -> bool {
        match self {
            Self::Trackline { .. } | Self::Trackcircle { .. } => true,
            Self::Waypoint { .. } | Self::Setpoint { .. } | Self::GpsHit { .. } | Self::Command | Self::Idle => false,
        }
    }

    /// A trackline with its lead-in and lead-out; any other shape unchanged.
    pub(crate) fn with_leads(self, lead_m: f64) -> Self {
        match self {
            Self::Trackline { start, end } => {
                let (start, end) = with_leads(start, end, lead_m);
                Self::Trackline { start, end }
            }
            Self::Waypoint { .. }
            | Self::Setpoint { .. }
            | Self::Trackcircle { .. }
            | Self::GpsHit { .. }
            | Self::Command
            | Self::Idle => self,
        }
    }
}

/// One behavior of the front seat's plan.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlanItem {
    /// The behavior's number in the dive file, from 1 (SPI 6.9).
    pub(crate) number: u32,
    /// The number of the planner-level element that it belongs to, from 1 (SPI 7.11).
    pub(crate) element: u32,
    /// As planned, without lead-in and lead-out.
    pub(crate) shape: Shape,
    pub(crate) lead_m: f64,
    pub(crate) vertical: Vertical,
    pub(crate) speed_mps: f64,
    /// From when to when, counted from the element's begin, dynamic requests are allowed; `None` if they never are.
    pub(crate) dynamic: Option<(Duration, Duration)>,
    pub(crate) timeout: Option<Duration>,
    /// The text for the payload: of a command, or of a trackline or trackcircle.
    pub(crate) message: Option<PayloadText>,
}

/// The distance from the origin up to which the east-north frame is accurate, metres.
pub(crate) const RADIUS_M: f64 = LocalFrame::RADIUS_M;

/// Resolves the plan's entries into the behaviors that are flown.
pub(crate) fn resolve(
    entries: &[PlanEntry],
    frame: &LocalFrame,
    vehicle: &VehicleConfig,
) -> Result<Vec<PlanItem>, MvcError> {
    let elements = backseat_plan::resolve(entries, frame, &vehicle.limits())?;
    Ok(elements.into_iter().map(PlanItem::from).collect())
}

impl From<PlanElement> for PlanItem {
    fn from(element: PlanElement) -> Self {
        Self {
            number: element.number,
            element: element.element,
            shape: match element.course {
                Course::Waypoint { to } => Shape::Waypoint { to },
                Course::Trackline { start, end } => Shape::Trackline { start, end },
                Course::Setpoint { heading_deg, duration } => Shape::Setpoint { heading_deg, duration },
                Course::Trackcircle {
                    centre,
                    radius_m,
                    orbits,
                    entry_deg,
                } => Shape::Trackcircle {
                    centre,
                    radius_m,
                    orbits,
                    entry_deg,
                },
                Course::Command => Shape::Command,
            },
            lead_m: element.lead_m,
            vertical: match element.vertical {
                PlannedVertical::Depth(depth_m) => Vertical::Depth(depth_m),
                PlannedVertical::Altitude(altitude_m) => Vertical::Altitude(altitude_m),
            },
            speed_mps: element.speed_mps,
            dynamic: element.dynamic,
            timeout: element.timeout,
            message: element.message,
        }
    }
}
