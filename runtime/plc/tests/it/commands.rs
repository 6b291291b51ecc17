//! Each command of Table 16 with its acknowledgement and what it solicits.

use backseat_plc::SensorKind;
use backseat_s7k::SensorIndex;
use backseat_s7k::plc::{Alarm, CalendarTime, Command, CommandId, Generic, Order, Status};
use backseat_s7k::record::{Action, AlarmMode, CommandStatus};

use crate::rig::{A, B, BLUEFIN, Got, HIGH, LOW, Rig, SUB_BOTTOM, accepted, invalid, rejected};

fn text_of(got: &Got) -> String {
    let mut text = String::new();
    match got {
        Got::Status(status) => status.write(&mut text).expect("a text"),
        Got::Alarm(_, alarm) => alarm.write(&mut text).expect("a text"),
        Got::Acknowledge(..) | Got::Time(_) | Got::Data(..) => panic!("{got:?}"),
    }
    text
}

#[test]
fn what_solicits_a_status_gets_it_after_its_acknowledgement() {
    let mut rig = Rig::ready("");
    for (id, action, text, status) in [
        (4, Action::Get, "", "1.0203"),
        (
            14,
            Action::Unspecified,
            "",
            "Modules: 3, Module = 1, EdgeTechSBP.dll, 1.0100, Module = 2, EdgeTechSS.dll, 1.0203, Module = 3, Bluefin.dll, 1.0001",
        ),
        (
            15,
            Action::Get,
            "",
            "Sensors: 4, Sensor = 0, 11000, 1, 1700, 0, 0, Sub-bottom, Sensor = 1, 11001, 2, 1701, 0, 20, Sidescan LF, \
             Sensor = 2, 11002, 2, 1702, 0, 21, Sidescan HF, Sensor = 3, 11100, 3, 0, 0, 0, Bluefin",
        ),
        (18, Action::Get, "", "Logging = 0, , 0.000"),
        (21, Action::Get, "", "Sensors: 4, 0, 1, 1, 1, 2, 1, 3, 1"),
        (26, Action::Get, "", "LoggingSetup = 100, 0, D:\\data"),
        // Without parameters it retrieves, whatever the action says (Table 16: "or none").
        (26, Action::Set, "", "LoggingSetup = 100, 0, D:\\data"),
        (10, Action::Get, "-1", "Sensors: 4, 0, 1, 1, 1, 2, 1, 3, 1"),
    ] {
        rig.text(A, SensorIndex::PLC, id, action, text);
        let got = rig.take(A);
        assert_eq!(got.len(), 2, "{id}: {got:?}");
        assert_eq!(got[0], accepted(CommandId::from(id)));
        assert_eq!(text_of(&got[1]), status, "{id}");
    }
}

#[test]
fn what_sets_is_acknowledged_and_says_no_more() {
    let mut rig = Rig::ready("");
    for (id, text) in [
        (1, "1"),
        (2, "line 3"),
        (2, "Auto"),
        (3, "E:\\survey"),
        (6, ""),
        (5, ""),
        (9, "3, 0"),
        (9, "3, 1"),
        (20, "2026/11/23,15:00:00.00000"),
        (22, "1"),
        (23, "1, 5000"),
        (23, "0, 0"),
        (24, "-1"),
        (26, "20, 5"),
        (28, "0"),
        (1, "0"),
    ] {
        rig.text(A, SensorIndex::PLC, id, Action::Set, text);
        assert_eq!(rig.take(A), [accepted(CommandId::from(id))], "{id} {text}");
    }
    rig.text(A, SensorIndex::PLC, 26, Action::Get, "");
    assert_eq!(text_of(&rig.take(A)[1]), "LoggingSetup = 20, 5, E:\\survey");
}

#[test]
fn an_invalid_command_is_rejected_with_alarm_14() {
    let mut rig = Rig::ready("");
    for (id, action, text, description) in [
        (
            1,
            Action::Set,
            "on",
            "Logging parameter on: expected a whole number, found on",
        ),
        (2, Action::Set, "a/b", "this is not a file name"),
        (
            3,
            Action::Set,
            &"x".repeat(201)[..],
            "a folder has 1 to 200 printable characters",
        ),
        (5, Action::Set, "", "there is no file 6046.sav"),
        (7, Action::Set, "9, 3000", "there is no sensor 9 in the run list"),
        (8, Action::Set, "0, 3001", "no subscription to record 3001 of sensor 0"),
        (9, Action::Set, "16, 1", "there is no alarm 16"),
        (10, Action::Get, "9", "there is no sensor 9 in the run list"),
        (12, Action::Set, "9", "there is no sensor 9 in the run list"),
        (16, Action::Set, "9, 0, 5, x", "there is no module 9 with a subsystem 0"),
        (16, Action::Set, "2, 20, 5, x", "sensor 1 has this subsystem already"),
        (
            16,
            Action::Set,
            "2, 20, 5, x, y",
            "a sensor's name has 1 to 64 characters and no comma",
        ),
        (17, Action::Set, "9", "there is no sensor 9 in the run list"),
        (20, Action::Set, "1950/01/01,00:00:00.00000", "TimeSync parameter time"),
        (22, Action::Get, "", "no status says what this command sets"),
        (23, Action::Set, "1, 99", "period 99 ms is below 100"),
        (24, Action::Set, "9", "there is no sensor 9 in the run list"),
        (26, Action::Set, "0, 5", "expected 1 to 4096 MB and 0 to 1000 records"),
        (
            26,
            Action::Set,
            "5, 1001",
            "expected 1 to 4096 MB and 0 to 1000 records",
        ),
        (28, Action::Set, "-1", "TimeMessages parameter on"),
    ] {
        rig.text(A, SensorIndex::PLC, id, action, text);
        let got = rig.take(A);
        assert_eq!(
            (got.len(), &got[0]),
            (2, &rejected(CommandId::from(id))),
            "{id} {text}: {got:?}"
        );
        let Got::Alarm(
            AlarmMode::Unspecified,
            Alarm::InvalidCommand {
                client: 1,
                command,
                description: said,
            },
        ) = &got[1]
        else {
            panic!("{got:?}")
        };
        assert_eq!(*command, id.cast_signed());
        assert!(said.starts_with(description), "{id} {text}: {said}");
    }
}

#[test]
fn an_unknown_command_is_answered_as_unknown() {
    let mut rig = Rig::ready("");
    for id in [19, 27, 29, 1000, u32::MAX] {
        rig.text(A, SensorIndex(5), id, Action::Set, "");
        let unknown = Got::Acknowledge(CommandId::from(id), SensorIndex(5), CommandStatus::Unknown);
        assert_eq!(rig.take(A), [unknown, invalid(id, "there is no such command")]);
    }
}

#[test]
fn a_quiet_client_gets_no_acknowledgement_and_what_it_solicits() {
    let mut rig = Rig::ready("");
    rig.connect(B);
    rig.tell(B, Command::Version {});
    assert!(matches!(rig.take(B)[..], [Got::Status(Status::Version { .. })]));
    rig.tell(B, Command::Logging { on: true });
    assert_eq!(rig.take(B), []);
    // Verbose mode is each client's own; both changes of it are acknowledged.
    rig.tell(A, Command::Verbose { on: false });
    assert_eq!(rig.take(A), [accepted(CommandId::Verbose)]);
    rig.tell(A, Command::Logging { on: false });
    assert_eq!(rig.take(A), []);
}

#[test]
fn the_acknowledgement_may_come_last() {
    let mut rig = Rig::new("interpretation = { acknowledge = \"last\", verbose_at_connect = \"verbose\" }");
    rig.connect(A);
    rig.tell(A, Command::Version {});
    assert!(matches!(rig.take(A)[..], [Got::Status(_), Got::Acknowledge(..)]));
}

#[test]
fn generic_commands_set_what_the_next_ping_has() {
    let mut rig = Rig::ready("");
    for command in [
        Generic::Range { range_m: 50.0 },
        Generic::Pulse {
            name: Box::from("FM 2-16 kHz 20 ms"),
        },
        Generic::TxPower { percent: 40.0 },
        Generic::RxGain { gain: 12 },
        Generic::Duration { period_ms: 500.0 },
        Generic::Ping { on: true },
    ] {
        rig.generic(A, SUB_BOTTOM, &command);
        let accepted = Got::Acknowledge(CommandId::Generic, SUB_BOTTOM, CommandStatus::Accepted);
        assert_eq!(rig.take(A), [accepted], "{command:?}");
    }
    rig.run(2.9);
    assert_eq!(rig.sonar.pings.len(), 6);
    for (number, (kind, ping)) in (1..).zip(&rig.sonar.pings) {
        assert_eq!((*kind, ping.number), (SensorKind::SubBottom, number));
        assert_eq!(
            (ping.range_m, ping.power_percent, ping.gain_steps, ping.pulse.id),
            (50.0, 40.0, 12, 1)
        );
        // 100 m of way at 1500 m/s, every 40 microseconds.
        assert_eq!((ping.samples, ping.sample_interval_us), (1667, 40));
        assert_eq!(
            (ping.pulse.start_hz, ping.pulse.end_hz, ping.pulse.length_s),
            (2000.0, 16_000.0, 0.02)
        );
    }
    let times: Vec<u64> = rig
        .sonar
        .pings
        .iter()
        .map(|(_, ping)| ping.time.as_nanos() / 1_000_000)
        .collect();
    assert_eq!(times, [5000, 5500, 6000, 6500, 7000, 7500]);
    rig.generic(A, SUB_BOTTOM, &Generic::DefaultState {});
    rig.run(5.0);
    // The ping under way is heard to its end.
    assert_eq!(rig.sonar.pings.len(), 6);
}

#[test]
fn a_sonar_listens_to_the_end_of_its_range_before_it_pings_again() {
    let mut rig = Rig::ready("");
    rig.generic(A, LOW, &Generic::Range { range_m: 375.0 });
    rig.generic(A, LOW, &Generic::Duration { period_ms: 10.0 });
    rig.generic(A, LOW, &Generic::Ping { on: true });
    rig.run(5.1);
    // 750 m at 1500 m/s take 0.5 s.
    assert_eq!(rig.sonar.pings.len(), 10);
}

#[test]
fn a_sonar_says_what_it_cannot_do_with_alarm_11() {
    let mut rig = Rig::ready("");
    for (sensor, text, description) in [
        (LOW, "Range = 9000.00", "range 9000.00 is outside 10 to 500 m"),
        (SUB_BOTTOM, "Pulse = Chirp", "there is no pulse Chirp"),
        (HIGH, "TxPower = 101.00", "power 101.00 is outside 0 to 100 %"),
        (HIGH, "RxGain = -1", "gain -1.00 is outside 0 to 60 steps"),
        (HIGH, "Duration = 1.00", "period 1.00 is outside 10 to 60000 ms"),
    ] {
        rig.text(A, sensor, 0, Action::Set, text);
        let alarm = Alarm::SensorCommandFailed {
            sensor,
            client: 1,
            description: Box::from(description),
        };
        let rejected = Got::Acknowledge(CommandId::Generic, sensor, CommandStatus::Rejected);
        assert_eq!(
            rig.take(A),
            [rejected, Got::Alarm(AlarmMode::Unspecified, alarm)],
            "{text}"
        );
    }
    // What is no generic command at all, or for no sensor, is an invalid command.
    for (sensor, text) in [
        (LOW, "Reboot"),
        (LOW, "range = 5.00"),
        (SensorIndex(9), "Ping = 1"),
        (SensorIndex::PLC, "Ping = 1"),
    ] {
        rig.text(A, sensor, 0, Action::Set, text);
        let got = rig.take(A);
        assert!(
            matches!(&got[1], Got::Alarm(_, Alarm::InvalidCommand { command: 0, .. })),
            "{got:?}"
        );
    }
}

#[test]
fn the_vehicle_takes_generic_commands_and_ignores_them() {
    let mut rig = Rig::ready("");
    rig.generic(A, BLUEFIN, &Generic::Ping { on: true });
    rig.run(1.0);
    let accepted = Got::Acknowledge(CommandId::Generic, BLUEFIN, CommandStatus::Accepted);
    assert_eq!((rig.take(A), rig.sonar.pings.len()), (vec![accepted.clone()], 0));
    rig.generic(A, BLUEFIN, &Generic::PulseFiles {});
    rig.run(1.0);
    assert_eq!(
        rig.take(A),
        [accepted, Got::Status(Status::SensorReply { pulses: vec![] })]
    );
}

#[test]
fn pulses_and_the_status_of_a_sensor_come_when_the_sensor_has_answered() {
    let mut rig = Rig::ready("reply_s = 0.5");
    rig.generic(A, SUB_BOTTOM, &Generic::PulseFiles {});
    rig.tell(A, Command::Status { sensor: LOW });
    assert!(rig.take(A).iter().all(|got| matches!(got, Got::Acknowledge(..))));
    rig.run(0.49);
    assert_eq!(rig.take(A), []);
    rig.run(0.02);
    let got = rig.take(A);
    assert_eq!(
        got.iter().map(text_of).collect::<Vec<_>>(),
        [
            "PulseFiles: 3, FM 4-24 kHz 10 ms, FM 2-16 kHz 20 ms, FM 4-20 kHz 5 ms",
            "Sensors: 1, 1, 1"
        ]
    );
    let mut rig = Rig::ready("interpretation = { sensor_status = \"pulses\" }");
    rig.tell(A, Command::Status { sensor: LOW });
    rig.run(1.0);
    assert_eq!(text_of(&rig.take(A)[1]), "PulseFiles: 1, FM 110-130 kHz 8 ms");
}

#[test]
fn a_client_waits_for_64_answers_at_most() {
    let mut rig = Rig::ready("reply_s = 10.0");
    for _ in 0..100 {
        rig.generic(A, LOW, &Generic::PulseFiles {});
    }
    rig.run(20.0);
    let got = rig.take(A);
    let count = |of: fn(&Got) -> bool| got.iter().filter(|got| of(got)).count();
    assert_eq!(count(|got| matches!(got, Got::Status(_))), 64);
    assert_eq!(
        count(|got| matches!(got, Got::Alarm(_, Alarm::InvalidCommand { .. }))),
        36
    );
}

#[test]
fn reset_brings_the_default_state_or_is_not_known() {
    let mut rig = Rig::ready("");
    rig.generic(A, LOW, &Generic::Range { range_m: 50.0 });
    rig.generic(A, LOW, &Generic::Ping { on: true });
    rig.tell(A, Command::Reset { sensor: LOW });
    rig.run(10.0);
    assert_eq!(rig.sonar.pings.len(), 0);
    rig.generic(A, LOW, &Generic::Ping { on: true });
    rig.run(1.0);
    assert_eq!(rig.sonar.pings[0].1.range_m, 100.0);
    let mut rig = Rig::ready("interpretation = { reset = \"unknown\" }");
    rig.tell(A, Command::Reset { sensor: LOW });
    let unknown = Got::Acknowledge(CommandId::Reset, SensorIndex::PLC, CommandStatus::Unknown);
    assert_eq!(rig.take(A)[0], unknown);
}

#[test]
fn alarms_are_switched_for_each_client() {
    let mut rig = Rig::ready("interpretation = { client_alarms = \"all\" }");
    rig.connect(B);
    let wrong = Command::Remove { sensor: SensorIndex(9) };
    let alarms = |rig: &mut Rig| (rig.alarms(A).len(), rig.alarms(B).len());
    rig.tell(A, wrong.clone());
    assert_eq!(alarms(&mut rig), (1, 1));
    rig.tell(B, Command::Alarm { alarm: 14, on: false });
    rig.tell(A, wrong.clone());
    assert_eq!(alarms(&mut rig), (1, 0));
    rig.tell(B, Command::Alarm { alarm: 14, on: true });
    rig.tell(A, wrong);
    assert_eq!(alarms(&mut rig), (1, 1));
}

#[test]
fn a_text_may_begin_with_its_commands_name() {
    let mut rig = Rig::ready("");
    rig.text(A, SensorIndex::PLC, 23, Action::Set, "AutoHealthCheck, 1, 5000");
    assert_eq!(rig.take(A), [accepted(CommandId::AutoHealthCheck)]);
    let order = Order::Do(Command::TimeSync {
        time: CalendarTime::from_utc(crate::rig::START),
    });
    rig.order(A, SensorIndex::PLC, &order);
    assert_eq!(rig.take(A), [accepted(CommandId::TimeSync)]);
}
