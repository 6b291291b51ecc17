//! Names and descriptions for people.

use geojson::JsonObject;
use serde_json::Value;

use crate::flatten::text;

/// Ends of names that are units, with the number of decimals that people want to see.
const UNITS: [(&str, &str, usize); 7] = [
    ("_mps", " m/s", 2),
    ("_dps", "°/s", 1),
    ("_deg", "°", 1),
    ("_degc", " °C", 2),
    ("_rpm", " rpm", 0),
    ("_m", " m", 1),
    ("_s", " s", 1),
];

/// A feature's name: its own, or its kind with its number and state.
pub(super) fn named(layer: &str, number: usize, properties: &JsonObject) -> String {
    let word = |name: &str| {
        properties
            .get(name)
            .and_then(Value::as_str)
            .filter(|word| !word.is_empty())
    };
    let count = |name: &str| properties.get(name).and_then(Value::as_u64);
    if let Some(name) = word("name") {
        return name.to_owned();
    }
    let kind = word("kind").unwrap_or(layer);
    let number = count("identifier")
        .or_else(|| count("request"))
        .or_else(|| count("number"))
        .unwrap_or(number as u64);
    let state = word("state").map_or_else(String::new, |state| format!(": {state}"));
    format!("{kind} {number}{state}")
}

/// Seconds of the run. A time of day stands beside each.
const SECONDS: [&str; 3] = ["t_s", "until_s", "changed_s"];
/// Times of day.
const TIMES: [&str; 3] = ["time", "until", "changed"];

/// All properties, one a line: `depth: 20.1 m`.
pub(super) fn described(properties: &JsonObject) -> String {
    let present = properties
        .iter()
        .filter(|(name, value)| !value.is_null() && !SECONDS.contains(&name.as_str()));
    let lines: Vec<String> = present.map(|(name, value)| line(name, value)).collect();
    lines.join("\n")
}

fn line(name: &str, value: &Value) -> String {
    let unit = UNITS.iter().find(|(end, ..)| name.ends_with(end));
    match (unit, value.as_f64()) {
        (Some((end, unit, decimals)), Some(number)) => {
            let name = name.strip_suffix(end).unwrap_or(name);
            format!("{}: {number:.decimals$}{unit}", words(name))
        }
        (Some(_) | None, _) if TIMES.contains(&name) => format!("{name}: {}", time(&text(value))),
        (Some(_) | None, _) => format!("{}: {}", words(name), text(value)),
    }
}

/// `2026-11-23 14:05:07 UTC` from RFC 3339.
fn time(text: &str) -> String {
    match (text.get(..10), text.get(10..11), text.get(11..19)) {
        (Some(date), Some("T"), Some(time)) => format!("{date} {time} UTC"),
        _ => text.to_owned(),
    }
}

fn words(name: &str) -> String {
    name.replace(['_', '.'], " ")
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn properties(value: &Value) -> JsonObject {
        value.as_object().cloned().unwrap_or_default()
    }

    #[test]
    fn people_read_names_and_units() {
        let insert = properties(&json!({
            "kind": "trackline", "identifier": 7, "state": "started", "depth_m": 20.123, "speed_mps": 1.5,
            "reason": null, "t_s": 3, "time": "2026-11-23T14:05:07.250000000Z"
        }));
        assert_eq!(named("inserts", 1, &insert), "trackline 7: started");
        assert_eq!(
            described(&insert),
            "depth: 20.1 m\nidentifier: 7\nkind: trackline\nspeed: 1.50 m/s\nstate: started\n\
             time: 2026-11-23 14:05:07 UTC"
        );
        assert_eq!(
            named("fence", 3, &properties(&json!({"name": "box", "kind": "keep-in"}))),
            "box"
        );
        assert_eq!(named("fence", 3, &properties(&json!({"kind": "keep-in"}))), "keep-in 3");
    }
}
