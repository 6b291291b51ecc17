pub(crate) mod external;
pub(crate) mod recovery;

use serde::{Deserialize, Serialize};

use crate::monitor::limits::plugin::PluginLimits;
use crate::monitor::limits::{FailAction, Grant, HeadingFrame};
use crate::order::Policy;
use crate::plugin::Description;
use crate::settings::external::ExternalSetup;
use crate::settings::recovery::Recovery;
use crate::vehicle::expected::ExpectedPlan;

/// What hands control to the backseat.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum ControlHook {
    /// BFCTL 1 (SPI 6.24).
    #[default]
    Bfctl,
    /// The mission's running, for vehicles configured to hand over when it starts (SPI 6.24).
    Running,
    /// A mission command (BFMSC, SPI 5.1) with a text of the operator's.
    MissionCommand {
        /// Hands control over.
        grant: String,
        /// Takes it back.
        revoke: String,
    },
}

/// How the session is held: the `[session]` table of a mission.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// What hands control to the backseat.
    pub control: ControlHook,
    /// Which north BPRMB's heading is counted from.
    pub heading_frame: HeadingFrame,
    /// The conditions under which BPSTS says 0, which feeds the vehicle's own fixed safety rules (SPI 3). None by
    /// default: a plugin's failure is text.
    pub status_failed_when: Vec<StatusCondition>,
    /// The mission command (BFMSC, SPI 5.1) with which the operator holds, blanks around it apart: latched, as every hold.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hold_text: Option<String>,
    /// The mission command with which the operator releases. Without it no text does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub release_text: Option<String>,
    /// Whether the vehicle reads the entry angle of a BPRTC: the table of SPI 7.6 has it, the header has not. `None` where
    /// that is not known: the mission's `[vehicle]` table.
    #[serde(skip)]
    pub trackcircle_entry_angle: Option<bool>,
    /// What is done where the vehicle is outside the fence after all: the mission's `[recovery]` table.
    #[serde(skip)]
    pub recovery: Recovery,
    /// What is done for the operator when something happens: the mission's `[[policy]]` tables.
    #[serde(skip)]
    pub policies: Vec<Policy>,
    /// Who may send what moves the vehicle's idea of where it is: the mission's `[[external]]` tables.
    #[serde(skip)]
    pub externals: Vec<ExternalSetup>,
    /// The plan that the operator had checked: nothing that steers is sent until the vehicle's own has been found to be
    /// the same on this connection. Where there is none, nothing is compared.
    #[serde(skip)]
    pub expected_plan: Option<ExpectedPlan>,
}

/// A condition of ours that the operator may make the vehicle's affair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StatusCondition {
    /// A plugin is quarantined.
    PluginQuarantined,
    /// Navigation is stale.
    NavigationStale,
}

/// A plugin of the mission, in priority order.
#[derive(Clone, Debug, PartialEq)]
pub struct PluginSetup {
    /// Its name in the mission.
    pub name: String,
    /// What it says of itself.
    pub description: Description,
    /// What it may do.
    pub grants: Vec<Grant>,
    /// What is done when it fails.
    pub on_failure: FailAction,
    /// What it may use of what the mission allows to all.
    pub limits: PluginLimits,
}
