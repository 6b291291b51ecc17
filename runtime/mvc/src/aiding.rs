use backseat_spi::{PayloadCtd, PositionFix};
use backseat_units::Timestamp;

use crate::answers::Regarding;
use crate::mvc::Mvc;

/// What a payload measures for the vehicle: fixes and CTD data (SPI 7.15, 7.21).
impl Mvc {
    pub(crate) fn position_fix(&mut self, now: Timestamp, re: Regarding, _request: &PositionFix) {
        self.unsupported(now, re);
    }

    pub(crate) fn payload_ctd(&mut self, now: Timestamp, re: Regarding, _request: &PayloadCtd) {
        self.unsupported(now, re);
    }
}
