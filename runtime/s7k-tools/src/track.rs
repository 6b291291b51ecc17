//! Where the vehicle was: the navigation of records 3100, thinned out so that memory stays bounded.

use backseat_s7k::record::{BluefinData, EnvironmentField, NavigationField, NavigationFrame, Record};
use backseat_units::math::{PI, TAU};

use crate::error::Error;
use crate::moment::Moment;
use crate::source::Source;

/// Navigation at an instant. What is not valid is missing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Pose {
    /// Latitude and longitude.
    pub(crate) position_deg: Option<(f64, f64)>,
    /// True heading.
    pub(crate) heading_deg: Option<f64>,
    /// Altitude above the seabed.
    pub(crate) altitude_m: Option<f64>,
    /// Depth.
    pub(crate) depth_m: Option<f64>,
    /// Speed.
    pub(crate) speed_mps: Option<f64>,
    /// Roll.
    pub(crate) roll_deg: Option<f64>,
    /// Pitch.
    pub(crate) pitch_deg: Option<f64>,
}

/// A solution; NaN stands for a value that is not valid.
#[derive(Clone, Copy, Debug)]
struct Fix {
    nanos: u64,
    latitude_rad: f64,
    longitude_rad: f64,
    yaw_rad: f32,
    altitude_m: f32,
    depth_m: f32,
    speed_mps: f32,
    roll_rad: f32,
    pitch_rad: f32,
}

/// The navigation of a recording.
#[derive(Debug, Default)]
pub(crate) struct Track {
    fixes: Vec<Fix>,
    /// The first valid speed of sound of the recording.
    pub(crate) sound_speed_mps: Option<f64>,
}

/// The most solutions that are kept. Beyond, every second one goes, and the others are twice as far apart.
const FIXES_MAX: usize = 1 << 20;
/// The least time between solutions that are kept, until there are too many.
const SPACING_NANOS: u64 = 100_000_000;
/// Nothing is interpolated between solutions that are farther apart.
const GAP_NANOS: u64 = 5_000_000_000;
/// The first and the last solution serve for as long before and behind.
const HOLD_NANOS: u64 = 1_000_000_000;

impl Track {
    /// Reads all navigation of a recording.
    pub(crate) fn read(source: &Source) -> Result<Self, Error> {
        let mut track = Self::default();
        let mut spacing = SPACING_NANOS;
        source.each_record(|_, frame| {
            if frame.header().record_type != 3100 {
                return Ok(());
            }
            let Ok(Record::Bluefin(record)) = Record::read(frame) else {
                return Ok(());
            };
            for data in record.frames() {
                let time = Moment::of(&data.header.time).or_else(|| Moment::of(&frame.header().time));
                match (data.data, time) {
                    (BluefinData::Navigation(navigation), Some(time)) => track.add(&navigation, time, &mut spacing),
                    (BluefinData::Environment(environment), _)
                        if environment.quality.contains(EnvironmentField::SoundSpeed)
                            && environment.sound_speed_mps > 0.0 =>
                    {
                        track
                            .sound_speed_mps
                            .get_or_insert(f64::from(environment.sound_speed_mps));
                    }
                    (BluefinData::Navigation(_) | BluefinData::Environment(_) | BluefinData::Other(_), _) => {}
                }
            }
            Ok(())
        })?;
        track.fixes.sort_by_key(|fix| fix.nanos);
        Ok(track)
    }

    fn add(&mut self, navigation: &NavigationFrame, time: Moment, spacing: &mut u64) {
        let nanos = time.nanos();
        if self
            .fixes
            .last()
            .is_some_and(|last| nanos.abs_diff(last.nanos) < *spacing)
        {
            return;
        }
        let valid = |field: NavigationField| navigation.quality.contains(field);
        let wide = |field, value: f64| if valid(field) { value } else { f64::NAN };
        let narrow = |field, value: f32| if valid(field) { value } else { f32::NAN };
        #[expect(clippy::cast_possible_truncation, reason = "depth and altitude to 1 mm")]
        self.fixes.push(Fix {
            nanos,
            latitude_rad: wide(NavigationField::Latitude, navigation.latitude_rad),
            longitude_rad: wide(NavigationField::Longitude, navigation.longitude_rad),
            yaw_rad: narrow(NavigationField::Yaw, navigation.yaw_rad),
            altitude_m: wide(NavigationField::Altitude, navigation.altitude_m) as f32,
            depth_m: wide(NavigationField::Depth, navigation.depth_m) as f32,
            speed_mps: narrow(NavigationField::Speed, navigation.speed_mps),
            roll_rad: narrow(NavigationField::Roll, navigation.roll_rad),
            pitch_rad: narrow(NavigationField::Pitch, navigation.pitch_rad),
        });
        if self.fixes.len() >= FIXES_MAX {
            let mut keep = false;
            self.fixes.retain(|_| {
                keep = !keep;
                keep
            });
            *spacing *= 2;
        }
    }

    /// The navigation at an instant, interpolated between the solutions around it.
    pub(crate) fn at(&self, time: Moment) -> Pose {
        let nanos = time.nanos();
        let behind = self.fixes.partition_point(|fix| fix.nanos <= nanos);
        let after = self.fixes.get(behind);
        let before = behind.checked_sub(1).and_then(|index| self.fixes.get(index));
        match (before, after) {
            (Some(before), Some(after)) if after.nanos - before.nanos <= GAP_NANOS => {
                #[expect(clippy::cast_precision_loss, reason = "at most 5e9")]
                let part = (nanos - before.nanos) as f64 / (after.nanos - before.nanos) as f64;
                between(before, after, part)
            }
            (Some(fix), _) if nanos - fix.nanos <= HOLD_NANOS => between(fix, fix, 0.0),
            (_, Some(fix)) if fix.nanos - nanos <= HOLD_NANOS => between(fix, fix, 0.0),
            _ => Pose::default(),
        }
    }
}

fn between(a: &Fix, b: &Fix, part: f64) -> Pose {
    let straight = |a: f64, b: f64| Some(a + (b - a) * part).filter(|value| value.is_finite());
    let narrow = |a: f32, b: f32| straight(f64::from(a), f64::from(b));
    // The shorter way round.
    let turn = |a: f64, b: f64| {
        let step = (b - a + PI).rem_euclid(TAU) - PI;
        Some(a + step * part).filter(|value| value.is_finite())
    };
    let latitude = straight(a.latitude_rad, b.latitude_rad)
        .map(f64::to_degrees)
        .filter(|deg| deg.abs() <= 90.0);
    let longitude = turn(a.longitude_rad, b.longitude_rad).map(|rad| backseat_units::math::wrap_180(rad.to_degrees()));
    Pose {
        position_deg: latitude.zip(longitude),
        heading_deg: turn(f64::from(a.yaw_rad), f64::from(b.yaw_rad))
            .map(|rad| backseat_units::math::wrap_360(rad.to_degrees())),
        altitude_m: narrow(a.altitude_m, b.altitude_m).filter(|altitude| *altitude > 0.0),
        depth_m: narrow(a.depth_m, b.depth_m),
        speed_mps: narrow(a.speed_mps, b.speed_mps),
        roll_deg: narrow(a.roll_rad, b.roll_rad).map(f64::to_degrees),
        pitch_deg: narrow(a.pitch_rad, b.pitch_rad).map(f64::to_degrees),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fix(seconds: u64, longitude_deg: f64, yaw_deg: f32) -> Fix {
        Fix {
            nanos: seconds * 1_000_000_000,
            latitude_rad: 0.5,
            longitude_rad: longitude_deg.to_radians(),
            yaw_rad: yaw_deg.to_radians(),
            altitude_m: f32::NAN,
            depth_m: 10.0,
            speed_mps: 1.0,
            roll_rad: 0.0,
            pitch_rad: 0.0,
        }
    }

    fn at(track: &Track, millis: u64) -> Pose {
        track.at(Moment(backseat_units::Utc::from_unix_nanos(millis * 1_000_000)))
    }

    #[test]
    fn headings_and_longitudes_take_the_shorter_way_round() {
        let track = Track {
            fixes: vec![fix(10, 179.0, 350.0), fix(12, -179.0, 10.0)],
            sound_speed_mps: None,
        };
        let pose = at(&track, 11_500);
        let (latitude, longitude) = pose.position_deg.unwrap();
        assert!(
            (latitude - 0.5_f64.to_degrees()).abs() < 1e-9 && (longitude + 179.5).abs() < 1e-9,
            "{pose:?}"
        );
        assert!((pose.heading_deg.unwrap() - 5.0).abs() < 1e-4, "{pose:?}");
        assert_eq!((pose.altitude_m, pose.depth_m), (None, Some(10.0)));
    }

    #[test]
    fn nothing_is_made_up_over_a_gap_or_far_from_the_ends() {
        let track = Track {
            fixes: vec![fix(10, 1.0, 0.0), fix(20, 2.0, 0.0)],
            sound_speed_mps: None,
        };
        assert!(at(&track, 9_100).position_deg.is_some());
        assert!(at(&track, 10_900).position_deg.is_some());
        for millis in [8_900, 11_100, 15_000, 21_100] {
            assert_eq!(at(&track, millis), Pose::default(), "{millis}");
        }
        assert_eq!(at(&Track::default(), 1), Pose::default());
    }

    #[test]
    fn a_long_track_is_thinned_and_stays_a_track() {
        let mut track = Track::default();
        let mut spacing = SPACING_NANOS;
        let navigation = NavigationFrame {
            quality: backseat_s7k::record::NavigationQuality(u32::MAX),
            ..NavigationFrame::default()
        };
        for tenth in 0..(FIXES_MAX as u64 + 10) {
            let time = Moment(backseat_units::Utc::from_unix_nanos(tenth * SPACING_NANOS));
            track.add(&navigation, time, &mut spacing);
        }
        assert_eq!(spacing, 2 * SPACING_NANOS);
        assert!(track.fixes.len() < FIXES_MAX / 2 + 10);
        assert!(track.fixes.is_sorted_by_key(|fix| fix.nanos));
        assert!(at(&track, 50_000_000).position_deg.is_some());
    }
}
