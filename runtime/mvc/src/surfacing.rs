use backseat_spi::GpsHit;
use backseat_units::Timestamp;

use crate::answers::Regarding;
use crate::file::WorldFile;
use crate::mvc::Mvc;

/// GPS hits (SPI 7.7).
#[derive(Debug)]
pub(crate) struct Surfacing {}

impl Surfacing {
    pub(crate) const fn new(_file: &WorldFile, _seed: u64) -> Self {
        Self {}
    }
}

impl Mvc {
    pub(crate) fn gps_hit(&mut self, now: Timestamp, re: Regarding, _request: &GpsHit) {
        self.unsupported(now, re);
    }

    /// One step of the vehicle.
    pub(crate) fn tick_surfacing(&mut self, _now: Timestamp) {}
}
