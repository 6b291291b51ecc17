//! Commands to the payload controller (Table 16).

use super::Generic;
use super::form::{Bit, Calendar, CalendarTime, Flag, Int, Last, Name, Sensor, Unsigned, UnsignedBit};
use super::table::texts;
use super::text::{TextError, TextFault};
use crate::SensorIndex;
use crate::record::Action;
use crate::wire::codes;

codes! {
    /// The number of a command (Table 16).
    pub enum CommandId: u32 {
        /// A generic sensor command of Table 19.
        0 Generic,
        /// Logging on or off.
        1 Logging,
        /// Changes the logging file.
        2 Switch,
        /// Sets the folder of logged data.
        3 Path,
        /// Solicits the controller's version.
        4 Version,
        /// Loads the run list.
        5 Load,
        /// Saves the run list.
        6 Save,
        /// Subscribes to a record of a sensor.
        7 Subscribe,
        /// Withdraws a subscription.
        8 Unsubscribe,
        /// Alarms on or off.
        9 Alarm,
        /// Solicits a status.
        10 Status,
        /// Acknowledgements on or off.
        11 Verbose,
        /// Resets a sensor.
        12 Reset,
        /// Shuts the controller down.
        13 Shutdown,
        /// Solicits the list of sensor modules.
        14 Modules,
        /// Solicits the run list.
        15 RunList,
        /// Adds a sensor to the run list.
        16 Add,
        /// Removes a sensor from the run list.
        17 Remove,
        /// Solicits the state of logging.
        18 ReportLogging,
        /// Reserved for future use.
        19 Reserved19,
        /// Sets the controller's clock.
        20 TimeSync,
        /// Solicits the health of the sensors.
        21 Health,
        /// Logging and sensors on start-up.
        22 AutoStart,
        /// Health checks at a period.
        23 AutoHealthCheck,
        /// The sensor that gets messages of other kinds.
        24 RouteMessages,
        /// Solicits the active alarms.
        25 ReportAlarms,
        /// Size and overlap of log files.
        26 LoggingSetup,
        /// Reserved for RESON.
        27 Reserved27,
        /// Time messages on or off.
        28 TimeMessages,
    }
}

texts! {
    /// A command with its parameters.
    pub enum Command of Command;

    /// A generic sensor command, as text: see [`Generic`].
    0 Generic "" {
        /// The command of Table 19.
        text: Box<str> as Name, "text";
    }
    "Range = 75.00"

    /// Logging on or off.
    1 Logging "" {
        /// On or off.
        on: bool as Flag, "flag";
    }
    "1"

    /// Changes the logging file now.
    2 Switch "" {
        /// `Auto` for automatic names by size, or a file's name.
        name: Box<str> as Name, "file name";
    }
    "Auto"

    /// Sets the folder of logged data.
    3 Path "" {
        /// The folder.
        folder: Box<str> as Name, "folder";
    }
    "D:\\survey"

    /// Solicits [`super::Status::Version`].
    4 Version "" {}
    ""

    /// Loads the run list from the controller's file 6046.sav.
    5 Load "" {}
    ""

    /// Saves the run list in the controller's file 6046.sav.
    6 Save "" {}
    ""

    /// Subscribes this client to a record of a sensor.
    7 Subscribe "" {
        /// The sensor.
        sensor: SensorIndex as Sensor, "index";
        /// The record type.
        record_type: u32 as Unsigned, "record type";
    }
    "0, 3000"

    /// Withdraws a subscription of this client.
    8 Unsubscribe "" {
        /// The sensor.
        sensor: SensorIndex as Sensor, "index";
        /// The record type.
        record_type: u32 as Unsigned, "record type";
    }
    "0, 3000"

    /// An alarm on or off, for this client.
    9 Alarm "" {
        /// The alarm of Table 18.
        alarm: i32 as Int, "identifier";
        /// On or off.
        on: bool as Bit, "flag";
    }
    "3, 0"

    /// Solicits a status of a sensor. Without parameters it is that of the sensor in the record's header: see
    /// [`Order::Get`].
    10 Status "" {
        /// The sensor.
        sensor: SensorIndex as Sensor, "index";
    }
    "1"

    /// Acknowledgements on (verbose mode) or off (quiet mode).
    11 Verbose "" {
        /// On or off.
        on: bool as Bit, "flag";
    }
    "1"

    /// Resets a sensor to its default state. Reserved for future use.
    12 Reset "" {
        /// The sensor.
        sensor: SensorIndex as Sensor, "index";
    }
    "1"

    /// Shuts the controller down.
    13 Shutdown "" {
        /// 1: the operating system and the sensors too. Any other number: the controller only.
        kind: i32 as Int, "code";
    }
    "0"

    /// Solicits [`super::Status::Modules`].
    14 Modules "" {}
    ""

    /// Solicits [`super::Status::RunList`].
    15 RunList "" {}
    ""

    /// Adds a sensor to the run list and starts it.
    16 Add "" {
        /// The module, as [`super::Status::Modules`] numbers it.
        module: i32 as Int, "module number";
        /// The subsystem of the sonar.
        subsystem: i32 as Int, "subsystem";
        /// The port.
        port: i32 as Int, "port";
        /// The sensor's name.
        name: Box<str> as Name, "text";
    }
    "2, 21, 5, HF sidescan"

    /// Removes a sensor from the run list and shuts it down.
    17 Remove "" {
        /// The sensor.
        sensor: SensorIndex as Sensor, "index";
    }
    "2"

    /// Solicits [`super::Status::FileDetails`].
    18 ReportLogging "" {}
    ""

    /// Reserved for future use.
    19 Reserved19 "" {
        /// What follows.
        text: Box<str> as Last, "text";
    }
    ""

    /// Sets the controller's clock, roughly.
    20 TimeSync "" {
        /// The time, UTC.
        time: CalendarTime as Calendar, "UTC";
    }
    "2026/11/23,14:05:07.25000"

    /// Solicits [`super::Status::Health`].
    21 Health "" {}
    ""

    /// Whether logging and sensors are active from start-up.
    22 AutoStart "" {
        /// On or off.
        on: bool as UnsignedBit, "flag";
    }
    "1"

    /// The controller's own health check of its sensors.
    23 AutoHealthCheck "" {
        /// On or off.
        on: bool as Bit, "flag";
        /// The period.
        period_ms: u32 as Unsigned, "ms";
    }
    "1, 5000"

    /// The sensor that gets 7k messages that are not for the controller.
    24 RouteMessages "" {
        /// The sensor.
        sensor: SensorIndex as Sensor, "index";
    }
    "0"

    /// Solicits the active alarms, a record each.
    25 ReportAlarms "" {}
    ""

    /// Size and overlap of log files. Without parameters it solicits [`super::Status::LoggingSetup`]: see
    /// [`Order::Get`].
    26 LoggingSetup "" {
        /// The size at which the next file begins. The specification states no unit; the status has megabytes.
        file_size: u32 as Unsigned, "megabytes";
        /// How many records of a file the next one repeats.
        overlap: u32 as Unsigned, "records";
    }
    "100, 10"

    /// Reserved for RESON.
    27 Reserved27 "" {
        /// What follows.
        text: Box<str> as Last, "text";
    }
    ""

    /// A time message (record 7400) about once a minute, to all clients.
    28 TimeMessages "" {
        /// On or off.
        on: bool as UnsignedBit, "flag";
    }
    "1"
}

/// What a command's record asks for.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    /// A command with its parameters.
    Do(Command),
    /// The value that a command sets, or the status that belongs to it: a command without its parameters.
    Get(CommandId),
    /// A command whose number is not in Table 16.
    Unknown(CommandId),
}

impl Order {
    /// Reads the text of a command's record. The text may begin with the command's name and a comma, as the syntax of
    /// 2.5 has it, or with its first parameter, as the formats of Table 16 have it.
    ///
    /// # Errors
    /// [`TextError`] names the command and the parameter.
    pub fn read(command: CommandId, action: Action, text: &str) -> Result<Self, TextError> {
        let Ok(id) = i32::try_from(command.code()) else {
            return Ok(Self::Unknown(command));
        };
        let Some(entry) = ENTRIES.iter().find(|entry| entry.id == id) else {
            return Ok(Self::Unknown(command));
        };
        let text = without_name(text, entry.name);
        let without_parameters = text.trim().is_empty() && !entry.fields.is_empty();
        // These two retrieve, whatever the action says: Table 16 has "or none" for the one, and the other's parameter may
        // stand in the record's header.
        let retrieves = matches!(command, CommandId::LoggingSetup | CommandId::Status);
        // A command that is reserved has no parameters to be without.
        let reserved = matches!(command, CommandId::Reserved19 | CommandId::Reserved27);
        if without_parameters && !reserved && (action == Action::Get || retrieves) {
            return Ok(Self::Get(command));
        }
        let fault = TextFault::expected("a command of Table 16", text);
        let unknown = || {
            Err(TextError {
                text: entry.name,
                field: "text",
                fault,
            })
        };
        Command::read_row(id, text).unwrap_or_else(unknown).map(Self::Do)
    }

    /// The command's number.
    #[must_use]
    pub fn command(&self) -> CommandId {
        match self {
            Self::Do(command) => command.command(),
            Self::Get(command) | Self::Unknown(command) => *command,
        }
    }

    /// Appends the text, exactly as Table 16 has it. If the parameters begin as the command's own name would, the name
    /// comes before them, so that nobody takes them for it.
    ///
    /// # Errors
    /// [`TextError`] if a value cannot be written.
    pub fn write(&self, out: &mut String) -> Result<(), TextError> {
        let Self::Do(command) = self else { return Ok(()) };
        let begin = out.len();
        command.write(out)?;
        let entry = ENTRIES
            .iter()
            .find(|entry| i64::from(entry.id) == i64::from(command.command().code()));
        if let Some(entry) = entry
            && without_name(&out[begin..], entry.name) != &out[begin..]
        {
            out.insert_str(begin, ", ");
            out.insert_str(begin, entry.name);
        }
        Ok(())
    }

    /// Whether the record says that it sets or that it retrieves.
    #[must_use]
    pub const fn action(&self) -> Action {
        match self {
            Self::Do(command) if command.solicits() => Action::Get,
            Self::Do(_) => Action::Set,
            Self::Get(_) => Action::Get,
            Self::Unknown(_) => Action::Unspecified,
        }
    }
}

impl Command {
    /// The command's number.
    #[must_use]
    pub fn command(&self) -> CommandId {
        CommandId::from(u32::try_from(self.id()).unwrap_or(u32::MAX))
    }

    /// Whether the command only solicits a message: whether it is one that the action "get" fits.
    #[must_use]
    pub const fn solicits(&self) -> bool {
        match self {
            Self::Version {}
            | Self::Status { .. }
            | Self::Modules {}
            | Self::RunList {}
            | Self::ReportLogging {}
            | Self::Health {}
            | Self::ReportAlarms {} => true,
            Self::Generic { .. }
            | Self::Logging { .. }
            | Self::Switch { .. }
            | Self::Path { .. }
            | Self::Load {}
            | Self::Save {}
            | Self::Subscribe { .. }
            | Self::Unsubscribe { .. }
            | Self::Alarm { .. }
            | Self::Verbose { .. }
            | Self::Reset { .. }
            | Self::Shutdown { .. }
            | Self::Add { .. }
            | Self::Remove { .. }
            | Self::Reserved19 { .. }
            | Self::TimeSync { .. }
            | Self::AutoStart { .. }
            | Self::AutoHealthCheck { .. }
            | Self::RouteMessages { .. }
            | Self::LoggingSetup { .. }
            | Self::Reserved27 { .. }
            | Self::TimeMessages { .. } => false,
        }
    }

    /// A generic sensor command.
    ///
    /// # Errors
    /// [`TextError`] if a value cannot be written.
    pub fn generic(generic: &Generic) -> Result<Self, TextError> {
        let mut text = String::new();
        generic.write(&mut text)?;
        Ok(Self::Generic {
            text: text.into_boxed_str(),
        })
    }
}

/// The text behind the command's own name, if it begins with that.
fn without_name<'a>(text: &'a str, name: &str) -> &'a str {
    match text.trim_start().strip_prefix(name) {
        Some(rest) if rest.trim().is_empty() => "",
        Some(rest) => rest.trim_start().strip_prefix(',').unwrap_or(text),
        None => text,
    }
}
