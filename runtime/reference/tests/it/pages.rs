//! What is made from the tables.

use std::fs;
use std::path::{Path, PathBuf};

use backseat_reference::{Found, REFERENCES, Reference, describe, find, page, schema};

use crate::held;

fn missions() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions")
}

/// A file as JSON, as an editor holds it against a schema.
fn as_json(text: &str) -> serde_json::Value {
    let table: toml::Table = text.parse().expect("our missions are TOML");
    serde_json::to_value(table).expect("TOML without dates is JSON")
}

#[test]
fn entries_are_whole() {
    for reference in REFERENCES.iter() {
        held::none(&held::whole(reference));
    }
}

#[test]
fn the_schemas_accept_our_missions_and_nothing_misspelt() {
    for reference in REFERENCES.iter().filter(|reference| reference.has_schema()) {
        let validator = jsonschema::draft7::new(&schema(reference)).unwrap();
        let mut seen = 0;
        for folder in fs::read_dir(missions()).unwrap() {
            let Ok(text) = fs::read_to_string(folder.unwrap().path().join(&reference.file)) else {
                continue;
            };
            seen += 1;
            let errors: Vec<String> = validator
                .iter_errors(&as_json(&text))
                .map(|error| format!("{}: {error}", error.instance_path))
                .collect();
            assert!(errors.is_empty(), "{}:\n{}", reference.file, errors.join("\n"));
            let misspelt = text.replacen("_m", "_meters", 1);
            assert!(!validator.is_valid(&as_json(&misspelt)), "{}", reference.file);
        }
        assert!(seen > 0 || !matches!(reference.name.as_str(), "mission" | "world"));
    }
}

/// A box to stay in lies on the outer side of the hull, and a box to keep out of may reach into it.
#[test]
fn a_box_to_keep_out_of_may_begin_inside_the_hull() {
    let validator = jsonschema::draft7::new(&schema(Reference::of("mission").unwrap())).unwrap();
    let mission = "
        [[limits.station.keep_out_hull]]
        horizontal_min_m = -1.0
        horizontal_max_m = 1.0
        vertical_min_m = -1.0
        vertical_max_m = 1.0
        distance_min_m = -0.5
        distance_max_m = 3.0";
    let within = "/limits/station/keep_out_hull";
    let refused: Vec<String> = validator
        .iter_errors(&as_json(mission))
        .filter(|error| error.instance_path.to_string().starts_with(within))
        .map(|error| error.to_string())
        .collect();
    assert!(refused.is_empty(), "{refused:?}");
}

#[test]
fn missions_name_their_schema_for_editors() {
    for name in ["isobath", "plume", "template"] {
        for file in ["mission", "world"] {
            if Reference::of(file).is_none() {
                continue;
            }
            let text = fs::read_to_string(missions().join(format!("{name}/{file}.toml"))).unwrap();
            let first = text.lines().next().unwrap();
            assert_eq!(first, format!("#:schema ../schemas/{file}.schema.json"), "{name}");
        }
    }
}

#[test]
fn a_key_is_found_whole_by_its_end_and_where_it_is_misspelt() {
    let Found::Entries(found) = find("limits.turn_rate_dps") else {
        panic!("not found")
    };
    assert_eq!(found.len(), 1);
    let Found::Entries(found) = find("mission.toml:turn_rate_dps") else {
        panic!("not found by its end")
    };
    let (reference, entry) = found[0];
    let text = describe(reference, entry);
    for part in [
        "limits.turn_rate_dps in mission.toml",
        "degrees/s",
        "required",
        "turn_rate_dps = 8.0",
        "fence",
    ] {
        assert!(text.contains(part), "no {part} in\n{text}");
    }
    let Found::Similar(names) = find("turn_rate") else {
        panic!("found what is not there")
    };
    assert_eq!(names.first().map(String::as_str), Some("limits.turn_rate_dps"));
    assert!(matches!(find("zzzzzz"), Found::Similar(names) if names.is_empty()));
}

#[test]
fn a_page_has_every_key_and_every_word() {
    for reference in REFERENCES.iter() {
        let page = page(reference);
        for entry in &reference.entries {
            assert!(page.contains(entry.name()), "{}", entry.key);
            for choice in &entry.values {
                assert!(page.contains(&choice.meaning), "{} {}", entry.key, choice.value);
            }
        }
    }
}

/// The page with the tables of the mock lists every key of world.toml, and names no other.
#[test]
fn the_mocks_page_lists_every_key() {
    let page = include_str!("../../../docs/mock-tables.md");
    let world = Reference::of("world.toml").expect("it is registered");
    let is_path =
        |word: &&str| word.contains('.') && word.bytes().all(|byte| matches!(byte, b'a'..=b'z' | b'_' | b'.'));
    for key in page.split('`').skip(1).step_by(2).filter(is_path) {
        assert!(
            key.ends_with(".toml") || world.entry(key).is_some(),
            "there is no key `{key}`"
        );
    }
    let (_, list) = page.split_once("\n## All keys\n").expect("the page has this section");
    let mut stated: Vec<String> = list
        .lines()
        .filter_map(|line| line.strip_prefix("| `[")?.split_once("]` | "))
        .map(|(table, keys)| {
            let keys = keys.trim_end_matches(" |").replace('`', "");
            format!("{}: {keys}", table.trim_matches(['[', ']']))
        })
        .collect();
    let mut expected: Vec<String> = world
        .entries
        .iter()
        .filter(|entry| entry.is_table())
        .map(|table| {
            let keys = world.within(&table.key).filter(|entry| !entry.is_table());
            let names: Vec<&str> = keys.map(backseat_reference::Entry::name).collect();
            format!("{}: {}", table.key, names.join(", "))
        })
        .collect();
    stated.sort();
    expected.sort();
    assert_eq!(stated, expected);
}
