use backseat_spi::Packet;
use backseat_units::Timestamp;

use crate::answers::Regarding;
use crate::file::WorldFile;
use crate::mvc::Mvc;

/// Packets over the acoustic modem (SPI 9).
#[derive(Debug)]
pub(crate) struct Acoustic {}

impl Acoustic {
    pub(crate) const fn new(_file: &WorldFile, _seed: u64) -> Self {
        Self {}
    }
}

impl Mvc {
    pub(crate) fn packet(&mut self, now: Timestamp, re: Regarding, _request: &Packet) {
        self.unsupported(now, re);
    }

    /// One step of the vehicle.
    pub(crate) fn tick_acoustic(&mut self, _now: Timestamp) {}
}
