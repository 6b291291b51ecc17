use std::fs;
use std::net::TcpListener;
use std::path::PathBuf;
use std::time::Duration;

use crate::clock::eventually;
use crate::mission::Mission;
use crate::process::Process;
use crate::program::Backseat;

const STARTS_WITHIN: Duration = Duration::from_secs(30);

/// The direction of a line of the vehicle's log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// A sentence that the vehicle received.
    Received,
    /// A sentence that the vehicle sent.
    Sent,
    /// An event of the vehicle.
    Event,
}

/// A line of the vehicle's log.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// The vehicle's clock, seconds since its start.
    pub at_s: f64,
    /// The direction.
    pub way: Way,
    /// The client's number, from 1; 0 for events.
    pub client: u32,
    /// The sentence or the event.
    pub text: String,
}

impl Line {
    fn parse(line: &str) -> Option<Self> {
        let (at, rest) = line.split_once(' ')?;
        let at_s = at.parse().ok()?;
        if let Some(text) = rest.strip_prefix("-- ") {
            return Some(Self {
                at_s,
                way: Way::Event,
                client: 0,
                text: text.to_owned(),
            });
        }
        let (mark, rest) = rest.split_once(" client ")?;
        let (client, text) = rest.split_once(' ')?;
        let way = match mark {
            "<" => Way::Received,
            ">" => Way::Sent,
            _ => return None,
        };
        Some(Self {
            at_s,
            way,
            client: client.parse().ok()?,
            text: text.to_owned(),
        })
    }

    /// Whether it is a sentence that the vehicle received, of this name.
    #[must_use]
    pub fn is_received(&self, name: &str) -> bool {
        self.way == Way::Received && self.name() == name
    }

    /// The sentence's name, without the dollar sign.
    #[must_use]
    pub fn name(&self) -> &str {
        self.field(0).trim_start_matches('$')
    }

    /// A field of the sentence; the name is field 0.
    #[must_use]
    pub fn field(&self, index: usize) -> &str {
        let body = self.text.split('*').next().unwrap_or("");
        body.split(',').nth(index).unwrap_or("")
    }
}

/// The mock vehicle as a separate program in real time, with its log.
#[derive(Debug)]
pub struct Vehicle {
    /// The program.
    pub process: Process,
    /// The address on which it listens.
    pub address: String,
    log: PathBuf,
}

impl Vehicle {
    /// Starts it on a free port.
    #[must_use]
    pub fn start(mission: &Mission) -> Self {
        Self::start_at(mission, "127.0.0.1:0")
    }

    /// Starts it on this address.
    #[must_use]
    pub fn start_at(mission: &Mission, address: &str) -> Self {
        Self::start_with(mission, address, &[])
    }

    /// Starts it on a free port of a very busy machine.
    #[must_use]
    pub fn start_within(mission: &Mission, within: Duration) -> Self {
        Self::begin(mission, "127.0.0.1:0", &[], within, Backseat::new())
    }

    /// Starts it on a free port with these options, and with an operator: [`Process::types`].
    #[must_use]
    pub fn start_typed(mission: &Mission, flags: &[&str]) -> Self {
        Self::begin(mission, "127.0.0.1:0", flags, STARTS_WITHIN, Backseat::new().typed())
    }

    /// Starts it on this address with these options.
    #[must_use]
    pub fn start_with(mission: &Mission, address: &str, flags: &[&str]) -> Self {
        Self::begin(mission, address, flags, STARTS_WITHIN, Backseat::new())
    }

    fn begin(mission: &Mission, address: &str, flags: &[&str], within: Duration, program: Backseat) -> Self {
        let count = fs::read_dir(mission.beside("")).map_or(0, Iterator::count);
        let log = mission.beside(&format!("vehicle-{count}.log"));
        let process = program
            .args(["mvc", "--listen", address, "--log"])
            .arg(&log)
            .args(flags.iter().copied())
            .mission(mission)
            .spawn();
        let line = process.says("listening on ", within);
        let address = line.rsplit(' ').next().unwrap_or("").trim().to_owned();
        Self { process, address, log }
    }

    /// Its log so far.
    ///
    /// # Panics
    ///
    /// If a line is not in the format of the log.
    #[must_use]
    pub fn lines(&self) -> Vec<Line> {
        let text = self.log_text();
        // The last line may be half written.
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        whole
            .lines()
            .map(|line| Line::parse(line).unwrap_or_else(|| panic!("no line of a log: `{line}`")))
            .collect()
    }

    /// The text of its log so far.
    #[must_use]
    pub fn log_text(&self) -> String {
        fs::read_to_string(&self.log).unwrap_or_default()
    }

    /// Waits for a line and returns it.
    ///
    /// # Panics
    ///
    /// If it does not appear. The message has the log without navigation.
    pub fn sees(&self, what: &str, within: Duration, is: impl Fn(&Line) -> bool) -> Line {
        eventually(
            within,
            || self.lines().into_iter().find(&is),
            || format!("the vehicle has not seen {what}\n{}", self.story()),
        )
    }

    /// Waits for this many sentences of a name, and returns the last.
    ///
    /// # Panics
    ///
    /// If it does not receive them.
    pub fn receives(&self, name: &str, count: usize, within: Duration) -> Line {
        eventually(
            within,
            || self.received(name).into_iter().nth(count - 1),
            || format!("the vehicle has not received {count} {name}\n{}", self.story()),
        )
    }

    /// All sentences of a name that it has received.
    #[must_use]
    pub fn received(&self, name: &str) -> Vec<Line> {
        self.lines().into_iter().filter(|line| line.is_received(name)).collect()
    }

    /// The log without what is repeated ten times a second, for people.
    #[must_use]
    pub fn story(&self) -> String {
        let lines = self.lines();
        let told = lines
            .iter()
            .filter(|line| !["BFNVG", "BFNVR", "BFCTD"].contains(&line.name()));
        let told: Vec<String> = told
            .map(|line| format!("{:.3} {:?} {} {}", line.at_s, line.way, line.client, line.text))
            .collect();
        told.join("\n")
    }
}

/// An address on which nothing listens. No other test can take its port, because all others listen on 127.0.0.1: a
/// runtime that is to find nobody must not find the vehicle of the test beside it.
///
/// # Panics
///
/// If the machine has no free port.
#[must_use]
pub fn free_address() -> String {
    let listener = TcpListener::bind("127.0.0.77:0").expect("the machine has a free port");
    listener.local_addr().expect("what is bound has an address").to_string()
}
