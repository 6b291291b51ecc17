//! JSON schemas of channels, with their properties in the order in which they are written.

use std::fmt;

use serde::Deserialize;
use serde::de::{Deserializer, MapAccess, Visitor};

/// What a channel's schema says about a value.
#[derive(Debug, Default, Deserialize)]
pub(crate) struct Schema {
    /// `number`, `string`, ...; empty where the schema does not have one type.
    #[serde(rename = "type", default, deserialize_with = "one_text")]
    pub(crate) kind: String,
    #[serde(default, deserialize_with = "one_text")]
    pub(crate) description: String,
    #[serde(default)]
    pub(crate) properties: Properties,
}

impl Schema {
    /// Reads a schema. One that cannot be read says nothing: columns then come from the messages alone.
    pub(crate) fn parse(text: &[u8]) -> Self {
        serde_json::from_slice(text).unwrap_or_default()
    }
}

/// A schema's properties in the order of its text.
#[derive(Debug, Default)]
pub(crate) struct Properties(pub(crate) Vec<(String, Schema)>);

impl<'de> Deserialize<'de> for Properties {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct InOrder;
        impl<'de> Visitor<'de> for InOrder {
            type Value = Properties;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object of schemas")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Properties, A::Error> {
                let mut properties = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    properties.push(entry);
                }
                Ok(Properties(properties))
            }
        }
        deserializer.deserialize_map(InOrder)
    }
}

/// A text; empty for anything else, such as a list of types.
fn one_text<'de, D: Deserializer<'de>>(deserializer: D) -> Result<String, D::Error> {
    Ok(match serde_json::Value::deserialize(deserializer)? {
        serde_json::Value::String(text) => text,
        serde_json::Value::Null
        | serde_json::Value::Bool(_)
        | serde_json::Value::Number(_)
        | serde_json::Value::Array(_)
        | serde_json::Value::Object(_) => String::new(),
    })
}
