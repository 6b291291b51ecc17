//! What the operator of the mock types while it runs.

use core::fmt::Write as _;

use super::{ControlOrder, Order};
use crate::file::{FaultEntry, MessageEntry, OrderEntry};

/// The commands, with what follows them and what they do.
const COMMANDS: [(&str, &str, &str); 10] = [
    (
        "fault",
        "KIND KEY=VALUE...",
        "begin a fault now, as in `fault stall for_s=10` or `fault kind=acks_late for_s=60 delay_s=2 command=RMB`",
    ),
    (
        "control",
        "take|give|plan",
        "take control from the payload, give it control while the mission runs, or follow the plan again",
    ),
    (
        "top",
        "TRANSPORT TEXT",
        "send BFTOP to every client by ethernet, wifi, rf-modem or acoustic-modem, as in `top acoustic-modem come home`",
    ),
    (
        "load",
        "NAME",
        "load the dive with this name (`dive.file` of world.toml)",
    ),
    ("start", "", "start the dive that is ready"),
    ("end", "", "end the dive that runs, as successful"),
    ("abort", "", "abort the dive that runs, or take back one that is ready"),
    (
        "shutdown",
        "",
        "send BFSHT, and switch the payload's power off a minute later",
    ),
    ("status", "", "show what the vehicle does, and where it is"),
    ("help", "", "show these lines"),
];

/// A line that the operator of the mock has typed.
#[derive(Clone, Debug, PartialEq)]
pub enum OperatorLine {
    /// The vehicle shall do this: [`crate::Mvc::order`].
    Order(Order),
    /// Show the state of the vehicle.
    Status,
    /// Show what can be typed.
    Help,
}

impl OperatorLine {
    /// Reads a line. An empty line, and one that begins with `#`, is no command: `None`.
    ///
    /// # Errors
    /// What is wrong and what was expected, in one line.
    ///
    /// ```
    /// use backseat_mvc::{ControlOrder, OperatorLine, Order};
    /// let line = OperatorLine::parse("control take")?;
    /// assert_eq!(line, Some(OperatorLine::Order(Order::Control(ControlOrder::Take))));
    /// # Ok::<(), String>(())
    /// ```
    pub fn parse(line: &str) -> Result<Option<Self>, String> {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            return Ok(None);
        }
        let (command, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim_start();
        let alone = |parsed: Self| {
            if rest.is_empty() {
                Ok(parsed)
            } else {
                Err(format!("`{command}` is a command alone, without `{}`", clipped(rest)))
            }
        };
        let parsed = match command {
            "fault" => Self::Order(fault(rest)?),
            "control" => Self::Order(Order::Control(control(rest)?)),
            "top" => Self::Order(topside(rest)?),
            "load" => Self::Order(OrderEntry::Load(rest.to_owned()).order()?),
            "start" => alone(Self::Order(Order::Start))?,
            "end" => alone(Self::Order(Order::End))?,
            "abort" => alone(Self::Order(Order::Abort))?,
            "shutdown" => alone(Self::Order(Order::Shutdown))?,
            "status" => alone(Self::Status)?,
            "help" => alone(Self::Help)?,
            other => {
                let known: Vec<String> = COMMANDS.iter().map(|(name, ..)| format!("`{name}`")).collect();
                return Err(format!(
                    "unknown command `{}`, expected one of {}",
                    clipped(other),
                    known.join(", ")
                ));
            }
        };
        Ok(Some(parsed))
    }

    /// What can be typed, a line for each command.
    #[must_use]
    pub fn help() -> Vec<String> {
        let usage = |(name, rest, _): &(&str, &str, &str)| format!("{name} {rest}").trim_end().to_owned();
        let width = COMMANDS.iter().map(|command| usage(command).len()).max().unwrap_or(0);
        COMMANDS
            .iter()
            .map(|command| format!("{:width$}  {}", usage(command), command.2))
            .collect()
    }
}

/// `stall for_s=10`, or with `kind=stall`: the keys of a fault.
fn fault(words: &str) -> Result<Order, String> {
    let mut text = String::new();
    for (index, word) in words.split_whitespace().enumerate() {
        let (key, value) = match word.split_once('=') {
            Some(pair) => pair,
            None if index == 0 => ("kind", word),
            None => {
                return Err(format!(
                    "expected KEY=VALUE, such as for_s=10, and not `{}`",
                    clipped(word)
                ));
            }
        };
        let is_key = !key.is_empty() && key.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
        if !is_key {
            return Err(format!(
                "expected KEY=VALUE, such as for_s=10, and not `{}`",
                clipped(word)
            ));
        }
        // Writing to a string cannot fail.
        let _written = writeln!(text, "{key} = {}", value_of(value));
    }
    let entry: FaultEntry = toml::from_str(&text).map_err(|error| {
        let message = error.message().split_whitespace().collect::<Vec<_>>().join(" ");
        format!("fault: {message}")
    })?;
    OrderEntry::Fault(Box::new(entry)).order()
}

/// A value as TOML: a number or a boolean as it is, everything else as a text.
fn value_of(value: &str) -> toml::Value {
    let value = value.trim_matches('"');
    if let Ok(whole) = value.parse::<i64>() {
        return toml::Value::Integer(whole);
    }
    if let Ok(number) = value.parse::<f64>() {
        return toml::Value::Float(number);
    }
    match value {
        "true" => toml::Value::Boolean(true),
        "false" => toml::Value::Boolean(false),
        text => toml::Value::String(text.to_owned()),
    }
}

fn control(word: &str) -> Result<ControlOrder, String> {
    match word {
        "take" => Ok(ControlOrder::Take),
        "give" => Ok(ControlOrder::Give),
        "plan" => Ok(ControlOrder::Plan),
        "" => Err("control: expected `take`, `give` or `plan` after it".to_owned()),
        other => Err(format!(
            "control: expected `take`, `give` or `plan`, and not `{}`",
            clipped(other)
        )),
    }
}

fn topside(rest: &str) -> Result<Order, String> {
    let (transport, text) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
    let mut table = toml::Table::new();
    table.insert("transport".to_owned(), transport.into());
    table.insert("text".to_owned(), text.trim_start().into());
    let entry: MessageEntry = table.try_into().map_err(|_| {
        format!(
            "top: expected `ethernet`, `wifi`, `rf-modem` or `acoustic-modem` and a text, and not `{}`",
            clipped(rest)
        )
    })?;
    OrderEntry::Topside(entry)
        .order()
        .map_err(|error| format!("top: {error}"))
}

/// The start of what was typed: a terminal shows nothing that is not printable, and no line of many thousands of
/// characters.
fn clipped(text: &str) -> String {
    let printable = |character: char| if character.is_control() { '?' } else { character };
    let mut start: String = text.chars().take(40).map(printable).collect();
    if start.len() < text.len() {
        start.push_str("...");
    }
    start
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::faults::FaultKind;

    fn order(line: &str) -> Order {
        match OperatorLine::parse(line) {
            Ok(Some(OperatorLine::Order(order))) => order,
            other => panic!("{line}: {other:?}"),
        }
    }

    fn wrong(line: &str) -> String {
        OperatorLine::parse(line).expect_err("the line is wrong")
    }

    #[test]
    fn what_can_be_typed() {
        let Order::Fault(fault) = order("  fault kind=stall for_s=10 ") else {
            panic!("no fault")
        };
        assert_eq!((order("fault stall for_s=10")), Order::Fault(fault.clone()));
        assert!(fault.lasts.as_secs() == 10 && matches!(fault.kind, FaultKind::Link(_)));
        assert!(matches!(
            order("fault acks_negative for_s=2.5 command=BPRMB status=0 done=true"),
            Order::Fault(_)
        ));
        assert_eq!(order("control give"), Order::Control(ControlOrder::Give));
        let Order::Topside { text, .. } = order("top acoustic-modem come  home") else {
            panic!("no message")
        };
        assert_eq!(text.as_str(), "come  home");
        assert_eq!(OperatorLine::parse("status"), Ok(Some(OperatorLine::Status)));
        for nothing in ["", "   ", "# a remark"] {
            assert_eq!(OperatorLine::parse(nothing), Ok(None));
        }
    }

    #[test]
    fn what_is_wrong_is_said_in_one_line() {
        for (line, says) in [
            (
                "fautl stall",
                "unknown command `fautl`, expected one of `fault`, `control`",
            ),
            ("fault", "missing field `kind`"),
            ("fault stal for_s=1", "unknown variant `stal`"),
            ("fault stall", "needs `for_s`"),
            ("fault stall fors=1", "unknown field `fors`"),
            ("fault stall for_s=ten", "expected f64"),
            ("fault stall for_s=-1", "for_s is -1, expected 0 to"),
            ("fault stall for_s=1 at_s=5", "no `at_s` here"),
            (
                "fault stall for_s=1 now",
                "expected KEY=VALUE, such as for_s=10, and not `now`",
            ),
            ("fault stall for_s=1 for_s=2", "duplicate key"),
            ("fault stall a.b=2", "expected KEY=VALUE"),
            ("control", "`take`, `give` or `plan` after it"),
            ("control tkae", "and not `tkae`"),
            ("top pigeon hello", "`ethernet`, `wifi`, `rf-modem` or `acoustic-modem`"),
            ("top", "`acoustic-modem` and a text"),
            ("top wifi", "text is \"\", expected 1 to 200"),
            ("top wifi a,b", "without comma"),
            ("load", "load is \"\", expected 1 to 200"),
            ("abort now", "`abort` is a command alone, without `now`"),
            ("\u{1b}[2J", "unknown command `?[2J`"),
        ] {
            let error = wrong(line);
            assert!(error.contains(says) && !error.contains('\n'), "{line}: {error}");
            assert!(!error.contains('\u{1b}'), "{error:?}");
        }
        assert!(wrong(&"x".repeat(10_000)).len() < 300);
    }

    #[test]
    fn the_help_has_every_command_in_columns() {
        let help = OperatorLine::help();
        for (line, (name, ..)) in help.iter().zip(COMMANDS) {
            assert!(line.starts_with(name), "{line}");
        }
    }
}
