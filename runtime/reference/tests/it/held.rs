//! What every table is held to, whichever file it describes.

use std::collections::BTreeSet;

use backseat_reference::{Entry, Kind, Reference};
use toml::{Table, Value};

use crate::document::{self, around, example, place, with, with_of, without_of};

/// A program's reader of a file: what it made of it, as text that can be compared, or its error.
pub(crate) type Read<'a> = &'a dyn Fn(&Table) -> Result<String, String>;

/// A name that no file has.
pub(crate) const NOBODY: &str = "nobody_knows_this";

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
pub(crate) fn compare(faults: &mut Vec<String>, place: &str, listed: BTreeSet<String>, answer: Result<String, String>) {
    let Err(error) = answer else {
        faults.push(format!("{place}: `{NOBODY}` is taken"));
        return;
    };
    let rest = error.split_once(NOBODY).map_or("", |(_, rest)| rest);
    // In a variant of an enum: "unexpected keys in table: a, available keys: b, c".
    let known: BTreeSet<String> = match (rest.split_once("expected"), rest.split_once("available keys:")) {
        (Some((_, names)), _) => names
            .split('`')
            .skip(1)
            .step_by(2)
            // An error may end with the line of the file that it is about.
            .filter(|name| !name.contains(NOBODY))
            .map(str::to_owned)
            .collect(),
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
/// required key is missed. All of that for each kind of table that has the key.
pub(crate) fn values(reference: &Reference, read: Read<'_>) -> Vec<String> {
    document::of(reference);
    let mut faults = Vec::new();
    for entry in &reference.entries {
        for kind in kinds_of(reference, entry) {
            let mut found = Vec::new();
            if entry.is_table() {
                presence(&mut found, reference, entry, kind.as_deref(), read);
            } else {
                value(&mut found, reference, entry, kind.as_deref(), read);
            }
            let place = match &kind {
                Some(kind) => format!("{} of {kind}", entry.key),
                None => entry.key.clone(),
            };
            faults.extend(found.into_iter().map(|fault| format!("{place}: {fault}")));
        }
    }
    faults
}

/// The kinds of table that an entry says something about; none alone where it is the same in all.
fn kinds_of(reference: &Reference, entry: &Entry) -> Vec<Option<String>> {
    if entry.only.is_empty() && entry.required_of.is_empty() {
        return vec![None];
    }
    let kinds = document::kinds(reference, entry.table()).into_iter();
    kinds.filter(|kind| entry.is_of(Some(kind))).map(Some).collect()
}

/// A table that is required is missed; another one is not.
fn presence(faults: &mut Vec<String>, reference: &Reference, entry: &Entry, kind: Option<&str>, read: Read<'_>) {
    let inside_choice = reference
        .entry(entry.table())
        .is_some_and(|table| table.kind == Kind::Choice);
    let required = entry.is_required(kind);
    match read(&without_of(reference, entry, kind)) {
        _ if inside_choice => {}
        Ok(_) if required => faults.push("is not required".to_owned()),
        Err(error) if !required => faults.push(format!("is required: {error}")),
        Err(error) if !error.contains(entry.name()) => {
            faults.push(format!("where it is missing, the error does not name it: {error}"));
        }
        Ok(_) | Err(_) => {}
    }
}

fn value(faults: &mut Vec<String>, reference: &Reference, entry: &Entry, kind: Option<&str>, read: Read<'_>) {
    let taken = match read(&with_of(reference, entry, example(entry), kind)) {
        Ok(taken) => taken,
        Err(error) => {
            faults.push(format!("its example is refused: {error}"));
            return;
        }
    };
    if matches!(entry.kind, Kind::NumberOrSeed | Kind::BooleanOrSeed) {
        match read(&with_of(reference, entry, Value::String("seed".to_owned()), kind)) {
            Ok(seeded) if seeded != taken => {}
            Ok(_) => faults.push("`seed` is its example".to_owned()),
            Err(error) => faults.push(format!("`seed` is refused: {error}")),
        }
    }
    let inside_choice = reference
        .entry(entry.table())
        .is_some_and(|table| table.kind == Kind::Choice);
    let required = entry.is_required(kind);
    let without = match &entry.default {
        // What the key needs is there with the default, and so without it.
        Some(default) => {
            let mut document = with_of(reference, entry, default.clone(), kind);
            place(&mut document, entry.table()).remove(entry.name());
            document
        }
        None => without_of(reference, entry, kind),
    };
    match (read(&without), &entry.default) {
        _ if inside_choice => {}
        (Ok(_), _) if required => faults.push("is not required".to_owned()),
        (Err(error), _) if required => {
            if !error.contains(entry.name()) {
                faults.push(format!("where it is missing, the error does not name it: {error}"));
            }
        }
        (Err(error), _) => faults.push(format!("is required: {error}")),
        (Ok(absent), Some(default)) => {
            match read(&with_of(reference, entry, default.clone(), kind)) {
                Ok(default) if default == absent => {}
                Ok(_) => faults.push(format!("{default} is not its default")),
                Err(error) => faults.push(format!("its default is refused: {error}")),
            }
            if absent == taken && default != &example(entry) {
                faults.push("its example changes nothing".to_owned());
            }
        }
        (Ok(absent), None) => {
            if entry.absent.is_none() {
                faults.push("neither required, nor default, nor what happens without it".to_owned());
            }
            if absent == taken {
                faults.push("its example changes nothing".to_owned());
            }
        }
    }
}

/// No other kind of table takes a key of some kinds, nothing takes two keys of which one is instead of the other, and what
/// a key needs must be there.
pub(crate) fn company(reference: &Reference, read: Read<'_>) -> Vec<String> {
    document::of(reference);
    let mut faults = Vec::new();
    for entry in reference.entries.iter().filter(|entry| !entry.is_table()) {
        let key = &entry.key;
        let mut refused = |document: &Table, why: &str| match read(document) {
            Ok(_) => faults.push(format!("{key}: is taken {why}")),
            Err(error) if !names(&error, entry) => {
                faults.push(format!("{key}: the error {why} does not name it: {error}"));
            }
            Err(_) => {}
        };
        for kind in document::kinds(reference, entry.table()) {
            if !entry.is_of(Some(&kind)) {
                let document = with_of(reference, entry, example(entry), Some(&kind));
                refused(&document, &format!("where the kind is {kind}"));
            }
        }
        for other in entry.instead_of.iter().filter_map(|other| reference.entry(other)) {
            let mut document = if other.is_table() {
                around(reference, &other.key)
            } else {
                with(reference, other, example(other))
            };
            place(&mut document, entry.table()).insert(entry.name().to_owned(), example(entry));
            refused(&document, &format!("beside {}", other.key));
        }
        for needed in entry.needs.iter().filter_map(|needed| reference.entry(needed)) {
            for kind in kinds_of(reference, entry) {
                if needed.is_of(kind.as_deref()) {
                    let mut document = with_of(reference, entry, example(entry), kind.as_deref());
                    place(&mut document, needed.table()).remove(needed.name());
                    refused(&document, &format!("without {}", needed.key));
                }
            }
        }
    }
    faults
}

/// Each bound is where the code has it, and an error beyond it names the key. Where no bound is stated, the code has none.
/// `elsewhere` are keys whose bounds other keys keep these files from, in every kind of table.
pub(crate) fn bounds(reference: &Reference, elsewhere: &[&str], read: Read<'_>) -> Vec<String> {
    document::of(reference);
    let mut faults = Vec::new();
    for entry in &reference.entries {
        let is_list = matches!(entry.kind, Kind::Numbers | Kind::Integers);
        let number = |value: f64| {
            #[expect(clippy::cast_possible_truncation, reason = "bounds of whole numbers are whole")]
            let number = if is_whole(entry) {
                Value::Integer(value as i64)
            } else {
                Value::Float(value)
            };
            if is_list { Value::Array(vec![number]) } else { number }
        };
        if !matches!(
            entry.kind,
            Kind::Number | Kind::Integer | Kind::Drawn | Kind::NumberOrSeed | Kind::Numbers | Kind::Integers
        ) {
            continue;
        }
        let (good, bad) = edges(entry);
        for value in bad {
            let mut forms = vec![number(value)];
            if entry.kind == Kind::Drawn {
                // Both ends of a span are held to the bounds.
                forms.push(Value::Array(vec![Value::Float(value), Value::Float(value)]));
            }
            for form in forms {
                match read(&with(reference, entry, form.clone())) {
                    Ok(_) => faults.push(format!("{}: {form} is taken", entry.key)),
                    Err(error) if !names(&error, entry) => {
                        faults.push(format!("{}: the error for {form} does not name it: {error}", entry.key));
                    }
                    Err(_) => {}
                }
            }
        }
        let mut forms: Vec<Value> = good.iter().map(|value| number(*value)).collect();
        if let (Kind::Drawn, [least, most]) = (entry.kind, &*good) {
            forms.push(Value::Array(vec![Value::Float(*least), Value::Float(*most)]));
        }
        for form in forms {
            if let Some(error) = refusal(reference, entry, &form, read)
                && !elsewhere.contains(&&*entry.key)
            {
                faults.push(format!("{}: {form} is refused: {error}", entry.key));
            }
        }
    }
    faults
}

/// Why the code does not take a value within the stated bounds; none where it does.
fn refusal(reference: &Reference, entry: &Entry, value: &Value, read: Read<'_>) -> Option<String> {
    let kinds = document::kinds(reference, entry.table()).into_iter();
    let kinds: Vec<String> = kinds.filter(|kind| entry.is_of(Some(kind))).collect();
    let answer = |kind| read(&with_of(reference, entry, value.clone(), kind)).err();
    if kinds.is_empty() {
        // A condition on other keys may refuse a bound that the range allows.
        return answer(None).filter(|_| entry.condition.is_none());
    }
    let refusals: Vec<Option<String>> = kinds.iter().map(|kind| answer(Some(kind))).collect();
    // In one kind of table it may, and in another there is no such condition.
    if entry.condition.is_some() && refusals.contains(&None) {
        return None;
    }
    refusals.into_iter().flatten().next()
}

/// Values that the code must take, and values that it must refuse.
fn edges(entry: &Entry) -> (Vec<f64>, Vec<f64>) {
    /// Greater than any number that a file means.
    const HUGE: f64 = 1e300;
    let step = |bound: f64| {
        if is_whole(entry) {
            1.0
        } else {
            bound.abs().max(1.0) * 1e-6
        }
    };
    let (mut good, mut bad) = (Vec::new(), Vec::new());
    match (entry.min, entry.above) {
        (Some(min), _) => {
            good.push(min);
            bad.push(min - step(min));
        }
        (None, Some(above)) => {
            good.push(above + step(above));
            bad.push(above);
        }
        // What else bounds it, the condition says.
        (None, None) if entry.condition.is_some() => {}
        (None, None) if is_whole(entry) => good.push(-1.0),
        (None, None) => good.push(-HUGE),
    }
    match (entry.max, entry.below) {
        (Some(max), _) => {
            good.push(max);
            bad.push(max + step(max));
        }
        (None, Some(below)) => {
            good.push(below - step(below));
            bad.push(below);
        }
        (None, None) if entry.condition.is_some() => {}
        // No type of a whole number has less room.
        (None, None) if is_whole(entry) => good.push(f64::from(i32::MAX)),
        (None, None) => good.push(HUGE),
    }
    // The code cannot take what is no number where it asks for a range.
    let ranged = !bad.is_empty() || entry.condition.is_some();
    if !is_whole(entry) && ranged {
        bad.extend([f64::NAN, f64::INFINITY]);
    }
    (good, bad)
}

fn is_whole(entry: &Entry) -> bool {
    matches!(entry.kind, Kind::Integer | Kind::Integers)
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
const UNITS: [(&str, &str); 30] = [
    ("_mps_per_sqrt_s", "m/s per √s"),
    ("_deg_per_sqrt_h", "degrees per √h"),
    ("_m_per_sqrt_h", "m per √h"),
    ("_m2_per_s", "m²/s"),
    ("_n_per_s", "N/s"),
    ("_c_per_m", "°C/m"),
    ("_c_per_100w", "°C per 100 W"),
    ("_us_per_cm", "µS/cm"),
    ("_deg_per_n", "degrees/N"),
    ("_w_at_1_mps", "W"),
    ("_per_min", "1/min"),
    ("_per_s", "1/s"),
    ("_per_h", "1/h"),
    ("_mps2", "m/s²"),
    ("_mps", "m/s"),
    ("_dps", "degrees/s"),
    ("_dph", "degrees/h"),
    ("_deg", "degrees"),
    ("_percent", "%"),
    ("_hz", "1/s"),
    ("_kpa", "kPa"),
    ("_wh", "Wh"),
    ("_ohm", "Ω"),
    ("_db", "dB"),
    ("_c", "°C"),
    ("_h", "h"),
    ("_n", "N"),
    ("_s", "s"),
    ("_w", "W"),
    ("_m", "m"),
];

pub(crate) fn none(faults: &[String]) {
    assert!(faults.is_empty(), "\n{}\n", faults.join("\n"));
}
