use serde_json::{Map, Value, json};

use crate::entry::{Entry, Kind};
use crate::reference::Reference;

/// The file's JSON Schema (draft 7, which taplo and VS Code read).
#[must_use]
pub fn schema(reference: &Reference) -> Value {
    let mut root = table(reference, "");
    root.insert("$schema".to_owned(), json!("http://json-schema.org/draft-07/schema#"));
    root.insert("title".to_owned(), json!(reference.file));
    root.insert("description".to_owned(), json!(reference.meaning));
    Value::Object(root)
}

/// A table: its keys, and no others.
fn table(reference: &Reference, name: &str) -> Map<String, Value> {
    let mut properties = Map::new();
    let mut required = Vec::new();
    for entry in reference.within(name) {
        properties.insert(entry.name().to_owned(), described(reference, entry));
        if entry.required && entry.only.is_empty() && entry.instead_of.is_empty() {
            required.push(json!(entry.name()));
        }
    }
    let mut object = Map::new();
    object.insert("type".to_owned(), json!("object"));
    object.insert("additionalProperties".to_owned(), json!(false));
    object.insert("properties".to_owned(), Value::Object(properties));
    if !required.is_empty() {
        object.insert("required".to_owned(), Value::Array(required));
    }
    object
}

fn described(reference: &Reference, entry: &Entry) -> Value {
    let mut schema = held(reference, entry);
    let mut text = entry.meaning.clone();
    if let Some(unit) = &entry.unit {
        text.push_str(&format!(" Unit: {unit}."));
    }
    if let Some(condition) = &entry.condition {
        text.push_str(&format!(" Must be {condition}."));
    }
    if let Some(absent) = &entry.absent {
        text.push_str(&format!(" Without it: {absent}."));
    }
    schema.insert("description".to_owned(), json!(text));
    if let Some(default) = entry.default.as_ref().and_then(as_json) {
        schema.insert("default".to_owned(), default);
    }
    if let Some(example) = entry.example.as_ref().and_then(as_json) {
        schema.insert("examples".to_owned(), json!([example]));
    }
    Value::Object(schema)
}

/// What a key holds.
fn held(reference: &Reference, entry: &Entry) -> Map<String, Value> {
    let words =
        || json!({ "type": "string", "enum": entry.values.iter().map(|choice| &choice.value).collect::<Vec<_>>() });
    let number = || with_range(entry, "number");
    match entry.kind {
        Kind::Number => object(number()),
        Kind::Integer => object(with_range(entry, "integer")),
        Kind::Boolean => object(json!({ "type": "boolean" })),
        Kind::String => object(json!({ "type": "string" })),
        // TOML's own dates and times are neither texts nor numbers, and editors differ in what they take them for.
        Kind::Time => Map::new(),
        Kind::Drawn => object(json!({ "anyOf": [
            number(),
            { "type": "array", "items": number(), "minItems": 2, "maxItems": 2 },
        ] })),
        Kind::NumberOrSeed => object(json!({ "anyOf": [number(), { "enum": ["seed"] }] })),
        Kind::BooleanOrSeed => object(json!({ "enum": [true, false, "seed"] })),
        Kind::Numbers => object(json!({ "type": "array", "items": number() })),
        Kind::Integers => object(json!({ "type": "array", "items": with_range(entry, "integer") })),
        Kind::Strings => object(json!({ "type": "array", "items": { "type": "string" } })),
        Kind::Choices => object(json!({ "type": "array", "items": words() })),
        Kind::Choice => {
            let mut forms = Vec::new();
            if !entry.values.is_empty() {
                forms.push(words());
            }
            for below in reference.within(&entry.key) {
                forms.push(json!({
                    "type": "object",
                    "additionalProperties": false,
                    "required": [below.name()],
                    "properties": { below.name(): described(reference, below) },
                }));
            }
            match <[Value; 1]>::try_from(forms) {
                Ok([only]) => object(only),
                Err(forms) => object(json!({ "oneOf": forms })),
            }
        }
        Kind::Table => table(reference, &entry.key),
        Kind::Tables => object(json!({ "type": "array", "items": table(reference, &entry.key) })),
        Kind::Values => object(json!({ "type": "array" })),
        Kind::Free => object(json!({ "type": "object" })),
    }
}

fn with_range(entry: &Entry, kind: &str) -> Value {
    let mut schema = object(json!({ "type": kind }));
    let bounds = [
        ("minimum", entry.min),
        ("maximum", entry.max),
        ("exclusiveMinimum", entry.above),
        ("exclusiveMaximum", entry.below),
    ];
    for (name, bound) in bounds {
        if let Some(bound) = bound {
            schema.insert(name.to_owned(), json!(bound));
        }
    }
    Value::Object(schema)
}

fn object(value: Value) -> Map<String, Value> {
    if let Value::Object(map) = value {
        map
    } else {
        Map::new()
    }
}

fn as_json(value: &toml::Value) -> Option<Value> {
    serde_json::to_value(value).ok()
}
