use std::path::PathBuf;

/// A mission that cannot be used. Always one line: file, place, what was expected.
#[derive(Debug, thiserror::Error)]
pub enum MissionError {
    /// A file that cannot be read.
    #[error("{}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The folder is no mission.
    #[error("{}: no mission here: expected a folder with mission.toml and a fence", path.display())]
    NoMission {
        /// What was given.
        path: PathBuf,
    },
    /// A fault in a TOML file.
    #[error("{}:{line}: {message}", path.display())]
    Toml {
        /// The file.
        path: PathBuf,
        /// Counted from 1.
        line: usize,
        /// What is wrong and what was expected.
        message: String,
    },
    /// A value that is no good.
    #[error("{}: {message}", path.display())]
    Value {
        /// The file.
        path: PathBuf,
        /// Key, value, what was expected.
        message: String,
    },
    /// A fault in the environment's or the command line's layer.
    #[error("{layer}: {message}")]
    Layer {
        /// Which layer.
        layer: String,
        /// What is wrong.
        message: String,
    },
    /// A plugin's component is nowhere.
    #[error("plugin `{plugin}`: no component `{component}`: looked for {looked}")]
    NoComponent {
        /// The plugin's name in the mission.
        plugin: String,
        /// Its `component` key.
        component: String,
        /// The places, in order.
        looked: String,
    },
}
