use std::fmt;

use backseat_core::plugin::PluginId;
use serde_json::{Map, Value};

/// What a simulation does to the process that it runs, and core cannot know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Remark {
    /// The process is killed. After this, nothing of it is recorded.
    Killed,
    /// A signal stops it.
    Stopped,
    /// It goes on.
    Continues,
    /// Another process has started. [`crate::Recorder::restart`] comes before this.
    StartedAgain,
    /// From now on another plugin stands in for this one.
    Substituted(PluginId),
    /// It answers itself again.
    Reinstated(PluginId),
}

impl Remark {
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Killed => "killed",
            Self::Stopped => "stopped",
            Self::Continues => "continues",
            Self::StartedAgain => "started-again",
            Self::Substituted(_) => "substituted",
            Self::Reinstated(_) => "reinstated",
        }
    }

    pub(crate) const fn plugin(self) -> Option<PluginId> {
        match self {
            Self::Killed | Self::Stopped | Self::Continues | Self::StartedAgain => None,
            Self::Substituted(plugin) | Self::Reinstated(plugin) => Some(plugin),
        }
    }

    /// The remark of a message of `/notes`, if it is one.
    #[must_use]
    pub fn of_note(note: &Value) -> Option<Self> {
        let note: &Map<String, Value> = note.as_object()?;
        let plugin = || {
            let number = note.get("plugin")?.as_u64()?;
            Some(PluginId(usize::try_from(number).ok()?))
        };
        match note.get("simulation")?.as_str()? {
            "killed" => Some(Self::Killed),
            "stopped" => Some(Self::Stopped),
            "continues" => Some(Self::Continues),
            "started-again" => Some(Self::StartedAgain),
            "substituted" => plugin().map(Self::Substituted),
            "reinstated" => plugin().map(Self::Reinstated),
            _ => None,
        }
    }
}

/// As it is in the log.
impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Killed => f.write_str("the runtime is killed"),
            Self::Stopped => f.write_str("the runtime is stopped"),
            Self::Continues => f.write_str("the runtime continues"),
            Self::StartedAgain => f.write_str("the runtime has started again"),
            Self::Substituted(PluginId(plugin)) => write!(f, "another plugin stands in for plugin {plugin}"),
            Self::Reinstated(PluginId(plugin)) => write!(f, "plugin {plugin} answers itself again"),
        }
    }
}
