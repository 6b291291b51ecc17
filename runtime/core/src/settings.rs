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

/// What gives control to the backseat.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum ControlHook {
    /// BFCTL 1 (SPI 6.24).
    #[default]
    Bfctl,
    /// The mission is running, for vehicles configured to hand over when it starts (SPI 6.24).
    Running,
    /// Mission commands (BFMSC, SPI 5.1) with texts that the operator chooses.
    MissionCommand {
        /// The text that gives control.
        grant: String,
        /// The text that takes control back.
        revoke: String,
    },
}

/// How the runtime talks with the vehicle and the operator: the `[session]` table of a mission.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// What gives control to the backseat.
    pub control: ControlHook,
    /// Which north BPRMB's heading is counted from.
    pub heading_frame: HeadingFrame,
    /// The conditions in which BPSTS says 0, which feeds the vehicle's own fixed safety rules (SPI 3). By default there
    /// are none: a plugin's failure is only reported as text.
    pub status_failed_when: Vec<StatusCondition>,
    /// The mission command (BFMSC, SPI 5.1) with which the operator holds. Blanks around it do not count. Like every
    /// hold, it lasts until a release.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hold_text: Option<String>,
    /// The mission command with which the operator releases a hold. Without it no mission command does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub release_text: Option<String>,
    /// Whether the vehicle reads the entry angle of a BPRTC: the table of SPI 7.6 has it, the header does not. `None`
    /// if that is not known. From the mission's `[vehicle]` table.
    #[serde(skip)]
    pub trackcircle_entry_angle: Option<bool>,
    /// What the runtime does if the vehicle is outside the fence in spite of all checks: the mission's `[recovery]`
    /// table.
    #[serde(skip)]
    pub recovery: Recovery,
    /// What the runtime does for the operator when something happens: the mission's `[[policy]]` tables.
    #[serde(skip)]
    pub policies: Vec<Policy>,
    /// The external sources: the operator's programs that may send what no plugin may. From the mission's
    /// `[[external]]` tables.
    #[serde(skip)]
    pub externals: Vec<ExternalSetup>,
    /// The plan that the operator checked. The runtime sends nothing that steers until the vehicle's own plan was found
    /// to be the same on this connection. If `None`, nothing is compared.
    #[serde(skip)]
    pub expected_plan: Option<ExpectedPlan>,
    /// The sonars: what core needs of the mission's `[sonar]` table. `None` if there is none.
    #[serde(skip)]
    pub sonar: Option<SonarSetup>,
}

/// What core needs to know of the mission's `[sonar]` table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SonarSetup {
    /// The sensors' indices in the payload controller.
    pub sensors: Vec<i32>,
    /// Logging follows BFBDL and BFSDL (SPI 5.3, 5.4).
    pub log_with_vehicle: bool,
}

/// A condition of ours that BPSTS reports as a failure, if the operator lists it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StatusCondition {
    /// A plugin is quarantined.
    PluginQuarantined,
    /// Navigation is stale.
    NavigationStale,
    /// There is no connection to the sonars' payload controller, or it is not set up yet.
    SonarNotReady,
    /// An alarm of the payload controller is active.
    SonarAlarm,
    /// A sonar is not healthy.
    SonarUnhealthy,
    /// Logging was ordered, and the payload controller does not say that it logs.
    SonarNotLogging,
}

/// A plugin of the mission, in priority order.
#[derive(Clone, Debug, PartialEq)]
pub struct PluginSetup {
    /// Its name in the mission.
    pub name: String,
    /// What it says about itself.
    pub description: Description,
    /// What it may do.
    pub grants: Vec<Grant>,
    /// What the runtime does when it fails.
    pub on_failure: FailAction,
    /// What it may use of what the mission allows to all plugins.
    pub limits: PluginLimits,
}
