use serde::{Deserialize, Serialize};

use crate::monitor::limits::LimitError;

/// The ladder of a mission: its `[recovery]` table. Times count from when the vehicle was first outside, while it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Recovery {
    /// After how long outside the vehicle counts as outside, and leases end, seconds.
    pub outside_for_s: f64,
    /// After how long outside our inserts that have not begun are cancelled, seconds.
    pub cancel_after_s: f64,
    /// Whether the insert of ours that is flown is ended with them (BPRCB, SPI 7.10), where the way that remains holds.
    pub cancel_current: bool,
    /// After how long outside the vehicle's log and the topside are told, seconds.
    pub tell_after_s: f64,
    /// Whether the topside is told (BPTOP, SPI 7.3), or the vehicle's log alone (BPMSG, 7.1).
    pub tell_topside: bool,
    /// After how long outside the vehicle's mission is aborted (BPABT, SPI 7.16), seconds: never where it is absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub abort_after_s: Option<f64>,
    /// How far inside the vehicle must be to be inside again, metres beyond the margin.
    pub back_by_m: f64,
    /// For how long, seconds.
    pub back_for_s: f64,
}

impl Default for Recovery {
    fn default() -> Self {
        Self {
            outside_for_s: 2.0,
            cancel_after_s: 4.0,
            cancel_current: false,
            tell_after_s: 10.0,
            tell_topside: true,
            abort_after_s: None,
            back_by_m: 5.0,
            back_for_s: 10.0,
        }
    }
}

impl Recovery {
    /// Every figure within what it can mean, the steps in their order.
    ///
    /// # Errors
    /// [`LimitError`] names the first key that is not.
    pub fn validate(&self) -> Result<(), LimitError> {
        const LONGEST_S: f64 = 3600.0;
        let fault = |key, value, expected| Err(LimitError { key, value, expected });
        for (key, value) in [
            ("outside_for_s", self.outside_for_s),
            ("cancel_after_s", self.cancel_after_s),
            ("tell_after_s", self.tell_after_s),
            ("abort_after_s", self.abort_after_s.unwrap_or(LONGEST_S)),
            ("back_for_s", self.back_for_s),
        ] {
            if !(0.0..=LONGEST_S).contains(&value) {
                return fault(key, value, "within 0 to 3600 s");
            }
        }
        if !(0.0..=1000.0).contains(&self.back_by_m) {
            return fault("back_by_m", self.back_by_m, "within 0 to 1000 m");
        }
        if self.cancel_after_s < self.outside_for_s {
            return fault("cancel_after_s", self.cancel_after_s, "at least outside_for_s");
        }
        if self.tell_after_s < self.cancel_after_s {
            return fault("tell_after_s", self.tell_after_s, "at least cancel_after_s");
        }
        match self.abort_after_s {
            Some(abort_s) if abort_s < self.tell_after_s => fault("abort_after_s", abort_s, "at least tell_after_s"),
            Some(_) | None => Ok(()),
        }
    }
}
