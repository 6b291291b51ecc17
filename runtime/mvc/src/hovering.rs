use backseat_spi::{
    BearingOffset, BottomPosition, Camera, Continue, HullPosition, HullSpeedLimit, Light, RelativeReset, Resume,
    SonarAngle, Suspend,
};
use backseat_units::Timestamp;

use crate::answers::Regarding;
use crate::file::WorldFile;
use crate::mvc::Mvc;

/// Hovering vehicles (SPI 8).
#[derive(Debug)]
pub(crate) struct Hovering {}

impl Hovering {
    pub(crate) const fn new(_file: &WorldFile, _seed: u64) -> Self {
        Self {}
    }
}

impl Mvc {
    pub(crate) fn suspend(&mut self, now: Timestamp, re: Regarding, _request: &Suspend) {
        self.unsupported(now, re);
    }

    pub(crate) fn keep_suspended(&mut self, now: Timestamp, re: Regarding, _request: &Continue) {
        self.unsupported(now, re);
    }

    pub(crate) fn resume(&mut self, now: Timestamp, re: Regarding, _request: &Resume) {
        self.unsupported(now, re);
    }

    pub(crate) fn hull_speed_limit(&mut self, now: Timestamp, re: Regarding, _request: &HullSpeedLimit) {
        self.unsupported(now, re);
    }

    pub(crate) fn sonar_angle(&mut self, now: Timestamp, re: Regarding, _request: &SonarAngle) {
        self.unsupported(now, re);
    }

    pub(crate) fn hull_position(&mut self, now: Timestamp, re: Regarding, _request: &HullPosition) {
        self.unsupported(now, re);
    }

    pub(crate) fn bottom_position(&mut self, now: Timestamp, re: Regarding, _request: &BottomPosition) {
        self.unsupported(now, re);
    }

    pub(crate) fn relative_reset(&mut self, now: Timestamp, re: Regarding, _request: &RelativeReset) {
        self.unsupported(now, re);
    }

    pub(crate) fn bearing_offset(&mut self, now: Timestamp, re: Regarding, _request: &BearingOffset) {
        self.unsupported(now, re);
    }

    pub(crate) fn camera(&mut self, now: Timestamp, re: Regarding, _request: &Camera) {
        self.unsupported(now, re);
    }

    pub(crate) fn light(&mut self, now: Timestamp, re: Regarding, _request: &Light) {
        self.unsupported(now, re);
    }

    /// One step of the vehicle.
    pub(crate) fn tick_hovering(&mut self, _now: Timestamp) {}
}
