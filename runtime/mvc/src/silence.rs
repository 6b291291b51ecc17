use backseat_spi::SilentMode;
use backseat_units::Timestamp;

use crate::answers::Regarding;
use crate::file::WorldFile;
use crate::mvc::Mvc;

/// Silent mode (SPI 7.22).
#[derive(Debug)]
pub(crate) struct Silence {}

impl Silence {
    pub(crate) const fn new(_file: &WorldFile, _seed: u64) -> Self {
        Self {}
    }
}

impl Mvc {
    pub(crate) fn silent_mode(&mut self, now: Timestamp, re: Regarding, _request: &SilentMode) {
        self.unsupported(now, re);
    }

    /// One step of the vehicle.
    pub(crate) fn tick_silence(&mut self, _now: Timestamp) {}
}
