use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::monitor::limits::{LimitError, seconds};

/// What one plugin may use of what the mission allows to all plugins: the `[plugin.limits]` table beside its grants.
/// Where a limit is absent, the mission's `[limits]` are the only bound.
///
/// All plugins share the mission's own caps, and the plugin that asks first gets them. The limits of this table keep a
/// plugin of high priority, or one that asks more often, from using up what the others need.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PluginLimits {
    /// How many of its inserts may be open at once.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inserts_open_max: Option<u32>,
    /// How many tracklines and trackcircles it may send in the whole mission.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inserts_total_max: Option<u32>,
    /// How long its open inserts together may fly unattended, seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inserts_duration_max_s: Option<f64>,
    /// How long it may steer in the whole mission, by modifies and station keeping together, seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steering_max_s: Option<f64>,
    /// How many of its requests the runtime takes in a second.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub requests_per_s: Option<u32>,
}

impl PluginLimits {
    /// Checks that every value is in its range.
    ///
    /// # Errors
    /// [`LimitError`] names the first key whose value is not.
    pub fn validate(&self) -> Result<(), LimitError> {
        for (key, value) in [
            ("inserts_duration_max_s", self.inserts_duration_max_s),
            ("steering_max_s", self.steering_max_s),
        ] {
            if let Some(value) = value
                && !(0.0..1e6).contains(&value)
            {
                return Err(LimitError {
                    key,
                    value,
                    expected: "0 or more",
                });
            }
        }
        if self.requests_per_s == Some(0) {
            return Err(LimitError {
                key: "requests_per_s",
                value: 0.0,
                expected: "at least 1",
            });
        }
        Ok(())
    }

    pub(crate) fn steering_max(&self) -> Option<Duration> {
        self.steering_max_s.map(seconds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_invalid_limit_of_a_plugin_is_named() {
        type Spoil = fn(&mut PluginLimits);
        assert_eq!(PluginLimits::default().validate(), Ok(()));
        let cases: [(&str, Spoil); 3] = [
            ("requests_per_s", |limits| limits.requests_per_s = Some(0)),
            ("steering_max_s", |limits| limits.steering_max_s = Some(f64::NAN)),
            ("inserts_duration_max_s", |limits| {
                limits.inserts_duration_max_s = Some(-1.0);
            }),
        ];
        for (key, spoil) in cases {
            let mut limits = PluginLimits::default();
            spoil(&mut limits);
            assert_eq!(limits.validate().unwrap_err().key, key);
        }
    }
}
