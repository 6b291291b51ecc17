use std::collections::BTreeMap;
use std::fmt;

use backseat_core::RequestCounts;
use backseat_oracle::{Statistics, Violation};
use serde::Serialize;

use crate::control::ControlTimes;

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
    /// Why requests were rejected, one example of each reason with how often it came. The last line counts those that core
    /// only counted, because a plugin's requests were over its rate.
    pub rejections: Vec<String>,
    /// When the runtime had control, and why not.
    pub control: ControlTimes,
    /// How often each plugin failed, by its name in the mission; plugins that did not fail are left out.
    pub plugin_failures: BTreeMap<String, u64>,
    /// How each of them failed first.
    pub plugin_first_failures: BTreeMap<String, FirstFailure>,
    /// When each plugin was quarantined that was, seconds since the start of the run.
    pub plugin_quarantines: BTreeMap<String, f64>,
    /// What the oracle found.
    pub violations: Vec<Violation>,
    /// How much the oracle saw, which shows whether a run without violations tested anything.
    pub seen: Statistics,
    /// What the mission's expectations measured, by name.
    pub measures: BTreeMap<&'static str, f64>,
    /// The last value of each measure that plugins published, by `PLUGIN.NAME`.
    pub published: BTreeMap<String, Published>,
    /// Expectations that did not hold, in words.
    pub unmet: Vec<String>,
    /// The digest of the link.
    pub digest: String,
}

/// How the measures of targets on the seabed begin.
const CONTACTS: &str = "contacts_";

/// How a plugin failed first.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FirstFailure {
    /// Seconds since the start of the run.
    pub at_s: f64,
    /// The fault, in a line.
    pub text: String,
}

/// What a plugin published last under a name.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Published {
    /// Finite.
    pub value: f64,
    /// As the plugin gave it; may be empty.
    pub unit: String,
}

impl fmt::Display for Published {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.3}", self.value)?;
        if !self.unit.is_empty() {
            write!(f, " {}", self.unit)?;
        }
        Ok(())
    }
}

impl Report {
    /// What was measured, for people: `contour rms 1.0 m`, or `plume.maximum 14.250 degC` of a plugin.
    pub fn measured(&self) -> impl Iterator<Item = String> + '_ {
        let measures = self.measures.iter().filter(|(name, _)| !name.starts_with(CONTACTS));
        let measures = measures.map(|(name, value)| {
            let (what, unit) = name.rsplit_once('_').unwrap_or((name, ""));
            format!("{} {value:.1} {unit}", what.replace('_', " "))
        });
        let published = self.published.iter().map(|(name, last)| format!("{name} {last}"));
        self.contacts().into_iter().chain(measures).chain(published)
    }

    /// What came of the targets on the seabed, if the mission expects a plugin to find them.
    fn contacts(&self) -> Option<String> {
        let of = |name: &str| self.measures.get(format!("{CONTACTS}{name}").as_str());
        let mut text = format!(
            "targets: {} of {} circled; circles: {}, {} of them around no target",
            of("found")?,
            of("targets")?,
            of("circles")?,
            of("false")?
        );
        if let Some(aspects) = of("aspects") {
            text.push_str(&format!("; a target was seen from {aspects} of 8 sides (median)"));
        }
        if let Some(error_m) = of("error_m") {
            text.push_str(&format!("; its circle is {error_m:.1} m off (median)"));
        }
        if let Some(way_m) = of("way_m") {
            text.push_str(&format!("; way {:.1} km", way_m / 1000.0));
        }
        Some(text)
    }

    /// Whether every expectation held.
    #[must_use]
    pub fn passed(&self) -> bool {
        self.unmet.is_empty()
    }
}
/// How often each reason came, and how many more of all that were rejected have none here.
pub(crate) fn rejections<'a>(reasons: impl Iterator<Item = &'a (u64, String)>, rejected: u64) -> Vec<String> {
    let mut told = 0;
    let mut lines: Vec<String> = reasons
        .map(|(count, reason)| {
            told += count;
            format!("{count} x {reason}")
        })
        .collect();
    let untold = rejected.saturating_sub(told);
    if untold > 0 {
        lines.push(format!(
            "{untold} x without being told one by one: over a plugin's rate, or for one more reason than these"
        ));
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_counts_of_the_reasons_add_up_to_all_rejections() {
        let reasons = [(2, "too deep".to_owned()), (1, "no control".to_owned())];
        let all = rejections(reasons.iter(), 3);
        assert_eq!(all, ["2 x too deep", "1 x no control"]);
        let more = rejections(reasons.iter(), 10);
        assert!(more.len() == 3 && more[2].starts_with("7 x "), "{more:?}");
    }
}
