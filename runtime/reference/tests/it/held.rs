//! What every table is held to, whichever file it describes.

use std::collections::BTreeSet;

use backseat_reference::{Entry, Kind, Reference};
use toml::{Table, Value};

use crate::document::{self, around, example, place, with, without};

/// A program's reader of a file: what it made of it, as text that can be compared, or its error.
pub(crate) type Read<'a> = &'a dyn Fn(&Table) -> Result<String, String>;

/// A name that no file has.
const NOBODY: &str = "nobody_knows_this";

/// Every key that the code reads has an entry, and every entry is a key.
pub(crate) fn keys(reference: &Reference, read: Read<'_>) -> Vec<String> {
    document::of(reference);
    let mut faults = Vec::new();
    let mut tables: Vec<&str> = vec![""];
    tables.extend(
        reference
            .entries
            .iter()
            .filter(|entry| entry.is_table())
            .map(|entry| entry.key.as_str()),
    );
    for table in tables {
        let mut file = around(reference, table);
        place(&mut file, table).insert(NOBODY.to_owned(), Value::Integer(1));
        let listed = reference.within(table).map(|entry| entry.name().to_owned()).collect();
        compare(&mut faults, &format!("[{table}]"), listed, read(&file));
    }
    for entry in &reference.entries {
        let nobody = Value::String(NOBODY.to_owned());
        let value = if entry.kind == Kind::Choice {
            nobody
        } else if entry.kind == Kind::Choices {
            Value::Array(vec![nobody])
        } else {
            continue;
        };
        let mut listed: BTreeSet<String> = entry.values.iter().map(|choice| choice.value.clone()).collect();
        listed.extend(reference.within(&entry.key).map(|below| below.name().to_owned()));
        compare(&mut faults, &entry.key, listed, read(&with(reference, entry, value)));
    }
    faults
}

/// serde's own errors list the names that a type has: "unknown field `a`, expected one of `b`, `c`".
fn compare(faults: &mut Vec<String>, place: &str, listed: BTreeSet<String>, answer: Result<String, String>) {
    let Err(error) = answer else {
        faults.push(format!("{place}: `{NOBODY}` is taken"));
        return;
    };
    let rest = error.split_once(NOBODY).map_or("", |(_, rest)| rest);
    // In a variant of an enum: "unexpected keys in table: a, available keys: b, c".
    let known: BTreeSet<String> = match (rest.split_once("expected"), rest.split_once("available keys:")) {
        (Some((_, names)), _) => names.split('`').skip(1).step_by(2).map(str::to_owned).collect(),
        (None, Some((_, names))) => names.split(',').map(|name| name.trim().to_owned()).collect(),
        (None, None) => {
            faults.push(format!("{place}: {error}"));
            return;
        }
    };
    for name in known.difference(&listed) {
        faults.push(format!("{place}: `{name}` has no entry"));
    }
    for name in listed.difference(&known) {
        faults.push(format!("{place}: the entry `{name}` is no key"));
    }
}

/// Each example is taken, and means something; each default is what the code takes where the key is absent; each
/// required key is missed.
pub(crate) fn values(reference: &Reference, read: Read<'_>) -> Vec<String> {
    document::of(reference);
    let mut faults = Vec::new();
    for entry in reference.entries.iter().filter(|entry| !entry.is_table()) {
        let key = &entry.key;
        let taken = match read(&with(reference, entry, example(entry))) {
            Ok(taken) => taken,
            Err(error) => {
                faults.push(format!("{key}: its example is refused: {error}"));
                continue;
            }
        };
        let inside_choice = reference
            .entry(entry.table())
            .is_some_and(|table| table.kind == Kind::Choice);
        match (read(&without(reference, entry)), &entry.default) {
            _ if inside_choice => {}
            (Ok(_), _) if entry.required => faults.push(format!("{key}: is not required")),
            (Err(error), _) if entry.required => {
                if !error.contains(entry.name()) {
                    faults.push(format!(
                        "{key}: where it is missing, the error does not name it: {error}"
                    ));
                }
            }
            (Err(error), _) => faults.push(format!("{key}: is required: {error}")),
            (Ok(absent), Some(default)) => match read(&with(reference, entry, default.clone())) {
                Ok(default) if default == absent => {}
                Ok(_) => faults.push(format!("{key}: {default} is not its default")),
                Err(error) => faults.push(format!("{key}: its default is refused: {error}")),
            },
            (Ok(absent), None) => {
                if entry.absent.is_none() {
                    faults.push(format!(
                        "{key}: neither required, nor default, nor what happens without it"
                    ));
                }
                if absent == taken {
                    faults.push(format!("{key}: its example changes nothing"));
                }
            }
        }
    }
    faults
}

/// Each bound is where the code has it, and an error beyond it names the key.
pub(crate) fn bounds(reference: &Reference, read: Read<'_>) -> Vec<String> {
    document::of(reference);
    let mut faults = Vec::new();
    for entry in &reference.entries {
        let number = |value: f64| {
            #[expect(clippy::cast_possible_truncation, reason = "bounds of whole numbers are whole")]
            let whole = || Value::Integer(value as i64);
            match entry.kind {
                Kind::Number | Kind::Drawn => Some(Value::Float(value)),
                Kind::Numbers => Some(Value::Array(vec![Value::Float(value)])),
                Kind::Integer => Some(whole()),
                Kind::Boolean
                | Kind::String
                | Kind::Choice
                | Kind::Time
                | Kind::Strings
                | Kind::Choices
                | Kind::Table
                | Kind::Tables
                | Kind::Free => None,
            }
        };
        if number(0.0).is_none() {
            continue;
        }
        let read_with = |value: f64| match number(value) {
            Some(value) => read(&with(reference, entry, value)),
            None => Err("no number".to_owned()),
        };
        let step = |bound: f64| {
            if entry.kind == Kind::Integer {
                1.0
            } else {
                bound.abs().max(1.0) * 1e-6
            }
        };
        let (mut good, mut bad) = (Vec::new(), Vec::new());
        if let Some(min) = entry.min {
            good.push(min);
            bad.push(min - step(min));
        }
        if let Some(max) = entry.max {
            good.push(max);
            bad.push(max + step(max));
        }
        if let Some(above) = entry.above {
            good.push(above + step(above));
            bad.push(above);
        }
        if let Some(below) = entry.below {
            good.push(below - step(below));
            bad.push(below);
        }
        if entry.kind != Kind::Integer {
            bad.push(f64::NAN);
            bad.push(f64::INFINITY);
        }
        for value in bad {
            match read_with(value) {
                Ok(_) => faults.push(format!("{}: {value} is taken", entry.key)),
                Err(error) if !names(&error, entry) => {
                    faults.push(format!(
                        "{}: the error for {value} does not name it: {error}",
                        entry.key
                    ));
                }
                Err(_) => {}
            }
        }
        // A condition on other keys may refuse a bound that the range allows.
        if entry.condition.is_none() {
            for value in good {
                if let Err(error) = read_with(value) {
                    faults.push(format!("{}: {value} is refused: {error}", entry.key));
                }
            }
        }
    }
    faults
}

fn names(error: &str, entry: &Entry) -> bool {
    error.contains(entry.name())
        || entry
            .table()
            .rsplit('.')
            .any(|table| !table.is_empty() && error.contains(table))
}

/// What each entry must have for its reader.
pub(crate) fn whole(reference: &Reference) -> Vec<String> {
    let mut faults = Vec::new();
    let mut seen = BTreeSet::new();
    for entry in &reference.entries {
        let key = &entry.key;
        let mut must = |holds: bool, what: &str| {
            if !holds {
                faults.push(format!("{key}: {what}"));
            }
        };
        must(seen.insert(key.clone()), "is there twice");
        must(entry.meaning.ends_with('.'), "its meaning is no sentence");
        must(
            entry.table().is_empty() || reference.entry(entry.table()).is_some(),
            "its table has no entry",
        );
        let words = matches!(entry.kind, Kind::Choice | Kind::Choices);
        must(
            !words || !entry.values.is_empty() || reference.within(key).next().is_some(),
            "has no words",
        );
        must(
            entry.values.iter().all(|choice| choice.meaning.ends_with('.')),
            "a word has no meaning",
        );
        for (ending, unit) in UNITS {
            if key.ends_with(ending) {
                must(entry.unit.as_deref() == Some(unit), &format!("its unit is not {unit}"));
                break;
            }
        }
    }
    faults
}

/// What the ending of a key says of its unit; longer endings first.
const UNITS: [(&str, &str); 10] = [
    ("_per_s", "1/s"),
    ("_per_min", "1/min"),
    ("_mps", "m/s"),
    ("_dps", "degrees/s"),
    ("_deg", "degrees"),
    ("_hz", "1/s"),
    ("_kpa", "kPa"),
    ("_wh", "Wh"),
    ("_s", "s"),
    ("_m", "m"),
];

pub(crate) fn none(faults: &[String]) {
    assert!(faults.is_empty(), "\n{}\n", faults.join("\n"));
}
