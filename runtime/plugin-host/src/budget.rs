use serde::{Deserialize, Serialize};

/// What one plugin may use. A unit of fuel is about one WebAssembly instruction; a present-day core uses about 10^9 a
/// second.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Budget {
    /// Fuel for one step. 10,000,000 by default, about 10 ms.
    pub fuel_per_step: u64,
    /// Fuel for a start: the component's own initialisation, `describe` and `init`; for a restart, `init` and
    /// `restore`. 1,000,000,000 by default, because interpreters start slowly.
    pub fuel_init: u64,
    /// Fuel for one snapshot. 10,000,000 by default.
    pub fuel_snapshot: u64,
    /// Linear memory in total, bytes. 64 MiB by default.
    pub memory_bytes: usize,
    /// The number of successful steps between snapshots; 0 means no snapshots. 10 by default.
    pub snapshot_every_steps: u32,
}

impl Default for Budget {
    fn default() -> Self {
        Self {
            fuel_per_step: 10_000_000,
            fuel_init: 1_000_000_000,
            fuel_snapshot: 10_000_000,
            memory_bytes: 64 << 20,
            snapshot_every_steps: 10,
        }
    }
}
