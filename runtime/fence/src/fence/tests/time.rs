//! Zones that are not always valid.

use core::time::Duration;

use backseat_units::Utc;

use super::*;
use crate::window::Span;

fn utc(seconds: u64) -> Utc {
    Utc::from_unix_nanos(seconds * 1_000_000_000)
}

fn span(from: u64, until: u64) -> Span {
    Span {
        from: utc(from),
        until: utc(until),
    }
}

fn windowed(mut zone: Zone, from: Option<u64>, until: Option<u64>) -> Zone {
    zone.window = Window {
        from: from.map(utc),
        until: until.map(utc),
    };
    zone
}

fn keep_in() -> Zone {
    zone("range", KEEP_IN, 5.0, &[rectangle(0.0, 0.0, 100.0, 100.0)])
}

fn keep_out() -> Zone {
    zone("traffic", KEEP_OUT, 5.0, &[rectangle(40.0, 40.0, 60.0, 60.0)])
}

fn judged(fence: &Fence, from: u64, until: u64) -> Result<Clearance, Breach> {
    let sweep = Sweep::new(leg((30.0, 50.0), (70.0, 50.0)), 1.0);
    fence.during(span(from, until)).check(&sweep, &VERTICAL)
}

#[test]
fn a_keep_in_zone_must_be_valid_for_the_whole_time() {
    let fence = fence(vec![windowed(keep_in(), Some(1000), Some(2000))]);
    for (from, until, holds) in [
        (1000, 2000, true),
        (1200, 1200, true),
        (999, 1500, false),
        (1500, 2001, false),
        (900, 2100, false),
        (0, 999, false),
        (2001, 3000, false),
    ] {
        let answer = judged(&fence, from, until);
        assert_eq!(answer.is_ok(), holds, "{from} to {until}: {answer:?}");
        if let Err(breach) = answer {
            assert_eq!((breach.rule, breach.zone()), (Rule::Closed, Some("range")));
            assert!(breach.metres.is_infinite());
        }
    }
    // A span that ends a nanosecond too late is refused.
    let late = Span {
        from: utc(1500),
        until: utc(2000) + Duration::from_nanos(1),
    };
    assert_eq!(
        fence.during(late).contains(at(50.0, 50.0)).unwrap_err().rule,
        Rule::Closed
    );
    assert!(fence.during(span(1500, 2000)).contains(at(50.0, 50.0)).is_ok());
}

#[test]
fn a_keep_out_zone_counts_if_its_window_and_the_time_share_an_instant() {
    let fence = fence(vec![keep_in(), windowed(keep_out(), Some(1000), Some(2000))]);
    for (from, until, holds) in [
        (0, 999, true),
        (2001, 3000, true),
        (0, 1000, false),
        (2000, 3000, false),
        (1400, 1500, false),
        (0, 3000, false),
    ] {
        let answer = judged(&fence, from, until);
        assert_eq!(answer.is_ok(), holds, "{from} to {until}: {answer:?}");
        if let Err(breach) = answer {
            assert_eq!((breach.rule, breach.metres), (Rule::KeepOut, 6.0));
        }
    }
}

#[test]
fn a_side_without_a_time_is_open() {
    let fence = fence(vec![
        windowed(keep_in(), Some(1000), None),
        windowed(keep_out(), None, Some(2000)),
    ]);
    assert_eq!(judged(&fence, 999, 3000).unwrap_err().rule, Rule::Closed);
    assert_eq!(judged(&fence, 2000, 3000).unwrap_err().rule, Rule::KeepOut);
    assert!(judged(&fence, 2001, u64::MAX / 1_000_000_000).is_ok());
}

#[test]
fn an_unknown_time_counts_as_the_worst_one() {
    let windowed_keep_out = fence(vec![keep_in(), windowed(keep_out(), Some(1000), Some(2000))]);
    assert_eq!(
        refused(&windowed_keep_out, leg((30.0, 50.0), (70.0, 50.0)), 1.0).0,
        Rule::KeepOut
    );
    let windowed_keep_in = fence(vec![windowed(keep_in(), None, Some(2000))]);
    assert_eq!(
        refused(&windowed_keep_in, leg((30.0, 50.0), (70.0, 50.0)), 1.0).0,
        Rule::Closed
    );
    let backwards = judged(&windowed_keep_out, 20, 10).unwrap_err();
    assert_eq!(backwards.rule, Rule::NotFinite);
    assert_eq!(
        backwards.to_string(),
        "not a usable number: time that ends before it begins"
    );
}

#[test]
fn a_closed_zone_is_named_if_only_its_window_is_breached() {
    let zones = || {
        let far = zone("far", KEEP_IN, 0.0, &[rectangle(5000.0, 0.0, 5100.0, 100.0)]);
        fence(vec![windowed(keep_in(), Some(1_777_622_400), None), far])
    };
    // Inside the closed zone, its window is the breach, and not the distance to the open one.
    let breach = judged(&zones(), 1_777_622_399, 1_777_622_460).unwrap_err();
    assert_eq!(
        breach.to_string(),
        "keep-in zone 'range' is valid only from 2026-05-01T08:00:00Z, and the request is for 2026-05-01T07:59:59Z to 2026-05-01T08:01:00Z"
    );
    // Inside neither, the open zone is named, because a request can be moved towards it.
    let outside = Sweep::new(Shape::point(at(4000.0, 50.0)), 1.0);
    let breach = zones().during(span(0, 1)).check(&outside, &VERTICAL).unwrap_err();
    assert_eq!(
        (breach.rule, breach.zone(), breach.metres),
        (Rule::KeepIn, Some("far"), 1001.0)
    );
}

#[test]
fn surfacing_respects_the_windows_too() {
    let kind = Kind::KeepIn {
        depth: Band {
            min_m: 2.0,
            max_m: 50.0,
        },
        altitude_min_m: 3.0,
        surfacing: true,
    };
    let zone = zone("gps", kind, 5.0, &[rectangle(0.0, 0.0, 100.0, 100.0)]);
    let fence = fence(vec![windowed(zone, Some(1000), Some(2000))]);
    let sweep = Sweep::new(Shape::point(at(50.0, 50.0)), 1.0);
    let surface = |from, until| fence.during(span(from, until)).check_surfacing(&sweep, &VERTICAL);
    assert!(surface(1000, 2000).is_ok());
    assert_eq!(surface(1000, 2001).unwrap_err().rule, Rule::Closed);
    assert_eq!(fence.check_surfacing(&sweep, &VERTICAL).unwrap_err().rule, Rule::Closed);
}
