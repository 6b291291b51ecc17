//! Arguments that several commands share.

use std::path::{Path, PathBuf};

use backseat_mission::Layers;
use clap::Args;

/// The arguments of all commands that read a mission.
#[derive(Debug, Args)]
pub(crate) struct MissionArguments {
    /// The mission's folder, with mission.toml, a fence (fence.geojson, fence.plan or fence.kml) and, to simulate it,
    /// world.toml
    pub(crate) mission: PathBuf,
    /// Look in this folder first for plugins that the mission names without a path
    #[arg(long, value_name = "DIR", value_parser = folder)]
    pub(crate) plugins: Option<PathBuf>,
    /// Compile the plugins, and keep nothing for the next start. Without this, what was compiled once is loaded from the
    /// folder BACKSEAT_CACHE [default: backseat in the user's cache folder]
    #[arg(long)]
    pub(crate) no_cache: bool,
    /// Set a key of mission.toml, such as limits.speed_max_mps=1.8; overrides the file and the environment. In a
    /// simulation also a key of world.toml, such as world.current.speed_mps=0.3
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
}

impl MissionArguments {
    pub(crate) fn layers(&self) -> Layers {
        Layers {
            set: self.set.iter().filter(|set| !is_of_world(set)).cloned().collect(),
            environment: true,
        }
    }

    /// The keys of `world.toml` that are set.
    pub(crate) fn world_sets(&self) -> Vec<String> {
        self.set.iter().filter(|set| is_of_world(set)).cloned().collect()
    }
}

fn is_of_world(set: &str) -> bool {
    set.trim_start().starts_with("world.")
}

/// The argument of the commands that need only the world of a mission.
#[cfg(feature = "simulation")]
#[derive(Debug, Args)]
pub(crate) struct WorldArguments {
    /// A folder with world.toml, such as a mission's, or the path of a world.toml. Nothing else of a mission is read
    #[arg(value_name = "MISSION|WORLD.toml")]
    pub(crate) world: PathBuf,
}

pub(crate) fn folder(text: &str) -> Result<PathBuf, String> {
    let folder = PathBuf::from(text);
    if folder.is_dir() {
        Ok(folder)
    } else {
        Err(match folder.parent().filter(|_| folder.is_file()) {
            Some(parent) => format!("expected a folder, and this is a file: give {}", or_here(parent)),
            None => "no such folder".to_owned(),
        })
    }
}

/// The empty path is the working folder.
fn or_here(folder: &Path) -> std::path::Display<'_> {
    match folder.as_os_str().is_empty() {
        true => Path::new(".").display(),
        false => folder.display(),
    }
}

/// A seed. The option that takes it allows numbers with a sign, so that this message comes and not one about options.
#[cfg(feature = "simulation")]
pub(crate) fn seed(text: &str) -> Result<u64, String> {
    text.parse()
        .map_err(|_| format!("expected one whole number from 0 to {}", u64::MAX))
}
