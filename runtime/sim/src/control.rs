//! When the runtime had control in a run, and why it had none.

use std::collections::BTreeMap;
use std::fmt;

use backseat_core::refusal::Uncontrolled;
use serde::Serialize;

/// When the runtime had control, and for how long it had none while the vehicle's mission ran, by reason. Looked at
/// once a second of the run.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct ControlTimes {
    /// The times with control, oldest first.
    pub windows: Vec<ControlTime>,
    /// Seconds of the mission without control, by reason.
    pub without_s: BTreeMap<&'static str, u64>,
    #[serde(skip)]
    granted: bool,
}

/// A time with control, whole seconds since the start of the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct ControlTime {
    /// The first second with control.
    pub from_s: u64,
    /// The first second without control after it, or the run's last second.
    pub until_s: u64,
}

/// What the runtime said of control at a second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Control {
    /// It had control.
    Granted,
    /// It had none.
    Lost(Uncontrolled),
    /// No process of the runtime was there.
    NoProcess,
}

impl ControlTimes {
    pub(crate) fn second(&mut self, now_s: u64, control: Control, mission_runs: bool) {
        let granted = control == Control::Granted;
        match self.windows.last_mut() {
            Some(window) if self.granted => window.until_s = now_s,
            _ if granted => self.windows.push(ControlTime {
                from_s: now_s,
                until_s: now_s,
            }),
            _ => {}
        }
        self.granted = granted;
        let reason = match control {
            Control::Granted => return,
            Control::Lost(reason) => reason.text(),
            Control::NoProcess => "the runtime was not running",
        };
        if mission_runs {
            *self.without_s.entry(reason).or_default() += 1;
        }
    }
}

/// In a line: `88-456 s; the rest of the time: the vehicle has control 120 s`.
impl fmt::Display for ControlTimes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const SHOWN: usize = 6;
        if self.windows.is_empty() {
            write!(f, "never")?;
        }
        for (index, window) in self.windows.iter().take(SHOWN).enumerate() {
            let comma = if index > 0 { ", " } else { "" };
            write!(f, "{comma}{}-{} s", window.from_s, window.until_s)?;
        }
        if let Some(more) = self.windows.len().checked_sub(SHOWN).filter(|more| *more > 0) {
            write!(f, " and {more} more times")?;
        }
        let mut reasons: Vec<_> = self.without_s.iter().collect();
        // The longest first. A sort by name before it makes the order of equal ones certain.
        reasons.sort_by_key(|(_, seconds)| std::cmp::Reverse(**seconds));
        for (index, (reason, seconds)) in reasons.iter().enumerate() {
            let lead = if index > 0 { ", " } else { "; the rest of the time: " };
            write!(f, "{lead}{reason} ({seconds} s)")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_and_reasons_are_those_that_were_seen() {
        let mut times = ControlTimes::default();
        let has = Control::Lost(Uncontrolled::VehicleHasControl);
        let seen = [
            (0, has, false),
            (1, has, true),
            (2, Control::Granted, true),
            (3, Control::Granted, true),
            (4, has, true),
            (5, has, true),
            (6, Control::NoProcess, true),
            (7, Control::Granted, true),
            (8, Control::Lost(Uncontrolled::MissionNotRunning), false),
        ];
        for (now_s, control, runs) in seen {
            times.second(now_s, control, runs);
        }
        let windows: Vec<_> = times.windows.iter().map(|time| (time.from_s, time.until_s)).collect();
        assert_eq!(windows, [(2, 4), (7, 8)]);
        let text = format!(
            "2-4 s, 7-8 s; the rest of the time: {} (3 s), the runtime was not running (1 s)",
            Uncontrolled::VehicleHasControl.text()
        );
        assert_eq!(times.to_string(), text);
        assert_eq!(ControlTimes::default().to_string(), "never");
    }
}
