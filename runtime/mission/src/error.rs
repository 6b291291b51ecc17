use std::path::{Path, PathBuf};

/// A mission that cannot be used. The message is one line: the file, the place in it, what was expected.
#[derive(Debug, thiserror::Error)]
pub enum MissionError {
    /// A file cannot be read.
    #[error("{}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
    /// The folder holds no mission.
    #[error("{}: no mission here: expected a folder with mission.toml and a fence{}", path.display(), did_you_mean(inside.as_deref()))]
    NoMission {
        /// The path that was given.
        path: PathBuf,
        /// A mission in this folder.
        inside: Option<PathBuf>,
    },
    /// There is nothing at the path.
    #[error("{}: no such folder{}", path.display(), did_you_mean(similar.as_deref()))]
    NoSuchMission {
        /// The path that was given.
        path: PathBuf,
        /// The mission whose path is most like it.
        similar: Option<PathBuf>,
    },
    /// A file was given in place of a folder.
    #[error("{}: expected a folder with mission.toml and a fence, and this is a file{}", path.display(), of_folder(folder))]
    NoFolder {
        /// The path that was given.
        path: PathBuf,
        /// The folder that it is in.
        folder: PathBuf,
    },
    /// An error in a TOML file.
    #[error("{}:{line}: {message}", path.display())]
    Toml {
        /// The file.
        path: PathBuf,
        /// Counted from 1.
        line: usize,
        /// What is wrong, and what was expected.
        message: String,
    },
    /// An invalid value.
    #[error("{}: {message}", path.display())]
    Value {
        /// The file.
        path: PathBuf,
        /// The key, its value and what was expected.
        message: String,
    },
    /// An error in a value from the environment or the command line.
    #[error("{layer}: {message}")]
    Layer {
        /// Where the value comes from.
        layer: String,
        /// What is wrong.
        message: String,
    },
    /// A plugin's component was not found.
    #[error("plugin `{plugin}`: no component `{component}`: looked for {looked}: build it, or correct `component`")]
    NoComponent {
        /// The plugin's name in the mission.
        plugin: String,
        /// Its `component` key.
        component: String,
        /// The places that were tried, in order.
        looked: String,
    },
}

fn did_you_mean(path: Option<&Path>) -> String {
    path.map_or_else(String::new, |path| format!(": did you mean {}?", path.display()))
}

fn of_folder(folder: &Path) -> String {
    match folder.to_str() {
        None | Some("") => String::new(),
        Some(folder) => format!(": give {folder}"),
    }
}
