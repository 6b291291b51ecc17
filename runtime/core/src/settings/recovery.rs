use serde::{Deserialize, Serialize};

use crate::monitor::limits::LimitError;

/// The steps of recovery: the `[recovery]` table of a mission. Times count from when the vehicle was first outside.
/// Time that it spends inside in between does not count.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Recovery {
    /// After how long the vehicle counts as outside, seconds. Leases end then.
    pub outside_for_s: f64,
    /// After how long outside the runtime cancels our inserts that have not begun, seconds.
    pub cancel_after_s: f64,
    /// Whether the runtime then also ends the insert of ours that is being flown (BPRCB, SPI 7.10), if the way that
    /// remains is inside the fence.
    pub cancel_current: bool,
    /// After how long outside the runtime reports it in the vehicle's log and to the topside, seconds.
    pub tell_after_s: f64,
    /// Whether the runtime reports it to the topside too (BPTOP, SPI 7.3), or in the vehicle's log alone (BPMSG, SPI
    /// 7.1).
    pub tell_topside: bool,
    /// After how long outside the runtime aborts the vehicle's mission (BPABT, SPI 7.16), seconds; never if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub abort_after_s: Option<f64>,
    /// How far inside the vehicle must be to count as inside again, metres beyond the margin.
    pub back_by_m: f64,
    /// For how long it must be there, seconds.
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
    /// Checks that every value is in its range, and that the steps are in order.
    ///
    /// # Errors
    /// [`LimitError`] names the first key whose value is not.
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
