//! Data from a Bluefin vehicle (3100): frames of navigation and of environment (2.4, appendix B).

mod check;

use super::{RecordError, RecordFault};
use crate::checksum::{BluefinChecksum, crc32};
use crate::layout::{Range, layouts};
use crate::time::Time7k;
use crate::wire::{Reserved, Wire, codes};

pub use check::BluefinFault;

codes! {
    /// What a record's frames hold, as its record type header says it.
    pub enum BluefinFormat: u32 {
        /// Navigation.
        0 Navigation,
        /// Environment.
        1 Environment,
    }

    /// What a frame holds, as the frame itself says it.
    pub enum BluefinDataType: u32 {
        /// Navigation.
        1 Navigation,
        /// Environment.
        2 Environment,
    }
}

layouts! {
    /// The record type header of vehicle data.
    "Volume III, Table 7" BluefinHeader bluefin_header {
        /// A millisecond counter, at the first frame.
        time_ms: u32, "ms", Range::ANY;
        /// Number of frames. Public readers hold 25 at most.
        frames: u32, "count", Range::new(0.0, 25.0);
        /// Length of each frame.
        frame_size: u32, "bytes", Range::ANY;
        /// What the frames hold.
        data_format: BluefinFormat, "code", Range::new(0.0, 1.0);
        /// Reserved.
        reserved: Reserved<16>, "reserved", Range::ANY;
    }

    /// The header of each frame.
    "Volume III, Table 11" BluefinFrameHeader bluefin_frame_header {
        /// Length of the frame with this header.
        packet_size: u32, "bytes", Range::new(32.0, 4_294_967_295.0);
        /// Version of the frame.
        version: u16, "version", Range::ANY;
        /// Bytes from the frame's start to its data.
        offset: u16, "bytes", Range::new(32.0, 65_535.0);
        /// What the frame holds.
        data_type: BluefinDataType, "code", Range::new(1.0, 2.0);
        /// Length of the data.
        data_size: u32, "bytes", Range::ANY;
        /// Time of the data, UTC.
        time: Time7k, "UTC", Range::ANY;
        /// CRC-32. The specification does not say of what: see [`BluefinChecksum`].
        checksum: u32, "checksum", Range::ANY;
        /// Reserved.
        reserved: Reserved<2>, "reserved", Range::ANY;
    }

    /// Navigation of the vehicle.
    "Volume III, Table 12" NavigationFrame navigation_frame {
        /// Which of the fields are valid.
        quality: NavigationQuality, "bit field", Range::new(0.0, 131_071.0);
        /// Latitude.
        latitude_rad: f64, "rad", Range::new(-core::f64::consts::FRAC_PI_2, core::f64::consts::FRAC_PI_2);
        /// Longitude.
        longitude_rad: f64, "rad", Range::new(-core::f64::consts::PI, core::f64::consts::PI);
        /// Speed.
        speed_mps: f32, "m/s", Range::ANY;
        /// Depth below the surface.
        depth_m: f64, "m", Range::ANY;
        /// Altitude above the seabed.
        altitude_m: f64, "m", Range::ANY;
        /// Roll.
        roll_rad: f32, "rad", Range::new(-core::f64::consts::TAU, core::f64::consts::TAU);
        /// Pitch.
        pitch_rad: f32, "rad", Range::new(-core::f64::consts::TAU, core::f64::consts::TAU);
        /// Yaw, which is the heading.
        yaw_rad: f32, "rad", Range::new(-core::f64::consts::TAU, core::f64::consts::TAU);
        /// Velocity northwards.
        northing_rate_mps: f32, "m/s", Range::ANY;
        /// Velocity eastwards.
        easting_rate_mps: f32, "m/s", Range::ANY;
        /// Velocity downwards.
        depth_rate_mps: f32, "m/s", Range::ANY;
        /// Rate of the altitude.
        altitude_rate_mps: f32, "m/s", Range::ANY;
        /// Rate of roll.
        roll_rate_radps: f32, "rad/s", Range::ANY;
        /// Rate of pitch.
        pitch_rate_radps: f32, "rad/s", Range::ANY;
        /// Rate of yaw.
        yaw_rate_radps: f32, "rad/s", Range::ANY;
        /// Time of the position. The specification does not say since when.
        position_time_s: f64, "s", Range::ANY;
        /// Time of the attitude. The specification does not say since when.
        attitude_time_s: f64, "s", Range::ANY;
    }

    /// Environment of the vehicle.
    "Volume III, Table 14" EnvironmentFrame environment_frame {
        /// Which of the fields are valid.
        quality: EnvironmentQuality, "bit field", Range::new(0.0, 1.0);
        /// Speed of sound in water.
        sound_speed_mps: f32, "m/s", Range::new(0.0, 10_000.0);
        /// Reserved.
        reserved: Reserved<88>, "reserved", Range::ANY;
    }
}

/// Quality bits: which fields of a frame are valid.
macro_rules! qualities {
    ($(
        $(#[$doc:meta])*
        $source:literal $Quality:ident of $Field:ident { $( $(#[$field_doc:meta])* $bit:literal $Variant:ident, )* }
    )*) => { $(
        $(#[$doc])*
        ///
        #[doc = concat!("Source: ", $source, ".")]
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
        #[serde(rename_all = "snake_case")]
        pub enum $Field {
            $( $(#[$field_doc])* $Variant, )*
        }

        impl $Field {
            /// All fields, in the order of their bits.
            pub const ALL: &'static [Self] = &[$( Self::$Variant ),*];

            /// The table that numbers the bits.
            pub const SOURCE: &'static str = $source;

            /// The number of the field's bit, from the least significant.
            #[must_use]
            pub const fn bit(self) -> u32 {
                match self { $( Self::$Variant => $bit, )* }
            }
        }

        #[doc = concat!("A set of [`", stringify!($Field), "`]: the fields that are valid. Other bits are kept.")]
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub struct $Quality(pub u32);

        impl $Quality {
            /// Whether the field is valid.
            #[must_use]
            pub const fn contains(self, field: $Field) -> bool {
                self.0 >> field.bit() & 1 == 1
            }

            /// The set with the field in it.
            #[must_use]
            pub const fn with(self, field: $Field) -> Self {
                Self(self.0 | 1 << field.bit())
            }

            /// The valid fields.
            pub fn fields(self) -> impl Iterator<Item = $Field> {
                $Field::ALL.iter().copied().filter(move |field| self.contains(*field))
            }
        }

        impl serde::Serialize for $Quality {
            /// As the list of the valid fields.
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.collect_seq(self.fields())
            }
        }

        impl Wire for $Quality {
            const SIZE: usize = 4;
            const TYPE: &'static str = "u32";

            fn get(bytes: &[u8]) -> Self {
                Self(Wire::get(bytes))
            }

            fn put(&self, out: &mut Vec<u8>) {
                self.0.put(out);
            }

            fn number(&self) -> Option<f64> {
                self.0.number()
            }
        }
    )* };
}

qualities! {
    /// A field of a navigation frame that may be invalid.
    "Volume III, Table 13" NavigationQuality of NavigationField {
        /// Latitude.
        0 Latitude,
        /// Longitude.
        1 Longitude,
        /// Speed.
        2 Speed,
        /// Depth.
        3 Depth,
        /// Altitude.
        4 Altitude,
        /// Roll.
        5 Roll,
        /// Pitch.
        6 Pitch,
        /// Yaw.
        7 Yaw,
        /// Velocity northwards.
        8 NorthingRate,
        /// Velocity eastwards.
        9 EastingRate,
        /// Velocity downwards.
        10 DepthRate,
        /// Rate of the altitude.
        11 AltitudeRate,
        /// Rate of roll.
        12 RollRate,
        /// Rate of pitch.
        13 PitchRate,
        /// Rate of yaw.
        14 YawRate,
        /// Time of the position.
        15 PositionTime,
        /// Time of the attitude.
        16 AttitudeTime,
    }

    /// A field of an environment frame that may be invalid.
    "Volume III, Table 15" EnvironmentQuality of EnvironmentField {
        /// Speed of sound.
        0 SoundSpeed,
    }
}

impl Default for NavigationFrame {
    /// All zero, and nothing valid.
    fn default() -> Self {
        Self {
            quality: NavigationQuality(0),
            latitude_rad: 0.0,
            longitude_rad: 0.0,
            speed_mps: 0.0,
            depth_m: 0.0,
            altitude_m: 0.0,
            roll_rad: 0.0,
            pitch_rad: 0.0,
            yaw_rad: 0.0,
            northing_rate_mps: 0.0,
            easting_rate_mps: 0.0,
            depth_rate_mps: 0.0,
            altitude_rate_mps: 0.0,
            roll_rate_radps: 0.0,
            pitch_rate_radps: 0.0,
            yaw_rate_radps: 0.0,
            position_time_s: 0.0,
            attitude_time_s: 0.0,
        }
    }
}

/// Vehicle data, borrowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BluefinRecord<'a> {
    /// The record type header.
    pub header: BluefinHeader,
    frames: &'a [u8],
    rest: &'a [u8],
}

/// One frame of vehicle data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BluefinFrame<'a> {
    /// Its header.
    pub header: BluefinFrameHeader,
    /// Its data.
    pub data: BluefinData<'a>,
    bytes: &'a [u8],
}

/// What a frame of vehicle data holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BluefinData<'a> {
    /// Navigation.
    Navigation(NavigationFrame),
    /// Environment.
    Environment(EnvironmentFrame),
    /// Something else, or data too short for what the frame says.
    Other(&'a [u8]),
}

impl<'a> BluefinRecord<'a> {
    /// The most frames that one record may have. A public reader has room for 25 and does not check.
    pub const FRAMES_MAX: usize = 25;

    pub(super) fn read(record_type: u32, body: &'a [u8]) -> Result<Self, RecordError> {
        let fail = |at: usize, fault: RecordFault| RecordError { record_type, at, fault };
        let header = BluefinHeader::read(body).map_err(|error| fail(0, error.into()))?;
        let behind = &body[BluefinHeader::SIZE..];
        let too_short = RecordFault::List {
            list: "frames",
            count: header.frames,
            size: header.frame_size,
            found: behind.len(),
        };
        let length = u64::from(header.frames) * u64::from(header.frame_size);
        let split = usize::try_from(length)
            .ok()
            .and_then(|length| behind.split_at_checked(length));
        let least = header.frames == 0 || header.frame_size as usize >= BluefinFrameHeader::SIZE;
        let (frames, rest) = split.filter(|_| least).ok_or_else(|| fail(4, too_short))?;
        Ok(Self { header, frames, rest })
    }

    /// The frames, in order.
    pub fn frames(&self) -> impl Iterator<Item = BluefinFrame<'a>> + use<'a> {
        self.frames
            .chunks(self.header.frame_size.max(1) as usize)
            .filter_map(|bytes| {
                let header = BluefinFrameHeader::read(bytes).ok()?;
                let data = bytes.get(usize::from(header.offset)..).unwrap_or_default();
                let data = data.get(..header.data_size as usize).unwrap_or(data);
                let data = match header.data_type {
                    BluefinDataType::Navigation => NavigationFrame::read(data).ok().map(BluefinData::Navigation),
                    BluefinDataType::Environment => EnvironmentFrame::read(data).ok().map(BluefinData::Environment),
                    BluefinDataType::Other(_) => None,
                }
                .unwrap_or(BluefinData::Other(data));
                Some(BluefinFrame { header, data, bytes })
            })
    }

    /// Appends the record as it was read.
    pub(super) fn write(&self, out: &mut Vec<u8>) {
        self.header.write(out);
        out.extend_from_slice(self.frames);
        out.extend_from_slice(self.rest);
    }

    /// Appends a record of navigation.
    ///
    /// # Errors
    /// [`RecordFault::List`] for more than [`Self::FRAMES_MAX`] frames; then nothing is appended.
    pub fn compose_navigation(
        time_ms: u32,
        frames: &[(Time7k, NavigationFrame)],
        checksum: BluefinChecksum,
        out: &mut Vec<u8>,
    ) -> Result<(), RecordFault> {
        let kind = (BluefinFormat::Navigation, BluefinDataType::Navigation);
        compose(time_ms, kind, checksum, frames, NavigationFrame::write, out)
    }

    /// Appends a record of environment.
    ///
    /// # Errors
    /// [`RecordFault::List`] for more than [`Self::FRAMES_MAX`] frames; then nothing is appended.
    pub fn compose_environment(
        time_ms: u32,
        frames: &[(Time7k, EnvironmentFrame)],
        checksum: BluefinChecksum,
        out: &mut Vec<u8>,
    ) -> Result<(), RecordFault> {
        let kind = (BluefinFormat::Environment, BluefinDataType::Environment);
        compose(time_ms, kind, checksum, frames, EnvironmentFrame::write, out)
    }
}

/// Bytes of a frame with its data: 32 and 96.
const FRAME: usize = BluefinFrameHeader::SIZE + NavigationFrame::SIZE;
const _: () = assert!(NavigationFrame::SIZE == EnvironmentFrame::SIZE && FRAME == 128);

/// Where a frame has its checksum.
const CHECKSUM_AT: usize = 26;

fn compose<T>(
    time_ms: u32,
    (data_format, data_type): (BluefinFormat, BluefinDataType),
    checksum: BluefinChecksum,
    frames: &[(Time7k, T)],
    write: fn(&T, &mut Vec<u8>),
    out: &mut Vec<u8>,
) -> Result<(), RecordFault> {
    let count = u32::try_from(frames.len()).unwrap_or(u32::MAX);
    let (size, data_size) = (FRAME as u32, NavigationFrame::SIZE as u32);
    if frames.len() > BluefinRecord::FRAMES_MAX {
        return Err(RecordFault::List {
            list: "frames",
            count,
            size,
            found: BluefinRecord::FRAMES_MAX * FRAME,
        });
    }
    BluefinHeader {
        time_ms,
        frames: count,
        frame_size: size,
        data_format,
        reserved: Reserved([0; 16]),
    }
    .write(out);
    for (time, data) in frames {
        let at = out.len();
        BluefinFrameHeader {
            packet_size: size,
            version: 1,
            offset: BluefinFrameHeader::SIZE as u16,
            data_type,
            data_size,
            time: *time,
            checksum: 0,
            reserved: Reserved([0; 2]),
        }
        .write(out);
        write(data, out);
        let sum = frame_checksum(checksum, &out[at..]).unwrap_or(0);
        out[at + CHECKSUM_AT..at + CHECKSUM_AT + 4].copy_from_slice(&sum.to_le_bytes());
    }
    Ok(())
}

impl BluefinFrame<'_> {
    /// Whether the frame's checksum is right by this reading of the specification; `None` if none is checked.
    #[must_use]
    pub fn checksum_matches(&self, checksum: BluefinChecksum) -> Option<bool> {
        frame_checksum(checksum, self.bytes).map(|sum| sum == self.header.checksum)
    }
}

/// The checksum of a whole frame.
fn frame_checksum(checksum: BluefinChecksum, frame: &[u8]) -> Option<u32> {
    let (before, behind) = frame.split_at_checked(CHECKSUM_AT)?;
    let (_, behind) = behind.split_at_checked(4)?;
    match checksum {
        BluefinChecksum::WholePacket => Some(crc32(&[before, &[0; 4], behind])),
        BluefinChecksum::DataOnly => Some(crc32(&[frame.get(BluefinFrameHeader::SIZE..)?])),
        BluefinChecksum::None => None,
    }
}
