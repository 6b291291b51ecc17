use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use serde_json::Value;

use crate::cargo::root;

/// The program's crate.
const PROGRAM: &str = "backseat";
/// The crate that builds the program and the plugins for tests.
const HANDS_OVER: &str = "backseat-test-support";

/// The crates of this workspace, and their dependencies on each other.
#[derive(Debug)]
pub(crate) struct Workspace {
    crates: BTreeMap<String, Crate>,
}

#[derive(Debug)]
struct Crate {
    /// Relative to the workspace's folder.
    folder: PathBuf,
    /// The crates of this workspace on which it depends, including for its tests.
    stands_on: BTreeSet<String>,
}

impl Workspace {
    /// Reads the workspace from Cargo's metadata.
    pub(crate) fn read() -> Result<Self> {
        let root = root()?;
        let output = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
            .args(["metadata", "--format-version", "1", "--no-deps", "--offline"])
            .current_dir(&root)
            .output()
            .context("cargo metadata")?;
        if !output.status.success() {
            bail!("cargo metadata: {}", String::from_utf8_lossy(&output.stderr).trim());
        }
        Self::parse(&serde_json::from_slice(&output.stdout)?, &root)
    }

    fn parse(metadata: &Value, root: &Path) -> Result<Self> {
        let packages = metadata["packages"]
            .as_array()
            .context("cargo metadata has no packages")?;
        let mut crates = BTreeMap::new();
        for package in packages {
            let name = package["name"].as_str().context("a package has no name")?;
            let manifest = Path::new(package["manifest_path"].as_str().unwrap_or_default());
            let folder = manifest.parent().unwrap_or(manifest);
            let dependencies = package["dependencies"].as_array().into_iter().flatten();
            let stands_on = dependencies
                .filter(|dependency| dependency["path"].is_string())
                .filter_map(|dependency| dependency["name"].as_str().map(str::to_owned))
                .collect();
            let folder = folder.strip_prefix(root).unwrap_or(folder).to_path_buf();
            crates.insert(name.to_owned(), Crate { folder, stands_on });
        }
        Ok(Self { crates })
    }

    /// The crate with this name or folder: `core` means `backseat-core`, and so does `runtime/core`.
    pub(crate) fn find(&self, name: &str) -> Result<String> {
        let folder = Path::new(name.trim_start_matches("./").trim_end_matches('/'));
        let by_folder =
            |(_, found): &(&String, &Crate)| !folder.as_os_str().is_empty() && found.folder.ends_with(folder);
        let found = match self.crates.get_key_value(name) {
            Some((found, _)) => Some(found),
            None => self.crates.iter().find(by_folder).map(|(found, _)| found),
        };
        let known = || self.crates.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
        found
            .cloned()
            .with_context(|| format!("no crate is called {name}; the crates are {}", known()))
    }

    /// The crate that a file belongs to, by its path from the workspace's folder.
    pub(crate) fn owner(&self, file: &Path) -> Option<&str> {
        let owners = self.crates.iter().filter(|(_, found)| file.starts_with(&found.folder));
        owners
            .max_by_key(|(_, found)| found.folder.components().count())
            .map(|(name, _)| name.as_str())
    }

    /// All crates.
    pub(crate) fn all(&self) -> BTreeSet<String> {
        self.crates.keys().cloned().collect()
    }

    /// These crates and all that depend on them, directly or indirectly. Tests that are given [`PROGRAM`] depend on it
    /// without Cargo's knowledge; they depend on [`HANDS_OVER`]. (They are given plugins too. A change of a plugin is
    /// checked by its own tests and the reference missions, and by all others in `test`.)
    pub(crate) fn and_those_above(&self, crates: BTreeSet<String>) -> BTreeSet<String> {
        let mut reached = crates;
        loop {
            let handed = reached.contains(PROGRAM);
            let above = self.crates.iter().filter(|(_, found)| {
                !found.stands_on.is_disjoint(&reached) || handed && found.stands_on.contains(HANDS_OVER)
            });
            let more: BTreeSet<String> = above.map(|(name, _)| name.clone()).collect();
            let before = reached.len();
            reached.extend(more);
            if reached.len() == before {
                return reached;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn crates_are_found_by_name_folder_and_file_with_those_above() {
        let package = |name: &str, folder: &str, on: &[&str]| {
            let dependencies: Vec<Value> = on.iter().map(|on| json!({ "name": on, "path": "/w" })).collect();
            json!({ "name": name, "manifest_path": format!("/w/{folder}/Cargo.toml"), "dependencies": dependencies })
        };
        let metadata = json!({ "packages": [
            package("backseat-units", "runtime/units", &[]),
            package("backseat-core", "runtime/core", &["backseat-units"]),
            package("backseat-sim", "runtime/sim", &["backseat-core"]),
            package("isobath", "plugins/isobath", &["backseat-units"]),
            package("backseat-test-support", "tests/support", &[]),
            package("backseat-suite", "tests/suite", &["backseat-test-support"]),
            package("backseat", "runtime/app", &["backseat-sim"]),
        ] });
        let workspace = Workspace::parse(&metadata, Path::new("/w")).unwrap();
        for name in ["core", "backseat-core", "runtime/core/", "./runtime/core"] {
            assert_eq!(workspace.find(name).unwrap(), "backseat-core");
        }
        assert!(workspace.find("cor").is_err() && workspace.find("").is_err());
        assert_eq!(
            workspace.owner(Path::new("runtime/core/src/lib.rs")),
            Some("backseat-core")
        );
        assert_eq!(workspace.owner(Path::new("runtime/docs/hunt.md")), None);
        let above = |name: &str| workspace.and_those_above(BTreeSet::from([name.to_owned()])).len();
        assert_eq!(
            (above("backseat-units"), above("backseat-core"), above("isobath")),
            (6, 4, 1)
        );
    }
}
