//! Reads schemas as the viewers do, and each message by its schema.

use std::collections::BTreeMap;

use mcap::MessageStream;
use serde_json::Value;

/// One channel of a log.
pub(crate) struct Channel {
    pub(crate) schema_name: String,
    pub(crate) schema: Value,
    /// Time, nanoseconds since 1970, and content.
    pub(crate) messages: Vec<(u64, Value)>,
}

/// All channels that have messages, by their topics. Panics on a number of the sequence that is missing, on a time that
/// falls, and on a channel that is no JSON.
pub(crate) fn channels(file: &[u8]) -> BTreeMap<String, Channel> {
    let mut channels: BTreeMap<String, Channel> = BTreeMap::new();
    let (mut sequence, mut newest) = (0, 0);
    for message in MessageStream::new(file).expect("the file is whole") {
        let message = message.expect("a message is whole");
        assert_eq!((message.sequence, message.log_time >= newest), (sequence, true));
        assert_eq!(message.publish_time, message.log_time);
        (sequence, newest) = (sequence + 1, message.log_time);
        assert_eq!(message.channel.message_encoding, "json");
        let schema = message.channel.schema.as_ref().expect("the channel has a schema");
        assert_eq!(schema.encoding, "jsonschema");
        let channel = channels
            .entry(message.channel.topic.clone())
            .or_insert_with(|| Channel {
                schema_name: schema.name.clone(),
                schema: serde_json::from_slice(&schema.data).expect("the schema is JSON"),
                messages: Vec::new(),
            });
        let content = serde_json::from_slice(&message.data).expect("the message is JSON");
        channel.messages.push((message.log_time, content));
    }
    channels
}

/// Reads an object's schema as Foxglove and Lichtblick do.
///
/// # Errors
///
/// What they refuse, and where.
pub(crate) fn accept(schema: &Value, place: &str) -> Result<(), String> {
    if schema["type"] != "object" {
        return Err(format!("{place}: expected an object, found {}", schema["type"]));
    }
    let Some(properties) = schema["properties"].as_object() else {
        // They take it for an object without properties: nothing of it could be plotted.
        return Err(format!("{place}: no properties"));
    };
    for (name, property) in properties {
        let place = format!("{place}.{name}");
        if ["oneOf", "anyOf", "allOf", "$ref"]
            .iter()
            .any(|key| property.get(key).is_some())
        {
            return Err(format!("{place}: a union"));
        }
        match property["type"].as_str() {
            Some("boolean" | "number" | "integer") => {}
            Some("string") => match property.get("contentEncoding").and_then(Value::as_str) {
                None | Some("base64") => {}
                Some(other) => return Err(format!("{place}: encoding {other}")),
            },
            Some("object") => accept(property, &place)?,
            Some("array") => match property["items"]["type"].as_str() {
                Some("boolean" | "number" | "integer" | "string") => {}
                Some("object") => accept(&property["items"], &place)?,
                other => return Err(format!("{place}: elements of type {other:?}")),
            },
            other => return Err(format!("{place}: type {other:?}, {}", property["type"])),
        }
    }
    Ok(())
}

/// The schema without room for what it does not name, so that it must name everything.
pub(crate) fn closed(schema: &Value) -> Value {
    let mut schema = schema.clone();
    close(&mut schema);
    schema
}

fn close(schema: &mut Value) {
    if let Some(properties) = schema.get_mut("properties").and_then(Value::as_object_mut) {
        properties.values_mut().for_each(close);
        schema["additionalProperties"] = false.into();
    }
    if let Some(items) = schema.get_mut("items") {
        close(items);
    }
}

/// Checks each message by the schema of its channel, which must name everything that it finds.
pub(crate) fn check(channels: &BTreeMap<String, Channel>) {
    for (topic, channel) in channels {
        accept(&channel.schema, topic).expect("the viewers read the schema");
        let validator = jsonschema::validator_for(&closed(&channel.schema)).expect("it is a schema");
        for (_, message) in &channel.messages {
            let errors: Vec<String> = validator
                .iter_errors(message)
                .map(|error| format!("{}: {error}", error.instance_path))
                .collect();
            assert!(errors.is_empty(), "{topic}: {errors:#?}\n{message:#}");
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn what_the_viewers_refuse_is_refused() {
        let object = |property: Value| json!({"type": "object", "properties": {"a": property}});
        for property in [
            json!({"type": ["integer", "null"]}),
            json!({"type": "null"}),
            json!({"enum": ["a", "b"]}),
            json!({"oneOf": [{"type": "string"}, {"type": "number"}]}),
            json!({"type": "array"}),
            json!({"type": "array", "items": {"type": "array", "items": {"type": "number"}}}),
            json!({"type": "array", "items": object(json!({}))}),
            json!({"type": "string", "contentEncoding": "base32"}),
            object(json!({"type": "null"})),
        ] {
            assert!(accept(&object(property.clone()), "").is_err(), "{property}");
        }
        assert!(accept(&json!({"type": "object"}), "").is_err());
        assert!(accept(&json!({"type": "string"}), "").is_err());
        for property in [
            json!({"type": "string", "contentEncoding": "base64"}),
            json!({"type": "array", "items": {"type": "number"}}),
            object(json!({"type": "integer"})),
        ] {
            assert_eq!(accept(&object(property), ""), Ok(()));
        }
    }
}
