use backseat_world::Span;
use serde::Deserialize;

use crate::error::{MvcError, check};

/// The `[silence]` section: silent mode (SPI 7.22).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SilenceConfig {
    /// How long the devices take to go quiet or to come back, seconds, drawn for each request, at most 2 s less one
    /// step of the vehicle. The second acknowledgement comes then.
    pub settle_s: Span,
    /// The time after which silent mode ends by itself, seconds, 1 to 86400.
    pub timeout_s: f64,
    /// How long the propeller still turns after its thruster is off, seconds, 0 to 60. Silent mode cannot begin before
    /// it stops.
    pub spin_down_s: f64,
    /// How likely a request for silent mode fails although the propeller has stopped, 0 to 1.
    pub failure_chance: f64,
}

impl Default for SilenceConfig {
    fn default() -> Self {
        Self {
            settle_s: Span::between(0.2, 1.5),
            timeout_s: 300.0,
            spin_down_s: 1.5,
            failure_chance: 0.0,
        }
    }
}

impl SilenceConfig {
    pub(crate) fn validate(&self, tick_s: f64) -> Result<(), MvcError> {
        let (least, most) = (self.settle_s.least(), self.settle_s.most());
        check(least >= 0.0, "silence.settle_s", least, "0 s or more")?;
        let expected = "2 s less one step of the vehicle: the second acknowledgement comes within 2 s";
        check(most <= 2.0 - tick_s + 1e-9, "silence.settle_s", most, expected)?;
        for (key, value, least, most, expected) in [
            ("silence.timeout_s", self.timeout_s, 1.0, 86_400.0, "1 to 86400 s"),
            ("silence.spin_down_s", self.spin_down_s, 0.0, 60.0, "0 to 60 s"),
            ("silence.failure_chance", self.failure_chance, 0.0, 1.0, "0 to 1"),
        ] {
            check((least..=most).contains(&value), key, value, expected)?;
        }
        Ok(())
    }
}
