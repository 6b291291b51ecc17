use std::sync::Arc;
use std::time::Duration;

use backseat_core::plugin::{Description, FaultKind};
use backseat_plugin_host::{Budget, HostError};

use crate::fixture::{Latitude, brief, components, fault_kind, faulty, input, only_modify, template};

#[test]
fn a_plugin_describes_itself() {
    let config = r#"{"heading_deg": 90.0, "depth_m": 10.0, "speed_mps": 1.5}"#;
    let started = components()
        .template
        .start(Budget::default(), &brief(config), Arc::new(Latitude))
        .unwrap();
    let expected = Description {
        name: "template".into(),
        version: "0.1.0".into(),
        step_period: Duration::from_secs(1),
        topics: vec![],
    };
    assert_eq!(started.description, expected);
    assert!(started.fuel > 0);
}

#[test]
fn a_wrong_configuration_is_refused_with_its_key() {
    let start = |config| {
        components()
            .template
            .start(Budget::default(), &brief(config), Arc::new(Latitude))
            .err()
            .unwrap()
    };
    assert_eq!(
        start(r#"{"heading_deg": 90.0, "depth_m": 1.0, "sped_mps": 1.5}"#).to_string(),
        "template: cannot be started: config: sped_mps: unknown field `sped_mps`, expected one of `heading_deg`, `depth_m`, \
         `speed_mps`"
    );
    let senseless = start(r#"{"heading_deg": 400.0, "depth_m": 1.0, "speed_mps": 1.5}"#);
    assert!(
        matches!(&senseless, HostError::Start { fault, .. } if fault.kind == FaultKind::Start),
        "{senseless}"
    );
}

#[test]
fn a_restart_goes_on_from_the_last_snapshot() {
    let mut plugin = faulty(
        "trap",
        8,
        Budget {
            snapshot_every_steps: 3,
            ..Budget::default()
        },
    );
    let tags: Vec<u64> = (0..8)
        .map(|second| only_modify(&plugin.step(&input(second))).tag)
        .collect();
    assert_eq!(tags, [1, 2, 3, 4, 5, 6, 7, 8]);
    assert_eq!(fault_kind(&plugin.step(&input(8))), Some(FaultKind::Trap));
    let restarted = plugin.restart();
    assert_eq!(restarted.result, Ok(()));
    assert!(restarted.fuel > 0);
    // The snapshot was taken after the sixth input, so the seventh, the eighth and the fatal one are lost.
    assert_eq!(restarted.lost_steps, 3);
    // The restored state contains the time of the first step, so the plugin traps again 8 s after that time.
    assert_eq!(only_modify(&plugin.step(&input(7))).tag, 7);
    assert_eq!(fault_kind(&plugin.step(&input(9))), Some(FaultKind::Trap));
    // The first loss is still counted, because no snapshot was taken since.
    assert_eq!(plugin.restart().lost_steps, 5);
}

#[test]
fn a_restart_without_a_snapshot_begins_from_the_start() {
    let mut plugin = faulty(
        "trap",
        2,
        Budget {
            snapshot_every_steps: 0,
            ..Budget::default()
        },
    );
    for second in 0..3 {
        plugin.step(&input(second));
    }
    assert_eq!(plugin.restart().lost_steps, 3);
    assert_eq!(only_modify(&plugin.step(&input(3))).tag, 1);
}

#[test]
fn a_snapshot_too_large_is_a_fault_and_the_old_one_is_kept() {
    let mut plugin = faulty(
        "big_snapshot",
        2,
        Budget {
            snapshot_every_steps: 2,
            ..Budget::default()
        },
    );
    for second in 0..3 {
        only_modify(&plugin.step(&input(second)));
    }
    let returned = plugin.step(&input(3));
    assert_eq!(fault_kind(&returned), Some(FaultKind::TooMuch), "{returned:?}");
    assert!(returned.result.unwrap_err().text.starts_with("snapshot: "));
    let restarted = plugin.restart();
    assert_eq!((restarted.result, restarted.lost_steps), (Ok(()), 2));
    assert_eq!(only_modify(&plugin.step(&input(1))).tag, 3);
}

#[test]
fn a_snapshot_has_fuel_of_its_own_and_its_fuel_is_returned() {
    let mut poor = faulty(
        "none",
        0,
        Budget {
            fuel_snapshot: 10,
            snapshot_every_steps: 1,
            ..Budget::default()
        },
    );
    assert_eq!(fault_kind(&poor.step(&input(0))), Some(FaultKind::OutOfFuel));
    let fuel = |snapshot_every_steps| {
        let mut plugin = faulty(
            "none",
            0,
            Budget {
                snapshot_every_steps,
                ..Budget::default()
            },
        );
        plugin.step(&input(0)).fuel
    };
    assert!(fuel(1) > fuel(0));
}

#[test]
fn a_running_plugin_can_be_restarted() {
    let mut plugin = template();
    assert_eq!(only_modify(&plugin.step(&input(0))).tag, 1);
    assert_eq!(plugin.restart().result, Ok(()));
    assert_eq!(only_modify(&plugin.step(&input(1))).tag, 1);
}
