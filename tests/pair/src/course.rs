use std::time::Duration;

use backseat_core::plugin::{
    Description, ModifyRequest, PositionRequest, Topic, TrackcircleRequest, TracklineRequest, VerticalRequest,
};
use backseat_core::{FailAction, Grant, Limits, PluginLimits, PluginSetup};
use backseat_fence::Fence;
use backseat_units::EastNorth;

/// About four by four kilometres around 42 N 70 W, with a harbour in the middle where the vehicle may surface.
const FENCE: &str = r#"{"type":"FeatureCollection","features":[
{"type":"Feature","properties":{"name":"box","kind":"keep-in","margin_m":10,"depth_max_m":60,"altitude_min_m":2},
 "geometry":{"type":"Polygon","coordinates":[[[-70.024,41.982],[-69.976,41.982],[-69.976,42.018],[-70.024,42.018],[-70.024,41.982]]]}},
{"type":"Feature","properties":{"name":"harbour","kind":"keep-in","margin_m":10,"depth_max_m":60,"altitude_min_m":2,"surfacing":true},
 "geometry":{"type":"Polygon","coordinates":[[[-70.0218,41.9919],[-69.9782,41.9919],[-69.9782,42.0081],[-70.0218,42.0081],[-70.0218,41.9919]]]}}
]}"#;

/// The vehicle's world: flat, 90 m deep, calm, with exact sensors; a long line to the east during which the backseat
/// may steer, then two waypoints without it. A test may append sections.
const WORLD: &str = r#"
[start]
utc = 2026-06-01T08:00:00Z
east_m = -620
depth_m = 20
heading_deg = 90
[origin]
latitude_deg = 42.0
longitude_deg = -70.0
[seabed]
depth_m = 90
slope = 0
meanders = 0
[mission]
starts_after_s = 1
[spi]
profile = "field"
[[plan]]
kind = "trackline"
start = { east_m = -600, north_m = 0 }
end = { east_m = 600, north_m = 0 }
depth_m = 20
speed_mps = 1.5
dynamic = true
[[plan]]
kind = "waypoint"
at = { east_m = 600, north_m = 300 }
depth_m = 20
speed_mps = 1.5
[[plan]]
kind = "waypoint"
at = { east_m = 0, north_m = 300 }
depth_m = 20
speed_mps = 1.5
"#;

pub(crate) fn world(more: &str) -> String {
    format!("{WORLD}\n{more}")
}

pub(crate) fn fence() -> Fence {
    Fence::from_geojson(FENCE).expect("the course's fence is right")
}

/// The limits of the plugin's requests.
#[must_use]
pub fn limits() -> Limits {
    Limits {
        integrity: backseat_core::IntegrityLimits::default(),
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

/// A plugin with these grants and topics, stepped every 100 ms.
#[must_use]
pub fn course_plugin(grants: &[Grant], topics: &[Topic]) -> PluginSetup {
    PluginSetup {
        name: "scripted".to_owned(),
        description: Description {
            name: "scripted".to_owned(),
            version: "1".to_owned(),
            step_period: Duration::from_millis(100),
            topics: topics.to_vec(),
        },
        grants: grants.to_vec(),
        on_failure: FailAction::Yield,
        limits: PluginLimits::default(),
    }
}

/// A point this many metres east and north of the course's middle.
#[must_use]
pub fn place(east_m: f64, north_m: f64) -> PositionRequest {
    fence().frame().to_position(EastNorth::new(east_m, north_m)).into()
}

/// A heading for some time, at 25 m and 1.5 m/s.
#[must_use]
pub fn modify(tag: u64, heading_deg: f64, seconds: u64) -> ModifyRequest {
    ModifyRequest {
        tag,
        heading_deg,
        vertical: VerticalRequest::DepthM(25.0),
        speed_mps: 1.5,
        duration: Duration::from_secs(seconds),
    }
}

/// A line at 20 m and 1.5 m/s.
#[must_use]
pub fn line(tag: u64, from: (f64, f64), to: (f64, f64), interrupt: bool) -> TracklineRequest {
    TracklineRequest {
        tag,
        start: place(from.0, from.1),
        end: place(to.0, to.1),
        vertical: VerticalRequest::DepthM(20.0),
        speed_mps: 1.5,
        interrupt,
    }
}

/// One orbit at 20 m and 1.5 m/s.
#[must_use]
pub fn circle(tag: u64, centre: (f64, f64), radius_m: f64) -> TrackcircleRequest {
    TrackcircleRequest {
        tag,
        centre: place(centre.0, centre.1),
        radius_m,
        orbits: 1.0,
        vertical: VerticalRequest::DepthM(20.0),
        speed_mps: 1.5,
        entry_angle_deg: Some(0.0),
        interrupt: true,
    }
}
