use std::time::Duration;

use backseat_fence::{Fence, Kind, Zone};
use backseat_units::{EastNorth, Utc};

use super::wit_mission::{Area, Briefing, Budget, KeepIn, Limits, Point};
use super::{nanos, wit_mission};
use crate::Brief;

/// What a plugin is told before its first step.
pub(crate) fn briefing(brief: &Brief<'_>, budget: &crate::Budget) -> Briefing {
    Briefing {
        config: brief.config_json.to_owned(),
        grants: brief.grants.iter().copied().map(Into::into).collect(),
        origin: brief.fence.frame().origin().into(),
        zones: zones(brief.fence),
        limits: limits(brief.limits),
        budget: Budget {
            fuel_per_step: budget.fuel_per_step,
            fuel_init: budget.fuel_init,
            fuel_snapshot: budget.fuel_snapshot,
            memory: budget.memory_bytes as u64,
            snapshot_every_steps: budget.snapshot_every_steps,
        },
    }
}

fn zones(fence: &Fence) -> Vec<wit_mission::Zone> {
    fence.zones().map(zone).collect()
}

fn zone(zone: &Zone) -> wit_mission::Zone {
    let (keep_in, depth) = match zone.kind() {
        Kind::KeepIn {
            depth,
            altitude_min_m,
            surfacing,
        } => (
            Some(KeepIn {
                altitude_min: altitude_min_m,
                surfacing,
            }),
            Some(depth),
        ),
        Kind::KeepOut { depth } => (None, depth),
    };
    // The band of a keep-out zone may be infinite on one side.
    let bound = |depth_m: f64| Some(depth_m).filter(|depth_m| depth_m.is_finite());
    let window = zone.window();
    wit_mission::Zone {
        name: zone.name().to_owned(),
        keep_in,
        margin: zone.margin_m(),
        depth_min: depth.and_then(|band| bound(band.min_m)),
        depth_max: depth.and_then(|band| bound(band.max_m)),
        valid_from_ns: window.from.map(Utc::as_unix_nanos),
        valid_until_ns: window.until.map(Utc::as_unix_nanos),
        areas: areas(zone),
    }
}

/// The areas of a zone. Its rings come in order, each outer one before its holes.
fn areas(zone: &Zone) -> Vec<Area> {
    let mut areas: Vec<Area> = Vec::new();
    for ring in zone.rings() {
        let points = open(ring.points);
        match areas.last_mut().filter(|_| ring.hole.is_some()) {
            Some(area) => area.holes.push(points),
            None => areas.push(Area {
                outer: points,
                holes: Vec::new(),
            }),
        }
    }
    areas
}

/// A ring without the repetition of its first point.
fn open(points: &[EastNorth]) -> Vec<Point> {
    let points = points.split_last().map_or(points, |(_, before)| before);
    points
        .iter()
        .map(|point| Point {
            east: point.east_m,
            north: point.north_m,
        })
        .collect()
}

fn limits(limits: &backseat_core::Limits) -> Limits {
    Limits {
        speed_min: limits.speed_min_mps,
        speed_max: limits.speed_max_mps,
        turn_rate: limits.turn_rate_dps,
        current_max: limits.current_max_mps,
        water_depth_min: limits.water_depth_min_m,
        water_depth_max: limits.water_depth_max_m,
        seabed_slope_max: limits.seabed_slope_max,
        navigation_error: limits.navigation_error_m,
        tracking_error: limits.tracking_error_m,
        vertical_error: limits.vertical_error_m,
        lead_max: limits.lead_max_m,
        modify_duration_max_ns: seconds(limits.modify_term_max_s),
        inserts_open_max: limits.inserts_open_max,
        inserts_total_max: limits.inserts_total_max,
        inserts_duration_max_ns: seconds(limits.inserts_duration_max_s),
        requests_per_second: limits.requests_per_s,
        gps_hits_total_max: limits.gps_hits_total_max,
        topside_per_minute: limits.topside_per_min,
        packets_per_minute: limits.packets_per_min,
    }
}

/// A limit in seconds. An invalid value becomes zero, as in core.
fn seconds(seconds: f64) -> u64 {
    Duration::try_from_secs_f64(seconds).map_or(0, nanos)
}
