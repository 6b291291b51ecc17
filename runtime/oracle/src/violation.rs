use std::fmt;

use backseat_units::Timestamp;
use serde::Serialize;

use crate::rule::Rule;

/// One breach of a rule.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Violation {
    /// When it was found.
    pub at: Timestamp,
    /// The rule's short name.
    pub rule: &'static str,
    /// The safety requirement behind the rule, where it has one.
    pub requirement: Option<u32>,
    /// What happened, with its numbers.
    pub text: String,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.at, self.rule)?;
        if let Some(requirement) = self.requirement {
            write!(f, " (requirement {requirement:03})")?;
        }
        write!(f, ": {}", self.text)
    }
}

/// The violations of a run: the first ones whole, the rest as a number, so that a broken run costs no more memory than
/// a good one.
#[derive(Clone, Debug, Default)]
pub(crate) struct Findings {
    kept: Vec<Violation>,
    count: u64,
    last: Timestamp,
}

impl Findings {
    const KEPT_MAX: usize = 100;

    /// Adds one. The text is made only where it is kept.
    pub(crate) fn add(&mut self, at: Timestamp, rule: Rule, text: impl FnOnce() -> String) {
        self.count += 1;
        self.last = at;
        if self.kept.len() < Self::KEPT_MAX {
            self.kept.push(Violation {
                at,
                rule: rule.name(),
                requirement: rule.requirement(),
                text: text(),
            });
        }
    }

    pub(crate) const fn count(&self) -> u64 {
        self.count
    }

    pub(crate) fn into_violations(mut self) -> Vec<Violation> {
        let omitted = self.count - self.kept.len() as u64;
        if omitted > 0 {
            self.kept.push(Violation {
                at: self.last,
                rule: Rule::Omitted.name(),
                requirement: None,
                text: format!("{omitted} more violations"),
            });
        }
        self.kept
    }
}
