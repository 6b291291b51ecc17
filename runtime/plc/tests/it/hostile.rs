//! Clients that send garbage, half records, or more than they should. Nobody else notices.

use backseat_plc::PlcEventKind;
use backseat_s7k::plc::{Command, CommandId, Generic};
use backseat_s7k::record::Action;
use backseat_s7k::{DeviceId, FRAME_LIMIT, FrameHeader, FrameWriter, SensorIndex};

use crate::rig::{A, B, Got, HIGH, LOW, Rig, accepted, command_record, enclosed, navigation_record};

/// What the other client gets in ten seconds, while this happens each tenth of a second.
fn undisturbed(disturb: impl Fn(&mut Rig, u32)) {
    let run = |hostile: bool| {
        let mut rig = Rig::ready("");
        rig.connect(B);
        for sensor in [LOW, HIGH] {
            rig.tell(
                A,
                Command::Subscribe {
                    sensor,
                    record_type: 3000,
                },
            );
            rig.generic(A, sensor, &Generic::Ping { on: true });
        }
        for step in 0..100 {
            if hostile {
                disturb(&mut rig, step);
            }
            rig.run(0.1);
        }
        rig.tell(A, Command::Version {});
        (rig.take(A), rig.records.remove(&A))
    };
    let (alone, beside) = (run(false), run(true));
    assert!(alone.0.len() > 100);
    assert_eq!(alone.0, beside.0);
}

#[test]
fn a_flood_of_commands_disturbs_nobody_else() {
    undisturbed(|rig, step| {
        for number in 0..50 {
            rig.tell(B, Command::RunList {});
            rig.text(B, SensorIndex(number), step + 200, Action::Set, "what is this, then");
            rig.tell(
                B,
                Command::Subscribe {
                    sensor: LOW,
                    record_type: 3000,
                },
            );
        }
    });
}

#[test]
fn garbage_disturbs_nobody_else() {
    undisturbed(|rig, step| {
        let garbage: Vec<u8> = (0..5000_u32)
            .map(|byte| (byte.wrapping_mul(2_654_435_761 + step) >> 13) as u8)
            .collect();
        rig.push(B, &garbage);
    });
}

#[test]
fn half_records_take_no_more_than_a_record() {
    let mut rig = Rig::ready("record_max_bytes = 4096");
    let mut record = enclosed(&navigation_record());
    record.truncate(3000);
    for _ in 0..200 {
        rig.push(A, &record);
    }
    rig.take(A);
    rig.connect(B);
    rig.tell(B, Command::Version {});
    assert_eq!(rig.take(B).len(), 1);
    // A new connection starts afresh.
    rig.disconnect(A);
    rig.connect(A);
    rig.tell(A, Command::Version {});
    assert_eq!(rig.take(A).len(), 1);
}

#[test]
fn a_command_is_found_behind_garbage() {
    let mut rig = Rig::ready("");
    let mut bytes = b"GET / HTTP/1.1\r\n\r\n".repeat(20);
    bytes.extend_from_slice(&enclosed(&command_record(SensorIndex::PLC, 18, Action::Get, "")));
    bytes.extend_from_slice(&enclosed(&command_record(SensorIndex::PLC, 4, Action::Get, "")));
    for byte in bytes.chunks(7) {
        rig.push(A, byte);
    }
    let got = rig.take(A);
    assert!(got.contains(&accepted(CommandId::ReportLogging)) && got.contains(&accepted(CommandId::Version)));
    let skipped = |event: &backseat_plc::PlcEvent| matches!(&event.kind, PlcEventKind::Ignored { client: A, what } if what.bytes > 0);
    assert!(rig.events.iter().any(skipped));
}

#[test]
fn a_command_with_a_wrong_checksum_is_not_done() {
    let mut rig = Rig::ready("");
    let mut record = command_record(SensorIndex::PLC, 13, Action::Set, "0");
    if let Some(last) = record.last_mut() {
        *last ^= 1;
    }
    rig.push(A, &enclosed(&record));
    rig.run(5.0);
    assert_eq!(rig.take(A), []);
    assert!(!rig.plc.is_shut_down());
    assert_eq!(crate::refusals::ignored(&rig).len(), 1);
}

#[test]
fn a_record_that_is_not_for_the_controller_is_routed_and_refused() {
    let mut rig = Rig::ready("");
    let mut other = Vec::new();
    let mut frame = FrameWriter::begin(FrameHeader::new(7000, DeviceId(7125)), &mut other);
    frame.bytes().extend_from_slice(&[1, 2, 3]);
    frame.finish(FRAME_LIMIT).expect("a short record");
    rig.push(A, &enclosed(&other));
    assert!(format!("{:?}", rig.take(A)).contains("record 7000: the sensor takes records 3100 only"));
    // A record 3100 that is none.
    let mut broken = Vec::new();
    let mut frame = FrameWriter::begin(FrameHeader::new(3100, DeviceId::BLUEFIN), &mut broken);
    frame.bytes().extend_from_slice(&[0xFF; 32]);
    frame.finish(FRAME_LIMIT).expect("a short record");
    rig.push(A, &enclosed(&broken));
    assert!(format!("{:?}", rig.take(A)).contains("record 3100: the record cannot be read"));
    // The controller's own messages are ignored.
    let mut echo = Vec::new();
    let frame = FrameWriter::begin(FrameHeader::new(11_002, DeviceId::UNSPECIFIED), &mut echo);
    frame.finish(FRAME_LIMIT).expect("a short record");
    rig.push(A, &enclosed(&echo));
    assert_eq!(rig.take(A), []);
}

#[test]
fn records_without_network_frames_are_read_too() {
    let mut rig = Rig::ready("");
    rig.push(A, &command_record(SensorIndex::PLC, 4, Action::Get, ""));
    assert!(matches!(rig.take(A)[..], [Got::Acknowledge(..), Got::Status(_)]));
}

#[test]
fn input_of_a_client_that_is_not_connected_is_ignored() {
    let mut rig = Rig::ready("");
    rig.plc.disconnect(rig.now, B);
    rig.push(B, &enclosed(&command_record(SensorIndex::PLC, 13, Action::Set, "0")));
    rig.run(5.0);
    assert!(!rig.plc.is_shut_down());
}
