//! Faults that begin at run time.

#![expect(clippy::unwrap_used, reason = "a flight that cannot be made fails its test")]

use std::time::Duration;

use backseat_mvc::{Fault, FaultPlan};

use crate::flight::{Flight, NO_VIOLATION, SECOND, at, understudy};

/// A fault of each kind, by its keys in a plan. Each begins at an instant at which nothing else is due.
const FAULTS: [&str; 20] = [
    "kind = \"link_cut\"; for_s = 3",
    "kind = \"refuse\"; for_s = 3",
    "kind = \"stall\"; for_s = 1.5",
    "kind = \"stall\"; for_s = 3; direction = \"from_vehicle\"",
    "kind = \"half_open\"; for_s = 5; direction = \"to_vehicle\"",
    "kind = \"delay\"; for_s = 9; delay_s = 0.4; jitter_s = 0.3",
    "kind = \"split\"; for_s = 9; bytes = 7; gap_s = 0.001",
    "kind = \"join\"; for_s = 9; hold_s = 0.3",
    "kind = \"duplicate\"; for_s = 9; chance = 0.5",
    "kind = \"corrupt\"; for_s = 9; chance = 0.01",
    "kind = \"drop\"; for_s = 9; chance = 0.5",
    "kind = \"acks_lost\"; for_s = 3",
    "kind = \"acks_late\"; for_s = 9; delay_s = 0.5",
    "kind = \"acks_negative\"; for_s = 3; command = \"RMB\"; status = 1",
    "kind = \"control_taken\"; for_s = 3",
    "kind = \"navigation_frozen\"; for_s = 3",
    "kind = \"navigation_jump\"; for_s = 3; east_m = 40; north_m = -20",
    "kind = \"navigation_missing\"; for_s = 3",
    "kind = \"mission_abort\"",
    "kind = \"clock_step\"; for_s = 3; by_s = -7.5",
];

const BEGINS_S: f64 = 60.012_345;

fn plan(faults: &[&str]) -> FaultPlan {
    let tables: Vec<String> = faults
        .iter()
        .map(|fault| format!("[[fault]]\nat_s = {BEGINS_S}\n{}\n", fault.replace("; ", "\n")))
        .collect();
    FaultPlan::from_toml(&tables.concat()).unwrap()
}

fn fault(text: &str) -> Fault {
    plan(&[text]).faults.remove(0)
}

fn planned(faults: &[&str]) -> Flight {
    let mut flight = Flight::new(1);
    flight.sim.set_faults(plan(faults));
    flight
        .until(10.0)
        .sim
        .substitute(SECOND, Some(understudy("cross_fence")));
    flight
}

fn injected(faults: &[&str]) -> Flight {
    let mut flight = Flight::new(1);
    flight
        .until(10.0)
        .sim
        .substitute(SECOND, Some(understudy("cross_fence")));
    flight.until(BEGINS_S);
    for text in faults {
        // The fault's own time does not count.
        let fault = Fault {
            at: at(1.0),
            ..fault(text)
        };
        flight.sim.inject(fault);
    }
    flight
}

#[test]
fn an_injected_fault_acts_like_a_planned_one() {
    let fly = |mut flight: Flight| {
        flight.towards(80.0);
        flight.end().0
    };
    let undisturbed = fly(planned(&[])).digest;
    for fault in FAULTS {
        let (planned, injected) = (fly(planned(&[fault])), fly(injected(&[fault])));
        assert_eq!((planned.faults, injected.faults), (1, 1), "{fault}");
        assert_eq!(planned.digest, injected.digest, "{fault}");
        assert_eq!(planned.violations, injected.violations, "{fault}");
        if !fault.contains("\"refuse\"") {
            assert_ne!(injected.digest, undisturbed, "{fault} changed nothing");
        }
    }
}

#[test]
fn several_injected_faults_act_like_those_of_a_plan_in_that_order() {
    let faults = [FAULTS[5], FAULTS[7], FAULTS[9], FAULTS[10], FAULTS[11], FAULTS[16]];
    let (planned, injected) = (planned(&faults).land().0, injected(&faults).land().0);
    assert_eq!(planned.digest, injected.digest);
    assert_eq!(injected.faults, 6);
}

#[test]
fn a_cut_of_a_live_connection_refuses_the_next_ones_while_it_lasts() {
    let mut flight = Flight::new(1);
    flight.until(60.0);
    assert_eq!(flight.sim.statistics().connections, 1);
    flight.sim.inject(fault("kind = \"link_cut\"; for_s = 20"));
    flight.until(79.9);
    assert_eq!(flight.sim.statistics().connections, 1);
    assert!(!flight.sim.is_steering());
    flight.until_it(|sim| sim.is_steering());
    let (report, _) = flight.land();
    assert_eq!(report.seen.connections, 2);
    assert_eq!(report.violations, NO_VIOLATION);
}

/// At sea TCP's user time-out resets a connection whose data is not acknowledged for 2 s (RFC 5482).
#[test]
fn a_silent_loss_of_what_we_send_resets_the_connection_after_two_seconds() {
    let mut flight = Flight::new(1);
    flight.until(60.0);
    flight
        .sim
        .inject(fault("kind = \"half_open\"; for_s = 30; direction = \"to_vehicle\""));
    let lost_from = flight.sim.now();
    // The pilot refreshes each second, so the first lost refresh leaves within a second after the loss has begun.
    let reset = flight.until_it(|sim| !sim.is_steering());
    let after = reset.since(lost_from);
    assert!(
        (Duration::from_secs(1)..Duration::from_millis(3100)).contains(&after),
        "{after:?}"
    );
    // Each new connection is reset in the same way, until the loss is over.
    flight.until(90.0);
    assert!(flight.sim.statistics().connections > 3);
    flight.until_it(|sim| sim.is_steering());
    let (report, _) = flight.land();
    assert_eq!(report.violations, NO_VIOLATION);
}

#[test]
fn a_silent_loss_of_under_two_seconds_resets_nothing() {
    let mut flight = Flight::new(1);
    flight.until(60.0);
    flight
        .sim
        .inject(fault("kind = \"half_open\"; for_s = 1.5; direction = \"to_vehicle\""));
    flight.until(120.0);
    assert_eq!(flight.sim.statistics().connections, 1);
}

/// The vehicle repeats BFCTL and BFMIS to a client that subscribes. So a new connection brings control back although
/// its first messages are lost: the runtime subscribes again to what is not acknowledged.
#[test]
fn control_comes_back_with_a_new_subscription() {
    let mut flight = Flight::new(1);
    flight.until(60.0);
    flight.sim.inject(fault("kind = \"link_cut\""));
    flight.sim.inject(fault(
        "kind = \"drop\"; for_s = 8; chance = 1; direction = \"from_vehicle\"",
    ));
    flight.until(68.0);
    assert!(!flight.sim.is_steering());
    let back = flight.until_it(|sim| sim.is_steering());
    assert!(back <= at(85.0), "{back}");
}
