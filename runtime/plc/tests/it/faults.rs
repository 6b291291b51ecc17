//! Faults: what they do, which alarms they raise, and how it goes on after them.

use backseat_plc::{DropReason, Fault, FaultEntry, FaultKind, FaultPlan, Ping, PlcConfig, PlcEventKind, SensorKind};
use backseat_s7k::plc::{Alarm, CalendarTime, Command, FailureCause, Generic, Status};
use backseat_s7k::record::AlarmMode;
use backseat_units::Timestamp;
use core::time::Duration;
use std::collections::BTreeSet;

use crate::rig::{A, B, Got, HIGH, LOW, Rig, START, SUB_BOTTOM, enclosed, navigation_record};

/// A fault from 10 s on, for so long.
fn fault(for_s: u32, rest: &str) -> String {
    format!("[[fault]]\nat_s = 10\nfor_s = {for_s}\n{rest}\n")
}

/// A controller 10.05 s after its start, with pinging sonars and a client that gets all of them.
fn faulty(table: &str) -> Rig {
    let mut rig = Rig::ready(table);
    for sensor in [SUB_BOTTOM, LOW, HIGH] {
        for record_type in [3000, 3001] {
            rig.tell(A, Command::Subscribe { sensor, record_type });
        }
        rig.generic(A, sensor, &Generic::Ping { on: true });
    }
    rig.run(5.05);
    rig.take(A);
    rig
}

fn of_low(rig: &mut Rig) -> usize {
    let low = |got: &Got| matches!(got, Got::Data(_, device, _) if device.0 == 11_001);
    rig.take(A).iter().filter(|got| low(got)).count()
}

#[test]
fn a_dead_sensor_neither_pings_nor_answers_and_goes_on_later() {
    let mut rig = faulty(&fault(20, "kind = \"sensor_dies\"\nsensor = \"sidescan_low\""));
    rig.run(4.8);
    assert_eq!(of_low(&mut rig), 0);
    rig.run(0.3);
    let silent = Alarm::SensorNotResponding {
        sensor: LOW,
        description: Box::from("no answer"),
    };
    assert_eq!(rig.alarms(A), [(AlarmMode::Active, silent.clone())]);
    // Each thing that is asked of it fails, most of them after a time.
    rig.generic(A, LOW, &Generic::Range { range_m: 50.0 });
    rig.tell(A, Command::Status { sensor: LOW });
    rig.tell(A, Command::Reset { sensor: LOW });
    rig.tell(
        A,
        Command::TimeSync {
            time: CalendarTime::from_utc(START),
        },
    );
    let names = |rig: &mut Rig| rig.alarms(A).iter().map(|(_, alarm)| alarm.name()).collect::<Vec<_>>();
    assert_eq!(names(&mut rig), ["ResetFailed", "SensorTimeFailed"]);
    rig.run(5.0);
    assert_eq!(names(&mut rig), ["SensorCommandFailed", "SensorStatusFailed"]);
    rig.tell(A, Command::Health {});
    let got = rig.take(A);
    assert!(format!("{got:?}").contains("SensorUnhealthy"), "{got:?}");
    rig.run(14.0);
    let got = rig.take(A);
    assert!(got.contains(&Got::Alarm(AlarmMode::Clear, silent)), "{got:?}");
    let low = |got: &&Got| matches!(got, Got::Data(_, device, _) if device.0 == 11_001);
    assert!(got.iter().filter(low).count() > 20);
    // It never got the command.
    let low = |(kind, _): &&(SensorKind, Ping)| *kind == SensorKind::SidescanLow;
    assert_eq!(rig.sonar.pings.iter().rfind(low).expect("a ping").1.range_m, 100.0);
}

#[test]
fn an_unhealthy_sensor_reports_its_cause_and_fails_its_check() {
    let table = "health_period_s = 3.0\n".to_owned()
        + &fault(
            10,
            "kind = \"sensor_unhealthy\"\nsensor = \"sub_bottom\"\ncause = 3\ncode = 17",
        );
    let mut rig = faulty(&table);
    rig.run(20.0);
    let alarms = rig.alarms(A);
    let failure = Alarm::SensorFailure {
        sensor: SUB_BOTTOM,
        cause: FailureCause::Temperature,
        code: 17,
        description: Box::from("temperature out of range"),
    };
    let unhealthy = Alarm::SensorUnhealthy {
        sensor: SUB_BOTTOM,
        description: Box::from("health check failed"),
    };
    assert_eq!(
        alarms,
        [
            (AlarmMode::Active, unhealthy.clone()),
            (AlarmMode::Clear, failure),
            (AlarmMode::Clear, unhealthy),
            (AlarmMode::Clear, Alarm::AllClear {})
        ],
        "alarm 4 came at 10 s, before the client began to listen"
    );
}

#[test]
fn dropped_pings_are_told_by_their_numbers() {
    let mut rig = faulty(&fault(
        3,
        "kind = \"pings_dropped\"\nsensor = \"sidescan_low\"\nchance = 1.0",
    ));
    rig.run(5.0);
    let alarms = rig.alarms(A);
    let mut numbers = BTreeSet::new();
    for (mode, alarm) in &alarms {
        let (AlarmMode::Unspecified, Alarm::PingDropped { sensor, first, last }) = (mode, alarm) else {
            panic!("{alarms:?}")
        };
        assert_eq!(*sensor, LOW);
        numbers.extend(*first..=(*last).max(*first));
    }
    // Pings are numbered from 1 at 5 s, one every 150 ms: those that were heard to the end from 10 s to 13 s.
    let expected: BTreeSet<i32> = (34..=53).collect();
    assert_eq!(numbers, expected);
    assert!(alarms.len() <= 4, "{alarms:?}");
    // The numbers are missing among the records.
    let heard: BTreeSet<u32> = rig
        .sonar
        .pings
        .iter()
        .filter(|(kind, _)| *kind == SensorKind::SidescanLow)
        .map(|(_, ping)| ping.number)
        .collect();
    assert!(heard.contains(&33) && !heard.contains(&34) && !heard.contains(&53) && heard.contains(&54));
}

#[test]
fn a_single_dropped_ping_has_no_last_number() {
    let mut rig = faulty(&fault(
        60,
        "kind = \"pings_dropped\"\nsensor = \"sidescan_low\"\nchance = 0.05",
    ));
    rig.run(60.0);
    let single = |alarm: &(AlarmMode, Alarm)| matches!(alarm.1, Alarm::PingDropped { last: -1, .. });
    assert!(rig.alarms(A).iter().any(single));
}

#[test]
fn missing_data_raise_an_alarm_while_the_sensor_pings() {
    let mut rig = faulty(&fault(10, "kind = \"data_missing\"\nsensor = \"sidescan_low\""));
    rig.run(4.0);
    assert_eq!(of_low(&mut rig), 0);
    rig.run(2.0);
    let alarms = rig.alarms(A);
    assert!(
        matches!(
            &alarms[..],
            [(AlarmMode::Active, Alarm::SensorDataFailed { sensor: LOW, .. })]
        ),
        "{alarms:?}"
    );
    rig.run(5.0);
    let alarms = rig.alarms(A);
    assert!(
        matches!(alarms[0], (AlarmMode::Clear, Alarm::SensorDataFailed { .. })),
        "{alarms:?}"
    );
    let low = |(kind, _): &&(SensorKind, Ping)| *kind == SensorKind::SidescanLow;
    let last = rig.sonar.pings.iter().rfind(low).expect("a ping").1.number;
    assert_eq!(last, 107, "numbers went on: a ping each 150 ms from 5 s on");
}

#[test]
fn refused_commands_and_resets_raise_their_alarms() {
    let refusals = fault(60, "kind = \"commands_refused\"\nsensor = \"sidescan_low\"")
        + &fault(60, "kind = \"reset_refused\"\nsensor = \"sidescan_low\"");
    let mut rig = faulty(&refusals);
    rig.generic(A, LOW, &Generic::Range { range_m: 50.0 });
    rig.tell(A, Command::Reset { sensor: LOW });
    rig.generic(A, HIGH, &Generic::Range { range_m: 50.0 });
    let names: Vec<&str> = rig.alarms(A).iter().map(|(_, alarm)| alarm.name()).collect();
    assert_eq!(names, ["SensorCommandFailed", "ResetFailed"]);
}

#[test]
fn a_full_disk_ends_logging_and_is_over_with_its_fault() {
    let mut rig = Rig::ready(&fault(5, "kind = \"disk_full\""));
    rig.generic(A, LOW, &Generic::Ping { on: true });
    rig.tell(A, Command::Logging { on: true });
    rig.take(A);
    rig.run(6.0);
    let alarms = rig.alarms(A);
    assert!(
        matches!(alarms[..], [(AlarmMode::Active, Alarm::DiskSpaceCritical { .. })]),
        "{alarms:?}"
    );
    assert!(rig.has_event(&PlcEventKind::LogStopped(backseat_plc::LogStop::DiskFull)));
    rig.run(5.0);
    assert_eq!(rig.alarms(A).len(), 2);
    rig.tell(A, Command::Logging { on: true });
    rig.run(1.0);
    assert_eq!(rig.open_files().len(), 1);
}

#[test]
fn a_controller_that_stalls_reads_and_writes_nothing_and_then_goes_on() {
    let mut rig = faulty(&fault(10, "kind = \"stall\""));
    let pings = rig.sonar.pings.len();
    rig.tell(A, Command::Version {});
    rig.push(A, &enclosed(&navigation_record()));
    rig.run(9.9);
    assert_eq!((rig.take(A), rig.sonar.pings.len()), (vec![], pings));
    rig.run(1.0);
    let got = rig.take(A);
    assert!(
        matches!(&got[0], Got::Acknowledge(..)) && matches!(&got[1], Got::Status(Status::Version { .. })),
        "{got:?}"
    );
    // The pings of these ten seconds are dropped, and said to be.
    let dropped = |got: &Got| matches!(got, Got::Alarm(_, Alarm::PingDropped { .. }));
    assert_eq!(got.iter().filter(|got| dropped(got)).count(), 3, "{got:?}");
    assert!(got.iter().any(|got| matches!(got, Got::Data(..))));
}

#[test]
fn what_comes_during_a_stall_takes_bounded_memory() {
    let mut rig = faulty(&("receive_buffer_bytes = 10000\n".to_owned() + &fault(10, "kind = \"stall\"")));
    assert!(rig.plc.reads(A));
    for _ in 0..100 {
        rig.tell(A, Command::Version {});
    }
    assert!(!rig.plc.reads(A));
    rig.run(11.0);
    // 120 bytes each.
    let versions = rig.take(A).iter().filter(|got| matches!(got, Got::Status(_))).count();
    assert_eq!(versions, 83);
    let lost = |event: &backseat_plc::PlcEvent| matches!(&event.kind, PlcEventKind::Ignored { what, .. } if what.bytes >= 2000);
    assert!(rig.events.iter().any(lost), "{:?}", rig.events.last());
}

#[test]
fn a_flood_reaches_every_client() {
    let mut rig = faulty(&fault(2, "kind = \"flood\"\nrecords_per_s = 500"));
    rig.connect(B);
    rig.run(5.0);
    let floods = rig
        .take(B)
        .iter()
        .filter(|got| matches!(got, Got::Status(Status::Version { .. })))
        .count();
    assert!((950..=1000).contains(&floods), "{floods}");
}

#[test]
fn garbage_lies_between_the_records() {
    let mut rig = faulty(&fault(5, "kind = \"garbage\"\nbytes_per_s = 5000"));
    rig.run(10.0);
    assert!((20_000..=25_500).contains(&rig.skipped_bytes), "{}", rig.skipped_bytes);
    // Nearly all of the records are still found.
    assert!(of_low(&mut rig) > 40);
}

#[test]
fn wrong_checksums_are_on_the_link_and_not_in_the_log() {
    let mut rig = faulty(&fault(5, "kind = \"checksums_wrong\"\nchance = 0.5"));
    rig.tell(A, Command::Logging { on: true });
    rig.run(5.0);
    rig.tell(A, Command::Logging { on: false });
    assert!(rig.wrong_checksums > 20, "{}", rig.wrong_checksums);
    let file = rig.files.values().next().expect("a file");
    let mut reader = backseat_s7k::file::FileReader::new(&file[..]);
    let mut records = 0;
    while let Some(item) = reader.next().expect("memory") {
        let backseat_s7k::file::FileItem::Record { frame, .. } = item else {
            panic!()
        };
        assert_eq!(frame.checksum(), backseat_s7k::Checksum::Valid);
        records += 1;
    }
    assert!(records > 50);
}

#[test]
fn closed_links_stay_closed_as_long_as_the_fault_lasts() {
    let mut rig = faulty(&fault(3, "kind = \"link_closed\""));
    assert_eq!(rig.closed, [A]);
    rig.connect(B);
    assert_eq!(rig.closed, [A, B]);
    assert!(rig.has_event(&PlcEventKind::Dropped(B, DropReason::Fault)));
    rig.run(3.0);
    rig.connect(B);
    rig.tell(B, Command::Version {});
    assert_eq!(rig.take(B).len(), 1);
    assert_eq!(rig.closed.len(), 2);
}

#[test]
fn an_injected_fault_begins_at_once_and_ends_in_its_time() {
    let mut rig = faulty(&fault(3, "kind = \"disk_full\""));
    let stall = Fault {
        at: Timestamp::ZERO,
        lasts: Duration::from_secs(5),
        kind: FaultKind::Stall,
    };
    assert_eq!(rig.plc.inject(rig.now, stall), 2);
    rig.run(0.0);
    rig.tell(A, Command::Version {});
    assert_eq!(rig.take(A), []);
    rig.run(4.9);
    assert_eq!(rig.take(A), []);
    rig.run(0.2);
    assert!(rig.take(A).len() > 2);
    let edges: Vec<String> = rig
        .events
        .iter()
        .filter(|event| matches!(event.kind, PlcEventKind::Fault(..)))
        .map(|event| event.kind.to_string())
        .collect();
    assert_eq!(
        edges,
        [
            "fault 1 begins: disk_full",
            "fault 2 begins: stall",
            "fault 1 ends: disk_full",
            "fault 2 ends: stall"
        ]
    );
}

#[test]
fn a_plan_survives_its_file() {
    let plan = FaultPlan::draw(3, Duration::from_secs(7200), 1.0);
    assert!(plan.faults.len() > 200);
    let kinds: BTreeSet<_> = plan.faults.iter().map(|fault| fault.kind.name()).collect();
    assert!(kinds.len() >= 15, "{kinds:?}");
    let config = PlcConfig {
        fault: plan.faults.iter().map(FaultEntry::of).collect(),
        ..PlcConfig::default()
    };
    assert_eq!(config.plan(), Ok(plan));
    let keys: Vec<bool> = (0..60)
        .map(|seed| {
            let plan = FaultPlan::draw(seed, Duration::from_secs(600), 1.0);
            plan.faults.iter().any(|fault| fault.kind == FaultKind::KeyMissing)
        })
        .collect();
    assert!(keys.contains(&true) && keys.contains(&false));
    assert_eq!(FaultPlan::draw(3, Duration::from_secs(600), 0.0), FaultPlan::default());
}

#[test]
fn a_fault_with_a_wrong_key_is_named() {
    for (entry, message) in [
        (
            "kind = \"sensor_dies\"\nfor_s = 1",
            "plc fault 1: sensor_dies needs `sensor`",
        ),
        ("kind = \"stall\"", "plc fault 1: stall needs `for_s`"),
        (
            "kind = \"stall\"\nfor_s = 1\nchance = 1.0",
            "plc fault 1: stall has no `chance`",
        ),
        ("kind = \"flood\"\nfor_s = 1", "plc fault 1: `records_per_s` is missing"),
        (
            "kind = \"pings_dropped\"\nfor_s = 1\nsensor = \"bluefin\"\nchance = 1.0",
            "plc fault 1: sensor is Bluefin vehicle, expected a sonar: only sonars ping",
        ),
        (
            "kind = \"sensor_unhealthy\"\nfor_s = 1\nsensor = \"bluefin\"\ncause = 5",
            "plc fault 1: cause is 5, expected 0 to 4",
        ),
        (
            "kind = \"stall\"\nfor_s = -1",
            "plc fault 1: for_s is -1, expected 0 to 315360000",
        ),
    ] {
        let config: PlcConfig = toml::from_str(&format!("[[fault]]\nat_s = 1\n{entry}")).expect("keys");
        assert_eq!(config.plan().expect_err("it is wrong").to_string(), message);
    }
}
