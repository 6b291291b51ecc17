use serde::{Deserialize, Serialize};

/// What one plugin may use. Fuel is roughly a WebAssembly instruction; a core of these years burns some 10^9 a second.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Budget {
    /// Fuel of one step. 10,000,000 by default, some 10 ms.
    pub fuel_per_step: u64,
    /// Fuel of a start: the component's own initialisation, `describe` and `init`; or, for a restart, `init` and
    /// `restore`. 1,000,000,000 by default: interpreters start slowly.
    pub fuel_init: u64,
    /// Fuel of one snapshot. 10,000,000 by default.
    pub fuel_snapshot: u64,
    /// Linear memory in all, bytes. 64 MiB by default.
    pub memory_bytes: usize,
    /// After how many successful steps a snapshot is taken; 0 means never. 10 by default.
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
