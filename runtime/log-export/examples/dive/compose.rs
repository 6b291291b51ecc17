//! A log as the runtime writes it, small, with everything that exports must get right: absent values, numbers that JSON
//! lacks, arrays, texts with quotation marks and line ends, bytes that are not UTF-8, changing states, a gap.

use std::collections::BTreeMap;
use std::io::Cursor;

use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, WriteOptions, Writer};
use serde_json::{Value, json};

/// 2026-11-23T14:05:07.25Z.
pub(crate) const START_NS: u64 = 1_795_442_707_250_000_000;
/// The last message, seconds of the run.
pub(crate) const LAST_S: f64 = 120.0;
/// Navigation comes at this period, seconds.
const STEP_S: f64 = 0.2;
/// `/position` is this far north of `/navigation`.
const POSITION_APART_DEG: f64 = 2e-7;
/// A sample of the CTD comes this long after navigation, seconds.
const CTD_AFTER_S: f64 = 0.0625;
/// Between these times records are missing.
const GAP_S: (f64, f64) = (50.0, 60.0);

/// A fence with one zone of each kind.
pub(crate) const FENCE: &str = r#"{"type":"FeatureCollection","features":[
{"type":"Feature","properties":{"kind":"keep-in","name":"box","depth_max_m":60},"geometry":{"type":"Polygon","coordinates":[[[-71.1,42.3],[-71.0,42.3],[-71.0,42.4],[-71.1,42.4],[-71.1,42.3]]]}},
{"type":"Feature","properties":{"kind":"keep-out","name":"wreck & reef"},"geometry":{"type":"Polygon","coordinates":[[[-71.06,42.34],[-71.05,42.34],[-71.05,42.35],[-71.06,42.34]]]}}]}"#;

const SCHEMAS: [(&str, &str, &str); 17] = [
    ("/link/from_vehicle", "backseat.Bytes", BYTES),
    ("/link/to_vehicle", "backseat.Bytes", BYTES),
    (
        "/core/input",
        "backseat.Input",
        r#"{"type":"object","properties":{"input":{"type":"string"}}}"#,
    ),
    (
        "/notes",
        "backseat.Note",
        r#"{"type":"object","properties":{"text":{"type":"string"},"note":{"type":"string"}}}"#,
    ),
    (
        "/requests",
        "backseat.Request",
        r#"{"type":"object","properties":{"text":{"type":"string"},"request":{"type":"integer"},
        "state":{"type":"string"},"reason":{"type":"string"},"why":{"type":"object","properties":{"rule":{"type":"string"}}}}}"#,
    ),
    (
        "/control",
        "backseat.Control",
        r#"{"type":"object","properties":{"granted":{"type":"boolean"}}}"#,
    ),
    (
        "/navigation",
        "backseat.Navigation",
        r#"{"type":"object","properties":{"latitude_deg":{"type":"number"},
        "longitude_deg":{"type":"number"},"east_m":{"type":"number"},"north_m":{"type":"number"},
        "depth_m":{"type":"number","description":"Metres below the surface."},"altitude_m":{"type":"number"},
        "heading_deg":{"type":"number"},"east_mps":{"type":"number"},"north_mps":{"type":"number"},"gps":{"type":"boolean"}}}"#,
    ),
    (
        "/truth",
        "backseat.Truth",
        r#"{"type":"object","properties":{"position":{"type":"object","properties":{
        "latitude_deg":{"type":"number"},"longitude_deg":{"type":"number"}}},"depth_m":{"type":"number"}}}"#,
    ),
    (
        "/position",
        "foxglove.LocationFix",
        r#"{"type":"object","properties":{"timestamp":{"type":"object","properties":{
        "sec":{"type":"integer"},"nsec":{"type":"integer"}}},"latitude":{"type":"number"},"longitude":{"type":"number"},
        "altitude":{"type":"number"},"position_covariance":{"type":"array","items":{"type":"number"}}}}"#,
    ),
    (
        "/log",
        "foxglove.Log",
        r#"{"type":"object","properties":{"level":{"type":"integer"},"message":{"type":"string"},"name":{"type":"string"}}}"#,
    ),
    ("/map/fence", "foxglove.GeoJSON", GEOJSON),
    ("/map/plan", "foxglove.GeoJSON", GEOJSON),
    ("/map/inserts", "foxglove.GeoJSON", GEOJSON),
    ("/map/requests", "foxglove.GeoJSON", GEOJSON),
    (
        "/sensors/CTD",
        "backseat.CTD",
        r#"{"type":"object","properties":{"created":{"type":"string"},
        "temperature_degc":{"type":"number","description":"Degrees Celsius."},"count":{"type":"integer"},
        "frames":{"type":"array","items":{"type":"string"}},"never":{"type":"number"}}}"#,
    ),
    (
        "/sensors/BFCTD",
        "backseat.BFCTD",
        r#"{"type":"object","properties":{"conductivity_us_per_cm":{"type":"number"},"temperature_c":{"type":"number"},
        "pressure_kpa":{"type":"number"}}}"#,
    ),
    (
        "/measures/pilot/slope",
        "backseat.Measure",
        r#"{"type":"object","properties":{"value":{"type":"number"},"unit":{"type":"string"}}}"#,
    ),
];

const BYTES: &str = r#"{"type":"object","properties":{"text":{"type":"string"},"base64":{"type":"string","contentEncoding":"base64"}}}"#;
const GEOJSON: &str = r#"{"type":"object","properties":{"geojson":{"type":"string"}}}"#;

/// The whole log.
pub(crate) fn whole() -> Vec<u8> {
    without(&[])
}

/// The log without the channels whose topics begin with one of these.
pub(crate) fn without(left_out: &[&str]) -> Vec<u8> {
    let mut log = Composer::new(left_out);
    log.dive();
    log.writer.finish().expect("memory can be written");
    log.writer.into_inner().into_inner()
}

/// The log of a process that was killed in the middle of a chunk.
pub(crate) fn killed() -> Vec<u8> {
    let mut log = whole();
    log.truncate(log.len() * 2 / 3);
    log
}

struct Composer {
    writer: Writer<Cursor<Vec<u8>>>,
    ids: BTreeMap<&'static str, u16>,
    sequence: u32,
    /// The features of `/map/inserts` and `/map/requests`. A message has all of a layer.
    inserts: Vec<Value>,
    requests: Vec<Value>,
}

impl Composer {
    fn new(left_out: &[&str]) -> Self {
        let options = WriteOptions::new()
            .chunk_size(Some(16 << 10))
            .disable_seeking(true)
            .compression(None);
        let mut writer = options.create(Cursor::new(Vec::new())).expect("memory can be written");
        let run = [
            ("format", "1"),
            ("version", "0.1.0"),
            ("mission", "composed <&>"),
            ("seed", "7"),
            ("rate", "deployed"),
            ("utc_at_start_ns", &START_NS.to_string()),
        ];
        let metadata = run.map(|(key, value)| (key.to_owned(), value.to_owned())).into();
        let name = "backseat".to_owned();
        writer
            .write_metadata(&Metadata { name, metadata })
            .expect("memory can be written");
        let attachment = Attachment {
            log_time: START_NS,
            create_time: START_NS,
            name: "fence.geojson".to_owned(),
            media_type: "application/geo+json".to_owned(),
            data: FENCE.as_bytes().into(),
        };
        writer.attach(&attachment).expect("memory can be written");
        let schemas = SCHEMAS.into_iter();
        let schemas = schemas.filter(|(topic, ..)| !left_out.iter().any(|start| topic.starts_with(start)));
        let ids = schemas.map(|(topic, name, schema)| {
            let id = writer
                .add_schema(name, "jsonschema", schema.as_bytes())
                .expect("memory can be written");
            let channel = writer.add_channel(id, topic, "json", &BTreeMap::new());
            (topic, channel.expect("memory can be written"))
        });
        let ids = ids.collect();
        Self {
            writer,
            ids,
            sequence: 0,
            inserts: Vec::new(),
            requests: Vec::new(),
        }
    }

    fn put(&mut self, topic: &'static str, at_s: f64, message: &Value) {
        let time = START_NS + (at_s * 1e9).round() as u64;
        let Some(id) = self.ids.get(topic) else { return };
        let header = MessageHeader {
            channel_id: *id,
            sequence: self.sequence,
            log_time: time,
            publish_time: time,
        };
        self.sequence += 1;
        let data = message.to_string();
        self.writer
            .write_to_known_channel(&header, data.as_bytes())
            .expect("memory can be written");
    }

    fn layer(&mut self, topic: &'static str, at_s: f64, geojson: &Value) {
        let geojson = geojson.as_str().map_or_else(|| geojson.to_string(), str::to_owned);
        self.put(topic, at_s, &json!({ "geojson": geojson }));
    }

    fn dive(&mut self) {
        self.put(
            "/core/input",
            0.0,
            &json!({"input": "start", "start": {"seed": u64::MAX, "armed": true}}),
        );
        self.layer("/map/fence", 0.0, &FENCE.into());
        self.put("/control", 1.0, &json!({"granted": true, "text": "control granted"}));
        let element = |number: u32, latitude: f64| {
            json!({"type": "Feature", "properties": {"number": number, "kind": "trackline"}, "geometry":
                {"type": "LineString", "coordinates": [[-71.09, latitude], [-71.02, latitude]]}})
        };
        self.layer("/map/plan", 2.0, &collection(&[element(1, 42.31), element(2, 42.32)]));
        let mut due = Vec::new();
        due.extend([10.0, 20.0, 30.0].map(|at_s| (at_s, Event::Request)));
        due.push((40.0, Event::Plan(collection(&[element(2, 42.32), element(3, 42.33)]))));
        due.push((GAP_S.1, Event::Gap));
        let mut due = due.into_iter().peekable();
        for step in 0..=(LAST_S / STEP_S) as u32 {
            let at_s = f64::from(step) * STEP_S;
            if at_s > GAP_S.0 && at_s < GAP_S.1 {
                continue;
            }
            while let Some((at_s, event)) = due.next_if(|(due_s, _)| *due_s <= at_s) {
                self.event(at_s, event);
            }
            self.navigation(at_s, step);
            self.link(at_s, step);
        }
    }

    fn event(&mut self, at_s: f64, event: Event) {
        match event {
            Event::Request => self.request(at_s),
            Event::Plan(plan) => self.layer("/map/plan", at_s, &plan),
            Event::Gap => {
                self.put(
                    "/core/input",
                    at_s,
                    &json!({"input": "gap", "since_s": GAP_S.0, "records": 250}),
                );
            }
        }
    }

    /// At 10 s a trackline, which is flown; at 20 s another, which is rejected; at 30 s a modify, which is rejected.
    fn request(&mut self, at_s: f64) {
        let request = at_s as u64 / 10;
        let line = json!({"type": "LineString", "coordinates": [[-71.08, 42.33, -20.0], [-71.07, 42.33, -20.0]]});
        let of = |state: &str, more: Value| {
            let mut properties = json!({
                "plugin": "pilot", "tag": 3, "kind": "trackline", "state": state, "style": {"color": "#1f77b4"}
            });
            for (name, value) in more.as_object().into_iter().flatten() {
                properties[name] = value.clone();
            }
            json!({"type": "Feature", "geometry": line, "properties": properties})
        };
        let numbered = json!({ "request": request });
        let reason = "the leg leaves \"box\" by 12.5 m,\nat its north edge";
        let told =
            |state: &str| json!({"text": format!("request {request} {state}"), "request": request, "state": state});
        match request {
            1 => {
                // It has no number until it is in the ledger.
                self.asked(at_s, of("asked", json!({})), false);
                self.asked(at_s, of("sent", numbered), true);
                self.put("/requests", at_s, &told("sent"));
                for (later_s, state) in [(1.0, "accepted"), (5.0, "started"), (12.0, "ended")] {
                    self.inserts = vec![of(state, json!({"identifier": 4711}))];
                    let inserts = collection(&self.inserts);
                    self.layer("/map/inserts", at_s + later_s, &inserts);
                }
            }
            number => {
                let mut rejected = told("rejected");
                rejected["reason"] = reason.into();
                rejected["why"] = json!({"rule": "fence", "range": [1.5, "inf"]});
                self.put("/requests", at_s, &rejected);
                if number == 2 {
                    self.asked(at_s, of("asked", json!({})), false);
                    self.asked(
                        at_s,
                        of("rejected", json!({"request": request, "reason": reason})),
                        true,
                    );
                }
            }
        }
        self.put(
            "/log",
            at_s,
            &json!({"level": 2, "message": format!("asked for {request}"), "name": "plugin pilot"}),
        );
    }

    /// A new request, or a new state of the last one.
    fn asked(&mut self, at_s: f64, feature: Value, again: bool) {
        if again {
            self.requests.pop();
        }
        self.requests.push(feature);
        let requests = collection(&self.requests);
        self.layer("/map/requests", at_s, &requests);
    }

    fn navigation(&mut self, at_s: f64, step: u32) {
        let (latitude, longitude) = (42.31 + at_s * 1e-5 / 3.0, -71.09 + at_s * 2e-5 / 3.0);
        let depth = (at_s / 4.0).min(20.0);
        let mut navigation = json!({
            "latitude_deg": latitude, "longitude_deg": longitude, "east_m": at_s * 0.55, "north_m": at_s * 0.37,
            "depth_m": depth, "heading_deg": 56.3, "east_mps": 0.55, "north_mps": 0.37, "gps": depth == 0.0
        });
        // No bottom lock at first.
        if at_s >= 30.0 {
            navigation["altitude_m"] = (40.0 - depth).into();
        }
        self.put("/navigation", at_s, &navigation);
        self.put(
            "/position",
            at_s,
            &json!({
                "timestamp": {"sec": START_NS / 1_000_000_000, "nsec": 250_000_000},
                // A little apart, so that a map shows which of the two it has.
                "latitude": latitude + POSITION_APART_DEG,
                "longitude": longitude, "altitude": -depth, "position_covariance": [1.5, 0, 0, 0, 1.5, 0, 0, 0, 0.25]
            }),
        );
        if step.is_multiple_of(5) {
            let position = json!({"latitude_deg": latitude + 1e-6, "longitude_deg": longitude - 1e-6});
            self.put(
                "/truth",
                at_s,
                &json!({"position": position, "depth_m": depth + 0.1, "steering": "modify"}),
            );
        }
        // Nearer to this solution than to the next.
        if step.is_multiple_of(7) {
            let after_s = at_s + CTD_AFTER_S;
            let mut ctd = json!({"temperature_c": 10.25 + depth / 8.0, "pressure_kpa": 101.325 + 10.0 * depth});
            // The cell is blocked at first.
            if at_s > 20.0 {
                ctd["conductivity_us_per_cm"] = (39_000.5 - depth).into();
            }
            self.put("/sensors/BFCTD", after_s, &ctd);
        }
        if step == 123 {
            self.put("/measures/pilot/slope", at_s, &json!({"value": 3.5, "unit": "%"}));
        }
        if step.is_multiple_of(10) {
            let temperature = if step == 100 {
                json!("nan")
            } else {
                json!(f64::from(step).sqrt() / 3.0)
            };
            let mut ctd = json!({"created": "14:05:07.250", "temperature_degc": temperature, "count": step});
            if step > 300 {
                ctd["frames"] = json!(["00FF", "a,b"]);
            }
            self.put("/sensors/CTD", at_s, &ctd);
        }
    }

    /// A sentence of the vehicle in two reads, and a modify each second from 70 s to 80 s.
    fn link(&mut self, at_s: f64, step: u32) {
        if step.is_multiple_of(50) {
            self.put("/link/from_vehicle", at_s, &json!({"text": "$BFCTL,0810"}));
            self.put("/link/to_vehicle", at_s, &json!({"text": "$BPLOG,NVG,ON\r\n"}));
            self.put("/link/from_vehicle", at_s, &json!({"text": "25.987,1*78\r\n"}));
        }
        if step == 33 {
            self.put("/link/from_vehicle", at_s, &json!({"base64": "//7/DQo="}));
        }
        if (70.0..80.0).contains(&at_s) && step.is_multiple_of(5) {
            self.put(
                "/link/to_vehicle",
                at_s,
                &json!({"text": "$BPRMB,081025.987,90,3,0,1.5,1,0*54\r\n"}),
            );
        }
        if step == 400 {
            self.put("/link/to_vehicle", at_s, &json!({"text": "$BPEMB,081025.987*62\r\n"}));
        }
    }
}

fn collection(features: &[Value]) -> Value {
    json!({"type": "FeatureCollection", "features": features})
}

enum Event {
    Request,
    Plan(Value),
    Gap,
}
