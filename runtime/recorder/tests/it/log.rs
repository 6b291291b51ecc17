//! What is written to a log can be read back.
#![expect(
    clippy::unwrap_used,
    reason = "a test may panic, and so may the functions that it calls"
)]

use std::io::Cursor;
use std::path::Path;
use std::time::Duration;

use backseat_core::plugin::{
    GpsHitRequest, ModifyRequest, PositionRequest, Request, Returned, SonarAngleRequest, SonarSetRequest, SonarSetting,
    StationTarget, TrackcircleRequest, TracklineRequest, VerticalRequest,
};
use backseat_core::{ExternalId, Input, Output};
use backseat_recorder::{
    COMPONENT_LIMIT, Channel, Encoder, Entry, Header, LogReader, LoggedInput, Rate, Record, Recorder, RecorderError,
    Remark, Sources, encode_input, parse, read,
};
use backseat_units::{EastNorth, LocalFrame, Timestamp};
use proptest::prelude::*;
use serde_json::json;

use crate::sample::{UTC, header, inputs, navigation, outputs, recorded, returned, start, station};

#[test]
fn every_input_comes_back_in_handle_order() {
    let (start, inputs) = (start(), inputs());
    let bytes = recorded(Rate::Simulation, |recorder| {
        recorder.start(&start).unwrap();
        for (index, input) in inputs.iter().enumerate() {
            recorder
                .input(Timestamp::from_millis(100 * index as u64), input)
                .unwrap();
        }
    });
    let log = parse(&bytes).unwrap();
    assert!(log.complete);
    assert_eq!(log.start(), Some(start));
    let back: Vec<_> = log.inputs().map(|(now, input)| (now, input.as_input())).collect();
    let expected: Vec<_> = inputs
        .into_iter()
        .enumerate()
        .map(|(index, input)| (Timestamp::from_millis(100 * index as u64), input))
        .collect();
    assert_eq!(back, expected);
    let sequences: Vec<_> = log.entries.iter().map(|entry| entry.sequence).collect();
    // Derived channels, which are not read, take numbers too.
    assert_eq!(sequences.len(), back.len() + 1);
    assert!(sequences.is_sorted_by(|one, next| one < next), "{sequences:?}");
}

proptest! {
    /// The replay of a step must give core the exact bits that the plugin returned.
    #[test]
    fn numbers_survive_bit_for_bit(heading_deg in any::<f64>(), speed_mps in any::<f64>(), depth_m in any::<f64>()) {
        let request = ModifyRequest {
            tag: 1,
            heading_deg,
            vertical: VerticalRequest::DepthM(depth_m),
            speed_mps,
            duration: Duration::from_secs(5),
        };
        let bytes = recorded(Rate::Simulation, |recorder| {
            recorder.input(Timestamp::ZERO, &returned(vec![Request::Modify(request)])).unwrap();
        });
        let log = parse(&bytes).unwrap();
        let Some((_, LoggedInput::Returned(_, Returned { result: Ok(requests), .. }))) = log.inputs().next() else {
            panic!("no step returned: {log:?}");
        };
        let [Request::Modify(back)] = requests.as_slice() else { panic!("{requests:?}") };
        let VerticalRequest::DepthM(back_m) = back.vertical else { panic!("{back:?}") };
        for (was, is) in [(heading_deg, back.heading_deg), (speed_mps, back.speed_mps), (depth_m, back_m)] {
            prop_assert!(was.to_bits() == is.to_bits() || was.is_nan() && is.is_nan(), "{was:e} {is:e}");
        }
    }

    /// The same for the numbers in requests other than modifies.
    #[test]
    fn numbers_of_every_request_survive_bit_for_bit(figures in proptest::array::uniform7(any::<f64>())) {
        let [x_m, y_m, depth_m, speed_mps, angle_deg, latitude_deg, longitude_deg] = figures;
        let bottom = StationTarget::Bottom { x_m, y_m, vertical: VerticalRequest::DepthM(depth_m) };
        let hull = StationTarget::Hull { horizontal_m: x_m, vertical_m: y_m, distance_m: depth_m };
        let position = PositionRequest { latitude_deg, longitude_deg };
        let asked = vec![
            station(bottom, Some(speed_mps)),
            station(hull, Some(speed_mps)),
            Request::SonarAngle(SonarAngleRequest { tag: 1, angle_deg }),
            Request::GpsHit(GpsHitRequest { tag: 2, position }),
            Request::Trackline(TracklineRequest {
                tag: 3,
                start: position,
                end: position,
                vertical: VerticalRequest::AltitudeM(depth_m),
                speed_mps,
                interrupt: false,
            }),
            Request::Trackcircle(TrackcircleRequest {
                tag: 4,
                centre: position,
                radius_m: x_m,
                orbits: y_m,
                vertical: VerticalRequest::DepthM(depth_m),
                speed_mps,
                entry_angle_deg: Some(angle_deg),
                interrupt: true,
            }),
            Request::SonarSet(SonarSetRequest { tag: 5, sensor: 1, setting: SonarSetting::PowerPercent(x_m) }),
        ];
        let bytes = recorded(Rate::Simulation, |recorder| {
            recorder.input(Timestamp::ZERO, &returned(asked.clone())).unwrap();
        });
        let log = parse(&bytes).unwrap();
        let Some((_, LoggedInput::Returned(_, Returned { result: Ok(requests), .. }))) = log.inputs().next() else {
            panic!("no step returned: {log:?}");
        };
        // `Debug` writes the shortest decimal that parses to the same number, with its sign, and NaN whatever its bits.
        prop_assert_eq!(format!("{requests:?}"), format!("{asked:?}"));
    }

    /// Core must be given the exact bytes that were read, and the oracle the exact bytes that were written.
    #[test]
    fn bytes_of_the_link_survive(
        read in prop::collection::vec(any::<u8>(), 0..64),
        text in "\\PC{0,16}[\\x00-\\x7f]{0,16}",
    ) {
        let bytes = recorded(Rate::Deployed, |recorder| {
            for bytes in [read.as_slice(), text.as_bytes()] {
                recorder.input(Timestamp::ZERO, &Input::Received(bytes)).unwrap();
                recorder.output(Timestamp::ZERO, &Output::Send(bytes.to_vec())).unwrap();
                recorder.input(Timestamp::ZERO, &Input::External(ExternalId(3), bytes)).unwrap();
            }
        });
        let log = parse(&bytes).unwrap();
        let link: Vec<_> = log.link().map(|(_, _, bytes)| bytes).collect();
        let (read, text) = (read.as_slice(), text.as_bytes());
        prop_assert_eq!(link, [read, read, text, text]);
        let external: Vec<_> = log.inputs().filter_map(|(_, input)| {
            let LoggedInput::External(ExternalId(3), bytes) = input else { return None };
            Some(bytes.as_slice())
        }).collect();
        prop_assert_eq!(external, [read, text]);
    }

    /// With any bytes damaged. The format allows a checksum of zero to mean that there is none, so zeros disable checks.
    #[test]
    fn sr_013_no_bytes_make_the_reader_panic(
        cut in any::<prop::sample::Index>(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<[u8; 4]>(), 1usize..=4), 1..8),
    ) {
        let mut bytes = short_log();
        let places = outside_of_schemas(&bytes);
        for (at, with, count) in changes {
            let at = places[at.index(places.len() - count)];
            bytes[at..at + count].copy_from_slice(&with[..count]);
        }
        bytes.truncate(bytes.len() / 2 + cut.index(bytes.len() / 2));
        let _ = parse(&bytes);
    }
}

/// A log with an attachment and one chunk.
fn short_log() -> Vec<u8> {
    recorded(Rate::Deployed, |recorder| {
        recorder
            .input(Timestamp::ZERO, &Input::Received(b"$BFVER\r\n"))
            .unwrap();
    })
}

/// The places of a log's bytes that are not in the text of a schema: most are, and the reader passes over them. Of each
/// schema the first and the last bytes are among them.
fn outside_of_schemas(bytes: &[u8]) -> Vec<usize> {
    const EDGE: usize = 4;
    let mut places = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let texts = Channel::ALL.into_iter().map(|channel| channel.schema().1.as_bytes());
        let here = texts
            .filter(|text| bytes[at..].starts_with(text))
            .map(<[u8]>::len)
            .max();
        let length = here.unwrap_or(1);
        places.extend((at..at + length).filter(|place| place - at < EDGE || at + length - place <= EDGE));
        at += length;
    }
    places
}

#[test]
fn no_single_byte_makes_the_reader_panic() {
    let mut bytes = short_log();
    for at in outside_of_schemas(&bytes) {
        let was = bytes[at];
        for with in [
            0,
            1,
            0x7f,
            0xff,
            was ^ 1,
            was ^ 0x80,
            was.wrapping_add(1),
            was.wrapping_sub(1),
        ] {
            bytes[at] = with;
            let _ = parse(&bytes);
        }
        bytes[at] = was;
    }
}

/// A log whose process was killed is read up to where it ends. A damaged one must not look like one.
#[test]
fn a_log_with_a_flipped_bit_is_refused_or_has_the_same_messages() {
    let mut bytes = short_log();
    // Their times count from a time in the metadata, which has no checksum of its own.
    let messages = |log: &backseat_recorder::Log| {
        let messages = log.entries.iter().map(|entry| (entry.sequence, &entry.record));
        format!("{:?}", messages.collect::<Vec<_>>())
    };
    let whole = messages(&parse(&bytes).unwrap());
    let mut refused = 0;
    for at in outside_of_schemas(&bytes) {
        for bit in [0x01, 0x10, 0x80] {
            bytes[at] ^= bit;
            match parse(&bytes) {
                Ok(log) => assert_eq!(messages(&log), whole, "byte {at}"),
                Err(error) => {
                    refused += 1;
                    assert!(!error.to_string().contains(char::is_control), "byte {at}: {error}");
                }
            }
            bytes[at] ^= bit;
        }
    }
    assert!(refused > 1000, "{refused}");
}

#[test]
fn a_file_cut_anywhere_reads_up_to_the_cut() {
    let bytes = short_log();
    for length in outside_of_schemas(&bytes) {
        match parse(&bytes[..length]) {
            Ok(log) => assert!(log.entries.len() <= 1, "{length}"),
            Err(error) => assert!(
                matches!(error, RecorderError::NotALog { .. } if length < mcap::MAGIC.len())
                    || matches!(error, RecorderError::Foreign { .. }),
                "{length}: {error}"
            ),
        }
    }
}

#[test]
fn outputs_go_to_their_channels() {
    let outputs = outputs();
    let write = |recorder: &mut Recorder<&mut Cursor<Vec<u8>>>| {
        for output in &outputs {
            recorder.output(Timestamp::ZERO, output).unwrap();
        }
        recorder.vehicle_event(Timestamp::ZERO, "began trackline").unwrap();
    };
    let log = parse(&recorded(Rate::Simulation, write)).unwrap();
    let records: Vec<_> = log.entries.iter().map(|entry| &entry.record).collect();
    assert_eq!(records[0], &Record::Sent(b"$BPVER\r\n".to_vec()));
    let json = |index: usize| {
        let (Record::Output(json) | Record::Note(json) | Record::Request(json) | Record::Control(json)) =
            records[index]
        else {
            panic!("{index}: {:?}", records[index]);
        };
        json.clone()
    };
    assert_eq!(json(1), json!({"output": "connect", "after_s": 1.5}));
    assert_eq!(json(3), json!({"output": "invoke", "plugin": 2}));
    assert_eq!(
        json(5),
        json!({"output": "reserve", "below": 64, "inserts": 4, "gps_hits": 4})
    );
    assert_eq!(
        json(7),
        json!({"text": "the vehicle's plan has 4 elements", "note": "plan", "elements": 4})
    );
    assert!(matches!(records[8], Record::Request(_)));
    let whose = |index: usize| ["owner", "plugin", "external"].map(|key| json(index)[key].clone());
    assert_eq!(whose(8), [json!("operator"), json!(null), json!(null)]);
    assert_eq!(whose(9), [json!("plugin"), json!(3), json!(null)]);
    assert_eq!(whose(11), [json!("external"), json!(null), json!(1)]);
    assert_eq!(json(9)["state"], "rejected");
    assert_eq!(json(9)["reason"], "tag: an insert with this tag is still open");
    assert_eq!(
        json(9)["why"],
        json!({"rule": "tag", "cause": "tag-open", "state": "tag-open"})
    );
    assert_eq!(json(9)["kind"], "trackline");
    assert!(matches!(records[10], Record::Control(_)));
    assert_eq!(
        json(12),
        json!({"output": "external", "external": 1, "text": "$BFACK\r\n"})
    );
    assert_eq!(
        json(13),
        json!({"output": "sonar", "order": "vehicle-logs", "order_vehicle-logs": true})
    );
    assert_eq!(records[14], &Record::Vehicle("began trackline".into()));
    assert_eq!(log.notes().count(), 5);
    assert_eq!(log.link().count(), 1);

    // At sea the log has the whole input of a step, so that a plugin's author can read it without a replay.
    let log = parse(&recorded(Rate::Deployed, write)).unwrap();
    let Record::Output(invoke) = &log.entries[3].record else {
        panic!("{:?}", log.entries[3]);
    };
    assert_eq!(invoke["step"]["navigation"]["local"]["east_m"], 12.5);
    // The samples of pings are in core's inputs already.
    let ping = &invoke["step"]["events"][1]["is_sidescan"];
    assert_eq!(ping["number"], 8);
    assert_eq!(ping["channels"][0]["samples"], json!([]));
}

#[test]
fn a_simulation_logs_decoded_records_once_a_second_and_a_deployed_run_all() {
    let write = |recorder: &mut Recorder<&mut Cursor<Vec<u8>>>| {
        for tick in 0..100 {
            let now = Timestamp::from_millis(50 + 100 * tick);
            recorder.navigation(now, &navigation(now)).unwrap();
            recorder.truth(now, &json!({"tick": tick})).unwrap();
        }
    };
    let times = |bytes: &[u8]| -> Vec<u64> {
        let log = parse(bytes).unwrap();
        let navigation = log
            .entries
            .iter()
            .filter(|entry| matches!(entry.record, Record::Navigation(_)));
        navigation.map(|entry| entry.now.as_nanos() / 1_000_000).collect()
    };
    let simulation = recorded(Rate::Simulation, write);
    assert_eq!(times(&simulation), (0..10).map(|s| 1000 * s + 50).collect::<Vec<_>>());
    let truths = parse(&simulation).unwrap();
    let truths = truths.entries.iter().filter(|e| matches!(e.record, Record::Truth(_)));
    assert_eq!(truths.count(), 10);
    assert_eq!(times(&recorded(Rate::Deployed, write)).len(), 100);
}

/// The world may have another origin.
#[test]
fn the_truth_is_in_the_frame_of_everything_else() {
    let place = LocalFrame::new(header(Rate::Simulation, &[]).origin).to_position(EastNorth::new(30.0, -40.0));
    let truth = json!({"local": {"east_m": 1.0, "north_m": 2.0}, "position": place, "depth_m": 3.0});
    let bytes = recorded(Rate::Simulation, |recorder| {
        recorder.truth(Timestamp::ZERO, &truth).unwrap();
    });
    let log = parse(&bytes).unwrap();
    let [
        Entry {
            record: Record::Truth(written),
            ..
        },
    ] = &log.entries[..]
    else {
        panic!("{log:?}");
    };
    let local = ["east_m", "north_m"].map(|key| written["local"][key].as_f64().unwrap());
    assert!(
        (local[0] - 30.0).abs() < 1e-3 && (local[1] + 40.0).abs() < 1e-3,
        "{written}"
    );
    assert_eq!(
        (&written["position"], &written["depth_m"]),
        (&truth["position"], &json!(3.0))
    );
}

#[test]
fn a_run_is_named_and_its_files_attached() {
    let components = [
        ("isobath".to_owned(), b"\0asm".to_vec()),
        ("python".to_owned(), vec![7; COMPONENT_LIMIT + 1]),
    ];
    let mut file = Cursor::new(Vec::new());
    let header = Header {
        world: Some("[origin]\n"),
        ..header(Rate::Deployed, &components)
    };
    let recorder = Recorder::new(&mut file, &header).unwrap();
    recorder.finish().unwrap();
    let log = parse(file.get_ref()).unwrap();
    assert_eq!(
        (log.run.mission.as_str(), log.run.seed, log.run.rate),
        ("isobath", Some(7), Rate::Deployed)
    );
    assert_eq!(log.run.utc_at_start.as_unix_nanos(), UTC);
    assert_eq!(log.run.origin, header.origin);
    assert_eq!(log.attachment("world.toml"), Some(b"[origin]\n".as_slice()));
    assert_eq!(
        log.attachment("mission.toml"),
        Some(b"[vehicle]\nname = \"nemo\"\n".as_slice())
    );
    assert_eq!(log.attachment("components/isobath.wasm"), Some(b"\0asm".as_slice()));
    assert_eq!(log.attachment("components/python.wasm"), None, "over the limit");
    // From sha256sum of the four bytes.
    assert_eq!(
        log.run.components["components/isobath.wasm"],
        "cd5d4935a48c0672cb06407bb443bc0087aff947c6b864bac886982c73b3027f"
    );
    assert_eq!(log.run.components["components/python.wasm"].len(), 64);
}

#[test]
fn a_killed_process_loses_its_open_chunk_and_nothing_else() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("killed.mcap");
    let mut recorder = Recorder::create(&path, &header(Rate::Deployed, &[])).unwrap();
    let mut last_on_disk = Timestamp::ZERO;
    for tick in 0..105 {
        let now = Timestamp::from_millis(100 * tick);
        recorder.input(now, &Input::Received(b"$BFNVG\r\n")).unwrap();
        last_on_disk = now;
    }
    // A killed process leaves what the operating system has received, because nothing flushes after the last chunk.
    let killed = std::fs::read(&path).unwrap();
    let log = parse(&killed).unwrap();
    assert!(!log.complete);
    assert_eq!(log.attachments.len(), 2);
    let last = log.inputs().last().unwrap().0;
    assert!(last_on_disk.since(last) <= Duration::from_secs(3), "{last}");
    // Whatever byte it is cut at, all whole chunks can be read.
    let all = log.entries.len();
    let mut counts = Vec::new();
    for cut in (killed.len() / 2..killed.len()).step_by(7) {
        let log = parse(&killed[..cut]).unwrap();
        assert!(!log.complete && log.entries.len() <= all);
        counts.push(log.entries.len());
    }
    assert!(counts.is_sorted() && counts.last().is_some_and(|count| *count > all / 2));
    recorder.finish().unwrap();
    assert_eq!(read(&path).unwrap().entries.len(), 105);
}

#[test]
fn errors_name_the_file_and_what_was_expected() {
    let missing = Path::new("/nonexistent/log.mcap");
    let text = Recorder::create(missing, &header(Rate::Deployed, &[]))
        .err()
        .unwrap()
        .to_string();
    assert!(text.starts_with("cannot create log /nonexistent/log.mcap: "), "{text}");
    assert!(matches!(read(missing), Err(RecorderError::Open { .. })));
    let text = parse(b"not a log at all").err().unwrap().to_string();
    assert_eq!(text, "log in memory is no MCAP file");
    assert!(matches!(
        parse(b""),
        Err(RecorderError::NotALog { what: "is empty", .. })
    ));
    // The format that the first versions wrote.
    let old = replaced(
        &short_log(),
        b"\x06\0\0\0format\x01\0\0\x002",
        b"\x06\0\0\0format\x01\0\0\x001",
    );
    assert_eq!(
        parse(&old).unwrap_err().to_string(),
        "log in memory has format \"1\", and this version reads format 2 only"
    );
    let mut foreign = Cursor::new(Vec::new());
    mcap::Writer::new(&mut foreign).unwrap().finish().unwrap();
    let text = parse(foreign.get_ref()).unwrap_err().to_string();
    assert_eq!(
        text,
        "log in memory is not a backseat log: no metadata, expected a metadata record named backseat"
    );
}

/// The bytes with one part replaced.
fn replaced(bytes: &[u8], part: &[u8], with: &[u8]) -> Vec<u8> {
    let at = bytes.windows(part.len()).position(|window| window == part).unwrap();
    [&bytes[..at], with, &bytes[at + part.len()..]].concat()
}

#[test]
fn the_same_run_gives_the_same_bytes() {
    let write = |recorder: &mut Recorder<&mut Cursor<Vec<u8>>>| {
        recorder.input(Timestamp::ZERO, &Input::LinkUp).unwrap();
        recorder
            .navigation(Timestamp::ZERO, &navigation(Timestamp::ZERO))
            .unwrap();
    };
    assert_eq!(recorded(Rate::Simulation, write), recorded(Rate::Simulation, write));
}

/// What a replay compares has the bytes that the recorder writes.
#[test]
fn an_encoder_writes_what_the_recorder_writes() {
    for rate in [Rate::Simulation, Rate::Deployed] {
        let (inputs, outputs) = (inputs(), outputs());
        let bytes = recorded(rate, |recorder| {
            for input in &inputs {
                recorder.input(Timestamp::ZERO, input).unwrap();
            }
            for output in &outputs {
                recorder.output(Timestamp::ZERO, output).unwrap();
            }
        });
        let mut log = LogReader::new(bytes.as_slice(), "a log".to_owned()).unwrap();
        let mut written = Vec::new();
        while let Some(message) = log.next_message().unwrap() {
            let derived = Channel::from_topic(&message.topic).is_none() && !message.topic.starts_with("/measures/");
            if !derived {
                written.push((message.topic.to_string(), message.data));
            }
        }
        let mut encoder = Encoder::new(rate, Vec::new());
        let mut encoded: Vec<_> = inputs.iter().map(|input| encode_input(input).unwrap()).collect();
        encoded.extend(outputs.iter().filter_map(|output| encoder.output(output).unwrap()));
        let encoded: Vec<_> = encoded
            .into_iter()
            .map(|encoded| (encoded.topic.into_owned(), encoded.data))
            .collect();
        assert_eq!(written, encoded);
    }
}

#[test]
fn a_log_has_what_a_replay_needs_and_no_other_attachment_has() {
    let setup = backseat_core::PluginSetup {
        name: "isobath".to_owned(),
        description: backseat_core::plugin::Description {
            name: "isobath".to_owned(),
            version: "1.2.3".to_owned(),
            step_period: Duration::from_millis(500),
            topics: vec![backseat_core::plugin::Topic::Ctd],
        },
        grants: Vec::new(),
        on_failure: backseat_core::FailAction::default(),
        limits: backseat_core::PluginLimits::default(),
    };
    let mut file = Cursor::new(Vec::new());
    let header = Header {
        sources: Sources {
            plan: Some("[[plan]]\n"),
            fence: Some(("fence.kml", "<kml/>")),
            plugins: std::slice::from_ref(&setup),
        },
        ..header(Rate::Deployed, &[])
    };
    Recorder::new(&mut file, &header).unwrap().finish().unwrap();
    let log = LogReader::new(file.get_ref().as_slice(), "a log".to_owned()).unwrap();
    assert_eq!(log.plan(), Some(b"[[plan]]\n".as_slice()));
    assert_eq!(log.fence_as_read(), Some(("fence.kml", b"<kml/>".as_slice())));
    assert_eq!(log.description("isobath"), Some(setup.description));
    assert_eq!(log.description("plume"), None);
    // Without them it is a log of an earlier version.
    let earlier = recorded(Rate::Deployed, |_| {});
    let earlier = LogReader::new(earlier.as_slice(), "a log".to_owned()).unwrap();
    assert_eq!(
        (earlier.plan(), earlier.fence_as_read(), earlier.description("isobath")),
        (None, None, None)
    );
}

#[test]
fn what_a_simulation_does_to_the_process_is_marked() {
    let remarks = [
        Remark::Killed,
        Remark::Stopped,
        Remark::Continues,
        Remark::StartedAgain,
        Remark::Substituted(backseat_core::plugin::PluginId(2)),
        Remark::Reinstated(backseat_core::plugin::PluginId(2)),
    ];
    let bytes = recorded(Rate::Simulation, |recorder| {
        for remark in remarks {
            recorder.remark(Timestamp::ZERO, remark).unwrap();
        }
        let text = "core says so".to_owned();
        let note = Output::Note(backseat_core::Note::Text { text });
        recorder.output(Timestamp::ZERO, &note).unwrap();
    });
    let log = parse(&bytes).unwrap();
    let told: Vec<_> = log
        .entries
        .iter()
        .filter_map(|entry| {
            let Record::Note(note) = &entry.record else {
                return None;
            };
            Some(Remark::of_note(note))
        })
        .collect();
    let mut expected: Vec<_> = remarks.into_iter().map(Some).collect();
    expected.push(None);
    assert_eq!(told, expected);
    assert_eq!(log.notes().next().unwrap().1, "the runtime is killed");
}
