use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use crate::Difference;

/// The version of locks.
const FORMAT: u32 = 1;

/// What decides what a vehicle may be asked for, as it was loaded.
#[derive(Clone, Copy, Debug)]
pub struct Parts<'a> {
    /// The mission's name.
    pub name: &'a str,
    /// `mission.toml` as it is written.
    pub file: &'a [u8],
    /// `mission.toml` with everything that was set over it.
    pub mission: &'a str,
    /// The fence's file as it is written.
    pub fence: &'a [u8],
    /// The plan that the mission names.
    pub plan: Option<&'a str>,
    /// The plugins' names and components.
    pub components: &'a [(String, Vec<u8>)],
    /// Other components that may take their places in mid-dive, by the plugins' names.
    pub swaps: &'a [(String, Vec<u8>)],
    /// The SHA-256 of the program, which is large and hashed once.
    pub program_sha256: &'a str,
}

/// The hashes of a mission's parts. All are SHA-256, hexadecimal.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Contents {
    format: u32,
    /// The mission's name.
    pub mission: String,
    /// Who signed, in words of their own.
    pub signed_by: String,
    /// When, UTC.
    pub signed_at: String,
    /// `mission.toml` as it is written.
    file_sha256: String,
    /// `mission.toml` with everything that was set over it, but for its limits.
    mission_sha256: String,
    limits_sha256: String,
    fence_sha256: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    plan_sha256: Option<String>,
    program_sha256: String,
    /// By plugin.
    components: BTreeMap<String, String>,
    /// By plugin.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    swaps: BTreeMap<String, BTreeSet<String>>,
}

impl Contents {
    /// The hashes of these parts.
    #[must_use]
    pub fn of(parts: &Parts<'_>, signed_by: &str, signed_at: &str) -> Self {
        let (rest, limits) = split(parts.mission);
        Self {
            format: FORMAT,
            mission: parts.name.to_owned(),
            signed_by: signed_by.to_owned(),
            signed_at: signed_at.to_owned(),
            file_sha256: sha256(parts.file),
            mission_sha256: sha256(rest.as_bytes()),
            limits_sha256: sha256(limits.as_bytes()),
            fence_sha256: sha256(parts.fence),
            plan_sha256: parts.plan.map(|plan| sha256(plan.as_bytes())),
            program_sha256: parts.program_sha256.to_owned(),
            components: parts
                .components
                .iter()
                .map(|(name, bytes)| (name.clone(), sha256(bytes)))
                .collect(),
            swaps: swaps(parts.swaps),
        }
    }

    /// Whether this component, which is named by its SHA-256, may take a plugin's place in mid-dive: the one that was signed
    /// for it, or another that was.
    #[must_use]
    pub fn may_swap(&self, plugin: &str, sha256: &str) -> bool {
        let flies = self.components.get(plugin).is_some_and(|signed| signed == sha256);
        flies || self.swaps.get(plugin).is_some_and(|signed| signed.contains(sha256))
    }

    /// Whether this version of the program reads the lock.
    pub(crate) const fn is_known(&self) -> bool {
        self.format == FORMAT
    }

    /// The first part that differs from what was signed; `None` if nothing does. Who signed, and when, does not count.
    #[must_use]
    pub fn difference(&self, loaded: &Self) -> Option<Difference> {
        if self.mission != loaded.mission {
            return Some(Difference::Mission {
                signed: self.mission.clone(),
                loaded: loaded.mission.clone(),
            });
        }
        let file_differs = self.file_sha256 != loaded.file_sha256;
        if self.limits_sha256 != loaded.limits_sha256 {
            return Some(if file_differs {
                Difference::Limits
            } else {
                Difference::LimitsSet
            });
        }
        if self.fence_sha256 != loaded.fence_sha256 {
            return Some(Difference::Fence);
        }
        if self.plan_sha256 != loaded.plan_sha256 {
            return Some(Difference::Plan);
        }
        let mut names = self.components.keys().chain(loaded.components.keys());
        if let Some(name) = names.find(|name| self.components.get(*name) != loaded.components.get(*name)) {
            return Some(Difference::Component(name.clone()));
        }
        if file_differs {
            return Some(Difference::File);
        }
        if self.mission_sha256 != loaded.mission_sha256 {
            return Some(Difference::Setting);
        }
        (self.program_sha256 != loaded.program_sha256).then_some(Difference::Program)
    }
}

fn swaps(components: &[(String, Vec<u8>)]) -> BTreeMap<String, BTreeSet<String>> {
    let mut swaps: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (name, bytes) in components {
        swaps.entry(name.clone()).or_default().insert(sha256(bytes));
    }
    swaps
}

/// A mission without its limits, and its limits, so that a difference has a name.
fn split(mission: &str) -> (String, String) {
    let Ok(mut table) = mission.parse::<toml::Table>() else {
        return (mission.to_owned(), String::new());
    };
    let limits = table
        .remove("limits")
        .map(|limits| limits.to_string())
        .unwrap_or_default();
    (table.to_string(), limits)
}

/// The SHA-256 of bytes, hexadecimal.
#[must_use]
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_part_that_differs_has_its_name() {
        let components = [("isobath".to_owned(), vec![1, 2, 3])];
        let others = [("isobath".to_owned(), vec![1, 2, 4])];
        let parts = Parts {
            name: "m",
            file: b"file",
            mission: "[vehicle]\nname = \"v\"\n[limits]\nspeed_max_mps = 2.0\n",
            fence: b"{}",
            plan: Some("plan"),
            components: &components,
            swaps: &others,
            program_sha256: "program",
        };
        let signed = Contents::of(&parts, "Ann", "then");
        let difference = |parts: Parts<'_>| signed.difference(&Contents::of(&parts, "Bob", "now"));
        assert_eq!(difference(parts), None);
        for (plugin, bytes, may) in [
            ("isobath", [1, 2, 3], true),
            ("isobath", [1, 2, 4], true),
            ("isobath", [1, 2, 5], false),
            ("plume", [1, 2, 4], false),
        ] {
            assert_eq!(signed.may_swap(plugin, &sha256(&bytes)), may, "{plugin} {bytes:?}");
        }
        for (parts, words) in [
            (Parts { name: "n", ..parts }, "it is of the mission m"),
            (
                Parts {
                    mission: "[vehicle]\nname = \"w\"\n[limits]\nspeed_max_mps = 2.0\n",
                    ..parts
                },
                "a setting of --set",
            ),
            (Parts { file: b"fil", ..parts }, "mission.toml differs"),
            (
                Parts {
                    mission: "[vehicle]\nname = \"v\"\n[limits]\nspeed_max_mps = 2.1\n",
                    ..parts
                },
                "the limits differ by a setting",
            ),
            (
                Parts {
                    file: b"fil",
                    mission: "[vehicle]\nname = \"v\"\n[limits]\nspeed_max_mps = 2.1\n",
                    ..parts
                },
                "the limits differ",
            ),
            (Parts { fence: b"{ }", ..parts }, "the fence differs"),
            (Parts { plan: None, ..parts }, "the plan differs"),
            (
                Parts {
                    components: &others,
                    ..parts
                },
                "the component of plugin isobath differs",
            ),
            (
                Parts {
                    components: &[],
                    ..parts
                },
                "the component of plugin isobath differs",
            ),
            (
                Parts {
                    program_sha256: "another",
                    ..parts
                },
                "the program differs",
            ),
        ] {
            let found = difference(parts).unwrap().to_string();
            assert!(found.starts_with(words), "{found} is not {words}");
        }
    }
}
