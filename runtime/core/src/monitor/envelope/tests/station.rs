//! Boxes, and how far a hovering vehicle strays.

use backseat_units::math::hypot;

use super::*;
use crate::monitor::envelope::boxes::{avoid, contain, hull_axes, span};
use crate::monitor::limits::station::{BottomBox, HullBox, StationLimits};
use crate::plugin::{CartesianSample, RelativeSample, StationRequest, StationTarget};
use crate::refusal::{BoxEdge, Stretch};

/// The samples are a quarter of a second old at this time.
const NOW: Timestamp = Timestamp::from_millis(10_000);
const MEASURED: Timestamp = Timestamp::from_millis(9_750);
/// The vehicle runs on for so long: the timeout of SPI 8.1, the age of the samples, the link.
const RUNS_ON_S: f64 = 2.0 + 0.25 + 1.7;

fn hull_box(horizontal_m: [f64; 2], vertical_m: [f64; 2], distance_m: [f64; 2]) -> HullBox {
    HullBox {
        name: "hull".to_owned(),
        horizontal_min_m: horizontal_m[0],
        horizontal_max_m: horizontal_m[1],
        vertical_min_m: vertical_m[0],
        vertical_max_m: vertical_m[1],
        distance_min_m: distance_m[0],
        distance_max_m: distance_m[1],
    }
}

fn bottom_box(x_m: [f64; 2], y_m: [f64; 2], depth_m: [f64; 2]) -> BottomBox {
    BottomBox {
        name: "bottom".to_owned(),
        x_min_m: x_m[0],
        x_max_m: x_m[1],
        y_min_m: y_m[0],
        y_max_m: y_m[1],
        depth_min_m: depth_m[0],
        depth_max_m: depth_m[1],
    }
}

const FAR: [f64; 2] = [-1000.0, 1000.0];

/// With a box around the hull and one over the bottom, both far away.
fn hovering(change: impl FnOnce(&mut StationLimits)) -> Envelope {
    let mut station: StationLimits = serde_json::from_str(
        r#"{"speed_max_mps":0.5,"speed_default_mps":0.4,"position_error_m":0.6,"altitude_min_m":3}"#,
    )
    .unwrap();
    station.hull_box = Some(hull_box(FAR, FAR, FAR));
    station.bottom_box = Some(bottom_box(FAR, FAR, FAR));
    change(&mut station);
    let limits = Limits {
        station: Some(station),
        ..distinct()
    };
    Envelope::new(fence_with(None), limits)
}

/// What is known about a vehicle at (10, 5, 4) from the hull and at (-7, 3) over the bottom, 20 m deep over 40 m of water,
/// that moves at 0.3 m/s.
struct Known {
    relative: RelativeSample,
    cartesian: CartesianSample,
    navigation: NavigationSample,
    lock: Option<BottomLock>,
    suspended: Vec<Suspended>,
}

impl Known {
    fn new() -> Self {
        let envelope = envelope();
        let mut navigation = navigation(&envelope, at(0.0, 0.0));
        (navigation.east_mps, navigation.north_mps, navigation.down_mps) = (0.1, 0.2, 0.2);
        Self {
            relative: RelativeSample {
                measured: MEASURED,
                horizontal_m: 10.0,
                vertical_m: 5.0,
                distance_m: 4.0,
                heading_deg: 0.0,
                depth_m: 20.0,
                absolute_heading_deg: 0.0,
                roll_deg: 0.0,
                pitch_deg: 0.0,
            },
            cartesian: CartesianSample {
                measured: MEASURED,
                x_m: -7.0,
                y_m: 3.0,
                z_m: 0.0,
                heading_deg: 0.0,
            },
            navigation,
            lock: Some(BottomLock {
                water_depth_m: 40.0,
                at: at(0.0, 0.0),
            }),
            suspended: Vec::new(),
        }
    }

    fn judge(&self, envelope: &Envelope, aim: Option<Aim>, speed_mps: f64) -> Result<f64, Refusal> {
        let around = Surroundings {
            relative: Some(&self.relative),
            cartesian: Some(&self.cartesian),
            navigation: &self.navigation,
            lock: self.lock,
            suspended: &self.suspended,
            now: NOW,
        };
        envelope.judge_station(&Hover { aim, speed_mps }, &around)
    }
}

fn to_hull(place_m: [f64; 3]) -> Option<Aim> {
    Some(Aim::Hull {
        horizontal_m: place_m[0],
        vertical_m: place_m[1],
        distance_m: place_m[2],
    })
}

fn to_bottom(x_m: f64, y_m: f64, vertical: Vertical) -> Option<Aim> {
    Some(Aim::Bottom { x_m, y_m, vertical })
}

#[test]
fn a_span_reaches_from_the_least_to_the_greatest_value_and_beyond() {
    assert_eq!(span([3.0, -2.0, 1.0].into_iter(), 0.5), [-2.5, 3.5]);
    assert!(span([3.0, f64::NAN].into_iter(), 0.5)[0].is_nan());
    assert!(span([f64::NAN, 3.0].into_iter(), 0.5)[1].is_nan());
}

#[test]
fn a_vehicle_that_stays_runs_on_at_its_speed_within_both_boxes() {
    let known = Known::new();
    let stray_m = 0.6 + 0.3 * RUNS_ON_S;
    // The clearance is the least one of all edges.
    let hull = |horizontal, vertical, distance| {
        hovering(|limits| limits.hull_box = Some(hull_box(horizontal, vertical, distance)))
    };
    for envelope in [
        hull([4.0, 1000.0], FAR, FAR),
        hull([-1000.0, 16.0], FAR, FAR),
        hull(FAR, [-1.0, 1000.0], FAR),
        hull(FAR, [-1000.0, 11.0], FAR),
        hull(FAR, FAR, [-2.0, 1000.0]),
        hull(FAR, FAR, [-1000.0, 10.0]),
    ] {
        near(known.judge(&envelope, None, 0.2).unwrap(), 6.0 - stray_m);
    }
    let bottom = |x, y, depth| hovering(|limits| limits.bottom_box = Some(bottom_box(x, y, depth)));
    for envelope in [
        bottom([-13.0, 1000.0], FAR, FAR),
        bottom([-1000.0, -1.0], FAR, FAR),
        bottom(FAR, [-3.0, 1000.0], FAR),
        bottom(FAR, [-1000.0, 9.0], FAR),
        bottom(FAR, FAR, [14.0, 1000.0]),
        bottom(FAR, FAR, [-1000.0, 26.0]),
    ] {
        near(known.judge(&envelope, None, 0.2).unwrap(), 6.0 - stray_m);
    }
    // An edge may be reached, and not crossed.
    passes_from(-(10.0 - stray_m), 1e-9, |minus_edge_m| {
        known.judge(&hull([-minus_edge_m, 1000.0], FAR, FAR), None, 0.2)
    });
}

#[test]
fn a_move_on_the_hull_spans_here_the_target_and_where_the_mission_was_suspended() {
    let mut known = Known::new();
    if let Some(lock) = &mut known.lock {
        lock.water_depth_m = 400.0;
    }
    let target = to_hull([30.0, 6.0, 4.0]);
    // It flies the move at the greater of its speed now and the limit.
    for (speed_mps, faster_mps) in [(0.2, 0.3), (0.5, 0.5)] {
        let stray_m = 0.6 + faster_mps * RUNS_ON_S;
        let envelope = hovering(|limits| limits.hull_box = Some(hull_box([-50.0, 50.0], FAR, FAR)));
        near(known.judge(&envelope, target, speed_mps).unwrap(), 20.0 - stray_m);
    }
    let stray_m = 0.6 + 0.3 * RUNS_ON_S;
    known.suspended = vec![Suspended {
        hull_m: Some([-40.0, 5.0, 4.0]),
        ..Suspended::default()
    }];
    let envelope = hovering(|limits| limits.hull_box = Some(hull_box([-50.0, 50.0], FAR, FAR)));
    near(known.judge(&envelope, target, 0.2).unwrap(), 10.0 - stray_m);
    // A keep-out box must be clear on one axis: the clearance is the gap there.
    let kept = |horizontal, distance| {
        hovering(|limits| limits.keep_out_hull = vec![hull_box(horizontal, [5.5, 6.0], distance)])
    };
    near(
        known.judge(&kept([35.0, 60.0], FAR), target, 0.2).unwrap(),
        5.0 - stray_m,
    );
    near(
        known.judge(&kept([-80.0, -46.0], FAR), target, 0.2).unwrap(),
        6.0 - stray_m,
    );
    near(
        known.judge(&kept([35.0, 60.0], [11.0, 20.0]), target, 0.2).unwrap(),
        7.0 - stray_m,
    );
    // Touching it is entering it.
    passes_from(30.0 + stray_m, 1e-9, |edge_m| {
        known.judge(&kept([edge_m, 60.0], FAR), target, 0.2)
    });
    known.suspended = vec![Suspended::default()];
    assert!(known.judge(&envelope, target, 0.2).is_err());
}

#[test]
fn a_move_over_the_bottom_keeps_its_altitude_where_the_seabed_may_rise() {
    let mut known = Known::new();
    let stray_m = 0.6 + 0.3 * RUNS_ON_S;
    // From (-7, 3) to (13, 18): the seabed may be 0.1 of the diagonal of the widened span higher or lower.
    let rise_m = 0.1 * hypot(20.0 + 2.0 * stray_m, 15.0 + 2.0 * stray_m);
    let open = hovering(|_| ());
    let deep = |metres| to_bottom(13.0, 18.0, Vertical::Depth(depth(metres)));
    // The altitude is the least clearance here.
    near(
        known.judge(&open, deep(30.0), 0.2).unwrap(),
        (40.0 - rise_m) - 30.0 - stray_m - 3.0,
    );
    near(
        known.judge(&open, deep(10.0), 0.2).unwrap(),
        (40.0 - rise_m) - 20.0 - stray_m - 3.0,
    );
    let low = |metres| to_bottom(13.0, 18.0, Vertical::Altitude(Altitude::from_m(metres).unwrap()));
    near(known.judge(&open, low(8.0), 0.2).unwrap(), 8.0 - stray_m - 3.0);
    passes_from(3.0 + stray_m, 1e-9, |metres| known.judge(&open, low(metres), 0.2));
    // The least altitude itself is allowed.
    let least = |metres| hovering(|limits| limits.altitude_min_m = metres);
    let reached_m = known.judge(&least(0.0), low(8.0), 0.2).unwrap();
    assert_eq!(known.judge(&least(reached_m), low(8.0), 0.2), Ok(0.0));
    // At an altitude, the depth is what is left of the greatest and of the least water depth.
    let shallow = |max_m| hovering(|limits| limits.bottom_box = Some(bottom_box(FAR, FAR, [-1000.0, max_m])));
    passes_from(40.0 + rise_m - 8.0 + stray_m, 1e-9, |max_m| {
        known.judge(&shallow(max_m), low(8.0), 0.2)
    });
    let sunk = |min_m| hovering(|limits| limits.bottom_box = Some(bottom_box(FAR, FAR, [min_m, 1000.0])));
    passes_from(-(40.0 - rise_m - 35.0 - stray_m), 1e-9, |minus_m| {
        known.judge(&sunk(-minus_m), low(35.0), 0.2)
    });
    // Sideways, the target and where the mission was suspended count.
    known.suspended = vec![Suspended {
        bottom_m: Some([-7.0, -20.0, 22.0]),
        ..Suspended::default()
    }];
    for (x, y, room_m) in [
        ([-1000.0, 15.0], FAR, 2.0),
        ([-10.0, 1000.0], FAR, 3.0),
        (FAR, [-1000.0, 22.0], 4.0),
        (FAR, [-25.0, 1000.0], 5.0),
    ] {
        let envelope = hovering(|limits| limits.bottom_box = Some(bottom_box(x, y, FAR)));
        near(known.judge(&envelope, deep(10.0), 0.2).unwrap(), room_m - stray_m);
    }
    let kept = hovering(|limits| limits.keep_out_bottom = vec![bottom_box(FAR, FAR, [24.0, 30.0])]);
    near(known.judge(&kept, deep(10.0), 0.2).unwrap(), 2.0 - stray_m);
    // Without bottom lock nothing is known about the seabed.
    known.lock = None;
    assert!(known.judge(&open, deep(10.0), 0.2).is_err());
}

#[test]
fn stale_or_missing_samples_allow_nothing() {
    let known = Known::new();
    let open = hovering(|_| ());
    let with = |relative, cartesian| Surroundings {
        relative,
        cartesian,
        navigation: &known.navigation,
        lock: known.lock,
        suspended: &[],
        now: NOW,
    };
    let judge = |aim, around: Surroundings<'_>| open.judge_station(&Hover { aim, speed_mps: 0.2 }, &around);
    let (hull, bottom) = (Some(&known.relative), Some(&known.cartesian));
    assert!(judge(None, with(hull, None)).is_ok());
    assert!(judge(None, with(None, bottom)).is_ok());
    assert!(judge(None, with(None, None)).is_err());
    assert!(judge(to_hull([10.0, 5.0, 4.0]), with(None, bottom)).is_err());
    let deep = to_bottom(-7.0, 3.0, Vertical::Depth(depth(20.0)));
    assert!(judge(deep, with(hull, None)).is_err());
    let no_hull = hovering(|limits| limits.hull_box = None);
    let hover = Hover {
        aim: to_hull([10.0, 5.0, 4.0]),
        speed_mps: 0.2,
    };
    assert!(no_hull.judge_station(&hover, &with(hull, bottom)).is_err());
}

#[test]
fn two_places_are_near_if_they_are_in_every_known_frame() {
    let place = |hull_m, bottom_m| Suspended {
        hull_m,
        bottom_m,
        local: None,
    };
    let here = place(Some([1.0, 2.0, 3.0]), Some([4.0, 5.0, 6.0]));
    // 7 m apart.
    let hull_off = Some([3.0, 5.0, 9.0]);
    let bottom_off = Some([2.0, 2.0, 0.0]);
    assert!(here.is_near(&place(hull_off, here.bottom_m), 7.0));
    assert!(!here.is_near(&place(hull_off, here.bottom_m), 6.99));
    assert!(here.is_near(&place(here.hull_m, bottom_off), 7.0));
    assert!(!here.is_near(&place(here.hull_m, bottom_off), 6.99));
    assert!(!here.is_near(&place(here.hull_m, None), 7.0));
    assert!(!here.is_near(&place(None, here.bottom_m), 7.0));
    assert!(place(None, here.bottom_m).is_near(&here, 0.0));
    assert!(place(here.hull_m, None).is_near(&here, 0.0));
    assert!(!place(None, None).is_near(&here, 7.0));
}

#[test]
fn a_box_is_kept_up_to_its_bounds_and_another_is_avoided_beyond_them() {
    let cube = hull_box([0.0, 10.0], [0.0, 10.0], [0.0, 10.0]);
    let axes = |spans_m| hull_axes(&cube, spans_m);
    let within = [[0.0, 5.0], [1.0, 9.0], [2.0, 8.0]];
    assert_eq!(contain(Stretch::Here, "hull_box", &axes(within)).unwrap(), 0.0);
    assert!(contain(Stretch::Here, "hull_box", &axes([[-1e-9, 5.0], [1.0, 9.0], [2.0, 8.0]])).is_err());
    // Touching is no gap, and the bound that is named is the first of those that are equally near.
    let touching = [[-5.0, 0.0], [-5.0, 0.0], [1.0, 2.0]];
    let breach = |spans_m| {
        let Err(Refusal::Box(breach)) = avoid(Stretch::Way, "keep_out", "wreck", &axes(spans_m)) else {
            panic!("it is entered");
        };
        match breach.edge {
            BoxEdge::Entered { key, .. } => (breach.missing_m, key),
            BoxEdge::Kept { .. } => panic!("it is no box to keep to"),
        }
    };
    assert_eq!(breach(touching), (Some(0.0), "horizontal_min_m".to_owned()));
    let inside = [[-5.0, 4.0], [-5.0, 3.0], [1.0, 9.5]];
    assert_eq!(breach(inside), (Some(3.0), "vertical_min_m".to_owned()));
    let clear = [[-5.0, -1e-9], [1.0, 9.0], [1.0, 9.0]];
    assert!(avoid(Stretch::Way, "keep_out", "wreck", &axes(clear)).is_ok());
}

#[test]
fn station_keeping_lasts_up_to_its_term_and_moves_up_to_its_speed() {
    let hull = StationTarget::Hull {
        horizontal_m: 10.0,
        vertical_m: 5.0,
        distance_m: 4.0,
    };
    let asked = |envelope: &Envelope, duration: Duration, speed_mps: Option<f64>| {
        let request = StationRequest {
            tag: 1,
            target: hull,
            speed_mps,
            duration,
        };
        envelope.admit_station(&request).map(|hover| hover.speed_mps)
    };
    let envelope = hovering(|_| ());
    let term = envelope.station_limits().unwrap().term_max();
    assert_eq!(asked(&envelope, term, Some(0.5)), Ok(0.5));
    assert!(asked(&envelope, term + Duration::from_nanos(1), Some(0.5)).is_err());
    assert!(asked(&envelope, Duration::ZERO, Some(0.5)).is_err());
    assert!(asked(&envelope, term, Some(0.500_001)).is_err());
    // The mission's own speed counts if the request has none.
    let default_of = |mps| hovering(|station| station.speed_default_mps = mps);
    assert_eq!(asked(&default_of(0.5), term, None), Ok(0.5));
    assert!(asked(&default_of(0.500_001), term, None).is_err());
}
