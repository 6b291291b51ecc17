use backseat_core::{FailAction, Grant, Limits, PluginLimits, Policy, Recovery, Settings};
use backseat_plan::VehicleClass;
use backseat_sonar::{PingGrant, SonarConfig};
use serde::{Deserialize, Serialize};

use crate::external::ExternalTable;
use crate::fence::{FenceTable, Origin};

/// The contents of `mission.toml`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct MissionFile {
    /// The vehicle and how to reach it.
    #[serde(default)]
    pub vehicle: VehicleTable,
    /// The values that `fence.plan` and `fence.kml` do not hold.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fence: Option<FenceTable>,
    /// Where the local frame has its zero point: without it, at the centroid of the fence's keep-in zones.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub origin: Option<Origin>,
    /// The front seat's plan with which this mission was checked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plan: Option<PlanTable>,
    /// The settings of the session with the vehicle: control, the operator's texts, the plan.
    #[serde(default)]
    pub session: Settings,
    /// What the operator allows.
    pub limits: Limits,
    /// What the runtime does if the vehicle leaves the fence while something of ours is active. Times count from the
    /// moment at which the vehicle was first outside.
    ///
    /// ```toml
    /// [recovery]
    /// outside_for_s = 2.0      # only counts after this long; then leases end
    /// cancel_after_s = 4.0     # cancel our inserts that have not begun
    /// cancel_current = false   # if true, also end the insert that is being flown (BPRCB)
    /// tell_after_s = 10.0      # write to the vehicle's log and, if tell_topside is true, to the topside
    /// abort_after_s = 60.0     # abort the mission (BPABT); without this key never
    /// back_by_m = 5.0          # inside again means: this far inside the margin,
    /// back_for_s = 10.0        # for this long
    /// ```
    #[serde(default)]
    pub recovery: Recovery,
    /// The plugins, in order of priority, highest first.
    #[serde(default, rename = "plugin")]
    pub plugins: Vec<PluginTable>,
    /// What the runtime does for the operator when something happens. If several conditions become true at once, their
    /// orders are carried out in this order.
    ///
    /// ```toml
    /// [[policy]]
    /// when = { mission-command = "payload abort" }    # or topside-message = "...", navigation-stale-for-s = 60.0
    /// order = { abort = { text = "the plan says so" } }   # errors = true by default; or kill = { text = "..." }
    ///
    /// [[policy]]
    /// when = "plugin-quarantined"
    /// order = "hold"    # or release, cancel-all, cancel-current, cancel-element, { start-empty-mission = { duration_s = 600 } }
    /// ```
    #[serde(default, rename = "policy")]
    pub policies: Vec<Policy>,
    /// The programs that may send sentences that change the vehicle's estimate of its position.
    #[serde(default, rename = "external")]
    pub externals: Vec<ExternalTable>,
    /// The sonars' payload controller, and what the client of it does. Without this table the runtime does not connect to
    /// one.
    ///
    /// ```toml
    /// [sonar]
    /// host = "192.168.1.20"
    ///
    /// [[sonar.sensor]]
    /// index = 2                # in the controller's run list
    /// device = 11002           # in the frames of its records
    /// records = [3000]
    /// ```
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sonar: Option<SonarConfig>,
}

/// The `[vehicle]` table.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct VehicleTable {
    /// The main vehicle computer's address (SPI 4.1).
    pub address: String,
    /// The vehicle's name: at most 64 letters, digits, `.`, `_` and `-`. State that outlives a run (identifiers, the
    /// operator's hold) is kept under this name, so that no other mission of the same vehicle uses an identifier twice.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The vehicle's class: `9-inch`, `12-inch`, `21-inch` or `hovering`. Before a dive the limits and the plan are
    /// checked against what this class can do. If missing, a check that reads `world.toml` takes the class from there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub class: Option<VehicleClass>,
    /// Whether the vehicle reads the entry angle of a trackcircle (BPRTC): SPI 7.6 lists it in the table but not in the
    /// header. If missing, circles are requested only in forms that both readings understand alike: without an entry
    /// angle, and after the current behavior.
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

/// The `[plan]` table: the front seat's plan with which the mission was checked. If present, nothing that steers is
/// sent until the vehicle's own plan (BFPLN) has been found to be the same.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct PlanTable {
    /// A file in the mission's folder with `[[plan]]` as in `world.toml`, and `[origin]` if its positions are relative
    /// to one; or `world.toml` itself, of which only these tables are read.
    pub file: String,
    /// How far a position in the vehicle's plan may be from the expected one, metres, above 0 and at most 100.
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
    /// Its component: a path relative to the mission's folder, or a bare name that is looked up.
    pub component: String,
    /// The requests that it may make.
    pub grants: Vec<Grant>,
    /// What the runtime does when it fails.
    #[serde(default)]
    pub on_failure: FailAction,
    /// Its share of what `[limits]` allows to all plugins together: `inserts_open_max`, `inserts_total_max`,
    /// `inserts_duration_max_s`, `steering_max_s`, `requests_per_s`.
    #[serde(default)]
    pub limits: PluginLimits,
    /// The sonar pings that it sees, and how finely.
    ///
    /// ```toml
    /// [[plugin.ping]]
    /// sensor = 2               # one of [[sonar.sensor]]
    /// samples = 512            # of each channel, at most
    /// decimation = "maximum"   # or mean
    /// ```
    #[serde(default, rename = "ping", skip_serializing_if = "Vec::is_empty")]
    pub pings: Vec<PingGrant>,
    /// The processor time and memory that it may use.
    #[serde(default)]
    pub budget: BudgetTable,
    /// Its own configuration, passed to it as JSON.
    #[serde(default)]
    pub config: toml::Table,
}

/// The `[plugin.budget]` table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct BudgetTable {
    /// Fuel for one step, about one unit for each WebAssembly instruction.
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
