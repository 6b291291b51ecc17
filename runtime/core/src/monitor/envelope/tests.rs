//! The numbers that a judgement is made of: how long, how far, how deep and when, each against its formula. Whole
//! trials judge them too, but notice a wrong one only if an answer changes.

use std::time::Duration;

use backseat_fence::{Fence, Rfc3339};
use backseat_units::math::cos;
use backseat_units::{Timestamp, Utc};

use super::*;
use crate::monitor::limits::tests::limits;

mod insert;
mod modify;
mod motion;
mod place;
mod station;
mod ways;

const START: Utc = Utc::from_unix_nanos(1_700_000_000_000_000_000);
/// Our clock, and the vehicle's three seconds off it.
const CLOCKS: Clocks = Clocks {
    utc: START,
    apart: Some(Duration::from_secs(3)),
};
fn at(east_m: f64, north_m: f64) -> EastNorth {
    EastNorth::new(east_m, north_m)
}

/// A box 3 km wide to 100 m depth, 2 m above the seabed, where the vehicle may surface; and a keep-out zone over the
/// northern half of it with these properties.
fn fence_with(north: Option<&str>) -> Fence {
    let north = north.map_or(String::new(), |properties| {
        format!(
            r#",{{"type":"Feature","properties":{{"name":"north","kind":"keep-out","margin_m":0{properties}}},"geometry":{{"type":
            "Polygon","coordinates":[[[-70.019,42],[-69.981,42],[-69.981,42.014],[-70.019,42.014],[-70.019,42]]]}}}}"#
        )
    });
    let text = format!(
        r#"{{"type":"FeatureCollection","features":[{{"type":"Feature","properties":{{"name":"box","kind":"keep-in",
            "margin_m":10,"depth_max_m":100,"altitude_min_m":2,"surfacing":true}},"geometry":{{"type":"Polygon",
            "coordinates":[[[-70.0181,41.9865],[-69.9819,41.9865],[-69.9819,42.0135],[-70.0181,42.0135],
            [-70.0181,41.9865]]]}}}}{north}]}}"#
    );
    let origin = Position::from_deg(42.0, -70.0).unwrap();
    Fence::read(&text, backseat_fence::Form::GeoJson, Some(origin)).unwrap()
}

/// Limits of which no two that are added, subtracted or multiplied are equal.
fn distinct() -> Limits {
    Limits {
        speed_min_mps: 1.1,
        speed_max_mps: 2.0,
        turn_rate_dps: 9.0,
        turn_lag_s: 2.0,
        climb_angle_min_deg: 30.0,
        current_max_mps: 0.3,
        seabed_slope_max: 0.1,
        navigation_error_m: 5.0,
        tracking_error_m: 4.0,
        vertical_error_m: 1.5,
        link_delay_max_s: 1.7,
        lead_max_m: 30.0,
        gps_hit_duration_max_s: 200.0,
        ..limits()
    }
}

/// What [`distinct`] makes of a speed, by the formula of safety requirement 002: errors, the width of a whole turn and
/// the drift in the current while it lasts.
fn beside_m(speed_mps: f64) -> f64 {
    let radius_m = speed_mps / (PI * 9.0 / 180.0);
    5.0 + 4.0 + (2.0 * radius_m + 2.0 * speed_mps) + 0.3 * (180.0 / 9.0 + 2.0)
}

fn envelope() -> Envelope {
    Envelope::new(fence_with(None), distinct())
}

/// An envelope whose northern half is closed from this many seconds after the start.
fn closing(after_s: f64) -> Envelope {
    let from = Rfc3339(START + Duration::from_secs_f64(after_s));
    Envelope::new(fence_with(Some(&format!(r#","valid_from":"{from}""#))), distinct())
}

fn depth(metres: f64) -> Depth {
    Depth::from_m(metres).unwrap()
}

fn flight(vertical: Vertical) -> Flight {
    Flight {
        vertical,
        speed: Speed::from_mps(1.5).unwrap(),
    }
}

fn deep(metres: f64) -> Flight {
    flight(Vertical::Depth(depth(metres)))
}

fn insert(path: InsertPath) -> Insert {
    Insert { path, interrupt: false }
}

fn position(envelope: &Envelope, point: EastNorth) -> Position {
    envelope.fence.frame().to_position(point)
}

fn line(envelope: &Envelope, start: EastNorth, end: EastNorth, flight: Flight) -> Insert {
    insert(InsertPath::Line {
        start: position(envelope, start),
        end: position(envelope, end),
        flight,
    })
}

fn circle(envelope: &Envelope, centre: EastNorth, radius_m: f64, entry_angle_deg: Option<f64>) -> Insert {
    insert(InsertPath::Circle {
        centre: position(envelope, centre),
        radius_m,
        orbits: -2.25,
        entry_angle_deg,
        flight: deep(15.0),
    })
}

fn surfacing(envelope: &Envelope, point: EastNorth) -> Insert {
    insert(InsertPath::Surface {
        at: position(envelope, point),
    })
}

fn navigation(envelope: &Envelope, local: EastNorth) -> NavigationSample {
    NavigationSample {
        solution: Timestamp::from_millis(9_500),
        position: position(envelope, local),
        local,
        depth: depth(20.0),
        altitude: None,
        heading: Heading::from_deg(90.0).unwrap(),
        roll_deg: 0.0,
        pitch_deg: 0.0,
        east_mps: 1.2,
        north_mps: 0.0,
        down_mps: 0.0,
        yaw_rate_dps: 0.0,
        gps: false,
    }
}

#[track_caller]
fn near(is: f64, expected: f64) {
    assert!((is - expected).abs() < 1e-3, "{is} instead of {expected}");
}

#[track_caller]
fn near_point(is: EastNorth, expected: EastNorth) {
    assert!(is.distance_m(expected) < 1e-3, "{is:?} instead of {expected:?}");
}

#[track_caller]
fn near_end(is: End, expected: End) {
    let points = |end: End| match end {
        End::At(point) => ([point; 3], 0.0),
        End::Anywhere { centre, radius_m } => ([centre; 3], radius_m),
        End::Within { corners, radius_m } => (corners, radius_m),
    };
    assert_eq!(
        std::mem::discriminant(&is),
        std::mem::discriminant(&expected),
        "{is:?} instead of {expected:?}"
    );
    let ((is, is_m), (expected, expected_m)) = (points(is), points(expected));
    near(is_m, expected_m);
    for (is, expected) in is.into_iter().zip(expected) {
        near_point(is, expected);
    }
}

/// Asserts that a judgement changes from a refusal to a pass when a value rises above a threshold.
#[track_caller]
fn passes_from<T: std::fmt::Debug>(threshold: f64, within: f64, judge: impl Fn(f64) -> Result<T, Refusal>) {
    let below = judge(threshold - within);
    let above = judge(threshold + within);
    assert!(
        below.is_err() && above.is_ok(),
        "at {threshold}: below {below:?}, above {above:?}"
    );
}

/// The clearance of a shape, as the fence gives it for a vehicle at 20 m.
fn clearance_m(envelope: &Envelope, shapes: impl IntoIterator<Item = Shape>, radius_m: f64) -> f64 {
    let extent = VerticalExtent {
        depth_min_m: 20.0,
        depth_max_m: 20.0,
        altitude_min_m: 10.0,
    };
    let clearances = shapes.into_iter().map(|shape| {
        let clearance = envelope.fence.check(&Sweep { shape, radius_m }, &extent).unwrap();
        clearance.metres
    });
    let least_m = clearances.fold(f64::MAX, f64::min);
    assert!(least_m < 1000.0, "too far from every edge to tell");
    least_m
}
