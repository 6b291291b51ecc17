use std::fmt;

use serde::{Deserialize, Serialize};

use crate::plugin::PluginId;

/// Which driver of the mission: its place in the mission file, 0 first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct DriverId(pub usize);

/// Whose a request is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Owner {
    /// A plugin's, under a grant.
    Plugin(PluginId),
    /// The operator's, by word or by a policy of the mission.
    Operator,
    /// A configured driver's.
    Driver(DriverId),
}

impl Owner {
    /// The plugin, where it is one's.
    #[must_use]
    pub const fn plugin(self) -> Option<PluginId> {
        match self {
            Self::Plugin(plugin) => Some(plugin),
            Self::Operator | Self::Driver(_) => None,
        }
    }
}

impl From<PluginId> for Owner {
    fn from(plugin: PluginId) -> Self {
        Self::Plugin(plugin)
    }
}

impl From<DriverId> for Owner {
    fn from(driver: DriverId) -> Self {
        Self::Driver(driver)
    }
}

impl PartialEq<PluginId> for Owner {
    fn eq(&self, plugin: &PluginId) -> bool {
        self.plugin() == Some(*plugin)
    }
}

impl fmt::Display for Owner {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Plugin(plugin) => write!(f, "plugin {}", plugin.0),
            Self::Operator => f.write_str("operator"),
            Self::Driver(driver) => write!(f, "driver {}", driver.0),
        }
    }
}
