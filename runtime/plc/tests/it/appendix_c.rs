//! Every command, generic command, status and alarm of appendix C can be met.

use std::collections::BTreeSet;

use backseat_plc::PlcEventKind;
use backseat_s7k::SensorIndex;
use backseat_s7k::plc::{CalendarTime, Command, Generic, TextKind, texts};
use backseat_s7k::record::{Action, CommandStatus};

use crate::rig::{A, Got, HIGH, LOW, Rig, START, SUB_BOTTOM, enclosed, navigation_record};

/// The numbers of one kind of text in the specification's tables.
fn all(kind: TextKind) -> BTreeSet<i32> {
    texts()
        .filter(|entry| entry.kind == kind)
        .map(|entry| entry.id)
        .collect()
}

/// Everything that can go wrong with a sensor, one after the other.
const FAULTS: &str = r#"
health_period_s = 1
key_grace_s = 300
disk = { capacity_mb = 100, used_mb = 0 }
fault = [
    { at_s = 0, for_s = 8, kind = "start_fails", sensor = "sub_bottom" },
    { at_s = 20, for_s = 10, kind = "sensor_dies", sensor = "sidescan_low" },
    { at_s = 40, for_s = 5, kind = "pings_dropped", sensor = "sidescan_high", chance = 0.5 },
    { at_s = 50, for_s = 10, kind = "data_missing", sensor = "sidescan_high" },
    { at_s = 70, for_s = 5, kind = "sensor_unhealthy", sensor = "sidescan_high" },
    { at_s = 80, for_s = 5, kind = "disk_full" },
    { at_s = 90, for_s = 5, kind = "key_missing" },
    { at_s = 90, for_s = 20, kind = "shutdown_fails", sensor = "sidescan_low" },
]
"#;

#[test]
fn every_status_and_alarm_reaches_a_client() {
    let mut rig = Rig::ready(FAULTS);
    let mut got = Vec::new();
    rig.tell(A, Command::ReportAlarms {});
    rig.run(5.0);
    rig.tell(A, Command::Reset { sensor: SUB_BOTTOM });
    rig.generic(A, HIGH, &Generic::Ping { on: true });
    rig.run(11.0);
    // 21 s: the low frequency is dead.
    rig.tell(
        A,
        Command::TimeSync {
            time: CalendarTime::from_utc(START),
        },
    );
    rig.tell(A, Command::Reset { sensor: LOW });
    rig.tell(A, Command::Status { sensor: LOW });
    rig.generic(A, LOW, &Generic::Ping { on: true });
    rig.run(74.0);
    got.extend(rig.take(A));
    // 95 s.
    rig.tell(A, Command::RouteMessages { sensor: HIGH });
    rig.push(A, &enclosed(&navigation_record()));
    rig.tell(A, Command::Remove { sensor: LOW });
    rig.generic(A, HIGH, &Generic::PulseFiles {});
    rig.tell(A, Command::Version {});
    rig.tell(A, Command::Modules {});
    rig.tell(A, Command::RunList {});
    rig.tell(A, Command::ReportLogging {});
    rig.text(A, SensorIndex::PLC, 26, Action::Get, "");
    rig.tell(A, Command::Health {});
    rig.text(A, SensorIndex::PLC, 99, Action::Set, "");
    rig.run(10.0);
    rig.tell(A, Command::Shutdown { kind: 1 });
    rig.run(10.0);
    got.extend(rig.take(A));
    let status = |got: &Got| {
        if let Got::Status(status) = got {
            Some(status.id())
        } else {
            None
        }
    };
    let alarm = |got: &Got| {
        if let Got::Alarm(_, alarm) = got {
            Some(alarm.id())
        } else {
            None
        }
    };
    assert_eq!(
        got.iter().filter_map(status).collect::<BTreeSet<_>>(),
        all(TextKind::Status)
    );
    assert_eq!(
        got.iter().filter_map(alarm).collect::<BTreeSet<_>>(),
        all(TextKind::Alarm)
    );
}

#[test]
fn every_command_is_done_but_those_that_are_reserved() {
    let mut rig = Rig::ready("");
    let mut done = BTreeSet::new();
    rig.events.clear();
    rig.tell(A, Command::Save {});
    // The examples of the catalogue are commands as they lie in a record; some need another sensor or module here.
    for entry in texts().filter(|entry| entry.kind == TextKind::Command) {
        let (sensor, text) = match entry.id {
            0 => (SUB_BOTTOM, entry.example),
            13 => continue,
            16 => (SensorIndex::PLC, "2, 21, 5, HF sidescan"),
            17 => (SensorIndex::PLC, "0"),
            24 => (SensorIndex::PLC, "1"),
            _ => (SensorIndex::PLC, entry.example),
        };
        if entry.id == 16 {
            rig.tell(A, Command::Remove { sensor: HIGH });
        }
        rig.text(A, sensor, entry.id.cast_unsigned(), Action::Set, text);
    }
    rig.run(10.0);
    rig.tell(A, Command::Shutdown { kind: 0 });
    for event in &rig.events {
        if let PlcEventKind::Command {
            command,
            status: CommandStatus::Accepted,
            ..
        } = event.kind
        {
            done.insert(command.code().cast_signed());
        }
    }
    let mut expected = all(TextKind::Command);
    expected.retain(|id| *id != 19 && *id != 27);
    assert_eq!(done, expected);
}

#[test]
fn every_generic_command_is_done() {
    let mut rig = Rig::ready("");
    for entry in texts().filter(|entry| entry.kind == TextKind::Generic) {
        rig.text(A, SUB_BOTTOM, 0, Action::Set, entry.example);
        let got = rig.take(A);
        assert!(
            matches!(got[0], Got::Acknowledge(_, SUB_BOTTOM, CommandStatus::Accepted)),
            "{}: {got:?}",
            entry.name
        );
    }
}
