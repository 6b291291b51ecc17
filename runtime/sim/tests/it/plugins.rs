//! Plugins: loaded once, started often, substituted while they fly.

use crate::flight::{Flight, PILOT, SECOND, crew, understudy};

#[test]
fn components_are_compiled_once_and_every_run_begins_afresh() {
    let fly = |seed, until| {
        let mut flight = Flight::new(seed);
        flight.until(until);
        flight.end().0
    };
    let first = fly(7, 100.0);
    fly(8, 30.0);
    let again = fly(7, 100.0);
    assert_eq!(first.digest, again.digest);
    assert!(first.requests.accepted > 0);
    assert_eq!(crew().setups.len(), 2);
    assert_eq!(crew().components[0].0, "pilot");
}

#[test]
fn sr_006_a_substitute_that_traps_is_a_failure_of_its_slot_only() {
    let mut flight = Flight::new(1);
    flight.until(60.0);
    flight.sim.substitute(SECOND, Some(understudy("trap")));
    let leases = flight.sim.statistics().leases;
    flight.until(90.0);
    flight.sim.substitute(SECOND, None);
    flight.until(150.0);
    // The pilot's lease has gone on all the time.
    assert_eq!(flight.sim.statistics().leases, leases);
    assert!(flight.sim.is_steering());
    let (report, _) = flight.land();
    assert!(report.plugin_failures["second"] > 0, "{:?}", report.plugin_failures);
    assert!(!report.plugin_failures.contains_key("pilot"));
}

#[test]
fn the_original_plugin_takes_over_again() {
    let mut flight = Flight::new(1);
    flight.until(60.0);
    assert!(flight.sim.is_steering());
    flight.sim.substitute(PILOT, Some(understudy("nan")));
    // A lease goes on for five seconds without another request.
    flight.until(66.5);
    assert!(!flight.sim.is_steering());
    flight.sim.substitute(PILOT, None);
    flight.until_it(|sim| sim.is_steering());
    let (report, _) = flight.end();
    assert!(report.requests.rejected > 0);
    assert!(report.plugin_failures.is_empty(), "{:?}", report.plugin_failures);
}
