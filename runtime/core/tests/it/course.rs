//! The scene of the trials: a fence of some four by four kilometres at 42 N 70 W, the plan inside it, and the limits.

use std::sync::{Arc, LazyLock};
use std::time::Duration;

use backseat_core::plugin::{Description, ModifyRequest, PositionRequest, Request, Topic, VerticalRequest};
use backseat_core::plugin::{TrackcircleRequest, TracklineRequest};
use backseat_core::{Envelope, FailAction, Grant, IntegrityLimits, Limits, PluginLimits, PluginSetup};
use backseat_fence::Fence;
use backseat_units::EastNorth;

const FENCE: &str = r#"{"type":"FeatureCollection","features":[
{"type":"Feature","properties":{"name":"box","kind":"keep-in","margin_m":10,"depth_max_m":60,"altitude_min_m":2},
 "geometry":{"type":"Polygon","coordinates":[[[-70.024,41.982],[-69.976,41.982],[-69.976,42.018],[-70.024,42.018],[-70.024,41.982]]]}},
{"type":"Feature","properties":{"name":"wreck","kind":"keep-out","margin_m":20},
 "geometry":{"type":"Polygon","coordinates":[[[-70.001,41.990],[-69.999,41.990],[-69.999,41.992],[-70.001,41.992],[-70.001,41.990]]]}}
]}"#;

const HARBOUR: &str = r#"{"type":"FeatureCollection","features":[
{"type":"Feature","properties":{"name":"box","kind":"keep-in","margin_m":10,"depth_max_m":60,"altitude_min_m":2},
 "geometry":{"type":"Polygon","coordinates":[[[-70.024,41.982],[-69.976,41.982],[-69.976,42.018],[-70.024,42.018],[-70.024,41.982]]]}},
{"type":"Feature","properties":{"name":"harbour","kind":"keep-in","margin_m":10,"depth_min_m":5,"depth_max_m":60,"altitude_min_m":2,"surfacing":true},
 "geometry":{"type":"Polygon","coordinates":[[[-70.0218,41.9919],[-69.9782,41.9919],[-69.9782,42.0081],[-70.0218,42.0081],[-70.0218,41.9919]]]}},
{"type":"Feature","properties":{"name":"shoals","kind":"keep-out","margin_m":10,"depth_max_m":5},
 "geometry":{"type":"Polygon","coordinates":[[[-69.98815,42.0020],[-69.98765,42.0020],[-69.98765,42.0029],[-69.98815,42.0029],[-69.98815,42.0020]]]}}
]}"#;

static PARSED: LazyLock<Fence> = LazyLock::new(|| Fence::from_geojson(FENCE).unwrap());

/// The box reaches some 1990 m east and west and 2000 m north and south of its middle; the wreck lies 890 to 1110 m
/// south of it.
pub(crate) fn fence() -> Fence {
    PARSED.clone()
}

/// The same box without the wreck; the vehicle may surface in a harbour that reaches some 1800 m east and west and 900 m
/// north and south of the middle. In its east, 1000 m from the middle and 220 to 320 m to the north, lie shoals of 5 m.
pub(crate) fn harbour() -> Fence {
    Fence::from_geojson(HARBOUR).unwrap()
}

/// The harbour with a keep-out zone that holds from 30 m down. It lies 760 to 800 m west of the middle and 400 to 600 m
/// north of it.
pub(crate) fn harbour_with_pit() -> Fence {
    let pit = r#"{"type":"Feature","properties":{"name":"pit","kind":"keep-out","margin_m":10,"depth_min_m":30},
 "geometry":{"type":"Polygon","coordinates":[[[-70.00965,42.0036],[-70.00917,42.0036],[-70.00917,42.0054],[-70.00965,42.0054],[-70.00965,42.0036]]]}},"#;
    let (before, zones) = HARBOUR.split_once('\n').unwrap();
    Fence::from_geojson(&format!("{before}\n{pit}\n{zones}")).unwrap()
}

/// The planned behaviors by number: a line to the east, then two waypoints.
pub(crate) const PLAN: [(u32, &[(f64, f64)]); 3] = [
    (1, &[(-600.0, 0.0), (600.0, 0.0)]),
    (2, &[(600.0, 300.0)]),
    (3, &[(0.0, 300.0)]),
];

/// Integrity limits under which a test may put the vehicle at another depth, or over another seabed, at once.
pub(crate) const LIFTED: IntegrityLimits = IntegrityLimits {
    speed_max_mps: None,
    position_step_m: 10.0,
    position_drift_mps: 0.3,
    depth_rate_max_mps: 2.5,
    depth_step_m: 200.0,
    depth_drift_mps: 0.5,
    heading_step_deg: 60.0,
    heading_drift_dps: 5.0,
    frozen_s: 8.0,
    velocity_gap_s: 1.5,
    seabed_step_m: 200.0,
};

pub(crate) fn limits() -> Limits {
    Limits {
        integrity: IntegrityLimits::default(),
        speed_min_mps: 1.0,
        speed_max_mps: 2.0,
        turn_rate_dps: 8.0,
        turn_lag_s: 0.0,
        plan_speed_max_mps: None,
        climb_angle_min_deg: 90.0,
        current_max_mps: 0.3,
        water_depth_min_m: Some(80.0),
        water_depth_max_m: Some(100.0),
        seabed_slope_max: 0.1,
        navigation_age_max_s: 1.0,
        navigation_error_m: 5.0,
        link_delay_max_s: 1.0,
        tracking_error_m: 5.0,
        vertical_error_m: 1.0,
        lead_max_m: 50.0,
        modify_term_max_s: 60.0,
        inserts_open_max: 4,
        inserts_total_max: 100,
        inserts_duration_max_s: 7200.0,
        requests_per_s: 20,
        gps_hits_total_max: 10,
        gps_hit_duration_max_s: 900.0,
        adjustments_total_max: 10,
        silences_total_max: 20,
        silent_term_s: 300.0,
        topside_per_min: 6,
        packets_per_min: 12,
        modify_needs_plan: true,
        station: None,
    }
}

pub(crate) fn envelope(limits: Limits) -> Arc<Envelope> {
    envelope_of(fence(), limits)
}

pub(crate) fn envelope_of(fence: Fence, limits: Limits) -> Arc<Envelope> {
    limits.validate().unwrap();
    Arc::new(Envelope::new(fence, limits))
}

/// A plugin with the usual grants and topics, stepped every 100 ms.
pub(crate) fn plugin(name: &str) -> PluginSetup {
    PluginSetup {
        name: name.to_owned(),
        description: Description {
            name: name.to_owned(),
            version: "1".to_owned(),
            step_period: Duration::from_millis(100),
            topics: vec![Topic::Ctd, Topic::MissionCommand, Topic::Behavior],
        },
        grants: vec![Grant::Modify, Grant::Insert, Grant::Interrupt, Grant::Message],
        on_failure: FailAction::Yield,
        limits: PluginLimits::default(),
    }
}

pub(crate) fn at(east_m: f64, north_m: f64) -> PositionRequest {
    fence().frame().to_position(EastNorth::new(east_m, north_m)).into()
}

/// A modify: east at a depth of 20 m and 1.5 m/s for 30 s.
pub(crate) fn modify(tag: u64) -> ModifyRequest {
    ModifyRequest {
        tag,
        heading_deg: 90.0,
        vertical: VerticalRequest::DepthM(20.0),
        speed_mps: 1.5,
        duration: Duration::from_secs(30),
    }
}

/// Like [`modify`], with another heading.
pub(crate) fn turn(tag: u64, heading_deg: f64) -> Request {
    Request::Modify(ModifyRequest {
        heading_deg,
        ..modify(tag)
    })
}

/// Like [`modify`], with another term.
pub(crate) fn modify_for(tag: u64, duration: Duration) -> Request {
    Request::Modify(ModifyRequest {
        duration,
        ..modify(tag)
    })
}

pub(crate) fn line(tag: u64, from: (f64, f64), to: (f64, f64)) -> TracklineRequest {
    TracklineRequest {
        tag,
        start: at(from.0, from.1),
        end: at(to.0, to.1),
        vertical: VerticalRequest::DepthM(20.0),
        speed_mps: 1.5,
        interrupt: false,
    }
}

/// A line of 300 m in the middle of the box.
pub(crate) fn good_line(tag: u64) -> Request {
    Request::Trackline(line(tag, (0.0, 500.0), (300.0, 500.0)))
}

/// Like [`good_line`], but it interrupts the current behavior.
pub(crate) fn interrupting(tag: u64) -> Request {
    Request::Trackline(TracklineRequest {
        interrupt: true,
        ..line(tag, (0.0, 500.0), (300.0, 500.0))
    })
}

pub(crate) fn circle(tag: u64, centre: (f64, f64), radius_m: f64) -> TrackcircleRequest {
    TrackcircleRequest {
        tag,
        centre: at(centre.0, centre.1),
        radius_m,
        orbits: 1.0,
        vertical: VerticalRequest::DepthM(20.0),
        speed_mps: 1.5,
        entry_angle_deg: Some(0.0),
        interrupt: false,
    }
}
