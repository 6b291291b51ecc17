use crate::moment::Moment;

use crate::rule::Rule;
use crate::violation::Findings;

/// Why a lease or station keeping must end, and the time by which the sentence that ends it must have been sent.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Due {
    pub(crate) by: Moment,
    pub(crate) rule: Rule,
    pub(crate) why: &'static str,
}

impl Due {
    /// The earlier one.
    #[expect(clippy::unnecessary_wraps, reason = "callers assign the result to an `Option`")]
    pub(crate) fn first(due: Option<Self>, other: Self) -> Option<Self> {
        Some(due.filter(|due| due.by <= other.by).unwrap_or(other))
    }

    pub(crate) fn is_missed(&self, now: Moment) -> bool {
        now > self.by
    }

    /// How much time is left, seconds; negative if it is missed.
    pub(crate) fn left_s(&self, now: Moment) -> f64 {
        self.by.since(now).as_secs_f64() - now.since(self.by).as_secs_f64()
    }

    pub(crate) fn tell(&self, now: Moment, end: &str, findings: &mut Findings) {
        findings.add(now, self.rule, || {
            format!("no {end} by {}, although {}", self.by, self.why)
        });
    }
}
