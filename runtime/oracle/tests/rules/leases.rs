//! Requirements 003, 007 and 008: how modifies begin, go on and end.

use backseat_oracle::Activity;

use crate::scenario::{END, MODIFY, Scenario};

fn lease() -> Scenario {
    Scenario::with_control()
        .lease(3000, 6000)
        .activity(6600, Activity::Plan)
}

#[test]
fn requirement_003_a_lease_that_is_refreshed_and_ended_is_no_violation() {
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
fn requirement_003_a_lease_must_not_stop_without_an_end() {
    lease().finds(&["modify-gap", "modify-abandoned"]);
}

#[test]
fn requirement_003_never_faster_than_five_hertz() {
    lease().ours(6196, MODIFY).ours(6500, END).finds_nothing();
    lease().ours(6190, MODIFY).ours(6500, END).finds(&["modify-too-fast"]);
    // A new lease is no exception.
    lease()
        .ours(6050, END)
        .ours(6100, MODIFY)
        .ours(6500, END)
        .finds(&["modify-too-fast"]);
}

#[test]
fn requirement_003_an_unanswered_lease_must_end() {
    // A second, the 100 ms of the end, and 800 ms for the delays of the link and a busy vehicle.
    let silent = || {
        Scenario::with_control()
            .without_answers()
            .lease(3000, 4000)
            .activity(5200, Activity::Plan)
    };
    silent().ours(4890, END).finds_nothing();
    silent().ours(4910, END).finds(&["modify-unanswered"]);
    // An answer to a later modify counts.
    silent()
        .vehicle(4500, "BFACK,{t},RMB,000003.000,0,2,0,ok")
        .ours(5000, END)
        .finds_nothing();
}

#[test]
fn requirement_003_a_lease_ends_when_it_is_refused() {
    let refused = || lease().vehicle(6000, "BFACK,{t},RMB,000004.000,0,1,0,no");
    refused().ours(6300, END).finds_nothing();
    refused().ours(6310, END).finds(&["lease-outlives"]);
    // This refusal belongs to an earlier lease.
    Scenario::with_control()
        .ours(2000, MODIFY)
        .ours(2500, END)
        .lease(3000, 6000)
        .activity(6600, Activity::Plan)
        .vehicle(4000, "BFACK,{t},RMB,000001.000,0,1,0,no")
        .ours(6500, END)
        .finds_nothing();
}

#[test]
fn requirement_003_a_lease_ends_with_the_behavior_that_it_modifies() {
    for words in ["BFMBS,{t},a.dive,3,,trackline", "BFMBE,{t},a.dive,2,,trackline"] {
        let next = || lease().vehicle(6000, words);
        next().ours(6300, END).finds_nothing();
        next().ours(6310, END).finds(&["lease-outlives"]);
        // The lease may begin again at once.
        next()
            .ours(6200, END)
            .ours(6201, MODIFY)
            .ours(6500, END)
            .finds_nothing();
    }
}

#[test]
fn requirement_003_a_standstill_ends_the_lease_before_anything_else() {
    let stopped = || lease().stopped(6500).continued(8500).activity(9500, Activity::Plan);
    stopped()
        .ours(8500, END)
        .ours(8510, MODIFY)
        .ours(9000, END)
        .finds_nothing();
    stopped()
        .ours(8500, MODIFY)
        .ours(9000, END)
        .finds(&["lease-after-stop"]);
    // A short standstill may pass unnoticed.
    lease()
        .stopped(6500)
        .continued(8000)
        .ours(8000, MODIFY)
        .ours(8100, END)
        .activity(8200, Activity::Plan)
        .finds_nothing();
    // On a new connection it is a new lease.
    lease()
        .stopped(6500)
        .reconnects(7000, 8000)
        .ours(8900, "BPSTS,{t},1,well")
        .vehicle(8900, "BFACK,{t},STS,{t},0,2,0,ok")
        .ours(9000, MODIFY)
        .ours(9500, END)
        .activity(9600, Activity::Plan)
        .finds_nothing();
}

#[test]
fn requirement_003_a_modify_inherits_no_value() {
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
fn requirement_002_a_modify_must_not_certainly_lead_out_of_the_fence() {
    // A minute of longitude is 1379.9 m here: at 1.5 m/s the vehicle goes 6.75 m in 4.5 s, 0.0049 of it.
    let near = |place| {
        Scenario::with_control()
            .believes(0, place)
            .ours(3000, MODIFY)
            .ours(3500, END)
    };
    near("4200.300,N,07000.0060,W").finds(&["modify-margin"]);
    near("4200.300,N,07000.0040,W").finds(&["modify-fence"]);
    // The vehicle is already outside.
    near("4159.900,N,07000.5000,W").finds(&["modify-fence"]);
    // The vehicle heads into the mooring, from 9 m before it and from 5 m.
    near("4200.660,N,07000.7265,W").finds(&["modify-margin"]);
    near("4200.660,N,07000.7236,W").finds(&["modify-fence"]);
    // The wreck is deeper.
    near("4200.180,N,07000.7236,W").finds_nothing();
    // The vehicle turns away, and nobody knows whether there is room for that. But it was in the margin before.
    Scenario::with_control()
        .believes(0, "4200.300,N,07000.0040,W")
        .ours(3000, "BPRMB,{t},270,10,0,1.5,1,0")
        .ours(3500, END)
        .finds(&["modify-margin"]);
}

#[test]
fn requirement_004_a_modify_keeps_the_margin_at_the_believed_position() {
    let near = |place, body| {
        Scenario::with_control()
            .believes(0, place)
            .ours(3000, body)
            .ours(3500, END)
    };
    let west = "BPRMB,{t},270,10,0,1.5,1,0";
    // The margin of 20 m less 1 m, and 6.75 m of way: 26.9 m and 24.8 m from the eastern edge.
    near("4200.300,N,07000.0195,W", MODIFY).finds_nothing();
    near("4200.300,N,07000.0180,W", MODIFY).finds(&["modify-margin"]);
    // Away from the edge only the place itself counts: 20.0 m and 18.6 m.
    near("4200.300,N,07000.0145,W", west).finds_nothing();
    near("4200.300,N,07000.0135,W", west).finds(&["modify-margin"]);
    // 37.0 m and 35.0 m before the mooring, whose margin is 30 m; and beside the wreck, which is deeper.
    near("4200.660,N,07000.7468,W", MODIFY).finds_nothing();
    near("4200.660,N,07000.7454,W", MODIFY).finds(&["modify-margin"]);
    near("4200.180,N,07000.7300,W", MODIFY).finds_nothing();
    near("4200.180,N,07000.7300,W", "BPRMB,{t},90,35,0,1.5,1,0").finds_nothing();
    near("4200.180,N,07000.7300,W", "BPRMB,{t},90,12,1,1.5,1,0").finds_nothing();
    // The runtime may not have received the newest place, and the one before it may be old: both must be in the margin.
    let moved = |ms| {
        Scenario::with_control()
            .believes(0, "4200.300,N,07000.0135,W")
            .believes(ms, "4200.300,N,07000.0300,W")
            .ours(3000, west)
            .ours(3500, END)
    };
    moved(2900).finds_nothing();
    moved(3100).finds(&["modify-margin"]);
}

#[test]
fn requirement_004_a_refresh_must_not_certainly_lead_out_of_the_fence() {
    Scenario::with_control()
        .believes(4500, "4200.300,N,07000.8990,W")
        .believes(4600, "4200.300,N,07000.8980,W")
        .ours(3000, MODIFY)
        .ours(4000, "BPRMB,{t},90,10,0,1.5,1,0")
        .ours(5000, MODIFY)
        .ours(5200, END)
        .finds_nothing();
    let comes_near = |ms, place| {
        // A step of 29 m, which this mission accepts as a correction.
        Scenario::with_control()
            .limits(|limits| limits.position_step_m = 40.0)
            .believes(0, "4200.300,N,07000.0250,W")
            .believes(ms, place)
            .ours(3000, MODIFY)
            .ours(4000, MODIFY)
            .ours(4100, END)
    };
    comes_near(3500, "4200.300,N,07000.0040,W").finds(&["refresh-fence"]);
    comes_near(3500, "4200.300,N,07000.0060,W").finds(&["modify-margin"]);
    // The runtime may not have received yet what the vehicle has just sent.
    comes_near(3800, "4200.300,N,07000.0040,W").finds_nothing();
}

#[test]
fn requirement_021_a_jump_ends_the_lease_until_navigation_has_been_steady() {
    // 83 m to the west.
    let jumps = || Scenario::with_control().believes(5000, "4200.300,N,07000.960,W");
    let leased = || jumps().lease(3000, 4900).activity(5500, Activity::Plan);
    leased().ours(5300, END).finds_nothing();
    leased().ours(5310, END).finds(&["jump-ignored"]);
    let later = |ms| jumps().ours(ms, MODIFY).ours(ms + 100, END);
    jumps().ours(5250, MODIFY).ours(5300, END).finds_nothing();
    later(6000).finds(&["jump-ignored"]);
    later(14_600).finds(&["jump-ignored"]);
    later(14_800).finds_nothing();
    // 9 m could be a correction; 20 m are a jump for an oracle that compares position and velocity.
    let steps = |place| {
        let steps = Scenario::with_control().believes(5000, place);
        steps.ours(6000, MODIFY).ours(6100, END)
    };
    steps("4200.300,N,07000.9065,W").finds_nothing();
    steps("4200.300,N,07000.9145,W").finds(&["navigation-untrue"]);
}

#[test]
fn requirement_021_a_runtime_that_takes_navigation_for_old_may_miss_a_jump_until_it_has_no_navigation() {
    // The vehicle's clock goes back by 3 s at 4.5 s.
    let leased = |end_ms| {
        Scenario::with_control()
            .navigation_delay(4500, 3000)
            .believes(5000, "4200.300,N,07000.960,W")
            .lease(3000, 4900)
            .activity(5900, Activity::Plan)
            .ours(end_ms, END)
    };
    leased(5700).finds_nothing();
    leased(5900).finds(&["jump-ignored"]);
}

#[test]
fn requirement_021_a_single_sample_that_is_old_and_elsewhere_is_no_jump() {
    // This sample is damaged in its time and its position, and its checksum is right by chance.
    let elsewhere = || {
        Scenario::with_control()
            .navigation_delay(5000, 5000)
            .believes(5000, "4200.300,N,07000.960,W")
            .ours(8000, MODIFY)
            .ours(8100, END)
    };
    let back = "4200.300,N,07000.900,W";
    let alone = |place| elsewhere().navigation_delay(5100, 0).believes(5100, place);
    alone(back).finds_nothing();
    // The next sample is at the other place too.
    alone("4200.300,N,07000.960,W").finds(&["jump-ignored"]);
    // Two such samples mean that a clock was set.
    elsewhere().believes(5200, back).finds(&["jump-ignored"]);
}

#[test]
fn requirement_021_a_jump_during_a_link_loss_counts() {
    let lost = || {
        Scenario::with_control()
            .believes(5000, "4200.300,N,07000.990,W")
            .reconnects(4000, 5500)
    };
    lost().ours(7000, MODIFY).ours(7100, END).finds(&["jump-ignored"]);
    // A new process has not seen where the vehicle was.
    lost().started(5000).ours(7000, MODIFY).ours(7100, END).finds_nothing();
}

#[test]
fn requirement_021_a_lease_beside_a_sentence_that_moves_the_position_is_a_violation() {
    let reset = |body: &str, ms: u64| {
        Scenario::with_control()
            .limits(|limits| limits.operator_commands = true)
            .ours(ms, body)
            .ours(3000, MODIFY)
            .ours(3600, END)
    };
    for body in ["BPRNS,{t},1,2,3", "BPRBO,{t},3"] {
        reset(body, 2000).finds(&["jump-ignored"]);
        reset(body, 3300).finds(&["jump-ignored"]);
        reset(body, 4000).finds_nothing();
    }
}

#[test]
fn requirement_007_a_modify_lapses_by_the_vehicles_clock() {
    // 5.1 s and 200 ms of delay after the last modify.
    let cut = Scenario::with_control().lease(3000, 6000).link(6100, false);
    cut.clone().activity(11_300, Activity::Plan).finds_nothing();
    cut.activity(11_500, Activity::Plan).finds(&["modify-outlives"]);
    Scenario::with_control()
        .activity(3000, Activity::Modified)
        .activity(4000, Activity::Plan)
        .finds(&["modify-outlives"]);
}

#[test]
fn requirement_007_a_modify_lapses_after_it_was_received() {
    // The link holds a modify back for 1.5 s, and then breaks.
    let late = |last_ms: u64| {
        let mut run = Scenario::with_control().ours(3000, MODIFY).ours(3100, END);
        run = run.arrives(3000, 3010, MODIFY).arrives(3100, 3110, END);
        run.lease(4000, 6000)
            .arrives(4000, 4010, MODIFY)
            .arrives(6000, last_ms, MODIFY)
            .link(7600, false)
    };
    late(7500).activity(12_600, Activity::Plan).finds_nothing();
    late(7500).activity(12_900, Activity::Plan).finds(&["modify-outlives"]);
    late(6010).activity(11_300, Activity::Plan).finds(&["modify-outlives"]);
    // The vehicle may still accept a modify that was damaged on its way.
    let damaged = |body: &str| {
        Scenario::with_control()
            .lease(4000, 5000)
            .arrives(4000, 4010, MODIFY)
            .link(5100, false)
            .arrives(4000, 8000, body)
            .activity(12_900, Activity::Plan)
    };
    damaged("BPRMB,{t},90,10,0,1.5,1").finds(&["stale-delivery"]);
    damaged("BPRXB,{t},90,10,0,1.5,1,0").finds(&["modify-outlives"]);
}

#[test]
fn requirement_007_nothing_that_steers_arrives_late() {
    let arrives = |ms: u64| {
        lease()
            .arrives(3000, 3010, MODIFY)
            .arrives(4000, 4010, MODIFY)
            .arrives(5000, 5010, MODIFY)
            .arrives(6000, ms, MODIFY)
            .ours(6500, END)
            .activity(10_000, Activity::Plan)
    };
    arrives(8650).finds_nothing();
    arrives(8750).finds(&["stale-delivery"]);
}

#[test]
fn requirement_007_a_stopped_runtime_cannot_end_its_lease() {
    let stopped = || Scenario::with_control().lease(3000, 6000).stopped(6500);
    stopped().activity(11_200, Activity::Plan).finds_nothing();
    stopped().activity(11_500, Activity::Plan).finds(&["modify-outlives"]);
    // A runtime that wakes late ends the lease first of all.
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
            run = run.vehicle(ms, "BFNVR,{t},0,0,0,0,0,0");
        }
        run.ours(8000, MODIFY).ours(8100, END)
    };
    run("{t}").finds_nothing();
    run("000002.800").finds(&["stale-navigation"]);
}

#[test]
fn requirement_008_a_connection_without_navigation_allows_no_lease() {
    Scenario::with_control()
        .navigation(0, false)
        .ours(5000, MODIFY)
        .ours(5100, END)
        .finds(&["stale-navigation"]);
}

#[test]
fn requirement_008_one_fix_by_another_clock_makes_no_later_fix_stale() {
    // The clock is set forward for one fix, and set back while navigation is missing. No answer shows it, and the times
    // of the solutions never go back.
    let run = || {
        Scenario::with_control()
            .clock_set_during(3950..4051, 7000)
            .navigation(4050, false)
            .navigation(11_100, true)
            .activity(19_000, Activity::Plan)
    };
    run().ours(13_000, MODIFY).ours(13_100, END).finds_nothing();
    let silent = run().navigation(13_950, false);
    silent.clone().ours(15_195, MODIFY).ours(15_200, END).finds_nothing();
    silent
        .ours(15_250, MODIFY)
        .ours(15_260, END)
        .finds(&["stale-navigation"]);
}
