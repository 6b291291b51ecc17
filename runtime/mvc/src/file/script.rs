use core::fmt;
use core::time::Duration;

use backseat_spi::{CommandName, Text, Transport};
use backseat_units::Timestamp;
use serde::Deserialize;
use toml::Spanned;

use super::FaultEntry;
use super::faults::{LONGEST_S, is_command};
use crate::error::MvcError;
use crate::script::{Beginning, ControlOrder, Order, Rule, Script, Trigger};

/// The most rules that a script may have.
const RULES_MAX: usize = 1000;
/// The greatest `nth`.
const NTH_MAX: u32 = 1_000_000;
/// The longest text of a message from the topside, characters.
const TEXT_MAX: usize = 200;

/// A file with a script as it is written.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ScriptFile {
    /// The rules, in any order.
    pub rule: Vec<Spanned<RuleEntry>>,
}

/// One rule as it is written.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RuleEntry {
    /// What it waits for.
    pub when: WhenEntry,
    /// For which time of that, 1 to 1000000; the first without this key. Not with `at_s`.
    pub nth: Option<u32>,
    /// Whether it also acts for each later time; false without this key. Not with `at_s`.
    pub again: Option<bool>,
    /// How long after that it acts, seconds; 0 without this key.
    #[serde(default)]
    pub after_s: f64,
    /// What the vehicle then does.
    #[serde(rename = "do")]
    pub order: OrderEntry,
}

/// What a rule waits for, as it is written.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WhenEntry {
    /// A client connects.
    Connected,
    /// This time of the run, seconds after its start.
    AtS(f64),
    /// A client's sentence with this name arrives, written `RMB` or `BPRMB`.
    Received(String),
    /// A behavior begins.
    Began(BeganName),
}

/// Which behaviors a rule waits for, as it is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "these are the types of BFMBS")]
pub enum BeganName {
    /// Every behavior.
    Any,
    /// An insert of a client.
    Insert,
    Trackline,
    Trackcircle,
    Waypoint,
    Setpoint,
    Gps,
    Command,
}

/// What the vehicle does, as it is written.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OrderEntry {
    /// The dive that is ready starts.
    Start,
    /// The dive that runs ends as successful.
    End,
    /// The dive that runs is aborted.
    Abort,
    /// BFSHT comes, and a minute later the payload's power goes off.
    Shutdown,
    /// The dive with this name is loaded.
    Load(String),
    /// A fault begins: the keys of a fault without `at_s`.
    Fault(Box<FaultEntry>),
    /// Whether the payload has control.
    Control(ControlName),
    /// A message comes from the topside.
    Topside(MessageEntry),
}

/// The name of a [`ControlOrder`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ControlName {
    /// As the plan and `mission.control` say.
    Plan,
    /// The payload has none.
    Take,
    /// The payload has it while the mission runs.
    Give,
}

/// A message from the topside, as it is written.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MessageEntry {
    /// The link that it comes by.
    pub transport: Transport,
    /// Its text: 1 to 200 printable ASCII characters without comma, asterisk and dollar.
    pub text: String,
    /// The role of the client that gets it; every client without this key.
    #[serde(default)]
    pub role: Option<String>,
}

impl ScriptFile {
    pub(crate) fn from_toml(text: &str) -> Result<Self, MvcError> {
        toml::from_str(text).map_err(|error| super::toml_error(text, &error))
    }

    /// Checks every value and returns the script. `text` is the text of the file.
    ///
    /// # Errors
    /// [`MvcError::Rule`] with the rule's line and number, the key, and what was expected.
    pub fn script(&self, text: &str) -> Result<Script, MvcError> {
        if self.rule.len() > RULES_MAX {
            return Err(MvcError::Value {
                key: "rule",
                value: format!("{} rules", self.rule.len()),
                expected: "at most 1000",
            });
        }
        let numbered = (1..).zip(&self.rule);
        let rules = numbered.map(|(number, entry)| {
            let before = text.get(..entry.span().start).unwrap_or_default();
            let line = before.matches('\n').count() + 1;
            let rule = entry.get_ref().rule(line);
            rule.map_err(|fault| MvcError::Rule { line, number, fault })
        });
        Ok(Script {
            rules: rules.collect::<Result<_, _>>()?,
        })
    }
}

impl RuleEntry {
    fn rule(&self, line: usize) -> Result<Rule, String> {
        let when = self.when.trigger()?;
        if let Trigger::At(_) = when {
            for (key, is_there) in [("nth", self.nth.is_some()), ("again", self.again.is_some())] {
                if is_there {
                    return Err(format!("`{key}` has no meaning with `at_s`, which comes once"));
                }
            }
        }
        let nth = self.nth.unwrap_or(1);
        if !(1..=NTH_MAX).contains(&nth) {
            return Err(format!("nth is {nth}, expected 1 to {NTH_MAX}"));
        }
        Ok(Rule {
            line,
            when,
            nth,
            again: self.again.unwrap_or(false),
            after: seconds("after_s", self.after_s)?,
            order: self.order.order()?,
        })
    }
}

impl WhenEntry {
    fn trigger(&self) -> Result<Trigger, String> {
        Ok(match self {
            Self::Connected => Trigger::Connected,
            Self::AtS(at_s) => Trigger::At(Timestamp::ZERO + seconds("at_s", *at_s)?),
            Self::Received(name) => match CommandName::new(name) {
                Ok(name) if is_command(name) => Trigger::Received(name),
                Ok(_) | Err(_) => {
                    return Err(format!(
                        "received is {name:?}, expected a sentence that a client sends, RMB or BPRMB"
                    ));
                }
            },
            Self::Began(name) => Trigger::Began((*name).into()),
        })
    }
}

impl From<BeganName> for Beginning {
    fn from(name: BeganName) -> Self {
        match name {
            BeganName::Any => Self::Any,
            BeganName::Insert => Self::Insert,
            BeganName::Trackline => Self::Kind("trackline"),
            BeganName::Trackcircle => Self::Kind("trackcircle"),
            BeganName::Waypoint => Self::Kind("waypoint"),
            BeganName::Setpoint => Self::Kind("setpoint"),
            BeganName::Gps => Self::Kind("gps"),
            BeganName::Command => Self::Kind("command"),
        }
    }
}

impl From<ControlName> for ControlOrder {
    fn from(name: ControlName) -> Self {
        match name {
            ControlName::Plan => Self::Plan,
            ControlName::Take => Self::Take,
            ControlName::Give => Self::Give,
        }
    }
}

impl OrderEntry {
    /// The order.
    ///
    /// # Errors
    /// The key, what is wrong and what was expected.
    pub(crate) fn order(&self) -> Result<Order, String> {
        Ok(match self {
            Self::Load(dive) => Order::Load(said("load", dive)?),
            Self::Start => Order::Start,
            Self::End => Order::End,
            Self::Abort => Order::Abort,
            Self::Shutdown => Order::Shutdown,
            Self::Fault(entry) => Order::Fault(entry.untimed()?),
            Self::Control(name) => Order::Control((*name).into()),
            Self::Topside(message) => message.order()?,
        })
    }
}

impl MessageEntry {
    fn order(&self) -> Result<Order, String> {
        if let Transport::Other(code) = self.transport {
            return Err(format!(
                "transport is {code}, expected a transport of the specification"
            ));
        }
        if let Some(role) = &self.role {
            said("role", role)?;
        }
        Ok(Order::Topside {
            transport: self.transport,
            text: said("text", &self.text)?,
            role: self.role.clone(),
        })
    }
}

/// A text that a sentence can carry.
fn said(key: &str, text: &str) -> Result<Text, String> {
    match Text::new(text) {
        Ok(said) if (1..=TEXT_MAX).contains(&text.len()) => Ok(said),
        Ok(_) | Err(_) => Err(format!(
            "{key} is {}, expected 1 to {TEXT_MAX} printable ascii characters without comma, asterisk and dollar",
            Quoted(text)
        )),
    }
}

/// A text in quotes, of which a long one is cut.
struct Quoted<'a>(&'a str);

impl fmt::Display for Quoted<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let start: String = self.0.chars().take(40).collect();
        let more = if start.len() < self.0.len() { "..." } else { "" };
        write!(f, "{start:?}{more}")
    }
}

fn seconds(key: &str, value: f64) -> Result<Duration, String> {
    if (0.0..=LONGEST_S).contains(&value) {
        Ok(Duration::from_secs_f64(value))
    } else {
        Err(format!("{key} is {value}, expected 0 to {LONGEST_S} s"))
    }
}
