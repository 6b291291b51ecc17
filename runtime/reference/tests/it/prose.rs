//! The keys that the pages name in their prose.

use std::path::Path;

use backseat_reference::{Found, Reference, find};

/// What follows a dot in the name of a file, and not in a key.
const ENDINGS: [&str; 12] = [
    "toml", "rs", "py", "csv", "md", "svg", "wasm", "mcap", "lock", "geojson", "kml", "plan",
];

/// Whether somebody who reads this takes it for a key of `mission.toml`: a table of it, a dot and a name.
fn looks_like_a_key(word: &str, tables: &[&str]) -> bool {
    let plain = |character: char| character.is_ascii_lowercase() || matches!(character, '_' | '.');
    let (Some((table, _)), Some((_, last))) = (word.split_once('.'), word.rsplit_once('.')) else {
        return false;
    };
    word.chars().all(plain) && tables.contains(&table) && !ENDINGS.contains(&last) && !word.contains(".config.")
        // A command of the SDK for Python.
        && word != "fence.check"
}

#[test]
fn every_key_of_a_mission_that_a_page_names_can_be_explained() {
    let mission = Reference::of("mission.toml").unwrap();
    let tables: Vec<&str> = mission.within("").map(|entry| entry.key.as_str()).collect();
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
    let (mut looked, mut unknown) = (0, Vec::new());
    for page in std::fs::read_dir(docs).unwrap() {
        let path = page.unwrap().path();
        if path.extension().is_none_or(|ending| ending != "md") {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        for word in text.split('`').filter(|word| looks_like_a_key(word, &tables)) {
            looked += 1;
            if matches!(find(word), Found::Similar(_)) {
                unknown.push(format!("{}: {word}", path.display()));
            }
        }
    }
    assert!(looked > 25, "{looked}");
    assert!(unknown.is_empty(), "{}", unknown.join("\n"));
}
