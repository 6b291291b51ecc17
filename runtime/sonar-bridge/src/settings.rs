use backseat_core::plugin::PluginId;
use backseat_mission::Mission;
use backseat_sonar::{ConfigError, SonarConfig};
use backseat_units::{LocalFrame, Utc};

use crate::bridge::{Bridge, PluginPing};

/// What a bridge needs to know of a mission.
#[derive(Clone, Debug)]
pub struct SonarSettings {
    config: SonarConfig,
    pings: Vec<PluginPing>,
    frame: LocalFrame,
}

impl SonarSettings {
    /// Those of a mission; `None` if it has no `[sonar]`.
    #[must_use]
    pub fn of(mission: &Mission) -> Option<Self> {
        let config = mission.file.sonar.clone()?;
        let plugins = mission.file.plugins.iter().enumerate();
        let pings = plugins.flat_map(|(index, plugin)| {
            let of = move |grant: &backseat_sonar::PingGrant| PluginPing {
                plugin: PluginId(index),
                grant: *grant,
            };
            plugin.pings.iter().map(of)
        });
        Some(Self {
            pings: pings.collect(),
            frame: *mission.envelope.fence().frame(),
            config,
        })
    }

    /// A bridge with a client that has received no input yet, for a process that starts at this UTC.
    ///
    /// # Errors
    /// [`ConfigError`] names the first setting or grant outside its range.
    pub fn bridge(&self, utc_at_start: Utc) -> Result<Bridge, ConfigError> {
        Bridge::new(self.config.clone(), self.pings.clone(), self.frame, utc_at_start)
    }
}
