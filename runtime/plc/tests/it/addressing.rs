//! Whom a command is for, whether it sets or retrieves, and what a record that is half right is answered (2.5, 2.6).

use backseat_s7k::plc::{Alarm, Command, CommandId, Generic, Status};
use backseat_s7k::record::{Action, CommandStatus};
use backseat_s7k::{DeviceId, FRAME_LIMIT, FrameHeader, FrameWriter, SensorIndex};

use crate::rig::{A, Got, HIGH, LOW, Rig, SUB_BOTTOM, accepted, enclosed};

/// The description of the one alarm 14 in an answer, behind the one acknowledgement.
fn refusal(got: &[Got], command: u32, sensor: SensorIndex, status: CommandStatus) -> String {
    let acknowledged = Got::Acknowledge(CommandId::from(command), sensor, status);
    match got {
        [
            first,
            Got::Alarm(
                _,
                Alarm::InvalidCommand {
                    command: id,
                    description,
                    ..
                },
            ),
        ] if *first == acknowledged => {
            assert_eq!(*id, command.cast_signed());
            description.to_string()
        }
        other => panic!("{command} to {sensor}: {other:?}"),
    }
}

fn rejected(rig: &mut Rig, sensor: SensorIndex, id: u32, action: Action, text: &str) -> String {
    rig.text(A, sensor, id, action, text);
    refusal(&rig.take(A), id, sensor, CommandStatus::Rejected)
}

#[test]
fn the_status_of_a_sensor_may_be_asked_for_by_the_header_alone() {
    let mut rig = Rig::ready("");
    let health = |rig: &mut Rig, sensor: SensorIndex| {
        rig.run(0.2);
        let got = rig.take(A);
        let [
            Got::Acknowledge(CommandId::Status, of, CommandStatus::Accepted),
            Got::Status(Status::Health { sensors }),
        ] = &got[..]
        else {
            panic!("{got:?}")
        };
        assert_eq!(*of, sensor);
        sensors.iter().map(|entry| entry.sensor).collect::<Vec<_>>()
    };
    for action in [Action::Unspecified, Action::Set, Action::Get] {
        for text in ["", "1"] {
            rig.text(A, LOW, 10, action, text);
            assert_eq!(health(&mut rig, LOW), [LOW], "{action:?} {text:?}");
        }
        rig.text(A, SensorIndex::PLC, 10, action, "1");
        assert_eq!(health(&mut rig, SensorIndex::PLC), [LOW]);
    }
    rig.text(A, SensorIndex::PLC, 10, Action::Get, "");
    assert_eq!(health(&mut rig, SensorIndex::PLC).len(), 4);
    let said = rejected(&mut rig, SensorIndex::PLC, 10, Action::Set, "");
    assert_eq!(said, "Status parameter sensor: it is missing");
    let said = rejected(&mut rig, SensorIndex(9), 10, Action::Get, "");
    assert_eq!(said, "there is no sensor 9 in the run list");
}

#[test]
fn a_command_without_an_answer_says_why() {
    let mut rig = Rig::ready("");
    for (ids, text) in [
        (
            &[1, 2, 3, 9, 11, 20, 22, 23, 24, 28][..],
            "no status says what this command sets",
        ),
        (
            &[7, 8, 12, 13, 16, 17],
            "this command sets nothing that can be retrieved",
        ),
    ] {
        for id in ids {
            assert_eq!(rejected(&mut rig, SensorIndex::PLC, *id, Action::Get, ""), text, "{id}");
        }
    }
    let said = rejected(&mut rig, LOW, 0, Action::Get, "");
    assert_eq!(said, "this command sets nothing that can be retrieved");
}

#[test]
fn get_sets_nothing_and_other_actions_are_none() {
    let mut rig = Rig::ready("");
    let nothing = "the action is get, and this command retrieves nothing";
    for (id, text) in [
        (1, "1"),
        (2, "line 3"),
        (3, "E:\\survey"),
        (5, ""),
        (6, ""),
        (7, "0, 3001"),
        (9, "14, 0"),
        (11, "0"),
        (12, "0"),
        (13, "0"),
        (16, "2, 20, 5, x"),
        (17, "0"),
        (20, "2026/11/23,15:00:00.00000"),
        (22, "1"),
        (23, "1, 5000"),
        (24, "0"),
        (26, "20, 5"),
        (28, "1"),
    ] {
        assert_eq!(
            rejected(&mut rig, SensorIndex::PLC, id, Action::Get, text),
            nothing,
            "{id}"
        );
    }
    assert_eq!(rejected(&mut rig, LOW, 0, Action::Get, "Range = 50.00"), nothing);
    assert_eq!(rejected(&mut rig, LOW, 0, Action::Get, "DefaultState"), nothing);
    rig.generic(A, LOW, &Generic::Ping { on: true });
    rig.run(1.0);
    assert_eq!(rig.sonar.pings[0].1.range_m, 100.0);
    assert_eq!(rig.plc.sensors().len(), 4);
    assert!(rig.files.is_empty() && !rig.plc.is_shut_down());
    rig.take(A);
    // What only retrieves may be got, with its parameters.
    rig.text(A, LOW, 0, Action::Get, "PulseFiles");
    rig.run(0.2);
    assert!(matches!(
        rig.take(A)[..],
        [Got::Acknowledge(..), Got::Status(Status::SensorReply { .. })]
    ));
    for (id, text) in [(1, "1"), (4, ""), (0, "Ping = 1")] {
        for action in [3, 7, u32::MAX] {
            let said = rejected(&mut rig, SensorIndex::PLC, id, Action::from(action), text);
            assert_eq!(said, format!("action {action}: expected 0, 1 or 2"));
        }
    }
}

#[test]
fn a_reserved_command_is_unknown_whatever_its_action_and_its_text() {
    let mut rig = Rig::ready("");
    for id in [19, 27, 29] {
        for action in [0, 1, 2, 3] {
            for text in ["", "1"] {
                rig.text(A, SensorIndex::PLC, id, Action::from(action), text);
                let said = refusal(&rig.take(A), id, SensorIndex::PLC, CommandStatus::Unknown);
                assert_eq!(said, "there is no such command");
            }
        }
    }
}

#[test]
fn a_command_goes_to_whom_its_header_names() {
    let mut rig = Rig::ready("");
    for id in [4, 7, 0, 10] {
        let said = rejected(&mut rig, SensorIndex(-2), id, Action::Set, "0, 3001");
        assert_eq!(said, "sensor index -2: expected -1 or that of a sensor");
    }
    // What only the controller does is for no sensor.
    for (id, text) in [
        (1, "1"),
        (4, ""),
        (13, "0"),
        (16, "2, 20, 5, x"),
        (18, ""),
        (26, ""),
        (28, "1"),
    ] {
        let said = rejected(&mut rig, SUB_BOTTOM, id, Action::Unspecified, text);
        assert!(
            said.ends_with("is for the controller: expected sensor index -1, found 0"),
            "{said}"
        );
    }
    // What names a sensor in its text may name the same one in its header, or the controller.
    for (id, text) in [(7, "1, 3000"), (8, "1, 3000"), (24, "1")] {
        rig.text(A, LOW, id, Action::Set, text);
        let acknowledged = Got::Acknowledge(CommandId::from(id), LOW, CommandStatus::Accepted);
        assert_eq!(rig.take(A), [acknowledged]);
        let said = rejected(&mut rig, HIGH, id, Action::Set, text);
        assert_eq!(said, "the header names sensor 2, and the text sensor 1");
    }
}

/// A record 11000 with these bytes behind its frame's header.
fn raw(body: &[u8], change: impl Fn(&mut Vec<u8>)) -> Vec<u8> {
    let header = FrameHeader {
        flags: 0,
        ..FrameHeader::new(11_000, DeviceId::UNSPECIFIED)
    };
    let mut out = Vec::new();
    let mut frame = FrameWriter::begin(header, &mut out);
    frame.bytes().extend_from_slice(body);
    frame.finish(FRAME_LIMIT).expect("a short record");
    change(&mut out);
    enclosed(&out)
}

#[test]
fn a_malformed_command_is_rejected_by_its_name() {
    let mut rig = Rig::ready("");
    let body = |bytes: u32, text: &str| {
        let mut body = Vec::new();
        for word in [-1, 11, 1, bytes.cast_signed()] {
            body.extend_from_slice(&word.to_le_bytes());
        }
        body.extend_from_slice(text.as_bytes());
        body
    };
    let good = body(1, "0");
    for (body, said) in [
        (body(10, "0"), "10 of 1 bytes each do not fit"),
        (body(u32::MAX, "0"), "do not fit"),
        (body(1, "10"), "1 bytes follow the text of 1"),
        (body(0, "0"), "1 bytes follow the text of 0"),
        (good[..15].to_vec(), "ends"),
        (good[..8].to_vec(), "ends"),
    ] {
        rig.push(A, &raw(&body, |_| {}));
        let got = rig.take(A);
        let description = refusal(&got, 11, SensorIndex::PLC, CommandStatus::Rejected);
        assert!(description.contains(said), "{description}");
    }
    for offset in [10_u32, 10_000] {
        let nonsense = |out: &mut Vec<u8>| out[12..16].copy_from_slice(&offset.to_le_bytes());
        rig.push(A, &raw(&good, nonsense));
        let description = refusal(&rig.take(A), 11, SensorIndex::PLC, CommandStatus::Rejected);
        assert!(description.contains("optional_offset"), "{description}");
    }
    // Without its name there is nobody to answer.
    rig.push(A, &raw(&good[..7], |_| {}));
    assert_eq!(rig.take(A), []);
    // A sender may fill up with NUL.
    rig.push(A, &raw(&body(1, "1\0\0\0"), |_| {}));
    assert_eq!(rig.take(A), [accepted(CommandId::Verbose)]);
    // A quiet client gets the alarm alone.
    rig.tell(A, Command::Verbose { on: false });
    rig.take(A);
    rig.push(A, &raw(&body(9, ""), |_| {}));
    assert!(matches!(
        rig.take(A)[..],
        [Got::Alarm(_, Alarm::InvalidCommand { command: 11, .. })]
    ));
}

#[test]
fn numbers_that_the_tables_do_not_have_are_refused() {
    let mut rig = Rig::ready("");
    for (id, text) in [
        (9, "3, 2"),
        (11, "2"),
        (11, "-1"),
        (22, "2"),
        (23, "2, 1000"),
        (28, "2"),
    ] {
        let said = rejected(&mut rig, SensorIndex::PLC, id, Action::Set, text);
        assert!(said.contains("expected 0 or 1"), "{said}");
    }
    // Table 16: any number but 0 switches logging on.
    rig.text(A, SensorIndex::PLC, 1, Action::Set, "2");
    assert_eq!(rig.take(A), [accepted(CommandId::Logging)]);
    rig.tell(A, Command::Remove { sensor: LOW });
    rig.take(A);
    for port in [0, -1, 65_536] {
        let said = rejected(
            &mut rig,
            SensorIndex::PLC,
            16,
            Action::Set,
            &format!("2, 20, {port}, LF"),
        );
        assert_eq!(said, format!("port {port} is outside 1 to 65535"));
    }
    rig.text(A, SensorIndex::PLC, 16, Action::Set, "2, 20, 65535, LF");
    assert_eq!(rig.take(A), [accepted(CommandId::Add)]);
    // A comma begins another parameter (2.5), in every name.
    for (id, text) in [(2, "line 3, south"), (3, "D:\\a,b"), (16, "2, 20, 5, x, y")] {
        rejected(&mut rig, SensorIndex::PLC, id, Action::Set, text);
    }
    // The vehicle's interface has no port.
    rig.text(A, SensorIndex::PLC, 17, Action::Set, "3");
    rig.text(A, SensorIndex::PLC, 16, Action::Set, "3, 0, 0, Bluefin");
    assert_eq!(rig.take(A), [accepted(CommandId::Remove), accepted(CommandId::Add)]);
}
