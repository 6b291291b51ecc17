//! What the vehicle tells, on its way to the controller: frames of navigation and of environment (record 3100).

use std::collections::VecDeque;
use std::time::Duration;

use backseat_s7k::Time7k;
use backseat_s7k::record::{
    BluefinRecord, EnvironmentField, EnvironmentFrame, EnvironmentQuality, NavigationField, NavigationFrame,
    NavigationQuality,
};
use backseat_units::{Altitude, Depth, Heading, Position, Timestamp, Utc};
use serde::{Deserialize, Serialize};

use crate::config::NavigationTimes;

/// How long the oldest frame waits for others. With the way to the socket it stays under [`AGE_MAX`].
pub(crate) const GATHER: Duration = Duration::from_millis(900);
/// An older frame is not sent.
pub(crate) const AGE_MAX: Duration = Duration::from_secs(1);
/// How many solutions are kept for the time of a ping: over six seconds at 10 Hz.
const HISTORY_MAX: usize = 64;

/// A navigation solution of the vehicle: a BFNVG, with the BFNVR of the same time if there is one (SPI 6.1, 6.2).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct VehicleNavigation {
    /// When the solution was computed, on our clock.
    pub solution: Utc,
    /// WGS84.
    pub position: Position,
    /// Below the surface.
    pub depth: Depth,
    /// Above the seabed; `None` without bottom lock.
    pub altitude: Option<Altitude>,
    /// True heading.
    pub heading: Heading,
    /// Degrees, starboard down positive.
    pub roll_deg: f64,
    /// Degrees, nose up positive.
    pub pitch_deg: f64,
    /// Velocities and rates; `None` without a BFNVR.
    pub rates: Option<VehicleRates>,
}

/// The vehicle's velocities over the ground and its angular rates (BFNVR, SPI 6.2).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct VehicleRates {
    /// East, m/s.
    pub east_mps: f64,
    /// North, m/s.
    pub north_mps: f64,
    /// Down, m/s.
    pub down_mps: f64,
    /// Degrees per second.
    pub roll_rate_dps: f64,
    /// Degrees per second.
    pub pitch_rate_dps: f64,
    /// Degrees per second.
    pub yaw_rate_dps: f64,
}

/// The speed of sound (BFSVS, SPI 6.4).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct VehicleSoundSpeed {
    /// When it was measured, on our clock.
    pub time: Utc,
    /// Metres per second, over 0 to 10000.
    pub sound_speed_mps: f64,
}

/// Frames that wait to leave in one record, with the times of their arrival.
#[derive(Debug)]
pub(crate) struct Gathered<T> {
    frames: Vec<(Time7k, T)>,
    arrived: Vec<Timestamp>,
}

impl<T> Default for Gathered<T> {
    fn default() -> Self {
        Self {
            frames: Vec::with_capacity(BluefinRecord::FRAMES_MAX),
            arrived: Vec::with_capacity(BluefinRecord::FRAMES_MAX),
        }
    }
}

impl<T> Gathered<T> {
    pub(crate) fn push(&mut self, now: Timestamp, time: Time7k, frame: T) {
        self.frames.push((time, frame));
        self.arrived.push(now);
    }

    pub(crate) const fn is_full(&self) -> bool {
        self.frames.len() >= BluefinRecord::FRAMES_MAX
    }

    /// When the frames must leave.
    pub(crate) fn due(&self) -> Option<Timestamp> {
        self.arrived.first().map(|first| *first + GATHER)
    }

    /// Drops the frames that are too old, and returns how many.
    pub(crate) fn drop_old(&mut self, now: Timestamp) -> usize {
        // They are in the order of their arrival.
        let old = self.arrived.partition_point(|arrived| now.since(*arrived) > AGE_MAX);
        self.frames.drain(..old);
        self.arrived.drain(..old);
        old
    }

    /// The frames, and the arrival of the first one.
    pub(crate) fn frames(&self) -> Option<(&[(Time7k, T)], Timestamp)> {
        self.arrived.first().map(|first| (&self.frames[..], *first))
    }

    pub(crate) fn clear(&mut self) {
        self.frames.clear();
        self.arrived.clear();
    }
}

/// Frames on their way, and what is needed at the time of a ping.
#[derive(Debug, Default)]
pub(crate) struct Vehicle {
    pub(crate) navigation: Gathered<NavigationFrame>,
    pub(crate) environment: Gathered<EnvironmentFrame>,
    history: VecDeque<VehicleNavigation>,
    sound_speed_mps: Option<f64>,
}

impl Vehicle {
    pub(crate) fn remember(&mut self, navigation: &VehicleNavigation) {
        if self.history.len() == HISTORY_MAX {
            self.history.pop_front();
        }
        self.history.push_back(*navigation);
    }

    pub(crate) const fn hear(&mut self, sound_speed_mps: f64) {
        self.sound_speed_mps = Some(sound_speed_mps);
    }

    /// The last solution that was not later than the time. Nothing is interpolated.
    pub(crate) fn at(&self, time: Utc) -> Option<&VehicleNavigation> {
        self.history.iter().rev().find(|known| known.solution <= time)
    }

    /// The newest solution.
    pub(crate) fn newest(&self) -> Option<&VehicleNavigation> {
        self.history.back()
    }

    /// As the vehicle told it, else 1500 m/s.
    pub(crate) fn sound_speed_mps(&self) -> f64 {
        self.sound_speed_mps.unwrap_or(1500.0)
    }

    /// The connection is gone: what waits would be old on the next one.
    pub(crate) fn forget_frames(&mut self) {
        self.navigation.clear();
        self.environment.clear();
    }
}

/// The frame of a solution. SPI tells neither the speed nor the rate of the altitude, so their quality bits are clear;
/// so are those of a value that is not finite, of the altitude without bottom lock, and of rates without a BFNVR.
pub(crate) fn navigation_frame(navigation: &VehicleNavigation, times: NavigationTimes) -> NavigationFrame {
    use NavigationField as F;
    let mut quality = NavigationQuality(0);
    let mut mark = |value: Option<f64>, field: F| match value.filter(|value| value.abs() <= f64::from(f32::MAX)) {
        Some(value) => {
            quality = quality.with(field);
            value
        }
        None => 0.0,
    };
    let rates = navigation.rates.as_ref();
    let rate = |of: fn(&VehicleRates) -> f64| rates.map(of);
    let solution_s = solution_s(navigation.solution, times);
    let frame = NavigationFrame {
        quality: NavigationQuality(0),
        latitude_rad: mark(Some(navigation.position.latitude.as_deg().to_radians()), F::Latitude),
        longitude_rad: mark(Some(navigation.position.longitude.as_deg().to_radians()), F::Longitude),
        speed_mps: narrow(mark(None, F::Speed)),
        depth_m: mark(Some(navigation.depth.as_m()), F::Depth),
        altitude_m: mark(navigation.altitude.map(Altitude::as_m), F::Altitude),
        roll_rad: narrow(mark(Some(navigation.roll_deg.to_radians()), F::Roll)),
        pitch_rad: narrow(mark(Some(navigation.pitch_deg.to_radians()), F::Pitch)),
        yaw_rad: narrow(mark(Some(navigation.heading.as_deg().to_radians()), F::Yaw)),
        northing_rate_mps: narrow(mark(rate(|rates| rates.north_mps), F::NorthingRate)),
        easting_rate_mps: narrow(mark(rate(|rates| rates.east_mps), F::EastingRate)),
        depth_rate_mps: narrow(mark(rate(|rates| rates.down_mps), F::DepthRate)),
        altitude_rate_mps: narrow(mark(None, F::AltitudeRate)),
        roll_rate_radps: narrow(mark(rate(|rates| rates.roll_rate_dps.to_radians()), F::RollRate)),
        pitch_rate_radps: narrow(mark(rate(|rates| rates.pitch_rate_dps.to_radians()), F::PitchRate)),
        yaw_rate_radps: narrow(mark(rate(|rates| rates.yaw_rate_dps.to_radians()), F::YawRate)),
        position_time_s: mark(solution_s, F::PositionTime),
        attitude_time_s: mark(solution_s, F::AttitudeTime),
    };
    NavigationFrame { quality, ..frame }
}

/// The frame of a speed of sound.
pub(crate) fn environment_frame(sound_speed_mps: f64) -> EnvironmentFrame {
    EnvironmentFrame {
        quality: EnvironmentQuality(0).with(EnvironmentField::SoundSpeed),
        sound_speed_mps: narrow(sound_speed_mps),
        reserved: backseat_s7k::Reserved([0; 88]),
    }
}

#[expect(clippy::cast_precision_loss, reason = "to a quarter of a microsecond")]
fn solution_s(solution: Utc, times: NavigationTimes) -> Option<f64> {
    match times {
        NavigationTimes::Unix => Some(solution.as_unix_nanos() as f64 / 1e9),
        NavigationTimes::Day => Some(solution.time_of_day().as_nanos() as f64 / 1e9),
        NavigationTimes::Invalid => None,
    }
}

#[expect(clippy::cast_possible_truncation, reason = "the frame has 32 bits for it")]
const fn narrow(value: f64) -> f32 {
    value as f32
}
