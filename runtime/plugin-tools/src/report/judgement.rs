//! What a report objects to, and what it remarks.

use super::{Report, Used};

/// From this share of a limit on, the report remarks how close to it a plugin came, percent.
const CLOSE_PERCENT: f64 = 50.0;
/// How many objections of a kind are listed.
const LISTED_MAX: usize = 5;

impl Report {
    pub(super) fn judge(&mut self) {
        self.objections = self.objections_found();
        self.remarks = self.remarks_found();
    }

    fn objections_found(&self) -> Vec<String> {
        let mut objections = Vec::new();
        for fault in &self.faults {
            objections.push(format!(
                "it failed {} ({}), first with seed {} at {:.1} s: {}",
                times(fault.count),
                fault.kind,
                fault.seed,
                fault.at_s,
                fault.text
            ));
        }
        for (grant, count) in &self.grants_lacked {
            objections.push(format!(
                "it lacks the grant {}: {count} requests were lost for that",
                grant.name()
            ));
        }
        let violations = self.violations.iter();
        list(
            &mut objections,
            "violation",
            violations.map(|fault| format!("seed {}: {}", fault.seed, fault.what)),
        );
        let unmet = self.trials.unmet.iter();
        list(
            &mut objections,
            "expectation not met",
            unmet.map(|fault| format!("seed {}: {}", fault.seed, fault.what)),
        );
        if self.log_lines_dropped > 0 {
            objections.push(format!(
                "{} of its log lines were dropped: it logs too much",
                self.log_lines_dropped
            ));
        }
        objections
    }

    fn remarks_found(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        let headroom = &self.headroom;
        let exact = |value: u64| value as f64;
        let fuel = |used: Used<u64>| percent(exact(used.most), exact(used.limit));
        for (what, share, limit) in [
            ("a step used", fuel(headroom.step_fuel), "its fuel"),
            ("a snapshot used", fuel(headroom.snapshot_fuel), "its fuel"),
            (
                "it used",
                percent(headroom.memory_bytes.most as f64, headroom.memory_bytes.limit as f64),
                "its memory",
            ),
            (
                "a step took",
                percent(headroom.step_seconds.most, headroom.step_seconds.limit),
                "the time that it has at sea",
            ),
        ] {
            if share >= CLOSE_PERCENT {
                remarks.push(format!("{what} {share:.0} % of {limit}"));
            }
        }
        if self.trials.control_seconds == 0 {
            remarks.push("the plugin never had control: the trials say nothing about how it steers".to_owned());
        } else if self.requests.values().all(|tally| tally.sent == 0) {
            remarks.push("none of its requests was sent: the trials say nothing about how it steers".to_owned());
        }
        for grant in &self.grants_unused {
            remarks.push(format!("it never used the grant {}: does it need it?", grant.name()));
        }
        remarks
    }
}

/// The share, percent.
pub(super) fn percent(most: f64, limit: f64) -> f64 {
    100.0 * most / limit.max(f64::MIN_POSITIVE)
}

fn times(count: u64) -> String {
    if count == 1 {
        "once".to_owned()
    } else {
        format!("{count} times")
    }
}

/// Adds the first of these, and how many more there are.
fn list(objections: &mut Vec<String>, what: &str, all: impl ExactSizeIterator<Item = String>) {
    let more = all.len().saturating_sub(LISTED_MAX);
    objections.extend(all.take(LISTED_MAX).map(|one| format!("{what}: {one}")));
    if more > 0 {
        objections.push(format!("{what}: {more} more"));
    }
}
