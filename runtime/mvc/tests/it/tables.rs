//! The tables of `runtime/docs/mock-tables.md`: each says what the mock does. (The reference's tests hold its list of
//! keys.)

use std::collections::{BTreeMap, BTreeSet};

use backseat_mvc::AcousticDevice;
use backseat_spi::{Direction, Entry, catalogue};

use crate::fields::{field, of};
use crate::files::CALM;
use crate::hovering::HARBOUR;
use crate::payload::Payload;

const PAGE: &str = include_str!("../../../docs/mock-tables.md");

/// The rows of the table under a heading, each as its cells without backticks.
fn rows(heading: &str) -> Vec<Vec<String>> {
    let section = PAGE
        .split("\n## ")
        .find(|section| section.lines().next() == Some(heading))
        .unwrap_or_else(|| panic!("the page has no section `{heading}`"));
    let cells = |line: &str| {
        let inner = line
            .strip_prefix('|')
            .and_then(|line| line.strip_suffix('|'))
            .expect("a row of a table");
        inner
            .split('|')
            .map(|cell| cell.trim().replace('`', ""))
            .collect::<Vec<_>>()
    };
    let table: Vec<&str> = section.lines().filter(|line| line.starts_with('|')).collect();
    assert!(table.len() > 2, "`{heading}` has no table");
    table[2..].iter().map(|line| cells(line)).collect()
}

/// The world with a key of this path set, such as `sensors.dvl.period_s`.
fn with(text: &str, key: &str, value: f64) -> String {
    let (table, name) = key.rsplit_once('.').expect("a key has a table");
    let header = format!("[{table}]\n");
    if text.contains(&header) {
        text.replacen(&header, &format!("{header}{name} = {value}\n"), 1)
    } else {
        format!("{header}{name} = {value}\n{text}")
    }
}

/// How many seconds lie between two of these messages, in the mean of two minutes.
fn period_s(text: &str, name: &str) -> f64 {
    let mut payload = Payload::connected(text, 1, &[name]);
    payload.until(20.0);
    payload.heard();
    payload.until(140.0);
    let heard = of(&payload.heard(), &format!("BF{name}"));
    // Each compass and each battery has a message of its own.
    let first = heard.first().map(|line| field(line, 2).to_owned());
    let one = match name {
        "RCM" | "RBS" => heard
            .iter()
            .filter(|line| Some(field(line, 2)) == first.as_deref())
            .count(),
        _ => heard.len(),
    };
    120.0 / one as f64
}

#[test]
fn the_rates_are_the_mocks() {
    let rows = rows("Messages and their rates");
    let named: Vec<&str> = rows.iter().map(|row| row[0].as_str()).collect();
    let all: Vec<&str> = catalogue()
        .iter()
        .filter(|entry| entry.direction == Direction::FromVehicle)
        .map(|entry| entry.name)
        .collect();
    let sorted = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<BTreeSet<_>>();
    assert_eq!(sorted(&named), sorted(&all), "each message of the vehicle has a row");
    for row in &rows {
        let (name, when, key) = (row[0].trim_start_matches("BF"), &row[1], &row[3]);
        let Some(every) = when.strip_prefix("every ") else {
            continue;
        };
        let expected_s: f64 = every.trim_end_matches(" s").parse().expect("a period");
        let hovers = ["RNV", "CNV", "PIT"].contains(&name);
        let base = if hovers { HARBOUR } else { CALM };
        let text = &format!("{base}\n[sensors.telemetry]\nenabled = true\n");
        let near = |found_s: f64, expected_s: f64| (found_s / expected_s - 1.0).abs() < 0.05;
        let found_s = period_s(text, name);
        assert!(near(found_s, expected_s), "BF{name} comes every {found_s} s");
        // The key decides.
        let per_second = key.ends_with("_hz");
        let twice = if per_second { 0.5 / expected_s } else { 2.0 * expected_s };
        let found_s = period_s(&with(text, key, twice), name);
        assert!(
            near(found_s, 2.0 * expected_s),
            "BF{name} with {key} = {twice}: every {found_s} s"
        );
    }
}

#[test]
fn the_modems_modes_are_the_mocks() {
    let mut stated = BTreeMap::new();
    for row in rows("Modem modes") {
        let numbers: Vec<usize> = row[2..4].iter().map(|cell| cell.parse().expect("a number")).collect();
        for mode in row[1].split(", ") {
            let mode: i32 = mode.parse().expect("a mode");
            stated.insert((row[0].clone(), mode), (numbers[0], numbers[1]));
        }
    }
    let devices = [
        AcousticDevice::Sonardyne6G,
        AcousticDevice::Whoi,
        AcousticDevice::WhoiPsk,
    ];
    let mut found = BTreeMap::new();
    for device in devices {
        for mode in -10..100 {
            if let Some(frames) = device.frames(mode) {
                found.insert((device.name().to_owned(), mode), frames);
            }
        }
    }
    assert_eq!(stated, found);
}

fn commands() -> impl Iterator<Item = &'static Entry> {
    catalogue()
        .iter()
        .filter(|entry| entry.direction == Direction::ToVehicle)
}

/// The status of each acknowledgement of a sentence, which is said at this time. At 30 s the payload has control; at
/// 0.5 s the mission has not begun, and the vehicle is at rest.
fn statuses(text: &str, at_s: f64, sentence: &str) -> Vec<String> {
    let mut payload = Payload::connected(text, 1, &["ACK"]);
    payload.until(at_s);
    payload.say(sentence);
    payload.until(at_s + 10.0);
    of(&payload.heard(), "BFACK")
        .iter()
        .map(|line| field(line, 5).to_owned())
        .collect()
}

/// The catalogue's example of a command, without its checksum.
fn example(entry: &Entry) -> String {
    let body = entry.example.split('*').next().unwrap_or_default();
    body.trim_start_matches('$').to_owned()
}

/// The name of the value to which a wire field belongs. A value can take several fields, and some fields have no value.
fn field_at(entry: &Entry, index: usize) -> &'static str {
    let mut names = entry.fields.iter().flat_map(|field| {
        let reserved = |format: &str| format == "reserved";
        field
            .formats
            .iter()
            .map(move |format| if reserved(format) { "reserved" } else { field.name })
    });
    names.nth(index - 1).unwrap_or("?")
}

const INVALID: &str = "0";
const PENDING: &str = "3";

/// Every command of the catalogue with every one of its fields empty: the table has those that are not invalid.
#[test]
fn the_empty_fields_are_the_mocks() {
    let stated: BTreeSet<String> = rows("Empty fields")
        .iter()
        .map(|row| format!("{} {}", row[0], row[1]))
        .collect();
    let mut found = BTreeSet::new();
    for entry in commands() {
        let fields: Vec<String> = example(entry).split(',').map(str::to_owned).collect();
        // Field 0 is the name and field 1 the time.
        for (index, of) in fields.iter().enumerate().skip(2) {
            if of.is_empty() {
                continue;
            }
            let mut fields = fields.clone();
            fields[index] = String::new();
            let answer = statuses(CALM, 30.0, &format!("${}", fields.join(",")));
            if !answer.iter().any(|status| status == INVALID) {
                found.insert(format!("{} {}", entry.name, field_at(entry, index)));
            }
        }
    }
    assert_eq!(stated, found);
}

/// Every command of the catalogue: the table has those that are answered by "pending" first.
#[test]
fn the_pending_commands_are_the_mocks() {
    let pending = CALM.replace("acknowledge = \"immediate\"\n", "");
    for (column, text) in [(1, pending.as_str()), (2, CALM)] {
        let stated: BTreeSet<String> = rows("Pending commands")
            .iter()
            .filter(|row| row[column] == "yes")
            .map(|row| row[0].clone())
            .collect();
        let mut found = BTreeSet::new();
        for entry in commands() {
            for at_s in [0.5, 30.0] {
                let answers = statuses(text, at_s, &format!("${}", example(entry)));
                if answers.first().is_some_and(|status| status == PENDING) {
                    assert_eq!(answers.len(), 2, "{}: {answers:?}", entry.name);
                    found.insert(entry.name.to_owned());
                }
            }
        }
        assert_eq!(stated, found, "column {column}");
    }
}

/// What a hovering vehicle answers to BPGHP, and where it turns its DVL.
#[test]
fn the_moves_along_a_hull_are_the_mocks() {
    for row in rows("Moves along a hull") {
        let mut payload = Payload::connected(HARBOUR, 1, &["ACK", "PIT"]);
        payload.until(20.0);
        let suspended = !row[0].starts_with("not suspended");
        for tenth in 0..100 {
            payload.until(20.0 + f64::from(tenth) / 10.0);
            if suspended {
                if tenth == 0 {
                    payload.say("$BPSUS,070000.000");
                } else {
                    payload.say("$BPCON,070001.000");
                }
            }
            if tenth == 5 {
                payload.heard();
                payload.say(&format!("$BPGHP,070002.000,{}", row[1]));
                let answer = of(&payload.heard(), "BFACK");
                let said = answer
                    .last()
                    .map_or("", |line| line.split_once(",070002.000,0,").map_or("", |said| said.1));
                assert_eq!(said.replace(",0,", ": ").trim_end_matches(": "), row[2], "{row:?}");
            }
        }
        let servo = of(&payload.heard(), "BFPIT");
        let dvl_deg: f64 = field(servo.last().expect("a BFPIT"), 2).parse().expect("a number");
        assert_eq!(format!("{dvl_deg:.0}"), row[3], "{row:?}");
    }
}
