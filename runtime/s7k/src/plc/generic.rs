//! Generic commands to a sensor (Table 19), which travel as the text of command 0.

use super::form::{Flag, Hundredths, Int, Name};
use super::table::texts;
use super::text::{TextError, TextFault};

texts! {
    /// A generic command to a sensor. A sensor does what is in its capability, and ignores the rest.
    pub enum Generic of Generic;

    /// Sets the range.
    0 Range "Range = " {
        /// The range.
        range_m: f64 as Hundredths, "m";
    }
    "Range = 75.00"

    /// Sets the pulse by name. The names are the sonar's own: see [`super::Status::SensorReply`].
    1 Pulse "Pulse = " {
        /// The pulse's name.
        name: Box<str> as Name, "text";
    }
    "Pulse = FM 4-24 kHz 10 ms"

    /// Pinging on or off.
    2 Ping "Ping = " {
        /// On or off.
        on: bool as Flag, "flag";
    }
    "Ping = 1"

    /// Sets the transmission power.
    3 TxPower "TxPower = " {
        /// The part of full power.
        percent: f64 as Hundredths, "%";
    }
    "TxPower = 80.00"

    /// Sets the gain of the receiver.
    4 RxGain "RxGain = " {
        /// The gain, in the sonar's own steps.
        gain: i32 as Int, "steps";
    }
    "RxGain = 12"

    /// Sets the pulse repetition. The specification calls it a rate, and states milliseconds.
    5 Duration "Duration = " {
        /// The time from ping to ping.
        period_ms: f64 as Hundredths, "ms";
    }
    "Duration = 200.00"

    /// Solicits [`super::Status::SensorReply`].
    6 PulseFiles "PulseFiles" {}
    "PulseFiles"

    /// Resets the sensor. A sensor may ignore it.
    7 DefaultState "DefaultState" {}
    "DefaultState"
}

impl Generic {
    /// Reads the text of command 0. Letters count as they are; spaces do not count.
    ///
    /// # Errors
    /// [`TextError`] names the command and the parameter, or says that there is no such command.
    pub fn read(text: &str) -> Result<Self, TextError> {
        let rows = ENTRIES
            .iter()
            .filter(|entry| super::text::without_prefix(text, entry.prefix).is_some());
        // `Pulse = ` is no start of `PulseFiles`: the longest row wins.
        let row = rows.max_by_key(|entry| entry.prefix.len());
        let unknown = || TextError {
            text: "Generic",
            field: "text",
            fault: TextFault::expected("a generic command of Table 19", text),
        };
        Self::read_row(row.ok_or_else(unknown)?.id, text).ok_or_else(unknown)?
    }
}
