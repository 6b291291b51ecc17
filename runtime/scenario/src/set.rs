//! Keys of `world.toml` that are set from outside: `world.current.speed_mps=0.3`.

use toml::{Table, Value};

use crate::error::ScenarioError;

/// What every key of `world.toml` begins with where keys of several files may be set.
pub const WORLD_PREFIX: &str = "world.";

/// Splits `KEY=VALUE` settings into those of `mission.toml` and those of `world.toml`.
#[must_use]
pub fn split_sets(sets: &[String]) -> (Vec<String>, Vec<String>) {
    sets.iter()
        .cloned()
        .partition(|set| !set.trim_start().starts_with(WORLD_PREFIX))
}

/// The text of `world.toml` with keys set.
///
/// Each setting is `world.KEY=VALUE`. Names are joined by dots; a number is the place in a list, from 0:
/// `world.plan.1.speed_mps=1.2`. The value is read as TOML where it is valid TOML, otherwise as text.
pub(crate) fn with_sets(text: &str, sets: &[String]) -> Result<String, ScenarioError> {
    if sets.is_empty() {
        return Ok(text.to_owned());
    }
    // A text that is not TOML is reported by its reader, with the line.
    let Ok(table) = toml::from_str::<Table>(text) else {
        return Ok(text.to_owned());
    };
    let mut file = Value::Table(table);
    for set in sets {
        put(&mut file, set).map_err(|message| ScenarioError::Set {
            set: set.clone(),
            message,
        })?;
    }
    Ok(file.as_table().map_or_else(|| text.to_owned(), Table::to_string))
}

fn put(file: &mut Value, set: &str) -> Result<(), String> {
    let expected = || format!("expected {WORLD_PREFIX}KEY=VALUE, such as world.current.speed_mps=0.3");
    let (key, value) = set.split_once('=').ok_or_else(expected)?;
    let key = key.trim();
    let path = key.strip_prefix(WORLD_PREFIX).ok_or_else(expected)?;
    let names: Vec<&str> = path.split('.').collect();
    if names.iter().any(|name| name.is_empty()) {
        return Err(format!("invalid key `{key}`: expected names joined by dots"));
    }
    let mut there = file;
    let mut within = String::from("world");
    for name in names {
        there = step(there, name, &within)?;
        within.push('.');
        within.push_str(name);
    }
    *there = read_value(value);
    Ok(())
}

/// The value behind a name, created if a table does not have it.
fn step<'a>(there: &'a mut Value, name: &str, within: &str) -> Result<&'a mut Value, String> {
    match there {
        Value::Table(table) => Ok(table
            .entry(name.to_owned())
            .or_insert_with(|| Value::Table(Table::new()))),
        Value::Array(list) => {
            let length = list.len();
            let place = name.parse::<usize>().ok();
            place.and_then(|place| list.get_mut(place)).ok_or_else(|| {
                format!(
                    "{within} is a list of {length}: expected a place from 0 to {}, not `{name}`",
                    length.saturating_sub(1)
                )
            })
        }
        Value::String(_) | Value::Integer(_) | Value::Float(_) | Value::Boolean(_) | Value::Datetime(_) => {
            Err(format!("{within} is of type {}, and has no keys", there.type_str()))
        }
    }
}

fn read_value(text: &str) -> Value {
    let line = format!("value = {text}");
    toml::from_str::<Table>(&line)
        .ok()
        .and_then(|mut table| table.remove("value"))
        .unwrap_or_else(|| Value::String(text.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "[current]\nspeed_mps = [0.0, 0.25]\n[[plan]]\nspeed_mps = 1.5\n[[plan]]\nspeed_mps = 1.5\n";

    fn set(sets: &[&str]) -> Result<Table, String> {
        let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
        let text = with_sets(FILE, &sets).map_err(|error| error.to_string())?;
        Ok(toml::from_str(&text).unwrap())
    }

    #[test]
    fn a_key_a_place_in_a_list_and_a_new_table_are_set() {
        let file = set(&[
            "world.current.speed_mps=0.3",
            "world.plan.1.speed_mps = 1",
            "world.vehicle.class=21-inch",
        ])
        .unwrap();
        assert_eq!(file["current"]["speed_mps"].as_float(), Some(0.3));
        assert_eq!(file["plan"][0]["speed_mps"].as_float(), Some(1.5));
        assert_eq!(file["plan"][1]["speed_mps"].as_integer(), Some(1));
        assert_eq!(file["vehicle"]["class"].as_str(), Some("21-inch"));
    }

    #[test]
    fn without_a_setting_the_text_stays_as_it_is() {
        assert_eq!(with_sets(FILE, &[]).unwrap(), FILE);
    }

    #[test]
    fn a_setting_that_cannot_be_made_is_one_line() {
        for (text, expected) in [
            ("world.current", "expected world.KEY=VALUE"),
            ("world.current..speed_mps=1", "names joined by dots"),
            (
                "world.plan.2.speed_mps=1",
                "world.plan is a list of 2: expected a place from 0 to 1, not `2`",
            ),
            (
                "world.current.speed_mps.0.x=1",
                "world.current.speed_mps.0 is of type float, and has no keys",
            ),
        ] {
            let error = set(&[text]).unwrap_err();
            assert!(error.contains(expected) && error.starts_with("--set "), "{error}");
        }
    }

    #[test]
    fn settings_are_split_by_their_file() {
        let sets = ["limits.x=1".to_owned(), "world.x=1".to_owned(), "worldly=1".to_owned()];
        let (mission, world) = split_sets(&sets);
        assert_eq!(mission, ["limits.x=1", "worldly=1"]);
        assert_eq!(world, ["world.x=1"]);
    }
}
