//! Alarms of the payload controller (Table 18).

use super::form::{Form, Int, Last, Long, Quoted, Sensor};
use super::table::texts;
use super::text::{Reader, TextError, TextFault, Writer};
use crate::SensorIndex;

texts! {
    /// An alarm of the payload controller.
    pub enum Alarm of Alarm;

    /// No alarm is active.
    0 AllClear "" {}
    ""

    /// Little room is left on the controller's disk, usually 10 % or less.
    1 DiskSpaceCritical "" {
        /// What the controller says of it.
        description: Box<str> as Last, "text";
    }
    "8 % of D: left"

    /// A sensor does not respond.
    2 SensorNotResponding "" {
        /// The sensor.
        sensor: SensorIndex as Sensor, "index";
        /// What the controller says of it.
        description: Box<str> as Last, "text";
    }
    "1, no data for 5 s"

    /// Pings are missing.
    3 PingDropped "" {
        /// The sensor.
        sensor: SensorIndex as Sensor, "index";
        /// The first ping that is missing; -1 if that is not known.
        first: i32 as Long, "ping number";
        /// The last ping that is missing; -1 if only one is.
        last: i32 as Long, "ping number";
    }
    "0, 200, -1"

    /// A sensor reports a failure of its own.
    4 SensorFailure "" {
        /// The sensor.
        sensor: SensorIndex as Sensor, "index";
        /// What kind of failure.
        cause: FailureCause as Cause, "code";
        /// The sensor's own code; -1 if that is not known.
        code: i32 as Int, "code";
        /// What the controller says of it.
        description: Box<str> as Last, "text";
    }
    "1, 3, -1, transceiver at 61 degrees"

    /// A sensor failed its health check.
    5 SensorUnhealthy "" {
        /// The sensor.
        sensor: SensorIndex as Sensor, "index";
        /// What the controller says of it.
        description: Box<str> as Last, "text";
    }
    "1, health check failed"

    /// A sensor did not start.
    6 SensorStartFailed "" {
        /// The sensor.
        sensor: SensorIndex as Sensor, "index";
        /// What the controller says of it.
        description: Box<str> as Last, "text";
    }
    "1, no answer from the bottle"

    /// A sensor did not shut down.
    7 SensorShutdownFailed "" {
        /// The sensor.
        sensor: SensorIndex as Sensor, "index";
        /// What the controller says of it.
        description: Box<str> as Last, "text";
    }
    "1, still pinging"

    /// A sensor gives no data for the log.
    8 SensorDataFailed "" {
        /// The sensor.
        sensor: SensorIndex as Sensor, "index";
        /// What the controller says of it.
        description: Box<str> as Last, "text";
    }
    "1, no imagery"

    /// A sensor did not set its time.
    9 SensorTimeFailed "" {
        /// The sensor.
        sensor: SensorIndex as Sensor, "index";
        /// What the controller says of it.
        description: Box<str> as Last, "text";
    }
    "1, time refused"

    /// A client's message could not be routed to a sensor.
    10 RouteFailed "" {
        /// The sensor.
        sensor: SensorIndex as Sensor, "index";
        /// The client.
        client: i32 as Int, "index";
        /// What the controller says of it.
        description: Box<str> as Last, "text";
    }
    "1, 0, sensor takes no messages"

    /// A sensor did not do a command.
    11 SensorCommandFailed "" {
        /// The sensor.
        sensor: SensorIndex as Sensor, "index";
        /// The client.
        client: i32 as Int, "index";
        /// What the controller says of it.
        description: Box<str> as Last, "text";
    }
    "1, 0, Range = 9000.00"

    /// A sensor's status could not be retrieved.
    12 SensorStatusFailed "" {
        /// The sensor.
        sensor: SensorIndex as Sensor, "index";
        /// What the controller says of it.
        description: Box<str> as Last, "text";
    }
    "1, no status"

    /// A sensor could not be reset.
    13 ResetFailed "" {
        /// The sensor.
        sensor: SensorIndex as Sensor, "index";
        /// What the controller says of it.
        description: Box<str> as Last, "text";
    }
    "1, reset refused"

    /// A client's command is invalid and was ignored.
    14 InvalidCommand "" {
        /// The client.
        client: i32 as Int, "index";
        /// The command of Table 16.
        command: i32 as Int, "code";
        /// What the controller says of it.
        description: Box<str> as Last, "text";
    }
    "0, 16, no such module"

    /// The controller's key is missing. It will end some time later.
    15 KeyMissing "" {
        /// What the controller says of it.
        description: Box<str> as Quoted, "text";
    }
    "\"no HASP key\""
}

impl Alarm {
    /// Reads the text of an alarm; `None` if Table 18 has no alarm of this number.
    ///
    /// # Errors
    /// In it, [`TextError`] names the alarm and the parameter.
    #[must_use]
    pub fn read(id: i32, text: &str) -> Option<Result<Self, TextError>> {
        Self::read_row(id, text)
    }
}

/// The cause of a failure that a sensor reports (Table 18, alarm 4).
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FailureCause {
    /// Unknown or unspecified.
    Unknown,
    /// An internal error code.
    InternalCode,
    /// Service is required.
    ServiceRequired,
    /// The temperature is out of range.
    Temperature,
    /// The humidity is out of range.
    Humidity,
    /// A cause that the specification does not name.
    Other(i32),
}

impl FailureCause {
    /// The causes that the specification names, in the order of their codes.
    pub const NAMED: [Self; 5] = [
        Self::Unknown,
        Self::InternalCode,
        Self::ServiceRequired,
        Self::Temperature,
        Self::Humidity,
    ];

    /// The number in the text.
    #[must_use]
    pub const fn code(self) -> i32 {
        match self {
            Self::Unknown => 0,
            Self::InternalCode => 1,
            Self::ServiceRequired => 2,
            Self::Temperature => 3,
            Self::Humidity => 4,
            Self::Other(code) => code,
        }
    }
}

/// A cause, as its number.
pub(crate) enum Cause {}

impl Form for Cause {
    type Value = FailureCause;
    const FORMAT: &'static str = "%d";

    fn read(reader: &mut Reader<'_>) -> Result<FailureCause, TextFault> {
        let code = Int::read(reader)?;
        let named = FailureCause::NAMED.into_iter().find(|cause| cause.code() == code);
        Ok(named.unwrap_or(FailureCause::Other(code)))
    }

    fn write(value: &FailureCause, writer: &mut Writer<'_>) -> Result<(), TextFault> {
        Int::write(&value.code(), writer)
    }

    #[cfg(test)]
    fn strategy() -> proptest::strategy::BoxedStrategy<FailureCause> {
        use proptest::strategy::Strategy as _;
        (-1..7_i32)
            .prop_map(|code| {
                FailureCause::NAMED
                    .into_iter()
                    .find(|cause| cause.code() == code)
                    .unwrap_or(FailureCause::Other(code))
            })
            .boxed()
    }
}
