use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Time since any fixed moment. The host reads no clock of its own.
pub type Stopwatch = Arc<dyn Fn() -> Duration + Send + Sync>;

/// What a plugin has used since its [`Meter`] was set, over all of its instances.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Usage {
    /// How many steps it was given while it ran.
    pub steps: u64,
    /// The greatest fuel of a step, without the snapshot after it. At most [`crate::Budget::fuel_per_step`].
    pub step_fuel_max: u64,
    /// The greatest fuel of a snapshot. At most [`crate::Budget::fuel_snapshot`].
    pub snapshot_fuel_max: u64,
    /// The greatest linear memory after a step, bytes. At most [`crate::Budget::memory_bytes`].
    pub memory_bytes_max: usize,
    /// The longest time of a step by the stopwatch, without the snapshot after it.
    pub step_time_max: Duration,
    /// The time of all steps by the stopwatch.
    pub step_time_total: Duration,
    /// How many of its log lines were dropped: more than 32 in a step or, over time, in a second.
    pub lines_dropped: u64,
}

impl Usage {
    /// What two runs of a plugin have used, taken together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            steps: self.steps + other.steps,
            step_fuel_max: self.step_fuel_max.max(other.step_fuel_max),
            snapshot_fuel_max: self.snapshot_fuel_max.max(other.snapshot_fuel_max),
            memory_bytes_max: self.memory_bytes_max.max(other.memory_bytes_max),
            step_time_max: self.step_time_max.max(other.step_time_max),
            step_time_total: self.step_time_total + other.step_time_total,
            lines_dropped: self.lines_dropped + other.lines_dropped,
        }
    }
}

/// Measures a plugin, for [`crate::Plugin::set_meter`]. Whoever made it reads it, also while the plugin runs elsewhere.
pub struct Meter {
    stopwatch: Stopwatch,
    usage: Mutex<Usage>,
}

impl Meter {
    /// A meter that has measured nothing yet.
    #[must_use]
    pub fn new(stopwatch: Stopwatch) -> Self {
        Self {
            stopwatch,
            usage: Mutex::default(),
        }
    }

    /// What was measured so far.
    #[must_use]
    pub fn usage(&self) -> Usage {
        *self.usage.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn now(&self) -> Duration {
        (self.stopwatch)()
    }

    /// Adds a step that began at this time of the stopwatch and ends now.
    pub(crate) fn step(&self, begun: Duration, fuel: u64, memory_bytes: usize) {
        let took = self.now().saturating_sub(begun);
        self.add(Usage {
            steps: 1,
            step_fuel_max: fuel,
            memory_bytes_max: memory_bytes,
            step_time_max: took,
            step_time_total: took,
            ..Usage::default()
        });
    }

    pub(crate) fn snapshot(&self, fuel: u64) {
        self.add(Usage {
            snapshot_fuel_max: fuel,
            ..Usage::default()
        });
    }

    pub(crate) fn dropped(&self, lines: u64) {
        self.add(Usage {
            lines_dropped: lines,
            ..Usage::default()
        });
    }

    fn add(&self, more: Usage) {
        let mut usage = self.usage.lock().unwrap_or_else(PoisonError::into_inner);
        *usage = usage.and(more);
    }
}
