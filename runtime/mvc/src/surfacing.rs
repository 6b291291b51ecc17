use core::time::Duration;

use backseat_spi::GpsHit;
use backseat_units::Timestamp;
use backseat_world::Stream;

use crate::answers::Regarding;
use crate::file::WorldFile;
use crate::insert::Insert;
use crate::mvc::Mvc;
use crate::plan::GpsTimes;
use crate::requests::Work;

/// GPS hits (SPI 7.7): how long they take.
#[derive(Debug)]
pub(crate) struct Surfacing {
    times: GpsTimes,
}

impl Surfacing {
    pub(crate) fn new(file: &WorldFile, seed: u64) -> Self {
        let fix_s = file.mission.gps_fix_s.draw(&mut Stream::new(seed, "gps fix"));
        Self {
            times: GpsTimes {
                fix: Duration::from_secs_f64(fix_s),
                within: Duration::from_secs_f64(file.mission.gps_within_s),
            },
        }
    }
}

impl Mvc {
    /// BPRGP. Its section does not say that it may be pending: the outcome comes at once (SPI 4.4).
    pub(crate) fn gps_hit(&mut self, now: Timestamp, re: Regarding, request: &GpsHit) {
        let re = Regarding {
            behavior: Some(request.identifier),
            ..re
        };
        let cruise = self.executive.cruise();
        match Insert::gps_hit(re.client, request, self.frame(), self.surfacing.times, cruise) {
            Ok(insert) if insert.id.get() == 0 => self.invalid(now, re, "identifier 0: expected 1 or more"),
            Ok(insert) => self.decide(now, re, Work::Insert(insert)),
            Err(text) => self.invalid(now, re, &text),
        }
    }
}
