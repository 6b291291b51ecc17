//! What is written to a log can be read back.
#![expect(
    clippy::unwrap_used,
    reason = "a test may panic, and so may the functions that it calls"
)]

use std::io::Cursor;
use std::path::Path;
use std::time::Duration;

use backseat_core::plugin::{
    CameraRequest, Decimation, DvlTriggerRequest, Event, FaultKind, GpsHitRequest, LightRequest, LogLevel, LogLine,
    ModifyRequest, NavigationSample, PacketRequest, PingNavigation, PingTime, PluginFault, PluginId, PositionRequest,
    Request, RequestState, Returned, SilentRequest, SonarAngleRequest, SonarChannel, SonarEvent, SonarLogRequest,
    SonarPing, SonarSetRequest, SonarSetting, SonarSide, StationRequest, StationTarget, StepInput, TopsideRequest,
    TrackcircleRequest, TracklineRequest, Transport, VerticalRequest,
};
use backseat_core::refusal::{Reason, Uncontrolled};
use backseat_core::{
    ExternalId, FromSonar, Identifiers, Input, Note, Operator, Order, Output, Owner, RequestKind, Reservation,
    Restarted, SonarOutcome, Start, StatusCondition, ToSonar, Transition,
};
use backseat_recorder::{COMPONENT_LIMIT, Header, LoggedInput, Rate, Record, Recorder, RecorderError, parse, read};
use backseat_units::{Altitude, Depth, EastNorth, Heading, Position, Timestamp, Utc};
use proptest::prelude::*;
use serde_json::json;

const UTC: u64 = 1_780_000_000_000_000_000;

fn header(rate: Rate, components: &[(String, Vec<u8>)]) -> Header<'_> {
    Header {
        utc_at_start: Utc::from_unix_nanos(UTC),
        rate,
        mission: "isobath",
        seed: Some(7),
        resolved_mission: "[vehicle]\nname = \"nemo\"\n",
        fence: r#"{"type":"FeatureCollection","features":[]}"#,
        components,
        version: "0.1.0",
    }
}

fn navigation(solution: Timestamp) -> NavigationSample {
    NavigationSample {
        solution,
        position: Position::from_deg(42.1, -70.3).unwrap(),
        local: EastNorth::new(12.5, -3.25),
        depth: Depth::from_m(10.0).unwrap(),
        altitude: Some(Altitude::from_m(5.5).unwrap()),
        heading: Heading::from_deg(90.0).unwrap(),
        roll_deg: 0.5,
        pitch_deg: -1.0,
        east_mps: 1.5,
        north_mps: 0.0,
        down_mps: 0.0,
        yaw_rate_dps: 0.1,
        gps: false,
    }
}

fn ping() -> SonarPing {
    let navigation = navigation(Timestamp::from_millis(900));
    SonarPing {
        sub_bottom: false,
        sensor: 1,
        number: 8,
        time: Timestamp::from_millis(950),
        time_source: PingTime::Measured,
        decimation: Decimation::Mean,
        channels: vec![SonarChannel {
            side: SonarSide::Port,
            ground_range: false,
            range_m: 75.0,
            start_nanos: 0,
            sample_nanos: 12.5,
            recorded: 8192,
            volts_per_step: Some(0.25),
            samples: vec![1.5, 0.1, 65_535.0],
        }],
        navigation: Some(PingNavigation {
            solution: navigation.solution,
            position: navigation.position,
            local: navigation.local,
            depth: navigation.depth,
            altitude: navigation.altitude,
            heading: navigation.heading,
            roll_deg: 0.5,
            pitch_deg: -1.0,
            velocity_mps: Some((1.5, 0.0)),
        }),
    }
}

/// Runs a closure that records, and returns the file's bytes.
fn recorded(rate: Rate, record: impl FnOnce(&mut Recorder<&mut Cursor<Vec<u8>>>)) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let mut recorder = Recorder::new(&mut file, &header(rate, &[])).unwrap();
    record(&mut recorder);
    recorder.finish().unwrap();
    file.into_inner()
}

fn station(target: StationTarget, speed_mps: Option<f64>) -> Request {
    Request::Station(StationRequest {
        tag: 18,
        target,
        speed_mps,
        duration: Duration::from_millis(1500),
    })
}

fn returned(requests: Vec<Request>) -> Input<'static> {
    let returned = Returned {
        fuel: 12_345,
        log: vec![LogLine {
            level: LogLevel::Info,
            text: "a \"line\"\n".into(),
        }],
        result: Ok(requests),
    };
    Input::Returned(PluginId(1), returned)
}

#[test]
fn every_input_comes_back_in_handle_order() {
    let fault = PluginFault {
        kind: FaultKind::Trap,
        text: "unreachable".into(),
    };
    let position = PositionRequest {
        latitude_deg: 42.1,
        longitude_deg: -70.123_456_789_012_34,
    };
    let inputs = vec![
        Input::Reserved(Reservation {
            below: 100,
            inserts: 4,
            gps_hits: 4,
        }),
        Input::LinkUp,
        Input::Received(b"$BFNVG,"),
        Input::Timeout,
        Input::Received(b"\xff\x00 not a sentence"),
        returned(vec![
            Request::EndModify,
            Request::Cancel(u64::MAX),
            Request::Message("so".into()),
            Request::Timer {
                id: 4,
                after: Duration::from_nanos(1_500_000_001),
            },
            Request::Trackline(TracklineRequest {
                tag: 9,
                start: position,
                end: position,
                vertical: VerticalRequest::AltitudeM(5.0),
                speed_mps: 1.5,
                interrupt: true,
            }),
            Request::Trackcircle(TrackcircleRequest {
                tag: 10,
                centre: position,
                radius_m: 25.0,
                orbits: -2.0,
                vertical: VerticalRequest::DepthM(f64::INFINITY),
                speed_mps: f64::NEG_INFINITY,
                entry_angle_deg: None,
                interrupt: false,
            }),
        ]),
        returned(vec![
            Request::GpsHit(GpsHitRequest { tag: 11, position }),
            Request::Topside(TopsideRequest {
                tag: 12,
                slowest: Transport::RadioModem,
                text: "half way".into(),
            }),
            Request::DvlTrigger(DvlTriggerRequest {
                tag: 13,
                external: true,
                triggering: false,
            }),
            Request::Silent(SilentRequest { tag: 14, silent: true }),
            Request::Trim(15),
            Request::Buoyancy(u64::MAX),
            Request::Packet(PacketRequest {
                tag: 17,
                destination: u32::MAX,
                mode: -1,
                acknowledge: true,
                frames: vec![vec![0, 255], vec![], b"text".to_vec()],
            }),
            station(StationTarget::Here, None),
            station(
                StationTarget::Hull {
                    horizontal_m: 1.5,
                    vertical_m: -0.1,
                    distance_m: f64::INFINITY,
                },
                Some(0.5),
            ),
            station(
                StationTarget::Bottom {
                    x_m: -0.0,
                    y_m: f64::NEG_INFINITY,
                    vertical: VerticalRequest::AltitudeM(2.0),
                },
                Some(f64::MAX),
            ),
            Request::EndStation,
            Request::SonarAngle(SonarAngleRequest {
                tag: 19,
                angle_deg: f64::MIN_POSITIVE,
            }),
            Request::Camera(CameraRequest {
                tag: 20,
                pan: i32::MIN,
                tilt: 0,
                zoom: i32::MAX,
            }),
            Request::SonarSet(SonarSetRequest {
                tag: 30,
                sensor: 1,
                setting: SonarSetting::RangeM(f64::INFINITY),
            }),
            Request::SonarSet(SonarSetRequest {
                tag: 31,
                sensor: 1,
                setting: SonarSetting::Pulse("a pulse".into()),
            }),
            Request::SonarLog(SonarLogRequest {
                tag: 32,
                on: true,
                file: None,
            }),
            Request::Light(LightRequest {
                tag: 21,
                light: -1,
                on: true,
            }),
        ]),
        Input::Returned(
            PluginId(0),
            Returned {
                fuel: 0,
                log: vec![],
                result: Err(fault.clone()),
            },
        ),
        Input::Restarted(
            PluginId(0),
            Restarted {
                fuel: 1,
                lost_steps: 2,
                result: Err(fault),
            },
        ),
        Input::Restarted(
            PluginId(0),
            Restarted {
                fuel: 1,
                lost_steps: 2,
                result: Ok(()),
            },
        ),
        Input::Operator(Operator::Hold),
        Input::Operator(Operator::Order(Order::CancelAll)),
        Input::Operator(Operator::Order(Order::Abort {
            text: "a leak".into(),
            errors: false,
        })),
        Input::Operator(Operator::Order(Order::StartEmptyMission { duration_s: 600 })),
        Input::External(ExternalId(2), b"$BPNPU,000000.000\r\n"),
        Input::Sonar(FromSonar::Ping(PluginId(1), ping())),
        Input::Sonar(FromSonar::Event(SonarEvent::Ready(true))),
        Input::Sonar(FromSonar::Outcome {
            request: 7,
            outcome: SonarOutcome::Failed("no".into()),
        }),
        Input::Sonar(FromSonar::Status {
            text: "sonar ready".into(),
            conditions: vec![StatusCondition::SonarAlarm],
        }),
        Input::Sonar(FromSonar::Line("a line".into())),
        Input::External(ExternalId(0), b"\xff\x00 no sentence"),
        Input::External(ExternalId(0), b""),
        Input::LinkDown,
    ];
    let start = Start {
        utc: Utc::from_unix_nanos(UTC),
        identifiers: Some(Identifiers {
            next: 3,
            reserved: 50,
            first: 1,
            inserts: 2,
            gps_hits: 1,
        }),
        armed: true,
        held: false,
        jitter: u64::MAX,
    };
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
    assert_eq!(sequences, (0..back.len() as u32 + 1).collect::<Vec<_>>());
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

    /// With any bytes damaged. The format allows a checksum of zero to mean that there is none, so zeros disable checks.
    #[test]
    fn sr_013_no_bytes_make_the_reader_panic(
        cut in any::<prop::sample::Index>(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<[u8; 4]>(), 1usize..=4), 1..8),
    ) {
        let mut bytes = short_log();
        for (at, with, count) in changes {
            let at = at.index(bytes.len() - count);
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

#[test]
fn no_single_byte_makes_the_reader_panic() {
    let mut bytes = short_log();
    for at in 0..bytes.len() {
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

#[test]
fn a_file_cut_anywhere_reads_up_to_the_cut() {
    let bytes = short_log();
    for length in 0..bytes.len() {
        match parse(&bytes[..length]) {
            Ok(log) => assert!(log.entries.len() <= 1, "{length}"),
            Err(error) => assert!(
                matches!(error, RecorderError::Damaged { .. } if length < mcap::MAGIC.len())
                    || matches!(error, RecorderError::Foreign { .. }),
                "{length}: {error}"
            ),
        }
    }
}

#[test]
fn outputs_go_to_their_channels() {
    let transition = |owner, state| {
        Output::Note(Note::Request(Transition {
            request: 5,
            owner,
            tag: 77,
            kind: RequestKind::Trackline,
            identifier: Some(12),
            state,
        }))
    };
    let step = StepInput {
        now: Timestamp::ZERO,
        utc: Utc::from_unix_nanos(UTC),
        clocks_apart: None,
        navigation: Some(navigation(Timestamp::ZERO)),
        relative: None,
        cartesian: None,
        control: true,
        events: vec![Event::Timer(1), Event::Sidescan(ping())],
    };
    let outputs = [
        Output::Send(b"$BPVER\r\n".to_vec()),
        Output::Connect {
            after: Duration::from_millis(1500),
        },
        Output::ResetLink,
        Output::Invoke(PluginId(2), step),
        Output::Restart(PluginId(2)),
        Output::Reserve(Reservation {
            below: 64,
            inserts: 4,
            gps_hits: 4,
        }),
        Output::Finish,
        Output::Note(Note::Plan { elements: 4 }),
        transition(Owner::Operator, RequestState::Sent),
        transition(
            Owner::Plugin(PluginId(3)),
            RequestState::Rejected(Reason::TagOpen.into()),
        ),
        Output::Note(Note::Control {
            granted: false,
            reason: Some(Uncontrolled::LinkDown),
        }),
        transition(Owner::External(ExternalId(1)), RequestState::Accepted),
        Output::External(ExternalId(1), b"$BFACK\r\n".to_vec()),
        Output::Sonar(ToSonar::VehicleLogs(true)),
    ];
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
        json!({"output": "external", "external": 1, "bytes": "$BFACK\r\n"})
    );
    assert_eq!(json(13), json!({"output": "sonar", "order": {"vehicle-logs": true}}));
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
    let ping = &invoke["step"]["events"][1]["Sidescan"];
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

#[test]
fn a_run_is_named_and_its_files_attached() {
    let components = [
        ("isobath".to_owned(), b"\0asm".to_vec()),
        ("python".to_owned(), vec![7; COMPONENT_LIMIT + 1]),
    ];
    let mut file = Cursor::new(Vec::new());
    let recorder = Recorder::new(&mut file, &header(Rate::Deployed, &components)).unwrap();
    recorder.finish().unwrap();
    let log = parse(file.get_ref()).unwrap();
    assert_eq!(
        (log.run.mission.as_str(), log.run.seed, log.run.rate),
        ("isobath", Some(7), Rate::Deployed)
    );
    assert_eq!(log.run.utc_at_start.as_unix_nanos(), UTC);
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
    assert!(matches!(parse(b"not a log at all"), Err(RecorderError::Damaged { .. })));
    let mut foreign = Cursor::new(Vec::new());
    mcap::Writer::new(&mut foreign).unwrap().finish().unwrap();
    let text = parse(foreign.get_ref()).unwrap_err().to_string();
    assert_eq!(
        text,
        "log in memory is not a backseat log: no metadata, expected a metadata record named backseat"
    );
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
