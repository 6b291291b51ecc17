//! Where the vehicle is: a fence of some 2500 by 800 metres at 42 N 70 W, the plan in it, and the mission's figures.

use std::sync::{Arc, LazyLock};
use std::time::Duration;

use backseat_core::plugin::{
    Description, ModifyRequest, PositionRequest, Request, StationRequest, StationTarget, TracklineRequest,
    VerticalRequest,
};
use backseat_core::{
    BottomBox, Envelope, FailAction, Grant, HullBox, Identifiers, IntegrityLimits, Limits, PluginLimits, PluginSetup,
    Settings, Start, StationLimits,
};
use backseat_fence::Fence;
use backseat_units::{EastNorth, LocalFrame, Utc};

use crate::world::Ask;

/// South, north, west and east, degrees. North and south are 400 m from the plan's line.
pub(crate) const EDGES_DEG: [f64; 4] = [41.9964, 42.0036, -70.015, -69.985];
/// Our clock at the start, and the vehicle's.
pub(crate) const UTC: Utc = Utc::from_unix_nanos(1_700_000_000_000_000_000);
/// Where the vehicle starts, metres east of the middle.
pub(crate) const START_EAST_M: f64 = -600.0;
pub(crate) const SPEED_MPS: f64 = 1.0;
pub(crate) const DEPTH_M: f64 = 20.0;
/// A place 6 m from the margin of the northern edge, and one beyond it, metres north.
pub(crate) const ASIDE_NORTH_M: f64 = 384.0;
pub(crate) const OUTSIDE_NORTH_M: f64 = 900.0;
/// How old navigation may be, seconds. It comes each second.
pub(crate) const AGE_MAX_S: f64 = 2.0;
pub(crate) const DELAY_MAX_S: f64 = 1.0;
/// How many inserts may be open.
pub(crate) const OPEN_MAX: u32 = 2;
/// For how long a lease is asked for.
pub(crate) const TERM: Duration = Duration::from_secs(30);
/// The planned behaviors by number: a line to the east, then two waypoints.
pub(crate) const PLAN: [(u32, &[(f64, f64)]); 3] = [
    (1, &[(-600.0, 0.0), (600.0, 0.0)]),
    (2, &[(600.0, 100.0)]),
    (3, &[(0.0, 100.0)]),
];

static FENCE: LazyLock<Fence> = LazyLock::new(|| {
    let [south, north, west, east] = EDGES_DEG;
    let text = format!(
        r#"{{"type":"FeatureCollection","features":[{{"type":"Feature",
        "properties":{{"name":"box","kind":"keep-in","margin_m":10,"depth_max_m":60,"altitude_min_m":2}},
        "geometry":{{"type":"Polygon","coordinates":
        [[[{west},{south}],[{east},{south}],[{east},{north}],[{west},{north}],[{west},{south}]]]}}}}]}}"#
    );
    Fence::from_geojson(&text).expect("the fence is a rectangle")
});

static FRONT: LazyLock<Arc<Envelope>> = LazyLock::new(|| Arc::new(Envelope::new(FENCE.clone(), limits(None))));
static HOVERS: LazyLock<Arc<Envelope>> =
    LazyLock::new(|| Arc::new(Envelope::new(FENCE.clone(), limits(Some(station())))));

pub(crate) fn frame() -> LocalFrame {
    *FENCE.frame()
}

pub(crate) fn envelope(hovers: bool) -> Arc<Envelope> {
    Arc::clone(if hovers { &HOVERS } else { &FRONT })
}

fn limits(station: Option<StationLimits>) -> Limits {
    let limits = Limits {
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
        navigation_age_max_s: AGE_MAX_S,
        navigation_error_m: 5.0,
        link_delay_max_s: DELAY_MAX_S,
        tracking_error_m: 5.0,
        vertical_error_m: 1.0,
        lead_max_m: 50.0,
        modify_term_max_s: 60.0,
        inserts_open_max: OPEN_MAX,
        inserts_total_max: 100,
        inserts_duration_max_s: 7200.0,
        requests_per_s: 20,
        gps_hits_total_max: 0,
        gps_hit_duration_max_s: 900.0,
        adjustments_total_max: 0,
        silences_total_max: 0,
        silent_term_s: 300.0,
        topside_per_min: 6,
        packets_per_min: 12,
        modify_needs_plan: true,
        station,
    };
    limits.validate().expect("the limits are right");
    limits
}

fn station() -> StationLimits {
    StationLimits {
        speed_max_mps: 0.5,
        speed_default_mps: 1.5,
        position_error_m: 0.5,
        relative_age_max_s: AGE_MAX_S,
        jump_allowance_m: 2.0,
        term_max_s: 60.0,
        altitude_min_m: 2.0,
        sonar_angle_min_deg: None,
        sonar_angle_max_deg: None,
        hull_box: Some(HullBox {
            name: String::new(),
            horizontal_min_m: -50.0,
            horizontal_max_m: 50.0,
            vertical_min_m: -5.0,
            vertical_max_m: 20.0,
            distance_min_m: 1.0,
            distance_max_m: 15.0,
        }),
        bottom_box: Some(BottomBox {
            name: String::new(),
            x_min_m: -50.0,
            x_max_m: 50.0,
            y_min_m: -50.0,
            y_max_m: 50.0,
            depth_min_m: 2.0,
            depth_max_m: 30.0,
        }),
        keep_out_hull: Vec::new(),
        keep_out_bottom: Vec::new(),
    }
}

pub(crate) fn settings() -> Settings {
    Settings {
        trackcircle_entry_angle: Some(true),
        ..Settings::default()
    }
}

/// One plugin that is stepped each second.
pub(crate) fn plugin(hovers: bool) -> PluginSetup {
    let mut grants = vec![Grant::Modify, Grant::Insert, Grant::Interrupt];
    if hovers {
        grants.push(Grant::Station);
    }
    PluginSetup {
        name: "plugin".to_owned(),
        description: Description {
            name: "plugin".to_owned(),
            version: "1".to_owned(),
            step_period: Duration::from_secs(1),
            topics: Vec::new(),
        },
        grants,
        on_failure: FailAction::Cancel,
        limits: PluginLimits::default(),
    }
}

/// Of a process that is the first, or that follows one which has sent so many inserts.
pub(crate) fn start(inserts_before: u32) -> Start {
    Start {
        utc: UTC,
        identifiers: Some(Identifiers {
            next: 1 + inserts_before,
            reserved: 1 + inserts_before,
            first: 1,
            inserts: inserts_before,
            gps_hits: 0,
        }),
        armed: true,
        held: false,
        jitter: 7,
    }
}

/// What a plugin returns for what it is to ask, an insert under this tag.
pub(crate) fn request(ask: Ask, tag: u64) -> Request {
    let at = |east_m, north_m| PositionRequest::from(frame().to_position(EastNorth::new(east_m, north_m)));
    let line = |north_m, interrupt| {
        Request::Trackline(TracklineRequest {
            tag,
            start: at(0.0, north_m),
            end: at(300.0, north_m),
            vertical: VerticalRequest::DepthM(DEPTH_M),
            speed_mps: 1.5,
            interrupt,
        })
    };
    match ask {
        Ask::Modify => Request::Modify(ModifyRequest {
            tag: 0,
            heading_deg: 0.0,
            vertical: VerticalRequest::DepthM(DEPTH_M),
            speed_mps: 1.5,
            duration: TERM,
        }),
        Ask::End => Request::EndModify,
        Ask::Insert => line(200.0, false),
        Ask::Interrupt => line(200.0, true),
        Ask::Outside => line(OUTSIDE_NORTH_M, false),
        Ask::Cancel => Request::Cancel(tag),
        Ask::Station => Request::Station(StationRequest {
            tag: 0,
            target: StationTarget::Here,
            speed_mps: None,
            duration: TERM,
        }),
    }
}
