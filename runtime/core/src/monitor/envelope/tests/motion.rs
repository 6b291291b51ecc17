//! How the vehicle moves at worst.

use super::*;
use crate::monitor::envelope::surfacing::deepest;

#[test]
fn the_cross_track_allowance_is_the_errors_a_whole_turn_and_the_drift_while_it_lasts() {
    let envelope = envelope();
    near(envelope.turn_away_s(), 22.0);
    near(envelope.turn_away_m(1.8), 2.0 * 1.8 / (PI / 20.0) + 3.6);
    near(envelope.cross_track_m(1.8), beside_m(1.8));
    near(turn_radius_m(1.8, 9.0), 1.8 / (PI / 20.0));
    near(envelope.slowest_mps(), 0.8);
}

#[test]
fn the_greatest_speed_is_that_of_a_request_or_of_the_plan_whichever_is_greater() {
    let told = |plan_speed_max_mps| {
        let limits = Limits {
            plan_speed_max_mps,
            ..distinct()
        };
        Envelope::new(fence_with(None), limits)
    };
    near(told(None).fastest_mps(0.0), 2.0);
    near(told(None).fastest_mps(2.7), 2.7);
    near(told(Some(2.5)).fastest_mps(0.0), 2.5);
    near(told(Some(1.5)).fastest_mps(0.0), 2.0);
    near(told(Some(2.5)).fastest_mps(2.7), 2.5);
    near(told(Some(2.5)).fastest_mps(3.1), 2.8);
}

#[test]
fn a_climb_is_longest_at_the_least_angle_and_speed_and_with_the_current() {
    let climb = envelope().climb(depth(10.0));
    near(climb.lasts_s, 20.0 / 1.1);
    near(climb.along_m, 20.0 * (3.0f64).sqrt() / 2.0 + 0.3 * 20.0 / 1.1);
    near(envelope().climb(depth(0.0)).along_m, 0.0);
    near(envelope().drift_m(), 60.0);
    near(deepest(depth(10.0), 12.0).unwrap().as_m(), 12.0);
    near(deepest(depth(10.0), 8.0).unwrap().as_m(), 10.0);
    near(deepest(depth(0.0), -8.0).unwrap().as_m(), 0.0);
    assert!(deepest(depth(10.0), f64::INFINITY).is_err());
}

#[test]
fn a_request_may_last_from_now_by_one_clock_until_its_end_by_the_other() {
    let span = CLOCKS.next(7.5).unwrap();
    assert_eq!(span.from, Utc::from_unix_nanos(1_699_999_997_000_000_000));
    assert_eq!(span.until, Utc::from_unix_nanos(1_700_000_010_500_000_000));
    let apart = |apart| Clocks { utc: START, apart };
    assert!(apart(None).next(1.0).is_none());
    assert!(apart(Some(Duration::from_secs(60))).next(1.0).is_some());
    assert!(apart(Some(Duration::from_millis(60_001))).next(1.0).is_none());
    for (seconds, known) in [
        (0.0, true),
        (604_800.0, true),
        (604_800.1, false),
        (-0.1, false),
        (f64::NAN, false),
        (f64::INFINITY, false),
    ] {
        assert_eq!(CLOCKS.next(seconds).is_some(), known, "{seconds}");
    }
}

#[test]
fn a_setpoint_leads_from_the_depth_now_to_the_depth_set_and_its_error() {
    let envelope = envelope();
    let lock = Some(BottomLock {
        water_depth_m: 50.0,
        at: at(30.0, 40.0),
    });
    // 50 m away, and 20 m of reach: the seabed may be 7 m higher or lower.
    let extent = |vertical, now_m| {
        envelope
            .extent(vertical, depth(now_m), lock, at(0.0, 0.0), 20.0)
            .unwrap()
    };
    let is = |extent: VerticalExtent, [shallowest_m, deepest_m, altitude_m]: [f64; 3]| {
        near(extent.depth_min_m, shallowest_m);
        near(extent.depth_max_m, deepest_m);
        near(extent.altitude_min_m, altitude_m);
    };
    let set = |metres| Vertical::Depth(depth(metres));
    is(extent(set(20.0), 10.0), [10.0, 21.5, 21.5]);
    is(extent(set(20.0), 30.0), [18.5, 30.0, 21.5]);
    is(extent(set(1.0), 30.0), [0.0, 30.0, 40.5]);
    let above = |metres| Vertical::Altitude(Altitude::from_m(metres).unwrap());
    is(extent(above(8.0), 10.0), [10.0, 50.5, 6.5]);
    is(extent(above(8.0), 40.0), [33.5, 50.5, 6.5]);
    is(extent(above(8.0), 60.0), [33.5, 60.0, 6.5]);
    is(extent(above(45.0), 60.0), [0.0, 60.0, 43.5]);
    // Without bottom lock nothing is known about the seabed.
    let unknown = |vertical| envelope.extent(vertical, depth(10.0), None, at(0.0, 0.0), 20.0);
    is(unknown(set(20.0)).unwrap(), [10.0, 21.5, -21.5]);
    assert!(unknown(above(8.0)).is_err());
}

#[test]
fn the_water_depth_is_what_lock_and_limits_both_allow() {
    let known = |min, max, lock: Option<f64>| {
        let limits = Limits {
            water_depth_min_m: min,
            water_depth_max_m: max,
            ..distinct()
        };
        let lock = lock.map(|water_depth_m| BottomLock {
            water_depth_m,
            at: at(-30.0, 0.0),
        });
        // 30 m away, and 20 m of reach: 5 m.
        Envelope::new(fence_with(None), limits).water_depths(lock, at(0.0, 0.0), 20.0)
    };
    assert_eq!(known(None, None, None), (None, None));
    assert_eq!(known(Some(30.0), Some(90.0), None), (Some(30.0), Some(90.0)));
    assert_eq!(known(None, None, Some(50.0)), (Some(45.0), Some(55.0)));
    assert_eq!(known(Some(30.0), Some(90.0), Some(50.0)), (Some(45.0), Some(55.0)));
    assert_eq!(known(Some(48.0), Some(53.0), Some(50.0)), (Some(48.0), Some(53.0)));
}

#[test]
fn the_water_depth_of_a_sample_is_its_depth_and_its_altitude() {
    let envelope = envelope();
    let mut sample = navigation(&envelope, at(7.0, 8.0));
    assert_eq!(bottom_lock(&sample), None);
    sample.altitude = Some(Altitude::from_m(13.0).unwrap());
    let lock = bottom_lock(&sample).unwrap();
    near(lock.water_depth_m, 33.0);
    assert_eq!(lock.at, at(7.0, 8.0));
}

#[test]
fn a_depth_of_nothing_is_the_surface_and_above_it_is_no_depth() {
    assert_eq!(
        vertical(VerticalRequest::DepthM(0.0)).unwrap(),
        Vertical::Depth(depth(0.0))
    );
    for metres in [-0.001, f64::NAN, f64::INFINITY] {
        assert!(vertical(VerticalRequest::DepthM(metres)).is_err(), "{metres}");
    }
    for degrees in [-360.0, 0.0, 360.0] {
        assert!(heading(degrees, Figure::Heading).is_ok(), "{degrees}");
    }
    for degrees in [-360.001, 360.001, f64::NAN] {
        assert!(heading(degrees, Figure::Heading).is_err(), "{degrees}");
    }
}
