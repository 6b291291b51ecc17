//! What the controller knows of the vehicle: the latest of what its clients sent in records 3100.

use backseat_s7k::BluefinChecksum;
use backseat_s7k::record::{
    BluefinData, BluefinRecord, EnvironmentField, NavigationField, NavigationFrame, NavigationQuality,
};
use backseat_units::{Position, Timestamp};

/// What a client said of the vehicle in the newest navigation frame. A value that is not valid or not finite is `None`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reported {
    /// When the record arrived.
    pub received: Timestamp,
    /// Its position.
    pub position: Option<Position>,
    /// Its depth, m.
    pub depth_m: Option<f64>,
    /// Its true heading, degrees.
    pub heading_deg: Option<f64>,
    /// Its pitch, degrees, bow up.
    pub pitch_deg: Option<f64>,
    /// Its roll, degrees, starboard down.
    pub roll_deg: Option<f64>,
    /// Its velocity to the north, m/s.
    pub north_mps: Option<f64>,
    /// Its velocity to the east, m/s.
    pub east_mps: Option<f64>,
    /// Its velocity downwards, m/s.
    pub down_mps: Option<f64>,
}

/// The vehicle's navigation and the speed of sound.
#[derive(Debug)]
pub(crate) struct Navigation {
    latest: Option<NavigationFrame>,
    received: Timestamp,
    sound_speed_mps: f64,
    checksum: BluefinChecksum,
    wrong_checksums: u64,
}

impl Navigation {
    pub(crate) const fn new(sound_speed_mps: f64, checksum: BluefinChecksum) -> Self {
        Self {
            latest: None,
            received: Timestamp::ZERO,
            sound_speed_mps,
            checksum,
            wrong_checksums: 0,
        }
    }

    /// Takes the last frame of each kind. A frame's wrong checksum is counted and not more, because the specification
    /// does not say how it is computed.
    pub(crate) fn take(&mut self, now: Timestamp, record: &BluefinRecord<'_>) {
        for frame in record.frames() {
            if frame.checksum_matches(self.checksum) == Some(false) {
                self.wrong_checksums += 1;
            }
            match frame.data {
                BluefinData::Navigation(navigation) => {
                    (self.latest, self.received) = (Some(navigation), now);
                }
                BluefinData::Environment(environment) => {
                    let speed = f64::from(environment.sound_speed_mps);
                    // Outside of this no water is, and a sonar keeps what it has.
                    if environment.quality.contains(EnvironmentField::SoundSpeed) && (1300.0..=1700.0).contains(&speed)
                    {
                        self.sound_speed_mps = speed;
                    }
                }
                BluefinData::Other(_) => {}
            }
        }
    }

    /// The speed of sound, m/s, 1300 to 1700.
    pub(crate) const fn sound_speed_mps(&self) -> f64 {
        self.sound_speed_mps
    }

    /// How many frames had a wrong checksum.
    pub(crate) const fn wrong_checksums(&self) -> u64 {
        self.wrong_checksums
    }

    /// A value that is valid and finite.
    fn value(&self, field: NavigationField, value: impl Fn(&NavigationFrame) -> f64) -> Option<f64> {
        let frame = self.latest.as_ref()?;
        let quality: NavigationQuality = frame.quality;
        Some(value(frame)).filter(|value| quality.contains(field) && value.is_finite())
    }

    /// Roll, pitch and heading, degrees; 0 for what is not known.
    pub(crate) fn attitude_deg(&self) -> (f64, f64, f64) {
        let roll = self.value(NavigationField::Roll, |frame| f64::from(frame.roll_rad));
        let pitch = self.value(NavigationField::Pitch, |frame| f64::from(frame.pitch_rad));
        let yaw = self.value(NavigationField::Yaw, |frame| f64::from(frame.yaw_rad));
        let degrees = |angle: Option<f64>| angle.unwrap_or(0.0).to_degrees();
        (degrees(roll), degrees(pitch), degrees(yaw))
    }

    /// What clients said of the vehicle; `None` before a navigation frame.
    pub(crate) fn reported(&self) -> Option<Reported> {
        use NavigationField as Field;
        self.latest?;
        let degrees = |field, angle: fn(&NavigationFrame) -> f32| {
            let angle = self.value(field, |frame| f64::from(angle(frame)));
            angle.map(f64::to_degrees)
        };
        let speed = |field, value: fn(&NavigationFrame) -> f32| self.value(field, |frame| f64::from(value(frame)));
        let position = self.position_deg();
        Some(Reported {
            received: self.received,
            position: position.and_then(|(latitude, longitude)| Position::from_deg(latitude, longitude).ok()),
            depth_m: self.value(Field::Depth, |frame| frame.depth_m),
            heading_deg: degrees(Field::Yaw, |frame| frame.yaw_rad),
            pitch_deg: degrees(Field::Pitch, |frame| frame.pitch_rad),
            roll_deg: degrees(Field::Roll, |frame| frame.roll_rad),
            north_mps: speed(Field::NorthingRate, |frame| frame.northing_rate_mps),
            east_mps: speed(Field::EastingRate, |frame| frame.easting_rate_mps),
            down_mps: speed(Field::DepthRate, |frame| frame.depth_rate_mps),
        })
    }

    /// Depth, m; 0 if it is not known.
    pub(crate) fn depth_m(&self) -> f64 {
        self.value(NavigationField::Depth, |frame| frame.depth_m).unwrap_or(0.0)
    }

    /// Latitude and longitude, degrees, if both are known.
    pub(crate) fn position_deg(&self) -> Option<(f64, f64)> {
        let latitude = self.value(NavigationField::Latitude, |frame| frame.latitude_rad)?;
        let longitude = self.value(NavigationField::Longitude, |frame| frame.longitude_rad)?;
        Some((latitude.to_degrees(), longitude.to_degrees()))
    }
}
