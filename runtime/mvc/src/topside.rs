use backseat_spi::{TopsideRelay, TopsideText};
use backseat_units::Timestamp;

use crate::answers::Regarding;
use crate::file::WorldFile;
use crate::mvc::Mvc;

/// Text to and from the topside, and the mission's own messages (SPI 5.1, 5.3, 5.4, 5.5, 7.3, 7.14).
#[derive(Debug)]
pub(crate) struct Topside {}

impl Topside {
    pub(crate) const fn new(_file: &WorldFile, _seed: u64) -> Self {
        Self {}
    }
}

impl Mvc {
    pub(crate) fn topside_text(&mut self, now: Timestamp, re: Regarding, _request: &TopsideText) {
        self.unsupported(now, re);
    }

    pub(crate) fn topside_relay(&mut self, now: Timestamp, re: Regarding, _request: &TopsideRelay) {
        self.unsupported(now, re);
    }

    /// One step of the vehicle.
    pub(crate) fn tick_topside(&mut self, _now: Timestamp) {}
}
