use std::fmt;

use crate::margin::{Margin, Margins};
use crate::moment::Moment;
use serde::Serialize;

use crate::rule::Rule;

/// One breach of a rule.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Violation {
    /// When the oracle found it, nanoseconds since the start of the run.
    #[serde(rename = "at")]
    pub at_ns: u64,
    /// The rule's short name.
    pub rule: &'static str,
    /// The safety requirement behind the rule, if it has one.
    pub requirement: Option<u32>,
    /// The sentence that revealed it, without its line end; `None` if silence broke the rule.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sentence: Option<String>,
    /// What happened, with the figures.
    pub text: String,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", Moment::from_nanos(self.at_ns), self.rule)?;
        if let Some(requirement) = self.requirement {
            write!(f, " (requirement {requirement:03})")?;
        }
        write!(f, ": {}", self.text)
    }
}

/// The violations of a run. The first ones are kept whole and the others are only counted, so that a broken run takes
/// no more memory than a good one.
#[derive(Clone, Debug)]
pub(crate) struct Findings {
    kept: Vec<Violation>,
    count: u64,
    last: Moment,
    /// The line that is being judged; empty if there is none.
    line: Vec<u8>,
    /// How often each rule was judged, and how often it was broken.
    judged: [u64; Rule::ALL.len()],
    broken: [u64; Rule::ALL.len()],
    margins: Margins,
}

impl Default for Findings {
    fn default() -> Self {
        Self {
            kept: Vec::new(),
            count: 0,
            last: Moment::ZERO,
            line: Vec::new(),
            judged: [0; Rule::ALL.len()],
            broken: [0; Rule::ALL.len()],
            margins: Margins::default(),
        }
    }
}

impl Findings {
    const KEPT_MAX: usize = 100;
    /// How many bytes of a line a violation shows.
    const SHOWN_MAX: usize = 200;

    /// Starts judging a line: violations that are found before [`Findings::passed`] show it.
    pub(crate) fn looks_at(&mut self, line: &[u8]) {
        self.line.clear();
        self.line.extend_from_slice(line.get(..Self::SHOWN_MAX).unwrap_or(line));
    }

    /// Ends the judging of the line.
    pub(crate) fn passed(&mut self) {
        self.line.clear();
    }

    /// Counts that a rule was judged.
    pub(crate) const fn judge(&mut self, rule: Rule) {
        self.judged[rule as usize] += 1;
    }

    /// How often a rule was judged, and how often it was broken.
    pub(crate) fn of(&self, rule: Rule) -> (u64, u64) {
        let broken = self.broken[rule as usize];
        (self.judged[rule as usize].max(broken), broken)
    }

    /// Notes how near a case came to what is forbidden. Figures that are not finite are left out.
    pub(crate) fn near(&mut self, margin: Margin, value: f64, allowed: f64) {
        if value.is_finite() && allowed.is_finite() {
            self.margins.note(margin, value, allowed);
        }
    }

    /// The nearest cases.
    pub(crate) const fn margins(&self) -> &Margins {
        &self.margins
    }

    /// Adds a violation. The text is made only if the violation is kept.
    pub(crate) fn add(&mut self, at: Moment, rule: Rule, text: impl FnOnce() -> String) {
        self.count += 1;
        self.broken[rule as usize] += 1;
        self.last = at;
        if self.kept.len() < Self::KEPT_MAX {
            self.kept.push(Violation {
                at_ns: at.as_nanos(),
                rule: rule.name(),
                requirement: rule.requirement(),
                sentence: self.sentence(),
                text: text(),
            });
        }
    }

    fn sentence(&self) -> Option<String> {
        let line = String::from_utf8_lossy(self.line.trim_ascii_end());
        (!line.is_empty()).then(|| line.escape_debug().to_string())
    }

    pub(crate) const fn count(&self) -> u64 {
        self.count
    }

    pub(crate) fn into_violations(mut self) -> Vec<Violation> {
        let omitted = self.count - self.kept.len() as u64;
        if omitted > 0 {
            self.kept.push(Violation {
                at_ns: self.last.as_nanos(),
                rule: Rule::Omitted.name(),
                requirement: None,
                sentence: None,
                text: format!("{omitted} more violations"),
            });
        }
        self.kept
    }
}
