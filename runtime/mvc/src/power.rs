use backseat_units::Timestamp;

use crate::file::WorldFile;
use crate::mvc::Mvc;

/// The battery, and the payload's power (SPI 5.2, 6.8).
#[derive(Debug)]
pub(crate) struct Power {}

impl Power {
    pub(crate) const fn new(_file: &WorldFile, _seed: u64) -> Self {
        Self {}
    }
}

impl Mvc {
    /// One step of the vehicle.
    pub(crate) fn tick_power(&mut self, _now: Timestamp) {}
}
