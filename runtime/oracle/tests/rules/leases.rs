//! Requirements 003, 007 and 008: how modifies live and die.

use backseat_oracle::Activity;

use crate::scenario::{END, MODIFY, Scenario};

fn lease() -> Scenario {
    Scenario::with_control()
        .lease(3000, 6000)
        .activity(6600, Activity::Plan)
}

#[test]
fn requirement_003_a_lease_that_is_kept_and_ended_finds_nothing() {
    let outcome = lease().ours(6500, END).finds_nothing();
    let statistics = outcome.statistics;
    assert_eq!(
        (statistics.leases, statistics.modifies, statistics.end_modifies),
        (1, 4, 1)
    );
    assert!((statistics.lease_s - 3.5).abs() < 1e-9, "{statistics:?}");
    assert!((statistics.truth_modified_s - 3.5).abs() < 1e-9, "{statistics:?}");
    assert_eq!((statistics.control_spans, statistics.connections), (1, 1));
    assert!((statistics.control_s - 19.9).abs() < 1e-9, "{statistics:?}");
    assert_eq!((statistics.navigations, statistics.truths), (201, 201));
    assert!(statistics.truth_judged > 100);
}

#[test]
fn requirement_003_no_gap_over_two_and_a_half_seconds() {
    lease().ours(8500, MODIFY).ours(9000, END).finds_nothing();
    lease().ours(8600, MODIFY).ours(9000, END).finds(&["modify-gap"]);
    lease().ours(8600, END).finds(&["modify-gap"]);
}

#[test]
fn requirement_003_a_lease_does_not_just_stop() {
    lease().finds(&["modify-gap", "modify-abandoned"]);
}

#[test]
fn requirement_003_never_faster_than_five_hertz() {
    lease().ours(6196, MODIFY).ours(6500, END).finds_nothing();
    lease().ours(6190, MODIFY).ours(6500, END).finds(&["modify-too-fast"]);
    // A new lease makes no exception.
    lease()
        .ours(6050, END)
        .ours(6100, MODIFY)
        .ours(6500, END)
        .finds(&["modify-too-fast"]);
}

#[test]
fn requirement_003_nothing_is_inherited() {
    for body in [
        "BPRMB,{t},,10,0,1.5,1,0",
        "BPRMB,{t},90,,0,1.5,1,0",
        "BPRMB,{t},90,10,,1.5,1,0",
        "BPRMB,{t},90,10,0,,1,0",
        "BPRMB,{t},90,10,0,1.5,,0",
        "BPRMB,{t},90,10,0,1.5,1,",
    ] {
        lease().ours(6300, body).ours(6500, END).finds(&["modify-inherits"]);
    }
}

#[test]
fn requirement_002_a_modify_keeps_to_the_limits() {
    let modify = |body: &str| lease().ours(6300, body).ours(6500, END);
    modify("BPRMB,{t},90,10,1,1.5,1,0").finds_nothing();
    modify("BPRMB,{t},90,41,0,1.5,1,0").finds(&["request-vertical"]);
    modify("BPRMB,{t},90,2,1,1.5,1,0").finds(&["request-vertical"]);
    modify("BPRMB,{t},90,10,0,2.6,1,0").finds(&["request-speed"]);
    modify("BPRMB,{t},90,10,0,0.4,1,0").finds(&["request-speed"]);
}

#[test]
fn requirement_007_a_modify_lapses_by_the_vehicles_clock() {
    // 5.1 s and 200 ms of delay after the last one.
    let cut = Scenario::with_control().lease(3000, 6000).link(6100, false);
    cut.clone().activity(11_300, Activity::Plan).finds_nothing();
    cut.activity(11_500, Activity::Plan).finds(&["modify-outlives"]);
    Scenario::with_control()
        .activity(3000, Activity::Modified)
        .activity(4000, Activity::Plan)
        .finds(&["modify-outlives"]);
}

#[test]
fn requirement_007_a_stopped_runtime_cannot_end_its_lease() {
    let stopped = || Scenario::with_control().lease(3000, 6000).stopped(6500);
    stopped().activity(11_200, Activity::Plan).finds_nothing();
    stopped().activity(11_500, Activity::Plan).finds(&["modify-outlives"]);
    // Woken up late, it ends the lease first of all.
    stopped().ours(9000, END).activity(9100, Activity::Plan).finds_nothing();
}

#[test]
fn requirement_008_no_refresh_while_navigation_is_stale() {
    // The last solution is of 3.9 s: at 5.2 s it is 1.3 s old, as old as it may be on this link.
    let silent = || {
        Scenario::with_control()
            .navigation(3950, false)
            .activity(7000, Activity::Plan)
    };
    silent().ours(5195, MODIFY).ours(5200, END).finds_nothing();
    silent().ours(5250, MODIFY).ours(5260, END).finds(&["stale-navigation"]);
}

#[test]
fn requirement_008_a_lease_ends_when_navigation_goes_stale() {
    let silent = || {
        Scenario::with_control()
            .lease(3000, 4000)
            .navigation(3950, false)
            .activity(5300, Activity::Plan)
    };
    silent().ours(5250, END).finds_nothing();
    silent().ours(5400, END).finds(&["stale-navigation"]);
}

#[test]
fn requirement_008_a_repeated_or_late_solution_is_not_fresh() {
    let run = |solution: &str| {
        let mut run = Scenario::with_control().navigation(3950, false);
        for ms in (4000..9000).step_by(100) {
            run = run.vehicle(
                ms,
                &format!("BFNVG,{{t}},4200.300,N,07000.900,W,1,30,10,90,0,0,{solution}"),
            );
        }
        run.ours(8000, MODIFY).ours(8100, END)
    };
    run("{t}").finds_nothing();
    run("000002.800").finds(&["stale-navigation"]);
}

#[test]
fn requirement_008_a_connection_without_navigation_gives_no_lease() {
    Scenario::with_control()
        .navigation(0, false)
        .ours(5000, MODIFY)
        .ours(5100, END)
        .finds(&["stale-navigation"]);
}
