//! Log files, read back with the reader of the format.

use std::io::Cursor;

use backseat_plc::{FileEffect, FileFailure, FilePlace, LogStop, Plc, PlcEventKind, Stored};
use backseat_s7k::file::{FileItem, FileReader, Index};
use backseat_s7k::plc::{Alarm, Command, CommandId, Generic, Status};
use backseat_s7k::record::{AlarmMode, Record};
use backseat_s7k::{DeviceId, FRAME_LIMIT, Frame};
use backseat_units::Utc;

use crate::rig::{
    A, B, BLUEFIN, Got, HIGH, LOW, Rig, START, SUB_BOTTOM, accepted, enclosed, navigation_record, rejected,
};

/// Type, device and record count of each record of a file.
fn read(bytes: &[u8]) -> Vec<(u32, u32, u32)> {
    let mut reader = FileReader::new(Cursor::new(bytes));
    let mut records = Vec::new();
    while let Some(item) = reader.next().expect("memory") {
        match item {
            FileItem::Record { frame, .. } => {
                let header = frame.header();
                assert_eq!(frame.checksum(), backseat_s7k::Checksum::Valid);
                records.push((header.record_type, header.device.0, header.record_count));
            }
            FileItem::Skipped(skipped) => panic!("{skipped}"),
        }
    }
    records
}

fn pinging(table: &str) -> Rig {
    let mut rig = Rig::ready(table);
    for sensor in [SUB_BOTTOM, LOW, HIGH] {
        rig.generic(A, sensor, &Generic::Ping { on: true });
    }
    rig.take(A);
    rig
}

fn details(rig: &mut Rig) -> (bool, String, f64) {
    rig.tell(A, Command::ReportLogging {});
    let got = rig.take(A);
    let Some(Got::Status(Status::FileDetails { on, file, size_mb })) = got.last() else {
        panic!("{got:?}")
    };
    (*on, file.to_string(), *size_mb)
}

#[test]
fn a_log_has_every_record_of_every_sensor_whether_anyone_subscribed_or_not() {
    let mut rig = pinging("");
    assert_eq!(details(&mut rig), (false, String::new(), 0.0));
    rig.tell(A, Command::Logging { on: true });
    // Table 17: "if active, the current fully qualified file name". There is no file before the first record, but its name
    // is known.
    let name = "D:\\data\\20261123_140005_0000.s7k".to_owned();
    assert_eq!(details(&mut rig), (true, name.clone(), 0.0));
    rig.run(2.0);
    rig.push(A, &enclosed(&navigation_record()));
    let (on, file, size_mb) = details(&mut rig);
    assert_eq!((on, file.as_str()), (true, name.as_str()));
    let length = rig.files[&file].len();
    assert!((size_mb * 1e6 - length as f64).abs() < 600.0, "{size_mb} {length}");
    let before = rig.sonar.pings.len();
    rig.tell(A, Command::Logging { on: false });
    rig.run(1.0);
    let bytes = &rig.files[&file];
    let records = read(bytes);
    assert_eq!(
        (records.first().map(|first| first.0), records.last().map(|last| last.0)),
        (Some(7200), Some(7300))
    );
    assert_eq!(records.len(), before + 3);
    assert!(records.contains(&(3100, 11_100, 0)));
    for device in [11_000, 11_001, 11_002] {
        let counts: Vec<u32> = records
            .iter()
            .filter(|record| record.1 == device)
            .map(|record| record.2)
            .collect();
        assert!(
            counts.windows(2).all(|pair| pair[1] == pair[0] + 1) && counts.len() > 8,
            "{counts:?}"
        );
    }
    assert_eq!(
        Index::from_catalog(Cursor::new(bytes)).expect("a catalogue"),
        Index::scan(Cursor::new(bytes)).expect("memory")
    );
    let header = Frame::read(bytes, FRAME_LIMIT).expect("a record");
    let Ok(Record::FileHeader(header)) = Record::read(&header) else {
        panic!()
    };
    let devices: Vec<DeviceId> = header.devices().map(|device| device.device).collect();
    assert_eq!(
        devices,
        [DeviceId(11_000), DeviceId(11_001), DeviceId(11_002), DeviceId(11_100)]
    );
    assert!(rig.open_files().is_empty() && rig.has_event(&PlcEventKind::LogStopped(LogStop::Command)));
}

#[test]
fn files_keep_to_their_size_and_repeat_the_last_records() {
    let mut rig = pinging("logging = { file_size_mb = 1, overlap_records = 3 }");
    rig.tell(A, Command::Logging { on: true });
    rig.run(20.0);
    rig.tell(A, Command::Logging { on: false });
    let files: Vec<&String> = rig.files.keys().collect();
    assert!(
        files.len() >= 4 && files[0] == "D:\\data\\20261123_140005_0000.s7k",
        "{files:?}"
    );
    let data = |bytes: &[u8]| {
        read(bytes)
            .into_iter()
            .filter(|record| record.0 < 7000)
            .collect::<Vec<_>>()
    };
    let mut all: Vec<(u32, u32, u32)> = Vec::new();
    for bytes in rig.files.values() {
        assert!(bytes.len() <= 1_000_000);
        let records = data(bytes);
        let repeated = if all.is_empty() { 0 } else { 3 };
        assert_eq!(records[..repeated], all[all.len() - repeated..]);
        all.extend_from_slice(&records[repeated..]);
    }
    assert_eq!(all.len(), rig.sonar.pings.len());
    // A longer file and no overlap from now on.
    rig.take(A);
    rig.tell(
        A,
        Command::LoggingSetup {
            file_size: 100,
            overlap: 0,
        },
    );
    rig.tell(A, Command::Logging { on: true });
    let before = rig.files.len();
    rig.run(20.0);
    assert_eq!(rig.files.len(), before + 1);
}

#[test]
fn switch_names_the_next_file_and_auto_goes_back_to_times() {
    let mut rig = pinging("logging = { overlap_records = 2 }");
    let names = |rig: &Rig| {
        rig.files
            .keys()
            .map(|name| name.replace("D:\\data\\", ""))
            .collect::<Vec<_>>()
    };
    rig.tell(A, Command::Logging { on: true });
    rig.run(1.0);
    rig.tell(
        A,
        Command::Switch {
            name: Box::from("line 3 south"),
        },
    );
    rig.run(1.0);
    rig.tell(
        A,
        Command::Switch {
            name: Box::from("Auto"),
        },
    );
    rig.run(1.0);
    rig.tell(
        A,
        Command::Switch {
            name: Box::from("b.s7k"),
        },
    );
    rig.run(1.0);
    rig.tell(A, Command::Logging { on: false });
    assert_eq!(
        names(&rig),
        [
            "20261123_140005_0000.s7k",
            "20261123_140007_0000.s7k",
            "b.s7k",
            "line 3 south.s7k"
        ]
    );
    let last = |name: &str| read(&rig.files[&format!("D:\\data\\{name}")]);
    let first = last("20261123_140005_0000.s7k");
    let second = last("line 3 south.s7k");
    assert_eq!(
        first[first.len() - 3..first.len() - 1],
        second[1..3],
        "the last two records are repeated"
    );
    rig.take(A);
    rig.tell(A, Command::Switch { name: Box::from("b") });
    assert_eq!(
        rig.take(A)[0],
        rejected(CommandId::Switch),
        "a file of this name exists"
    );
}

#[test]
fn several_switches_within_a_second_give_files_of_their_own() {
    let mut rig = pinging("");
    rig.tell(A, Command::Logging { on: true });
    for _ in 0..5 {
        rig.run(0.15);
        rig.tell(
            A,
            Command::Switch {
                name: Box::from("Auto"),
            },
        );
    }
    rig.tell(A, Command::Logging { on: false });
    assert_eq!(rig.files.len(), 5, "{:?}", rig.files.keys());
    assert!(rig.files.contains_key("D:\\data\\20261123_140005-2_0000.s7k"));
}

#[test]
fn path_sets_the_folder_of_the_next_file() {
    let mut rig = pinging("");
    rig.tell(A, Command::Logging { on: true });
    rig.run(1.0);
    rig.tell(
        A,
        Command::Path {
            folder: Box::from("/data/second/"),
        },
    );
    rig.run(1.0);
    let places: Vec<Option<String>> = rig
        .effects
        .iter()
        .filter_map(|effect| {
            if let FileEffect::Open { place, .. } = effect {
                Some(place.folder.clone())
            } else {
                None
            }
        })
        .collect();
    assert_eq!(places, [Some("D:\\data".to_owned()), Some("/data/second/".to_owned())]);
    assert!(details(&mut rig).1.starts_with("/data/second/20261123_"));
}

#[test]
fn another_run_list_begins_another_file() {
    let mut rig = pinging("");
    rig.tell(A, Command::Logging { on: true });
    rig.run(1.0);
    rig.tell(A, Command::Remove { sensor: BLUEFIN });
    rig.run(1.0);
    rig.tell(A, Command::Logging { on: false });
    let devices: Vec<u32> = rig
        .files
        .values()
        .map(|bytes| {
            let header = Frame::read(bytes, FRAME_LIMIT).expect("a record");
            let Ok(Record::FileHeader(header)) = Record::read(&header) else {
                panic!()
            };
            header.header.devices
        })
        .collect();
    assert_eq!(devices, [4, 3]);
}

#[test]
fn the_disk_fills_up_and_logging_ends_with_whole_files() {
    let disk = "disk = { capacity_mb = 10, used_mb = 6, critical_percent = 25 }\nlogging = { file_size_mb = 1 }";
    let mut rig = pinging(disk);
    rig.tell(A, Command::Logging { on: true });
    rig.take(A);
    rig.connect(B);
    rig.run(40.0);
    // Everybody hears of it, asked or not.
    let stopped = Got::Status(Status::FileDetails {
        on: false,
        file: Box::from(""),
        size_mb: 0.0,
    });
    assert!(rig.take(B).contains(&stopped));
    let got = rig.take(A);
    assert!(got.contains(&stopped), "{got:?}");
    let alarm = |got: Got| {
        if let Got::Alarm(mode, alarm) = got {
            Some((mode, alarm))
        } else {
            None
        }
    };
    let alarms: Vec<(AlarmMode, Alarm)> = got.into_iter().filter_map(alarm).collect();
    assert_eq!(alarms.len(), 1);
    let (AlarmMode::Active, Alarm::DiskSpaceCritical { description }) = &alarms[0] else {
        panic!("{alarms:?}")
    };
    // Alarm 1 comes while there is room, and logging goes on.
    let percent: f64 = description
        .split(' ')
        .next()
        .and_then(|number| number.parse().ok())
        .expect("a number");
    assert!((24.0..=25.0).contains(&percent), "{description}");
    assert!(rig.has_event(&PlcEventKind::LogStopped(LogStop::DiskFull)));
    assert!(rig.open_files().is_empty());
    let total: usize = rig.files.values().map(Vec::len).sum();
    assert!((2_900_000..=4_000_000).contains(&total), "{total}");
    for bytes in rig.files.values() {
        assert_eq!(read(bytes).last().map(|last| last.0), Some(7300));
    }
    rig.tell(A, Command::Logging { on: true });
    assert_eq!(rig.take(A)[0], rejected(CommandId::Logging));
    // Somebody makes room.
    rig.plc.set_disk_free(rig.now, 9_000_000);
    rig.drain();
    let alarms = rig.alarms(A);
    assert!(
        matches!(alarms[0], (AlarmMode::Clear, Alarm::DiskSpaceCritical { .. })),
        "{alarms:?}"
    );
    assert_eq!(alarms[1], (AlarmMode::Clear, Alarm::AllClear {}));
    rig.tell(A, Command::Logging { on: true });
    assert_eq!(rig.take(A)[0], accepted(CommandId::Logging));
}

#[test]
fn a_driver_that_cannot_write_ends_logging() {
    for (failure, why, alarms) in [
        (FileFailure::Full, LogStop::DiskFull, 1),
        (FileFailure::Other, LogStop::Failed, 0),
    ] {
        let mut rig = pinging("");
        rig.tell(A, Command::Logging { on: true });
        rig.take(A);
        rig.run(1.0);
        let Some(FileEffect::Append { file, .. }) = rig.effects.last() else {
            panic!()
        };
        rig.plc.file_failed(rig.now, *file, failure);
        rig.drain();
        assert!(rig.has_event(&PlcEventKind::LogStopped(why)) && rig.open_files().is_empty());
        let got = rig.take(A);
        let count = |of: fn(&Got) -> bool| got.iter().filter(|got| of(got)).count();
        assert_eq!(count(|got| matches!(got, Got::Alarm(..))), alarms);
        let off = |got: &Got| matches!(got, Got::Status(Status::FileDetails { on: false, .. }));
        assert_eq!(count(off), 1, "{got:?}");
        assert!(!details(&mut rig).0);
    }
}

#[test]
fn the_files_of_an_earlier_run_keep_their_names() {
    let mut rig = pinging("");
    for name in ["20261123_140005_0000.s7k", "20261123_140005_0001.s7k", "survey.s7k"] {
        rig.plc.keep_file(FilePlace {
            folder: Some("D:\\data".to_owned()),
            name: name.to_owned(),
        });
    }
    rig.tell(A, Command::Logging { on: true });
    rig.run(1.0);
    assert_eq!(details(&mut rig).1, "D:\\data\\20261123_140005-2_0000.s7k");
    let name = Box::from("survey");
    rig.tell(A, Command::Switch { name });
    assert_eq!(rig.take(A)[0], rejected(CommandId::Switch));
}

#[test]
fn a_file_that_may_not_grow_counts_as_a_full_disk() {
    for kind in [
        std::io::ErrorKind::FileTooLarge,
        std::io::ErrorKind::StorageFull,
        std::io::ErrorKind::QuotaExceeded,
    ] {
        assert_eq!(FileFailure::from(&std::io::Error::from(kind)), FileFailure::Full);
    }
    let other = std::io::Error::from(std::io::ErrorKind::PermissionDenied);
    assert_eq!(FileFailure::from(&other), FileFailure::Other);
}

#[test]
fn the_state_of_logging_has_the_name_of_the_next_file_wherever_one_is_known() {
    let mut rig = pinging("");
    rig.tell(A, Command::Logging { on: true });
    rig.run(1.0);
    let name = Box::from("survey");
    rig.tell(A, Command::Switch { name });
    assert_eq!(details(&mut rig), (true, "D:\\data\\survey.s7k".to_owned(), 0.0));
    rig.run(1.0);
    let (on, file, size_mb) = details(&mut rig);
    assert_eq!((on, file.as_str()), (true, "D:\\data\\survey.s7k"));
    assert!(size_mb > 0.0);
    let folder = Box::from("E:\\x");
    rig.tell(A, Command::Path { folder });
    let (on, file, size_mb) = details(&mut rig);
    assert_eq!(
        (on, file.starts_with("E:\\x\\survey"), size_mb),
        (true, true, 0.0),
        "{file}"
    );
    rig.run(1.0);
    assert_eq!(details(&mut rig).1, file);
}

#[test]
fn a_disk_without_room_is_critical_whatever_part_of_it_is_left() {
    let disk = "disk = { capacity_mb = 10, used_mb = 6, critical_percent = 0 }";
    let mut rig = pinging(disk);
    rig.tell(A, Command::Logging { on: true });
    rig.take(A);
    rig.run(40.0);
    let alarms = rig.alarms(A);
    assert!(
        matches!(alarms[..], [(AlarmMode::Active, Alarm::DiskSpaceCritical { .. })]),
        "{alarms:?}"
    );
    assert!(rig.has_event(&PlcEventKind::LogStopped(LogStop::DiskFull)));
}

/// Version, flags and type of each record of the one file of a run, and its identifiers.
fn one_file(table: &str, seed: u64, later_s: u64) -> (Vec<(u16, u16, u32)>, [u64; 4]) {
    let config = toml::from_str(table).expect("a table");
    let utc = Utc::from_unix_nanos(START.as_unix_nanos() + later_s * 1_000_000_000);
    let plc = Plc::new(&config, seed, utc, &Stored::default()).expect("a controller");
    let mut rig = Rig::of(plc);
    rig.pose();
    rig.run(6.0);
    rig.plc.shut_down(rig.now);
    rig.drain();
    let bytes = rig.files.values().next().expect("a file");
    read(bytes);
    let mut reader = FileReader::new(Cursor::new(bytes));
    let (mut records, mut identifiers) = (Vec::new(), [0; 4]);
    while let Some(item) = reader.next().expect("memory") {
        let FileItem::Record { frame, .. } = item else { panic!() };
        let header = frame.header();
        records.push((header.version, header.flags, header.record_type));
        if let Ok(Record::FileHeader(record)) = Record::read(&frame) {
            let header = record.header;
            identifiers = [
                header.file_id_1,
                header.file_id_2,
                header.session_id_1,
                header.session_id_2,
            ];
        }
    }
    (records, identifiers)
}

#[test]
fn the_frames_of_a_file_are_of_one_version_and_recorded_where_the_version_says_so() {
    for (version, flags) in [(4, 1), (5, 0x8001)] {
        let table = format!("protocol_version = {version}\nauto_start = true");
        let (records, _) = one_file(&table, 7, 0);
        assert!(records.len() > 10);
        for (number, record) in records.iter().enumerate() {
            let own = number == 0 || number == records.len() - 1;
            assert_eq!(
                (record.0, record.1),
                (version, if own { 1 } else { flags }),
                "{record:?}"
            );
        }
    }
}

#[test]
fn runs_that_start_at_other_times_have_other_identifiers() {
    let identifiers = |seed, later_s| one_file("auto_start = true", seed, later_s).1;
    let first = identifiers(7, 0);
    assert_eq!(first, identifiers(7, 0));
    for other in [identifiers(7, 1), identifiers(8, 0)] {
        assert_ne!(first[0], other[0], "the file");
        assert_ne!(first[2..], other[2..], "the session");
    }
}
