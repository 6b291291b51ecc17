//! The .alog of MOOS: a line for each new value of a variable, `time  VARIABLE  source  value`.
//!
//! Positions and movements have the names that MOOS uses. Everything else is `BACKSEAT_` with the channel and the
//! property. Bytes of the link, inputs and outputs of core, and layers of maps are left out.

use std::io::{self, Write};
use std::path::Path;

use backseat_spi::{Framer, HorizontalMode, ModifySpeedMode, ModifyVerticalMode, Policy, ToVehicle};
use base64::Engine as _;
use serde_json::Value;

use crate::contents::{Contents, Message};
use crate::error::Error;
use crate::flatten::{flatten, number, text};
use crate::output::OutputFile;
use crate::source::Source;
use crate::tables::decimal;
use crate::time::ctime;
use crate::{Exported, counted};

const NAVIGATION: &str = "/navigation";
const TO_VEHICLE: &str = "/link/to_vehicle";
/// Channels that say the same as others, or nothing to a user of MOOS.
const LEFT_OUT: [&str; 4] = ["/link/", "/core/", "/map/", "/position"];
/// MOOS' names of what navigation has.
const NAMES: [(&str, &str); 7] = [
    ("east_m", "NAV_X"),
    ("north_m", "NAV_Y"),
    ("latitude_deg", "NAV_LAT"),
    ("longitude_deg", "NAV_LONG"),
    ("depth_m", "NAV_DEPTH"),
    ("altitude_m", "NAV_ALTITUDE"),
    ("heading_deg", "NAV_HEADING"),
];
/// A modify that is not refreshed lapses after this time, seconds (SPI 7.12).
const LAPSE_S: f64 = 5.0;

pub(crate) fn export(source: &Source, out: &Path) -> Result<Exported, Error> {
    let mut file = OutputFile::create(out)?;
    let contents = Contents::of(source, |_| false)?;
    let mut lines = Lines {
        lease: Lease::default(),
        sorted: (!contents.in_order).then(Vec::new),
        buffer: Vec::new(),
        count: 0,
    };
    header(&mut file, out, &contents).map_err(|error| file.failed(error))?;
    let is_told = |topic: &str| !LEFT_OUT.iter().any(|start| topic.starts_with(start));
    contents.read(
        source,
        |topic| topic == TO_VEHICLE || is_told(topic),
        |message| {
            lines.take(&message);
            let written = file.write_all(&lines.buffer);
            lines.buffer.clear();
            written.map_err(|error| file.failed(error))
        },
    )?;
    let written = file.write_all(&lines.rest());
    written.map_err(|error| file.failed(error))?;
    file.commit()?;
    Ok(Exported {
        summary: format!("{}: {}", out.display(), counted(lines.count, "line")),
        remarks: contents.remarks(source),
    })
}

fn header(file: &mut impl Write, out: &Path, contents: &Contents) -> io::Result<()> {
    const RULE: &str = "%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%";
    let name = out.file_name().unwrap_or_default();
    writeln!(file, "{RULE}")?;
    writeln!(file, "%% LOG FILE:       {}", name.display())?;
    writeln!(file, "%% FILE OPENED ON  {}", ctime(contents.start_ns))?;
    let (seconds, nanos) = (contents.start_ns / 1_000_000_000, contents.start_ns % 1_000_000_000);
    writeln!(file, "%% LOGSTART               {seconds}.{nanos:09}")?;
    writeln!(file, "{RULE}")
}

/// Makes lines from messages.
#[derive(Default)]
struct Lines {
    lease: Lease,
    /// Where the log is not in the order of time: all lines, with their time, to be sorted.
    sorted: Option<Vec<(f64, Vec<u8>)>>,
    /// Lines to write.
    buffer: Vec<u8>,
    count: u64,
}

/// What we ask of the vehicle by BPRMB.
struct Lease {
    framer: Framer,
    /// When the last modify lapses, seconds of the run.
    until_s: Option<f64>,
}

impl Default for Lease {
    fn default() -> Self {
        Self {
            framer: Framer::new(Policy::FromPayload),
            until_s: None,
        }
    }
}

impl Lines {
    fn take(&mut self, message: &Message<'_>) {
        if let Some(until_s) = self.lease.until_s.filter(|until_s| *until_s <= message.t_s) {
            self.end_lease(until_s);
        }
        if message.topic == TO_VEHICLE {
            self.modifies(message);
            return;
        }
        if message.schema == "foxglove.GeoJSON" {
            return;
        }
        let source = message.topic.trim_start_matches('/');
        let is_navigation = message.topic == NAVIGATION;
        flatten(&message.value, &mut |path, value| {
            if value.is_array() || path.starts_with("timestamp.") {
                return;
            }
            let known = NAMES.iter().find(|(name, _)| is_navigation && *name == path);
            match known {
                Some((_, variable)) => self.put(message.t_s, variable, source, &shown(value)),
                None => self.put(message.t_s, &variable(source, path), source, &shown(value)),
            }
        });
        let speed = |name| message.value.get(name).and_then(number);
        if is_navigation && let (Some(east), Some(north)) = (speed("east_mps"), speed("north_mps")) {
            let speed = (east * east + north * north).sqrt();
            self.put(message.t_s, "NAV_SPEED", source, &decimal(speed));
        }
    }

    /// The wishes of the modifies in bytes to the vehicle.
    fn modifies(&mut self, message: &Message<'_>) {
        const SOURCE: &str = "backseat";
        let t_s = message.t_s;
        self.lease.framer.push(&bytes(&message.value));
        let mut sent = Vec::new();
        while let Some(sentence) = self.lease.framer.next_sentence() {
            sent.extend(ToVehicle::decode(&sentence));
        }
        for sentence in sent {
            if let ToVehicle::ModifyBehavior(modify) = sentence {
                let mut put = |variable, wish: Option<f64>| {
                    if let Some(wish) = wish {
                        self.put(t_s, variable, SOURCE, &decimal(wish));
                    }
                };
                let horizontal = |mode| modify.horizontal.filter(|_| modify.horizontal_mode == Some(mode));
                let vertical = |mode| modify.vertical_m.filter(|_| modify.vertical_mode == Some(mode));
                let speed = |mode| modify.speed.filter(|_| modify.speed_mode == Some(mode));
                put("DESIRED_HEADING", horizontal(HorizontalMode::Heading));
                put("DESIRED_RUDDER", horizontal(HorizontalMode::Rudder));
                put("DESIRED_DEPTH", vertical(ModifyVerticalMode::Depth));
                put("DESIRED_ALTITUDE", vertical(ModifyVerticalMode::Altitude));
                put("DESIRED_PITCH", vertical(ModifyVerticalMode::Pitch));
                put("DESIRED_ELEVATOR", vertical(ModifyVerticalMode::Elevator));
                put("DESIRED_SPEED", speed(ModifySpeedMode::MetresPerSecond));
                put("DESIRED_RPM", speed(ModifySpeedMode::Rpm));
                if self.lease.until_s.is_none() {
                    self.put(t_s, "BACKSEAT_LEASE", SOURCE, "true");
                }
                self.lease.until_s = Some(t_s + LAPSE_S);
            } else if matches!(sentence, ToVehicle::EndModify(_)) && self.lease.until_s.is_some() {
                self.end_lease(t_s);
            }
        }
    }

    fn end_lease(&mut self, t_s: f64) {
        self.lease.until_s = None;
        self.put(t_s, "BACKSEAT_LEASE", "backseat", "false");
    }

    fn put(&mut self, t_s: f64, variable: &str, source: &str, value: &str) {
        if value.is_empty() {
            return;
        }
        self.count += 1;
        let line = format!("{t_s:<15.6} {variable:<32} {source:<16} {value}\n");
        match &mut self.sorted {
            Some(lines) => lines.push((t_s, line.into_bytes())),
            None => self.buffer.extend_from_slice(line.as_bytes()),
        }
    }

    /// The lines that are still to be written.
    fn rest(&mut self) -> Vec<u8> {
        let mut lines = self.sorted.take().unwrap_or_default();
        lines.sort_by(|a, b| a.0.total_cmp(&b.0));
        lines.into_iter().flat_map(|(_, line)| line).collect()
    }
}

/// `BACKSEAT_SENSORS_CTD_TEMPERATURE_DEGC` from `sensors/ctd` and `temperature_degc`.
fn variable(source: &str, path: &str) -> String {
    let name = format!("BACKSEAT_{source}_{path}");
    name.chars()
        .map(|character| {
            if character.is_ascii_alphanumeric() {
                character.to_ascii_uppercase()
            } else {
                '_'
            }
        })
        .collect()
}

/// A value in one line.
fn shown(value: &Value) -> String {
    match value {
        Value::Number(_) => number(value).map_or_else(|| text(value), as_number),
        Value::Null | Value::Bool(_) | Value::String(_) | Value::Array(_) | Value::Object(_) => {
            text(value).split_whitespace().collect::<Vec<_>>().join(" ")
        }
    }
}

/// Whole numbers, such as identifiers, have no decimals.
fn as_number(value: f64) -> String {
    let number = decimal(value);
    number.strip_suffix(".0").unwrap_or(&number).to_owned()
}

/// The bytes of a message of the link.
fn bytes(value: &Value) -> Vec<u8> {
    let field = |name| value.get(name).and_then(Value::as_str);
    match (field("text"), field("base64")) {
        (Some(text), _) => text.as_bytes().to_vec(),
        (None, Some(text)) => base64::engine::general_purpose::STANDARD
            .decode(text)
            .unwrap_or_default(),
        (None, None) => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn message(topic: &'static str, t_s: f64, value: Value) -> Message<'static> {
        Message {
            channel: 0,
            topic,
            schema: "",
            log_time: 0,
            t_s,
            value,
        }
    }

    fn lines(messages: Vec<Message<'_>>) -> Vec<String> {
        let mut lines = Lines::default();
        messages.iter().for_each(|message| lines.take(message));
        let text = String::from_utf8(lines.buffer).unwrap();
        text.lines()
            .map(|line| line.split_whitespace().collect::<Vec<_>>().join(" "))
            .collect()
    }

    #[test]
    fn navigation_has_the_names_of_moos_and_the_rest_has_ours() {
        let navigation = json!({"east_m": 3.5, "east_mps": 3.0, "north_mps": 4.0, "gps": true, "roll_deg": -1});
        assert_eq!(
            lines(vec![message("/navigation", 2.0, navigation)]),
            [
                "2.000000 NAV_X navigation 3.5",
                "2.000000 BACKSEAT_NAVIGATION_EAST_MPS navigation 3",
                "2.000000 BACKSEAT_NAVIGATION_GPS navigation true",
                "2.000000 BACKSEAT_NAVIGATION_NORTH_MPS navigation 4",
                "2.000000 BACKSEAT_NAVIGATION_ROLL_DEG navigation -1",
                "2.000000 NAV_SPEED navigation 5.0",
            ]
        );
        let text = json!({"text": "two\nlines", "list": [1], "tag": 7});
        assert_eq!(
            lines(vec![message("/notes", 0.5, text)]),
            [
                "0.500000 BACKSEAT_NOTES_TAG notes 7",
                "0.500000 BACKSEAT_NOTES_TEXT notes two lines"
            ]
        );
    }

    #[test]
    fn a_lease_has_its_wishes_and_ends_with_bpemb_or_after_five_seconds() {
        let sent = |t_s, text: &str| message(TO_VEHICLE, t_s, json!({ "text": text }));
        let modify = "$BPRMB,081025.987,90,3,0,1.5,1,0*54\r\n";
        let lines = lines(vec![
            sent(1.0, &modify[..9]),
            sent(1.5, &modify[9..]),
            sent(2.0, "$BPEMB,081025.987*62\r\n"),
            sent(3.0, "$BPRMB,081025.987,,,,750,0,1\r\n"),
            message("/vehicle", 9.0, json!({"text": "x"})),
        ]);
        assert_eq!(
            lines,
            [
                "1.500000 DESIRED_HEADING backseat 90.0",
                "1.500000 DESIRED_DEPTH backseat 3.0",
                "1.500000 DESIRED_SPEED backseat 1.5",
                "1.500000 BACKSEAT_LEASE backseat true",
                "2.000000 BACKSEAT_LEASE backseat false",
                "3.000000 DESIRED_RPM backseat 750.0",
                "3.000000 BACKSEAT_LEASE backseat true",
                "8.000000 BACKSEAT_LEASE backseat false",
                "9.000000 BACKSEAT_VEHICLE_TEXT vehicle x",
            ]
        );
    }

    #[test]
    fn lines_of_a_log_that_is_not_in_order_are_sorted() {
        let mut lines = Lines {
            sorted: Some(Vec::new()),
            ..Lines::default()
        };
        for t_s in [2.0, 1.0] {
            lines.take(&message("/vehicle", t_s, json!({"text": "x"})));
        }
        assert!(lines.buffer.is_empty());
        let text = String::from_utf8(lines.rest()).unwrap();
        assert!(text.starts_with("1.000000"), "{text}");
    }
}
