//! `backseat log report`: what a dive came to, on one page.

mod page;

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use backseat_fence::Rfc3339;
use backseat_recorder::{Log, LoggedInput, Record};
use backseat_spi::{Sentence, ToVehicle};
use clap::Args;
use serde::Serialize;
use serde_json::Value;

use super::files::each;
use super::show::{named, plugins};
use super::{read_log, whole};
use crate::output::say;

#[derive(Debug, Args)]
pub(crate) struct LogReport {
    /// The logs, written by `run`, `fly` or `sim --log`
    #[arg(value_name = "DIVE.mcap", required = true)]
    files: Vec<PathBuf>,
    /// Write the page of one log as HTML into this file; it needs no network
    #[arg(long, value_name = "FILE.html")]
    html: Option<PathBuf>,
    /// Print one JSON object for each log on standard output and nothing else
    #[arg(long, conflicts_with = "html")]
    json: bool,
}

/// What a dive came to.
#[derive(Debug, Default, Serialize)]
struct Report {
    log: String,
    mission: String,
    version: String,
    seed: Option<u64>,
    began: String,
    seconds: f64,
    complete: bool,
    /// Records that the disk was too slow for.
    missing: u64,
    /// How long the runtime had control, seconds.
    control_s: f64,
    /// Why it lost control, in the order in which that happened first.
    control_lost: Vec<Lost>,
    /// Since when it had no control at the end; 0 if it never had. `None` if it had control until the end.
    without_control_from_s: Option<f64>,
    /// Why it has no control at the end, as it told the vehicle (BPSTS).
    without_control_because: Option<String>,
    /// What was asked for, by owner.
    asked: BTreeMap<String, Asked>,
    /// What was refused, the most frequent first.
    refused: Vec<Refused>,
    /// Inserts that the vehicle began.
    flown: Vec<Flown>,
    /// Leases that ended, by owner and reason.
    leases: Vec<Lease>,
    /// What the operator did.
    operator: Vec<Happened>,
    /// What went wrong, or was noted about safety: failures of plugins, recovery, navigation, links, late wake-ups.
    troubles: Vec<Happened>,
    /// How many more there were than `troubles` lists.
    troubles_left_out: u64,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct Lost {
    reason: String,
    times: u64,
    first_s: f64,
}

/// How the requests of an owner ended.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
struct Asked {
    all: u64,
    refused: u64,
    failed: u64,
    unanswered: u64,
    /// Cancelled before they began.
    cancelled: u64,
    /// Ended before they were sent: another request took their place, or they were withdrawn.
    unsent: u64,
    /// Were carried out, and are over.
    ended: u64,
    /// Had no end when the log ended.
    open: u64,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct Refused {
    owner: String,
    rule: String,
    cause: String,
    times: u64,
    first_s: f64,
    /// The first one's text.
    text: String,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct Flown {
    request: u64,
    /// Which process of a simulation asked for it: each counts its requests anew.
    #[serde(skip)]
    process: u64,
    owner: String,
    kind: String,
    from_s: f64,
    /// `None` if it had not ended when the log ended.
    until_s: Option<f64>,
    /// How it ended.
    end: String,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct Lease {
    owner: String,
    reason: String,
    times: u64,
    first_s: f64,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct Happened {
    at_s: f64,
    text: String,
}

pub(super) fn report(arguments: &LogReport) -> Result<bool> {
    if let (Some(path), true) = (&arguments.html, arguments.files.len() > 1) {
        bail!("--html {}: a page is of one log", path.display());
    }
    each(&arguments.files, |file| {
        let log = read_log(file)?;
        whole(file, log.run.part)?;
        let report = Report::of(&file.display().to_string(), &log);
        if arguments.json {
            say!("{}", serde_json::to_string(&report)?);
            return Ok(true);
        }
        for line in report.lines() {
            say!("{line}");
        }
        if let Some(path) = &arguments.html {
            std::fs::write(path, page::page(&report)).with_context(|| path.display().to_string())?;
            say!("page: {}", path.display());
        }
        Ok(true)
    })
}

/// The text of the last BPSTS that was sent: while there is no control, it is why (SPI 7.2).
fn status(bytes: &[u8]) -> Option<String> {
    let text = std::str::from_utf8(bytes).ok()?;
    text.lines().rev().find_map(|line| {
        let sentence = Sentence::parse(line.trim_end()).ok()?;
        let Ok(ToVehicle::PayloadStatus(status)) = ToVehicle::decode(&sentence) else {
            return None;
        };
        // What follows the semicolon is about the sonars.
        let text = status.text.as_str().split(';').next()?.trim();
        (!text.is_empty()).then(|| text.to_owned())
    })
}

fn text(value: &Value, key: &str) -> String {
    value[key].as_str().unwrap_or_default().to_owned()
}

impl Report {
    fn of(name: &str, log: &Log) -> Self {
        let names = plugins(log);
        let mut report = Self {
            log: name.to_owned(),
            mission: log.run.mission.clone(),
            version: log.run.version.clone(),
            seed: log.run.seed,
            began: Rfc3339(log.run.utc_at_start).to_string(),
            seconds: log.entries.last().map_or(0.0, |entry| entry.now.as_secs_f64()),
            complete: log.complete,
            without_control_from_s: Some(0.0),
            without_control_because: None,
            ..Self::default()
        };
        let mut collect = Collect {
            report: &mut report,
            names: &names,
            last: BTreeMap::new(),
            granted: None,
            process: 0,
            swapped_to: BTreeMap::new(),
            last_words: BTreeMap::new(),
        };
        for entry in &log.entries {
            collect.record(entry.now.as_secs_f64(), &entry.record);
        }
        collect.finish();
        report.refused.sort_by_key(|refused| std::cmp::Reverse(refused.times));
        report
    }

    fn lines(&self) -> Vec<String> {
        let seed = self.seed.map_or_else(String::new, |seed| format!(", seed {seed}"));
        let mut lines = vec![
            format!(
                "{}: {}{seed}, {:.1} min from {}, backseat {}",
                self.log,
                self.mission,
                self.seconds / 60.0,
                self.began,
                self.version
            ),
            format!("  the runtime had control for {:.1} min", self.control_s / 60.0),
        ];
        lines.extend(self.control_words().map(|words| format!("  {words}")));
        if !self.complete {
            lines.push("  the log is cut short, or still being written: its last records may be missing".to_owned());
        }
        if self.missing > 0 {
            lines.push(format!("  {} records are missing: the disk was too slow", self.missing));
        }
        let asked = self
            .asked
            .iter()
            .map(|(owner, asked)| format!("{owner}: {}", asked.line()));
        section(&mut lines, "asked for", asked);
        section(&mut lines, "refused", self.refused.iter().map(Refused::line));
        section(&mut lines, "inserts flown", self.flown.iter().map(Flown::line));
        section(&mut lines, "leases that ended", self.leases.iter().map(Lease::line));
        section(&mut lines, "the operator", self.operator.iter().map(Happened::line));
        section(&mut lines, "troubles", self.troubles.iter().map(Happened::line));
        lines.extend(self.left_out().map(|line| format!("  {line}")));
        lines
    }

    /// Why control was lost, and whether it came again.
    fn control_words(&self) -> impl Iterator<Item = String> {
        let because = self.without_control_because.as_ref();
        let because = because.map_or_else(String::new, |because| format!(": {because}"));
        let end = self.without_control_from_s.map(|from_s| match from_s {
            0.0 => format!("no control at any time{because}"),
            _ => format!("no control from {from_s:.1} s to the end{because}"),
        });
        self.control_lost.iter().map(Lost::line).chain(end)
    }

    /// How many troubles are not listed, and where they are.
    fn left_out(&self) -> Option<String> {
        let more = self.troubles_left_out;
        (more > 0).then(|| format!("and {more} more, which `backseat log show` lists"))
    }
}

fn section(lines: &mut Vec<String>, title: &str, rows: impl Iterator<Item = String>) {
    let mut rows = rows.peekable();
    if rows.peek().is_none() {
        lines.push(format!("{title}: nothing"));
        return;
    }
    lines.push(title.to_owned());
    lines.extend(rows.map(|row| format!("  {row}")));
}

impl Lost {
    fn line(&self) -> String {
        let Self { reason, times, first_s } = self;
        format!("control lost {times} x: {reason} (first at {first_s:.1} s)")
    }
}

impl Asked {
    fn line(&self) -> String {
        let Self {
            all,
            refused,
            failed,
            unanswered,
            cancelled,
            unsent,
            ended,
            open,
        } = self;
        let mut line = format!("{all} requests");
        for (count, word) in [
            (refused, "refused"),
            (failed, "failed"),
            (unanswered, "not answered"),
            (cancelled, "cancelled before they began"),
            (unsent, "replaced or withdrawn before they were sent"),
            (ended, "carried out"),
            (open, "open at the end"),
        ] {
            if *count > 0 {
                line.push_str(&format!(", {count} {word}"));
            }
        }
        line
    }
}

impl Refused {
    fn line(&self) -> String {
        let Self {
            owner,
            times,
            first_s,
            text,
            ..
        } = self;
        format!("{owner}: {times} x {text} (first at {first_s:.1} s)")
    }
}

impl Flown {
    fn line(&self) -> String {
        let until = self
            .until_s
            .map_or_else(|| "the end".to_owned(), |until_s| format!("{until_s:.1} s"));
        format!(
            "{} {} of {}: {:.1} s to {until}, {}",
            self.kind, self.request, self.owner, self.from_s, self.end
        )
    }
}

impl Lease {
    fn line(&self) -> String {
        format!(
            "{}: {} x {} (first at {:.1} s)",
            self.owner, self.times, self.reason, self.first_s
        )
    }
}

impl Happened {
    fn line(&self) -> String {
        format!("{:.1} s: {}", self.at_s, self.text)
    }
}

/// A request as it was last told of.
struct Last {
    owner: String,
    state: String,
    /// Has left for the vehicle.
    sent: bool,
}

struct Collect<'a> {
    report: &'a mut Report,
    names: &'a [String],
    /// By number in the ledger, and by process: a log of a simulation can have several.
    last: BTreeMap<(u64, u64), Last>,
    granted: Option<f64>,
    process: u64,
    /// The version that last took each plugin's place, or was to, until it has passed its trial: number and hash, and
    /// whether it is on trial.
    swapped_to: BTreeMap<u64, (String, bool)>,
    /// The newest error that each plugin logged, and when: the first of its step, or a panic.
    last_words: BTreeMap<u64, (f64, String)>,
}

/// How the line begins that Rust writes for a panic, and that the SDK logs.
const PANIC: &str = "panicked at ";
/// What `run` says of a version that has passed its trial.
const PASSED: &str = " has passed its trial of ";
/// At most so many troubles are listed. The rest is counted.
const TROUBLES_MAX: usize = 200;

impl Collect<'_> {
    fn record(&mut self, at_s: f64, record: &Record) {
        match record {
            Record::Request(request) => self.request(at_s, request),
            Record::Control(control) => {
                if control["granted"] == true {
                    self.granted.get_or_insert(at_s);
                    self.report.without_control_from_s = None;
                    self.report.without_control_because = None;
                } else if let Some(since_s) = self.granted.take() {
                    self.report.control_s += at_s - since_s;
                    self.lost(at_s, text(control, "reason"));
                }
            }
            Record::Note(note) => self.note(at_s, note),
            // A new process counts its requests anew.
            Record::Start(_) => self.process += 1,
            Record::Gap { records, .. } => self.report.missing += records,
            Record::Input(LoggedInput::Swap(plugin, version)) => {
                let name = self.name(plugin.0 as u64);
                self.happened(at_s, format!("swap {name} to version {version}"));
                let on_trial = version.trial_steps > 0;
                let version = format!("{} ({})", version.version, version.sha256.get(..12).unwrap_or_default());
                if let Some((before, true)) = self.swapped_to.insert(plugin.0 as u64, (version, on_trial)) {
                    let text = format!("{name}: version {before} was on trial, and the next one comes in its place");
                    self.happened(at_s, text);
                }
            }
            Record::Sent(bytes) if self.granted.is_none() => {
                if let Some(status) = status(bytes) {
                    self.report.without_control_because = Some(status);
                }
            }
            Record::Input(_)
            | Record::Sent(_)
            | Record::Output(_)
            | Record::Navigation(_)
            | Record::Truth(_)
            | Record::Vehicle(_) => {}
        }
    }

    /// The log has why control was lost, and not why it does not come again.
    fn lost(&mut self, at_s: f64, reason: String) {
        self.report.without_control_from_s = Some(at_s);
        match self.report.control_lost.iter_mut().find(|lost| lost.reason == reason) {
            Some(lost) => lost.times += 1,
            None => self.report.control_lost.push(Lost {
                reason,
                times: 1,
                first_s: at_s,
            }),
        }
    }

    fn owner(&self, request: &Value) -> String {
        match (request["plugin"].as_u64(), request["owner"].as_str()) {
            (Some(plugin), _) => self.name(plugin),
            (None, Some(owner)) => owner.to_owned(),
            (None, None) => "?".to_owned(),
        }
    }

    fn name(&self, plugin: u64) -> String {
        let name = usize::try_from(plugin).ok().and_then(|plugin| self.names.get(plugin));
        name.cloned().unwrap_or_else(|| format!("plugin {plugin}"))
    }

    fn request(&mut self, at_s: f64, request: &Value) {
        let (owner, state) = (self.owner(request), text(request, "state"));
        let number = request["request"].as_u64().unwrap_or_default();
        let key = (self.process, number);
        match state.as_str() {
            "rejected" => {
                let why = &request["why"];
                let (rule, cause) = (text(why, "rule"), text(why, "cause"));
                let same =
                    |refused: &&mut Refused| (&refused.owner, &refused.rule, &refused.cause) == (&owner, &rule, &cause);
                match self.report.refused.iter_mut().find(same) {
                    Some(refused) => refused.times += 1,
                    None => self.report.refused.push(Refused {
                        owner: owner.clone(),
                        rule,
                        cause,
                        times: 1,
                        first_s: at_s,
                        text: text(request, "reason"),
                    }),
                }
            }
            "started" => self.report.flown.push(Flown {
                request: number,
                process: self.process,
                owner: owner.clone(),
                kind: text(request, "kind"),
                from_s: at_s,
                until_s: None,
                end: "not over when the log ended".to_owned(),
            }),
            "ended" => {
                let begun = |flown: &&mut Flown| (flown.process, flown.request) == key && flown.until_s.is_none();
                if let Some(flown) = self.report.flown.iter_mut().rev().find(begun) {
                    flown.until_s = Some(at_s);
                    flown.end = text(request, "reason");
                }
            }
            _ => {}
        }
        let left = matches!(state.as_str(), "sent" | "pending" | "accepted" | "started");
        let sent = left || self.last.get(&key).is_some_and(|last| last.sent);
        self.last.insert(key, Last { owner, state, sent });
    }

    fn note(&mut self, at_s: f64, note: &Value) {
        let line = || named(&text(note, "text"), self.names);
        match note["note"].as_str().unwrap_or_default() {
            "lease-ended" => {
                let owner = note["plugin"]
                    .as_u64()
                    .map_or_else(|| "?".to_owned(), |plugin| self.name(plugin));
                let line = line();
                let reason = line
                    .split_once(": ")
                    .map_or(line.as_str(), |(_, reason)| reason)
                    .to_owned();
                // What a zone says has figures that differ; the words before them count.
                let kind = reason.split([':', '(']).next().unwrap_or_default().to_owned();
                let same = |lease: &&mut Lease| lease.owner == owner && lease.reason.starts_with(&kind);
                match self.report.leases.iter_mut().find(same) {
                    Some(lease) => lease.times += 1,
                    None => self.report.leases.push(Lease {
                        owner,
                        reason,
                        times: 1,
                        first_s: at_s,
                    }),
                }
            }
            // A simulation ends itself with the operator's words, and has no operator.
            "operator"
                if self.report.seed.is_some() && self.report.seconds - at_s < 1.0 && line().ends_with(": Stop") => {}
            "operator" | "asked" => {
                let text = line();
                if text.contains(PASSED)
                    && let Some(plugin) = self
                        .names
                        .iter()
                        .position(|name| text.starts_with(&format!("{name}: ")))
                {
                    self.swapped_to.remove(&(plugin as u64));
                }
                self.happened(at_s, text);
            }
            "text" => {
                if let Some((count, owner)) = over_rate(&line()) {
                    self.refused_untold(owner, count);
                }
            }
            "plugin-log" => {
                let line = line();
                if let (Some(plugin), Some((_, said))) = (note["plugin"].as_u64(), line.split_once(" says: "))
                    && note["line"]["level"] == "error"
                {
                    let is_first = self
                        .last_words
                        .get(&plugin)
                        .is_none_or(|(then_s, _)| then_s.total_cmp(&at_s).is_ne());
                    if is_first || said.starts_with(PANIC) {
                        let said = said.lines().collect::<Vec<_>>().join(" ");
                        self.last_words.insert(plugin, (at_s, said));
                    }
                }
            }
            "plugin-failed" | "plugin-not-swapped" | "recovery" | "navigation" | "late" | "link-down" => {
                let text = match (note["note"].as_str(), note["plugin"].as_u64()) {
                    // Its text is the reason alone.
                    (Some("plugin-not-swapped"), Some(plugin)) => {
                        format!(
                            "{}: not swapped, the version before goes on: {}",
                            self.name(plugin),
                            line()
                        )
                    }
                    _ => line(),
                };
                let came_to = match note["note"].as_str() {
                    Some("plugin-failed") if note["fault"]["kind"] == "trial" => {
                        Some("did not pass its trial, and the version before is back")
                    }
                    Some("plugin-not-swapped") => Some("could not take over, and the version before goes on"),
                    _ => None,
                };
                if let (Some(came_to), Some(plugin)) = (came_to, note["plugin"].as_u64())
                    && let Some((version, _)) = self.swapped_to.remove(&plugin)
                {
                    let name = self.name(plugin);
                    self.happened(at_s, format!("{name}: version {version} {came_to}"));
                }
                let text = self.with_last_words(at_s, note, text);
                if self.report.troubles.len() < TROUBLES_MAX {
                    self.report.troubles.push(Happened { at_s, text });
                } else {
                    self.report.troubles_left_out += 1;
                }
            }
            _ => {}
        }
    }

    /// A trap has no words of its own. The panic or exception that led to it was logged in the same step, with the place in the
    /// source.
    fn with_last_words(&self, at_s: f64, note: &Value, text: String) -> String {
        let fault = note["fault"]["text"]
            .as_str()
            .filter(|fault| note["note"] == "plugin-failed" && note["fault"]["kind"] == "trap" && !fault.is_empty());
        let said = note["plugin"].as_u64().and_then(|plugin| self.last_words.get(&plugin));
        let said = said.filter(|(then_s, _)| then_s.total_cmp(&at_s).is_eq());
        match (fault, said) {
            (Some(fault), Some((_, panic))) if panic.starts_with(PANIC) => text.replace(fault, panic),
            (Some(fault), Some((_, line))) => text.replace(fault, &format!("{fault}; it logged: {line}")),
            _ => text,
        }
    }

    fn happened(&mut self, at_s: f64, text: String) {
        self.report.operator.push(Happened { at_s, text });
    }

    /// Core has rejected so many more requests for the plugin's rate, without a record of each.
    fn refused_untold(&mut self, owner: &str, count: u64) {
        let asked = self.report.asked.entry(owner.to_owned()).or_default();
        asked.all += count;
        asked.refused += count;
        let of_rate = |refused: &&mut Refused| (refused.owner.as_str(), refused.cause.as_str()) == (owner, "requests");
        if let Some(refused) = self.report.refused.iter_mut().find(of_rate) {
            refused.times += count;
        }
    }

    fn finish(mut self) {
        if let Some(since_s) = self.granted.take() {
            self.report.control_s += self.report.seconds - since_s;
        }
        for Last { owner, state, sent } in std::mem::take(&mut self.last).into_values() {
            let asked = self.report.asked.entry(owner).or_default();
            asked.all += 1;
            let count = match state.as_str() {
                "rejected" => &mut asked.refused,
                "failed" => &mut asked.failed,
                "timed-out" => &mut asked.unanswered,
                "cancelled" => &mut asked.cancelled,
                "ended" if !sent => &mut asked.unsent,
                "ended" => &mut asked.ended,
                _ => &mut asked.open,
            };
            *count += 1;
        }
    }
}

/// What core says once a second of the requests over a plugin's rate that it does not tell one by one: how many, and whose.
fn over_rate(text: &str) -> Option<(u64, &str)> {
    let (count, rest) = text.split_once(" more requests of ")?;
    let owner = rest.strip_suffix(" were over its rate and rejected")?;
    Some((count.parse().ok()?, owner))
}
