use backseat_mission::MissionError;
use backseat_plugin_loader::LoadError;

/// Why a log cannot be replayed.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// An attachment is missing.
    #[error("it has no attachment {name}: expected the log of a run, which has its mission and its fence attached")]
    Attachment {
        /// Its name.
        name: String,
    },
    /// The file ends before its first message.
    #[error("it was cut short before its {name} was written, so there is nothing to replay")]
    Cut {
        /// What is missing first.
        name: String,
    },
    /// An attachment is not what was attached.
    #[error("its attachment {name} has another SHA-256 than the log says: it was changed or damaged")]
    Hash {
        /// Its name.
        name: String,
    },
    /// An attachment is not text.
    #[error("its attachment {name} is not UTF-8")]
    Text {
        /// Its name.
        name: String,
    },
    /// The attached mission, fence or plan cannot be used.
    #[error(transparent)]
    Mission(#[from] MissionError),
    /// The plan that the mission names is not attached.
    #[error("its mission names the plan {file}, which logs of earlier versions do not have: it cannot be replayed")]
    Plan {
        /// The plan's file.
        file: String,
    },
    /// The log has a component by its hash alone.
    #[error(
        "it has the component of plugin `{plugin}` by its hash alone, because the component is large: give the file with \
         --component FILE (SHA-256 {sha256})"
    )]
    ByHashAlone {
        /// The plugin.
        plugin: String,
        /// Its component's hash.
        sha256: String,
    },
    /// The log has neither the component that flew nor what it said about itself.
    #[error(
        "it is of an earlier version and does not say what plugin `{plugin}` listens to: give the component that flew \
         with --plugin {plugin}=FILE (SHA-256 {sha256})"
    )]
    Undescribed {
        /// The plugin.
        plugin: String,
        /// Its component's hash.
        sha256: String,
    },
    /// No plugin of the mission has this name.
    #[error("{option} {name}: the run had no plugin of this name; it had {known}")]
    NoPlugin {
        /// The option.
        option: &'static str,
        /// The name.
        name: String,
        /// The plugins of the mission.
        known: String,
    },
    /// A plugin's component or config was given twice.
    #[error("{option} {name}: given twice")]
    Twice {
        /// The option.
        option: &'static str,
        /// The name.
        name: String,
    },
    /// A plugin's config is given whole and in part.
    #[error(
        "--config {name}: --set also changes the config of {name}, and both are not possible: put the key into the file"
    )]
    ConfigAndSet {
        /// The plugin.
        name: String,
    },
    /// Another component wants what the run did not grant.
    #[error(
        "--plugin {plugin}={file}: it needs {missing}, which the run did not grant {plugin}: a replay keeps the grants of the run"
    )]
    NotGranted {
        /// The plugin.
        plugin: String,
        /// The file.
        file: String,
        /// The missing grants.
        missing: String,
    },
    /// A setting would change more than a plugin's config.
    #[error(
        "--set {set}: expected plugin.NAME.config.KEY=VALUE: all other settings are those of the run, because core is \
         replayed with them"
    )]
    Setting {
        /// The setting.
        set: String,
    },
    /// What `--set` says cannot be used.
    #[error(transparent)]
    Set(MissionError),
    /// A config is not TOML.
    #[error("{file}, line {line}: {message}")]
    Config {
        /// The file.
        file: String,
        /// The line.
        line: usize,
        /// What is wrong.
        message: String,
    },
    /// A component of the log cannot be used.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// A component or a config that was given cannot be used.
    #[error(transparent)]
    Given(LoadError),
    /// A message cannot be read.
    #[error("message {message} of {channel} is invalid: {source}")]
    Message {
        /// Its sequence number.
        message: u32,
        /// Its channel.
        channel: String,
        /// Where reading fails.
        source: serde_json::Error,
    },
    /// The log has no start values of core.
    #[error("it does not say how core was started before its first input (message {message})")]
    NoStart {
        /// The first input.
        message: u32,
    },
}

impl ReplayError {
    /// Whether an option is wrong, and not the log.
    #[must_use]
    pub const fn is_of_an_option(&self) -> bool {
        matches!(
            self,
            Self::NoPlugin { .. }
                | Self::Twice { .. }
                | Self::ConfigAndSet { .. }
                | Self::NotGranted { .. }
                | Self::Setting { .. }
                | Self::Set(_)
                | Self::Config { .. }
                | Self::Given(_)
        )
    }
}
