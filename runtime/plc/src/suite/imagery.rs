//! The records 3000 and 3001 of a ping, with EdgeTech's headers (2.2, 2.3, appendix A).

use backseat_s7k::plc::PlcVersion;
use backseat_s7k::record::{
    Channel, ChannelHeader, ChannelSide, CoordinateUnits, Correlated, EdgeTechFormat, HeaderLayout, Imagery,
    ImageryHeader, Polarity, RangeKind, SampleFormat, SegyHeader, SideScanHeader, TriggerSource,
};
use backseat_s7k::{Chars, FrameWriter, Reserved, Time7k};
use backseat_units::math::{wrap_180, wrap_360};
use backseat_units::{Timestamp, Utc};

use crate::navigation::Navigation;
use crate::sonar::{Ping, SensorKind};

/// What a ping's records need besides the samples.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Heading<'a> {
    pub(crate) kind: SensorKind,
    pub(crate) ping: &'a Ping,
    pub(crate) navigation: &'a Navigation,
    /// The time of the ping on the sonar's own clock.
    pub(crate) sonar_utc: Utc,
    pub(crate) layout: HeaderLayout,
    pub(crate) weighting_factor: i16,
    pub(crate) version: PlcVersion,
}

/// The time of day by the sonar's clock, as EdgeTech's headers have it.
struct Clock {
    time: Time7k,
    day_ms: u32,
}

impl Clock {
    fn of(utc: Utc) -> Self {
        let day_ms = utc.time_of_day().as_nanos() / 1_000_000;
        Self {
            time: Time7k::from_utc(utc),
            day_ms: u32::try_from(day_ms).unwrap_or(0),
        }
    }

    fn year(&self) -> i16 {
        i16::try_from(self.time.year).unwrap_or(i16::MAX)
    }

    const fn second(&self) -> u8 {
        self.time.seconds as u8
    }
}

impl Heading<'_> {
    /// Writes a sidescan record with its optional data.
    pub(crate) fn side_scan(&self, port: &[u16], starboard: &[u16], frame: &mut FrameWriter<'_>) {
        let (port_bytes, starboard_bytes) = (envelope(port), envelope(starboard));
        let channels = [
            self.channel(0, ChannelSide::Port, "port", 2, &port_bytes),
            self.channel(1, ChannelSide::Starboard, "starboard", 2, &starboard_bytes),
        ];
        self.imagery(SampleFormat::Envelope, &channels, 2 * SideScanHeader::SIZE, frame);
        frame.begin_optional(SideScanHeader::OPTIONAL_ID);
        for (number, samples) in (0..).zip([port, starboard]) {
            self.side_scan_header(number, samples).write(frame.bytes());
        }
    }

    /// Writes a sub-bottom record with its optional data.
    pub(crate) fn sub_bottom(&self, samples: &[[i16; 2]], frame: &mut FrameWriter<'_>) {
        let bytes = complex(samples);
        let channels = [self.channel(0, ChannelSide::Port, "sub-bottom", 4, &bytes)];
        self.imagery(SampleFormat::Complex, &channels, SegyHeader::SIZE, frame);
        frame.begin_optional(SegyHeader::OPTIONAL_ID);
        self.segy_header(samples).write(frame.bytes());
    }

    fn imagery(&self, format: SampleFormat, channels: &[Channel<'_>], optional: usize, frame: &mut FrameWriter<'_>) {
        let header = ImageryHeader {
            time_ms: milliseconds(self.ping.time),
            ping: self.ping.number,
            channels: 0,
            channel_bytes: 0,
            data_format: format,
        };
        let composed = Imagery::compose(header, self.layout, channels, optional, frame.bytes());
        debug_assert!(composed.is_ok(), "{composed:?}");
    }

    fn channel<'b>(
        &self,
        number: u8,
        side: ChannelSide,
        name: &str,
        bytes_per_sample: u8,
        bytes: &'b [u8],
    ) -> Channel<'b> {
        let samples = bytes.len() / usize::from(bytes_per_sample);
        let header = ChannelHeader {
            number,
            side,
            range_kind: RangeKind::Slant,
            polarity: if bytes_per_sample == 2 {
                Polarity::Unipolar
            } else {
                Polarity::Bipolar
            },
            bytes_per_sample,
            reserved_1: Reserved::default(),
            samples: u32::try_from(samples).unwrap_or(0),
            start_us: 0,
            sample_interval_us: self.ping.sample_interval_us,
            range_m: self.ping.range_m as f32,
            full_scale_v: -1.0,
            name: Chars::new(name).unwrap_or_default(),
            reserved_2: Reserved::default(),
        };
        Channel { header, bytes }
    }

    fn side_scan_header(&self, channel: u16, samples: &[u16]) -> SideScanHeader {
        let clock = Clock::of(self.sonar_utc);
        let (roll_deg, pitch_deg, heading_deg) = self.navigation.attitude_deg();
        let heading_arcmin = (wrap_360(heading_deg) * 60.0) as i16;
        SideScanHeader {
            subsystem: self.kind.subsystem(),
            channel,
            ping: self.ping.number,
            packet: 1,
            trigger: TriggerSource::Internal,
            samples: u32::try_from(samples.len()).unwrap_or(0),
            sample_interval_ns: self.ping.sample_interval_us * 1000,
            start_depth_samples: 0,
            weighting_factor: self.weighting_factor,
            adc_gain: u16::try_from(self.ping.gain_steps).unwrap_or(0),
            // `fold`, because `max` keeps the last of equal ones, which the compiler does not turn into vector code.
            adc_max: samples.iter().fold(0, |max, sample| max.max(*sample)),
            range_dm: (self.ping.range_m * 10.0).round() as u16,
            pulse_id: self.ping.pulse.id,
            mark: 0,
            data_format: EdgeTechFormat::Envelope,
            reserved: Reserved::default(),
            day_ms: clock.day_ms,
            year: clock.year(),
            day: clock.time.day,
            hour: u16::from(clock.time.hours),
            minute: u16::from(clock.time.minutes),
            second: u16::from(clock.second()),
            heading_arcmin,
            pitch_arcmin: (wrap_180(pitch_deg) * 60.0) as i16,
            roll_arcmin: (wrap_180(roll_deg) * 60.0) as i16,
            heave_cm: 0,
            yaw_arcmin: heading_arcmin,
            depth_cm: (self.navigation.depth_m().max(0.0) * 100.0).round() as u32,
            temperature_ddegc: 0,
            reserved_2: Reserved::default(),
        }
    }

    fn segy_header(&self, samples: &[[i16; 2]]) -> SegyHeader {
        let clock = Clock::of(self.sonar_utc);
        let (roll_deg, pitch_deg, heading_deg) = self.navigation.attitude_deg();
        let (latitude_deg, longitude_deg) = self.navigation.position_deg().unwrap_or((0.0, 0.0));
        let centidegrees = |deg: f64| (wrap_180(deg) * 100.0).round() as i16;
        let modulus = |sample: &[i16; 2]| sample[0].unsigned_abs().max(sample[1].unsigned_abs());
        let pulse = self.ping.pulse;
        SegyHeader {
            sequence: 0,
            start_depth_samples: 0,
            ping: self.ping.number,
            channel: 0,
            unused_1: Reserved::default(),
            trace_id: 1,
            unused_2: Reserved::default(),
            data_format: EdgeTechFormat::Complex,
            antenna_r_cm: 0,
            antenna_o_cm: 0,
            rs232: Reserved::default(),
            source_x: (longitude_deg * 3600.0).round() as i32,
            source_y: (latitude_deg * 3600.0).round() as i32,
            group_x: (longitude_deg * 600_000.0).round() as i32,
            group_y: (latitude_deg * 600_000.0).round() as i32,
            coordinate_units: CoordinateUnits::SecondsOfArc,
            annotation: Chars::default(),
            samples: u16::try_from(samples.len()).unwrap_or(u16::MAX),
            sample_interval_ns: self.ping.sample_interval_us * 1000,
            adc_gain: u16::try_from(self.ping.gain_steps).unwrap_or(0),
            pulse_power_percent: self.ping.power_percent.round() as i16,
            correlated: Correlated::Yes,
            start_frequency_dahz: (pulse.start_hz / 10.0).round() as u16,
            end_frequency_dahz: (pulse.end_hz / 10.0).round() as u16,
            sweep_ms: (pulse.length_s * 1000.0).round() as u16,
            unused_7: Reserved::default(),
            alias_frequency: (0.5e6 / f64::from(self.ping.sample_interval_us)).round() as u16,
            pulse_id: pulse.id,
            unused_8: Reserved::default(),
            year: clock.year(),
            day: i16::try_from(clock.time.day).unwrap_or(0),
            hour: i16::from(clock.time.hours),
            minute: i16::from(clock.time.minutes),
            second: i16::from(clock.second()),
            time_basis: 3,
            weighting_factor: self.weighting_factor,
            unused_9: Reserved::default(),
            heading_cdeg: centidegrees(heading_deg),
            pitch: centidegrees(pitch_deg),
            roll: centidegrees(roll_deg),
            temperature_ddegc: 0,
            heave_samples: 0,
            trigger: TriggerSource::Internal,
            mark: 0,
            nmea_hour: 0,
            nmea_minute: 0,
            nmea_second: 0,
            nmea_course: 0,
            nmea_speed: 0,
            nmea_day: 0,
            nmea_year: 0,
            day_ms: clock.day_ms,
            adc_max: samples.iter().map(modulus).fold(0, u16::max),
            calibration_ddb: 0,
            vehicle_id: 0,
            software_version: Chars::new(&format!("{}.{:02}", self.version.major, self.version.minor))
                .unwrap_or_default(),
            spherical_correction_c: 0,
            packet: 1,
            adc_decimation: 1,
            decimation: 1,
            unused_a: Reserved::default(),
        }
    }
}

/// Envelope samples as a record has them.
fn envelope(samples: &[u16]) -> Vec<u8> {
    let mut bytes = vec![0; 2 * samples.len()];
    for (out, sample) in bytes.chunks_exact_mut(2).zip(samples) {
        out.copy_from_slice(&sample.to_le_bytes());
    }
    bytes
}

/// Complex samples as a record has them: real part, imaginary part.
fn complex(samples: &[[i16; 2]]) -> Vec<u8> {
    let mut bytes = vec![0; 4 * samples.len()];
    for (out, [real, imaginary]) in bytes.chunks_exact_mut(4).zip(samples) {
        let (first, second) = out.split_at_mut(2);
        first.copy_from_slice(&real.to_le_bytes());
        second.copy_from_slice(&imaginary.to_le_bytes());
    }
    bytes
}

/// The controller's millisecond counter, which wraps after 49 days.
fn milliseconds(now: Timestamp) -> u32 {
    ((now.as_nanos() / 1_000_000) & u64::from(u32::MAX)) as u32
}
