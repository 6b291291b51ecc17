//! What only the operator may order, by word or by a policy of the mission file: cancels beyond a plugin's own inserts,
//! abort and kill, an empty mission (SPI 7.9, 7.10, 7.11, 7.16, 7.17, 7.20).

use serde::{Deserialize, Serialize};

use crate::machine::Core;

/// What the operator orders.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Order {
    /// As [`Operator::Hold`](crate::Operator::Hold).
    Hold,
    /// As [`Operator::Release`](crate::Operator::Release).
    Release,
    /// Cancel all inserts, other payloads' too (BPRCA).
    CancelAll,
    /// End the current behaviour, where it is an insert of ours (BPRCB).
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

/// When a policy acts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Condition {
    /// A mission command with exactly this text (BFMSC, SPI 5.1).
    MissionCommand(String),
    /// A message from the topside with exactly this text (BFTOP, SPI 5.5).
    TopsideMessage(String),
    /// A plugin is quarantined.
    PluginQuarantined,
    /// Navigation has been stale for this long, seconds.
    NavigationStaleForS(f64),
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

impl Core {
    /// The operator's order.
    pub(crate) fn order(&mut self, order: &Order) {
        self.note(crate::io::Note::Text {
            text: format!("an order is not carried out: {order:?}"),
        });
    }

    /// Carries out the policies whose condition an event fulfils.
    pub(crate) fn carry_out(&mut self, fulfilled: impl Fn(&Condition) -> bool) {
        let orders: Vec<Order> = self
            .settings
            .policies
            .iter()
            .filter(|policy| fulfilled(&policy.when))
            .map(|policy| policy.order.clone())
            .collect();
        for order in orders {
            self.order(&order);
        }
    }

    /// A condition that must last may have lasted for long enough.
    pub(crate) fn policies_due(&mut self) {}
}
