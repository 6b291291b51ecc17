use std::fmt;

use serde::Serialize;

/// What a rule is judged by. If a record does not have it, the rule is not judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// Our bytes alone, as they leave the runtime.
    Sent,
    /// Our bytes, compared with what the vehicle's bytes have told the runtime before.
    Heard,
    /// Our bytes, compared with what the operator has done.
    Operator,
    /// The times at which our bytes arrive at the vehicle.
    Arrived,
    /// The vehicle's true state.
    Truth,
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Sent => "sent",
            Self::Heard => "heard",
            Self::Operator => "operator",
            Self::Arrived => "arrived",
            Self::Truth => "truth",
        })
    }
}

/// How often one rule was judged and broken in a run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Judged {
    /// The rule's short name.
    pub rule: &'static str,
    /// The safety requirement behind the rule, if it has one.
    pub requirement: Option<u32>,
    /// What the rule is judged by.
    pub side: Side,
    /// How often there was something to judge.
    pub judged: u64,
    /// How often the rule was broken.
    pub broken: u64,
    /// Why the rule was not judged; `None` if it was.
    pub unjudged: Option<&'static str>,
}
