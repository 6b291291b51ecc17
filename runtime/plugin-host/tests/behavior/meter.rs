use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use backseat_core::Grant;
use backseat_core::plugin::FaultKind;
use backseat_plugin_host::{Budget, Meter, Stopwatch, Usage};

use crate::fixture::{components, fault_kind, faulty, input};

/// A stopwatch that is a second later at each look, so that each step takes a second.
fn seconds() -> Stopwatch {
    let looks = AtomicU64::new(0);
    Arc::new(move || Duration::from_secs(looks.fetch_add(1, Ordering::Relaxed)))
}

/// What the faulty plugin uses in some steps, with the fuel of each step without its snapshot.
fn measured(fault: &str, budget: Budget, steps: u64) -> (Usage, Vec<u64>) {
    let mut plugin = faulty(fault, 0, budget);
    let meter = Arc::new(Meter::new(seconds()));
    plugin.set_meter(Some(meter.clone()));
    let fuel = (0..steps).map(|second| plugin.step(&input(second)).fuel).collect();
    (meter.usage(), fuel)
}

#[test]
fn a_meter_has_the_greatest_of_fuel_memory_and_time() {
    let without_snapshots = Budget {
        snapshot_every_steps: 0,
        ..Budget::default()
    };
    let (usage, fuel) = measured("none", without_snapshots, 5);
    assert_eq!(usage.steps, 5);
    assert_eq!(Some(usage.step_fuel_max), fuel.into_iter().max());
    assert_eq!(usage.snapshot_fuel_max, 0);
    assert_eq!(usage.step_time_max, Duration::from_secs(1));
    assert_eq!(usage.step_time_total, Duration::from_secs(5));
    assert_eq!(usage.lines_dropped, 0);
    assert!((64 << 10..8 << 20).contains(&usage.memory_bytes_max), "{usage:?}");
    let (with, _) = measured("none", Budget::default(), 10);
    assert!(with.snapshot_fuel_max > 0, "{with:?}");
    let (flood, _) = measured("log_flood", Budget::default(), 1);
    assert_eq!(flood.lines_dropped, 968);
}

#[test]
fn a_step_that_fails_is_measured_too() {
    let budget = Budget {
        memory_bytes: 16 << 20,
        ..Budget::default()
    };
    let (grown, _) = measured("grow", budget.clone(), 1);
    assert!((15 << 20..=16 << 20).contains(&grown.memory_bytes_max), "{grown:?}");
    let (looped, _) = measured("loop", budget.clone(), 1);
    assert!(looped.step_fuel_max >= budget.fuel_per_step - 100, "{looped:?}");
    // A plugin that has failed runs nothing until it is restarted.
    let mut plugin = faulty("trap", 0, budget.clone());
    let meter = Arc::new(Meter::new(seconds()));
    plugin.set_meter(Some(meter.clone()));
    assert_eq!(fault_kind(&plugin.step(&input(0))), Some(FaultKind::Trap));
    assert_eq!(fault_kind(&plugin.step(&input(1))), Some(FaultKind::Start));
    let trapped = meter.usage();
    assert_eq!(trapped.steps, 1);
    assert!(
        (1..budget.fuel_per_step).contains(&trapped.step_fuel_max),
        "{trapped:?}"
    );
}

#[test]
fn a_plugin_is_described_without_its_configuration() {
    let (description, needs) = components().template.describe(&Budget::default()).unwrap();
    assert_eq!((description.name.as_str(), needs), ("template", vec![Grant::Modify]));
    let poor = Budget {
        fuel_init: 10,
        ..Budget::default()
    };
    let refused = components().template.describe(&poor).unwrap_err().to_string();
    assert_eq!(
        refused,
        "template: cannot be started: used all its fuel: 10 units in one start: too much work in it, or a loop without end (the same for each plugin: no key of mission.toml sets it)"
    );
}
