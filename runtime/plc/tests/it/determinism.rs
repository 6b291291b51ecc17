//! The same inputs give the same bytes.

use core::time::Duration;

use backseat_plc::{FaultEntry, FaultPlan, PlcConfig};
use backseat_s7k::plc::{Command, Generic};

use crate::rig::{A, B, HIGH, LOW, Rig, SUB_BOTTOM, enclosed, navigation_record};

/// Bytes on the links, files and events of a run with drawn faults and readings.
fn run(seed: u64) -> (Vec<u8>, Vec<Vec<u8>>, Vec<String>) {
    let plan = FaultPlan::draw(seed, Duration::from_secs(60), 1.0);
    let entries: Vec<FaultEntry> = plan.faults.iter().map(FaultEntry::of).collect();
    let faults: String = entries
        .iter()
        .map(|entry| format!("[[fault]]\n{}\n", toml::to_string(entry).expect("a fault")))
        .collect();
    let table = format!(
        "auto_start = true\ntime_messages = true\nhealth_period_s = 7\nclock_offset_s = [-5, 5]\nclock_drift_ppm = [-20, 20]\n\
         logging = {{ file_size_mb = 1, overlap_records = 2 }}\n\
         interpretation = {{ acknowledge = \"seed\", sensor_status = \"seed\", event_alarm_mode = \"seed\" }}\n{faults}"
    );
    let _: PlcConfig = toml::from_str(&table).expect("a table");
    let mut rig = Rig::with(&table, seed, &backseat_plc::Stored::default());
    rig.pose();
    for step in 0..60 {
        rig.connect(A);
        rig.connect(B);
        rig.tell(A, Command::Verbose { on: true });
        for sensor in [SUB_BOTTOM, LOW, HIGH] {
            rig.tell(
                A,
                Command::Subscribe {
                    sensor,
                    record_type: 3000,
                },
            );
            rig.generic(B, sensor, &Generic::PulseFiles {});
            rig.tell(B, Command::Status { sensor });
        }
        rig.push(A, &enclosed(&navigation_record()));
        rig.tell(
            B,
            if step % 10 == 3 {
                Command::Reset { sensor: LOW }
            } else {
                Command::Health {}
            },
        );
        rig.run(1.0);
        rig.pose();
    }
    let events = rig
        .events
        .iter()
        .map(|event| format!("{} {}", event.at, event.kind))
        .collect();
    (rig.bytes, rig.files.into_values().collect(), events)
}

#[test]
fn the_same_seed_and_inputs_give_the_same_bytes() {
    for seed in [1, 2] {
        let (first, again) = (run(seed), run(seed));
        assert!(first.0.len() > 1_000_000 && first.1.len() > 3 && first.2.len() > 500);
        assert!(first == again, "seed {seed}");
    }
}

#[test]
fn another_seed_gives_others() {
    assert!(run(1).0 != run(2).0);
}
