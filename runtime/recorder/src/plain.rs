//! JSON in which each property has one type, because the viewers' schema readers refuse anything else.
//!
//! Values are written as `serde_json` writes them, except for the following. Here `K` is the name of the property that
//! has the value.
//!
//! | value | as |
//! |---|---|
//! | absent (`None`, unit) | left out |
//! | number that JSON cannot express | `"K_is"`, which is `"nan"`, `"inf"` or `"-inf"`, in place of `K` |
//! | variant of an enum | `"K": "variant"` in lower case with hyphens, and its content, if any, as `"K_variant"` |
//! | tuple, array of a fixed length | object with the properties `"1"`, `"2"` and so on |
//!
//! An element of a list has no name. So an element that is a variant is an object with the property `is`, by the same
//! rule, and an element that is a list is an object with the property `items`.
//!
//! [`read`] is the reverse, bit for bit. Only the sign and the payload of NaN are not kept, because the host of plugins
//! makes all NaNs the same.

mod reader;
mod writer;

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

/// The property of an element that is a variant.
const IS: &str = "is";
/// The property of an element that is a list.
const ITEMS: &str = "items";
/// What follows a property's name if the number cannot be expressed.
const SPECIAL: &str = "_is";

/// Appends a value.
///
/// # Errors
///
/// The value's own, or a map with a key that is not text.
pub(crate) fn write(out: &mut Vec<u8>, value: &impl Serialize) -> Result<(), serde_json::Error> {
    value.serialize(writer::Writer::element(out))
}

/// Reads a property of an object.
///
/// # Errors
///
/// The property is missing, or not of this type.
pub(crate) fn read<T: DeserializeOwned>(object: &Map<String, Value>, key: &str) -> Result<T, serde_json::Error> {
    T::deserialize(reader::Node::property(object, key))
}

/// The name of a variant in the log: lower case with hyphens, whichever way its type has it.
fn variant_name(name: &str) -> std::borrow::Cow<'_, str> {
    if !name.bytes().any(|byte| byte.is_ascii_uppercase()) {
        return name.into();
    }
    let mut kebab = String::with_capacity(name.len() + 4);
    for letter in name.chars() {
        if letter.is_ascii_uppercase() && !kebab.is_empty() {
            kebab.push('-');
        }
        kebab.push(letter.to_ascii_lowercase());
    }
    kebab.into()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use serde::Deserialize;

    use super::*;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    enum Choice {
        Nothing,
        GpsHit(f64),
        Both(u8, Option<String>),
        Named { speed_mps: f64, left: Option<Box<Choice>> },
    }

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct Everything {
        absent: Option<u8>,
        number: f64,
        choice: Choice,
        list: Vec<Choice>,
        lists: Vec<Vec<u8>>,
        pairs: Vec<(u8, Option<f64>)>,
        three: [Option<f64>; 3],
        result: Result<(), String>,
        map: BTreeMap<String, u64>,
    }

    fn everything(choice: Choice, number: f64) -> Everything {
        Everything {
            absent: None,
            number,
            choice,
            list: vec![
                Choice::Nothing,
                Choice::GpsHit(f64::NEG_INFINITY),
                Choice::Both(7, None),
                Choice::Named {
                    speed_mps: -0.0,
                    left: Some(Box::new(Choice::GpsHit(1.5))),
                },
            ],
            lists: vec![vec![], vec![1, 2]],
            pairs: vec![(1, None), (2, Some(f64::INFINITY))],
            three: [Some(1.0), None, Some(0.1)],
            result: Ok(()),
            map: BTreeMap::from([("a \"key\"".to_owned(), u64::MAX)]),
        }
    }

    fn written(value: &impl Serialize) -> Map<String, Value> {
        let mut json = Vec::new();
        write(&mut json, value).unwrap();
        serde_json::from_slice(&json).unwrap()
    }

    #[test]
    fn each_property_has_one_type() {
        let json = written(&everything(Choice::Both(3, Some("text".into())), f64::INFINITY));
        let expected = serde_json::json!({
            "number_is": "inf",
            "choice": "both",
            "choice_both": {"1": 3, "2": "text"},
            "list": [
                {"is": "nothing"},
                {"is": "gps-hit", "is_gps-hit_is": "-inf"},
                {"is": "both", "is_both": {"1": 7}},
                {"is": "named", "is_named": {"speed_mps": -0.0, "left": "gps-hit", "left_gps-hit": 1.5}},
            ],
            "lists": [{"items": []}, {"items": [1, 2]}],
            "pairs": [{"1": 1}, {"1": 2, "2_is": "inf"}],
            "three": {"1": 1.0, "3": 0.1},
            "result": "ok",
            "map": {"a \"key\"": u64::MAX},
        });
        assert_eq!(Value::Object(json), expected);
    }

    #[test]
    fn what_is_written_is_read_back() {
        let choices = [
            Choice::Nothing,
            Choice::GpsHit(f64::INFINITY),
            Choice::GpsHit(f64::MIN_POSITIVE),
            Choice::Both(0, Some(String::new())),
            Choice::Named {
                speed_mps: f64::MAX,
                left: None,
            },
        ];
        for choice in choices {
            #[derive(Serialize)]
            struct Message<'a> {
                all: &'a Everything,
            }
            let all = everything(choice, f64::NEG_INFINITY);
            let json = written(&Message { all: &all });
            assert_eq!(read::<Everything>(&json, "all").unwrap(), all);
        }
        let nan = written(&everything(Choice::GpsHit(f64::NAN), f64::NAN));
        assert!(read::<f64>(&nan, "number").unwrap().is_nan());
        assert!(matches!(read::<Choice>(&nan, "choice").unwrap(), Choice::GpsHit(nan) if nan.is_nan()));
    }

    #[test]
    fn what_does_not_fit_is_an_error() {
        let json = written(&everything(Choice::Nothing, 1.0));
        assert!(read::<f64>(&json, "choice").is_err());
        assert!(read::<f64>(&json, "missing").is_err());
        assert!(read::<Choice>(&json, "number").is_err());
        assert!(read::<Vec<u8>>(&json, "list").is_err());
    }
}
