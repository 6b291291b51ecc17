//! Messages about keys and values that a file's reader does not know.

/// Former keys and values of `mission.toml`, each with its present name.
const RENAMED: [(&str, &str); 3] = [
    ("driver", "external"),
    ("hull", "station"),
    ("hold_term_max_s", "term_max_s"),
];
/// How alike a name must be to be suggested (Jaro-Winkler, 1 for equal names).
const LIKENESS_MIN: f64 = 0.85;

/// A message of the TOML parser about `mission.toml`, with the new name added if the unknown key or value is a former
/// one, and else as [`with_suggestion`].
pub(crate) fn with_new_name(message: &str) -> String {
    let name = Unknown::find(message).map(|unknown| unknown.name);
    match RENAMED.iter().find(|(old, _)| Some(*old) == name) {
        Some((old, new)) => format!("`{old}` is called `{new}` now: {message}"),
        None => with_suggestion(message),
    }
}

/// Whether somebody who wrote one name may have meant the other.
pub(crate) fn is_like(written: &str, known: &str) -> bool {
    strsim::jaro_winkler(written, known) >= LIKENESS_MIN
}

/// A message of the TOML parser or of the fence's reader, with the known name that an unknown one resembles most, in
/// place of the list of all names. Without such a name, the message as it is.
#[must_use]
pub fn with_suggestion(message: &str) -> String {
    let Some(unknown) = Unknown::find(message) else {
        return message.to_owned();
    };
    let likeness = |known: &str| strsim::jaro_winkler(unknown.name, known);
    // Of those that are alike, the one with the fewest letters that differ.
    let nearest = unknown
        .known
        .iter()
        .filter(|known| is_like(unknown.name, known))
        .min_by(|a, b| {
            let letters = |known: &str| strsim::osa_distance(unknown.name, known);
            let by_likeness = || likeness(b).total_cmp(&likeness(a)).then_with(|| a.cmp(b));
            letters(a).cmp(&letters(b)).then_with(by_likeness)
        });
    match nearest {
        Some(known) => format!("{}: did you mean `{known}`?{}", unknown.before, unknown.after),
        None => message.to_owned(),
    }
}

/// The parts of serde's message "unknown field `a`, expected one of `b`, `c`", which may have more on both sides.
struct Unknown<'a> {
    /// Up to the unknown name.
    before: &'a str,
    name: &'a str,
    known: Vec<&'a str>,
    /// After the list of known names.
    after: &'a str,
}

impl<'a> Unknown<'a> {
    fn find(message: &'a str) -> Option<Self> {
        let begin = [
            "unknown field `",
            "unknown key `",
            "unknown variant `",
            "unknown command `",
        ]
        .iter()
        .find_map(|text| Some(message.find(text)? + text.len()))?;
        let (name, list) = message.get(begin..)?.split_once('`')?;
        let before = message.get(..begin + name.len() + 1)?;
        let mut after = list;
        let mut known = Vec::new();
        for joint in [", expected one of `", ", expected `"] {
            if let Some(first) = list.strip_prefix(joint) {
                after = first;
                break;
            }
        }
        if after.len() == list.len() {
            // The list is empty: "there are no fields".
            return Some(Self {
                before,
                name,
                known,
                after,
            });
        }
        while let Some((one, rest)) = after.split_once('`') {
            known.push(one);
            after = rest;
            match rest.strip_prefix(", `").or_else(|| rest.strip_prefix(" or `")) {
                Some(next) => after = next,
                None => break,
            }
        }
        Some(Self {
            before,
            name,
            known,
            after,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_most_similar_name_is_suggested() {
        for (message, expected) in [
            (
                "unknown field `turn_rat_dps`, expected one of `speed_min_mps`, `turn_rate_dps`, `turn_lag_s`",
                "unknown field `turn_rat_dps`: did you mean `turn_rate_dps`?",
            ),
            (
                "unknown field `hosts`, expected `host` or `port`",
                "unknown field `hosts`: did you mean `host`?",
            ),
            (
                "unknown field `at_m`, expected one of `east_m`, `at_s`, `for_s`",
                "unknown field `at_m`: did you mean `at_s`?",
            ),
            (
                "unknown field `hosts`, expected `host`",
                "unknown field `hosts`: did you mean `host`?",
            ),
            (
                "unknown variant `modfy`, expected one of `modify`, `insert`, `sonar` for key `plugin[0].grants`",
                "unknown variant `modfy`: did you mean `modify`? for key `plugin[0].grants`",
            ),
            (
                "feature 2 'pier': unknown key `marginn_m`, expected `name`, `margin_m` or `valid_until`",
                "feature 2 'pier': unknown key `marginn_m`: did you mean `margin_m`?",
            ),
        ] {
            assert_eq!(with_suggestion(message), expected);
        }
    }

    #[test]
    fn without_a_similar_name_the_message_stays() {
        for message in [
            "unknown field `bearing`, expected one of `east_m`, `north_m`",
            "unknown field `x`, there are no fields",
            "invalid type: string \"fast\", expected f64",
            "unknown field `",
            "unknown field `a`, expected one of `",
            "",
        ] {
            assert_eq!(with_suggestion(message), message);
        }
    }

    #[test]
    fn a_former_name_is_told_with_its_new_one() {
        let message = "unknown field `driver`, expected one of `external`, `plugin`";
        assert!(with_new_name(message).starts_with("`driver` is called `external` now: "));
    }
}
