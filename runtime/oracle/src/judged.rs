use std::fmt;

use serde::Serialize;

/// What a rule is judged by: where a run does not tell that, the rule is not judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// Our bytes alone, as they leave the runtime.
    Sent,
    /// Our bytes, held against what the vehicle's bytes have told the runtime before.
    Heard,
    /// Our bytes, held against what the operator has done.
    Operator,
    /// When our bytes arrive at the vehicle.
    Arrived,
    /// The vehicle's truth.
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

/// How one rule fared in a run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Judged {
    /// The rule's short name.
    pub rule: &'static str,
    /// The safety requirement behind it, where it has one.
    pub requirement: Option<u32>,
    /// What it is judged by.
    pub side: Side,
    /// How often there was something to judge.
    pub judged: u64,
    /// How often it was broken.
    pub broken: u64,
    /// Why it was not judged; nothing where it was.
    pub unjudged: Option<&'static str>,
}
