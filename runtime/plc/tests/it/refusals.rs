//! Records that are refused: the log says why, once a second, and nothing inside them is done.

use backseat_plc::{DropReason, PlcEventKind};
use backseat_s7k::plc::{Alarm, Command, CommandId};
use backseat_s7k::record::{Action, BluefinRecord, NavigationField, NavigationFrame, NavigationQuality};
use backseat_s7k::{
    BluefinChecksum, DeviceId, FRAME_LIMIT, FrameHeader, FrameWriter, NetworkHeader, SensorIndex, StreamReader, Time7k,
};
use backseat_units::Timestamp;

use crate::rig::{A, B, Got, Rig, START, accepted, command_record, enclosed};

/// What the log says of unusable input: when, and the line.
pub(crate) fn ignored(rig: &Rig) -> Vec<(Timestamp, String)> {
    let events = rig.events.iter();
    events
        .filter(|event| matches!(event.kind, PlcEventKind::Ignored { .. }))
        .map(|event| (event.at, event.kind.to_string()))
        .collect()
}

fn said(rig: &mut Rig) -> Vec<String> {
    rig.run(3.0);
    let lines = ignored(rig).into_iter().map(|(_, line)| line).collect();
    rig.events.clear();
    lines
}

fn version() -> Vec<u8> {
    command_record(SensorIndex::PLC, 4, Action::Get, "")
}

fn shutdown() -> Vec<u8> {
    enclosed(&command_record(SensorIndex::PLC, 13, Action::Set, "0"))
}

#[test]
fn a_wrong_checksum_is_said_with_both_numbers_once_a_second() {
    let mut rig = Rig::ready("");
    let mut wrong = version();
    let end = wrong.len() - 4;
    let right = u32::from_le_bytes([wrong[end], wrong[end + 1], wrong[end + 2], wrong[end + 3]]);
    wrong[end..].copy_from_slice(&0x1234_u32.to_le_bytes());
    let began = rig.now;
    for _ in 0..10 {
        rig.push(A, &enclosed(&wrong));
        rig.run(0.01);
    }
    assert_eq!(rig.take(A), []);
    rig.run(5.0);
    let lines = ignored(&rig);
    let line = |count: u32| {
        format!(
            "client 1: ignored {count} with a wrong checksum (record 11000: expected {right:#010x}, found 0x00001234)"
        )
    };
    let [(first, one), (second, nine)] = &lines[..] else {
        panic!("{lines:?}")
    };
    assert_eq!((one, nine), (&line(1), &line(9)));
    assert_eq!((*first, second.since(*first).as_millis()), (began, 1000));
    // A connection that ends takes nothing with it.
    rig.events.clear();
    rig.push(A, &enclosed(&wrong));
    rig.push(A, &enclosed(&wrong));
    rig.disconnect(A);
    assert_eq!(ignored(&rig).len(), 2);
}

#[test]
fn another_version_is_named_and_refused() {
    let mut rig = Rig::ready("");
    for other in [0, 3, 6, 15] {
        let mut record = version();
        record[0] = other;
        for sent in [record.clone(), enclosed(&record)] {
            rig.push(A, &sent);
            let lines = said(&mut rig);
            let text =
                format!("1 of another protocol version (data record frame of version {other}; only 4 and 5 are read)");
            assert!(lines.len() == 1 && lines[0].contains(&text), "{lines:?}");
        }
        let mut packet = enclosed(&version());
        packet[0] = other;
        if other > 0 {
            rig.push(A, &packet);
            let lines = said(&mut rig);
            let text =
                format!("1 of another protocol version (network frame of version {other}; only 4 and 5 are read)");
            assert!(lines.len() == 1 && lines[0].contains(&text), "{lines:?}");
        }
        assert_eq!(rig.take(A), []);
    }
    rig.push(A, &enclosed(&version()));
    assert_eq!(rig.take(A)[0], accepted(CommandId::Version));
    // Garbage is of no version.
    rig.push(A, &b"GET / HTTP/1.1\r\n\r\n".repeat(10));
    let lines = said(&mut rig);
    assert!(
        lines.len() == 1 && lines[0].ends_with(" bytes skipped") && !lines[0].contains("version"),
        "{lines:?}"
    );
}

/// A record that hides a command in the middle of its data.
fn hiding(length: usize) -> Vec<u8> {
    let (mut out, hidden) = (Vec::new(), shutdown());
    let mut frame = FrameWriter::begin(FrameHeader::new(3100, DeviceId::BLUEFIN), &mut out);
    frame.bytes().resize(FrameHeader::SIZE + length, 0);
    frame.bytes()[FrameHeader::SIZE + length / 2..][..hidden.len()].copy_from_slice(&hidden);
    frame.finish(FRAME_LIMIT).expect("a record");
    out
}

#[test]
fn no_command_inside_a_record_that_is_too_long_is_done() {
    let mut rig = Rig::ready("record_max_bytes = 4096");
    let long = hiding(50_000);
    for packet_max in [0, 45, 1400, 60_000] {
        let mut sent = Vec::new();
        if packet_max == 0 {
            sent.clone_from(&long);
        } else {
            let header = NetworkHeader::new(DeviceId::UNSPECIFIED, 3);
            header.enclose(&long, packet_max, &mut sent).expect("a record");
        }
        for bytes in sent.chunks(997) {
            rig.push(A, bytes);
        }
        assert_eq!(rig.take(A), []);
        rig.push(A, &enclosed(&version()));
        assert_eq!(rig.take(A)[0], accepted(CommandId::Version), "{packet_max}");
        let lines = said(&mut rig);
        assert!(lines[0].contains("1 too long ("), "{lines:?}");
    }
    rig.run(5.0);
    assert!(!rig.plc.is_shut_down());
}

#[test]
fn a_length_that_no_record_has_ends_the_connection() {
    let mut rig = Rig::ready("");
    rig.connect(B);
    let mut record = hiding(2000);
    record[8..12].copy_from_slice(&u32::MAX.to_le_bytes());
    rig.push(A, &record);
    assert_eq!(rig.closed, [A]);
    assert!(rig.has_event(&PlcEventKind::Dropped(A, DropReason::Astray)));
    assert!(
        ignored(&rig)[0]
            .1
            .contains("1 too long (4294967295 bytes, at most 1048576)")
    );
    rig.run(5.0);
    rig.connect(A);
    rig.tell(A, Command::Version {});
    rig.tell(B, Command::Version {});
    assert_eq!((rig.take(A).len(), rig.take(B).len()), (1, 1));
    // A lie below that costs what it covers.
    record[8..12].copy_from_slice(&(StreamReader::SKIP_MAX as u32).to_le_bytes());
    rig.push(B, &record);
    rig.push(B, &enclosed(&version()));
    assert_eq!((rig.take(B), rig.closed.len()), (vec![], 1));
}

/// A record 3100 of so many good frames, changed.
fn navigation(frames: usize, change: impl Fn(&mut Vec<u8>)) -> Vec<u8> {
    let frame = NavigationFrame {
        quality: NavigationQuality::default().with(NavigationField::Latitude),
        latitude_rad: 0.7,
        ..NavigationFrame::default()
    };
    let time = Time7k::from_utc(START);
    let mut body = Vec::new();
    BluefinRecord::compose_navigation(0, &vec![(time, frame); frames], BluefinChecksum::WholePacket, &mut body)
        .expect("25 frames at most");
    change(&mut body);
    let mut out = Vec::new();
    let mut writer = FrameWriter::begin(FrameHeader::new(3100, DeviceId::BLUEFIN).at(time), &mut out);
    writer.bytes().extend_from_slice(&body);
    writer.finish(FRAME_LIMIT).expect("a short record");
    enclosed(&out)
}

#[test]
fn vehicle_data_that_no_reader_takes_are_neither_passed_on_nor_logged_nor_used() {
    let mut rig = Rig::ready("");
    rig.tell(
        A,
        Command::Subscribe {
            sensor: SensorIndex(3),
            record_type: 3100,
        },
    );
    rig.tell(A, Command::Logging { on: true });
    rig.take(A);
    let many = |body: &mut Vec<u8>| {
        body.extend_from_within(32..);
        body[4] = 26;
    };
    for (bytes, fault) in [
        (navigation(13, many), "field frames: 26 is outside 0 to 25"),
        (
            navigation(1, |body| body[8] = 127),
            "field frame_size: 127 bytes, expected 128",
        ),
        (
            navigation(1, |body| body[12] = 2),
            "field data_format: 2 is neither 0 nor 1",
        ),
        (
            navigation(1, |body| body[12] = 1),
            "frame 0 field data_type: 1, expected 2",
        ),
        (
            navigation(1, |body| body[32 + 8] = 3),
            "frame 0 field data_type: 3, expected 1",
        ),
        (navigation(2, |body| body[4] = 1), "128 bytes follow the last frame"),
        (
            navigation(1, |body| body[32 + 16..32 + 26].fill(0)),
            "frame 0 field time: this is no time",
        ),
        (
            navigation(1, |body| body[32 + 16..32 + 26].fill(0xFF)),
            "frame 0 field time: this is no time",
        ),
        (
            navigation(1, |body| body[68..76].copy_from_slice(&5_f64.to_le_bytes())),
            "frame 0 field latitude_rad: 5 is outside its range",
        ),
    ] {
        rig.push(A, &bytes);
        let got = rig.take(A);
        let [
            Got::Alarm(
                _,
                Alarm::RouteFailed {
                    client: 1, description, ..
                },
            ),
        ] = &got[..]
        else {
            panic!("{fault}: {got:?}")
        };
        assert_eq!(**description, *format!("record 3100: {fault}"));
        let lines = said(&mut rig);
        assert_eq!(lines, ["client 1: ignored 1 that cannot be used"]);
    }
    assert!(rig.plc.reported().is_none() && rig.files.is_empty() && rig.records.is_empty());
    for frames in [0, 1, 25] {
        rig.push(A, &navigation(frames, |_| {}));
        assert!(matches!(rig.take(A)[..], [Got::Data(3100, DeviceId::BLUEFIN, _)]));
    }
    assert!(rig.plc.reported().is_some() && rig.files.len() == 1);
}
