use serde::Deserialize;

use crate::error::{MvcError, check};

/// The `[dvl]` section: external triggering of the DVL by the payload (SPI 5.6, 7.4).
///
/// The mock has no trigger line. It assumes that the line pulses while the payload says so (1 in the second field of
/// its last BPDVR), unless `payload_triggers` is false or one of `line_faults` acts. Without pulses the DVL measures
/// nothing.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DvlTriggerConfig {
    /// Whether the payload has the optional trigger lines. Otherwise every BPDVR fails.
    pub triggering_equipped: bool,
    /// How long after a request external triggering is safe and begins, seconds, 0 to 3600.
    pub safe_after_s: f64,
    /// When the vehicle itself stops external triggering, seconds after the start, in order.
    pub stop_at_s: Vec<f64>,
    /// How long external triggering is not safe after such a stop, seconds, 0 to 86400.
    pub stop_for_s: f64,
    /// After how long without a trigger of the payload the DVL goes back to internal triggering, seconds, 0.1 to 3600.
    pub timeout_s: f64,
    /// Whether the line pulses while the payload says that it triggers.
    pub payload_triggers: bool,
    /// The time from one pulse of the payload to the next, seconds, 0.01 to less than `timeout_s`; without
    /// it, that of the DVL's own trigger.
    pub pulse_period_s: Option<f64>,
    /// The times in which the line is dead although the payload triggers.
    pub line_faults: Vec<LineFault>,
}

/// A time in which the trigger line is dead.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LineFault {
    /// When it begins, seconds after the start.
    pub at_s: f64,
    /// How long it lasts, seconds.
    pub for_s: f64,
}

impl Default for DvlTriggerConfig {
    fn default() -> Self {
        Self {
            triggering_equipped: true,
            safe_after_s: 1.0,
            stop_at_s: Vec::new(),
            stop_for_s: 10.0,
            timeout_s: 5.0,
            payload_triggers: true,
            pulse_period_s: None,
            line_faults: Vec::new(),
        }
    }
}

impl DvlTriggerConfig {
    pub(crate) fn validate(&self) -> Result<(), MvcError> {
        for (key, value, least, most, expected) in [
            ("dvl.safe_after_s", self.safe_after_s, 0.0, 3600.0, "0 to 3600 s"),
            ("dvl.stop_for_s", self.stop_for_s, 0.0, 86_400.0, "0 to 86400 s"),
            ("dvl.timeout_s", self.timeout_s, 0.1, 3600.0, "0.1 to 3600 s"),
        ] {
            check((least..=most).contains(&value), key, value, expected)?;
        }
        if let Some(period_s) = self.pulse_period_s {
            let expected = "0.01 s to less than dvl.timeout_s";
            let ok = (0.01..self.timeout_s).contains(&period_s);
            check(ok, "dvl.pulse_period_s", period_s, expected)?;
        }
        for fault in &self.line_faults {
            for (key, value) in [
                ("dvl.line_faults.at_s", fault.at_s),
                ("dvl.line_faults.for_s", fault.for_s),
            ] {
                check((0.0..=1e9).contains(&value), key, value, "0 to 1e9 s")?;
            }
        }
        super::ordered_times("dvl.stop_at_s", &self.stop_at_s)
    }
}
