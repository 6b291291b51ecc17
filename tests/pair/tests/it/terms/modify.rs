use std::time::Duration;

use backseat_core::Limits;
use backseat_mvc::Truth;
use backseat_pair::Dive;
use backseat_units::Timestamp;

use super::scene::{
    ORIGIN, Zone, exact, fence, line, modify, outside_of, setpoint, setup, south_of, steer, steer_until_refused, watch,
    world,
};

/// The fence's northern edge.
const EDGE_M: f64 = 100.0;
/// How far north a vehicle that heads north-east gets in one second more.
const NORTH_EAST_MPS: f64 = 2.0 * 0.707;

/// A vehicle that flies on a heading of its plan, south of an edge.
fn off_the_edge(south_m: f64, own_deg: f64, limits: Limits, more: &str) -> Dive {
    let start = (0.0, EDGE_M - south_m, own_deg);
    let plan = setpoint(own_deg, 2.0);
    let inside = Zone::inside([-700.0, -700.0, 700.0, EDGE_M]);
    let world = world(ORIGIN, start, &plan, more);
    let mut dive = Dive::new(setup(world, fence(ORIGIN, &[inside]), limits));
    dive.run_for(6.0);
    assert!(
        dive.run_until(20.0, |dive| dive.core.has_control()),
        "{:#?}",
        dive.notes
    );
    dive.lost = vec!["$BPEMB"];
    dive
}

/// A vehicle on a line of its plan to the east, south of an edge.
fn along_the_edge(south_m: f64, limits: Limits, more: &str) -> Dive {
    let north_m = EDGE_M - south_m;
    let plan = line((-600.0, north_m), (600.0, north_m));
    let inside = Zone::inside([-700.0, -700.0, 700.0, EDGE_M]);
    let world = world(ORIGIN, (-600.0, north_m, 90.0), &plan, more);
    let mut dive = Dive::under_way(setup(world, fence(ORIGIN, &[inside]), limits));
    dive.lost = vec!["$BPEMB"];
    dive
}

fn earlier(than: Timestamp, millis: u64) -> Timestamp {
    Timestamp::from_nanos(than.as_nanos() - millis * 1_000_000)
}

/// The time that a vehicle needs to turn away, and a little more.
const TURNS_AWAY_S: f64 = 14.0;

#[test]
fn the_five_seconds_that_it_obeys_after_the_last_word() {
    // At an angle to the edge, and back by a left turn along it.
    let mut dive = off_the_edge(150.0, 230.0, exact(), "");
    steer_until_refused(&mut dive, 45.0, 2.0);
    let least_m = watch(&mut dive, 5.0 + TURNS_AWAY_S, &south_of(EDGE_M));
    assert!((0.0..5.0 * NORTH_EAST_MPS).contains(&least_m), "{least_m}");
}

#[test]
fn the_age_of_navigation() {
    let limits = Limits {
        navigation_age_max_s: 4.0,
        ..exact()
    };
    let mut rehearsal = off_the_edge(150.0, 230.0, limits.clone(), "");
    let ended = steer_until_refused(&mut rehearsal, 45.0, 2.0);
    // Navigation stops just before the vehicle is too close.
    let frozen_s = ended.as_secs_f64() - 0.25;
    let fault = format!("[[faults.fault]]\nat_s = {frozen_s}\nfor_s = 60\nkind = \"navigation_frozen\"\n");
    let mut dive = off_the_edge(150.0, 230.0, limits, &fault);
    steer_until_refused(&mut dive, 45.0, 2.0);
    let least_m = watch(&mut dive, 5.0 + TURNS_AWAY_S, &south_of(EDGE_M));
    assert!((0.0..3.5 * NORTH_EAST_MPS).contains(&least_m), "{least_m}");
}

#[test]
fn the_delay_of_the_link() {
    let limits = Limits {
        link_delay_max_s: 4.2,
        ..exact()
    };
    // The later a sentence may be, the less is known of where a behavior began, so all paths back to it are judged
    // wider. Nothing of this remains on a line that has been flown for some time.
    let dive = || {
        let mut dive = along_the_edge(65.0, limits.clone(), "");
        dive.run_for(20.0);
        dive
    };
    let mut rehearsal = dive();
    let ended = steer_until_refused(&mut rehearsal, 345.0, 2.0);
    // The last sentences are as late as a sentence may be. The lease would end a second later without an
    // acknowledgement.
    let mut dive = dive();
    assert!(!steer(&mut dive, 345.0, 2.0, Some(earlier(ended, 800))));
    dive.delay[0] = Duration::from_millis(4200);
    steer_until_refused(&mut dive, 345.0, 2.0);
    let least_m = watch(&mut dive, 4.2 + 5.0 + TURNS_AWAY_S, &south_of(EDGE_M));
    assert!((0.0..4.2 * 2.0 * 0.966).contains(&least_m), "{least_m}");
}

#[test]
fn the_strongest_current() {
    let limits = Limits {
        current_max_mps: 0.45,
        ..exact()
    };
    // Nearly along the edge, towards which the current sets.
    let mut dive = off_the_edge(100.0, 255.0, limits, "[current]\nspeed_mps = 0.45\ntowards_deg = 0\n");
    steer_until_refused(&mut dive, 72.0, 2.0);
    let least_m = watch(&mut dive, 5.0 + TURNS_AWAY_S, &south_of(EDGE_M));
    assert!((0.0..0.45 * (5.0 + 180.0 / 14.0)).contains(&least_m), "{least_m}");
}

#[test]
fn the_error_of_navigation() {
    let limits = Limits {
        navigation_error_m: 25.0,
        ..exact()
    };
    let fault = "[[faults.fault]]\nat_s = 0.5\nkind = \"navigation_jump\"\neast_m = 0\nnorth_m = -25\n";
    let mut dive = off_the_edge(180.0, 230.0, limits, fault);
    steer_until_refused(&mut dive, 45.0, 2.0);
    let truth = dive.mvc.truth();
    assert!(
        (truth.local.north_m - truth.believed.north_m - 25.0).abs() < 0.1,
        "{truth:?}"
    );
    let least_m = watch(&mut dive, 5.0 + TURNS_AWAY_S, &south_of(EDGE_M));
    assert!((0.0..25.0).contains(&least_m), "{least_m}");
}

#[test]
fn the_turn_away() {
    let mut dive = off_the_edge(90.0, 262.0, exact(), "");
    steer_until_refused(&mut dive, 80.0, 2.0);
    let least_m = watch(&mut dive, 5.0 + TURNS_AWAY_S, &south_of(EDGE_M));
    assert!((0.0..16.0).contains(&least_m), "{least_m}");
}

/// A vehicle on its way to the edge turns onto a heading along it, as late as the monitor allows, and then receives
/// nothing until it has come back. Returns its distance from the edge, metres.
fn turned_along_the_edge(first_deg: f64, speed_mps: f64, limits: &Limits, more: &str) -> f64 {
    let dive = || {
        let world = world(ORIGIN, (0.0, EDGE_M - 110.0, 268.0), &setpoint(268.0, speed_mps), more);
        let inside = Zone::inside([-700.0, -700.0, 700.0, EDGE_M]);
        let mut dive = Dive::under_way(setup(world, fence(ORIGIN, &[inside]), limits.clone()));
        dive.lost = vec!["$BPEMB"];
        dive
    };
    let ended = steer_until_refused(&mut dive(), first_deg, speed_mps);
    // After the sentence that ended it was lost, a modify may be judged once more, for as long as the vehicle obeys.
    let asked_at = |tenths: u64| {
        let mut dive = dive();
        let at = earlier(ended, 5000) + Duration::from_millis(100 * tenths);
        let until = at.min(ended);
        steer(&mut dive, first_deg, speed_mps, Some(until));
        dive.run_for(at.since(until).as_secs_f64());
        dive.ask(modify(85.0, speed_mps));
        dive.run_for(0.2);
        dive
    };
    let (mut admitted, mut refused) = (0_u64, 95_u64);
    while refused - admitted > 1 {
        let middle = admitted.midpoint(refused);
        if asked_at(middle).states(1).last() == Some(&"rejected") {
            refused = middle;
        } else {
            admitted = middle;
        }
    }
    assert!(admitted > 0, "it was never admitted");
    let mut dive = asked_at(admitted);
    let until = dive.now + Duration::from_secs(10);
    steer(&mut dive, 85.0, speed_mps, Some(until));
    dive.lost.push("$BPRMB");
    watch(&mut dive, 5.0 + 30.0, &south_of(EDGE_M))
}

#[test]
fn the_turn_onto_the_heading() {
    let limits = Limits {
        turn_rate_dps: 12.0,
        ..exact()
    };
    let least_m = turned_along_the_edge(0.0, 2.0, &limits, "");
    assert!((0.0..8.0).contains(&least_m), "{least_m}");
}

#[test]
fn the_other_north() {
    // At the edge of a UTM zone near the pole, where grid north is 2.6 degrees from true north; nearly along the edge.
    let origin = (70.0, -71.8);
    let limits = Limits {
        turn_rate_dps: 14.9,
        navigation_age_max_s: 4.0,
        ..exact()
    };
    let dive = |fault: &str| {
        let more = format!("[interpretation]\nmodify_heading = \"grid\"\n{fault}");
        let world = world(origin, (0.0, 30.0, 262.0), &setpoint(262.0, 2.0), &more);
        let inside = Zone::inside([-700.0, -700.0, 700.0, EDGE_M]);
        let mut dive = Dive::under_way(setup(world, fence(origin, &[inside]), limits.clone()));
        dive.lost = vec!["$BPEMB"];
        dive
    };
    let ended = steer_until_refused(&mut dive(""), 82.0, 2.0);
    // The vehicle is not seen for as long as navigation may be old.
    let frozen_s = ended.as_secs_f64() - 3.75;
    let fault = format!("[[faults.fault]]\nat_s = {frozen_s}\nfor_s = 60\nkind = \"navigation_frozen\"\n");
    let mut dive = dive(&fault);
    steer_until_refused(&mut dive, 82.0, 2.0);

    let least_m = watch(&mut dive, 5.0 + TURNS_AWAY_S, &south_of(EDGE_M));
    assert!((0.0..0.8).contains(&least_m), "{least_m}");
}

/// A turn needs time to begin and to end: the 12-inch vehicle turns at 8.19 degrees a second at 1 m/s, with a time
/// constant of a second, and more slowly for its last 30 degrees. Without the lag it leaves by 0.2 m if nothing else is
/// uncertain, and with limits that are exactly those of the classes by 0.9 m (9-inch, 15) and 1.5 m (12-inch, 10).
#[test]
fn a_turn_has_to_begin() {
    for (class, turn_rate_dps, speed_mps) in [("12-inch", 8.0, 1.0), ("9-inch", 15.0, 2.0), ("12-inch", 10.0, 2.0)] {
        let limits = Limits {
            turn_rate_dps,
            turn_lag_s: 0.5,
            plan_speed_max_mps: None,
            speed_max_mps: speed_mps,
            ..exact()
        };
        let vehicle = format!("[vehicle]\nclass = \"{class}\"\n");
        let least_m = turned_along_the_edge(45.0, speed_mps, &limits, &vehicle);
        assert!((0.0..1.1).contains(&least_m), "{class}: {least_m}");
    }
}

#[test]
fn the_ways_back() {
    // It would leave its line at an angle, and return across the area between the two.
    let zone = [10.0, 22.0, 40.0, 60.0];
    let inside = Zone::inside([-700.0, -700.0, 700.0, 700.0]);
    let plan = line((-200.0, 0.0), (600.0, 0.0));
    let world = world(ORIGIN, (-200.0, 0.0, 90.0), &plan, "");
    let mut dive = Dive::under_way(setup(world, fence(ORIGIN, &[inside, Zone::outside(zone)]), exact()));
    dive.run_for(14.0);
    let until = dive.now + Duration::from_secs(100);
    steer(&mut dive, 60.0, 2.0, Some(until));
    dive.lost.push("$BPRMB");
    let least_m = watch(&mut dive, 120.0, &|truth: &Truth| outside_of(zone, truth.local));
    assert!((0.0..23.0).contains(&least_m), "{least_m}");
}

/// The limit of 2.5 s for a refresh keeps no vehicle inside the fence by itself. Each refresh is judged from the
/// vehicle's position at that time. A runtime that wakes more than half a second late ends its leases, and so does an
/// acknowledgement that is missing for a second, or stale navigation. The limit only matters if the cadence itself is
/// wrong: without it this test fails as soon as a refresh is due each 4 s.
#[test]
fn no_refresh_is_later_than_two_and_a_half_seconds() {
    for late_ms in (100..7000).step_by(300) {
        let mut dive = off_the_edge(150.0, 230.0, exact(), "");
        dive.ask(modify(45.0, 2.0));
        dive.run_for(10.0);
        // Nothing is handled for this long, and then everything.
        dive.now = dive.now + Duration::from_millis(late_ms);
        dive.run_for(10.0);
        let mut last: Option<Timestamp> = None;
        for (at, line) in &dive.sent {
            if line.starts_with("$BPEMB") {
                last = None;
            } else if line.starts_with("$BPRMB") {
                let gap_s = last.map_or(0.0, |last| at.since(last).as_secs_f64());
                assert!(gap_s <= 2.5, "{late_ms} ms: {gap_s}");
                last = Some(*at);
            }
        }
    }
}

/// After a modify the vehicle is as fast again as its plan: the turn away is judged with the speed that was seen while
/// it flew its plan in this dive, or with `plan_speed_max_mps` if that is higher.
#[test]
fn the_plan_may_be_faster_than_any_request() {
    // By then it has reached its speed, or the mission has stated it.
    for (seen_s, plan_speed_max_mps) in [(4.0, None), (0.0, Some(2.5))] {
        let limits = Limits {
            speed_max_mps: 1.4,
            plan_speed_max_mps,
            ..exact()
        };
        let inside = Zone::inside([-700.0, -700.0, 700.0, EDGE_M]);
        let world = world(ORIGIN, (0.0, EDGE_M - 70.0, 262.0), &setpoint(262.0, 2.5), "");
        let mut dive = Dive::under_way(setup(world, fence(ORIGIN, &[inside]), limits));
        dive.run_for(seen_s);
        dive.lost = vec!["$BPEMB"];
        steer_until_refused(&mut dive, 80.0, 1.4);
        let least_m = watch(&mut dive, 5.0 + TURNS_AWAY_S, &south_of(EDGE_M));
        assert!((0.0..5.8).contains(&least_m), "{seen_s} s: {least_m}");
    }
}
