use crate::error::ToolError;
use crate::kit::Content;

/// The longest name, bytes: that of a crate, and of a plugin in its description.
const BYTES_MAX: usize = 64;

/// Names that Rust or Cargo use themselves.
const TAKEN: &[&str] = &[
    "abstract",
    "alloc",
    "as",
    "async",
    "await",
    "become",
    "box",
    "break",
    "build",
    "const",
    "continue",
    "core",
    "crate",
    "deps",
    "do",
    "dyn",
    "else",
    "enum",
    "examples",
    "extern",
    "false",
    "final",
    "fn",
    "for",
    "gen",
    "if",
    "impl",
    "in",
    "incremental",
    "let",
    "loop",
    "macro",
    "match",
    "mod",
    "move",
    "mut",
    "override",
    "priv",
    "proc-macro",
    "proc_macro",
    "pub",
    "ref",
    "return",
    "self",
    "static",
    "std",
    "struct",
    "super",
    "test",
    "trait",
    "true",
    "try",
    "type",
    "typeof",
    "unsafe",
    "unsized",
    "use",
    "virtual",
    "where",
    "while",
    "yield",
];

/// Checks a plugin's name: the name of its folder, its crate, its component and its table in the mission.
pub(super) fn check(name: &str) -> Result<(), ToolError> {
    let fault = |fault: String| {
        Err(ToolError::Name {
            name: name.to_owned(),
            fault,
        })
    };
    let letters = |letter: char| letter.is_ascii_lowercase() || letter.is_ascii_digit() || matches!(letter, '-' | '_');
    if !name.starts_with(|first: char| first.is_ascii_lowercase()) || !name.chars().all(letters) {
        return fault("expected a letter of a-z, then a-z, 0-9, `-` and `_`, such as my-survey".to_owned());
    }
    if name.len() > BYTES_MAX {
        return fault(format!("it has {} letters, expected at most {BYTES_MAX}", name.len()));
    }
    if TAKEN.contains(&name) {
        return fault("Rust or Cargo uses it itself: choose another one".to_owned());
    }
    let library = name.replace('-', "_");
    let of_sdk = Content::embedded().lock().names();
    if let Some(package) = of_sdk.iter().find(|package| package.replace('-', "_") == library) {
        return fault(format!(
            "plugins are built with a crate called {package}: choose another one"
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_that_of_a_crate() {
        for good in ["drift", "my-survey", "a", "plume_2", "isobath"] {
            check(good).unwrap();
        }
        let long = "x".repeat(65);
        for (bad, why) in [
            ("", "expected a letter"),
            ("2nd", "expected a letter"),
            ("-drift", "expected a letter"),
            ("Drift", "expected a letter"),
            ("a b", "expected a letter"),
            ("a/b", "expected a letter"),
            ("../up", "expected a letter"),
            ("größe", "expected a letter"),
            (&long, "at most 64"),
            ("test", "Rust or Cargo"),
            ("yield", "Rust or Cargo"),
            ("serde", "a crate called serde"),
            ("backseat_sdk", "a crate called backseat-sdk"),
        ] {
            let error = check(bad).unwrap_err().to_string();
            assert!(error.contains(why) && error.contains(&format!("{bad:?}")), "{error}");
            assert_eq!(error.lines().count(), 1);
        }
    }
}
