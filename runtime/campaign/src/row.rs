use std::collections::BTreeMap;

use backseat_oracle::Margin;
use backseat_sim::Report;
use serde::{Deserialize, Serialize};

/// A value of a row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Cell {
    Boolean(bool),
    Integer(i64),
    /// An unsigned number, such as a seed.
    Natural(u64),
    /// Not NaN.
    Number(f64),
    Text(String),
}

/// What a run gave: its values by column. What follows from its number, such as its seed, is not in it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Row {
    pub(crate) cells: Vec<(String, Cell)>,
}

/// The outcome of a run that could not be flown.
pub(crate) const NOT_FLOWN: &str = "not flown";

/// The columns that every row may have, in the order in which `runs.parquet` has them, behind those of the run's number
/// and parameters and before those of measures.
pub(crate) const COLUMNS: [&str; 29] = [
    "outcome",
    "passed",
    "error",
    "unmet",
    "violations",
    "rules_broken",
    "sim_s",
    "faults",
    "control_s",
    "lease_s",
    "leases",
    "requests_proposed",
    "requests_rejected",
    "requests_replaced",
    "requests_withdrawn",
    "requests_sent",
    "requests_accepted",
    "requests_failed",
    "requests_unanswered",
    "requests_open",
    "modifies",
    "inserts_sent",
    "inserts_accepted",
    "inserts_begun",
    "connections",
    "plugin_failures",
    "first_failure",
    "digest",
    "replay",
];

/// What the columns of margins of safety begin with: how near the run came to what a safety requirement forbids, in the
/// unit of the margin, metres or seconds.
pub(crate) const MARGIN: &str = "margin.";
/// What the columns of plugins' published measures begin with.
pub(crate) const PUBLISHED: &str = "published.";

impl Row {
    /// The names of what was measured.
    pub(crate) fn measures(&self) -> impl Iterator<Item = &str> {
        let names = self.cells.iter().map(|(name, _)| name.as_str());
        names.filter(|name| !COLUMNS.contains(name) && !name.starts_with(MARGIN))
    }

    /// The row of a run that was flown.
    pub(crate) fn of(report: &Report) -> Self {
        let mut row = Self::default();
        let seen = &report.seen;
        row.text("outcome", report.outcome);
        row.put("passed", Cell::Boolean(report.passed()));
        if !report.unmet.is_empty() {
            row.text("unmet", &report.unmet.join("; "));
        }
        row.count("violations", seen.violations);
        if !report.violations.is_empty() {
            let mut rules: BTreeMap<&str, u64> = BTreeMap::new();
            for violation in &report.violations {
                *rules.entry(violation.rule).or_default() += 1;
            }
            let rules: Vec<&str> = rules.into_keys().collect();
            row.text("rules_broken", &rules.join(", "));
        }
        row.number("sim_s", report.sim_seconds);
        row.count("faults", report.faults);
        row.number("control_s", seen.control_s);
        row.number("lease_s", seen.lease_s);
        row.count("leases", seen.leases);
        let requests = &report.requests;
        for (name, count) in [
            ("requests_proposed", requests.proposed),
            ("requests_rejected", requests.rejected),
            ("requests_replaced", requests.replaced),
            ("requests_withdrawn", requests.withdrawn),
            ("requests_sent", requests.sent),
            ("requests_accepted", requests.accepted),
            ("requests_failed", requests.failed),
            ("requests_unanswered", requests.unanswered),
            ("requests_open", report.requests_open as u64),
            ("modifies", seen.modifies),
            ("inserts_sent", seen.inserts_sent),
            ("inserts_accepted", seen.inserts_accepted),
            ("inserts_begun", seen.inserts_begun),
            ("connections", seen.connections),
            ("plugin_failures", report.plugin_failures.values().sum()),
        ] {
            row.count(name, count);
        }
        let first = report
            .plugin_first_failures
            .iter()
            .min_by(|(_, one), (_, other)| one.at_s.total_cmp(&other.at_s));
        if let Some((plugin, failure)) = first {
            row.text(
                "first_failure",
                &format!("{plugin} at {:.1} s: {}", failure.at_s, failure.text),
            );
        }
        row.text("digest", &report.digest);
        for margin in Margin::ALL {
            if let Some(nearest) = seen.margins.nearest(margin) {
                row.number(&format!("{MARGIN}{}", margin.name()), nearest.value);
            }
        }
        for (name, value) in &report.measures {
            row.number(name, *value);
        }
        for (name, last) in &report.published {
            row.number(&format!("{PUBLISHED}{name}"), last.value);
        }
        row
    }

    /// The row of a run that could not be flown.
    pub(crate) fn not_flown(reason: &str) -> Self {
        let mut row = Self::default();
        row.text("outcome", NOT_FLOWN);
        row.put("passed", Cell::Boolean(false));
        row.text("error", reason);
        row
    }

    pub(crate) fn get(&self, name: &str) -> Option<&Cell> {
        self.cells
            .iter()
            .find(|(column, _)| column == name)
            .map(|(_, cell)| cell)
    }

    /// Whether the run met every expectation.
    pub(crate) fn passed(&self) -> bool {
        self.get("passed") == Some(&Cell::Boolean(true))
    }

    /// Whether the run was flown.
    pub(crate) fn flown(&self) -> bool {
        self.get("error").is_none()
    }

    /// How many violations it has.
    pub(crate) fn violations(&self) -> u64 {
        match self.get("violations") {
            Some(Cell::Integer(count)) => (*count).cast_unsigned(),
            _ => 0,
        }
    }

    fn put(&mut self, name: &str, cell: Cell) {
        self.cells.push((name.to_owned(), cell));
    }

    pub(crate) fn text(&mut self, name: &str, text: &str) {
        self.put(name, Cell::Text(text.to_owned()));
    }

    fn count(&mut self, name: &str, count: u64) {
        self.put(name, Cell::Integer(i64::try_from(count).unwrap_or(i64::MAX)));
    }

    /// A number that is not finite has no cell: readers differ in what they make of it.
    fn number(&mut self, name: &str, value: f64) {
        if value.is_finite() {
            self.put(name, Cell::Number(value));
        }
    }
}
