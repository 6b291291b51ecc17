//! What shall happen in a run, and when: rules that are data, and the orders that a rule or the operator gives.

pub(crate) mod line;
pub(crate) mod rules;
mod text;

use core::time::Duration;

use backseat_spi::{CommandName, Text, Transport};
use backseat_units::Timestamp;

use crate::error::MvcError;
use crate::faults::Fault;
use crate::file::ScriptFile;

/// A script: rules of the form "some time after something has happened, the vehicle does something".
///
/// ```
/// let script = backseat_mvc::Script::from_toml(r#"
/// [[rule]]
/// when = { received = "BPRMB" }
/// after_s = 3
/// do = { control = "take" }
///
/// [[rule]]
/// when = { at_s = 60 }
/// do = { fault = { kind = "stall", for_s = 10 } }
/// "#)?;
/// assert_eq!(script.rules.len(), 2);
/// # Ok::<(), backseat_mvc::MvcError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Script {
    /// The rules, in any order. A rule's number is its place here, from 1.
    pub rules: Vec<Rule>,
}

/// One rule of a script.
#[derive(Clone, Debug, PartialEq)]
pub struct Rule {
    /// The line of the file in which it begins, from 1.
    pub line: usize,
    /// What it waits for.
    pub when: Trigger,
    /// For which time of that: 1 is the first. Without meaning for [`Trigger::At`].
    pub nth: u32,
    /// Whether it also acts for each later time.
    pub again: bool,
    /// How long after that it acts.
    pub after: Duration,
    /// What the vehicle then does.
    pub order: Order,
}

/// What a rule waits for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trigger {
    /// This time of the run.
    At(Timestamp),
    /// A client connects, and the vehicle accepts it.
    Connected,
    /// A client's sentence with this name arrives, whatever the vehicle answers.
    Received(CommandName),
    /// A behavior begins (BFMBS, SPI 6.9).
    Began(Beginning),
}

/// Which behaviors a rule waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beginning {
    /// Every behavior.
    Any,
    /// An insert of a client, of whichever type.
    Insert,
    /// The behaviors of this type in BFMBS, of the plan or inserted.
    Kind(&'static str),
}

/// What a rule or the operator orders.
#[derive(Clone, Debug, PartialEq)]
pub enum Order {
    /// A fault begins, whatever its `at` says, and lasts as long as it says.
    Fault(Fault),
    /// Whether the payload has control (BFCTL, SPI 6.24), from now on.
    Control(ControlOrder),
    /// A message comes from the topside (BFTOP, SPI 5.5).
    Topside {
        /// The link that it comes by.
        transport: Transport,
        /// The message.
        text: Text,
        /// The role of the client that gets it (SPI 4.1); `None` for every client.
        role: Option<String>,
    },
    /// The dive with this name is loaded ([`crate::Mvc::load_dive`]).
    Load(Text),
    /// The dive that is ready starts ([`crate::Mvc::start_dive`]).
    Start,
    /// The dive that runs ends as successful ([`crate::Mvc::end_dive`]).
    End,
    /// The dive that runs is aborted ([`crate::Mvc::abort_dive`]).
    Abort,
    /// BFSHT comes (SPI 5.2), and a minute later the payload's power goes off.
    Shutdown,
}

/// Who decides whether the payload has control.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ControlOrder {
    /// The plan and `mission.control`.
    #[default]
    Plan,
    /// The payload has none, whatever the plan allows.
    Take,
    /// The payload has it while the mission runs, whatever the plan allows. A fault `control_taken` still takes it.
    Give,
}

/// Who has ordered something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Orderer {
    /// The rule of the script with this number, from 1.
    Rule(u32),
    /// The operator of the mock.
    Operator,
}

impl Script {
    /// Reads a script: `[[rule]]` tables with `when` and `do`.
    ///
    /// # Errors
    /// [`MvcError::Toml`] with line and column, or [`MvcError::Rule`] with line, number, key and what was expected.
    pub fn from_toml(text: &str) -> Result<Self, MvcError> {
        ScriptFile::from_toml(text)?.script(text)
    }
}
