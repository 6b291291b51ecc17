use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result};

/// The feature that lets a test leave out checks of the safety monitor.
const FEATURE: &str = "mutations";
/// The program for sea never enables it.
const PROGRAM: &str = "runtime/app/Cargo.toml";
/// The feature with which the exploration copies and compares core's state, the crate that has it, and the only one
/// that asks for it.
const EXPLORE: (&str, &str, &str) = ("\"explore\"", "runtime/core/Cargo.toml", "tests/explore/Cargo.toml");

/// Checks that no crate gets the monitor's mutations unless it asks for them by name: the feature appears only among
/// features that pass it on under the same name.
pub(crate) fn mutations(root: &Path, faults: &mut Vec<String>) -> Result<()> {
    let output = Command::new("git")
        .args(["ls-files", "*Cargo.toml"])
        .current_dir(root)
        .output()
        .context("git")?;
    for file in String::from_utf8_lossy(&output.stdout).lines() {
        let path = root.join(file);
        if path.exists() {
            let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
            faults.extend(enabled(file, &text));
        }
    }
    Ok(())
}

/// The lines of a manifest that may enable the feature.
fn enabled(file: &str, manifest: &str) -> Vec<String> {
    let mut section = "";
    let mut faults = Vec::new();
    for (number, line) in manifest.lines().enumerate() {
        let code = line.split('#').next().unwrap_or_default().trim();
        if code.starts_with('[') {
            section = code;
        }
        let passes_on = section == "[features]" && code.split('=').next().is_some_and(|key| key.trim() == FEATURE);
        if code.contains(FEATURE) && (file == PROGRAM || !passes_on) {
            let place = format!("{file}:{}", number + 1);
            faults.push(format!("{place}: only tests may leave out the monitor's checks"));
        }
        let (feature, owner, user) = EXPLORE;
        let asks = code.contains(feature) || code.contains("backseat-core/explore");
        if asks && file != owner && file != user {
            let place = format!("{file}:{}", number + 1);
            faults.push(format!("{place}: only the exploration may copy core's state"));
        }
    }
    faults
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_feature_of_its_own_passes_the_mutations_on() {
        let passes_on = "[features]\n# mutations\nmutations = [\"backseat-core/mutations\"]\n";
        assert!(enabled("tests/hunt/Cargo.toml", passes_on).is_empty());
        assert_eq!(enabled(PROGRAM, passes_on).len(), 1);
        for enables in [
            "[features]\ndefault = [\"mutations\"]\n",
            "[features]\nall = [\"backseat-core/mutations\"]\n",
            "[dependencies]\nbackseat-core = { workspace = true, features = [\"mutations\"] }\n",
            "[dependencies.backseat-core]\nworkspace = true\nfeatures = [\n  \"mutations\",\n]\n",
        ] {
            assert_eq!(enabled("tests/hunt/Cargo.toml", enables).len(), 1, "{enables}");
        }
    }

    #[test]
    fn only_the_exploration_copies_cores_state() {
        let asks = "[dependencies]\nbackseat-core = { workspace = true, features = [\"explore\"] }\n";
        assert!(enabled("tests/explore/Cargo.toml", asks).is_empty());
        for text in [asks, "[features]\nexplore = [\"backseat-core/explore\"]\n"] {
            for file in [PROGRAM, "tests/hunt/Cargo.toml"] {
                assert_eq!(enabled(file, text).len(), 1, "{file}: {text}");
            }
        }
    }
}
