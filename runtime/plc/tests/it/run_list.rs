//! The run list: sensors are added, removed, saved and loaded, and start and shut down in their times.

use backseat_plc::{FaultKind, PlcEventKind, SensorKind, Stored};
use backseat_s7k::SensorIndex;
use backseat_s7k::plc::{Command, CommandId, Generic, Status};

use crate::rig::{A, BLUEFIN, Got, HIGH, LOW, Rig, SUB_BOTTOM, accepted, enclosed, navigation_record};

fn list(rig: &mut Rig) -> Vec<(i32, i32, String)> {
    rig.take(A);
    rig.tell(A, Command::RunList {});
    let got = rig.take(A);
    let Some(Got::Status(Status::RunList { sensors })) = got.last() else {
        panic!("{got:?}")
    };
    let entry = |sensor: &backseat_s7k::plc::RunListEntry| (sensor.sensor.0, sensor.id, sensor.name.to_string());
    sensors.iter().map(entry).collect()
}

fn add(module: i32, subsystem: i32, name: &str) -> Command {
    Command::Add {
        module,
        subsystem,
        port: 5,
        name: Box::from(name),
    }
}

#[test]
fn an_added_sensor_gets_an_index_that_was_never_used_and_starts() {
    let mut rig = Rig::ready("sensor = []");
    assert_eq!(list(&mut rig), []);
    rig.tell(A, add(2, 21, "HF sidescan"));
    rig.tell(A, add(1, 0, "SBP"));
    rig.tell(A, Command::Remove { sensor: SensorIndex(0) });
    rig.run(10.0);
    rig.tell(A, add(2, 21, "HF again"));
    assert_eq!(
        list(&mut rig),
        [(1, 11_000, "SBP".to_owned()), (2, 11_002, "HF again".to_owned())]
    );
    let high = SensorIndex(2);
    assert!(rig.has_event(&PlcEventKind::SensorStarting(high, SensorKind::SidescanHigh)));
    assert!(!rig.has_event(&PlcEventKind::SensorStarted(high, SensorKind::SidescanHigh)));
    // Default: 2 to 4 s.
    rig.run(4.0);
    assert!(rig.has_event(&PlcEventKind::SensorStarted(high, SensorKind::SidescanHigh)));
}

#[test]
fn a_sensor_that_starts_takes_no_commands_and_does_not_ping() {
    let mut rig = Rig::new("");
    rig.connect(A);
    rig.tell(A, Command::Verbose { on: true });
    rig.take(A);
    rig.generic(A, LOW, &Generic::Ping { on: true });
    let got = rig.take(A);
    assert!(format!("{got:?}").contains("the sensor has not started"), "{got:?}");
}

#[test]
fn a_saved_run_list_is_loaded_with_indices_from_0() {
    let mut rig = Rig::ready("");
    rig.tell(A, Command::Remove { sensor: LOW });
    rig.tell(A, Command::Save {});
    assert_eq!(
        String::from_utf8_lossy(&rig.files["6046.sav"]),
        "6046 run list 1\n1, 0, 1700, Sub-bottom\n2, 21, 1702, Sidescan HF\n3, 0, 0, Bluefin\n"
    );
    rig.tell(A, Command::Remove { sensor: HIGH });
    rig.tell(A, Command::Load {});
    let names = |list: Vec<(i32, i32, String)>| list.into_iter().map(|(index, id, _)| (index, id)).collect::<Vec<_>>();
    assert_eq!(names(list(&mut rig)), [(0, 11_000), (1, 11_002), (2, 11_100)]);
    // A sensor of the new list waits until that of the old one is down.
    let started = |rig: &Rig| {
        rig.events
            .iter()
            .filter(|event| matches!(event.kind, PlcEventKind::SensorStarted(..)))
            .count()
    };
    let before = started(&rig);
    rig.run(1.0);
    assert_eq!(started(&rig), before + 1, "the vehicle's takes less than a second");
    rig.run(6.0);
    assert_eq!(started(&rig), before + 3);
    // The next start of the controller has what was saved.
    let stored = Stored {
        run_list: Some(String::from_utf8_lossy(&rig.files["6046.sav"]).into_owned()),
        settings: None,
    };
    let next = Rig::with("", 7, &stored);
    let kinds: Vec<SensorKind> = next.plc.sensors().into_iter().map(|(_, kind, _)| kind).collect();
    assert_eq!(
        kinds,
        [SensorKind::SubBottom, SensorKind::SidescanHigh, SensorKind::Bluefin]
    );
}

#[test]
fn indices_may_go_on_after_a_load() {
    let mut rig = Rig::ready("interpretation = { loaded_index = \"continue\" }");
    rig.tell(A, Command::Save {});
    rig.tell(A, Command::Load {});
    let indices: Vec<i32> = list(&mut rig).into_iter().map(|(index, ..)| index).collect();
    assert_eq!(indices, [4, 5, 6, 7]);
}

#[test]
fn loading_again_and_again_leaves_one_sensor_of_each_kind() {
    let mut rig = Rig::ready("");
    rig.tell(A, Command::Save {});
    for _ in 0..500 {
        rig.tell(A, Command::Load {});
    }
    rig.run(20.0);
    assert_eq!(rig.plc.sensors().len(), 4);
    let down = rig
        .events
        .iter()
        .filter(|event| matches!(event.kind, PlcEventKind::SensorDown(..)))
        .count();
    assert_eq!(down, 4);
}

#[test]
fn auto_start_is_kept_for_the_next_start() {
    let mut rig = Rig::ready("");
    rig.tell(A, Command::AutoStart { on: true });
    assert_eq!(rig.files["6046.cfg"], b"AutoStart = 1\n");
    rig.run(2.0);
    assert_eq!(rig.sonar.pings.len(), 0, "it changes nothing now");
    let stored = Stored {
        run_list: None,
        settings: Some("AutoStart = 1\n".to_owned()),
    };
    let mut next = Rig::with("", 7, &stored);
    next.pose();
    next.run(6.0);
    assert!(next.sonar.pings.len() > 30);
    assert_eq!(next.open_files(), ["D:\\data\\20261123_140000_0000.s7k"]);
}

#[test]
fn a_stored_file_that_cannot_be_read_is_refused() {
    let config = backseat_plc::PlcConfig::default();
    let fault = |stored: &Stored| {
        backseat_plc::Plc::new(&config, 1, crate::rig::START, stored)
            .expect_err("it is wrong")
            .to_string()
    };
    let run_list = Stored {
        run_list: Some("6046 run list 1\n7, 0, 0, x".to_owned()),
        settings: None,
    };
    assert_eq!(
        fault(&run_list),
        "6046.sav, line 2: expected module, subsystem, port and name of a sensor"
    );
    let settings = Stored {
        run_list: None,
        settings: Some("yes".to_owned()),
    };
    assert!(fault(&settings).starts_with("6046.cfg, line 1: expected \"AutoStart = 0\""));
}

#[test]
fn messages_go_to_the_sensor_that_is_set_for_them() {
    let mut rig = Rig::ready("");
    let navigation = enclosed(&navigation_record());
    rig.push(A, &navigation);
    assert_eq!(rig.take(A), []);
    for (route, fault) in [(LOW, "takes no messages"), (SensorIndex::PLC, "no sensor is set")] {
        rig.tell(A, Command::RouteMessages { sensor: route });
        assert_eq!(rig.take(A), [accepted(CommandId::RouteMessages)]);
        rig.push(A, &navigation);
        let got = format!("{:?}", rig.take(A));
        assert!(got.contains("RouteFailed") && got.contains(fault), "{got}");
    }
    rig.tell(A, Command::RouteMessages { sensor: BLUEFIN });
    rig.take(A);
    rig.push(A, &navigation);
    assert_eq!(rig.take(A), []);
    assert_eq!(rig.plc.wrong_bluefin_checksums(), 0);
    rig.tell(A, Command::Remove { sensor: BLUEFIN });
    rig.take(A);
    rig.push(A, &navigation);
    assert!(format!("{:?}", rig.take(A)).contains("no sensor is set"));
}

#[test]
fn a_sensor_whose_start_failed_starts_after_a_reset() {
    let table = "[[fault]]\nat_s = 0\nfor_s = 10\nkind = \"start_fails\"\nsensor = \"sub_bottom\"\n";
    let mut rig = Rig::ready(table);
    assert!(rig.has_event(&PlcEventKind::SensorStartFailed(SUB_BOTTOM, SensorKind::SubBottom)));
    rig.run(10.0);
    rig.tell(A, Command::Reset { sensor: SUB_BOTTOM });
    rig.run(5.0);
    let begin =
        |event: &&backseat_plc::PlcEvent| matches!(event.kind, PlcEventKind::Fault(1, _, FaultKind::StartFails(_)));
    assert_eq!(rig.events.iter().filter(begin).count(), 2);
    assert!(rig.has_event(&PlcEventKind::SensorStarted(SUB_BOTTOM, SensorKind::SubBottom)));
}

#[test]
fn a_sensor_is_not_healthy_before_it_has_started() {
    let mut rig = Rig::new("health_period_s = 0.5");
    rig.connect(A);
    let health = |rig: &mut Rig| {
        rig.tell(A, Command::Health {});
        let got = rig.take(A);
        let Some(Got::Status(Status::Health { sensors })) = got.last() else {
            panic!("{got:?}")
        };
        sensors.iter().map(|entry| entry.healthy).collect::<Vec<_>>()
    };
    assert_eq!(health(&mut rig), [false; 4]);
    rig.run(1.0);
    assert_eq!(
        health(&mut rig),
        [false, false, false, true],
        "the vehicle's starts first"
    );
    rig.run(4.0);
    assert_eq!(health(&mut rig), [true; 4]);
    // None of them has failed a check.
    assert!(
        !rig.events
            .iter()
            .any(|event| matches!(event.kind, PlcEventKind::Raised(_)))
    );
}
