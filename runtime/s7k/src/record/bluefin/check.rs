//! What a record 3100 must be before it is passed on: 2.4, appendix B, and the room that public readers have.

use super::{
    BluefinData, BluefinDataType, BluefinFormat, BluefinFrame, BluefinFrameHeader, BluefinHeader, BluefinRecord,
    EnvironmentField, EnvironmentFrame, FRAME, NavigationField, NavigationFrame,
};

/// Why a record of vehicle data is not one that Volume III allows, although its frames can be told apart.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum BluefinFault {
    /// There are more frames than a public reader has room for.
    #[error("field frames: {frames} is outside 0 to {}", BluefinRecord::FRAMES_MAX)]
    Frames {
        /// Frames that the header says.
        frames: u32,
    },
    /// The frames have not the one size that a header and 96 bytes of data make.
    #[error("field frame_size: {size} bytes, expected {FRAME}")]
    FrameSize {
        /// The size that the header says, bytes.
        size: u32,
    },
    /// The record's data format is neither navigation nor environment.
    #[error("field data_format: {format} is neither 0 nor 1")]
    Format {
        /// The format found.
        format: u32,
    },
    /// Bytes follow the last frame.
    #[error("{bytes} bytes follow the last frame")]
    Rest {
        /// How many.
        bytes: usize,
    },
    /// A part of a frame's header is not what the record's header says.
    #[error("frame {frame} field {field}: {found}, expected {expected}")]
    Header {
        /// The frame, from 0.
        frame: usize,
        /// The field.
        field: &'static str,
        /// What is in it.
        found: u32,
        /// What belongs there.
        expected: u32,
    },
    /// A frame's time is none.
    #[error("frame {frame} field time: this is no time")]
    Time {
        /// The frame, from 0.
        frame: usize,
    },
    /// A value that the frame calls valid is no number, or outside its range.
    #[error("frame {frame} field {field}: {value} is outside its range")]
    Value {
        /// The frame, from 0.
        frame: usize,
        /// The field.
        field: &'static str,
        /// The value found.
        value: f64,
    },
}

impl BluefinRecord<'_> {
    /// Checks what Volume III (2.4, appendix B) says of the record and of each of its frames, and that there are at most
    /// [`Self::FRAMES_MAX`]. Files are read without it: see [`Self::frames`].
    ///
    /// # Errors
    /// [`BluefinFault`] names the frame and the field.
    pub fn check(&self) -> Result<(), BluefinFault> {
        let BluefinHeader {
            frames,
            frame_size: size,
            data_format,
            ..
        } = self.header;
        let data_type = match data_format {
            BluefinFormat::Navigation => BluefinDataType::Navigation,
            BluefinFormat::Environment => BluefinDataType::Environment,
            BluefinFormat::Other(format) => return Err(BluefinFault::Format { format }),
        };
        if frames as usize > Self::FRAMES_MAX {
            return Err(BluefinFault::Frames { frames });
        }
        if frames > 0 && size as usize != FRAME {
            return Err(BluefinFault::FrameSize { size });
        }
        if !self.rest.is_empty() {
            return Err(BluefinFault::Rest { bytes: self.rest.len() });
        }
        let mut frames = self.frames().enumerate();
        frames.try_for_each(|(number, frame)| frame.check(number, data_type))
    }
}

impl BluefinFrame<'_> {
    fn check(&self, frame: usize, data_type: BluefinDataType) -> Result<(), BluefinFault> {
        let header = &self.header;
        for (field, found, expected) in [
            ("packet_size", header.packet_size, FRAME as u32),
            ("offset", u32::from(header.offset), BluefinFrameHeader::SIZE as u32),
            ("data_type", header.data_type.code(), data_type.code()),
            ("data_size", header.data_size, NavigationFrame::SIZE as u32),
        ] {
            if found != expected {
                return Err(BluefinFault::Header {
                    frame,
                    field,
                    found,
                    expected,
                });
            }
        }
        if header.time.to_utc().is_none() {
            return Err(BluefinFault::Time { frame });
        }
        let values = match &self.data {
            BluefinData::Navigation(navigation) => navigation.valid_values(),
            BluefinData::Environment(environment) => environment.valid_values(),
            BluefinData::Other(_) => Vec::new(),
        };
        // Not-a-number is in no range.
        let wrong = values
            .into_iter()
            .find(|(_, value, most)| !(-most..=*most).contains(value));
        wrong.map_or(Ok(()), |(field, value, _)| {
            Err(BluefinFault::Value { frame, field, value })
        })
    }
}

impl NavigationFrame {
    /// The values that the frame calls valid: field, value, and the greatest absolute value that it may have.
    fn valid_values(&self) -> Vec<(&'static str, f64, f64)> {
        use core::f64::consts::{FRAC_PI_2, PI};

        use NavigationField as Field;
        let all = [
            (Field::Latitude, "latitude_rad", self.latitude_rad, FRAC_PI_2),
            (Field::Longitude, "longitude_rad", self.longitude_rad, PI),
            (Field::Speed, "speed_mps", f64::from(self.speed_mps), f64::MAX),
            (Field::Depth, "depth_m", self.depth_m, f64::MAX),
            (Field::Altitude, "altitude_m", self.altitude_m, f64::MAX),
            (Field::Roll, "roll_rad", f64::from(self.roll_rad), f64::MAX),
            (Field::Pitch, "pitch_rad", f64::from(self.pitch_rad), f64::MAX),
            (Field::Yaw, "yaw_rad", f64::from(self.yaw_rad), f64::MAX),
            (
                Field::NorthingRate,
                "northing_rate_mps",
                f64::from(self.northing_rate_mps),
                f64::MAX,
            ),
            (
                Field::EastingRate,
                "easting_rate_mps",
                f64::from(self.easting_rate_mps),
                f64::MAX,
            ),
            (
                Field::DepthRate,
                "depth_rate_mps",
                f64::from(self.depth_rate_mps),
                f64::MAX,
            ),
            (
                Field::AltitudeRate,
                "altitude_rate_mps",
                f64::from(self.altitude_rate_mps),
                f64::MAX,
            ),
            (
                Field::RollRate,
                "roll_rate_radps",
                f64::from(self.roll_rate_radps),
                f64::MAX,
            ),
            (
                Field::PitchRate,
                "pitch_rate_radps",
                f64::from(self.pitch_rate_radps),
                f64::MAX,
            ),
            (
                Field::YawRate,
                "yaw_rate_radps",
                f64::from(self.yaw_rate_radps),
                f64::MAX,
            ),
            (Field::PositionTime, "position_time_s", self.position_time_s, f64::MAX),
            (Field::AttitudeTime, "attitude_time_s", self.attitude_time_s, f64::MAX),
        ];
        let valid = |(field, name, value, most)| self.quality.contains(field).then_some((name, value, most));
        all.into_iter().filter_map(valid).collect()
    }
}

impl EnvironmentFrame {
    fn valid_values(&self) -> Vec<(&'static str, f64, f64)> {
        let value = ("sound_speed_mps", f64::from(self.sound_speed_mps), 10_000.0);
        let valid = self.quality.contains(EnvironmentField::SoundSpeed);
        valid.then_some(value).into_iter().collect()
    }
}
