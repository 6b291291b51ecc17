use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use backseat_core::plugin::{FaultKind, PluginFault, Returned};
use backseat_plugin_host::{Budget, HostError, LOG_FUEL, PUBLISH_FUEL};

use crate::fixture::{Latitude, brief, components, fault_kind, faulty, input, only_modify};

#[test]
fn memory_is_also_bounded_at_the_start() {
    let budget = Budget {
        memory_bytes: 64 << 10,
        ..Budget::default()
    };
    let refused = components()
        .faulty
        .start(budget, &brief("{}"), Arc::new(Latitude))
        .err();
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
        plugin.step(&input(0)).result.expect_err("a bound is broken")
    };
    let refused = fault(4 << 20);
    assert_eq!(refused.kind, FaultKind::Memory);
    assert!(
        refused
            .text
            .starts_with("was refused 1.06 MiB of memory, as it uses 3.25 MiB")
            && refused
                .text
                .contains(" MiB of its 4.00 MiB (plugin.budget.memory_mib in mission.toml): "),
        "{}",
        refused.text
    );
    let ended = fault(64 << 20);
    assert_eq!(
        (ended.kind, ended.text.as_str()),
        (
            FaultKind::OutOfFuel,
            "used all its fuel: 100000 units in one call: too much for one step, or a loop without end (plugin.budget.fuel_per_step in mission.toml)"
        )
    );
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
        .start(budget, &brief("{}"), Arc::new(Latitude))
        .err()
        .unwrap();
    assert_eq!(
        error.to_string(),
        "faulty: cannot be started: used all its fuel: 1000 units in one start: too much work in it, or a loop without end (the same for each plugin: no key of mission.toml sets it)"
    );
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

/// What a wall clock has ended can be repeated without one: the same returns, and the same state after them.
#[test]
fn what_the_watchdog_ended_is_repeated_without_a_clock() {
    let budget = Budget {
        fuel_per_step: u64::MAX / 4,
        snapshot_every_steps: 2,
        ..Budget::default()
    };
    let (mut deployed, mut replayed) = (faulty("loop", 3, budget.clone()), faulty("loop", 3, budget));
    deployed.set_deadline_ticks(Some(3));
    let host = components().host.clone();
    let over = AtomicBool::new(false);
    let mut deadlines = 0;
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !over.load(Ordering::Relaxed) {
                host.increment_epoch();
                std::thread::yield_now();
            }
        });
        for second in 0..8 {
            let recorded = deployed.step(&input(second));
            deadlines += u32::from(fault_kind(&recorded) == Some(FaultKind::Deadline));
            assert_eq!(
                replayed.step_again(&input(second), &recorded),
                recorded,
                "step {second}"
            );
            assert_eq!(replayed.is_running(), deployed.is_running());
            if !deployed.is_running() {
                let restarted = deployed.restart();
                let again = replayed.restart_again(&restarted.result);
                assert_eq!(
                    (again.fuel, again.lost_steps, again.result),
                    (restarted.fuel, restarted.lost_steps, restarted.result)
                );
            }
        }
        over.store(true, Ordering::Relaxed);
    });
    assert!(deadlines > 0);
    // A restart and a snapshot that were ended.
    let fault = |kind, text: &str| PluginFault {
        kind,
        text: text.to_owned(),
    };
    let restarted = replayed.restart_again(&Err(fault(FaultKind::Start, "ran past its deadline")));
    assert_eq!(restarted.fuel, Budget::default().fuel_init);
    assert!(restarted.result.is_err() && !replayed.is_running());
    let mut plugin = faulty(
        "none",
        0,
        Budget {
            snapshot_every_steps: 1,
            ..Budget::default()
        },
    );
    let recorded = Returned {
        fuel: 0,
        log: Vec::new(),
        measures: Vec::new(),
        result: Err(fault(FaultKind::Deadline, "snapshot: ran past its deadline")),
    };
    let again = plugin.step_again(&input(0), &recorded);
    assert_eq!(again.result, recorded.result);
    assert!(again.fuel > Budget::default().fuel_snapshot && !plugin.is_running());
}

#[test]
fn a_plugin_can_be_given_to_a_thread() {
    let mut plugin = faulty("none", 0, Budget::default());
    let returned = std::thread::spawn(move || plugin.step(&input(0))).join().unwrap();
    only_modify(&returned);
}

#[test]
fn published_values_are_bounded_and_the_rest_are_counted_with_the_reason() {
    let mut plugin = faulty("publish_flood", 0, Budget::default());
    let returned = plugin.step(&input(0));
    only_modify(&returned);
    assert_eq!(returned.measures.len(), 128);
    let last = returned.measures.last().unwrap();
    assert_eq!(
        (last.name.as_str(), last.value, last.unit.as_str()),
        ("index", 127.0, "")
    );
    let lines: Vec<&str> = returned.log.iter().map(|line| line.text.as_str()).collect();
    let name = "Name".repeat(12);
    assert_eq!(
        lines,
        [format!(
            "874 values were not published, the last of them \"{name}\": a name is 1 to 48 of a-z, 0-9 and _, and begins with a letter"
        )]
    );
    assert!(
        returned.fuel > 1_000 * PUBLISH_FUEL + (1 << 14),
        "each value is charged, kept or not: {}",
        returned.fuel
    );
    // In the next second there is room for 64 again.
    assert_eq!(plugin.step(&input(1)).measures.len(), 64);
}
