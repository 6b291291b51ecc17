use serde::Deserialize;

use crate::error::{MvcError, check};

/// One `[[mission.commands]]`: a mission command (BFMSC) that a user-defined behavior of the mission sends (SPI 5.1).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MissionCommandConfig {
    /// When the vehicle sends it, seconds after the mission's start, 0 to 1e7. A mission that is over by then does not
    /// send it.
    pub at_s: f64,
    /// The role of the client that gets it; `None` for every client.
    pub role: Option<String>,
    /// Its text, 1 to 1000 characters. Only the payload understands it.
    pub text: String,
}

impl MissionCommandConfig {
    pub(crate) fn validate(&self) -> Result<(), MvcError> {
        let at_s = self.at_s;
        check((0.0..=1e7).contains(&at_s), "mission.commands.at_s", at_s, "0 to 1e7 s")?;
        for (key, text, most) in [
            ("mission.commands.text", self.text.as_str(), 1000),
            ("mission.commands.role", self.role.as_deref().unwrap_or("all"), 32),
        ] {
            if backseat_spi::Text::new(text).is_err() || text.is_empty() || text.len() > most {
                return Err(MvcError::Value {
                    key,
                    value: format!("{text:?}"),
                    expected: "1 to 1000 (role: 32) printable ascii characters without comma, asterisk and dollar",
                });
            }
        }
        Ok(())
    }
}
