//! The channels that are derived from others.
#![expect(
    clippy::unwrap_used,
    reason = "a test may panic, and so may the functions that it calls"
)]

use std::io::Cursor;
use std::time::Duration;

use backseat_core::plugin::{
    GpsHitRequest, LogLevel, LogLine, Measure, PluginId, PositionRequest, Request, RequestState, Returned,
    TrackcircleRequest, TracklineRequest, VerticalRequest,
};
use backseat_core::refusal::Reason;
use backseat_core::{Input, Note, Output, Owner, RequestKind, Transition};
use backseat_recorder::{Header, Rate, Recorder};
use backseat_spi::{FromVehicle, Sentence, ToVehicle};
use backseat_units::Timestamp;
use proptest::prelude::*;
use serde_json::{Value, json};

use crate::sample::{UTC, header, navigation, start};
use crate::viewer::{channels, check};

type Log<'a> = Recorder<&'a mut Cursor<Vec<u8>>>;

/// The messages of a topic, each with its time in milliseconds of the run, in a log with a plugin `plume`.
fn told(rate: Rate, topic: &str, record: impl FnOnce(&mut Log<'_>)) -> Vec<(u64, Value)> {
    let components = [("plume".to_owned(), Vec::new())];
    let header = Header {
        components: &components,
        ..header(rate, &[])
    };
    let mut file = Cursor::new(Vec::new());
    let mut recorder = Recorder::new(&mut file, &header).unwrap();
    record(&mut recorder);
    recorder.finish().unwrap();
    let mut channels = channels(file.get_ref());
    check(&channels);
    let channel = channels.remove(topic);
    let messages = channel.map(|channel| channel.messages).unwrap_or_default();
    messages
        .into_iter()
        .map(|(time, message)| ((time - UTC) / 1_000_000, message))
        .collect()
}

const fn at(millis: u64) -> Timestamp {
    Timestamp::from_millis(millis)
}

/// The line of a sentence without its checksum.
fn line(body: &str) -> Vec<u8> {
    let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    format!("${body}*{sum:02X}\r\n").into_bytes()
}

fn hear(recorder: &mut Log<'_>, millis: u64, body: &str) {
    recorder.input(at(millis), &Input::Received(&line(body))).unwrap();
}

fn send(recorder: &mut Log<'_>, millis: u64, body: &str) {
    recorder.output(at(millis), &Output::Send(line(body))).unwrap();
}

fn note(recorder: &mut Log<'_>, millis: u64, note: Note) {
    recorder.output(at(millis), &Output::Note(note)).unwrap();
}

fn transition(request: u64, tag: u64, kind: RequestKind, identifier: Option<u32>, state: RequestState) -> Note {
    Note::Request(Transition {
        request,
        owner: Owner::Plugin(PluginId(0)),
        tag,
        kind,
        identifier,
        state,
    })
}

fn asks(recorder: &mut Log<'_>, millis: u64, requests: Vec<Request>) {
    let returned = Returned {
        fuel: 1,
        measures: vec![],
        log: vec![],
        result: Ok(requests),
    };
    recorder
        .input(at(millis), &Input::Returned(PluginId(0), returned))
        .unwrap();
}

const fn place(latitude_deg: f64, longitude_deg: f64) -> PositionRequest {
    PositionRequest {
        latitude_deg,
        longitude_deg,
    }
}

const fn trackline(tag: u64, end: PositionRequest) -> Request {
    Request::Trackline(TracklineRequest {
        tag,
        start: place(42.0, -70.0),
        end,
        vertical: VerticalRequest::DepthM(5.0),
        speed_mps: 1.5,
        interrupt: false,
    })
}

/// The features of a message on the map.
fn features(message: &Value) -> Vec<Value> {
    let geojson: Value = serde_json::from_str(message["geojson"].as_str().unwrap()).unwrap();
    assert_eq!(geojson["type"], "FeatureCollection");
    geojson["features"].as_array().unwrap().clone()
}

#[test]
fn position_is_a_fix_of_foxgloves() {
    let write = |recorder: &mut Log<'_>| {
        for tick in 0..20 {
            recorder
                .navigation(at(100 * tick), &navigation(at(100 * tick)))
                .unwrap();
        }
    };
    let fixes = told(Rate::Deployed, "/position", write);
    assert_eq!(
        fixes[1].1,
        json!({
            "timestamp": {"sec": UTC / 1_000_000_000 + 1, "nsec": 0},
            "frame_id": "vehicle",
            "latitude": 42.1,
            "longitude": -70.3,
            "altitude": -10.0,
            "position_covariance": [0, 0, 0, 0, 0, 0, 0, 0, 0],
            "position_covariance_type": 0,
            "heading": 90f64.to_radians(),
        })
    );
    let times = |rate| -> Vec<u64> { told(rate, "/position", write).iter().map(|(time, _)| *time).collect() };
    assert_eq!(
        (times(Rate::Simulation), times(Rate::Deployed)),
        (vec![0, 1000], vec![0, 1000])
    );
}

#[test]
fn log_has_the_lines_of_everybody_by_name_and_level() {
    let modify = |state| transition(1, 2, RequestKind::Modify, None, state);
    let lines = told(Rate::Simulation, "/log", |recorder| {
        for (level, text) in [(LogLevel::Debug, "d"), (LogLevel::Error, "e")] {
            let line = LogLine {
                level,
                text: text.into(),
            };
            let plugin = PluginId(0);
            note(recorder, 500, Note::PluginLog { plugin, line });
        }
        note(recorder, 1500, Note::LinkUp);
        // Only a refusal of a modify is worth a line: the rest comes twice a second.
        note(recorder, 1600, modify(RequestState::Sent));
        note(recorder, 1650, modify(RequestState::Accepted));
        note(
            recorder,
            1690,
            transition(4, 5, RequestKind::Trackline, Some(1001), RequestState::Sent),
        );
        note(recorder, 1700, modify(RequestState::Rejected(Reason::TagOpen.into())));
        note(recorder, 1800, Note::PluginRestarted { plugin: PluginId(3) });
        recorder.vehicle_event(at(2000), "began trackline").unwrap();
    });
    let lines: Vec<_> = lines
        .iter()
        .map(|(time, line)| {
            assert_eq!((&line["file"], &line["line"]), (&json!(""), &json!(0)));
            assert_eq!(line["timestamp"]["nsec"], time % 1000 * 1_000_000);
            let text = |key: &str| line[key].as_str().unwrap().to_owned();
            (line["level"].as_u64().unwrap(), text("name"), text("message"))
        })
        .collect();
    let expected = [
        (1, "plugin plume", "d"),
        (4, "plugin plume", "e"),
        (2, "runtime", "connected to the vehicle"),
        (1, "plugin plume", "Trackline 4 (plume, tag 5, identifier 1001) sent"),
        (
            3,
            "plugin plume",
            "Modify 1 (plume, tag 2) rejected: tag: an insert with this tag is still open",
        ),
        (2, "plugin 3", "plugin 3 works again"),
        (2, "vehicle", "began trackline"),
    ];
    assert_eq!(
        lines,
        expected.map(|(level, name, text)| (level, name.to_owned(), text.to_owned()))
    );
}

#[test]
fn the_fence_is_on_the_map_once() {
    let messages = told(Rate::Deployed, "/map/fence", |recorder| {
        recorder.start(&start()).unwrap();
        recorder.restart(at(9000), &start()).unwrap();
    });
    let fence = header(Rate::Deployed, &[]).fence;
    assert_eq!(messages, [(0, json!({"geojson": fence}))]);
}

#[test]
fn the_plan_is_on_the_map_whenever_it_is_whole_and_has_changed() {
    let ask = |recorder: &mut Log<'_>, millis, points: &[&str]| {
        send(recorder, millis, "BPRMP,081025.987");
        for point in points {
            let place = "4221.810920,N,07106.846030,W,,,";
            hear(recorder, millis + 10, &format!("BFPLN,081025.987,{point},{place}"));
        }
    };
    let whole = |recorder: &mut Log<'_>, millis| note(recorder, millis, Note::Plan { elements: 2 });
    let one = ["3,,0,1", "3,,1,2", "4,,0,0"];
    let messages = told(Rate::Simulation, "/map/plan", |recorder| {
        // Nobody has asked.
        hear(recorder, 0, "BFPLN,081025.987,9,,0,1,4221.810920,N,07106.846030,W,,,");
        whole(recorder, 10);
        ask(recorder, 100, &one);
        whole(recorder, 150);
        ask(recorder, 200, &one);
        whole(recorder, 250);
        // Two answers to two questions, and an answer whose end does not come.
        ask(recorder, 300, &["3,,0,1", "3,,0,1", "3,,1,2", "4,,0,0", ",1001,0,3"]);
        whole(recorder, 350);
        ask(recorder, 400, &["5,,0,0"]);
        recorder.input(at(450), &Input::LinkUp).unwrap();
        whole(recorder, 460);
    });
    let times: Vec<u64> = messages.iter().map(|(time, _)| *time).collect();
    assert_eq!(times, [150, 350]);
    let [line, point] = &features(&messages[0].1)[..] else {
        panic!("{messages:?}");
    };
    assert_eq!(line["geometry"]["type"], "LineString");
    assert_eq!(
        (&line["properties"]["number"], &line["properties"]["kind"]),
        (&json!(3), &json!("trackline"))
    );
    assert_eq!(point["geometry"]["type"], "Point");
    let [longitude, latitude] = [0, 1].map(|place| point["geometry"]["coordinates"][place].as_f64().unwrap());
    assert!(
        (longitude + 71.1141005).abs() < 1e-6 && (latitude - 42.3635153).abs() < 1e-6,
        "{point}"
    );
    let [_, _, circle] = &features(&messages[1].1)[..] else {
        panic!("{messages:?}");
    };
    assert_eq!(
        (&circle["properties"]["identifier"], &circle["properties"]["kind"]),
        (&json!(1001), &json!("trackcircle"))
    );
}

#[test]
fn inserts_are_on_the_map_as_they_were_sent_and_as_they_change() {
    let (here, there) = ("4221.810920,N,07106.846030,W", "4221.910920,N,07106.846030,W");
    let messages = told(Rate::Simulation, "/map/inserts", |recorder| {
        send(
            recorder,
            0,
            &format!("BPRTK,081025.987,1001,{here},{there},1,10,1.5,0,0"),
        );
        note(
            recorder,
            0,
            transition(1, 7, RequestKind::Trackline, Some(1001), RequestState::Sent),
        );
        note(
            recorder,
            100,
            transition(1, 7, RequestKind::Trackline, Some(1001), RequestState::Accepted),
        );
        send(
            recorder,
            200,
            &format!("BPRTC,081025.987,1002,{here},50,-2,0,15,1.5,0,180,4"),
        );
        send(recorder, 300, &format!("BPRGP,081025.987,1003,{here},120,5,0"));
        // Of no insert, and of one that is not sent.
        note(
            recorder,
            400,
            transition(2, 7, RequestKind::Packet, Some(1004), RequestState::Sent),
        );
        note(
            recorder,
            400,
            transition(3, 7, RequestKind::Trackline, Some(1005), RequestState::Sent),
        );
        recorder.input(at(1000), &Input::Timeout).unwrap();
        recorder.input(at(2500), &Input::Timeout).unwrap();
        note(
            recorder,
            3000,
            transition(1, 7, RequestKind::Trackline, Some(1001), RequestState::Started),
        );
    });
    let times: Vec<u64> = messages.iter().map(|(time, _)| *time).collect();
    assert_eq!(
        times,
        [0, 1000, 3000],
        "at most once a second, and only if something has changed"
    );
    let [line, circle, hit] = &features(&messages[1].1)[..] else {
        panic!("{messages:?}");
    };
    assert_eq!(
        line["properties"],
        json!({
            "identifier": 1001, "kind": "trackline", "state": "accepted", "plugin": "plume", "tag": 7,
            "style": {"color": "#1f77b4"},
        })
    );
    assert_eq!(line["geometry"]["coordinates"].as_array().unwrap().len(), 2);
    assert_eq!(circle["properties"]["kind"], "trackcircle");
    let ring = circle["geometry"]["coordinates"].as_array().unwrap();
    assert_eq!(ring.first(), ring.last());
    let north = ring[0][1].as_f64().unwrap() - 42.363_515_3;
    assert!((north * 111_000.0 - 50.0).abs() < 1.0, "{north}");
    assert_eq!(
        (&hit["properties"]["kind"], &hit["geometry"]["type"]),
        (&json!("gps-hit"), &json!("Point"))
    );
    assert_eq!(features(&messages[2].1)[0]["properties"]["state"], "started");
}

#[test]
fn a_change_before_the_end_of_the_log_is_on_the_map() {
    let kind = RequestKind::Trackline;
    let messages = told(Rate::Simulation, "/map/inserts", |recorder| {
        let place = "4221.810920,N,07106.846030,W";
        send(
            recorder,
            0,
            &format!("BPRTK,081025.987,1001,{place},{place},1,10,1.5,0,0"),
        );
        note(
            recorder,
            200,
            transition(1, 7, kind, Some(1001), RequestState::Cancelled),
        );
    });
    assert_eq!(messages[1].0, 200);
    assert_eq!(features(&messages[1].1)[0]["properties"]["state"], "cancelled");
}

#[test]
fn requests_are_on_the_map_as_they_were_asked_for() {
    let refused = || RequestState::Rejected(Reason::TagOpen.into());
    let (line, hit) = (RequestKind::Trackline, RequestKind::GpsHit);
    let messages = told(Rate::Simulation, "/map/requests", |recorder| {
        let circle = |radius_m| {
            Request::Trackcircle(TrackcircleRequest {
                tag: 9,
                centre: place(42.0, -70.0),
                radius_m,
                orbits: 1.0,
                vertical: VerticalRequest::DepthM(5.0),
                speed_mps: 1.5,
                entry_angle_deg: None,
                interrupt: false,
            })
        };
        let gps_hit = |position| Request::GpsHit(GpsHitRequest { tag: 8, position });
        asks(
            recorder,
            0,
            vec![
                trackline(7, place(42.0, -70.1)),
                gps_hit(place(42.0, -70.2)),
                circle(30.0),
            ],
        );
        note(recorder, 10, transition(1, 7, line, Some(1001), RequestState::Sent));
        note(recorder, 10, transition(2, 8, hit, None, refused()));
        // What cannot be drawn.
        let nowhere = vec![
            trackline(3, place(f64::NAN, 0.0)),
            gps_hit(place(91.0, f64::INFINITY)),
            circle(f64::NAN),
            circle(0.0),
            circle(1e9),
            Request::EndModify,
        ];
        asks(recorder, 20, nowhere);
        // Another with the same tag while the first waits to be told of: it is refused at once.
        asks(recorder, 1500, vec![trackline(6, place(42.0, -70.3))]);
        asks(recorder, 2500, vec![trackline(6, place(42.0, -70.4))]);
        note(recorder, 2500, transition(4, 6, line, None, refused()));
        note(recorder, 3600, transition(3, 6, line, Some(1002), RequestState::Sent));
        // The same again, and refused for the same reason, changes nothing.
        for again in 0..20 {
            asks(recorder, 5000 + 500 * again, vec![trackline(6, place(42.0, -70.4))]);
            note(
                recorder,
                5000 + 500 * again,
                transition(5 + again, 6, line, None, refused()),
            );
        }
    });
    let times: Vec<u64> = messages.iter().map(|(time, _)| *time).collect();
    assert_eq!(times, [0, 1500, 2500, 3600]);
    let all = features(&messages[3].1);
    let told: Vec<_> = all
        .iter()
        .map(|feature| {
            let of = |key: &str| feature["properties"][key].clone();
            (of("tag"), of("kind"), of("state"), of("reason"), of("plugin"))
        })
        .collect();
    let reason = json!("tag: an insert with this tag is still open");
    let plume = json!("plume");
    assert_eq!(
        told,
        [
            (json!(7), json!("trackline"), json!("sent"), json!(null), plume.clone()),
            (
                json!(8),
                json!("gps-hit"),
                json!("rejected"),
                reason.clone(),
                plume.clone()
            ),
            (
                json!(9),
                json!("trackcircle"),
                json!("asked"),
                json!(null),
                plume.clone()
            ),
            (json!(6), json!("trackline"), json!("sent"), json!(null), plume.clone()),
            (json!(6), json!("trackline"), json!("rejected"), reason, plume),
        ]
    );
    assert_eq!(all[4]["geometry"]["coordinates"], json!([[-70.0, 42.0], [-70.4, 42.0]]));
}

#[test]
fn sensors_are_decoded_with_one_type_a_property() {
    let dvl = |recorder: &mut Log<'_>, millis| {
        hear(
            recorder,
            millis,
            "BFDV2,081025.987,0.5,-0.5,,-0.25,5.1,5.3,,5,,081025.900",
        );
    };
    let write = |recorder: &mut Log<'_>| {
        for tick in 0..20 {
            dvl(recorder, 100 * tick);
        }
    };
    let all = told(Rate::Deployed, "/sensors/BFDV2", write);
    assert_eq!(all.len(), 20);
    assert_eq!(
        all[0].1,
        json!({
            "created": "08:10:25.987", "velocity_mps_1": 0.5, "velocity_mps_2": -0.5, "velocity_mps_4": -0.25,
            "ranges_m_1": 5.1, "ranges_m_2": 5.3, "ranges_m_4": 5.0, "measured": "08:10:25.900",
        })
    );
    let times = |messages: &[(u64, Value)]| messages.iter().map(|(time, _)| *time).collect::<Vec<_>>();
    assert_eq!(times(&told(Rate::Simulation, "/sensors/BFDV2", write)), [0, 1000]);
    let codes = told(Rate::Simulation, "/sensors/BFTRM", |recorder| {
        hear(recorder, 0, "BFTRM,081025.987,7,0,trimming,0.5,-0.25");
    });
    assert_eq!(
        (&codes[0].1["status"], &codes[0].1["text"]),
        (&json!("other-7"), &json!("trimming"))
    );
    assert!(codes[0].1["error"].is_string(), "{codes:?}");
}

#[test]
fn each_battery_has_its_own_second() {
    let batteries = told(Rate::Simulation, "/sensors/BFRBS", |recorder| {
        for tick in 0..20 {
            for number in 0..3 {
                hear(recorder, 100 * tick, &format!("BFRBS,081025.987,{number},29.85"));
            }
        }
    });
    let numbers: Vec<_> = batteries.iter().map(|(_, battery)| battery["number"].clone()).collect();
    assert_eq!(numbers, [0, 1, 2, 0, 1, 2]);
    assert_eq!(batteries[0].1["voltage_v"], 29.85);
    assert_eq!(batteries[0].1.get("cell_min_v"), None);
}

#[test]
fn what_is_no_sensor_or_cannot_be_read_makes_no_message() {
    let write = |recorder: &mut Log<'_>| {
        hear(
            recorder,
            0,
            "BFNVG,081025.987,4221.810920,N,07106.846030,W,1,45.3,20.1,203.1,-3.4,4.5,081025.980",
        );
        hear(recorder, 0, "BFCTD,081025.987,nonsense,10.25,303.4,081025.900");
        hear(recorder, 0, "BFCTD,081025.987");
        recorder
            .input(at(0), &Input::Received(b"$BFCTD,1*00\r\n$BFCTD,\xff*00\r\n"))
            .unwrap();
        // A good one in three reads, still in its second.
        let good = line("BFCTD,081025.987,42914,10.25,303.4,081025.900");
        for piece in [&good[..3], &good[3..20], &good[20..]] {
            recorder.input(at(200), &Input::Received(piece)).unwrap();
        }
    };
    let messages = told(Rate::Simulation, "/sensors/BFCTD", write);
    let [(200, ctd)] = &messages[..] else {
        panic!("{messages:?}")
    };
    assert_eq!(ctd["temperature_c"], 10.25);
    assert!(told(Rate::Deployed, "/sensors/BFNVG", write).is_empty());
}

#[test]
fn what_is_kept_for_the_map_is_bounded() {
    let inserts = |recorder: &mut Log<'_>| {
        let place = "4221.810920,N,07106.846030,W";
        for number in 0..500u32 {
            let millis = 2000 * u64::from(number);
            send(
                recorder,
                millis,
                &format!("BPRTK,081025.987,{number},{place},{place},1,10,1.5,0,0"),
            );
            if number != 5 {
                let ended = transition(1, 7, RequestKind::Trackline, Some(number), RequestState::Cancelled);
                note(recorder, millis, ended);
            }
        }
    };
    let messages = told(Rate::Simulation, "/map/inserts", inserts);
    let last = features(&messages.last().unwrap().1);
    assert_eq!(last.len(), 64);
    assert_eq!(last[0]["properties"]["identifier"], 5, "what is open goes last");
    let requests = told(Rate::Simulation, "/map/requests", |recorder| {
        for number in 0..500u32 {
            let millis = 100 * u64::from(number);
            asks(recorder, millis, vec![trackline(number.into(), place(42.0, -70.1))]);
        }
    });
    assert_eq!(features(&requests.last().unwrap().1).len(), 32);
    assert!(requests.len() <= 51, "{}", requests.len());
    let plan = told(Rate::Simulation, "/map/plan", |recorder| {
        send(recorder, 0, "BPRMP,081025.987");
        for number in 0..10_001 {
            let place = "4221.810920,N,07106.846030,W,,,";
            hear(recorder, 1, &format!("BFPLN,081025.987,{number},,0,1,{place}"));
        }
        note(recorder, 2, Note::Plan { elements: 10_001 });
    });
    assert!(plan.is_empty(), "core does not believe such a plan");
}

proptest! {
    // Each case compiles all schemas.
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Nothing that the vehicle or a plugin says makes the recorder fail, and viewers can read the log.
    #[test]
    fn sr_013_no_bytes_and_no_request_make_the_recorder_fail(
        reads in prop::collection::vec((any::<prop::sample::Index>(), any::<[u8; 3]>(), any::<bool>()), 1..20),
        figures in prop::array::uniform4(any::<f64>()),
    ) {
        let [latitude_deg, longitude_deg, radius_m, speed_mps] = figures;
        let somewhere = place(latitude_deg, longitude_deg);
        let _readable = told(Rate::Deployed, "/log", |recorder| {
            send(recorder, 0, "BPRMP,081025.987");
            for (entry, damage, is_ours) in reads {
                let mut bytes = entry.get(backseat_spi::catalogue()).example.as_bytes().to_vec();
                let at_byte = entry.index(bytes.len());
                bytes[at_byte] = damage[0];
                // A right checksum for what is damaged.
                let body = String::from_utf8_lossy(&bytes[1..bytes.len() - 3]).into_owned();
                bytes = line(&body);
                bytes.extend_from_slice(&damage);
                let input = Input::Received(&bytes);
                recorder.input(at(0), &input).unwrap();
                if is_ours {
                    recorder.output(at(0), &Output::Send(bytes)).unwrap();
                }
            }
            note(recorder, 1, Note::Plan { elements: 1 });
            let circle = TrackcircleRequest {
                tag: 1,
                centre: somewhere,
                radius_m,
                orbits: 1.0,
                vertical: VerticalRequest::AltitudeM(speed_mps),
                speed_mps,
                entry_angle_deg: Some(latitude_deg),
                interrupt: true,
            };
            asks(recorder, 2, vec![Request::Trackcircle(circle), trackline(2, somewhere)]);
        });
    }
}

/// The line that the tests make is a sentence of SPI.
#[test]
fn lines_of_these_tests_are_sentences() {
    let text = String::from_utf8(line("BPRMP,081025.987")).unwrap();
    let sentence = Sentence::parse(text.trim_end()).unwrap();
    assert!(matches!(ToVehicle::decode(&sentence), Ok(ToVehicle::RequestPlan(_))));
    let text = String::from_utf8(line("BFRBS,081025.987,1,29.85")).unwrap();
    let sentence = Sentence::parse(text.trim_end()).unwrap();
    assert!(matches!(FromVehicle::decode(&sentence), Ok(FromVehicle::Battery(_))));
    assert_eq!(Duration::from_millis(5), at(5).since(at(0)));
}

/// A channel for each name, and no line in the others.
#[test]
fn what_a_plugin_publishes_has_a_channel_of_its_name() {
    let publishes = |recorder: &mut Log<'_>| {
        for (millis, name, value) in [(1000, "slope", 2.5), (2000, "salinity", 35.0), (2000, "slope", 3.0)] {
            let measure = Measure {
                name: name.to_owned(),
                value,
                unit: "%".to_owned(),
            };
            let plugin = PluginId(0);
            note(recorder, millis, Note::PluginMeasure { plugin, measure });
        }
    };
    assert_eq!(
        told(Rate::Deployed, "/measures/plume/slope", publishes),
        [
            (1000, json!({"value": 2.5, "unit": "%"})),
            (2000, json!({"value": 3.0, "unit": "%"}))
        ]
    );
    for other in ["/notes", "/log"] {
        assert!(told(Rate::Deployed, other, publishes).is_empty(), "{other}");
    }
}
