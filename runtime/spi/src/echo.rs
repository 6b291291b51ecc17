use std::fmt;

use backseat_units::{TimeOfDay, TimeOfDayError};
use serde::{Deserialize, Serialize};

/// The creation time of a command as the vehicle's acknowledgement echoes it (SPI 6.21).
///
/// The specification prints two decimals for it, and real vehicles write three. An echo shows the command's time only
/// to its last decimal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct EchoedTime {
    time: TimeOfDay,
    decimals: u8,
}

impl EchoedTime {
    /// The echo of a command that had no time: `000000.000`.
    pub const NONE: Self = Self::of(TimeOfDay::MIDNIGHT);

    /// Makes an echo with three decimals, as most are.
    #[must_use]
    pub const fn of(time: TimeOfDay) -> Self {
        Self::with_decimals(time, 3)
    }

    /// Makes an echo with this number of decimals, nine at most. The further decimals of the time are cut off.
    #[must_use]
    pub const fn with_decimals(time: TimeOfDay, decimals: u8) -> Self {
        let decimals = if decimals > 9 { 9 } else { decimals };
        let unit = unit_nanos(decimals);
        let nanos = time.as_nanos();
        match TimeOfDay::from_nanos(nanos - nanos % unit) {
            Some(time) => Self { time, decimals },
            None => Self { time, decimals },
        }
    }

    /// The time as it was written.
    #[must_use]
    pub const fn time(self) -> TimeOfDay {
        self.time
    }

    /// The number of decimals of a second that it has, 0 to 9.
    #[must_use]
    pub const fn decimals(self) -> u8 {
        self.decimals
    }

    /// Whether the echo says that the command had no time.
    #[must_use]
    pub fn is_none(self) -> bool {
        self.time == TimeOfDay::MIDNIGHT
    }

    /// Whether this echoes a command that was made at `created`. The times must be equal except for what the echo's
    /// decimals leave out: all of the further decimals if they are cut off, up to half a unit if the echo is rounded. An
    /// echo that says that there was no time echoes no command.
    #[must_use]
    pub fn echoes(self, created: TimeOfDay) -> bool {
        let unit = unit_nanos(self.decimals).min(1_000_000_000).cast_signed();
        let left_out = created.nanos_since(self.time);
        // Our own times are whole milliseconds, so finer decimals are noise of the vehicle's arithmetic.
        let echoes = if unit <= 1_000_000 {
            left_out.abs() < 1_000_000
        } else {
            -unit / 2 <= left_out && left_out < unit
        };
        !self.is_none() && echoes
    }
}

impl fmt::Display for EchoedTime {
    /// `08:10:25.95`, with the echo's number of decimals.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (hour, minute, second, nanos) = self.time.hms_nano();
        write!(f, "{hour:02}:{minute:02}:{second:02}")?;
        let decimals = format!("{nanos:09}");
        match decimals.get(..usize::from(self.decimals)) {
            None | Some("") => Ok(()),
            Some(decimals) => write!(f, ".{decimals}"),
        }
    }
}

impl From<EchoedTime> for String {
    fn from(echo: EchoedTime) -> Self {
        echo.to_string()
    }
}

impl TryFrom<String> for EchoedTime {
    type Error = TimeOfDayError;

    fn try_from(text: String) -> Result<Self, TimeOfDayError> {
        let time = text.parse()?;
        let decimals = text.split_once('.').map_or(0, |(_, decimals)| decimals.len().min(9));
        Ok(Self::with_decimals(time, decimals as u8))
    }
}

const fn unit_nanos(decimals: u8) -> u64 {
    10u64.pow(9 - decimals as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(nanos: u64) -> TimeOfDay {
        TimeOfDay::from_nanos(nanos).unwrap()
    }

    #[test]
    fn an_echo_matches_to_the_decimals_that_it_has() {
        let created = at(29_425_987_000_000);
        for decimals in 0..=9 {
            assert!(
                EchoedTime::with_decimals(created, decimals).echoes(created),
                "{decimals}"
            );
        }
        // Echoes that were rounded.
        assert!(EchoedTime::with_decimals(at(29_425_990_000_000), 2).echoes(created));
        assert!(EchoedTime::with_decimals(at(29_426_000_000_000), 0).echoes(created));
        // Echoes of other commands.
        assert!(!EchoedTime::of(at(29_425_986_000_000)).echoes(created));
        assert!(!EchoedTime::with_decimals(at(29_425_970_000_000), 2).echoes(created));
        assert!(!EchoedTime::with_decimals(at(29_427_000_000_000), 0).echoes(created));
    }

    #[test]
    fn an_echo_without_a_time_echoes_no_command() {
        assert!(!EchoedTime::NONE.echoes(TimeOfDay::MIDNIGHT));
        assert!(!EchoedTime::with_decimals(TimeOfDay::MIDNIGHT, 0).echoes(at(300_000_000)));
    }

    #[test]
    fn an_echo_as_text_keeps_its_decimals() {
        for decimals in 0..=9 {
            let echo = EchoedTime::with_decimals(at(29_425_987_654_321), decimals);
            assert_eq!(EchoedTime::try_from(echo.to_string()), Ok(echo));
        }
        assert_eq!(
            EchoedTime::with_decimals(at(29_425_987_654_321), 2).to_string(),
            "08:10:25.98"
        );
    }

    #[test]
    fn midnight_lies_between_a_command_and_its_rounded_echo() {
        let created = at(86_399_999_000_000);
        assert!(EchoedTime::with_decimals(at(86_399_990_000_000), 2).echoes(created));
        assert!(!EchoedTime::with_decimals(at(500_000_000), 1).echoes(created));
    }
}
