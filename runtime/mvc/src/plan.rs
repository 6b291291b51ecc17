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
    /// The heading counts from true north.
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
    /// To a place, up, and on with the fix (SPI 7.7).
    GpsHit {
        at: EastNorth,
        /// The vehicle surfaces by itself.
        climbs: bool,
        times: GpsTimes,
    },
    /// A text to the payload: over as it begins.
    Command,
    /// What an empty mission does where the payload asks for nothing: drift, without an end.
    Idle,
}

/// How long a GPS hit may and must take: the vehicle's defaults (SPI 7.7 ignores what BPRGP says).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GpsTimes {
    /// The antenna is out of the water for so long before there is a fix.
    pub(crate) fix: Duration,
    /// It gives up where it has no fix so long after it came to the place.
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

    /// A survey leg or trackcircle: where the inserts have their place (SPI 7.5).
    pub(crate) const fn is_leg(&self) -> bool {
        match self {
            Self::Trackline { .. } | Self::Trackcircle { .. } => true,
            Self::Waypoint { .. } | Self::Setpoint { .. } | Self::GpsHit { .. } | Self::Command | Self::Idle => false,
        }
    }

    /// A trackline with its lead-in and lead-out; any other shape as it is.
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
    /// Behavior number in the dive file, from 1 (SPI 6.9).
    pub(crate) number: u32,
    /// The planner-level element that it belongs to, from 1 (SPI 7.11).
    pub(crate) element: u32,
    /// As planned, without lead-in and lead-out.
    pub(crate) shape: Shape,
    pub(crate) lead_m: f64,
    pub(crate) vertical: Vertical,
    pub(crate) speed_mps: f64,
    /// When, after the element's begin, dynamic requests are allowed.
    pub(crate) dynamic: Option<(Duration, Duration)>,
    pub(crate) timeout: Option<Duration>,
    /// What the payload is told: a command, or a trackline's message.
    pub(crate) message: Option<PayloadText>,
}

/// Where the east-north frame stops being true.
pub(crate) const RADIUS_M: f64 = LocalFrame::RADIUS_M;

/// The plan as it is flown.
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
