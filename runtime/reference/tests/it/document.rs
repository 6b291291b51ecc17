//! Files made from the tables: what is required, and what a test puts in.

use backseat_reference::{Entry, Kind, Reference};
use toml::{Table, Value};

/// A file with its required keys, the tables on the way to `key`, and their required keys.
pub(crate) fn around(reference: &Reference, key: &str) -> Table {
    around_of(reference, key, None)
}

/// The same, where the key's own table is of this `kind`. Otherwise each table is of the first kind that takes the key, or
/// the table, that is next on the way.
fn around_of(reference: &Reference, key: &str, kind: Option<&str>) -> Table {
    let mut document = Table::new();
    let path: Vec<&Entry> = prefixes(key).filter_map(|prefix| reference.entry(prefix)).collect();
    let kind_within = |table: &str| {
        let next = path.iter().find(|entry| entry.table() == table);
        let wanted = match (kind, next) {
            (Some(kind), Some(next)) if next.key == key => Some(kind),
            (_, next) => next.and_then(|next| next.only.first()).map(String::as_str),
        };
        wanted.map_or_else(
            || kinds(reference, table).first().cloned(),
            |kind| Some(kind.to_owned()),
        )
    };
    fill(reference, "", &kind_within, &mut document);
    for entry in &path {
        if entry.is_table() || (entry.kind == Kind::Choice && entry.key != key) {
            let inner = place(&mut document, &entry.key);
            if entry.is_table() {
                fill(reference, &entry.key, &kind_within, inner);
            } else {
                // One of the words that take a value is on the way.
                inner.clear();
            }
        }
    }
    document
}

/// `a`, `a.b` and `a.b.c` of `a.b.c`.
fn prefixes(key: &str) -> impl Iterator<Item = &str> {
    let dots = key.match_indices('.').map(|(at, _)| at);
    dots.chain([key.len()]).map(|end| &key[..end])
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

/// Puts the required keys of a table in, with those of its own tables, each of the kind that is wanted.
fn fill(reference: &Reference, table: &str, kind_within: &dyn Fn(&str) -> Option<String>, into: &mut Table) {
    let kind = kind_within(table);
    for entry in reference.within(table) {
        let instead = entry.instead_of.iter().any(|other| into.contains_key(last(other)));
        if !entry.is_required(kind.as_deref()) || instead || into.contains_key(entry.name()) {
            continue;
        }
        let value = if entry.is_table() {
            let mut inner = Table::new();
            fill(reference, &entry.key, kind_within, &mut inner);
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

fn last(key: &str) -> &str {
    key.rsplit_once('.').map_or(key, |(_, name)| name)
}

/// The words of the key `kind` of a table.
pub(crate) fn kinds(reference: &Reference, table: &str) -> Vec<String> {
    let kind = reference.within(table).find(|entry| entry.name() == "kind");
    let words = kind.map_or(&[][..], |kind| &kind.values);
    words.iter().map(|choice| choice.value.clone()).collect()
}

pub(crate) fn example(entry: &Entry) -> Value {
    entry
        .example
        .clone()
        .unwrap_or_else(|| panic!("{} has no example", entry.key))
}

/// The file with this key set.
pub(crate) fn with(reference: &Reference, entry: &Entry, value: Value) -> Table {
    with_of(reference, entry, value, None)
}

/// The file with this key set, and with the keys that it needs, in a table of this `kind`.
pub(crate) fn with_of(reference: &Reference, entry: &Entry, value: Value, kind: Option<&str>) -> Table {
    // Another kind of table has other required keys.
    let own = value.as_str().filter(|_| entry.name() == "kind");
    let kind = own
        .or(kind)
        .or(entry.only.first().map(String::as_str))
        .map(str::to_owned);
    let mut document = around_of(reference, &entry.key, kind.as_deref());
    for needed in entry.needs.iter().filter_map(|key| reference.entry(key)) {
        if needed.is_of(kind.as_deref()) {
            place(&mut document, needed.table()).insert(needed.name().to_owned(), example(needed));
        }
    }
    for other in entry.instead_of.iter().filter_map(|key| reference.entry(key)) {
        place(&mut document, other.table()).remove(other.name());
    }
    place(&mut document, entry.table()).insert(entry.name().to_owned(), value);
    document
}

/// The file without this key and what may be there in its place, though its table is there and is of this `kind`.
pub(crate) fn without_of(reference: &Reference, entry: &Entry, kind: Option<&str>) -> Table {
    let mut document = around_of(reference, &entry.key, kind.or(entry.only.first().map(String::as_str)));
    for other in entry.instead_of.iter().filter_map(|key| reference.entry(key)) {
        place(&mut document, other.table()).remove(other.name());
    }
    place(&mut document, entry.table()).remove(entry.name());
    document
}
