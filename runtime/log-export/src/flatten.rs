//! A message's values, each under its path: `position.latitude_deg`.

use serde_json::Value;

/// Visits the values of a message that are not objects, depth first, with their paths. Absent values (null) are left
/// out, and arrays are given whole.
pub(crate) fn flatten<'a>(value: &'a Value, visit: &mut impl FnMut(&str, &'a Value)) {
    descend(value, &mut String::new(), visit);
}

fn descend<'a>(value: &'a Value, path: &mut String, visit: &mut impl FnMut(&str, &'a Value)) {
    match value {
        Value::Null => {}
        Value::Object(members) => {
            let length = path.len();
            for (name, member) in members {
                if length > 0 {
                    path.push('.');
                }
                path.push_str(name);
                descend(member, path, visit);
                path.truncate(length);
            }
        }
        Value::Bool(_) | Value::Number(_) | Value::String(_) | Value::Array(_) => {
            visit(if path.is_empty() { "value" } else { path }, value);
        }
    }
}

/// A number. The log has numbers that JSON cannot express as texts: `"nan"`, `"inf"`, `"-inf"`.
pub(crate) fn number(value: &Value) -> Option<f64> {
    match value.as_str() {
        Some("nan") => Some(f64::NAN),
        Some("inf") => Some(f64::INFINITY),
        Some("-inf") => Some(f64::NEG_INFINITY),
        Some(_) => None,
        None => value.as_f64(),
    }
}

/// The value as text: a string without its quotation marks, anything else as JSON.
pub(crate) fn text(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn nested_values_have_paths_and_absent_ones_are_left_out() {
        let message = json!({"a": {"b": 1, "c": {"d": "x"}}, "e": [1, 2], "f": null, "g": {}});
        let mut seen = Vec::new();
        flatten(&message, &mut |path, value| seen.push(format!("{path}={value}")));
        assert_eq!(seen, ["a.b=1", "a.c.d=\"x\"", "e=[1,2]"]);
    }
}
