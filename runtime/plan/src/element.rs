use core::time::Duration;

use backseat_spi::Text;
use backseat_units::{EastNorth, LocalFrame, Position};

use crate::class::VehicleLimits;
use crate::entry::{PlaceConfig, PlanEntry, PlanKind};
use crate::error::PlanError;

/// The path of an element, in the frame of the plan's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Course {
    /// Straight to a point.
    Waypoint {
        /// The destination.
        to: EastNorth,
    },
    /// To a line's start, then along it.
    Trackline {
        /// Where the line begins, without its lead-in.
        start: EastNorth,
        /// Where it ends, without its lead-out.
        end: EastNorth,
    },
    /// A heading for some time.
    Setpoint {
        /// Degrees from true north.
        heading_deg: f64,
        /// The time.
        duration: Duration,
    },
    /// To a circle and around it.
    Trackcircle {
        /// Its centre.
        centre: EastNorth,
        /// Its radius, metres.
        radius_m: f64,
        /// The number of rounds; negative is counterclockwise.
        orbits: f64,
        /// Where on the circle the vehicle begins, degrees clockwise from the frame's north as seen from the centre;
        /// the nearest point if missing.
        entry_deg: Option<f64>,
    },
    /// A text to the payload, without a path.
    Command,
}

/// The vertical setpoint of an element, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlannedVertical {
    /// Below the surface.
    Depth(f64),
    /// Above the seabed.
    Altitude(f64),
}

/// One behavior of a checked plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanElement {
    /// Behavior number in the dive file, from 1 (SPI 6.9).
    pub number: u32,
    /// The planner-level element that it belongs to, from 1 (SPI 7.11).
    pub element: u32,
    /// The path as planned, without lead-in and lead-out.
    pub course: Course,
    /// Length of lead-in and lead-out, metres.
    pub lead_m: f64,
    /// The vertical setpoint.
    pub vertical: PlannedVertical,
    /// Speed through the water, metres a second; 0 if the vehicle does not move.
    pub speed_mps: f64,
    /// When dynamic requests are allowed, counted from the beginning of the element.
    pub dynamic: Option<(Duration, Duration)>,
    /// The behavior ends by itself after this time.
    pub timeout: Option<Duration>,
    /// The text to the payload: a command, or the message of a trackline or trackcircle.
    pub message: Option<PayloadText>,
}

/// A text to the payload, and the client that receives it.
#[derive(Clone, Debug, PartialEq)]
pub struct PayloadText {
    /// The role of the client that receives it; every client if missing.
    pub role: Option<Box<str>>,
    /// The text.
    pub text: Text,
}

/// A line extended by a lead-in and a lead-out, whose lengths are in metres.
#[must_use]
pub fn with_leads(start: EastNorth, end: EastNorth, lead_m: f64) -> (EastNorth, EastNorth) {
    let lead = (end - start) * (lead_m / start.distance_m(end).max(1.0));
    (start - lead, end + lead)
}

/// A plan with more elements is probably a script's mistake.
const ELEMENTS_MAX: usize = 10_000;

/// The behaviors of a plan, in the order of flight, checked against what the vehicle can do.
///
/// # Errors
///
/// [`PlanError`] with the element that is invalid or that this vehicle cannot fly.
pub fn resolve(
    entries: &[PlanEntry],
    frame: &LocalFrame,
    vehicle: &VehicleLimits,
) -> Result<Vec<PlanElement>, PlanError> {
    if entries.is_empty() || entries.len() > ELEMENTS_MAX {
        return Err(PlanError::Length(entries.len()));
    }
    let mut items = Vec::with_capacity(entries.len());
    for (element, entry) in (1..).zip(entries) {
        let mut item =
            item(entry, element, frame, vehicle).map_err(|fault| PlanError::Element { number: element, fault })?;
        if entry.separate_transit {
            let transit = transit(&item);
            items.push(PlanElement {
                number: items.len() as u32 + 1,
                ..transit
            });
        }
        item.number = items.len() as u32 + 1;
        items.push(item);
    }
    Ok(items)
}

/// The way to the beginning of a line or circle, as a behavior of its own.
fn transit(item: &PlanElement) -> PlanElement {
    let to = match item.course {
        Course::Trackline { start, end } => with_leads(start, end, item.lead_m).0,
        Course::Trackcircle {
            centre,
            radius_m,
            entry_deg,
            ..
        } => centre.offset(entry_deg.unwrap_or(0.0), radius_m),
        Course::Waypoint { to } => to,
        Course::Setpoint { .. } | Course::Command => EastNorth::default(),
    };
    PlanElement {
        course: Course::Waypoint { to },
        lead_m: 0.0,
        message: None,
        ..item.clone()
    }
}

fn item(entry: &PlanEntry, element: u32, frame: &LocalFrame, vehicle: &VehicleLimits) -> Result<PlanElement, String> {
    refuse_foreign_keys(entry)?;
    let place = |key: &str, place: Option<PlaceConfig>| resolve_place(entry.kind, key, place, frame);
    let course = match entry.kind {
        PlanKind::Waypoint => Course::Waypoint {
            to: place("at", entry.at)?,
        },
        PlanKind::Trackline => {
            let (start, end) = (place("start", entry.start)?, place("end", entry.end)?);
            if start.distance_m(end) < 1.0 {
                return Err("`start` and `end` must be at least 1 m apart".to_owned());
            }
            Course::Trackline { start, end }
        }
        PlanKind::Setpoint => {
            let heading_deg = number_in(entry, "heading_deg", entry.heading_deg, -360.0, 360.0)?;
            let duration_s = number_in(entry, "duration_s", entry.duration_s, 1.0, 1e6)?;
            Course::Setpoint {
                heading_deg,
                duration: Duration::from_secs_f64(duration_s),
            }
        }
        PlanKind::Command => Course::Command,
        PlanKind::Trackcircle => {
            let orbits = number_in(entry, "orbits", entry.orbits, -1000.0, 1000.0)?;
            if orbits.abs() < 0.01 {
                return Err(format!("orbits is {orbits}, expected 0.01 to 1000 either way"));
            }
            Course::Trackcircle {
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
    Ok(PlanElement {
        number: 0,
        element,
        course,
        lead_m,
        vertical,
        speed_mps,
        dynamic: window(entry)?,
        timeout,
        message: message(entry)?,
    })
}

fn vertical(entry: &PlanEntry, vehicle: &VehicleLimits) -> Result<PlannedVertical, String> {
    let depth_max_m = vehicle.depth_max_m;
    match (entry.depth_m, entry.altitude_m) {
        (Some(depth), None) if (0.0..=depth_max_m).contains(&depth) => Ok(PlannedVertical::Depth(depth)),
        (Some(depth), None) => Err(format!("depth_m is {depth}, expected 0 to {depth_max_m}")),
        (None, Some(altitude)) if (vehicle.altitude_min_m..=1000.0).contains(&altitude) => {
            Ok(PlannedVertical::Altitude(altitude))
        }
        (None, Some(altitude)) => Err(format!(
            "altitude_m is {altitude}, expected {} to 1000",
            vehicle.altitude_min_m
        )),
        (Some(_), Some(_)) | (None, None) => Err("expected one of `depth_m` and `altitude_m`".to_owned()),
    }
}

fn speed_mps(entry: &PlanEntry, vehicle: &VehicleLimits) -> Result<f64, String> {
    // A vehicle that does not move never completes a line. A setpoint ends by time, so a vehicle may stop for it.
    let stops = entry.kind == PlanKind::Setpoint;
    if stops && entry.speed_mps == Some(0.0) {
        return Ok(0.0);
    }
    let least = vehicle.speed_min_mps.max(if stops { 0.0 } else { 0.05 });
    let checked = number_in(entry, "speed_mps", entry.speed_mps, least, vehicle.speed_max_mps);
    checked.map_err(|fault| {
        if stops && least > 0.0 {
            format!("{fault}, or 0")
        } else {
            fault
        }
    })
}

/// Checks that a command has neither depth nor speed, because it moves nothing.
fn no_motion(entry: &PlanEntry) -> Result<(PlannedVertical, f64), String> {
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
    Ok((PlannedVertical::Depth(0.0), 0.0))
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

/// Refuses keys that only other kinds of element have.
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
        ("text", entry.text.is_some(), PlanKind::Command),
    ];
    let optional = ["entry_angle_deg", "lead_in_m"];
    // Missing keys are reported first, because they are the usual cause of a key too many.
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
    for (key, present) in [
        ("separate_transit", entry.separate_transit),
        ("payload_message", entry.payload_message.is_some()),
    ] {
        if present && !matches!(kind, PlanKind::Trackline | PlanKind::Trackcircle) {
            return Err(format!("a {} has no `{key}`", kind_name(kind)));
        }
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
    if point.distance_m(EastNorth::default()) <= LocalFrame::RADIUS_M {
        Ok(point)
    } else {
        Err(format!("`{key}` is expected within 50 km of the origin"))
    }
}
