//! Requirements 023 and 024: nothing that steers leaves on navigation, or on a clock, that has just proved to be wrong.

use crate::scenario::{END, MODIFY, Outcome, Scenario, stamp};

const TRACKLINE: &str = "BPRTK,{t},7,4200.300,N,07000.900,W,4200.300,N,07000.700,W,0,10,1.5,0,0";

fn modified(run: Scenario, ms: u64) -> Scenario {
    run.ours(ms, MODIFY).ours(ms + 100, END)
}

fn rules(outcome: &Outcome) -> Vec<&str> {
    outcome.violations.iter().map(|violation| violation.rule).collect()
}

/// What the oracle finds for a lease from 3 s to 18 s while the reported position creeps from 4 s on.
fn under_a_creep(mps: f64) -> Outcome {
    let run = Scenario::with_control().creeps(4000, 18_000, mps).lease(3000, 18_000);
    run.ours(18_500, END)
        .activity(18_600, backseat_oracle::Activity::Plan)
        .run(20_000)
}

#[test]
fn requirement_024_a_lease_on_a_creeping_position_is_found_unless_the_creep_is_within_the_limits() {
    // 10 m and 0.3 m/s in 9.5 s are 12.9 m.
    for mps in [0.1, 0.3, 1.0, 1.3] {
        assert_eq!(rules(&under_a_creep(mps)), Vec::<&str>::new(), "{mps} m/s");
    }
    for mps in [1.5, 2.0, 3.0, 8.0, -1.5, -8.0] {
        let outcome = under_a_creep(mps);
        let found = rules(&outcome);
        assert!(!found.is_empty(), "{mps} m/s");
        assert!(found.iter().all(|rule| *rule == "navigation-untrue"), "{found:?}");
    }
    // The violation is dated by the first sample that shows it: 8 m/s for 1.5 s are 12 m.
    assert!(under_a_creep(8.0).violations[0].at_ns <= 6_000_000_000);
    let tight = |mps| {
        let run = Scenario::with_control().limits(|limits| limits.position_step_m = 5.0);
        modified(run.creeps(4000, 18_000, mps), 14_000)
    };
    tight(0.7).finds_nothing();
    tight(1.0).finds(&["navigation-untrue"]);
}

#[test]
fn requirement_024_an_error_that_position_and_velocity_share_cannot_be_seen() {
    let run = Scenario::with_control().creeps(0, 20_000, 1.5).goes_north(1.5);
    modified(run, 14_000).finds_nothing();
    // The vehicle and the position stand still, and only the velocity is wrong: that is no error of the position.
    modified(Scenario::with_control().goes_north(3.0), 14_000).finds_nothing();
}

#[test]
fn requirement_024_a_creep_that_is_over_is_forgotten_with_its_window() {
    // The position creeps 24 m from 4 s to 7 s. A lease at 6.8 s is wrong, and so is one at 12 s.
    let crept = |ms| modified(Scenario::with_control().creeps(4000, 7000, 8.0), ms);
    crept(6800).finds(&["navigation-untrue"]);
    crept(12_000).finds(&["navigation-untrue"]);
    crept(16_900).finds_nothing();
    // The runtime may not have received yet what the vehicle has just sent.
    crept(5700).finds_nothing();
    let insert = Scenario::with_control().creeps(4000, 7000, 8.0).ours(8000, TRACKLINE);
    insert.finds(&["navigation-untrue"]);
}

#[test]
fn requirement_024_a_new_connection_or_process_begins_a_new_window() {
    let lost = Scenario::with_control()
        .creeps(4000, 5500, 9.0)
        .reconnects(5600, 5700)
        .ours(6500, MODIFY)
        .ours(6600, END);
    lost.finds_nothing();
    let stopped = Scenario::with_control().creeps(4000, 5800, 8.0).stopped(4100);
    modified(stopped.continued(5900), 7000).finds_nothing();
    let killed = Scenario::with_control().creeps(4000, 6500, 8.0).started(7000);
    modified(
        killed
            .ours(7050, "BPRMP,{t}")
            .vehicle(7060, "BFPLN,{t},1,,0,0,4200.300,N,07000.900,W,,,"),
        8200,
    )
    .finds_nothing();
}

#[test]
fn requirement_024_navigation_without_velocities_steers_nothing_for_ten_seconds() {
    let without = |until, ms| modified(Scenario::with_control().without_velocities(4000..until), ms);
    // The first sample without velocities is that of 4 s, and 1.7 s later the gap is certainly too long.
    without(5700, 6500).finds_nothing();
    without(5900, 6500).finds(&["velocity-missing"]);
    without(5900, 15_600).finds(&["velocity-missing"]);
    without(5900, 15_800).finds_nothing();
    let patient = Scenario::with_control().limits(|limits| limits.velocity_gap_s = 3.0);
    modified(patient.without_velocities(4000..6900), 7500).finds_nothing();
    // No velocities at all, and an insert.
    let never = Scenario::with_control().without_velocities(0..20_000);
    never.ours(8000, TRACKLINE).finds(&["velocity-missing"]);
}

#[test]
fn requirement_023_after_a_clock_was_set_nothing_steers_for_ten_seconds() {
    let set = |by_ms, ms| modified(Scenario::with_control().clock_set(5000, by_ms), ms);
    for by_ms in [600, 3000] {
        // The beat of 5.055 s shows it.
        set(by_ms, 5200).finds_nothing();
        set(by_ms, 6500).finds(&["clock-set"]);
        set(by_ms, 14_900).finds(&["clock-set"]);
        set(by_ms, 15_000).finds_nothing();
    }
    set(300, 6500).finds_nothing();
    // Backwards: navigation does not count until its time has passed that of the sample before.
    set(-600, 8000).finds(&["clock-set"]);
    set(-600, 15_000).finds_nothing();
    // A new process does not know what time the vehicle had before.
    let killed = Scenario::with_control().clock_set(5000, 3000).started(6000);
    let killed = killed.vehicle(6100, "BFPLN,{t},1,,0,0,4200.300,N,07000.900,W,,,");
    modified(killed, 7500).finds_nothing();
}

/// The vehicle answers BPLOG once a second and no BPSTS, and its clock is set at 5 s.
fn answers_only_subscriptions(by_ms: u64) -> Scenario {
    let run = Scenario::with_control().beats_until(0).without_answers();
    let run = run.clock_set(5000, by_ms.cast_signed()).ours(200, "BPLOG,CTL,ON");
    (255..20_000).step_by(1000).fold(run, |run, ms| {
        run.ours(ms, "BPLOG,ACK,ON")
            .vehicle(ms + 5, &answer("LOG,000000.000", ms + 5, by_ms))
    })
}

/// An answer to this command, with the time of a clock that was set at 5 s.
fn answer(command: &str, ms: u64, by_ms: u64) -> String {
    let made = stamp(if ms < 5000 { ms } else { ms + by_ms });
    format!("BFACK,{made},{command},0,2,0,ok")
}

#[test]
fn requirement_023_answers_to_subscriptions_also_show_that_a_clock_was_set() {
    let set = |ms| modified(answers_only_subscriptions(3000), ms);
    // The beat of 5.26 s shows it.
    set(5400).finds_nothing();
    set(6500).finds(&["clock-set"]);
    set(15_100).finds(&["clock-set"]);
    set(15_300).finds_nothing();
}

#[test]
fn requirement_023_a_set_clock_that_the_runtime_has_seen_before_does_not_count_again() {
    let precise = |run: Scenario, ms: u64| {
        run.ours(ms, "BPSTS,{t},1,well")
            .vehicle(ms + 5, &answer(&format!("STS,{}", stamp(ms)), ms + 5, 3000))
    };
    // The first answer with a time, after the clock was set, comes 10 s after those that have none.
    let run = precise(answers_only_subscriptions(3000), 3000);
    modified(precise(run, 15_600), 17_000).finds_nothing();
    // Echoes with fewer decimals show it to the runtime, but the oracle does not measure them.
    let coarse = |run: Scenario, ms: u64| {
        let echo = stamp(ms);
        let echo = echo.split_at(echo.len() - 1).0;
        run.ours(ms, "BPSTS,{t},1,well")
            .vehicle(ms + 5, &answer(&format!("STS,{echo}"), ms + 5, 3000))
    };
    let run = Scenario::with_control().beats_until(4500).without_answers();
    let run = run.clock_set(5000, 3000);
    let run = (5055..15_000).step_by(1000).fold(run, coarse);
    modified(precise(run, 15_055), 15_500).finds_nothing();
}

#[test]
fn requirement_023_an_answer_to_an_earlier_subscription_sets_no_clock() {
    // The vehicle answers the first BPLOG too, which left before answers were asked for. So the second answer, made before
    // the third BPLOG left, is to the second.
    let run = Scenario::with_control()
        .ours(200, "BPLOG,CTL,ON")
        .ours(300, "BPLOG,ACK,ON");
    let run = run.vehicle(1000, &answer("LOG,000000.000", 900, 0));
    let run = run.ours(4000, "BPLOG,ACK,ON");
    let run = run.vehicle(4100, &answer("LOG,000000.000", 3000, 0));
    modified(run, 6000).finds_nothing();
}

#[test]
fn requirement_023_a_late_answer_to_a_subscription_sets_no_clock() {
    // The vehicle answers the BPLOG that left at 4 s at once, but the link stalls for 4 s.
    let run = Scenario::with_control().beats_until(5000);
    let run = run.ours(300, "BPLOG,ACK,ON");
    let run = run.vehicle(310, &answer("LOG,000000.000", 310, 0));
    let run = run.ours(4000, "BPLOG,ACK,ON").ours(7000, "BPLOG,ACK,ON");
    let run = run.vehicle(8000, &answer("LOG,000000.000", 4100, 0));
    modified(run, 9000).finds_nothing();
}

#[test]
fn requirement_023_an_answer_to_a_subscription_after_a_reconnection_sets_no_clock() {
    let beat = |run: Scenario, ms| {
        run.ours(ms, "BPSTS,{t},1,well")
            .vehicle(ms + 5, &answer(&format!("STS,{}", stamp(ms)), ms + 5, 0))
    };
    // The answer may be to a BPLOG of the connection before. Its time is of 4 s ago.
    let run = |run: Scenario| {
        let run = run.beats_until(4500).without_answers().reconnects(5000, 5100);
        let run = run.ours(5150, "BPLOG,ACK,ON");
        let run = run.vehicle(5160, &answer("LOG,000000.000", 1160, 0));
        [5400, 6400].into_iter().fold(run, beat)
    };
    let before = Scenario::with_control().ours(4900, "BPLOG,ACK,ON");
    modified(run(before), 7000).finds_nothing();
    // No BPLOG left before.
    modified(run(Scenario::with_control()), 7000).finds(&["clock-set"]);
}

#[test]
fn requirement_023_the_runtime_may_not_know_of_a_clock_that_was_set_as_the_link_was_lost() {
    let beat = |run: Scenario, (ms, by_ms)| {
        run.ours(ms, "BPSTS,{t},1,well")
            .vehicle(ms + 5, &answer(&format!("STS,{}", stamp(ms)), ms + 5, by_ms))
    };
    let run = |lost_ms| {
        let run = Scenario::with_control().beats_until(5000).without_answers();
        let run = beat(run, (5055, 3000)).reconnects(lost_ms, lost_ms + 100);
        [(5500, 0), (6500, 0)].into_iter().fold(run, beat)
    };
    // It was set back before the link came up again.
    modified(run(5100), 7000).finds_nothing();
    modified(run(5400), 7000).finds(&["clock-set"]);
}

#[test]
fn requirement_023_after_a_refusal_the_next_lease_waits() {
    let refused = |run: Scenario, ms: u64| {
        let refusal = format!("BFACK,{{t}},RMB,{},0,1,0,no", stamp(ms));
        run.ours(ms, MODIFY).vehicle(ms + 50, &refusal).ours(ms + 60, END)
    };
    let run = || Scenario::with_control().without_answers();
    let once = || refused(run(), 3000);
    modified(once(), 3290).finds_nothing();
    modified(once(), 3500).finds(&["pause-ignored"]);
    modified(once(), 4000).finds(&["pause-ignored"]);
    modified(once(), 4100).finds_nothing();
    // The pause is longer each time.
    let twice = || refused(once(), 4500);
    modified(twice(), 6500).finds(&["pause-ignored"]);
    modified(twice(), 6600).finds_nothing();
    // A repeated refusal counts once.
    let again = format!("BFACK,{{t}},RMB,{},0,1,0,no", stamp(3000));
    modified(once().vehicle(3051, &again), 4100).finds_nothing();
    // A refusal of another request does not count.
    let insert = run()
        .ours(3000, TRACKLINE)
        .vehicle(3050, &format!("BFACK,{{t}},RTK,{},7,1,0,no", stamp(3000)));
    modified(insert, 3500).finds_nothing();
}
