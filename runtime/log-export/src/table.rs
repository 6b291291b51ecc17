//! The table of a channel: its columns, and a row for each message.
//!
//! A table's columns are those of the channel's schema, in its order, and behind them those that only messages have. So
//! they are known, with their types, only once every message has been seen ([`Draft`]); then come the rows ([`Table`]).

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value;

use crate::flatten::{flatten, number, text};
use crate::schema::Schema;

/// The most columns of a table. A channel of a plugin or of another program could have a new name in each message.
const COLUMNS_MAX: usize = 2000;
/// Arrays of numbers up to this length have a column for each element.
const ELEMENTS_MAX: usize = 64;

/// The type of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Boolean,
    /// 64 bits, signed.
    Integer,
    /// 64 bits, floating point.
    Number,
    Text,
}

impl Kind {
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Boolean => "boolean",
            Self::Integer => "integer",
            Self::Number => "number",
            Self::Text => "string",
        }
    }
}

/// The kinds of value that a column has had, a bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Kinds(u8);

impl Kinds {
    const BOOLEAN: Self = Self(1);
    const INTEGER: Self = Self(2);
    const NUMBER: Self = Self(4);
    /// `"nan"`, `"inf"` or `"-inf"`: a number among numbers, a text among texts.
    const NOT_FINITE: Self = Self(8);
    const TEXT: Self = Self(16);

    fn of(value: &Value) -> Self {
        match value {
            Value::Bool(_) => Self::BOOLEAN,
            Value::Number(number) if number.is_i64() => Self::INTEGER,
            // Whole numbers over 2^63 are exact as text only.
            Value::Number(number) if number.is_u64() => Self::TEXT,
            Value::Number(_) => Self::NUMBER,
            Value::String(_) if number(value).is_some() => Self::NOT_FINITE,
            Value::String(_) | Value::Array(_) | Value::Object(_) | Value::Null => Self::TEXT,
        }
    }

    fn declared(kind: &str) -> Self {
        match kind {
            "boolean" => Self::BOOLEAN,
            "integer" => Self::INTEGER,
            "number" => Self::NUMBER,
            "string" => Self::TEXT,
            _ => Self::default(),
        }
    }

    const fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    const fn kind(self) -> Kind {
        const NUMERIC: u8 = Kinds::INTEGER.0 | Kinds::NUMBER.0;
        match self.0 {
            bits if bits == Self::BOOLEAN.0 => Kind::Boolean,
            bits if bits == Self::INTEGER.0 => Kind::Integer,
            bits if bits & !(NUMERIC | Self::NOT_FINITE.0) == 0 && bits & NUMERIC != 0 => Kind::Number,
            _ => Kind::Text,
        }
    }
}

/// A column of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Column {
    pub(crate) name: String,
    pub(crate) kind: Kind,
    /// From the schema, with the unit; may be empty.
    pub(crate) description: String,
}

/// A table whose columns are not all known yet.
#[derive(Debug, Default)]
pub(crate) struct Draft {
    entries: Vec<Entry>,
    places: BTreeMap<String, usize>,
    rows: u64,
    /// Whether there were more columns than [`COLUMNS_MAX`].
    overfull: bool,
}

#[derive(Debug, Default)]
struct Entry {
    path: String,
    description: String,
    /// Of values that are not arrays; and of arrays, of their elements.
    kinds: Kinds,
    array: Option<Array>,
    /// Whether there was a value that was not an array.
    single: bool,
}

/// What is known of the arrays under a path.
#[derive(Debug)]
struct Array {
    longest: usize,
    /// Whether all of them are short and have only numbers.
    numbers: bool,
}

impl Draft {
    /// The columns that a schema names.
    pub(crate) fn declare(&mut self, schema: &Schema) {
        self.declare_under("", schema);
    }

    fn declare_under(&mut self, path: &str, schema: &Schema) {
        for (name, property) in &schema.properties.0 {
            let path = if path.is_empty() {
                name.clone()
            } else {
                format!("{path}.{name}")
            };
            match property.kind.as_str() {
                "object" => self.declare_under(&path, property),
                // Its columns depend on its length.
                "array" => {
                    if let Some(entry) = self.entry(&path) {
                        entry.description.clone_from(&property.description);
                    }
                }
                kind => {
                    if let Some(entry) = self.entry(&path) {
                        entry.description.clone_from(&property.description);
                        entry.kinds = entry.kinds.with(Kinds::declared(kind));
                        entry.single = entry.kinds != Kinds::default();
                    }
                }
            }
        }
    }

    /// Takes note of a message's values.
    pub(crate) fn see(&mut self, message: &Value) {
        self.rows += 1;
        flatten(message, &mut |path, value| {
            let Some(entry) = self.entry(path) else { return };
            let Some(elements) = value.as_array() else {
                entry.kinds = entry.kinds.with(Kinds::of(value));
                entry.single = true;
                return;
            };
            let array = entry.array.get_or_insert(Array {
                longest: 0,
                numbers: true,
            });
            array.longest = array.longest.max(elements.len());
            array.numbers &= elements.len() <= ELEMENTS_MAX && elements.iter().all(|element| number(element).is_some());
            for element in elements.iter().filter(|_| array.numbers) {
                entry.kinds = entry.kinds.with(Kinds::of(element));
            }
        });
    }

    fn entry(&mut self, path: &str) -> Option<&mut Entry> {
        let place = match self.places.get(path) {
            Some(place) => *place,
            None if self.entries.len() < COLUMNS_MAX => {
                self.places.insert(path.to_owned(), self.entries.len());
                self.entries.push(Entry {
                    path: path.to_owned(),
                    ..Entry::default()
                });
                self.entries.len() - 1
            }
            None => {
                self.overfull = true;
                return None;
            }
        };
        self.entries.get_mut(place)
    }

    /// The table, now that every message has been seen.
    pub(crate) fn table(self) -> Table {
        let mut table = Table {
            columns: Vec::new(),
            places: BTreeMap::new(),
            arrays: BTreeSet::new(),
            rows: self.rows,
            overfull: self.overfull,
        };
        for entry in self.entries {
            let kind = entry.kinds.kind();
            match entry.array {
                Some(array) if array.numbers && !entry.single => {
                    for element in 0..array.longest {
                        table.add(format!("{}.{element}", entry.path), kind, &entry.description);
                    }
                }
                Some(_) => {
                    table.add(entry.path.clone(), Kind::Text, &entry.description);
                    table.arrays.insert(entry.path);
                }
                None if entry.single => table.add(entry.path, kind, &entry.description),
                // An array that the schema has and no message.
                None => {}
            }
        }
        table
    }
}

/// A table with its columns.
#[derive(Debug)]
pub(crate) struct Table {
    pub(crate) columns: Vec<Column>,
    /// The place of each path's column.
    places: BTreeMap<String, usize>,
    /// The paths of arrays that are one column, as JSON.
    arrays: BTreeSet<String>,
    pub(crate) rows: u64,
    /// Whether columns were left out because there were too many.
    pub(crate) overfull: bool,
}

/// A value of a row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Cell<'a> {
    Absent,
    Boolean(bool),
    Integer(i64),
    Number(f64),
    Text(Cow<'a, str>),
}

impl<'a> Cell<'a> {
    fn of(value: &'a Value, kind: Kind) -> Self {
        let cell = match kind {
            Kind::Boolean => value.as_bool().map(Self::Boolean),
            Kind::Integer => value.as_i64().map(Self::Integer),
            Kind::Number => number(value).map(Self::Number),
            Kind::Text => Some(Self::Text(match value.as_str() {
                Some(text) => text.into(),
                None => text(value).into(),
            })),
        };
        cell.unwrap_or(Self::Absent)
    }
}

impl Table {
    fn add(&mut self, path: String, kind: Kind, description: &str) {
        // The tables have two columns of their own.
        let own = path == "time" || path == "t_s";
        let name = if own { format!("message.{path}") } else { path.clone() };
        // `{"a": {"b": 1}, "a.b": 2}` has one path twice.
        if self.places.insert(path, self.columns.len()).is_none() {
            self.columns.push(Column {
                name,
                kind,
                description: description.to_owned(),
            });
        }
    }

    /// A message's values, in the order of the columns.
    pub(crate) fn row<'a>(&self, message: &'a Value) -> Vec<Cell<'a>> {
        let mut row = vec![Cell::Absent; self.columns.len()];
        let mut put = |path: &str, value: &'a Value| {
            let column = self
                .places
                .get(path)
                .and_then(|place| Some((*place, self.columns.get(*place)?)));
            if let Some((place, column)) = column
                && let Some(cell) = row.get_mut(place)
            {
                *cell = Cell::of(value, column.kind);
            }
        };
        let mut element_path = String::new();
        flatten(message, &mut |path, value| match value.as_array() {
            Some(elements) if !self.arrays.contains(path) => {
                for (number, element) in elements.iter().enumerate() {
                    element_path.clear();
                    element_path.push_str(path);
                    element_path.push('.');
                    element_path.push_str(&number.to_string());
                    put(&element_path, element);
                }
            }
            Some(_) | None => put(path, value),
        });
        row
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn table(schema: &Value, messages: &[Value]) -> Table {
        let mut draft = Draft::default();
        draft.declare(&Schema::parse(schema.to_string().as_bytes()));
        messages.iter().for_each(|message| draft.see(message));
        draft.table()
    }

    fn columns(table: &Table) -> Vec<String> {
        let columns = table.columns.iter();
        columns
            .map(|column| format!("{} {}", column.name, column.kind.name()))
            .collect()
    }

    #[test]
    fn columns_come_from_the_schema_in_its_order_and_then_from_messages() {
        let schema = r#"{"type": "object", "properties": {
            "zone": {"type": "string"}, "depth_m": {"type": "number", "description": "Metres."},
            "stamp": {"type": "object", "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}}},
            "list": {"type": "array", "items": {"type": "number"}}, "valid": {"type": "boolean"}
        }}"#;
        let mut draft = Draft::default();
        draft.declare(&Schema::parse(schema.as_bytes()));
        draft.see(&json!({"depth_m": 3, "list": [1.5, 2.5], "extra": {"b": 1}}));
        draft.see(&json!({"depth_m": "nan", "list": [1], "extra": {"b": 1.5}, "valid": true}));
        let table = draft.table();
        assert_eq!(
            columns(&table),
            [
                "zone string",
                "depth_m number",
                "stamp.sec integer",
                "stamp.nsec integer",
                "list.0 number",
                "list.1 number",
                "valid boolean",
                "extra.b number"
            ]
        );
        assert_eq!(table.columns[1].description, "Metres.");
        let message = json!({"depth_m": 3, "list": [1, 2.5], "extra": {"b": 1}});
        let row = table.row(&message);
        assert_eq!(row[0], Cell::Absent);
        assert_eq!(row[1..2], [Cell::Number(3.0)]);
        assert_eq!(
            row[4..],
            [Cell::Number(1.0), Cell::Number(2.5), Cell::Absent, Cell::Number(1.0)]
        );
        let message = json!({"depth_m": "nan"});
        assert!(matches!(table.row(&message)[1], Cell::Number(depth) if depth.is_nan()));
    }

    #[test]
    fn what_does_not_fit_one_type_is_text_and_nothing_is_lost() {
        let messages = [
            json!({"mixed": 1, "seed": u64::MAX, "act": "hold", "word": "nan", "array": [{"a": 1}]}),
            json!({"mixed": "x", "seed": 1, "act": {"order": 2}, "word": "nan", "array": []}),
        ];
        let table = table(&json!({}), &messages);
        assert_eq!(
            columns(&table),
            [
                "act string",
                "array string",
                "mixed string",
                "seed string",
                "word string",
                "act.order integer"
            ]
        );
        let text = |text: &'static str| Cell::Text(text.into());
        assert_eq!(
            table.row(&messages[0]),
            [
                text("hold"),
                text("[{\"a\":1}]"),
                text("1"),
                text("18446744073709551615"),
                text("nan"),
                Cell::Absent
            ]
        );
        assert_eq!(table.row(&messages[1])[5], Cell::Integer(2));
    }

    #[test]
    fn long_arrays_are_one_column_and_so_are_arrays_beside_other_values() {
        let long: Vec<usize> = (0..=ELEMENTS_MAX).collect();
        let messages = [json!({"a": long, "b": [1, 2]}), json!({"a": [1], "b": 7})];
        let table = table(&json!({}), &messages);
        assert_eq!(columns(&table), ["a string", "b string"]);
        let text = |text: &'static str| Cell::Text(text.into());
        assert_eq!(table.row(&messages[1]), [text("[1]"), text("7")]);
        assert_eq!(table.row(&messages[0])[1], text("[1,2]"));
    }

    #[test]
    fn a_column_of_a_message_that_has_the_name_of_a_tables_own_is_renamed() {
        let table = table(&json!({}), &[json!({"time": "x", "t_s": 1})]);
        assert_eq!(columns(&table), ["message.t_s integer", "message.time string"]);
    }

    #[test]
    fn a_new_name_in_every_message_does_not_use_memory_without_bound() {
        let messages: Vec<Value> = (0..COLUMNS_MAX + 9)
            .map(|number| json!({format!("n{number}"): 1}))
            .collect();
        let table = table(&json!({}), &messages);
        assert_eq!((table.columns.len(), table.overfull), (COLUMNS_MAX, true));
        assert!(
            table
                .row(&messages[COLUMNS_MAX])
                .iter()
                .all(|cell| *cell == Cell::Absent)
        );
    }
}
