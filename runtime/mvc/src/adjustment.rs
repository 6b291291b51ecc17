use backseat_spi::{BuoyancyAdjustment, TrimAdjustment};
use backseat_units::Timestamp;

use crate::answers::Regarding;
use crate::file::WorldFile;
use crate::mvc::Mvc;

/// Trim and buoyancy (SPI 6.22, 6.23, 7.23, 7.24).
#[derive(Debug)]
pub(crate) struct Adjustment {}

impl Adjustment {
    pub(crate) const fn new(_file: &WorldFile, _seed: u64) -> Self {
        Self {}
    }
}

impl Mvc {
    pub(crate) fn adjust_trim(&mut self, now: Timestamp, re: Regarding, _request: &TrimAdjustment) {
        self.unsupported(now, re);
    }

    pub(crate) fn adjust_buoyancy(&mut self, now: Timestamp, re: Regarding, _request: &BuoyancyAdjustment) {
        self.unsupported(now, re);
    }

    /// One step of the vehicle.
    pub(crate) fn tick_adjustment(&mut self, _now: Timestamp) {}
}
