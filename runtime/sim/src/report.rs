use backseat_core::RequestCounts;
use backseat_oracle::{Statistics, Violation};
use serde::Serialize;

/// The result of a run.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Report {
    /// The mission's name.
    pub mission: String,
    /// The seed.
    pub seed: u64,
    /// `completed`, `aborted` or `overran` (the run's own end came before the mission's).
    pub outcome: &'static str,
    /// Virtual time from the first event to the last.
    pub sim_seconds: f64,
    /// Real time from the first event to the log's end; the caller's clock.
    pub wall_seconds: f64,
    /// Real time for compiling and starting plugins; the caller's clock.
    pub load_seconds: f64,
    /// How many faults of the run's plan began.
    pub faults: u64,
    /// How many requests reached which state.
    pub requests: RequestCounts,
    /// Requests without an end when the run ended; 0 in a good run.
    pub requests_open: usize,
    /// Why requests were rejected, one example of each reason with how often it came.
    pub rejections: Vec<String>,
    /// How often each plugin failed, by its name in the mission; plugins that did not fail are left out.
    pub plugin_failures: std::collections::BTreeMap<String, u64>,
    /// What the oracle found.
    pub violations: Vec<Violation>,
    /// How much the oracle saw, which shows whether a run without violations tested anything.
    pub seen: Statistics,
    /// What the mission's expectations measured, by name.
    pub measures: std::collections::BTreeMap<&'static str, f64>,
    /// Expectations that did not hold, in words.
    pub unmet: Vec<String>,
    /// The digest of the link.
    pub digest: String,
}

impl Report {
    /// What was measured, for people: `contour rms 1.0 m`. The unit is the last part of the measure's name.
    pub fn measured(&self) -> impl Iterator<Item = String> + '_ {
        self.measures.iter().map(|(name, value)| {
            let (what, unit) = name.rsplit_once('_').unwrap_or((name, ""));
            format!("{} {value:.1} {unit}", what.replace('_', " "))
        })
    }

    /// Whether every expectation held.
    #[must_use]
    pub fn passed(&self) -> bool {
        self.unmet.is_empty()
    }
}
