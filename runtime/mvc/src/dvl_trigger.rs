use backseat_spi::DvlTriggerRequest;
use backseat_units::Timestamp;

use crate::answers::Regarding;
use crate::file::WorldFile;
use crate::mvc::Mvc;

/// External triggering of the DVL (SPI 5.6, 7.4).
#[derive(Debug)]
pub(crate) struct DvlTrigger {}

impl DvlTrigger {
    pub(crate) const fn new(_file: &WorldFile, _seed: u64) -> Self {
        Self {}
    }
}

impl Mvc {
    pub(crate) fn dvl_trigger_request(&mut self, now: Timestamp, re: Regarding, _request: &DvlTriggerRequest) {
        self.unsupported(now, re);
    }

    /// One step of the vehicle.
    pub(crate) fn tick_dvl_trigger(&mut self, _now: Timestamp) {}
}
