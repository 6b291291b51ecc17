use backseat_world::Span;
use serde::Deserialize;

use crate::error::{MvcError, check};
use crate::file::{RoleConfig, WithoutRole};

/// The `[spi]` section: the server that payloads connect to.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SpiConfig {
    /// The interface version that BFVER announces.
    pub version: String,
    /// What the vehicle sends to a new client before it asks for anything.
    pub profile: Profile,
    /// How the vehicle answers requests that change its plan, and messages to the topside (SPI 4.4).
    pub acknowledge: AcknowledgeConfig,
    /// How long such a request is pending, seconds, drawn for each, 0 to 1.9, and at most 2 s less one step of the
    /// vehicle (SPI 4.4).
    pub pending_s: Span,
    /// How many clients may be connected at once, 1 to 256. More are turned away.
    pub clients_max: u32,
    /// The roles that clients hold according to the address that they connect from (SPI 4.1), at most 256 entries; an
    /// empty list means that there are no roles.
    pub roles: Vec<RoleConfig>,
    /// What happens to a client whose address has no role, if there are roles.
    pub without_role: WithoutRole,
    /// The text of an acknowledgement of success that has nothing else to say, at most 100 characters.
    pub acknowledge_text: String,
    /// What ends each of the vehicle's sentences.
    pub line_end: LineEnd,
}

/// What ends each of the vehicle's sentences.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LineEnd {
    /// Carriage return and line feed (SPI 4.2).
    #[default]
    Crlf,
    /// The same and another line feed, which makes a blank line after each sentence, as vehicles in the field do.
    CrlfLf,
}

/// What the vehicle sends to a new client before it asks for anything.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Profile {
    /// No status messages, as the specification says (section 6).
    #[default]
    Spec,
    /// BFCTL and BFMIS, as vehicles in the field do.
    Field,
}

/// How the vehicle answers requests that change its plan, and messages to the topside (SPI 4.4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AcknowledgeConfig {
    /// First `pending`, and the outcome later.
    #[default]
    Pending,
    /// The outcome at once.
    Immediate,
}

impl Default for SpiConfig {
    fn default() -> Self {
        Self {
            version: "1.12".to_owned(),
            profile: Profile::Spec,
            acknowledge: AcknowledgeConfig::Pending,
            pending_s: Span::between(0.1, 1.5),
            clients_max: 16,
            roles: Vec::new(),
            without_role: WithoutRole::Refuse,
            acknowledge_text: String::new(),
            line_end: LineEnd::Crlf,
        }
    }
}

impl SpiConfig {
    pub(crate) fn validate(&self) -> Result<(), MvcError> {
        let (least, most) = (self.pending_s.least(), self.pending_s.most());
        check(least >= 0.0 && least <= most, "spi.pending_s", least, "0 to 1.9 s")?;
        // A step of the vehicle may pass between the due time and the answer.
        check(most <= 1.9, "spi.pending_s", most, "0 to 1.9 s")?;
        let clients = self.clients_max;
        check(
            (1..=256).contains(&clients),
            "spi.clients_max",
            f64::from(clients),
            "1 to 256",
        )?;
        let roles = self.roles.len();
        check(roles <= 256, "spi.roles", roles as f64, "at most 256 entries")?;
        for role in &self.roles {
            role.validate()?;
        }
        for (key, text, most, expected) in [
            (
                "spi.version",
                &self.version,
                40,
                "at most 40 printable ascii characters without comma, asterisk and dollar",
            ),
            (
                "spi.acknowledge_text",
                &self.acknowledge_text,
                100,
                "at most 100 printable ascii characters without comma, asterisk and dollar",
            ),
        ] {
            if backseat_spi::Text::new(text).is_err() || text.len() > most {
                let value = format!("{text:?}");
                return Err(MvcError::Value { key, value, expected });
            }
        }
        Ok(())
    }
}
