use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use backseat_core::plugin::FaultKind;
use backseat_plugin_host::{Budget, HostError, LOG_FUEL};

use crate::fixture::{Latitude, components, fault_kind, faulty, input, only_modify};

#[test]
fn memory_is_also_bounded_at_the_start() {
    let budget = Budget {
        memory_bytes: 64 << 10,
        ..Budget::default()
    };
    let refused = components().faulty.start(budget, "{}", Arc::new(Latitude)).err();
    assert!(
        matches!(&refused, Some(HostError::Start { fault, .. }) if fault.kind == FaultKind::Memory),
        "{:?}",
        refused.map(|error| error.to_string())
    );
}

#[test]
fn more_memory_takes_more_fuel_before_it_is_refused() {
    // The plugin takes one mebibyte at a time, 16 pages of 255 units each. It runs out of fuel if it does not run out
    // of memory.
    let fault = |memory_bytes| {
        let mut plugin = faulty(
            "grow",
            0,
            Budget {
                memory_bytes,
                fuel_per_step: 100_000,
                ..Budget::default()
            },
        );
        fault_kind(&plugin.step(&input(0)))
    };
    assert_eq!(fault(4 << 20), Some(FaultKind::Memory));
    assert_eq!(fault(64 << 20), Some(FaultKind::OutOfFuel));
}

#[test]
fn log_lines_are_bounded_and_the_rest_are_counted() {
    let returned = faulty("log_flood", 0, Budget::default()).step(&input(0));
    only_modify(&returned);
    assert_eq!(returned.log.len(), 33);
    assert_eq!(returned.log[31].text, "line 31");
    assert_eq!(returned.log[32].text, "968 more lines were dropped");
    assert!(
        returned.fuel > 1_000 * LOG_FUEL,
        "each line is charged, kept or not: {}",
        returned.fuel
    );
    let poor = Budget {
        fuel_per_step: 100 * LOG_FUEL,
        ..Budget::default()
    };
    assert_eq!(
        fault_kind(&faulty("log_flood", 0, poor).step(&input(0))),
        Some(FaultKind::OutOfFuel)
    );
}

#[test]
fn init_has_a_budget_of_its_own() {
    let budget = Budget {
        fuel_init: 1_000,
        ..Budget::default()
    };
    let error = components()
        .faulty
        .start(budget, "{}", Arc::new(Latitude))
        .err()
        .unwrap();
    assert_eq!(error.to_string(), "faulty: cannot be started: used all its fuel");
}

#[test]
fn the_watchdog_ends_a_call_that_takes_too_long() {
    let mut plugin = faulty(
        "loop",
        0,
        Budget {
            fuel_per_step: u64::MAX / 4,
            ..Budget::default()
        },
    );
    plugin.set_deadline_ticks(Some(3));
    let host = components().host.clone();
    let over = AtomicBool::new(false);
    let returned = std::thread::scope(|scope| {
        scope.spawn(|| {
            while !over.load(Ordering::Relaxed) {
                host.increment_epoch();
                std::thread::yield_now();
            }
        });
        let returned = plugin.step(&input(0));
        over.store(true, Ordering::Relaxed);
        returned
    });
    assert_eq!(fault_kind(&returned), Some(FaultKind::Deadline), "{returned:?}");
}

#[test]
fn a_plugin_can_be_given_to_a_thread() {
    let mut plugin = faulty("none", 0, Budget::default());
    let returned = std::thread::spawn(move || plugin.step(&input(0))).join().unwrap();
    only_modify(&returned);
}
