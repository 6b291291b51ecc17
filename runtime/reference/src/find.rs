use crate::entry::Entry;
use crate::reference::{REFERENCES, Reference};

/// How alike a name must be to be suggested, 0 to 1.
const LIKENESS_MIN: f64 = 0.8;
/// How many names are suggested at most.
const SUGGESTIONS_MAX: usize = 5;

/// What is known of a key that somebody asks for.
#[derive(Debug)]
pub enum Found {
    /// Entries with this key, in one file or several.
    Entries(Vec<(&'static Reference, &'static Entry)>),
    /// None, but these are spelt alike.
    Similar(Vec<String>),
}

/// Looks a key up: whole (`limits.speed_max_mps`), or its end (`speed_max_mps`), or a file's name and a key
/// (`world.toml vehicle.class` is written `world.toml:vehicle.class`).
#[must_use]
pub fn find(asked: &str) -> Found {
    let (file, key) = match asked.split_once(':') {
        Some((file, key)) => (Some(file), key),
        None => (None, asked),
    };
    let key = key.trim_matches(|character| matches!(character, '[' | ']' | ' '));
    let all = || {
        REFERENCES
            .iter()
            .filter(move |reference| file.is_none_or(|file| reference.file == file || reference.name == file))
            .flat_map(|reference| reference.entries.iter().map(move |entry| (reference, entry)))
    };
    let whole: Vec<_> = all().filter(|(_, entry)| entry.key == key).collect();
    if !whole.is_empty() {
        return Found::Entries(whole);
    }
    // As `--set` and campaigns name a key of the world.
    if let (None, Some(of_world)) = (file, key.strip_prefix("world.")) {
        return find(&format!("world.toml:{of_world}"));
    }
    let end = format!(".{key}");
    let ends: Vec<_> = all().filter(|(_, entry)| entry.key.ends_with(&end)).collect();
    if !ends.is_empty() {
        return Found::Entries(ends);
    }
    let mut similar: Vec<(f64, String)> = all()
        .map(|(_, entry)| {
            let likeness = strsim::jaro_winkler(key, &entry.key).max(strsim::jaro_winkler(key, entry.name()));
            (likeness, entry.key.clone())
        })
        .filter(|(likeness, _)| *likeness >= LIKENESS_MIN)
        .collect();
    similar.sort_by(|a, b| b.0.total_cmp(&a.0).then_with(|| a.1.cmp(&b.1)));
    similar.dedup_by(|a, b| a.1 == b.1);
    similar.truncate(SUGGESTIONS_MAX);
    Found::Similar(similar.into_iter().map(|(_, key)| key).collect())
}
