//! The layer of the command line: `--set KEY=VALUE`.

use toml::{Table, Value};

use crate::error::MissionError;

/// One `--set`.
struct Set<'a> {
    key: &'a str,
    value: &'a str,
}

impl<'a> Set<'a> {
    fn parse(set: &'a str) -> Result<Self, MissionError> {
        let Some((key, value)) = set.split_once('=') else {
            return Err(fault(
                set,
                "expected KEY=VALUE, such as limits.speed_max_mps=1.8".to_owned(),
            ));
        };
        Ok(Self { key: key.trim(), value })
    }

    /// The key below `plugin`, if it is one of a plugin.
    fn of_plugin(&self) -> Option<&'a str> {
        match self.key.strip_prefix("plugin") {
            Some("") => Some(""),
            Some(rest) => rest.strip_prefix('.'),
            None => None,
        }
    }

    /// A line of TOML. The value is read as TOML where it is valid TOML, so that 1.8 is a number and true a boolean;
    /// otherwise as text.
    fn line(&self, key: &str) -> String {
        let line = format!("{key} = {}", self.value);
        if toml::from_str::<Table>(&line).is_ok() {
            line
        } else {
            format!("{key} = {:?}", self.value)
        }
    }
}

fn fault(set: &str, message: String) -> MissionError {
    MissionError::Layer {
        layer: format!("--set {set}"),
        message,
    }
}

/// A `--set` as a line of TOML; none for a key of a plugin, which [`plugins`] has set.
pub(crate) fn line(text: &str) -> Result<Option<String>, MissionError> {
    let set = Set::parse(text)?;
    if set.of_plugin().is_some() {
        return Ok(None);
    }
    let line = set.line(set.key);
    if toml::from_str::<Table>(&line).is_err() {
        return Err(fault(
            text,
            format!("invalid key `{}`: expected names joined by dots", set.key),
        ));
    }
    Ok(Some(line))
}

/// The text of `mission.toml` with the keys of plugins set: `plugin.NAME.KEY`, because a mission may have several.
pub(crate) fn plugins(text: &str, sets: &[String]) -> Result<String, MissionError> {
    let mut file: Option<Table> = None;
    for text_of_set in sets {
        let set = Set::parse(text_of_set)?;
        let Some(key) = set.of_plugin() else { continue };
        // The file was parsed before.
        let file = file.get_or_insert_with(|| toml::from_str(text).unwrap_or_default());
        set_plugin(file, &set, key).map_err(|message| fault(text_of_set, message))?;
    }
    Ok(file.map_or_else(|| text.to_owned(), |file| file.to_string()))
}

fn set_plugin(file: &mut Table, set: &Set<'_>, key: &str) -> Result<(), String> {
    let tables = file.get_mut("plugin").and_then(Value::as_array_mut);
    let mut named: Vec<(String, &mut Table)> = tables
        .into_iter()
        .flatten()
        .filter_map(|plugin| {
            let table = plugin.as_table_mut()?;
            Some((table.get("name")?.as_str()?.to_owned(), table))
        })
        .collect();
    let names: Vec<String> = named.iter().map(|(name, _)| format!("`{name}`")).collect();
    // A name may itself have a dot, so the longest that fits is meant.
    let found = named
        .iter_mut()
        .filter_map(|(name, table)| {
            let key = key.strip_prefix(name.as_str())?.strip_prefix('.')?;
            Some((key, table))
        })
        .min_by_key(|(key, _)| key.len());
    let Some((key, table)) = found else {
        return Err(format!(
            "expected plugin.NAME.KEY, and NAME is a plugin of this mission: {}",
            names.join(", ")
        ));
    };
    let line = toml::from_str::<Table>(&set.line(key))
        .map_err(|_| format!("invalid key `{key}`: expected names joined by dots"))?;
    merge(table, line, "")
}

/// Puts `over` into `table`, key by key.
fn merge(table: &mut Table, over: Table, within: &str) -> Result<(), String> {
    for (key, value) in over {
        match (table.get_mut(&key), value) {
            (Some(Value::Table(inner)), Value::Table(value)) => merge(inner, value, &format!("{within}{key}."))?,
            (Some(there), Value::Table(_)) => {
                return Err(format!(
                    "{within}{key} is of type {}, and has no keys",
                    there.type_str()
                ));
            }
            (_, value) => {
                table.insert(key, value);
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "[limits]\nspeed_max_mps = 2.0\n[[plugin]]\nname = \"a\"\ngrants = []\n\
                        [plugin.config]\ndepth_m = 3\n[[plugin]]\nname = \"a.b\"\ngrants = []\n";

    fn set(sets: &[&str]) -> Result<Table, String> {
        let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
        let text = plugins(FILE, &sets).map_err(|error| error.to_string())?;
        Ok(toml::from_str(&text).unwrap())
    }

    #[test]
    fn a_key_of_a_plugin_is_set_by_its_name() {
        let file = set(&[
            "plugin.a.config.depth_m=4.5",
            "plugin.a.config.words=fast",
            "limits.x=1",
        ])
        .unwrap();
        assert_eq!(file["plugin"][0]["config"]["depth_m"].as_float(), Some(4.5));
        assert_eq!(file["plugin"][0]["config"]["words"].as_str(), Some("fast"));
        assert_eq!(file["plugin"][1].get("config"), None);
        let file = set(&["plugin.a.b.config.deep.er=[1, 2]", "plugin.a.grants=[\"modify\"]"]).unwrap();
        assert_eq!(file["plugin"][1]["config"]["deep"]["er"][1].as_integer(), Some(2));
        assert_eq!(file["plugin"][0]["grants"][0].as_str(), Some("modify"));
    }

    #[test]
    fn without_a_key_of_a_plugin_the_text_stays_as_it_is() {
        assert_eq!(plugins(FILE, &["limits.speed_max_mps=1".to_owned()]).unwrap(), FILE);
        assert_eq!(
            line("limits.speed_max_mps=1").unwrap().as_deref(),
            Some("limits.speed_max_mps = 1")
        );
        assert_eq!(line("plugin.a.config.depth_m=1").unwrap(), None);
    }

    #[test]
    fn what_cannot_be_set_is_said() {
        for (text, expected) in [
            ("plugin.c.config.x=1", "NAME is a plugin of this mission: `a`, `a.b`"),
            ("plugin=1", "expected plugin.NAME.KEY"),
            ("plugin.a.=1", "invalid key ``"),
            ("plugin.a.name.x=1", "name is of type string, and has no keys"),
            (
                "plugin.a.config.depth_m.x=1",
                "config.depth_m is of type integer, and has no keys",
            ),
            ("nonsense", "expected KEY=VALUE"),
        ] {
            let error = set(&[text]).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
    }
}
