//! The runtime's process: killed, stopped, held, on a full disk.

use std::time::Duration;

use backseat_core::Operator;
use backseat_oracle::State;

use crate::flight::{
    Flight, NO_VIOLATION, PILOT, SECOND, at, crew, identifiers, is_modified, patient_understudy, seconds, understudy,
};

#[test]
fn sr_007_a_runtime_killed_in_a_lease_leaves_a_modify_that_lapses_within_five_seconds() {
    for seed in 1..=5 {
        let mut flight = Flight::in_legs(seed);
        let killed = 60.0 + 0.21 * seed as f64;
        flight.until(killed);
        assert!(is_modified(&flight.sim) && flight.sim.is_steering());
        assert_eq!(flight.sim.state(), State::Lease);
        flight.sim.kill(seconds(20), crew(), 0);
        assert!(!flight.sim.is_steering());
        assert_eq!(flight.sim.state(), State::Down);
        assert_eq!((flight.sim.open_requests(), flight.sim.restarts()), (0, 0));
        let lapsed = flight.until_it(|sim| !is_modified(sim));
        assert!(lapsed <= at(killed + 5.1), "{lapsed}");
        flight.until(killed + 19.9);
        assert_eq!(flight.sim.statistics().connections, 1);
        flight.until_it(|sim| sim.is_steering());
        assert_eq!((flight.sim.restarts(), flight.sim.statistics().connections), (1, 2));
        let (report, _) = flight.land();
        assert_eq!(report.violations, NO_VIOLATION);
        assert_eq!(report.outcome, "completed");
    }
}

#[test]
fn sr_009_a_new_process_uses_no_identifier_of_the_old_ones() {
    let mut flight = Flight::in_legs(1);
    let mut sent = Vec::new();
    for process in 0..4 {
        let begin = 40.0 * f64::from(process);
        flight.until(begin + 25.0);
        flight.sim.substitute(SECOND, Some(patient_understudy("cross_fence")));
        flight.until(begin + 31.5).sim.substitute(SECOND, None);
        flight.until(begin + 38.0);
        sent.push(flight.sim.statistics().inserts_sent);
        if process < 3 {
            // The clock is wrong each time, an hour behind or ahead.
            let wrong = if process % 2 == 0 { -1 } else { 1 } * 3_600_000_000_000;
            flight.sim.kill(seconds(2), crew(), wrong);
        }
    }
    assert!(
        sent.is_sorted_by(|before, after| before < after),
        "each process has sent some: {sent:?}"
    );
    let (report, trace) = flight.end();
    let identifiers = identifiers(&trace);
    assert_eq!(identifiers.len() as u64, sent[3]);
    let mut once = identifiers.clone();
    once.sort_unstable();
    once.dedup();
    assert_eq!(once, identifiers, "each identifier occurs once, in rising order");
    assert_eq!(report.violations, NO_VIOLATION);
}

#[test]
fn sr_010_a_new_process_interrupts_nothing_while_an_insert_of_an_old_one_may_be_flown() {
    let mut flight = Flight::new(1);
    flight.until(20.0);
    flight.sim.substitute(SECOND, Some(understudy("cross_fence")));
    flight.until(40.0).sim.kill(seconds(2), crew(), 0);
    flight.until(42.0);
    flight.sim.substitute(SECOND, Some(understudy("cross_fence")));
    flight.until(100.0);
    let (_, trace) = flight.end();
    assert_eq!(identifiers(&trace), [1]);
}

#[test]
fn a_run_with_a_kill_is_reproducible() {
    let fly = |step_ns| {
        let mut flight = Flight::new(3);
        flight.until(50.0).sim.kill(seconds(5), crew(), step_ns);
        flight.land().0.digest
    };
    assert_eq!(fly(0), fly(0));
    assert_ne!(fly(0), fly(1_000_000_000));
}

#[test]
fn a_process_killed_again_before_its_restart_stays_away() {
    let mut flight = Flight::new(1);
    flight.until(50.0).sim.kill(seconds(10), crew(), 0);
    flight.until(55.0).sim.kill(seconds(30), crew(), 0);
    flight.until(84.9);
    assert_eq!((flight.sim.restarts(), flight.sim.statistics().connections), (0, 1));
    flight.until(90.0);
    assert_eq!((flight.sim.restarts(), flight.sim.statistics().connections), (1, 2));
}

#[test]
fn sr_003_a_stopped_runtime_ends_its_lease_first_when_it_goes_on() {
    let mut flight = Flight::new(1);
    flight.until(60.3);
    let before = flight.sim.statistics();
    flight.sim.stop_for(seconds(3));
    flight.until(63.299);
    let stopped = flight.sim.statistics();
    assert_eq!(stopped.sentences_to_vehicle, before.sentences_to_vehicle);
    assert!(
        stopped.navigations > before.navigations + 25,
        "the vehicle goes on sending"
    );
    flight.until(63.3);
    let after = flight.sim.statistics();
    assert_eq!(
        (after.end_modifies, after.modifies),
        (before.end_modifies + 1, before.modifies)
    );
    // The connection has survived the stop.
    flight.until_it(|sim| sim.is_steering());
    let (report, _) = flight.land();
    assert_eq!(report.seen.connections, 1);
    assert_eq!(report.violations, NO_VIOLATION);
}

#[test]
fn sr_007_during_a_long_stop_the_modify_lapses() {
    let mut flight = Flight::new(1);
    flight.until(60.0).sim.stop_for(seconds(30));
    let lapsed = flight.until_it(|sim| !is_modified(sim));
    assert!(lapsed <= at(65.1), "{lapsed}");
    // The longer of two stops counts.
    flight.sim.stop_for(seconds(1));
    flight.until(89.9);
    assert!(!is_modified(&flight.sim));
    flight.until_it(|sim| sim.is_steering());
    assert_eq!(flight.land().0.violations, NO_VIOLATION);
}

#[test]
fn a_short_stop_keeps_the_lease() {
    let mut flight = Flight::new(1);
    flight.until(60.0);
    let before = flight.sim.statistics().end_modifies;
    flight.sim.stop_for(Duration::from_millis(300));
    flight.until(65.0);
    assert!(flight.sim.is_steering());
    assert_eq!(flight.sim.statistics().end_modifies, before);
}

#[test]
fn a_connection_that_ends_during_a_stop_is_noticed_afterwards() {
    let cut = backseat_mvc::FaultPlan::from_toml("[[fault]]\nkind = \"link_cut\"\nat_s = 61\nfor_s = 0.5\n").unwrap();
    let mut flight = Flight::new(1);
    flight.sim.set_faults(cut);
    flight.until(60.0).sim.stop_for(seconds(3));
    flight.until(62.9);
    let before = flight.sim.statistics();
    assert_eq!(before.connections, 1);
    flight.until(63.0);
    // Nothing leaves on a connection that is gone.
    assert_eq!(
        flight.sim.statistics().sentences_to_vehicle,
        before.sentences_to_vehicle
    );
    flight.until_it(|sim| sim.is_steering());
    assert_eq!(flight.sim.statistics().connections, 2);
    assert_eq!(flight.land().0.violations, NO_VIOLATION);
}

#[test]
fn a_stopped_runtime_can_be_killed() {
    let mut flight = Flight::in_legs(1);
    flight.until(60.0).sim.stop_for(seconds(1000));
    flight.until(61.0).sim.kill(seconds(1), crew(), 0);
    flight.until_it(|sim| sim.is_steering());
    assert_eq!(flight.sim.restarts(), 1);
}

#[test]
fn sr_015_a_hold_survives_the_process_and_reaches_a_stopped_one() {
    let mut flight = Flight::in_legs(1);
    flight.until(60.0).sim.operate(Operator::Hold);
    assert!(!flight.sim.is_steering());
    flight.sim.kill(seconds(3), crew(), 0);
    flight.until(90.0);
    assert!(!flight.sim.is_steering());
    flight.sim.operate(Operator::Release);
    flight.until_it(|sim| sim.is_steering());

    // While no process runs, a hold is kept in its file, and the next process reads it.
    let now = flight.sim.now().as_secs_f64();
    flight.sim.kill(seconds(3), crew(), 0);
    flight.sim.operate(Operator::Hold);
    flight.until(now + 20.0);
    assert!(!flight.sim.is_steering());
    flight.sim.operate(Operator::Release);
    flight.until_it(|sim| sim.is_steering());

    let now = flight.sim.now().as_secs_f64();
    flight.sim.stop_for(Duration::from_millis(400));
    flight.sim.operate(Operator::Hold);
    assert!(flight.sim.is_steering());
    flight.until(now + 0.401);
    assert!(!flight.sim.is_steering());
    assert_eq!(flight.land().0.violations, NO_VIOLATION);
}

#[test]
fn a_signal_lost_with_a_killed_process_is_no_violation_of_the_next_one() {
    let mut flight = Flight::in_legs(1);
    flight.until(60.0).sim.stop_for(seconds(1000));
    flight.sim.operate(Operator::Hold);
    flight.until(61.0).sim.kill(seconds(1), crew(), 0);
    flight.until_it(|sim| sim.is_steering());
    assert_eq!(flight.land().0.violations, NO_VIOLATION);
}

#[test]
fn sr_009_on_a_full_disk_no_insert_is_sent_until_there_is_room_and_the_lease_goes_on() {
    let mut flight = Flight::in_legs(1);
    flight.sim.reserve_fails(true);
    // The first process has reserved its first block at once; the next one finds the disk full.
    flight.until(20.0).sim.kill(seconds(1), crew(), 0);
    flight.until(30.0);
    flight.sim.substitute(SECOND, Some(patient_understudy("cross_fence")));
    flight.until(100.0);
    assert!(flight.sim.is_steering());
    assert_eq!(flight.sim.statistics().inserts_sent, 0);
    flight.sim.reserve_fails(false);
    flight.until(110.0);
    assert!(flight.sim.is_steering());
    assert!(flight.sim.statistics().inserts_sent > 0);
    assert_eq!(flight.end().0.violations, NO_VIOLATION);
}

#[test]
fn substitutes_end_with_the_process() {
    let mut flight = Flight::in_legs(1);
    flight.until(60.0).sim.substitute(PILOT, Some(understudy("error")));
    flight.until(70.0);
    assert!(!flight.sim.is_steering());
    flight.sim.kill(seconds(1), crew(), 0);
    flight.until_it(|sim| sim.is_steering());
}
