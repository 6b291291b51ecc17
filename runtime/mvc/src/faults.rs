use backseat_units::Timestamp;

use crate::file::WorldFile;
use crate::mvc::Mvc;

/// What goes wrong, and when.
#[derive(Debug)]
pub(crate) struct Faults {}

impl Faults {
    pub(crate) const fn new(_file: &WorldFile, _seed: u64) -> Self {
        Self {}
    }
}

impl Mvc {
    /// One step of the vehicle.
    pub(crate) fn tick_faults(&mut self, _now: Timestamp) {}
}
