//! A calm sea with exact sensors, a vehicle whose properties the limits state exactly, and a fence of rectangles, so
//! that each test can make one thing bad and keep all others good.

use backseat_core::plugin::{ModifyRequest, PositionRequest, Request, TracklineRequest, VerticalRequest};
use backseat_core::{Grant, IntegrityLimits, Limits};
use backseat_mvc::Truth;
use backseat_pair::{Dive, Setup, course_plugin, limits};
use backseat_units::math::hypot;
use backseat_units::{EastNorth, LocalFrame, Position, Timestamp};
use std::time::Duration;

/// The origin of east and north in most of the tests.
pub(super) const ORIGIN: (f64, f64) = (42.0, -70.0);

/// No noise, no drift, no bias.
const EXACT: &str = "
[sensors]
position_noise_m = 0
position_drift_m_per_sqrt_h = 0
depth_noise_m = 0
heading_noise_deg = 0
attitude_noise_deg = 0
velocity_noise_mps = 0
altitude_noise_m = 0
altitude_dropouts_per_h = 0
[sensors.ins]
heading_bias_deg = 0
velocity_walk_mps_per_sqrt_s = 0
[sensors.dvl]
scale_error = 0
misalignment_deg = 0
[sensors.gps]
error_m = 0
";

/// A rectangle of the fence: its kind, its west, south, east and north edges in metres, and further properties.
pub(super) struct Zone(pub(super) &'static str, pub(super) [f64; 4], pub(super) String);

impl Zone {
    pub(super) fn inside(edges_m: [f64; 4]) -> Self {
        Self("keep-in", edges_m, "\"depth_max_m\":60,\"altitude_min_m\":2".to_owned())
    }

    pub(super) fn outside(edges_m: [f64; 4]) -> Self {
        Self("keep-out", edges_m, "\"depth_min_m\":0".to_owned())
    }
}

/// A fence without margins, so that only the envelope keeps the vehicle away from an edge.
pub(super) fn fence(origin: (f64, f64), zones: &[Zone]) -> String {
    let frame = frame(origin);
    let mut features = Vec::new();
    for (index, Zone(kind, [west, south, east, north], more)) in zones.iter().enumerate() {
        let corners = [
            (west, south),
            (east, south),
            (east, north),
            (west, north),
            (west, south),
        ];
        let corners = corners.map(|(east, north)| {
            let position = frame.to_position(EastNorth::new(*east, *north));
            format!("[{},{}]", position.longitude.as_deg(), position.latitude.as_deg())
        });
        features.push(format!(
            "{{\"type\":\"Feature\",\"properties\":{{\"name\":\"zone {index}\",\"kind\":\"{kind}\",\"margin_m\":0,{more}}},\
             \"geometry\":{{\"type\":\"Polygon\",\"coordinates\":[[{}]]}}}}",
            corners.join(",")
        ));
    }
    format!(
        "{{\"type\":\"FeatureCollection\",\"features\":[{}]}}",
        features.join(",")
    )
}

pub(super) fn frame((latitude_deg, longitude_deg): (f64, f64)) -> LocalFrame {
    LocalFrame::new(Position::from_deg(latitude_deg, longitude_deg).expect("a place on the globe"))
}

/// A world: the vehicle's start and heading, its plan, and sections to put before the sensors.
pub(super) fn world(origin: (f64, f64), start: (f64, f64, f64), plan: &str, more: &str) -> String {
    let mut text = format!(
        "[start]\nutc = 2026-06-01T08:00:00Z\neast_m = {}\nnorth_m = {}\nheading_deg = {}\ndepth_m = 20\n\
         [origin]\nlatitude_deg = {}\nlongitude_deg = {}\n\
         [mission]\nstarts_after_s = 1\n[spi]\nprofile = \"field\"\n",
        start.0, start.1, start.2, origin.0, origin.1
    );
    if !more.contains("[vehicle]") {
        text.push_str("[vehicle]\nclass = \"9-inch\"\n");
    }
    if !more.contains("[seabed]") {
        text.push_str("[seabed]\ndepth_m = 90\nslope = 0\nmeanders = 0\n");
    }
    text + plan + "\n" + EXACT + "\n" + more
}

/// A heading for some time, at 20 m and 2 m/s. There is no line to return to, only the place to which it leads.
pub(super) fn setpoint(heading_deg: f64, speed_mps: f64) -> String {
    format!(
        "[[plan]]\nkind = \"setpoint\"\nheading_deg = {heading_deg}\nduration_s = 250\ndepth_m = 20\n\
         speed_mps = {speed_mps}\ndynamic = true\n"
    )
}

/// A line at 20 m and 2 m/s.
pub(super) fn line(from: (f64, f64), to: (f64, f64)) -> String {
    format!(
        "[[plan]]\nkind = \"trackline\"\nstart = {{ east_m = {}, north_m = {} }}\nend = {{ east_m = {}, north_m = {} }}\n\
         depth_m = 20\nspeed_mps = 2\ndynamic = true\n",
        from.0, from.1, to.0, to.1
    )
}

/// Nothing is uncertain except the turn of the 9-inch vehicle, which is a degree a second faster than stated.
pub(super) fn exact() -> Limits {
    Limits {
        integrity: IntegrityLimits {
            position_step_m: 1000.0,
            ..IntegrityLimits::default()
        },
        turn_rate_dps: 14.0,
        plan_speed_max_mps: Some(2.0),
        current_max_mps: 0.0,
        navigation_age_max_s: 1.0,
        navigation_error_m: 0.0,
        // A byte takes 5 ms.
        link_delay_max_s: 0.05,
        tracking_error_m: 0.5,
        vertical_error_m: 0.2,
        lead_max_m: 0.0,
        ..limits()
    }
}

pub(super) fn setup(world: String, fence: String, limits: Limits) -> Setup {
    Setup {
        other_world: Some(world),
        fence: Some(fence),
        limits,
        plugin: course_plugin(&[Grant::Modify, Grant::Insert, Grant::Interrupt, Grant::Surface], &[]),
        ..Setup::default()
    }
}

pub(super) fn place(east_m: f64, north_m: f64) -> PositionRequest {
    frame(ORIGIN).to_position(EastNorth::new(east_m, north_m)).into()
}

/// A line at 20 m that interrupts.
pub(super) fn trackline(from: (f64, f64), to: (f64, f64), speed_mps: f64) -> Request {
    Request::Trackline(TracklineRequest {
        tag: 1,
        start: place(from.0, from.1),
        end: place(to.0, to.1),
        vertical: VerticalRequest::DepthM(20.0),
        speed_mps,
        interrupt: true,
    })
}

/// A modify of a minute at 20 m.
pub(super) fn modify(heading_deg: f64, speed_mps: f64) -> Request {
    Request::Modify(ModifyRequest {
        tag: 1,
        heading_deg,
        vertical: VerticalRequest::DepthM(20.0),
        speed_mps,
        duration: Duration::from_secs(60),
    })
}

/// A clearance of the vehicle's true position, metres.
pub(super) type Clearance<'a> = &'a dyn Fn(&Truth) -> f64;

/// The least value within some bounds, to a five-hundredth of them, for which the monitor accepts the request with tag
/// 1, together with its dive; the lower bound if everything is accepted.
pub(super) fn closest_admitted((from, to): (f64, f64), dive: impl Fn(f64) -> Dive) -> (f64, Dive) {
    let admitted = |value: f64| {
        let dive = dive(value);
        let states = dive.states(1);
        assert!(!states.is_empty(), "it was not asked for");
        (states != ["rejected"]).then_some(dive)
    };
    let (mut refused, mut value) = (from, to);
    let mut best = admitted(to).expect("what is far away is admitted");
    if let Some(dive) = admitted(from) {
        return (from, dive);
    }
    while value - refused > (to - from) / 500.0 {
        let middle = 0.5 * (value + refused);
        match admitted(middle) {
            Some(dive) => (value, best) = (middle, dive),
            None => refused = middle,
        }
    }
    (value, best)
}

/// South of an edge.
pub(super) fn south_of(north_m: f64) -> impl Fn(&Truth) -> f64 {
    move |truth| north_m - truth.local.north_m
}

/// The distance of a position from a rectangle; negative inside.
pub(super) fn outside_of([west_m, south_m, east_m, north_m]: [f64; 4], at: EastNorth) -> f64 {
    let east_m = (west_m - at.east_m).max(at.east_m - east_m);
    let north_m = (south_m - at.north_m).max(at.north_m - north_m);
    if east_m > 0.0 && north_m > 0.0 {
        hypot(east_m, north_m)
    } else {
        east_m.max(north_m)
    }
}

/// Advances the time. Returns the least clearance, measured ten times a second.
pub(super) fn watch(dive: &mut Dive, seconds: f64, clearance: Clearance<'_>) -> f64 {
    let mut least_m = clearance(&dive.mvc.truth());
    for _ in 0..(10.0 * seconds) as u32 {
        dive.run_for(0.1);
        least_m = least_m.min(clearance(&dive.mvc.truth()));
    }
    least_m
}

/// Steers on a heading until the monitor ends the lease, or until some time. Returns whether the monitor has ended it.
/// The speed differs by a millimetre a second from one request to the next, so that BPRMB is sent five times a second:
/// the last accepted request is the closest one to the fence.
pub(super) fn steer(dive: &mut Dive, heading_deg: f64, speed_mps: f64, until: Option<Timestamp>) -> bool {
    let mut asked = false;
    while until.is_none_or(|until| dive.now < until) {
        if asked && !dive.core.is_steering() {
            return true;
        }
        assert!(dive.now < Timestamp::from_millis(300_000), "nothing ends the lease");
        let step = dive.now.as_nanos() / 100_000_000 % 2;
        dive.ask(modify(heading_deg, speed_mps - 0.001 * step as f64));
        // A step of the plugin, and its result.
        dive.run_for(0.1);
        asked = asked || dive.core.is_steering();
    }
    false
}

/// Like [`steer`]; returns when the monitor ended the lease.
pub(super) fn steer_until_refused(dive: &mut Dive, heading_deg: f64, speed_mps: f64) -> Timestamp {
    assert!(steer(dive, heading_deg, speed_mps, None));
    dive.now
}
