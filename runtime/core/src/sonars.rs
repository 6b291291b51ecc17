//! What we believe of the sonars behind the payload controller, as its client reports it.

use crate::settings::StatusCondition;

/// The longest text for BPSTS, bytes.
const STATUS_BYTES_MAX: usize = 80;

/// The state of the sonars.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Sonars {
    /// Whether the client is ready to send requests.
    pub(crate) ready: bool,
    status: String,
    conditions: Vec<StatusCondition>,
}

impl Sonars {
    /// Takes the state of the sonars for BPSTS.
    pub(crate) fn report(&mut self, mut text: String, conditions: Vec<StatusCondition>) {
        text.truncate(text.floor_char_boundary(STATUS_BYTES_MAX));
        self.status = text;
        self.conditions = conditions;
    }

    /// The state in words.
    pub(crate) fn status(&self) -> &str {
        match self.status.as_str() {
            "" => "sonar not ready",
            status => status,
        }
    }

    /// Whether this is wrong with the sonars.
    pub(crate) fn has(&self, condition: StatusCondition) -> bool {
        self.conditions.contains(&condition) || (condition == StatusCondition::SonarNotReady && !self.ready)
    }
}
