use std::collections::BTreeMap;
use std::fmt;

use super::judge::Verdict;
use super::plan::{Plan, Subject};

/// The results of the trials.
#[derive(Clone, Debug, Default)]
pub struct KillsReport {
    rows: BTreeMap<(Subject, &'static str), Row>,
    misses: Vec<String>,
    flown: usize,
    identifiers: usize,
}

#[derive(Clone, Debug, Default)]
struct Row {
    trials: usize,
    stood: usize,
    after_last_s: Vec<f64>,
    after_fault_s: Vec<f64>,
    again_s: Vec<f64>,
}

impl KillsReport {
    pub(super) fn add(&mut self, plan: &Plan, verdict: Verdict) {
        self.flown += 1;
        self.identifiers += verdict.identifiers;
        let row = self.rows.entry((plan.subject, plan.act.kind())).or_default();
        row.trials += 1;
        row.stood += usize::from(verdict.stood);
        row.after_last_s.extend(verdict.after_last_s);
        row.after_fault_s.extend(verdict.after_fault_s);
        row.again_s.extend(verdict.again_s);
        for miss in verdict.misses {
            self.misses.push(format!("{plan}: {miss}"));
        }
    }

    pub(super) fn add_failure(&mut self, plan: &Plan, why: Option<&String>) {
        let why = why.map_or("it panicked", String::as_str);
        self.misses.push(format!("{plan}: could not be flown: {why}"));
    }

    /// Everything that is not as required.
    #[must_use]
    pub fn faults(&self) -> Vec<String> {
        self.misses.clone()
    }

    /// The number of trials that were flown to their end.
    #[must_use]
    pub const fn flown(&self) -> usize {
        self.flown
    }

    /// The number of trials in which a lease was active when the fault began.
    #[must_use]
    pub fn stood(&self) -> usize {
        self.rows.values().map(|row| row.stood).sum()
    }

    /// The number of identifiers that were used.
    #[must_use]
    pub const fn identifiers(&self) -> usize {
        self.identifiers
    }

    /// The measurements for a subject in all its trials.
    fn all(&self, subject: Subject, of: fn(&Row) -> &Vec<f64>) -> Vec<f64> {
        let rows = self.rows.iter().filter(|((row, _), _)| *row == subject);
        rows.flat_map(|(_, row)| of(row).iter().copied()).collect()
    }
}

/// The minimum, and the 50th, 90th and 99th percentile, and the maximum.
fn spread(mut values: Vec<f64>) -> String {
    values.sort_by(f64::total_cmp);
    let Some(last) = values.len().checked_sub(1) else {
        return format!("{:>36}", "-");
    };
    let at = |share: f64| {
        values
            .get((last as f64 * share).round() as usize)
            .copied()
            .unwrap_or(f64::NAN)
    };
    let figures = [at(0.0), at(0.5), at(0.9), at(0.99), at(1.0)];
    figures.iter().map(|value| format!(" {value:>6.3}")).collect::<String>() + " "
}

impl fmt::Display for KillsReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{} trials; seconds by the vehicle's clock: min p50 p90 p99 max",
            self.flown
        )?;
        writeln!(
            f,
            "{:<8}{:<18}{:>6}{:>6}  {:<36}  {:<36}  {:<36}",
            "", "", "trials", "ended", "last received -> end", "fault -> end", "back -> steers again"
        )?;
        for ((subject, kind), row) in &self.rows {
            let ended = row.after_last_s.len();
            writeln!(
                f,
                "{:<8}{:<18}{:>6}{:>6}  {}  {}  {}",
                subject.to_string(),
                kind,
                row.trials,
                ended,
                spread(row.after_last_s.clone()),
                spread(row.after_fault_s.clone()),
                spread(row.again_s.clone())
            )?;
        }
        for subject in [Subject::Modify, Subject::Station] {
            writeln!(
                f,
                "{:<8}{:<30}  {}  {}  {}",
                subject.to_string(),
                "all",
                spread(self.all(subject, |row| &row.after_last_s)),
                spread(self.all(subject, |row| &row.after_fault_s)),
                spread(self.all(subject, |row| &row.again_s))
            )?;
        }
        write!(f, "{} identifiers used, {} misses", self.identifiers, self.misses.len())
    }
}
