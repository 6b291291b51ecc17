use std::path::PathBuf;

use backseat_mission::MissionError;
use backseat_plugin_host::HostError;
use backseat_plugin_loader::LoadError;
use backseat_recorder::RecorderError;
use backseat_scenario::ScenarioError;
use backseat_sim::SimError;

/// Why a tool could not do its work: one line that says what, where and what to do.
#[derive(Debug, thiserror::Error)]
pub enum ToolError {
    /// The environment names no folder for the kit.
    #[error("no folder for the SDK: set BACKSEAT_KIT, XDG_DATA_HOME or HOME")]
    NoPlace,
    /// The kit cannot be unpacked or repaired.
    #[error("{}: the SDK cannot be unpacked here: {source}: set BACKSEAT_KIT to a folder that you can write", path.display())]
    Kit {
        /// The kit's folder.
        path: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
    /// A plugin cannot have this name.
    #[error("{name:?} cannot be the name of a plugin: {fault}")]
    Name {
        /// The name.
        name: String,
        /// What is wrong with it, and what is right.
        fault: String,
    },
    /// The folder of a new plugin exists already.
    #[error("{}: exists already: choose another name, or remove it", path.display())]
    Exists {
        /// The folder.
        path: PathBuf,
    },
    /// A file or a folder cannot be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
    /// The folder is not a plugin's.
    #[error("{}: no Cargo.toml or pyproject.toml here: expected the folder of a plugin, as `backseat plugin new NAME` makes it", path.display())]
    NoProject {
        /// The folder.
        path: PathBuf,
    },
    /// A plugin's `Cargo.toml` or `pyproject.toml` cannot be used.
    #[error("{}: {fault}", path.display())]
    Manifest {
        /// The file.
        path: PathBuf,
        /// What is wrong, and what to do.
        fault: String,
    },
    /// The SDK that a plugin names is not there: the plugin comes from another computer, or the SDK was removed.
    #[error("{}: no SDK at {}: set the path of backseat-sdk to {}", manifest.display(), sdk.display(), here.display())]
    NoSdk {
        /// The plugin's `Cargo.toml`.
        manifest: PathBuf,
        /// Where it looks.
        sdk: PathBuf,
        /// The SDK of this program.
        here: PathBuf,
    },
    /// The plugin has no component yet.
    #[error("{}: not built yet: run `backseat plugin build {}`", component.display(), folder.display())]
    NotBuilt {
        /// The component.
        component: PathBuf,
        /// The plugin's folder.
        folder: PathBuf,
    },
    /// The folder has several plugins, or one with another name.
    #[error("{}: the build has no plugin `{name}`: expected the folder of one plugin", folder.display())]
    OtherPackage {
        /// The plugin's folder.
        folder: PathBuf,
        /// The name in its `Cargo.toml`.
        name: String,
    },
    /// There is no cargo or no rustc.
    #[error("{tool} does not start ({source}): install Rust from https://rustup.rs")]
    NoRust {
        /// `cargo` or `rustc`.
        tool: String,
        /// The reason.
        source: std::io::Error,
    },
    /// The compiler refuses the plugin or its unit tests, and has said why.
    #[error("{}: the plugin or its unit tests do not compile: the compiler's lines above say why", folder.display())]
    TestsDoNotCompile {
        /// The plugin's folder.
        folder: PathBuf,
    },
    /// A tool was ended from outside, before it was done.
    #[error("{what}: ended by signal {signal}, which says nothing about the plugin: try again")]
    Killed {
        /// The command.
        what: String,
        /// The signal.
        signal: i32,
    },
    /// There is no Python.
    #[error("{tool} does not start ({source}): install Python 3.11 or later, or set PYTHON")]
    NoPython {
        /// The program.
        tool: String,
        /// The reason.
        source: std::io::Error,
    },
    /// Python cannot be used, or its packages cannot be installed.
    #[error("{what}: {fault}")]
    Python {
        /// The program or the folder.
        what: String,
        /// What is wrong.
        fault: String,
    },
    /// The SDK could not build a plugin in Python, and has said why.
    #[error("{}: not built: the line above says why", folder.display())]
    PythonBuild {
        /// The plugin's folder.
        folder: PathBuf,
    },
    /// The component cannot be built.
    #[error(transparent)]
    Build(backseat_componentize::Error),
    /// A file is not a component, or not one of a plugin.
    #[error(transparent)]
    Component(#[from] HostError),
    /// The mission cannot be used.
    #[error(transparent)]
    Mission(#[from] MissionError),
    /// A component has no mission to fly in.
    #[error("{}: no mission beside it: give one with --mission", path.display())]
    NoMission {
        /// Where it was expected.
        path: PathBuf,
    },
    /// It is not clear which plugin of the mission the component is.
    #[error("{}: which of its plugins ({}) is {component}? Say it with --plugin", mission.display(), plugins.join(", "))]
    Which {
        /// The mission's folder.
        mission: PathBuf,
        /// The names of its plugins.
        plugins: Vec<String>,
        /// The component.
        component: String,
    },
    /// The mission has no such plugin.
    #[error("{}: no plugin `{name}`; its plugins are: {}", mission.display(), plugins.join(", "))]
    NoPlugin {
        /// The mission's folder.
        mission: PathBuf,
        /// The name that was given.
        name: String,
        /// The names of its plugins.
        plugins: Vec<String>,
    },
    /// The mission flies something else than what was built.
    #[error("{}/mission.toml: no plugin has component = {expected:?}, so what was built would not fly", mission.display())]
    NotFlown {
        /// The mission's folder.
        mission: PathBuf,
        /// The component as the mission should name it.
        expected: String,
    },
    /// The world of the mission cannot be used.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// A plugin cannot be started.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// A trial cannot be flown.
    #[error("seed {seed}: {source}")]
    Flight {
        /// The trial.
        seed: u64,
        /// The reason.
        source: SimError,
    },
    /// The log of a trial cannot be written or read.
    #[error("seed {seed}: {source}")]
    Log {
        /// The trial.
        seed: u64,
        /// The reason.
        source: RecorderError,
    },
}

impl From<backseat_componentize::Error> for ToolError {
    fn from(error: backseat_componentize::Error) -> Self {
        match error {
            backseat_componentize::Error::Tool { tool, source } => Self::NoRust { tool, source },
            backseat_componentize::Error::Encode(_)
            | backseat_componentize::Error::TargetMissing
            | backseat_componentize::Error::Failed { .. }
            | backseat_componentize::Error::NoModule(_)
            | backseat_componentize::Error::File { .. } => Self::Build(error),
        }
    }
}

/// For `map_err`: a file that cannot be read or written.
pub(crate) fn of_file(path: impl Into<PathBuf>) -> impl FnOnce(std::io::Error) -> ToolError {
    let path = path.into();
    |source| ToolError::File { path, source }
}
