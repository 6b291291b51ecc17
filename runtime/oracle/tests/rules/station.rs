//! Requirements 001, 005 and 014: how a hovering vehicle keeps its station.

use crate::scenario::Scenario;

const SUSPEND: &str = "BPSUS,{t}";
const CONTINUE: &str = "BPCON,{t}";
const RESUME: &str = "BPRES,{t}";

/// BPSUS at 3 s, and then a refresh each half second until 6 s.
fn held() -> Scenario {
    let mut run = Scenario::with_control()
        .ours(3000, SUSPEND)
        .ours(3001, "BPSPD,{t},0.5")
        .ours(3250, "BPGHP,{t},2.5,-1.25,1.5");
    for ms in (3500..=6000).step_by(500) {
        run = run.ours(ms, CONTINUE);
    }
    run
}

#[test]
fn requirement_005_a_station_that_is_refreshed_and_ended_is_no_violation() {
    let outcome = held().ours(6400, RESUME).finds_nothing();
    assert_eq!(outcome.statistics.stations, 1);
    assert!(
        (outcome.statistics.station_s - 3.4).abs() < 1e-9,
        "{:?}",
        outcome.statistics
    );
    held().ours(6400, "BPSUS,{t}").ours(7400, RESUME).finds_nothing();
    held()
        .ours(7000, "BPGBP,{t},1,2,A,3")
        .ours(7400, RESUME)
        .finds_nothing();
}

#[test]
fn requirement_005_no_gap_over_a_second() {
    held().ours(7100, CONTINUE).ours(7200, RESUME).finds(&["station-gap"]);
    held().ours(7100, RESUME).finds(&["station-gap"]);
    held().finds(&["station-gap"]);
    // The runtime cannot avoid a gap when the link is lost or when it is stopped.
    held().link(6500, false).finds_nothing();
    held().stopped(6500).finds_nothing();
    held().stopped(6500).ours(9000, RESUME).finds_nothing();
}

#[test]
fn requirement_005_station_keeping_that_is_over_is_not_refreshed() {
    for body in [CONTINUE, "BPGHP,{t},2.5,-1.25,1.5", "BPGBP,{t},1,2,A,3"] {
        held().ours(6400, RESUME).ours(6500, body).finds(&["station-dead"]);
        Scenario::with_control().ours(3000, body).finds(&["station-dead"]);
        held().reconnects(6500, 7000).ours(8000, body).finds(&["station-dead"]);
    }
}

#[test]
fn requirement_014_station_keeping_ends_with_control() {
    let lost = || held().vehicle(6000, "BFCTL,{t},0");
    lost().ours(6250, "BPSPD,{t},1.5").ours(6251, RESUME).finds_nothing();
    lost().ours(6350, RESUME).finds(&["end-missing"]);
    lost().ours(6251, RESUME).ours(6400, RESUME).finds(&["end-surplus"]);
    lost()
        .ours(6251, RESUME)
        .ours(6400, "BPSPD,{t},1.5")
        .finds(&["not-allowed-without-control"]);
}

#[test]
fn requirement_001_nobody_keeps_station_without_control() {
    for body in [SUSPEND, CONTINUE, "BPGHP,{t},2.5,-1.25,1.5", "BPGBP,{t},1,2,A,3"] {
        Scenario::without_control().ours(3000, body).finds(&["no-control"]);
    }
}

#[test]
fn requirement_002_a_move_keeps_to_its_box() {
    let moved = |body: &str| {
        Scenario::with_control()
            .limits(|limits| {
                limits.hull_box = Some([[-5.0, 5.0], [-2.0, 2.0], [1.0, 4.0]]);
                limits.bottom_box = Some([[-5.0, 5.0], [-5.0, 5.0], [1.0, 9.0]]);
            })
            .ours(3000, SUSPEND)
            .ours(3250, body)
            .ours(3500, RESUME)
    };
    for body in ["BPGHP,{t},5,-2,1", "BPGBP,{t},5,-5,D,9", "BPGBP,{t},5,-5,A,40"] {
        moved(body).finds_nothing();
    }
    for body in [
        "BPGHP,{t},5.1,-1,2",
        "BPGHP,{t},2,-1,0.9",
        "BPGBP,{t},5,-5.1,D,5",
        "BPGBP,{t},5,-5,D,9.1",
    ] {
        moved(body).finds(&["request-box"]);
    }
}
