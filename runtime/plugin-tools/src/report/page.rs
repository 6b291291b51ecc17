//! The report as a page of text.

use std::fmt;

use backseat_core::{FailAction, Grant};

use super::judgement::percent;
use super::{Report, Used};
use crate::component::topic_name;

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.component(f)?;
        self.mission(f)?;
        self.trials(f)?;
        self.requests(f)?;
        self.headroom(f)?;
        self.faults(f)?;
        for objection in &self.objections {
            writeln!(f, "objection: {objection}")?;
        }
        for remark in &self.remarks {
            writeln!(f, "remark: {remark}")?;
        }
        let plugin = &self.mission.plugin;
        let objections = count(self.objections.len(), "objection");
        write!(f, "{objections} to {plugin} with this mission")
    }
}

impl Report {
    fn component(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "component {}", self.file.display())?;
        row(f, "SHA-256", &self.sha256)?;
        row(f, "size", &used_kib(self.size_bytes))?;
        let Used { most, limit } = self.compile_seconds;
        row(
            f,
            "compiled",
            &format!("in {most:.2} s of {limit:.0} s, on this computer"),
        )?;
        row(f, "interface", &listed(&self.interface))?;
        row(
            f,
            "imports",
            &format!("{}; WASI: {}", listed(&self.imports), listed(&self.wasi)),
        )?;
        if let Some(said) = &self.description {
            let topics: Vec<&str> = said.topics.iter().map(|topic| topic_name(*topic)).collect();
            let period_ms = said.step_period.as_secs_f64() * 1000.0;
            row(
                f,
                "it says",
                &format!(
                    "{} {}; it needs the grants: {}",
                    said.name,
                    said.version,
                    names(&self.needs)
                ),
            )?;
            row(
                f,
                "steps",
                &format!("every {period_ms} ms; listens to: {}", listed(&topics)),
            )?;
        }
        Ok(())
    }

    fn mission(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mission = &self.mission;
        writeln!(f, "mission {}", mission.folder.display())?;
        row(f, "SHA-256", &mission.sha256)?;
        row(f, "plugin", &mission.plugin)?;
        row(f, "grants", &names(&mission.grants))?;
        let then = match mission.on_failure {
            FailAction::Yield => "yield: its lease ends, its inserts are flown",
            FailAction::Cancel => "cancel: its lease ends, its waiting inserts are cancelled",
            FailAction::Abort => "abort: as cancel, and the vehicle's mission is aborted",
        };
        row(f, "on failure", then)?;
        for (key, value) in &mission.config {
            row(f, "config", &format!("{key} = {value}"))?;
        }
        Ok(())
    }

    fn trials(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let trials = &self.trials;
        writeln!(f, "trials: {}, with the seeds 1 to {}", trials.flown, trials.flown)?;
        let control_h = trials.control_seconds as f64 / 3600.0;
        let outcomes: Vec<String> = trials
            .outcomes
            .iter()
            .map(|(how, count)| format!("{count} {how}"))
            .collect();
        row(
            f,
            "flown",
            &format!(
                "{:.1} h, {control_h:.1} h of them with control",
                trials.sim_seconds / 3600.0
            ),
        )?;
        row(f, "ended", &listed(&outcomes))?;
        row(
            f,
            "not met",
            &count(trials.unmet.len(), "expectation").replace("no expectation", "none"),
        )
    }

    fn requests(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "requests{}", if self.requests.is_empty() { ": none" } else { "" })?;
        for (kind, tally) in &self.requests {
            let mut line = format!("{} made", tally.made);
            if !tally.ends.is_empty() {
                line.push_str(&format!(", {} sent, {} accepted", tally.sent, tally.accepted));
            }
            row(f, kind, &line)?;
            let mut ends: Vec<_> = tally.ends.iter().collect();
            ends.sort_by(|a, b| b.1.cmp(a.1));
            for (how, count) in ends {
                row(f, "", &format!("{count} x {how}"))?;
            }
            for refused in &tally.refusals {
                row(
                    f,
                    "",
                    &format!("  {} x refused, such as: {}", refused.count, refused.example),
                )?;
            }
        }
        let lacked: Vec<Grant> = self.grants_lacked.keys().copied().collect();
        writeln!(
            f,
            "grants: used: {}; given and not used: {}; asked for and not given: {}",
            names(&self.grants_used),
            names(&self.grants_unused),
            names(&lacked)
        )
    }

    fn headroom(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let headroom = &self.headroom;
        writeln!(f, "the most that it used, in {} steps", headroom.steps)?;
        for (what, used) in [("step", headroom.step_fuel), ("snapshot", headroom.snapshot_fuel)] {
            let Used { most, limit } = used;
            let share = percent(most as f64, limit as f64);
            row(f, what, &format!("{most} of {limit} units of fuel ({share:.1} %)"))?;
        }
        row(f, "memory", &used_kib(headroom.memory_bytes))?;
        let Used { most, limit } = headroom.step_seconds;
        let (longest_ms, mean_ms) = (most * 1000.0, headroom.step_seconds_mean * 1000.0);
        row(
            f,
            "time",
            &format!("{longest_ms:.3} ms for a step, {mean_ms:.3} ms on average, of {limit:.0} s, on this computer"),
        )
    }

    fn faults(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let faults: u64 = self.faults.iter().map(|fault| fault.count).sum();
        let faults = usize::try_from(faults).unwrap_or(usize::MAX);
        let dropped = usize::try_from(self.log_lines_dropped).unwrap_or(usize::MAX);
        writeln!(
            f,
            "{}, {} dropped, {} of the safety rules",
            count(faults, "fault"),
            count(dropped, "log line"),
            count(self.violations.len(), "violation")
        )
    }
}

/// A line with a name and a value.
fn row(f: &mut fmt::Formatter<'_>, name: &str, value: &str) -> fmt::Result {
    writeln!(f, "  {name:<12} {value}")
}

fn used_kib(used: Used<usize>) -> String {
    let kib = |bytes: usize| bytes as f64 / 1024.0;
    let share = percent(used.most as f64, used.limit as f64);
    format!("{:.0} of {:.0} KiB ({share:.1} %)", kib(used.most), kib(used.limit))
}

fn count(count: usize, what: &str) -> String {
    match count {
        0 => format!("no {what}"),
        1 => format!("1 {what}"),
        count => format!("{count} {what}s"),
    }
}

fn names(grants: &[Grant]) -> String {
    let names: Vec<&str> = grants.iter().map(|grant| grant.name()).collect();
    listed(&names)
}

fn listed<T: AsRef<str>>(all: &[T]) -> String {
    if all.is_empty() {
        return "none".to_owned();
    }
    all.iter().map(AsRef::as_ref).collect::<Vec<_>>().join(", ")
}
