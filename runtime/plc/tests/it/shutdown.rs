//! The controller shuts down: clients are told, files are closed, connections end.

use backseat_plc::{DropReason, LogStop, PlcEventKind, SensorKind};
use backseat_s7k::plc::{Alarm, Command, CommandId, Generic, Status};
use backseat_s7k::record::AlarmMode;

use crate::rig::{A, B, Got, LOW, Rig, accepted, enclosed, navigation_record, rejected};

#[test]
fn every_client_is_told_and_files_are_closed_before_connections() {
    let mut rig = Rig::ready("");
    rig.connect(B);
    rig.generic(A, LOW, &Generic::Ping { on: true });
    rig.tell(A, Command::Logging { on: true });
    rig.run(1.0);
    rig.take(A);
    rig.tell(B, Command::Shutdown { kind: 0 });
    assert_eq!(rig.take(A), [Got::Status(Status::Shutdown {})]);
    assert_eq!(rig.take(B), [Got::Status(Status::Shutdown {})]);
    assert!(rig.open_files().is_empty() && rig.closed.is_empty());
    assert!(rig.has_event(&PlcEventKind::LogStopped(LogStop::ShutDown)));
    // Until the end commands are refused.
    rig.tell(A, Command::Shutdown { kind: 0 });
    assert_eq!(rig.take(A)[0], rejected(CommandId::Shutdown));
    rig.run(1.0);
    assert_eq!(rig.closed, [A, B]);
    assert!(rig.plc.is_shut_down() && rig.plc.poll_timeout().is_none());
    // Nothing happens any more.
    rig.connect(A);
    assert!(rig.has_event(&PlcEventKind::Dropped(A, DropReason::ShutDown)));
    rig.push(A, &enclosed(&navigation_record()));
    assert_eq!(rig.take(A), []);
}

#[test]
fn shutdown_1_takes_the_sensors_down_first() {
    let table = "[[fault]]\nat_s = 0\nfor_s = 60\nkind = \"shutdown_fails\"\nsensor = \"sidescan_high\"\n";
    let mut rig = Rig::ready(table);
    rig.tell(A, Command::Shutdown { kind: 1 });
    let mut got = rig.take(A);
    got.retain(|got| !matches!(got, Got::Alarm(..)));
    assert_eq!(
        got,
        [accepted(CommandId::Shutdown), Got::Status(Status::Shutdown {})]
            .into_iter()
            .rev()
            .collect::<Vec<_>>()
    );
    rig.run(10.0);
    // Alarm 7 still reaches the clients.
    let got = rig.alarms(A);
    assert!(
        matches!(&got[..], [(AlarmMode::Unspecified, Alarm::SensorShutdownFailed { .. })]),
        "{got:?}"
    );
    let down = |kind: SensorKind, whole: bool| {
        let is =
            |event: &PlcEventKind| matches!(event, PlcEventKind::SensorDown(_, of, ok) if *of == kind && *ok == whole);
        rig.events
            .iter()
            .position(|event| is(&event.kind))
            .expect("it went down")
    };
    let last = [
        down(SensorKind::SubBottom, true),
        down(SensorKind::SidescanLow, true),
        down(SensorKind::SidescanHigh, false),
        down(SensorKind::Bluefin, true),
    ]
    .into_iter()
    .max();
    let closed = rig
        .events
        .iter()
        .position(|event| matches!(event.kind, PlcEventKind::Dropped(..)));
    assert!(last < closed && rig.plc.is_shut_down());
}

#[test]
fn without_its_key_the_controller_ends_some_time_later() {
    let table = "key_grace_s = 30\n[[fault]]\nat_s = 10\nfor_s = 20\nkind = \"key_missing\"\n[[fault]]\nat_s = 50\nfor_s = 100\nkind = \"key_missing\"\n";
    let mut rig = Rig::ready(table);
    rig.run(5.5);
    let key = Alarm::KeyMissing {
        description: Box::from("no valid HASP key"),
    };
    assert_eq!(rig.alarms(A), [(AlarmMode::Active, key.clone())]);
    rig.run(30.0);
    assert_eq!(
        rig.alarms(A),
        [(AlarmMode::Clear, key), (AlarmMode::Clear, Alarm::AllClear {})]
    );
    rig.run(60.0);
    assert!(rig.take(A).contains(&Got::Status(Status::Shutdown {})));
    assert!(rig.plc.is_shut_down());
}

#[test]
fn a_driver_ends_the_controller_as_a_client_does() {
    let mut rig = Rig::ready("");
    rig.generic(A, LOW, &Generic::Ping { on: true });
    rig.tell(A, Command::Logging { on: true });
    rig.run(1.0);
    rig.take(A);
    rig.plc.shut_down(rig.now);
    rig.plc.shut_down(rig.now);
    rig.drain();
    assert_eq!(rig.take(A), [Got::Status(Status::Shutdown {})], "once");
    assert!(rig.open_files().is_empty() && rig.has_event(&PlcEventKind::LogStopped(LogStop::ShutDown)));
    rig.run(1.0);
    assert!(rig.plc.is_shut_down() && rig.closed == [A]);
    rig.plc.shut_down(rig.now);
    assert!(rig.plc.poll_timeout().is_none());
}
