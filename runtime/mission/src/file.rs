use backseat_core::{FailAction, Grant, Limits, PluginLimits, Policy, Recovery, Settings};
use backseat_plan::VehicleClass;
use serde::{Deserialize, Serialize};

use crate::external::ExternalTable;
use crate::fence::FenceTable;

/// `mission.toml` as it is written.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct MissionFile {
    /// Where the vehicle is.
    #[serde(default)]
    pub vehicle: VehicleTable,
    /// What `fence.plan` and `fence.kml` do not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fence: Option<FenceTable>,
    /// The front seat's plan that this mission was checked with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plan: Option<PlanTable>,
    /// How the session is held.
    #[serde(default)]
    pub session: Settings,
    /// What the operator allows.
    pub limits: Limits,
    /// What is done where the vehicle is outside the fence after all, while something of ours is active. Times count from
    /// when it was first outside.
    ///
    /// ```toml
    /// [recovery]
    /// outside_for_s = 2.0      # so long outside before it counts; leases end then
    /// cancel_after_s = 4.0     # our inserts that have not begun are cancelled
    /// cancel_current = false   # and the one that is flown is ended (BPRCB)
    /// tell_after_s = 10.0      # the vehicle's log is told, and with tell_topside = true the topside
    /// abort_after_s = 60.0     # the mission is aborted (BPABT); never without this key
    /// back_by_m = 5.0          # inside again: by so much beyond the margin,
    /// back_for_s = 10.0        # for so long
    /// ```
    #[serde(default)]
    pub recovery: Recovery,
    /// The plugins, the first of the highest priority.
    #[serde(default, rename = "plugin")]
    pub plugins: Vec<PluginTable>,
    /// What is done for the operator when something happens. Several that come to be at once act in this order.
    ///
    /// ```toml
    /// [[policy]]
    /// when = { mission-command = "payload abort" }    # or topside-message = "...", navigation-stale-for-s = 60.0
    /// order = { abort = { text = "the plan says so" } }   # errors = true unless it says false; kill = { text = "..." }
    ///
    /// [[policy]]
    /// when = "plugin-quarantined"
    /// order = "hold"    # or release, cancel-all, cancel-current, cancel-element, { start-empty-mission = { duration_s = 600 } }
    /// ```
    #[serde(default, rename = "policy")]
    pub policies: Vec<Policy>,
    /// Who may send what moves the vehicle's idea of where it is.
    #[serde(default, rename = "external")]
    pub externals: Vec<ExternalTable>,
}

/// The `[vehicle]` table.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct VehicleTable {
    /// The main vehicle computer's address (SPI 4.1).
    pub address: String,
    /// What the vehicle is called: letters, digits, `.`, `_` and `-`, 64 at most. What outlives a run is kept under it (its
    /// identifiers, the operator's hold), so that no other mission of the same vehicle uses an identifier twice.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Which class it is of: `9-inch`, `12-inch`, `21-inch` or `hovering`. What it can do is held against the limits
    /// and the plan before a dive; where absent, a check that looks at `world.toml` takes its class.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub class: Option<VehicleClass>,
    /// Whether it reads the entry angle of a trackcircle (BPRTC): SPI 7.6 has it in the table and not in the header. Where
    /// absent, circles are requested only so that both read them alike: without an entry angle, and after what is flown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trackcircle_entry_angle: Option<bool>,
}

impl Default for VehicleTable {
    fn default() -> Self {
        Self {
            address: "127.0.0.1:29500".to_owned(),
            name: None,
            class: None,
            trackcircle_entry_angle: None,
        }
    }
}

/// The `[plan]` table: the front seat's plan that the mission was checked with. Where it is there, nothing is sent that
/// steers until the vehicle's own plan (BFPLN) has been found to be the same.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct PlanTable {
    /// A file of the mission's folder with `[[plan]]` as in `world.toml`, and `[origin]` where its places count from
    /// one; or `world.toml` itself, of which no more than that is read.
    pub file: String,
    /// How far a place of the vehicle's plan may be from the one expected, metres, above 0 to 100.
    #[serde(default = "PlanTable::default_tolerance_m")]
    pub tolerance_m: f64,
}

impl PlanTable {
    pub(crate) const fn default_tolerance_m() -> f64 {
        2.0
    }
}

/// A `[[plugin]]` table.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct PluginTable {
    /// Its name in this mission.
    pub name: String,
    /// Its component: a path from the mission's folder, or a bare name that is looked up.
    pub component: String,
    /// What it may do.
    pub grants: Vec<Grant>,
    /// What is done when it fails.
    #[serde(default)]
    pub on_failure: FailAction,
    /// What it may use of what `[limits]` allows to all: `inserts_open_max`, `inserts_total_max`,
    /// `inserts_duration_max_s`, `steering_max_s`, `requests_per_s`.
    #[serde(default)]
    pub limits: PluginLimits,
    /// What it may use.
    #[serde(default)]
    pub budget: BudgetTable,
    /// Its own configuration, handed to it as JSON.
    #[serde(default)]
    pub config: toml::Table,
}

/// The `[plugin.budget]` table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct BudgetTable {
    /// Fuel for a step, about one for a WebAssembly instruction.
    pub fuel_per_step: u64,
    /// Memory, mebibytes.
    pub memory_mib: u32,
}

impl Default for BudgetTable {
    fn default() -> Self {
        Self {
            fuel_per_step: 20_000_000,
            memory_mib: 64,
        }
    }
}
