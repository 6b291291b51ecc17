/// Former keys and values of `mission.toml`, each with its present name.
const RENAMED: [(&str, &str); 3] = [
    ("driver", "external"),
    ("hull", "station"),
    ("hold_term_max_s", "term_max_s"),
];

/// A message of the TOML parser, with the new name added if the unknown key or value is a former one.
pub(crate) fn with_new_name(message: &str) -> String {
    let unknown = |of: &str| message.split_once(of)?.1.split_once('`').map(|(name, _)| name);
    let name = unknown("unknown field `").or_else(|| unknown("unknown variant `"));
    match RENAMED.iter().find(|(old, _)| Some(*old) == name) {
        Some((old, new)) => format!("`{old}` is called `{new}` now: {message}"),
        None => message.to_owned(),
    }
}
