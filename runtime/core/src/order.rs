//! Orders that only the operator may give, at once or in advance as policies.

use std::fmt;

use serde::{Deserialize, Serialize};

/// An order of the operator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Order {
    /// As [`Operator::Hold`](crate::Operator::Hold).
    Hold,
    /// As [`Operator::Release`](crate::Operator::Release).
    Release,
    /// Cancel all inserts, also those of other payloads (BPRCA).
    CancelAll,
    /// End the current behavior, if it is an insert of ours (BPRCB).
    CancelCurrent,
    /// End the current element of the mission (BPRCE).
    CancelElement,
    /// End the mission with its wrap-up (BPABT).
    Abort {
        /// Shown to people.
        text: String,
        /// Whether it ends with errors, which is the vehicle's default.
        #[serde(default = "with_errors")]
        errors: bool,
    },
    /// End the mission and all movement: the vehicle drifts (BPKIL).
    Kill {
        /// Shown to people.
        text: String,
    },
    /// Start a mission without a plan (BPSEM).
    StartEmptyMission {
        /// How long it may last, seconds.
        duration_s: u32,
    },
}

const fn with_errors() -> bool {
    true
}

impl fmt::Display for Order {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Hold => f.write_str("hold"),
            Self::Release => f.write_str("release"),
            Self::CancelAll => f.write_str("cancel all inserts"),
            Self::CancelCurrent => f.write_str("cancel the current behavior"),
            Self::CancelElement => f.write_str("cancel the current element of the mission"),
            Self::Abort { text, .. } => write!(f, "abort: {text}"),
            Self::Kill { text } => write!(f, "kill: {text}"),
            Self::StartEmptyMission { duration_s } => write!(f, "start an empty mission of {duration_s} s"),
        }
    }
}

/// When a policy acts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Condition {
    /// A mission command with exactly this text, apart from blanks around it (BFMSC, SPI 5.1).
    MissionCommand(String),
    /// A message from the topside with exactly this text (BFTOP, SPI 5.5).
    TopsideMessage(String),
    /// A plugin is quarantined.
    PluginQuarantined,
    /// Navigation has been stale for this long, seconds. The policy acts once in each period of staleness, and not
    /// before the first connection.
    NavigationStaleForS(f64),
}

impl fmt::Display for Condition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::MissionCommand(text) => write!(f, "the mission command `{text}`"),
            Self::TopsideMessage(text) => write!(f, "the topside's message `{text}`"),
            Self::PluginQuarantined => f.write_str("a plugin is quarantined"),
            Self::NavigationStaleForS(seconds) => write!(f, "navigation has been stale for {seconds} s"),
        }
    }
}

/// What is done for the operator when something happens: a `[[policy]]` table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Policy {
    /// When.
    pub when: Condition,
    /// What.
    pub order: Order,
}
