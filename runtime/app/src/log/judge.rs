//! `backseat log judge`: the oracle's verdict on a run.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use backseat_sim::{Verdict, judge_log};
use clap::Args;
use serde_json::json;

use super::files::each;
use super::{read_log, whole};
use crate::output::say;

#[derive(Debug, Args)]
pub(crate) struct LogJudge {
    /// The logs, written by `run`, `fly` or `sim --log`
    #[arg(value_name = "DIVE.mcap", required = true)]
    pub(crate) files: Vec<PathBuf>,
    /// Also print the rules that were not judged, with the reason
    #[arg(long)]
    pub(crate) all: bool,
    /// Print one JSON object for each log on standard output and nothing else
    #[arg(long)]
    pub(crate) json: bool,
}

pub(super) fn judge(arguments: &LogJudge) -> Result<bool> {
    each(&arguments.files, |file| judge_one(file, arguments))
}

fn judge_one(path: &Path, arguments: &LogJudge) -> Result<bool> {
    let log = read_log(path)?;
    whole(path, log.run.part)?;
    let verdict = judge_log(&log).with_context(|| format!("log {} cannot be judged", path.display()))?;
    if arguments.json {
        let mut report = serde_json::to_value(&verdict)?;
        if let Some(report) = report.as_object_mut() {
            report.insert("log".to_owned(), json!(path.display().to_string()));
            report.insert("passed".to_owned(), json!(verdict.passed()));
        }
        say!("{report}");
    } else {
        print(path, &verdict, arguments.all)?;
    }
    Ok(verdict.passed())
}

fn print(path: &Path, verdict: &Verdict, all: bool) -> Result<()> {
    let seed = verdict.seed.map_or_else(String::new, |seed| format!(", seed {seed}"));
    let cut = if verdict.complete { "" } else { ", cut short" };
    say!(
        "{}: {}{seed}, {:.1} min{cut}",
        path.display(),
        verdict.mission,
        verdict.seconds / 60.0
    );
    for gap in &verdict.gaps {
        say!(
            "  gap: {} records are missing from {:.3} s to {:.3} s; what depends on \
             them is not judged until the log states it again",
            gap.records,
            gap.since_s,
            gap.until_s
        );
    }
    if verdict.standstills > 0 {
        say!(
            "  the process stood still {} times, for over a second: its silence then is not judged",
            verdict.standstills
        );
    }
    let (judged, others): (Vec<_>, Vec<_>) = verdict.rules.iter().partition(|rule| rule.unjudged.is_none());
    say!("  {:3} {:27} {:9} result", "SR", "rule", "looks at");
    for rule in judged.iter().chain(others.iter().filter(|_| all)) {
        let requirement = rule
            .requirement
            .map_or_else(|| "   ".to_owned(), |requirement| format!("{requirement:03}"));
        let fared = match (rule.unjudged, rule.broken) {
            (Some(why), _) => format!("not judged: {why}"),
            (None, 0) if rule.judged == 1 => "held in the one case".to_owned(),
            (None, 0) => format!("held in all {} cases", rule.judged),
            (None, broken) => format!("BROKEN in {broken} of {} cases", rule.judged),
        };
        say!("  {requirement} {:27} {:9} {fared}", rule.rule, rule.side);
    }
    if !all && !others.is_empty() {
        say!(
            "  {} rules had no case or need a simulation: --all shows them",
            others.len()
        );
    }
    for violation in &verdict.broken {
        say!("  {violation}");
        if let Some(sentence) = &violation.sentence {
            say!("    {sentence}");
        }
    }
    match verdict.broken.len() {
        0 => say!("  no rule broke"),
        _ => say!("  a rule broke"),
    }
    Ok(())
}
