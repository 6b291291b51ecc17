//! Zones that are valid for a time: what counts is when the vehicle may fly a geometry, by our clock and by the
//! vehicle's.

use std::time::Duration;

use backseat_core::plugin::Rule;
use backseat_core::plugin::{Judge, Request};
use backseat_core::{Envelope, Input, Limits, Note};
use backseat_fence::Fence;
use backseat_units::{Timestamp, Utc};

use crate::course::{good_line, interrupting, limits, line, modify};
use crate::scene::{at_once, begins, ends};
use crate::trial::{Setup, Trial, shorts};

/// The trials' time zero, 2023-11-14T22:13:20Z.
const START_S: u64 = 1_700_000_000;

/// The time this many seconds after the start, in the format of a fence's file.
fn rfc3339(after_s: u64) -> String {
    let of_day = START_S + after_s - 1_699_920_000;
    assert!(of_day < 2 * 86_400, "{after_s}");
    let (day, second) = (14 + of_day / 86_400, of_day % 86_400);
    format!(
        "2023-11-{day}T{:02}:{:02}:{:02}Z",
        second / 3600,
        second / 60 % 60,
        second % 60
    )
}

/// The box of the trials with this window, and a keep-out zone with another.
fn fence(of_box: &str, keep_out: Option<(&str, &str)>) -> Fence {
    let keep_out = keep_out.map_or(String::new(), |(ring, window)| {
        format!(
            r#",{{"type":"Feature","properties":{{"name":"convoy","kind":"keep-out","margin_m":20{window}}},
                "geometry":{{"type":"Polygon","coordinates":[[{ring}]]}}}}"#
        )
    });
    Fence::from_geojson(&format!(
        r#"{{"type":"FeatureCollection","features":[{{"type":"Feature",
            "properties":{{"name":"box","kind":"keep-in","margin_m":10,"depth_max_m":60,"altitude_min_m":2{of_box}}},
            "geometry":{{"type":"Polygon","coordinates":[
                [[-70.024,41.982],[-69.976,41.982],[-69.976,42.018],[-70.024,42.018],[-70.024,41.982]]]}}}}{keep_out}]}}"#
    ))
    .unwrap()
}

/// Over the good line, 444 to 555 m north.
const ON_THE_LINE: &str = "[-70.0005,42.004],[-69.996,42.004],[-69.996,42.005],[-70.0005,42.005],[-70.0005,42.004]";
/// On the planned leg, some 300 to 500 m east.
const ON_THE_LEG: &str = "[-69.9964,41.9995],[-69.994,41.9995],[-69.994,42.0005],[-69.9964,42.0005],[-69.9964,41.9995]";

fn opens_after(ring: &'static str, after_s: u64) -> Fence {
    fence("", Some((ring, &format!(r#","valid_from":"{}""#, rfc3339(after_s)))))
}

fn over(ring: &'static str) -> Fence {
    fence("", Some((ring, &format!(r#","valid_until":"{}""#, rfc3339(0)))))
}

fn trial(fence: Fence) -> Trial {
    Trial::with_under_way(Setup {
        fence,
        ..Setup::default()
    })
}

/// Asks, and returns the refusal, or nothing if the vehicle has accepted.
fn ask(trial: &mut Trial, tag: u64, request: Request) -> Option<String> {
    trial.ask(0, [request]);
    trial.run_for(0.5);
    if shorts(&trial.states(tag)) == ["sent", "accepted"] {
        None
    } else {
        Some(trial.rejection(tag))
    }
}

#[test]
fn sr_002_an_insert_that_may_be_flown_when_a_keep_out_zone_opens_is_rejected_and_one_that_ends_before_is_not() {
    // With its transit and its way on the insert takes some 55 min at most.
    let refusal = ask(&mut trial(opens_after(ON_THE_LINE, 600)), 1, interrupting(1)).unwrap();
    assert!(
        refusal.starts_with("keep-out: inside keep-out zone 'convoy'"),
        "{refusal}"
    );
    assert_eq!(
        ask(&mut trial(opens_after(ON_THE_LINE, 3600)), 1, interrupting(1)),
        None
    );
    // The same request, a quarter of an hour later.
    let mut later = trial(opens_after(ON_THE_LINE, 3600));
    later.run_for(900.0);
    let refusal = ask(&mut later, 1, interrupting(1)).unwrap();
    assert!(
        refusal.starts_with("keep-out: inside keep-out zone 'convoy'"),
        "{refusal}"
    );
    assert!(later.commands("RTK").is_empty());
}

#[test]
fn sr_002_the_behaviors_before_an_insert_delay_it() {
    // An interrupting insert would be over in time; one after the planned leg is not.
    let fence = || opens_after(ON_THE_LINE, 3300);
    assert_eq!(ask(&mut trial(fence()), 1, interrupting(1)), None);
    assert!(ask(&mut trial(fence()), 1, good_line(1)).is_some());
    // Neither is one after another insert.
    let mut behind = trial(opens_after(ON_THE_LINE, 4000));
    assert_eq!(ask(&mut behind, 1, good_line(1)), None);
    assert!(ask(&mut behind, 2, good_line(2)).is_some());
}

#[test]
fn sr_002_every_zone_counts_after_a_behavior_whose_end_cannot_be_predicted() {
    let mut trial = trial(opens_after(ON_THE_LINE, 80_000));
    let now = trial.now;
    // This behavior is a single place, and no sentence says how long the vehicle stays there.
    trial.vehicle.begin(now, Some(2), None);
    trial.run_for(0.5);
    assert!(ask(&mut trial, 1, good_line(1)).is_some());
    assert_eq!(
        ask(&mut trial, 2, interrupting(2)),
        None,
        "the end of an interrupting insert can be predicted"
    );
}

#[test]
fn sr_002_a_keep_in_zone_that_closes_allows_only_what_ends_before() {
    let closes = |after_s| fence(&format!(r#","valid_until":"{}""#, rfc3339(after_s)), None);
    let refusal = ask(&mut trial(closes(600)), 1, interrupting(1)).unwrap();
    assert!(refusal.starts_with("time: "), "{refusal}");
    assert_eq!(ask(&mut trial(closes(4000)), 1, interrupting(1)), None);
    let opens = fence(&format!(r#","valid_from":"{}""#, rfc3339(600)), None);
    let mut early = trial(opens);
    let refusal = ask(&mut early, 1, interrupting(1)).unwrap();
    assert!(refusal.starts_with("time: "), "{refusal}");
    early.run_for(700.0);
    assert_eq!(ask(&mut early, 2, interrupting(2)), None);
}

#[test]
fn sr_002_while_the_clocks_differ_by_over_a_minute_zones_with_a_window_count_at_their_worst() {
    for (clock_s, known) in [
        (0, true),
        (50, true),
        (-50, true),
        (61, false),
        (-61, false),
        (7200, false),
    ] {
        for worst in [
            over(ON_THE_LINE),
            fence(&format!(r#","valid_from":"{}""#, rfc3339(0)), None),
        ] {
            let mut trial = Trial::with(Setup {
                fence: worst,
                ..Setup::default()
            });
            trial.vehicle.clock_nanos = clock_s * 1_000_000_000;
            // By then no zone begins or ends within the difference of the clocks.
            trial.run_for(120.0);
            let refusal = ask(&mut trial, 1, interrupting(1));
            assert_eq!(refusal.is_none(), known, "{clock_s} s: {refusal:?}");
        }
    }
}

#[test]
fn sr_002_zones_follow_our_clock_when_it_is_set_after_the_start_but_the_times_in_messages_do_not() {
    let opens = fence(&format!(r#","valid_from":"{}""#, rfc3339(600)), None);
    let mut trial = trial(opens);
    let refusal = ask(&mut trial, 1, interrupting(1)).unwrap();
    assert!(refusal.starts_with("time: "), "{refusal}");
    // Both clocks were 700 s behind, and are set now.
    let ahead = 700_000_000_000;
    trial.vehicle.clock_nanos += ahead;
    trial.feed(Input::UtcSet(ahead));
    trial.run_for(15.0);
    assert_eq!(ask(&mut trial, 2, interrupting(2)), None);
    let stamped = trial.commands("STS").pop().unwrap();
    let expected = (Setup::default().start.utc + Duration::from_nanos(stamped.0.as_nanos())).time_of_day();
    assert_eq!(stamped.1.created(), Some(expected.truncated_to_millis()));
    let told = |(_, note): &(Timestamp, Note)| match note {
        Note::Text { text } => text.contains("clock was set by +700.000 s: zones with times follow it"),
        _ => false,
    };
    assert!(trial.notes().iter().any(told));
    // When the clocks are set back, the zone is closed again.
    trial.vehicle.clock_nanos -= ahead;
    trial.feed(Input::UtcSet(0));
    trial.run_for(15.0);
    assert!(ask(&mut trial, 3, interrupting(3)).is_some());
}

#[test]
fn sr_002_a_zone_that_is_open_by_one_of_the_two_clocks_counts_as_open() {
    // The vehicle's clock is half a minute ahead, and there the zone is open already.
    let mut trial = Trial::with(Setup {
        fence: opens_after(ON_THE_LINE, 1700),
        ..Setup::default()
    });
    trial.vehicle.clock_nanos = 30_000_000_000;
    trial.run_for(2.0);
    let begun = trial.now;
    let mut last = None;
    // At first the line ends before the zone opens, by both clocks. By the vehicle's clock that changes first.
    while last.is_none() && trial.now.since(begun) < Duration::from_secs(1200) {
        let (_, step) = trial.steps(0).pop().unwrap();
        let by = |apart: Option<Duration>| {
            let envelope = Envelope::new(opens_after(ON_THE_LINE, 1700), limits());
            let step = backseat_core::plugin::StepInput {
                clocks_apart: apart,
                ..step.clone()
            };
            envelope.judge(&interrupting(1), &step).is_ok()
        };
        if by(Some(Duration::ZERO)) && !by(step.clocks_apart) {
            last = Some(step.clocks_apart);
        }
        trial.run_for(10.0);
    }
    let apart = last.expect("the two clocks give different answers in the end").unwrap();
    assert!(
        apart.abs_diff(Duration::from_secs(30)) < Duration::from_millis(100),
        "{apart:?}"
    );
}

#[test]
fn sr_004_a_lease_ends_before_a_zone_opens_on_its_way_back() {
    let mut trial = trial(opens_after(ON_THE_LEG, 2400));
    trial.script(0, |_| (Duration::from_millis(1), Ok(vec![Request::Modify(modify(1))])));
    trial.run_for(100.0);
    assert!(trial.core.is_steering() && trial.lease_ends().is_empty());
    trial.run_for(700.0);
    assert!(!trial.core.is_steering());
    let (ended, _) = trial.lease_ends().pop().unwrap();
    assert!(ended.as_secs_f64() < 2400.0 - 30.0, "{ended}");
    let refusal = trial.rejection(1);
    assert!(refusal.contains("inside keep-out zone 'convoy'"), "{refusal}");
    assert_eq!(trial.sent_since("RMB", ended).len(), 0);
}

#[test]
fn sr_002_an_interrupted_insert_is_delayed_by_all_that_is_flown_before_it_goes_on() {
    // It crosses the zone, and ends far behind it.
    let across = |tag: u64| Request::Trackline(line(tag, (-100.0, 500.0), (1200.0, 500.0)));
    let south = |tag: u64| Request::Trackline(line(tag, (-1700.0, -600.0), (1300.0, -600.0)));
    let short = |tag: u64| at_once(line(tag, (1200.0, 200.0), (1250.0, 200.0)));
    let begun = |opens_s| {
        let limits = Limits {
            inserts_duration_max_s: 50_000.0,
            ..limits()
        };
        let mut trial = Trial::with_under_way(Setup {
            fence: opens_after(ON_THE_LINE, opens_s),
            limits,
            ..Setup::default()
        });
        let admitted = ask(&mut trial, 1, across(1)).is_none();
        ends(&mut trial, Some(1), None);
        begins(&mut trial, None, Some(1));
        admitted.then_some(trial)
    };
    // If nothing else waits, the line is over in time where the zone opens so late.
    let late_enough = |opens_s: &u64| begun(*opens_s).is_some_and(|mut trial| ask(&mut trial, 2, short(2)).is_none());
    let opens_s = (3000..20_000)
        .step_by(100)
        .find(late_enough)
        .expect("it is over some time");
    let mut alone = begun(opens_s).unwrap();
    assert_eq!(ask(&mut alone, 2, short(2)), None);
    // The vehicle may fly the long way in the south before it goes on along the line.
    let refused = ask(&mut alone, 3, south(3)).unwrap();
    assert!(refused.starts_with("time: it would delay insert"), "{refused}");
    begins(&mut alone, None, Some(2));
    assert!(ask(&mut alone, 4, south(4)).is_some());
    let mut waits = begun(opens_s).unwrap();
    assert_eq!(ask(&mut waits, 2, south(2)), None);
    assert!(ask(&mut waits, 3, short(3)).is_some());
}

#[test]
fn sr_002_an_insert_that_has_not_begun_in_time_is_called_back() {
    let mut trial = trial(opens_after(ON_THE_LINE, 3600));
    trial.vehicle.speed_mps = 0.8;
    trial.run_for(0.5);
    assert_eq!(ask(&mut trial, 1, good_line(1)), None);
    trial.run_for(1500.0);
    assert!(trial.commands("RCN").is_empty());
    // The planned leg should have been over by then.
    trial.run_for(600.0);
    assert_eq!(trial.commands("RCN").len(), 1);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "cancelled"]);
    // If no zone changes by then, the insert may be late.
    let mut unhurried = self::trial(opens_after(ON_THE_LINE, 80_000));
    unhurried.vehicle.speed_mps = 0.8;
    unhurried.run_for(0.5);
    assert_eq!(ask(&mut unhurried, 1, good_line(1)), None);
    unhurried.run_for(2100.0);
    assert!(unhurried.commands("RCN").is_empty());
}

#[test]
fn a_plugins_query_is_answered_for_its_time() {
    let mut trial = trial(over(ON_THE_LINE));
    trial.run_for(1.0);
    let envelope = Envelope::new(over(ON_THE_LINE), limits());
    let (_, step) = trial.steps(0).pop().unwrap();
    assert!(envelope.judge(&interrupting(1), &step).is_ok());
    let yesterday = backseat_core::plugin::StepInput {
        utc: Utc::from_unix_nanos((START_S - 86_400) * 1_000_000_000),
        ..step.clone()
    };
    assert_eq!(
        envelope.judge(&interrupting(1), &yesterday).unwrap_err().rule(),
        Rule::KeepOut
    );
    let unknown = backseat_core::plugin::StepInput {
        clocks_apart: None,
        ..step
    };
    assert_eq!(
        envelope.judge(&interrupting(1), &unknown).unwrap_err().rule(),
        Rule::KeepOut
    );
}
