use backseat_spi::{Abort, CancelCurrent, CancelElement, Kill, StartEmptyMission};
use backseat_units::Timestamp;

use crate::answers::Regarding;
use crate::mvc::Mvc;

/// What ends behaviors, elements and missions at a payload's wish, and starts an empty one (SPI 7.10, 7.11, 7.16, 7.17, 7.20).
impl Mvc {
    pub(crate) fn cancel_current(&mut self, now: Timestamp, re: Regarding, _request: &CancelCurrent) {
        self.unsupported(now, re);
    }

    pub(crate) fn cancel_element(&mut self, now: Timestamp, re: Regarding, _request: &CancelElement) {
        self.unsupported(now, re);
    }

    pub(crate) fn abort(&mut self, now: Timestamp, re: Regarding, _request: &Abort) {
        self.unsupported(now, re);
    }

    pub(crate) fn kill(&mut self, now: Timestamp, re: Regarding, _request: &Kill) {
        self.unsupported(now, re);
    }

    pub(crate) fn start_empty_mission(&mut self, now: Timestamp, re: Regarding, _request: &StartEmptyMission) {
        self.unsupported(now, re);
    }
}
