//! What each tool says of the survey, whole and damaged.

use std::io::Cursor;
use std::path::PathBuf;

use backseat_s7k::file::{FileItem, Frames, Index};
use backseat_s7k::{DeviceId, FRAME_LIMIT, FrameHeader, FrameWriter};
use backseat_s7k_tools::{Catalogue, Info, Selection, Source, cut, dump, info, verify, write_info};
use serde_json::Value;
use tempfile::TempDir;

use crate::compose;

/// A folder with the survey's bytes in a file.
pub(crate) fn recording(bytes: &[u8]) -> (TempDir, PathBuf) {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("dive.s7k");
    std::fs::write(&path, bytes).unwrap();
    (folder, path)
}

fn info_of(bytes: &[u8]) -> (Info, String) {
    let (_folder, path) = recording(bytes);
    let source = Source::open(&path).unwrap();
    let info = info(&source).unwrap();
    let mut out = Vec::new();
    write_info(&info, &source, false, &mut out).unwrap();
    let text = String::from_utf8(out)
        .unwrap()
        .replace(path.to_str().unwrap(), "dive.s7k");
    (info, text)
}

fn dumped(bytes: &[u8], selection: &Selection, samples: bool) -> Vec<Value> {
    let (_folder, path) = recording(bytes);
    let mut out = Vec::new();
    dump(&Source::open(&path).unwrap(), selection, samples, &mut out).unwrap();
    let text = String::from_utf8(out).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

fn findings(bytes: &[u8]) -> (Vec<String>, String, bool) {
    let (_folder, path) = recording(bytes);
    let mut out = Vec::new();
    let verdict = verify(&Source::open(&path).unwrap(), false, &mut out).unwrap();
    let text = String::from_utf8(out).unwrap();
    (
        text.lines().map(str::to_owned).collect(),
        verdict.to_string(),
        verdict.is_right(),
    )
}

#[test]
fn info_counts_a_whole_survey() {
    let bytes = compose::clean();
    let (info, text) = info_of(&bytes);
    println!("{text}");
    let group = |record_type: u32, device: u32| {
        info.groups
            .iter()
            .find(|group| (group.record_type, group.device) == (record_type, device))
            .unwrap()
    };
    // 480 pings of the high frequency but for a pause of 3 s, 240 of the low one, 120 traces, 61 and 7 of the vehicle, 4
    // of the controller, header and catalogue.
    assert_eq!(info.records, 456 + 240 + 120 + 61 + 7 + 4 + 2);
    assert_eq!(info.bytes, bytes.len() as u64);
    let high = group(3000, 11_002);
    assert_eq!(
        (high.records, high.missing, high.time_gaps.count, high.count_gaps.count),
        (456, 24, 1, 1)
    );
    let gap = high.time_gaps.first[0];
    assert!((gap.seconds - 3.125).abs() < 1e-4, "{gap:?}");
    assert_eq!(gap.from.to_string(), "2026-11-23T14:00:39.875Z");
    assert_eq!((high.count_gaps.first[0].from, high.count_gaps.first[0].to), (320, 345));
    assert!((high.interval_s.unwrap() - 0.125).abs() < 1e-4);
    let low = group(3000, 11_001);
    assert_eq!((low.records, low.missing, low.time_gaps.count), (240, 0, 0));
    assert!((low.rate_hz.unwrap() - 4.0).abs() < 1e-4);
    assert_eq!((info.header_layouts.spec, info.header_layouts.padded), (456 + 120, 240));
    assert_eq!(
        info.protocol_versions.into_iter().collect::<Vec<_>>(),
        [(4, 650), (5, 240)]
    );
    assert_eq!(
        (info.checksums.valid, info.checksums.wrong.count, info.damage.bytes),
        (890, 0, 0)
    );
    assert_eq!(
        (info.bluefin_checksums.whole_packet, info.bluefin_checksums.data_only),
        (305, 7)
    );
    assert!(matches!(info.catalogue, Catalogue::Matches { entries: 889, .. }));
    assert_eq!(info.first.unwrap().to_string(), "2026-11-23T14:00:00.000Z");
    assert_eq!(info.last.unwrap().to_string(), "2026-11-23T14:01:00.500Z");
    for line in [
        "dive.s7k: 890 records, ",
        "file header: recorded by \"PLC\" 1.02.03, name \"survey\", notes \"a block to starboard\"",
        "sonar headers: 576 of 20 bytes, 240 of 32 bytes",
        "3000 of device 11002: gap of 3.125 s after 2026-11-23T14:00:39.875Z (usually 0.125 s), byte ",
        "3000 of device 11002: record count 345 follows 320, byte ",
        "3000 of device 11002: 24 records missing by the record counts",
        "checksums: 890 right, 0 wrong; 0 not claimed but right, 0 not claimed and not right",
        "right (889 entries)",
        "damage: none",
    ] {
        assert!(text.contains(line), "{line}\n{text}");
    }
}

#[test]
fn info_finds_every_fault_of_a_damaged_survey() {
    let (bytes, faults) = compose::damaged();
    let (info, text) = info_of(&bytes);
    println!("{text}");
    assert_eq!(info.checksums.wrong.count, 1);
    assert_eq!(info.checksums.wrong.first[0].offset, faults.wrong_checksum as u64);
    assert_eq!((info.checksums.unclaimed_right, info.checksums.unclaimed_wrong), (1, 1));
    let places: Vec<(u64, u64)> = info
        .damage
        .places
        .first
        .iter()
        .map(|place| (place.offset, place.bytes))
        .collect();
    let end = bytes.len() - faults.cut;
    let expected = [
        (faults.overwritten.0, faults.overwritten.1),
        (faults.noise, 100),
        (end, faults.cut),
    ];
    assert_eq!(places, expected.map(|(at, bytes)| (at as u64, bytes as u64)));
    assert!(
        matches!(info.catalogue, Catalogue::NotThere { .. }),
        "{:?}",
        info.catalogue
    );
    for part in [
        "damage: ",
        "in 3 places",
        "1 wrong; 1 not claimed but right, 1 not claimed and not right",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
}

#[test]
fn verify_finds_nothing_in_a_whole_survey() {
    let (lines, verdict, right) = findings(&compose::clean());
    assert_eq!(
        (lines, verdict.as_str(), right),
        (vec![], "890 records: nothing wrong", true)
    );
}

#[test]
fn verify_has_a_line_with_its_place_for_each_fault() {
    let (bytes, faults) = compose::damaged();
    let (lines, verdict, right) = findings(&bytes);
    println!("{}", lines.join("\n"));
    assert!(!right);
    let begins = [
        format!("byte {}: record 3000 of 4388 bytes: checksum ", faults.wrong_checksum),
        format!(
            "byte {}: record 3100: NavigationFrame field latitude_rad: 3 is outside its range (-1.57",
            faults.value
        ),
        format!(
            "byte {}: {} bytes are not a record: no frame starts here",
            faults.overwritten.0, faults.overwritten.1
        ),
        format!(
            "byte {}: 100 bytes are not a record: no frame starts here",
            faults.noise
        ),
        format!(
            "byte {}: 500 bytes are not a record: the frame ends after 500 of ",
            bytes.len() - 500
        ),
        "byte 0: the file header names a catalogue at byte ".to_owned(),
    ];
    assert_eq!(lines.len(), begins.len());
    for (line, begin) in lines.iter().zip(begins) {
        assert!(line.starts_with(&begin), "{line}\n{begin}");
    }
    assert_eq!(
        verdict,
        "888 records: 3 damaged places, 1 wrong checksum, 1 value outside its range, 1 difference in the catalogue"
    );
}

#[test]
fn verify_compares_each_entry_of_the_catalogue() {
    let mut bytes = compose::clean();
    let index = Index::scan(Cursor::new(&bytes)).unwrap();
    let catalog = usize::try_from(index.entries.last().unwrap().offset).unwrap();
    let entry = |number: usize| catalog + 64 + 14 + 48 * number;
    // Entry 3 has another size, entry 5 another type, entry 7 points one byte too far.
    bytes[entry(3)] ^= 1;
    bytes[entry(5) + 12] ^= 1;
    bytes[entry(7) + 4] += 1;
    let end = bytes.len() - 4;
    let sum = backseat_s7k::byte_sum(&bytes[catalog..end]);
    bytes[end..].copy_from_slice(&sum.to_le_bytes());
    let (lines, _, right) = findings(&bytes);
    assert!(!right && lines.len() == 4, "{lines:#?}");
    assert!(
        lines[0].starts_with(&format!("byte {}: catalogue entry 3: size ", entry(3))),
        "{lines:#?}"
    );
    assert!(
        lines[1].contains("catalogue entry 5: type ") && lines[1].contains("in the record at byte "),
        "{lines:#?}"
    );
    let (_, at) = (0, index.entries[7].offset);
    assert_eq!(
        lines[2],
        format!(
            "byte {at}: a record of type {} is not in the catalogue",
            index.entries[7].record_type
        )
    );
    assert_eq!(
        lines[3],
        format!(
            "byte {}: catalogue entry 7: it points to byte {}, where no record begins",
            entry(7),
            at + 1
        )
    );
}

#[test]
fn dump_has_each_record_with_its_frame_and_its_fields() {
    let bytes = compose::clean();
    let all = dumped(&bytes, &Selection::default(), false);
    assert_eq!(all.len(), 890);
    assert_eq!(all[0]["record"]["header"]["recorder"], "PLC");
    assert_eq!(all[0]["record"]["devices"][2]["device"], 11_002);
    assert_eq!(all[889]["record"]["entries"].as_array().unwrap().len(), 889);
    let of = |record_type: u32| {
        all.iter()
            .find(|line| line["frame"]["record_type"] == record_type)
            .unwrap()
    };
    let ping = of(3000);
    assert_eq!(ping["utc"], "2026-11-23T14:00:00.000000Z");
    assert_eq!(ping["checksum"]["state"], "valid");
    assert_eq!(ping["record"]["channels"][1]["header"]["side"], "starboard");
    assert_eq!(ping["record"]["channels"][1]["header"]["name"], "starboard");
    assert!(ping["record"]["channels"][1].get("samples").is_none());
    assert_eq!(ping["record"]["optional"]["side_scan"][1]["weighting_factor"], 12);
    assert_eq!(of(3001)["record"]["optional"]["segy"][0]["source_x"], -255_240);
    let navigation = &of(3100)["record"]["frames"][4];
    assert_eq!(
        (&navigation["quality_bits"], &navigation["header"]["data_type"]),
        (&131_071.into(), &"navigation".into())
    );
    assert_eq!(navigation["navigation"]["position_time_s"], 0.8);
    assert_eq!(of(11_000)["record"]["text"], "1");
    assert_eq!(of(11_001)["record"]["header"]["status"], "accepted");
    assert_eq!(of(11_002)["record"]["text"], "Logging = 1, dive.s7k, 0.001");
    assert_eq!(of(7400)["record"]["header"]["leap_second_offset_s"], 37);
}

#[test]
fn dump_gives_samples_and_ranges_if_they_are_wanted() {
    let bytes = compose::clean();
    let selection = Selection {
        types: vec![3001],
        from: Some("2026-11-23T14:00:10Z".parse().unwrap()),
        to: Some("2026-327T14:00:11".parse().unwrap()),
        ..Selection::default()
    };
    let lines = dumped(&bytes, &selection, true);
    assert_eq!(lines.len(), 2);
    let expected = serde_json::to_value(compose::trace(10.5)).unwrap();
    assert_eq!(lines[1]["record"]["channels"][0]["samples"], expected);
    let device = Selection {
        devices: vec![11_001],
        ..Selection::default()
    };
    let lines = dumped(&bytes, &device, true);
    assert_eq!(
        (lines.len(), lines[0]["record"]["layout"].as_str()),
        (240, Some("padded"))
    );
    // Samples with sign.
    let samples = lines[0]["record"]["channels"][0]["samples"].as_array().unwrap();
    assert!(samples.len() == 1000 && samples[500].as_i64().unwrap() > 0 && samples[501].as_i64().unwrap() < 0);
}

#[test]
fn dump_goes_on_behind_damage_and_says_where_it_is() {
    let (bytes, faults) = compose::damaged();
    let lines = dumped(&bytes, &Selection::default(), false);
    let damage: Vec<&Value> = lines.iter().filter(|line| line.get("bytes").is_some()).collect();
    assert_eq!(lines.len(), 888 + 3);
    assert_eq!(
        (&damage[1]["offset"], &damage[1]["bytes"]),
        (&faults.noise.into(), &100.into())
    );
    assert!(damage[1]["error"].as_str().unwrap().starts_with("no frame starts here"));
    let states = |state: &str| lines.iter().filter(|line| line["checksum"]["state"] == state).count();
    assert_eq!(
        (states("wrong"), states("unclaimed_right"), states("unclaimed_wrong")),
        (1, 1, 1)
    );
}

#[test]
fn cut_writes_a_whole_file_with_the_same_records() {
    let bytes = compose::clean();
    let (folder, path) = recording(&bytes);
    let out = folder.path().join("cut.s7k");
    let selection = Selection {
        types: vec![3000, 3100],
        devices: vec![11_002, 11_100],
        from: Some("2026-11-23T14:00:20Z".parse().unwrap()),
        to: Some("2026-11-23T14:00:25Z".parse().unwrap()),
    };
    let source = Source::open(&path).unwrap();
    let done = cut(&source, &selection, &out).unwrap();
    let written = std::fs::read(&out).unwrap();
    // 40 pings, 5 records of navigation, one of environment.
    assert_eq!((done.records, done.bytes, done.damage), (46, written.len() as u64, 0));
    let (lines, verdict, right) = findings(&written);
    assert!(right, "{lines:?} {verdict}");
    let (info, text) = info_of(&written);
    assert!(matches!(info.catalogue, Catalogue::Matches { entries: 47, .. }));
    let header = info.file_header.unwrap();
    assert_eq!(
        (header.recorder.as_str(), header.notes.as_str()),
        ("PLC", "a block to starboard")
    );
    assert_eq!(header.devices, [(11_002, 0), (11_100, 0), (11_100, 1)]);
    assert!(
        text.contains("2026-11-23T14:00:20.000Z to 2026-11-23T14:00:24.875Z"),
        "{text}"
    );
    // Byte for byte.
    let records = |bytes: &[u8]| -> Vec<Vec<u8>> {
        let frames = Frames::new(bytes).map(|item| match item {
            FileItem::Record { frame, .. } => frame,
            FileItem::Skipped(skipped) => panic!("{skipped}"),
        });
        let meant = frames.filter(|frame| selection.contains(frame.header()));
        meant.map(|frame| frame.bytes().to_vec()).collect()
    };
    assert_eq!(records(&written), records(&bytes));
    // The same cut again is the same file; another has another identity.
    cut(&source, &selection, &out).unwrap();
    assert_eq!(std::fs::read(&out).unwrap(), written);
    let all = Selection::default();
    cut(&source, &all, &out).unwrap();
    assert_ne!(std::fs::read(&out).unwrap()[64..80], written[64..80]);
}

#[test]
fn a_link_keeps_its_place_and_what_it_names_is_written() {
    let (folder, path) = recording(&compose::clean());
    let (target, link) = (folder.path().join("part.s7k"), folder.path().join("link.s7k"));
    std::fs::write(&target, b"before").unwrap();
    std::os::unix::fs::symlink(&target, &link).unwrap();
    let selection = Selection {
        types: vec![3001],
        ..Selection::default()
    };
    cut(&Source::open(&path).unwrap(), &selection, &link).unwrap();
    assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
    let (info, _) = info_of(&std::fs::read(&target).unwrap());
    assert_eq!(info.records, 122);
}

#[test]
fn a_cut_has_the_protocol_version_of_its_records() {
    for version in [4_u16, 5] {
        let (mut bytes, mut records) = (Vec::new(), Vec::new());
        let header = FrameHeader::new(9000, DeviceId(7)).at(compose::time(1.0));
        let header = if version == 5 { header.version_5() } else { header };
        FrameWriter::begin(header, &mut bytes).finish(FRAME_LIMIT).unwrap();
        let (folder, path) = recording(&bytes);
        let out = folder.path().join("cut.s7k");
        cut(&Source::open(&path).unwrap(), &Selection::default(), &out).unwrap();
        let written = std::fs::read(&out).unwrap();
        let mut rest = &written[..];
        while let Ok(frame) = backseat_s7k::Frame::read(rest, FRAME_LIMIT) {
            records.push((frame.header().record_type, frame.header().version));
            rest = &rest[frame.bytes().len()..];
        }
        assert_eq!(records, [(7200, version), (9000, version), (7300, version)]);
    }
}

#[test]
fn a_cut_without_records_says_what_there_is_and_writes_nothing() {
    let (folder, path) = recording(&compose::clean());
    let out = folder.path().join("cut.s7k");
    let selection = Selection {
        from: Some("2027-01-01T00:00".parse().unwrap()),
        ..Selection::default()
    };
    let error = cut(&Source::open(&path).unwrap(), &selection, &out)
        .unwrap_err()
        .to_string();
    let expected = format!(
        "{}: no record matches: its records are from 2026-11-23T14:00:00.000Z to 2026-11-23T14:01:00.500Z; see \
         `backseat s7k info` for types and devices",
        path.display()
    );
    assert_eq!(error, expected);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn a_catalogue_longer_than_any_other_record_is_read() {
    // 350,000 records have a catalogue of 16 MiB and more.
    let record = {
        let mut out = Vec::new();
        let header = FrameHeader::new(9000, DeviceId(7)).at(compose::time(1.0));
        FrameWriter::begin(header, &mut out).finish(FRAME_LIMIT).unwrap();
        out
    };
    let bytes = compose::file(&vec![record; 350_000]);
    let (info, _) = info_of(&bytes);
    assert!(
        matches!(info.catalogue, Catalogue::Matches { entries: 350_001, .. }),
        "{:?}",
        info.catalogue
    );
    assert_eq!((info.records, info.damage.bytes), (350_002, 0));
    let (lines, verdict, right) = findings(&bytes);
    assert!(right, "{} {verdict}", lines.len());
}

/// A recording whose pings nobody can place is right, and useless: people are told.
#[test]
fn navigation_that_does_not_meet_the_pings_is_a_warning() {
    let keep = |keep: &dyn Fn(u32, usize) -> bool| {
        let records = compose::records().into_iter().enumerate();
        let records: Vec<_> = records
            .filter(|(number, record)| keep(u32::from_le_bytes(record[32..36].try_into().unwrap()), *number))
            .map(|(_, record)| record)
            .collect();
        compose::file(&records)
    };
    let (_, verdict, right) = findings(&keep(&|record_type, _| record_type != 3100));
    assert!(
        right && verdict.contains("warning: the pings have no navigation"),
        "{verdict}"
    );
    let third = compose::records().len() / 3;
    let apart = keep(&|record_type, number| match record_type {
        3100 => number < third,
        _ => number > 2 * third,
    });
    let (_, verdict, right) = findings(&apart);
    assert!(
        right && verdict.contains("navigation and pings do not overlap in time: positions from"),
        "{verdict}"
    );
    let (info, text) = info_of(&apart);
    assert!(
        info.warning.is_some() && text.contains("warning: navigation and pings do not overlap"),
        "{text}"
    );
    assert_eq!(info_of(&compose::clean()).0.warning, None);
}
