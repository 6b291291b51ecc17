use std::collections::BTreeMap;
use std::sync::OnceLock;

use sha2::{Digest as _, Sha256};

use super::lock::Lock;
use super::manifest::stand_alone;

/// The files of the repository that the program carries, by their paths in it.
static FILES: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/kit.rs"));
/// The workspace's manifest, from which its crates inherit.
const WORKSPACE: &str = include!(concat!(env!("OUT_DIR"), "/workspace.rs"));
pub(super) const LOCK: &str = include!(concat!(env!("OUT_DIR"), "/lock.rs"));

/// How many characters of the hash are in the folder's name.
const HASH_CHARS: usize = 12;

/// The files of the kit as they are unpacked: those of the repository, and manifests that need no workspace.
pub(crate) struct Content {
    files: BTreeMap<String, Vec<u8>>,
    name: String,
}

impl Content {
    /// What this program carries.
    pub(crate) fn embedded() -> &'static Self {
        static CONTENT: OnceLock<Content> = OnceLock::new();
        CONTENT.get_or_init(|| {
            let files = FILES.iter().map(|(path, bytes)| {
                let bytes = match path.strip_suffix("/Cargo.toml") {
                    Some(folder) => stand_alone(text(bytes), WORKSPACE, folder)
                        .unwrap_or_else(|fault| panic!("{path} does not stand alone: {fault}"))
                        .into_bytes(),
                    None => bytes.to_vec(),
                };
                ((*path).to_owned(), bytes)
            });
            Self::of(files.collect())
        })
    }

    pub(crate) fn of(files: BTreeMap<String, Vec<u8>>) -> Self {
        let mut hash = Sha256::new();
        for (path, bytes) in &files {
            for part in [path.as_bytes(), bytes] {
                hash.update((part.len() as u64).to_le_bytes());
                hash.update(part);
            }
        }
        let hash: String = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
        Self {
            files,
            name: format!("{}-{}", env!("CARGO_PKG_VERSION"), &hash[..HASH_CHARS]),
        }
    }

    /// `VERSION-HASH`.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    pub(crate) fn files(&self) -> impl Iterator<Item = (&str, &[u8])> {
        self.files.iter().map(|(path, bytes)| (path.as_str(), bytes.as_slice()))
    }

    /// A text file of the kit.
    ///
    /// # Panics
    ///
    /// If the kit has no such file, which a test would show.
    pub(crate) fn text(&self, path: &str) -> &str {
        let bytes = self.files.get(path);
        text(bytes.unwrap_or_else(|| panic!("the kit has no {path}")))
    }

    /// The versions of everything that a plugin is built from.
    pub(crate) fn lock(&self) -> Lock<'_> {
        Lock::new(LOCK, |folder| self.text(&format!("{folder}/Cargo.toml")))
    }
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).expect("the project's sources are UTF-8")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kit_has_what_a_plugin_needs_and_nothing_of_the_tests() {
        let content = Content::embedded();
        let has = |path: &str| content.files().any(|(name, _)| name == path);
        for path in [
            "plugins/sdk/src/lib.rs",
            "runtime/units/src/lib.rs",
            "wit/v0.2.0/plugin.wit",
            "plugins/template/src/lib.rs",
            "missions/template/world.toml",
            "LICENSE-MIT",
        ] {
            assert!(has(path), "{path}");
        }
        assert!(!content.files().any(|(name, _)| name.contains("/tests/")));
        let version = env!("CARGO_PKG_VERSION");
        assert!(content.name().starts_with(&format!("{version}-")), "{}", content.name());
    }

    #[test]
    fn every_manifest_names_only_what_is_in_the_kit_or_in_the_registry() {
        let content = Content::embedded();
        let manifests: Vec<_> = content
            .files()
            .filter(|(path, _)| path.ends_with("Cargo.toml"))
            .collect();
        assert_eq!(manifests.len(), 3);
        for (path, bytes) in manifests {
            let text = text(bytes);
            assert!(
                !text.contains("workspace") && !text.contains("dev-dependencies"),
                "{path}:\n{text}"
            );
            let manifest: toml::Table = text.parse().unwrap();
            for (name, dependency) in manifest["dependencies"].as_table().unwrap() {
                if let Some(to) = dependency.get("path").and_then(toml::Value::as_str) {
                    let folder = path.trim_end_matches("Cargo.toml");
                    let ups = to.matches("../").count();
                    let base: Vec<&str> = folder.trim_end_matches('/').split('/').collect();
                    let target = [&base[..base.len() - ups].join("/"), to.trim_start_matches("../")].join("/");
                    let target = format!("{}/Cargo.toml", target.trim_start_matches('/'));
                    assert!(
                        content.files().any(|(path, _)| path == target),
                        "{path}: {name} is at {target}"
                    );
                }
            }
        }
    }

    #[test]
    fn another_content_has_another_name() {
        let of = |files: &[(&str, &str)]| {
            let files = files
                .iter()
                .map(|(path, text)| ((*path).to_owned(), text.as_bytes().to_vec()));
            Content::of(files.collect()).name().to_owned()
        };
        let names = [of(&[("ab", "c")]), of(&[("a", "bc")]), of(&[("ab", "d")]), of(&[])];
        for (index, name) in names.iter().enumerate() {
            assert!(!names[..index].contains(name), "{names:?}");
        }
        assert_eq!(of(&[("ab", "c")]), names[0]);
    }
}
