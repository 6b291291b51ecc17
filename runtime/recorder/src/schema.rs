//! The channels' JSON schemas. Each property has exactly one type, at every depth, and a list has elements of one type:
//! the viewers' readers refuse anything else. So a value with several forms takes several properties, as [`crate::plain`]
//! writes it.

mod core;
mod events;
mod meaning;
mod refusal;
mod told;

use serde_json::{Map, Value, json};

use self::meaning::meaning;

pub(crate) use self::core::{bytes, input, output, shadow};
pub(crate) use told::{control, navigation, note, request, truth, vehicle};

/// The properties of an object.
#[derive(Clone, Default)]
pub(crate) struct Fields(Map<String, Value>);

impl Fields {
    pub(crate) fn new() -> Self {
        Self::default()
    }

    fn scalar(mut self, name: &str, type_name: &str, what: &str) -> Self {
        let mut schema = json!({"type": type_name});
        let what = if what.is_empty() { meaning(name) } else { what };
        if !what.is_empty() {
            schema["description"] = what.into();
        }
        self.0.insert(name.to_owned(), schema);
        self
    }

    pub(crate) fn boolean(self, name: &str, what: &str) -> Self {
        self.scalar(name, "boolean", what)
    }

    pub(crate) fn integer(self, name: &str, what: &str) -> Self {
        self.scalar(name, "integer", what)
    }

    pub(crate) fn number(self, name: &str, what: &str) -> Self {
        self.scalar(name, "number", what)
    }

    pub(crate) fn text(self, name: &str, what: &str) -> Self {
        self.scalar(name, "string", what)
    }

    /// A number of a plugin or a sonar, which can be one that JSON cannot express.
    pub(crate) fn figure(self, name: &str, what: &str) -> Self {
        self.number(name, what)
            .text(&format!("{name}_is"), "In its place: nan, inf or -inf.")
    }

    /// Bytes: one of the two.
    pub(crate) fn bytes(mut self) -> Self {
        self = self.text("text", "The bytes, if they are UTF-8.");
        let base64 = json!({
            "type": "string", "contentEncoding": "base64", "description": "The bytes, if they are not UTF-8."
        });
        self.0.insert("base64".to_owned(), base64);
        self
    }

    pub(crate) fn object(mut self, name: &str, what: &str, fields: Self) -> Self {
        self.0.insert(name.to_owned(), fields.into_object(what));
        self
    }

    /// A list of objects.
    pub(crate) fn list(mut self, name: &str, what: &str, element: Self) -> Self {
        let element = element.into_object("");
        self.0.insert(
            name.to_owned(),
            json!({"type": "array", "description": what, "items": element}),
        );
        self
    }

    /// A list of numbers, strings or integers.
    pub(crate) fn list_of(mut self, name: &str, type_name: &str, what: &str) -> Self {
        self.0.insert(
            name.to_owned(),
            json!({"type": "array", "description": what, "items": {"type": type_name}}),
        );
        self
    }

    /// An enum: the variant's name, and the contents of its variants, by their names.
    pub(crate) fn variant(mut self, name: &str, what: &str, contents: Self) -> Self {
        self = self.text(name, what);
        for (variant, schema) in contents.0 {
            self.0.insert(format!("{name}_{variant}"), schema);
        }
        self
    }

    /// An array of a fixed length, or a tuple of values of one type.
    pub(crate) fn numbered(self, name: &str, type_name: &str, places: usize, what: &str) -> Self {
        let what = if what.is_empty() { meaning(name) } else { what };
        let fields = (1..=places).fold(Self::new(), |fields, place| {
            fields.scalar(&place.to_string(), type_name, what)
        });
        self.object(name, what, fields)
    }

    /// Inserts all properties of another.
    pub(crate) fn and(mut self, other: Self) -> Self {
        self.0.extend(other.0);
        self
    }

    pub(crate) fn into_object(self, what: &str) -> Value {
        let mut schema = json!({"type": "object", "properties": self.0});
        if !what.is_empty() {
            schema["description"] = what.into();
        }
        schema
    }

    /// The schema of a message; these properties are in each.
    pub(crate) fn into_message(self, what: &str, required: &[&str]) -> Value {
        let mut schema = self.into_object(what);
        if !required.is_empty() {
            schema["required"] = required.into();
        }
        schema
    }
}

/// A time of the run.
const RUN_TIME: &str = "Time of the run, nanoseconds.";
const PLUGIN: &str = "Place in priority order, 0 first.";

fn duration() -> Fields {
    Fields::new()
        .integer("secs", "Seconds.")
        .integer("nanos", "Nanoseconds.")
}

fn position() -> Fields {
    Fields::new().number("latitude_deg", "").number("longitude_deg", "")
}

fn local() -> Fields {
    Fields::new().number("east_m", "").number("north_m", "")
}

fn fault() -> Fields {
    Fields::new()
        .text("kind", "Which bound the plugin broke.")
        .text("text", "In one line.")
}

fn version() -> Fields {
    Fields::new()
        .text("version", "As the component says it.")
        .text("sha256", "The component's, hexadecimal.")
        .integer(
            "trial_steps",
            "If it fails or is refused something in this many steps, the one before comes back.",
        )
}

fn log_line() -> Fields {
    Fields::new()
        .text("level", "debug, info, warn or error.")
        .text("text", "")
}

fn measure() -> Fields {
    Fields::new()
        .text("name", "")
        .number("value", "In the unit.")
        .text("unit", "As the plugin gave it; may be empty.")
}

fn operator_order() -> Fields {
    Fields::new()
        .object(
            "abort",
            "",
            Fields::new()
                .text("text", "Shown to people.")
                .boolean("errors", "It ends with errors."),
        )
        .object("kill", "", Fields::new().text("text", "Shown to people."))
        .object(
            "start-empty-mission",
            "",
            Fields::new().integer("duration_s", "How long it may last."),
        )
}

fn operator_act(fields: Fields) -> Fields {
    fields.variant(
        "act",
        "What the operator did: hold, release, stop; or order, for requests that no plugin may make.",
        Fields::new().variant("order", "The order.", operator_order()),
    )
}

fn sonar_setting(fields: Fields) -> Fields {
    fields.variant(
        "setting",
        "What to change.",
        Fields::new()
            .figure("range-m", "")
            .text("pulse", "")
            .boolean("ping", "")
            .figure("power-percent", "")
            .integer("gain", "In the sonar's own steps.")
            .figure("period-ms", ""),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_variant_has_a_property_for_its_name_and_one_for_each_content() {
        let vertical = Fields::new().number("depth-m", "").number("altitude-m", "");
        let fields = Fields::new().variant("vertical", "Where.", vertical);
        assert_eq!(
            fields.into_message("A request.", &["vertical"]),
            json!({
                "type": "object",
                "description": "A request.",
                "required": ["vertical"],
                "properties": {
                    "vertical": {"type": "string", "description": "Where."},
                    "vertical_depth-m": {"type": "number", "description": "Metres."},
                    "vertical_altitude-m": {"type": "number", "description": "Metres."},
                }
            })
        );
    }
}
