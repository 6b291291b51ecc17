use core::fmt::Write as _;

use crate::entry::{Entry, Kind};
use crate::exit::EXITS;
use crate::reference::Reference;

/// The file's page, as Markdown.
#[must_use]
pub fn page(reference: &Reference) -> String {
    let mut text = format!("# `{}`\n\n{}\n\n", reference.file, reference.meaning);
    let schema = if reference.has_schema() {
        format!(
            " Editors read the same from `missions/schemas/{}.schema.json`.",
            reference.name
        )
    } else {
        String::new()
    };
    let _ = writeln!(
        text,
        "`backseat explain KEY` prints one entry.{schema} This page is generated: change `runtime/reference/keys/{}.toml` \
         and run `cargo xtask reference`.",
        reference.name
    );
    section(&mut text, reference, "");
    for table in reference.entries.iter().filter(|entry| entry.is_table()) {
        let heading = if reference.printed {
            table.key.clone()
        } else {
            header(reference, &table.key)
        };
        let _ = write!(text, "\n## `{heading}`\n\n{}", table.meaning);
        if let Some(absent) = &table.absent {
            let _ = write!(text, " Without it: {absent}.");
        }
        if let Some(other) = &table.same_as {
            let _ = write!(text, " Its keys are those of `{}`", header(reference, other));
            let except: Vec<&str> = table.except.iter().map(|key| last(key)).collect();
            if !except.is_empty() {
                let _ = write!(text, ", without `{}`", except.join("` and `"));
            }
            text.push('.');
        }
        text.push('\n');
        if table.same_as.is_none() {
            section(&mut text, reference, &table.key);
        }
    }
    text
}

/// The keys of a table, their words, and an example.
fn section(text: &mut String, reference: &Reference, table: &str) {
    let keys: Vec<&Entry> = reference.within(table).filter(|entry| !entry.is_table()).collect();
    if keys.is_empty() {
        return;
    }
    let kinds = keys.iter().any(|entry| !entry.only.is_empty());
    text.push_str(if reference.printed {
        "\n| key | value | meaning |\n|---|---|---|\n"
    } else {
        "\n| key | value | without it | meaning |\n|---|---|---|---|\n"
    });
    for entry in &keys {
        let mut meaning = entry.meaning.clone();
        if kinds && !entry.only.is_empty() {
            meaning = format!("For {}. {meaning}", kinds_of(reference, entry, &entry.only));
        }
        let _ = write!(text, "| `{}` | {} | ", entry.name(), cell(&value(entry)));
        if !reference.printed {
            let _ = write!(text, "{} | ", cell(&without(reference, entry)));
        }
        let _ = writeln!(text, "{} |", cell(&meaning));
    }
    for entry in keys.iter().filter(|entry| !entry.values.is_empty()) {
        let _ = writeln!(text, "\n`{}` takes:\n", entry.name());
        for choice in &entry.values {
            let _ = writeln!(text, "- `{}`: {}", choice.value, choice.meaning);
        }
        for below in reference.within(&entry.key) {
            let _ = writeln!(text, "- `{{ {} = ... }}`: {}", below.name(), below.meaning);
            for choice in &below.values {
                let _ = writeln!(text, "  - `{}`: {}", choice.value, choice.meaning);
            }
        }
    }
    // Of keys that may not stand together, the first; and nothing that needs the others.
    let second = |entry: &Entry| {
        let mut before = keys.iter().take_while(|other| other.key != entry.key);
        before.any(|other| entry.instead_of.contains(&other.key))
    };
    let shown = keys.iter().filter(|entry| {
        let mut needed = keys.iter().filter(|other| entry.needs.contains(&other.key));
        !second(entry) && !needed.any(|other| second(other))
    });
    let examples: Vec<String> = shown.filter_map(|entry| assignment(entry)).collect();
    if !kinds && !examples.is_empty() {
        let _ = writeln!(text, "\n```toml");
        if !table.is_empty() {
            let _ = writeln!(text, "{}", header(reference, table));
        }
        let _ = writeln!(text, "{}\n```", examples.join("\n"));
    }
}

fn last(key: &str) -> &str {
    key.rsplit_once('.').map_or(key, |(_, name)| name)
}

/// An entry as `backseat explain` prints it.
#[must_use]
pub fn describe(reference: &Reference, entry: &Entry) -> String {
    let mut text = format!("{} in {}\n", entry.key, reference.file);
    for line in wrapped(&entry.meaning) {
        let _ = writeln!(text, "  {line}");
    }
    text.push('\n');
    if !entry.only.is_empty() {
        let _ = writeln!(
            text,
            "  for:        {}",
            plain(&kinds_of(reference, entry, &entry.only))
        );
    }
    let _ = writeln!(text, "  value:      {}", plain(&value(entry)));
    if !reference.printed {
        let _ = writeln!(text, "  without it: {}", plain(&without(reference, entry)));
    }
    let below: Vec<&Entry> = reference.within(&entry.key).collect();
    let mut words: Vec<(String, &str)> = entry
        .values
        .iter()
        .map(|choice| (choice.value.clone(), choice.meaning.as_str()))
        .collect();
    if entry.kind == Kind::Choice {
        words.extend(
            below
                .iter()
                .map(|entry| (format!("{{ {} = ... }}", entry.name()), entry.meaning.as_str())),
        );
    }
    let width = words.iter().map(|(word, _)| word.len()).max().unwrap_or(0);
    for (word, meaning) in words {
        let _ = writeln!(text, "    {word:<width$}  {}", plain(meaning));
    }
    if entry.is_table() && !below.is_empty() {
        let names: Vec<&str> = below.iter().map(|entry| entry.name()).collect();
        let line = format!("keys below: {}", names.join(", "));
        for line in wrapped(&line) {
            let _ = writeln!(text, "  {line}");
        }
    }
    if let Some(example) = assignment(entry) {
        let _ = writeln!(text, "\n  example:");
        if !entry.table().is_empty() {
            let _ = writeln!(text, "    {}", header(reference, entry.table()));
        }
        let _ = writeln!(text, "    {example}");
    }
    text
}

/// `[table]` or `[[table]]`, as it is written in a file.
fn header(reference: &Reference, key: &str) -> String {
    if let Some((file, key)) = key.split_once(':')
        && let Some(other) = Reference::of(file)
    {
        return format!("{}` of `{file}", header(other, key));
    }
    match reference.entry(key).map(|entry| entry.kind) {
        Some(Kind::Tables) => format!("[[{key}]]"),
        _ => format!("[{key}]"),
    }
}

/// What a key takes: kind, unit, range and condition.
fn value(entry: &Entry) -> String {
    let mut parts = vec![entry.kind.describe().to_owned()];
    parts.extend(entry.unit.clone());
    let range = entry.range();
    if !range.is_empty() {
        parts.push(range);
    }
    parts.extend(entry.condition.clone());
    parts.extend(entry.needs.iter().map(|key| format!("together with `{key}`")));
    if !entry.required {
        parts.extend(entry.instead_of.iter().map(|key| format!("not together with `{key}`")));
    }
    parts.join("; ")
}

/// Some of the kinds of the entry's table: by name, or by the names of the others where those are fewer.
fn kinds_of(reference: &Reference, entry: &Entry, kinds: &[String]) -> String {
    let all = reference.within(entry.table()).find(|entry| entry.name() == "kind");
    let others: Vec<&str> = all
        .iter()
        .flat_map(|entry| &entry.values)
        .map(|choice| choice.value.as_str())
        .filter(|kind| !kinds.iter().any(|listed| listed == kind))
        .collect();
    let quoted = |kinds: &[&str]| {
        kinds
            .iter()
            .map(|kind| format!("`{kind}`"))
            .collect::<Vec<_>>()
            .join(", ")
    };
    if others.is_empty() {
        "every kind".to_owned()
    } else if others.len() < kinds.len() {
        format!("every kind but {}", quoted(&others))
    } else {
        quoted(&kinds.iter().map(String::as_str).collect::<Vec<_>>())
    }
}

/// What happens without the key.
fn without(reference: &Reference, entry: &Entry) -> String {
    if entry.required {
        return match &*entry.instead_of {
            [] => "required".to_owned(),
            others => format!("required, or else `{}`", others.join("` and `")),
        };
    }
    if !entry.required_of.is_empty() {
        let required = format!("required for {}", kinds_of(reference, entry, &entry.required_of));
        return match &entry.absent {
            Some(absent) => format!("{required}; else {absent}"),
            None => required,
        };
    }
    if let Some(default) = &entry.default {
        let none = default.as_array().is_some_and(Vec::is_empty)
            || default.as_table().is_some_and(toml::Table::is_empty)
            || default.as_str().is_some_and(str::is_empty);
        return if none {
            "none".to_owned()
        } else {
            format!("`{default}`")
        };
    }
    entry
        .absent
        .clone()
        .unwrap_or_else(|| "its keys have their defaults".to_owned())
}

fn assignment(entry: &Entry) -> Option<String> {
    let example = entry.example.as_ref()?;
    let mut line = format!("{} = {example}", entry.name());
    if let Some(unit) = &entry.unit {
        let _ = write!(line, "  # {unit}");
    }
    Some(line)
}

fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('\n', " ")
}

/// Without Markdown's marks.
fn plain(text: &str) -> String {
    text.replace('`', "")
}

/// Lines of at most 96 columns.
fn wrapped(text: &str) -> Vec<String> {
    textwrap::wrap(&plain(text), 96)
        .into_iter()
        .map(|line| line.into_owned())
        .collect()
}

/// The page of the exit codes, as Markdown.
#[must_use]
pub fn exit_page() -> String {
    let mut text = String::from(
        "# Exit codes\n\nEvery command of `backseat` ends with one of these. This page is generated from \
         `runtime/reference/src/exit.rs` by `cargo xtask reference`.\n\n| code | meaning |\n|---|---|\n",
    );
    for exit in EXITS {
        let _ = writeln!(text, "| {} | {} |", exit.code, exit.meaning);
    }
    text
}
