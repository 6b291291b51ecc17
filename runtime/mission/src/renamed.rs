/// Keys and values of `mission.toml` by the names that they had before, and those that they have.
const RENAMED: [(&str, &str); 3] = [
    ("driver", "external"),
    ("hull", "station"),
    ("hold_term_max_s", "term_max_s"),
];

/// What the reader of TOML says, with the new name where the key or value that it does not know has one.
pub(crate) fn with_new_name(message: &str) -> String {
    let unknown = |of: &str| message.split_once(of)?.1.split_once('`').map(|(name, _)| name);
    let name = unknown("unknown field `").or_else(|| unknown("unknown variant `"));
    match RENAMED.iter().find(|(old, _)| Some(*old) == name) {
        Some((old, new)) => format!("`{old}` is called `{new}` now: {message}"),
        None => message.to_owned(),
    }
}
