//! Records of every kind.
#![expect(
    clippy::unwrap_used,
    reason = "a test may panic, and so may the functions that it calls"
)]

use std::io::Cursor;
use std::time::Duration;

use backseat_core::ended::Ended;
use backseat_core::plugin::{
    CameraRequest, Decimation, DvlTriggerRequest, Event, FaultKind, GpsHitRequest, LightRequest, LogLevel, LogLine,
    Measure, NavigationSample, PacketRequest, PingNavigation, PingTime, PluginFault, PluginId, PositionRequest,
    Refusal, Request, RequestState, Returned, SilentRequest, SonarAngleRequest, SonarChannel, SonarEvent,
    SonarLogRequest, SonarPing, SonarSetRequest, SonarSetting, SonarSide, StationRequest, StationTarget, StepInput,
    TopsideRequest, TrackcircleRequest, TracklineRequest, Transport, Version, VerticalRequest,
};
use backseat_core::refusal::{Reason, Uncontrolled};
use backseat_core::{
    ExternalId, FromSonar, Identifiers, Input, Note, Operator, Order, Output, Owner, RequestKind, Reservation,
    Restarted, SonarOutcome, Start, StatusCondition, ToSonar, Transition,
};
use backseat_recorder::{Header, Rate, Recorder, Sources};
use backseat_spi::{Direction, FrameCounts, catalogue};
use backseat_units::{Altitude, Depth, EastNorth, Heading, Position, Timestamp, Utc};
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

pub(crate) const UTC: u64 = 1_780_000_000_000_000_000;

pub(crate) fn header(rate: Rate, components: &[(String, Vec<u8>)]) -> Header<'_> {
    Header {
        utc_at_start: Utc::from_unix_nanos(UTC),
        rate,
        mission: "isobath",
        seed: Some(7),
        resolved_mission: "[vehicle]\nname = \"nemo\"\n",
        fence: r#"{"type":"FeatureCollection","features":[]}"#,
        origin: Position::from_deg(42.0, -70.0).unwrap(),
        world: None,
        components,
        version: "0.1.0",
        sources: Sources::default(),
    }
}

pub(crate) fn navigation(solution: Timestamp) -> NavigationSample {
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

pub(crate) fn ping() -> SonarPing {
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
pub(crate) fn recorded(rate: Rate, record: impl FnOnce(&mut Recorder<&mut Cursor<Vec<u8>>>)) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let mut recorder = Recorder::new(&mut file, &header(rate, &[])).unwrap();
    record(&mut recorder);
    recorder.finish().unwrap();
    file.into_inner()
}

pub(crate) fn station(target: StationTarget, speed_mps: Option<f64>) -> Request {
    Request::Station(StationRequest {
        tag: 18,
        target,
        speed_mps,
        duration: Duration::from_millis(1500),
    })
}

fn measure() -> Measure {
    Measure {
        name: "water_depth".into(),
        value: 41.5,
        unit: "m".into(),
    }
}

pub(crate) fn returned(requests: Vec<Request>) -> Input<'static> {
    let returned = Returned {
        fuel: 12_345,
        measures: vec![measure()],
        log: vec![LogLine {
            level: LogLevel::Info,
            text: "a \"line\"\n".into(),
        }],
        result: Ok(requests),
    };
    Input::Returned(PluginId(1), returned)
}

/// What core is started with.
pub(crate) fn start() -> Start {
    Start {
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
    }
}

/// Every input that core can be given.
pub(crate) fn inputs() -> Vec<Input<'static>> {
    let fault = PluginFault {
        kind: FaultKind::Trap,
        text: "unreachable".into(),
    };
    let position = PositionRequest {
        latitude_deg: 42.1,
        longitude_deg: -70.123_456_789_012_34,
    };
    vec![
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
                measures: vec![],
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
        Input::Swap(PluginId(0), version()),
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
    ]
}

/// Outputs for each channel.
pub(crate) fn outputs() -> Vec<Output> {
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
    vec![
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
    ]
}

/// Every kind of refusal.
pub(crate) fn refusals() -> Vec<Refusal> {
    let zone = json!({
        "rule": "closed", "zone": "bay", "missing_m": 1.5, "bound_m": 20.0, "margin_m": 5.0,
        "edge": {"polygon": 1, "hole": 2, "number": 3, "latitude_deg": 42.0, "longitude_deg": -70.0},
        "valid": {"from": 1, "until": 2}, "asked": {"from": 1, "until": 2}, "number": "a radius",
    });
    let figure = json!({"figure": "speed", "value": 9.0, "least": 1.0, "most": 2.0});
    let boxed = |edge| json!({"box": {"name": "hull_box", "stretch": "way", "missing_m": 0.5, "edge": edge}});
    values(json!([
        {"zone": zone},
        {"zone": {"rule": "keep-in", "margin_m": 5.0}},
        boxed(json!({"kept": {"axis": "x", "key": "x_max_m", "reached_m": 3.0, "bound_m": 2.0}})),
        boxed(json!({"entered": {"list": "keep_out_hull", "key": "depth_max_m"}})),
        {"figure": figure},
        {"uncontrolled": "link-down"},
        {"not-granted": "insert"},
        {"state": "tag-open"},
        {"until": {"reason": "tag-open", "left_s": 1.5}},
        {"command-in-text": {"letters": "RMB", "at": 4}},
        {"unwritable": "no"},
        {"delays": {"request": 4}},
        {"way-back": {"zone": zone}},
        {"way-back": {"figure": figure}},
        {"way-to": {"zone": zone}},
        {"way-on": {"figure": figure}},
    ]))
}

/// Every state of a request.
pub(crate) fn states() -> Vec<RequestState> {
    let mut states: Vec<RequestState> = values(json!([
        "Sent", "Pending", "Accepted", "TimedOut", "Unknown", "Started", "Cancelled",
        {"Failed": {"vehicle": "no"}},
        {"Failed": "not-in-plan"},
        {"Failed": {"sonar": "no"}},
        {"Ended": {"by": "flown"}},
        {"Ended": {"said": ["vehicle-stopped", "enough"]}},
        {"Ended": {"uncontrolled": "link-down"}},
        {"Ended": {"frames": ["acked", {"other": 7}]}},
    ]));
    for refusal in refusals() {
        states.push(RequestState::Ended(Ended::Refusal(Box::new(refusal.clone()))));
        states.push(RequestState::Rejected(refusal));
    }
    states
}

/// Every kind of event for a plugin.
pub(crate) fn events() -> Vec<Event> {
    let alarm = json!({"id": 3, "active": true, "sensor": 1, "text": "hot"});
    let place = json!([{"latitude_deg": 42.0, "longitude_deg": -70.0}, {"east_m": 1.0, "north_m": 2.0}]);
    let mut events: Vec<Event> = values(json!([
        {"Control": true},
        {"Ctd": {"measured": 1, "conductivity_us_per_cm": 1.5, "temperature_c": 2.5, "pressure_kpa": 3.5}},
        {"MissionCommand": "text"},
        {"BehaviorBegan": {"kind": "trackline", "tag": 7}},
        {"BehaviorEnded": {"kind": "trackline", "tag": null}},
        {"Timer": 4},
        {"Restored": {"lost_steps": 3, "open": [1, 2]}},
        "Shutdown",
        {"LoggingBegan": "line 3"},
        {"LoggingEnded": "line 3"},
        {"TopsideMessage": {"transport": "wifi", "text": "text"}},
        {"DvlTrigger": true},
        {"Window": {"until": 5, "address": 7, "device": "WHOI"}},
        {"Packet": {
            "arrived": 5, "source": 1, "destination": 2, "mode": 3, "frames": [{"good": true, "data": [0, 255]}]
        }},
        {"Plan": [{"number": 3, "identifier": 4, "points": [place]}]},
        {"Sample": {"Telemetry": {
            "measured": 1, "acoustic_up_available_kb": 1.0, "acoustic_up_last_kb": 1.0,
            "acoustic_down_available_kb": 1.0, "acoustic_down_last_kb": 1.0, "rf_connected": true,
            "ethernet_available": false
        }}},
        {"Sample": {"SoundVelocity": {"measured": 1, "sound_velocity_mps": 1500.0}}},
        {"Sample": {"Compass": {
            "measured": 1, "number": 1, "heading_deg": 1.0, "pitch_deg": 1.0, "roll_deg": 1.0
        }}},
        {"Sample": {"Pressure": {"measured": 1, "pressure_kpa": 1.0}}},
        {"Sample": {"VehicleSpeed": {"measured": 1, "thruster_rpm": 1.0, "water_speed_mps": 1.0}}},
        {"Sample": {"Battery": {
            "measured": 1, "number": 0, "voltage_v": 1.0, "cell_min_v": 1.0, "cell_max_v": null, "temperature_c": 1.0,
            "capacity_kwh": 1.0, "charge_percent": 1.0
        }}},
        {"Sample": {"Surfaces": {
            "measured": 1, "elevator_deg": 1.0, "rudder_deg": 1.0, "elevator_target_deg": 1.0,
            "rudder_target_deg": 1.0
        }}},
        {"Sample": {"Dvl": {
            "measured": 1, "velocity_mps": [1.0, null, 2.0], "ranges_m": [1.0, 2.0, null, 4.0], "temperature_c": 1.0
        }}},
        {"Sample": {"DvlBeams": {
            "measured": 1, "velocity_mps": [1.0, null, 2.0, 3.0], "ranges_m": [1.0, 2.0, null, 4.0],
            "temperature_c": null
        }}},
        {"Sample": {"Imu": {
            "measured": 1, "rate_dps": [1.0, 2.0, 3.0], "acceleration_mps2": [1.0, 2.0, 3.0]
        }}},
        {"Sample": {"Servo": {"measured": 1, "dvl_deg": 1.0, "sonar_deg": 1.0}}},
        {"Sample": {"Trim": {"measured": 1, "adjusting": true, "pitch_deg": 1.0, "roll_deg": 1.0}}},
        {"Sample": {"Buoyancy": {"measured": 1, "adjusting": true, "buoyancy_n": 1.0}}},
        {"Sonar": {"ready": true}},
        {"Sonar": {"logging": {"on": true, "file": "f", "size_mb": 1.0, "missing": false}}},
        {"Sonar": {"health": [[1, true], [2, false]]}},
        {"Sonar": {"alarm": alarm}},
        {"Sonar": {"active-alarms": [alarm]}},
        {"Sonar": {"swath": {
            "sensor": 1, "number": 2, "port_m": 1.0, "starboard_m": 1.0, "altitude_m": 3.0, "source": "bottom-lock"
        }}},
        {"Sonar": "controller-shutdown"},
    ]));
    events.push(Event::Sidescan(ping()));
    events.push(Event::SubBottom(ping()));
    events.extend(states().into_iter().map(|state| Event::Outcome { tag: 7, state }));
    events
}

/// Every kind of note.
pub(crate) fn notes() -> Vec<Note> {
    let text = || "a text".to_owned();
    let plugin = PluginId(0);
    let mut notes = vec![
        Note::LinkUp,
        Note::LinkDown {
            counts: FrameCounts::default(),
            retry_s: 0.5,
        },
        Note::VehicleVersion { version: "1.12".into() },
        Note::Clock {
            offset_s: -0.5,
            vehicle: "08:10:25.987".parse().unwrap(),
        },
        Note::Mission {
            status: "Running".into(),
        },
        Note::Control {
            granted: true,
            reason: None,
        },
        Note::Plan { elements: 3 },
        Note::Behavior {
            began: true,
            number: Some(3),
            identifier: None,
            kind: "trackline".into(),
        },
        Note::Behavior {
            began: false,
            number: None,
            identifier: Some(1001),
            kind: "trackline".into(),
        },
        Note::Navigation { text: text() },
        Note::Malformed { text: text(), count: 3 },
        Note::PluginFailed {
            plugin,
            fault: PluginFault {
                kind: FaultKind::OutOfFuel,
                text: text(),
            },
            then: "it is restarted",
        },
        Note::PluginRestarted { plugin },
        Note::PluginSwap { plugin, to: version() },
        Note::PluginSwapped { plugin },
        Note::PluginNotSwapped { plugin, text: text() },
        Note::PluginLog {
            plugin,
            line: LogLine {
                level: LogLevel::Warn,
                text: "on the contour".into(),
            },
        },
        Note::PluginMeasure {
            plugin,
            measure: measure(),
        },
        Note::Operator { act: Operator::Hold },
        Note::Operator {
            act: Operator::Order(Order::CancelAll),
        },
        Note::Operator {
            act: Operator::Order(Order::Kill { text: text() }),
        },
        Note::Recovery { text: text() },
        Note::Sonar { text: text() },
        Note::Late { seconds: 0.6 },
        Note::Text { text: text() },
    ];
    for state in states() {
        if let RequestState::Ended(reason) = &state {
            notes.push(Note::LeaseEnded {
                plugin,
                reason: reason.clone(),
            });
        }
        notes.push(Note::Request(Transition {
            request: 5,
            owner: Owner::Plugin(plugin),
            tag: 77,
            kind: RequestKind::Modify,
            identifier: None,
            state,
        }));
    }
    notes
}

fn version() -> Version {
    Version {
        version: "0.2.0".to_owned(),
        sha256: "ab".repeat(32),
        trial_steps: 30,
    }
}

fn values<T: DeserializeOwned>(json: Value) -> T {
    serde_json::from_value(json).unwrap()
}

/// A log with every record that there is.
pub(crate) fn everything(rate: Rate) -> Vec<u8> {
    recorded(rate, |recorder| {
        recorder.start(&start()).unwrap();
        let mut now = Timestamp::ZERO;
        let mut later = || {
            now = now + Duration::from_millis(100);
            now
        };
        for input in inputs() {
            recorder.input(later(), &input).unwrap();
        }
        for event in events() {
            if let Event::Sonar(event) = event {
                recorder.input(later(), &Input::Sonar(FromSonar::Event(event))).unwrap();
            }
        }
        recorder.input(later(), &Input::UtcSet(-5)).unwrap();
        for text in ["range-m", "power-percent", "period-ms"] {
            let setting = values(json!({text: 1.5}));
            let request = Request::SonarSet(SonarSetRequest {
                tag: 1,
                sensor: 1,
                setting,
            });
            recorder.input(later(), &returned(vec![request])).unwrap();
        }
        recorder.gap(later(), Timestamp::ZERO, 3).unwrap();
        for output in outputs() {
            recorder.output(later(), &output).unwrap();
        }
        let steps = events().into_iter().map(|event| StepInput {
            events: vec![event],
            ..values(json!({
                "now": 0, "utc": 0, "clocks_apart": {"secs": 1, "nanos": 5}, "control": true, "events": [],
                "relative": {
                    "measured": 1, "horizontal_m": 1.0, "vertical_m": 1.0, "distance_m": 1.0, "heading_deg": 1.0,
                    "depth_m": 1.0, "absolute_heading_deg": 1.0, "roll_deg": 1.0, "pitch_deg": 1.0
                },
                "cartesian": {"measured": 1, "x_m": 1.0, "y_m": 1.0, "z_m": 1.0, "heading_deg": 1.0},
            }))
        });
        for step in steps {
            recorder.output(later(), &Output::Invoke(PluginId(0), step)).unwrap();
        }
        let orders = [
            json!({"order": {"request": 4, "order": {"set": {"sensor": 1, "setting": {"gain": 3}}}}}),
            json!({"order": {"request": 4, "order": {"log": {"on": true, "file": "f"}}}}),
            json!("shutdown"),
        ];
        for order in orders {
            recorder.output(later(), &Output::Sonar(values(order))).unwrap();
        }
        recorder
            .output(later(), &Output::External(ExternalId(0), vec![0xff]))
            .unwrap();
        for note in notes() {
            recorder.output(later(), &Output::Note(note)).unwrap();
        }
        for tick in 0..2 {
            let now = now + Duration::from_secs(tick + 1);
            recorder.navigation(now, &navigation(now)).unwrap();
            let truth = json!({
                "at": 5, "local": {"east_m": 1.5, "north_m": 2.5}, "depth_m": 4.0, "water_depth_m": 30.0,
                "position": {"latitude_deg": 42.0, "longitude_deg": -70.0}, "steering": "plan",
            });
            recorder.truth(now, &truth).unwrap();
            recorder.vehicle_event(now, "began trackline").unwrap();
        }
        let now = now + Duration::from_secs(3);
        for entry in catalogue() {
            let line = format!("{}\r\n", entry.example);
            match entry.direction {
                Direction::FromVehicle => recorder.input(now, &Input::Received(line.as_bytes())).unwrap(),
                Direction::ToVehicle => recorder.output(now, &Output::Send(line.into_bytes())).unwrap(),
            }
        }
        let plan = catalogue().iter().find(|entry| entry.name == "BFPLN").unwrap();
        let plan = format!("{}\r\n", plan.example);
        recorder.input(now, &Input::Received(plan.as_bytes())).unwrap();
        recorder.output(now, &Output::Note(Note::Plan { elements: 1 })).unwrap();
    })
}
