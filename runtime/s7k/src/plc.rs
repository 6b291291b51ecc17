//! What is said with the payload controller (PLC) in text: commands, status and alarms (appendix C).
//!
//! Each text has a number in its record's header and parameters that are separated by commas. The tables here are the
//! specification's: a row has the number, the words before the parameters, and the parameters with their formats.

mod alarm;
mod command;
mod form;
mod generic;
mod status;
mod table;
mod text;

pub use alarm::{Alarm, FailureCause};
pub use command::{Command, CommandId, Order};
pub use form::{CalendarTime, PlcVersion};
pub use generic::Generic;
pub use status::{HealthEntry, ModuleEntry, PulseName, RunListEntry, Status};
pub use text::{TextError, TextFault};

/// The kind of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TextKind {
    /// A command of Table 16, in record 11000.
    Command,
    /// A generic sensor command of Table 19, in record 11000 with command 0.
    Generic,
    /// A status of Table 17, in record 11002.
    Status,
    /// An alarm of Table 18, in record 11002.
    Alarm,
}

/// A row of Tables 16 to 19.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct TextEntry {
    /// What it is.
    pub kind: TextKind,
    /// Its number in the record's header. The generic commands have none, and are counted here.
    pub id: i32,
    /// The name of this crate's variant.
    pub name: &'static str,
    /// The words before the parameters.
    pub prefix: &'static str,
    /// The parameters.
    pub fields: &'static [TextField],
    /// A text as it lies in a record.
    pub example: &'static str,
    /// The test that any values survive their text.
    pub test: &'static str,
}

/// A parameter of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct TextField {
    /// Its name in this crate's type.
    pub name: &'static str,
    /// Its format, as the specification writes it.
    pub format: &'static str,
    /// Its unit or meaning.
    pub unit: &'static str,
}

impl TextEntry {
    /// The whole format, as the specification writes it: `%d, %lu`. A dash stands for no text.
    #[must_use]
    pub fn format(&self) -> String {
        let formats: Vec<&str> = self.fields.iter().map(|field| field.format).collect();
        let format = format!("{}{}", self.prefix, formats.join(", "));
        if format.is_empty() { "-".to_owned() } else { format }
    }
}

/// Every command, generic command, status and alarm.
pub fn texts() -> impl Iterator<Item = &'static TextEntry> {
    [command::ENTRIES, generic::ENTRIES, status::ENTRIES, alarm::ENTRIES]
        .into_iter()
        .flatten()
}

pub(crate) use command::CODES;

#[cfg(test)]
mod tests;
