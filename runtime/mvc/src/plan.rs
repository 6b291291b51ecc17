pub(crate) mod course;
pub(crate) mod insert;
pub(crate) mod planned;
pub(crate) mod soundings;

use core::time::Duration;

use backseat_spi::Text;
use backseat_units::{EastNorth, LocalFrame, Position};

use crate::error::MvcError;
use crate::file::{PlaceConfig, PlanEntry, PlanKind, VehicleConfig};
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
                let lead = (end - start) * (lead_m / start.distance_m(end).max(1.0));
                Self::Trackline {
                    start: start - lead,
                    end: end + lead,
                }
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

/// A text for the payload, and which client is meant.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PayloadText {
    pub(crate) role: Option<Box<str>>,
    pub(crate) text: Text,
}

/// Where the east-north frame stops being true.
pub(crate) const RADIUS_M: f64 = LocalFrame::RADIUS_M;

/// The plan as it is flown.
pub(crate) fn resolve(
    entries: &[PlanEntry],
    frame: &LocalFrame,
    vehicle: &VehicleConfig,
) -> Result<Vec<PlanItem>, MvcError> {
    if entries.is_empty() || entries.len() > 10_000 {
        let expected = "1 to 10000 elements";
        return Err(MvcError::Value {
            key: "plan",
            value: format!("{} elements", entries.len()),
            expected,
        });
    }
    let mut items = Vec::with_capacity(entries.len());
    for (element, entry) in (1..).zip(entries) {
        let mut item =
            item(entry, element, frame, vehicle).map_err(|fault| MvcError::Plan { number: element, fault })?;
        if entry.separate_transit {
            let transit = transit(&item);
            items.push(PlanItem {
                number: items.len() as u32 + 1,
                ..transit
            });
        }
        item.number = items.len() as u32 + 1;
        items.push(item);
    }
    Ok(items)
}

/// The way to the begin of a line or circle as a behavior of its own.
fn transit(item: &PlanItem) -> PlanItem {
    let to = match item.shape.with_leads(item.lead_m) {
        Shape::Trackline { start, .. } => start,
        Shape::Trackcircle {
            centre,
            radius_m,
            entry_deg,
            ..
        } => centre.offset(entry_deg.unwrap_or(0.0), radius_m),
        Shape::Waypoint { to } | Shape::GpsHit { at: to, .. } => to,
        Shape::Setpoint { .. } | Shape::Command | Shape::Idle => EastNorth::default(),
    };
    PlanItem {
        shape: Shape::Waypoint { to },
        lead_m: 0.0,
        message: None,
        ..item.clone()
    }
}

fn item(entry: &PlanEntry, element: u32, frame: &LocalFrame, vehicle: &VehicleConfig) -> Result<PlanItem, String> {
    refuse_foreign_keys(entry)?;
    let place = |key: &str, place: Option<PlaceConfig>| resolve_place(entry.kind, key, place, frame);
    let shape = match entry.kind {
        PlanKind::Waypoint => Shape::Waypoint {
            to: place("at", entry.at)?,
        },
        PlanKind::Trackline => {
            let (start, end) = (place("start", entry.start)?, place("end", entry.end)?);
            if start.distance_m(end) < 1.0 {
                return Err("`start` and `end` must be at least 1 m apart".to_owned());
            }
            Shape::Trackline { start, end }
        }
        PlanKind::Setpoint => {
            let heading_deg = number_in(entry, "heading_deg", entry.heading_deg, -360.0, 360.0)?;
            let duration_s = number_in(entry, "duration_s", entry.duration_s, 1.0, 1e6)?;
            Shape::Setpoint {
                heading_deg,
                duration: Duration::from_secs_f64(duration_s),
            }
        }
        PlanKind::Command => Shape::Command,
        PlanKind::Trackcircle => {
            let orbits = number_in(entry, "orbits", entry.orbits, -1000.0, 1000.0)?;
            if orbits.abs() < 0.01 {
                return Err(format!("orbits is {orbits}, expected 0.01 to 1000 either way"));
            }
            Shape::Trackcircle {
                centre: place("centre", entry.centre)?,
                radius_m: number_in(entry, "radius_m", entry.radius_m, 5.0, 20_000.0)?,
                orbits,
                entry_deg: match entry.entry_angle_deg {
                    None => None,
                    angle => Some(number_in(entry, "entry_angle_deg", angle, -360.0, 360.0)?),
                },
            }
        }
    };
    let lead_m = number_in(entry, "lead_in_m", entry.lead_in_m.or(Some(0.0)), 0.0, 500.0)?;
    let (vertical, speed_mps) = match entry.kind {
        PlanKind::Command => no_motion(entry)?,
        PlanKind::Waypoint | PlanKind::Trackline | PlanKind::Setpoint | PlanKind::Trackcircle => {
            (vertical(entry, vehicle)?, speed_mps(entry, vehicle)?)
        }
    };
    let timeout = match entry.timeout_s {
        None => None,
        seconds => Some(Duration::from_secs_f64(number_in(
            entry,
            "timeout_s",
            seconds,
            1.0,
            1e6,
        )?)),
    };
    Ok(PlanItem {
        number: 0,
        element,
        shape,
        lead_m,
        vertical,
        speed_mps,
        dynamic: window(entry)?,
        timeout,
        message: message(entry)?,
    })
}

fn vertical(entry: &PlanEntry, vehicle: &VehicleConfig) -> Result<Vertical, String> {
    let depth_max_m = vehicle.hull().depth_max_m;
    match (entry.depth_m, entry.altitude_m) {
        (Some(depth), None) if (0.0..=depth_max_m).contains(&depth) => Ok(Vertical::Depth(depth)),
        (Some(depth), None) => Err(format!("depth_m is {depth}, expected 0 to {depth_max_m}")),
        (None, Some(altitude)) if (vehicle.altitude_min_m..=1000.0).contains(&altitude) => {
            Ok(Vertical::Altitude(altitude))
        }
        (None, Some(altitude)) => Err(format!(
            "altitude_m is {altitude}, expected {} to 1000",
            vehicle.altitude_min_m
        )),
        (Some(_), Some(_)) | (None, None) => Err("expected one of `depth_m` and `altitude_m`".to_owned()),
    }
}

fn speed_mps(entry: &PlanEntry, vehicle: &VehicleConfig) -> Result<f64, String> {
    let hull = vehicle.hull();
    // Without way on a line never ends; a setpoint does, and a hovering hull may stand still for it.
    let least = if entry.kind == PlanKind::Setpoint {
        hull.speed_min_mps
    } else {
        hull.speed_min_mps.max(0.05)
    };
    number_in(entry, "speed_mps", entry.speed_mps, least, hull.speed_max_mps)
}

/// A command moves nothing: it has neither depth nor speed.
fn no_motion(entry: &PlanEntry) -> Result<(Vertical, f64), String> {
    for (key, present) in [
        ("depth_m", entry.depth_m.is_some()),
        ("altitude_m", entry.altitude_m.is_some()),
        ("speed_mps", entry.speed_mps.is_some()),
        ("timeout_s", entry.timeout_s.is_some()),
    ] {
        if present {
            return Err(format!("a command has no `{key}`"));
        }
    }
    Ok((Vertical::Depth(0.0), 0.0))
}

fn message(entry: &PlanEntry) -> Result<Option<PayloadText>, String> {
    let Some(text) = entry.text.as_ref().or(entry.payload_message.as_ref()) else {
        return match entry.role {
            None => Ok(None),
            Some(_) => Err("`role` needs a `text` or a `payload_message`".to_owned()),
        };
    };
    let checked = |key: &str, text: &str| match Text::new(text) {
        Ok(text) if text.as_str().len() <= 200 => Ok(text),
        Ok(_) | Err(_) => Err(format!(
            "{key} is {text:?}, expected at most 200 printable ascii characters without comma, asterisk and dollar"
        )),
    };
    if let Some(role) = &entry.role {
        checked("role", role)?;
    }
    let key = if entry.text.is_some() {
        "text"
    } else {
        "payload_message"
    };
    Ok(Some(PayloadText {
        role: entry.role.as_deref().map(Box::from),
        text: checked(key, text)?,
    }))
}

fn window(entry: &PlanEntry) -> Result<Option<(Duration, Duration)>, String> {
    if !entry.dynamic {
        return match (entry.dynamic_from_s, entry.dynamic_for_s) {
            (None, None) => Ok(None),
            _ => Err("`dynamic_from_s` and `dynamic_for_s` need `dynamic = true`".to_owned()),
        };
    }
    let from = number_in(entry, "dynamic_from_s", entry.dynamic_from_s.or(Some(0.0)), 0.0, 1e6)?;
    let length = number_in(entry, "dynamic_for_s", entry.dynamic_for_s.or(Some(1e7)), 0.0, 1e7)?;
    Ok(Some((
        Duration::from_secs_f64(from),
        Duration::from_secs_f64(from + length),
    )))
}

fn number_in(entry: &PlanEntry, key: &str, value: Option<f64>, least: f64, most: f64) -> Result<f64, String> {
    let value = value.ok_or_else(|| format!("a {} needs `{key}`", kind_name(entry.kind)))?;
    if (least..=most).contains(&value) {
        Ok(value)
    } else {
        Err(format!("{key} is {value}, expected {least} to {most}"))
    }
}

/// A key that another kind needs is a mistake, not a remark.
fn refuse_foreign_keys(entry: &PlanEntry) -> Result<(), String> {
    let kind = entry.kind;
    let keys = [
        ("at", entry.at.is_some(), PlanKind::Waypoint),
        ("start", entry.start.is_some(), PlanKind::Trackline),
        ("end", entry.end.is_some(), PlanKind::Trackline),
        ("centre", entry.centre.is_some(), PlanKind::Trackcircle),
        ("radius_m", entry.radius_m.is_some(), PlanKind::Trackcircle),
        ("orbits", entry.orbits.is_some(), PlanKind::Trackcircle),
        (
            "entry_angle_deg",
            entry.entry_angle_deg.is_some(),
            PlanKind::Trackcircle,
        ),
        ("heading_deg", entry.heading_deg.is_some(), PlanKind::Setpoint),
        ("duration_s", entry.duration_s.is_some(), PlanKind::Setpoint),
        ("lead_in_m", entry.lead_in_m.is_some(), PlanKind::Trackline),
        ("payload_message", entry.payload_message.is_some(), PlanKind::Trackline),
        ("text", entry.text.is_some(), PlanKind::Command),
    ];
    let optional = ["entry_angle_deg", "lead_in_m", "payload_message"];
    // What is missing is said first: it is the commoner cause of a key too many.
    for (key, present, of) in keys {
        if !present && of == kind && !optional.contains(&key) {
            return Err(format!("a {} needs `{key}`", kind_name(kind)));
        }
    }
    for (key, present, of) in keys {
        if present && of != kind {
            return Err(format!("a {} has no `{key}`", kind_name(kind)));
        }
    }
    if entry.separate_transit && !matches!(kind, PlanKind::Trackline | PlanKind::Trackcircle) {
        return Err(format!("a {} has no `separate_transit`", kind_name(kind)));
    }
    Ok(())
}

const fn kind_name(kind: PlanKind) -> &'static str {
    match kind {
        PlanKind::Waypoint => "waypoint",
        PlanKind::Trackline => "trackline",
        PlanKind::Setpoint => "setpoint",
        PlanKind::Trackcircle => "trackcircle",
        PlanKind::Command => "command",
    }
}

fn resolve_place(
    kind: PlanKind,
    key: &str,
    place: Option<PlaceConfig>,
    frame: &LocalFrame,
) -> Result<EastNorth, String> {
    let place = place.ok_or_else(|| format!("a {} needs `{key}`", kind_name(kind)))?;
    let point = match (place.east_m, place.north_m, place.latitude_deg, place.longitude_deg) {
        (Some(east), Some(north), None, None) => EastNorth::new(east, north),
        (None, None, Some(latitude), Some(longitude)) => {
            let position = Position::from_deg(latitude, longitude).map_err(|error| format!("{key}: {error}"))?;
            frame.to_local(position)
        }
        _ => {
            return Err(format!(
                "`{key}` is expected as {{ east_m, north_m }} or {{ latitude_deg, longitude_deg }}"
            ));
        }
    };
    if point.distance_m(EastNorth::default()) <= RADIUS_M {
        Ok(point)
    } else {
        Err(format!("`{key}` is expected within 50 km of the origin"))
    }
}
