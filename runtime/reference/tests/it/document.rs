//! Files made from the tables: what is required, and what a test puts in.

use backseat_reference::{Entry, Kind, Reference};
use toml::{Table, Value};

/// A file with its required keys, the tables on the way to `key`, and their required keys.
pub(crate) fn around(reference: &Reference, key: &str) -> Table {
    let mut document = Table::new();
    fill(reference, "", None, &mut document);
    let mut table = String::new();
    let kind = reference.entry(key).and_then(|entry| entry.only.first());
    for part in key.split('.') {
        if !table.is_empty() {
            table.push('.');
        }
        table.push_str(part);
        let Some(entry) = reference.entry(&table) else { continue };
        if entry.is_table() || (entry.kind == Kind::Choice && table != key) {
            let inner = place(&mut document, &table);
            if entry.is_table() {
                fill(reference, &table, kind.map(String::as_str), inner);
            } else {
                // One of the words that take a value is on the way.
                inner.clear();
            }
        }
    }
    document
}

/// The table of this name, made where it is not there.
pub(crate) fn place<'a>(document: &'a mut Table, table: &str) -> &'a mut Table {
    let mut inner = document;
    if table.is_empty() {
        return inner;
    }
    let mut path = String::new();
    for part in table.split('.') {
        if !path.is_empty() {
            path.push('.');
        }
        path.push_str(part);
        let list = LISTS.with(|lists| lists.borrow().contains(&path));
        let slot = inner.entry(part).or_insert(Value::Boolean(false));
        if !matches!(slot, Value::Table(_) | Value::Array(_)) {
            let empty = Value::Table(Table::new());
            *slot = if list { Value::Array(vec![empty]) } else { empty };
        }
        let slot = if list {
            slot.as_array_mut()
                .and_then(|list| list.first_mut())
                .expect("lists of tables are made with one")
        } else {
            slot
        };
        inner = slot.as_table_mut().expect("what holds a key is a table");
    }
    inner
}

std::thread_local! {
    /// The keys of the reference at hand that are lists of tables.
    static LISTS: std::cell::RefCell<Vec<String>> = const { std::cell::RefCell::new(Vec::new()) };
}

/// Says which reference documents are made for.
pub(crate) fn of(reference: &Reference) {
    let lists = reference
        .entries
        .iter()
        .filter(|entry| entry.kind == Kind::Tables)
        .map(|entry| entry.key.clone())
        .collect();
    LISTS.with(|kept| *kept.borrow_mut() = lists);
}

/// Puts the required keys of a table in, with those of its own tables.
fn fill(reference: &Reference, table: &str, kind: Option<&str>, into: &mut Table) {
    let kind = kind.map(str::to_owned).or_else(|| first_kind(reference, table));
    for entry in reference.within(table).filter(|entry| entry.required) {
        let wanted = entry.only.is_empty() || kind.as_ref().is_some_and(|kind| entry.only.contains(kind));
        if !wanted || into.contains_key(entry.name()) {
            continue;
        }
        let value = if entry.is_table() {
            let mut inner = Table::new();
            fill(reference, &entry.key, None, &mut inner);
            if entry.kind == Kind::Tables {
                Value::Array(vec![Value::Table(inner)])
            } else {
                Value::Table(inner)
            }
        } else if entry.name() == "kind" {
            Value::String(kind.clone().expect("a kind has words"))
        } else {
            example(entry)
        };
        into.insert(entry.name().to_owned(), value);
    }
}

fn first_kind(reference: &Reference, table: &str) -> Option<String> {
    let kind = reference.within(table).find(|entry| entry.name() == "kind")?;
    kind.values.first().map(|choice| choice.value.clone())
}

pub(crate) fn example(entry: &Entry) -> Value {
    entry
        .example
        .clone()
        .unwrap_or_else(|| panic!("{} has no example", entry.key))
}

/// The file with this key set.
pub(crate) fn with(reference: &Reference, entry: &Entry, value: Value) -> Table {
    let mut document = around(reference, &entry.key);
    for needed in entry.needs.iter().filter_map(|key| reference.entry(key)) {
        place(&mut document, needed.table()).insert(needed.name().to_owned(), example(needed));
    }
    place(&mut document, entry.table()).insert(entry.name().to_owned(), value);
    document
}

/// The file without this key, though its table is there.
pub(crate) fn without(reference: &Reference, entry: &Entry) -> Table {
    let mut document = around(reference, &entry.key);
    place(&mut document, entry.table()).remove(entry.name());
    document
}
