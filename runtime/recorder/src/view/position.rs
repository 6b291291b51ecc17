use std::time::Duration;

use backseat_core::plugin::NavigationSample;
use serde::Serialize;

use super::{Batch, Moment, Topic};
use crate::decimation::Decimation;

/// A time as Foxglove's schemas have it.
#[derive(Serialize)]
pub(super) struct Time {
    sec: u64,
    nsec: u64,
}

impl Time {
    pub(super) const fn from_nanos(nanos: u64) -> Self {
        Self {
            sec: nanos / 1_000_000_000,
            nsec: nanos % 1_000_000_000,
        }
    }
}

#[derive(Serialize)]
struct Fix {
    timestamp: Time,
    frame_id: &'static str,
    latitude: f64,
    longitude: f64,
    altitude: f64,
    position_covariance: [u8; 9],
    position_covariance_type: u8,
    heading: f64,
}

/// `/position`: where the vehicle is, as the safety monitor sees it. Once a second is enough for a map, and `/navigation`
/// has the rest.
pub(super) struct Fixes {
    due: Decimation,
}

impl Fixes {
    pub(super) const fn new() -> Self {
        Self {
            due: Decimation::new(Duration::from_secs(1)),
        }
    }

    /// Navigation was recorded, with a solution of this UTC.
    pub(super) fn navigated(&mut self, moment: Moment, solution_ns: u64, sample: &NavigationSample, batch: &mut Batch) {
        if !self.due.take(moment.now) {
            return;
        }
        let fix = Fix {
            timestamp: Time::from_nanos(solution_ns),
            frame_id: "vehicle",
            latitude: sample.position.latitude.as_deg(),
            longitude: sample.position.longitude.as_deg(),
            // Not the negative, which would be -0 at the surface.
            altitude: 0.0 - sample.depth.as_m(),
            // SPI does not tell it: unknown.
            position_covariance: [0; 9],
            position_covariance_type: 0,
            heading: sample.heading.as_deg().to_radians(),
        };
        batch.add(Topic::Position, |out| {
            serde_json::to_writer(out, &fix).expect("a Vec takes every number");
        });
    }
}
