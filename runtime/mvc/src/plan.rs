use core::time::Duration;

use backseat_units::{EastNorth, LocalFrame, Position};

use crate::error::MvcError;
use crate::file::{PlaceConfig, PlanEntry, PlanKind, VehicleConfig};

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
}

impl Shape {
    /// The behavior type that BFMBS and BFMBE carry (SPI 6.9).
    pub(crate) const fn kind(&self) -> &'static str {
        match self {
            Self::Waypoint { .. } => "waypoint",
            Self::Trackline { .. } => "trackline",
            Self::Setpoint { .. } => "setpoint",
            Self::Trackcircle { .. } => "trackcircle",
        }
    }
}

/// What the vehicle holds vertically.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Vertical {
    Depth(f64),
    Altitude(f64),
    /// Degrees, positive up.
    Pitch(f64),
}

/// One element of the front seat's plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PlanItem {
    pub(crate) number: u32,
    pub(crate) shape: Shape,
    pub(crate) vertical: Vertical,
    pub(crate) speed_mps: f64,
    /// When, after its begin, dynamic requests are allowed.
    pub(crate) dynamic: Option<(Duration, Duration)>,
    pub(crate) timeout: Option<Duration>,
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
    for (number, entry) in (1..).zip(entries) {
        items.push(item(entry, number, frame, vehicle).map_err(|fault| MvcError::Plan { number, fault })?);
    }
    Ok(items)
}

fn item(entry: &PlanEntry, number: u32, frame: &LocalFrame, vehicle: &VehicleConfig) -> Result<PlanItem, String> {
    let hull = vehicle.hull();
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
    let vertical = match (entry.depth_m, entry.altitude_m) {
        (Some(depth), None) if (0.0..=hull.depth_max_m).contains(&depth) => Vertical::Depth(depth),
        (Some(depth), None) => return Err(format!("depth_m is {depth}, expected 0 to {}", hull.depth_max_m)),
        (None, Some(altitude)) if (vehicle.altitude_min_m..=1000.0).contains(&altitude) => Vertical::Altitude(altitude),
        (None, Some(altitude)) => {
            return Err(format!(
                "altitude_m is {altitude}, expected {} to 1000",
                vehicle.altitude_min_m
            ));
        }
        (Some(_), Some(_)) | (None, None) => return Err("expected one of `depth_m` and `altitude_m`".to_owned()),
    };
    let speed_mps = entry.speed_mps;
    // Without way on a line never ends; a setpoint does, and a hovering hull may stand still for it.
    let least = if entry.kind == PlanKind::Setpoint {
        hull.speed_min_mps
    } else {
        hull.speed_min_mps.max(0.05)
    };
    let most = hull.speed_max_mps;
    if !(least..=most).contains(&speed_mps) {
        return Err(format!("speed_mps is {speed_mps}, expected {least} to {most}"));
    }
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
        number,
        shape,
        vertical,
        speed_mps,
        dynamic: window(entry)?,
        timeout,
    })
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
    ];
    // What is missing is said first: it is the commoner cause of a key too many.
    for (key, present, of) in keys {
        if !present && of == kind && key != "entry_angle_deg" {
            return Err(format!("a {} needs `{key}`", kind_name(kind)));
        }
    }
    for (key, present, of) in keys {
        if present && of != kind {
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
