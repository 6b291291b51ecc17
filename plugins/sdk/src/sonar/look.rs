use backseat_units::math::wrap_360;
use backseat_units::{EastNorth, LocalFrame, Position as GlobePosition};
use serde::{Deserialize, Serialize};

use crate::{Position, SonarChannel, SonarPing, SonarSide};

/// Navigation that was older than this at the ping says too little of its place, nanoseconds: 2 s.
const OLD_NS: u64 = 2_000_000_000;

/// A side of a sidescan sonar.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// Left of the vehicle.
    Port,
    /// Right of the vehicle.
    Starboard,
}

impl Side {
    /// Both sides.
    pub const BOTH: [Self; 2] = [Self::Port, Self::Starboard];

    /// The direction abeam on this side, degrees clockwise from the heading.
    #[must_use]
    pub const fn abeam_deg(self) -> f64 {
        match self {
            Self::Port => -90.0,
            Self::Starboard => 90.0,
        }
    }
}

/// Where a sonar was at a ping.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Its place in the mission's local frame.
    pub at: EastNorth,
    /// The same place on the globe, degrees north.
    pub latitude_deg: f64,
    /// Degrees east.
    pub longitude_deg: f64,
    /// Its true heading, degrees.
    pub heading_deg: f64,
    /// Its altitude above the seabed, metres; `None` without bottom lock.
    pub altitude_m: Option<f64>,
}

impl Pose {
    /// The place abeam on a side at a ground range, metres, in the mission's local frame. The frame's north counts as
    /// true north: the two differ by less than a hundredth of a degree a kilometre from the frame's origin, but near the
    /// poles.
    #[must_use]
    pub fn beside(&self, side: Side, ground_m: f64) -> EastNorth {
        self.at.offset(wrap_360(self.heading_deg + side.abeam_deg()), ground_m)
    }

    /// A point of the mission's local frame as latitude and longitude; accurate to a few centimetres within a kilometre.
    /// Near the poles, where the frame is not defined, it is the sonar's own position.
    #[must_use]
    pub fn position_of(&self, point: EastNorth) -> Position {
        match GlobePosition::from_deg(self.latitude_deg, self.longitude_deg) {
            Ok(here) => LocalFrame::new(here).to_position(point - self.at).into(),
            Err(_) => Position {
                latitude: self.latitude_deg,
                longitude: self.longitude_deg,
            },
        }
    }
}

/// The samples of one side of a ping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strip<'a> {
    /// The amplitudes, in order of range.
    pub samples: &'a [f32],
    /// Range of the begin of the first sample, metres.
    pub start_m: f64,
    /// Range of the end of the last sample, metres.
    pub end_m: f64,
    /// The samples are spaced along the ground; if false, along the slant range.
    pub over_ground: bool,
    /// What one step of the samples is, in units that are the same in all pings: volts, or 1.
    pub step: f32,
}

impl<'a> Strip<'a> {
    /// Samples that divide the slant range from 0 to `range_m` evenly, in steps that are the same in all pings.
    #[must_use]
    pub const fn along_slant(samples: &'a [f32], range_m: f64) -> Self {
        Self {
            samples,
            start_m: 0.0,
            end_m: range_m,
            over_ground: false,
            step: 1.0,
        }
    }

    /// The samples of a channel. `None` if the channel has none, or if its figures cannot be true.
    #[must_use]
    pub fn of(channel: &'a SonarChannel) -> Option<Self> {
        // The range is that of the end of the last sample. What the first sample's time is of the last one's, its range
        // is too, whatever the speed of sound.
        let begin = channel.start_ns as f64;
        let end = begin + channel.sample_ns * channel.samples.len() as f64;
        let is_true = channel.range.is_finite() && channel.range > 0.0 && end > begin && end.is_finite();
        (is_true && !channel.samples.is_empty()).then(|| Self {
            samples: &channel.samples,
            start_m: channel.range * begin / end,
            end_m: channel.range,
            over_ground: channel.ground_range,
            step: channel
                .volts_per_step
                .filter(|step| step.is_finite() && *step > 0.0)
                .unwrap_or(1.0),
        })
    }

    /// The range that one sample takes, metres.
    #[must_use]
    pub fn sample_m(&self) -> f64 {
        (self.end_m - self.start_m) / self.samples.len().max(1) as f64
    }
}

/// A sidescan ping with its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look<'a> {
    /// Where the sonar was.
    pub pose: Pose,
    /// What it heard to port.
    pub port: Option<Strip<'a>>,
    /// What it heard to starboard.
    pub starboard: Option<Strip<'a>>,
}

impl<'a> Look<'a> {
    /// A ping as the runtime gives it. Its navigation is older than the ping, so the place is moved on by the velocity
    /// of that navigation. `None` if the ping has no navigation, or only one that is over 2 s older: then nobody knows
    /// where it looked.
    #[must_use]
    pub fn of(ping: &'a SonarPing) -> Option<Self> {
        let navigation = ping.navigation.as_ref()?;
        if navigation.before_ping_ns > OLD_NS {
            return None;
        }
        let since_s = navigation.before_ping_ns as f64 * 1e-9;
        let way = match (navigation.velocity_east, navigation.velocity_north) {
            (Some(east_mps), Some(north_mps)) => EastNorth::new(east_mps, north_mps) * since_s,
            (Some(_) | None, None) | (None, Some(_)) => EastNorth::default(),
        };
        let then = EastNorth::new(navigation.east, navigation.north);
        let mut pose = Pose {
            at: then,
            latitude_deg: navigation.position.latitude,
            longitude_deg: navigation.position.longitude,
            heading_deg: navigation.heading,
            altitude_m: navigation.altitude.filter(|altitude_m| *altitude_m > 0.0),
        };
        let position = pose.position_of(then + way);
        pose.at = then + way;
        (pose.latitude_deg, pose.longitude_deg) = (position.latitude, position.longitude);
        let side = |side: SonarSide| {
            let channel = ping.channels.iter().find(|channel| channel.side == side);
            channel.and_then(Strip::of)
        };
        Some(Self {
            pose,
            port: side(SonarSide::Port),
            starboard: side(SonarSide::Starboard),
        })
    }

    /// The samples of a side.
    #[must_use]
    pub const fn side(&self, side: Side) -> Option<&Strip<'a>> {
        match side {
            Side::Port => self.port.as_ref(),
            Side::Starboard => self.starboard.as_ref(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Decimation, PingNavigation, PingTime};

    fn ping(before_ping_ns: u64) -> SonarPing {
        SonarPing {
            age_ns: 0,
            time_source: PingTime::Measured,
            sensor: 2,
            number: 1,
            decimation: Decimation::Mean,
            channels: vec![SonarChannel {
                side: SonarSide::Starboard,
                ground_range: false,
                range: 75.0,
                start_ns: 10_000_000,
                sample_ns: 90_000.0,
                recorded: 1000,
                volts_per_step: Some(0.25),
                samples: vec![1.0; 1000],
            }],
            navigation: Some(PingNavigation {
                before_ping_ns,
                position: Position {
                    latitude: 42.0,
                    longitude: -70.0,
                },
                east: 100.0,
                north: 50.0,
                depth: 20.0,
                altitude: Some(0.0),
                heading: 90.0,
                roll: 0.0,
                pitch: 0.0,
                velocity_east: Some(1.5),
                velocity_north: Some(0.0),
            }),
        }
    }

    #[test]
    fn the_place_of_a_ping_is_moved_on_from_its_navigation() {
        let ping = ping(400_000_000);
        let look = Look::of(&ping).unwrap();
        assert!(look.pose.at.distance_m(EastNorth::new(100.6, 50.0)) < 1e-9);
        assert!(look.pose.longitude_deg > -70.0 && (look.pose.latitude_deg - 42.0).abs() < 1e-6);
        assert_eq!(look.pose.altitude_m, None, "an altitude of 0 is none");
        assert!(look.port.is_none());
        let strip = look.starboard.unwrap();
        assert!((strip.start_m - 7.5).abs() < 1e-9 && strip.step == 0.25);
        assert!((strip.sample_m() - 0.0675).abs() < 1e-9);
        let abeam = look.pose.beside(Side::Starboard, 30.0);
        assert!(abeam.distance_m(EastNorth::new(100.6, 20.0)) < 1e-9, "{abeam:?}");
    }

    #[test]
    fn a_ping_without_a_place_is_no_look() {
        assert!(Look::of(&ping(2_100_000_000)).is_none());
        let mut lost = ping(0);
        lost.navigation = None;
        assert!(Look::of(&lost).is_none());
        let mut odd = ping(0);
        odd.channels[0].range = f64::NAN;
        assert!(Look::of(&odd).unwrap().starboard.is_none());
    }
}
