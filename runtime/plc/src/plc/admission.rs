//! Whether a command may be done at all: its action and its target (2.5).

use backseat_s7k::SensorIndex;
use backseat_s7k::plc::{Command, CommandId, Generic, Order};
use backseat_s7k::record::Action;

/// Whether the number of a command stands for none: it is reserved, or not in Table 16.
pub(super) const fn is_unknown(command: CommandId) -> bool {
    matches!(
        command,
        CommandId::Reserved19 | CommandId::Reserved27 | CommandId::Other(_)
    )
}

/// Checks what the record's header says of a command, whatever its text is.
///
/// # Errors
/// What is wrong, in words.
pub(super) fn header(command: CommandId, sensor: SensorIndex, action: Action) -> Result<(), String> {
    if let Action::Other(action) = action {
        return Err(format!("action {action}: expected 0, 1 or 2"));
    }
    if sensor < SensorIndex::PLC {
        return Err(format!("sensor index {sensor}: expected -1 or that of a sensor"));
    }
    let for_sensors = matches!(
        command,
        CommandId::Generic
            | CommandId::Subscribe
            | CommandId::Unsubscribe
            | CommandId::Status
            | CommandId::Reset
            | CommandId::Remove
            | CommandId::RouteMessages
    );
    if sensor != SensorIndex::PLC && !for_sensors {
        return Err(format!(
            "{command:?} is for the controller: expected sensor index -1, found {sensor}"
        ));
    }
    Ok(())
}

/// Checks the header against the command's text: a sensor may be named in both, and the action "get" sets nothing.
///
/// # Errors
/// What is wrong, in words.
pub(super) fn text(order: &Order, sensor: SensorIndex, action: Action) -> Result<(), String> {
    let Order::Do(command) = order else { return Ok(()) };
    if let Some(named) = named(command)
        && sensor != SensorIndex::PLC
        && named != sensor
    {
        return Err(format!("the header names sensor {sensor}, and the text sensor {named}"));
    }
    let pulses = if let Command::Generic { text } = command {
        matches!(Generic::read(text), Ok(Generic::PulseFiles {}))
    } else {
        false
    };
    let solicits = pulses || command.solicits();
    if action == Action::Get && !solicits {
        return Err("the action is get, and this command retrieves nothing".to_owned());
    }
    Ok(())
}

/// The sensor that a command's text names.
const fn named(command: &Command) -> Option<SensorIndex> {
    match command {
        Command::Subscribe { sensor, .. }
        | Command::Unsubscribe { sensor, .. }
        | Command::Status { sensor }
        | Command::Reset { sensor }
        | Command::Remove { sensor }
        | Command::RouteMessages { sensor } => Some(*sensor),
        Command::Generic { .. }
        | Command::Logging { .. }
        | Command::Switch { .. }
        | Command::Path { .. }
        | Command::Version {}
        | Command::Load {}
        | Command::Save {}
        | Command::Alarm { .. }
        | Command::Verbose { .. }
        | Command::Shutdown { .. }
        | Command::Modules {}
        | Command::RunList {}
        | Command::Add { .. }
        | Command::ReportLogging {}
        | Command::Reserved19 { .. }
        | Command::TimeSync { .. }
        | Command::Health {}
        | Command::AutoStart { .. }
        | Command::AutoHealthCheck { .. }
        | Command::ReportAlarms {}
        | Command::LoggingSetup { .. }
        | Command::Reserved27 { .. }
        | Command::TimeMessages { .. } => None,
    }
}

/// Why a command without its parameters and with the action "get" has no answer.
pub(super) fn no_answer(command: CommandId) -> &'static str {
    match command {
        CommandId::Logging
        | CommandId::Switch
        | CommandId::Path
        | CommandId::Alarm
        | CommandId::Verbose
        | CommandId::TimeSync
        | CommandId::AutoStart
        | CommandId::AutoHealthCheck
        | CommandId::RouteMessages
        | CommandId::TimeMessages => "no status says what this command sets",
        CommandId::Generic
        | CommandId::Version
        | CommandId::Load
        | CommandId::Save
        | CommandId::Subscribe
        | CommandId::Unsubscribe
        | CommandId::Status
        | CommandId::Reset
        | CommandId::Shutdown
        | CommandId::Modules
        | CommandId::RunList
        | CommandId::Add
        | CommandId::Remove
        | CommandId::ReportLogging
        | CommandId::Reserved19
        | CommandId::Health
        | CommandId::ReportAlarms
        | CommandId::LoggingSetup
        | CommandId::Reserved27
        | CommandId::Other(_) => "this command sets nothing that can be retrieved",
    }
}
