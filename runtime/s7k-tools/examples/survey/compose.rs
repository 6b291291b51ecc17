//! A short survey, composed record by record: one line over a flat seabed with a block on it.
//!
//! The vehicle runs 60 s at 1.5 m/s, heading 040, 10 m above the seabed. Two sidescans, a sub-bottom profiler and the
//! vehicle's own data are recorded, in both lengths of the sonar header and both protocol versions. To starboard, at 20 m
//! across and abeam at 30 s, stands a block of 3 m by 1 m, 1.5 m high, which throws a shadow of 3.7 m.

use std::io::Cursor;

use backseat_s7k::file::{FileInfo, FileWriter};
use backseat_s7k::record::{
    BluefinRecord, Channel, ChannelHeader, ChannelSide, EdgeTechFormat, EnvironmentFrame, EnvironmentQuality,
    HeaderLayout, Imagery, ImageryHeader, NavigationField, NavigationFrame, NavigationQuality, Polarity, RangeKind,
    SampleFormat, SegyHeader, SideScanHeader, TimeMessage,
};
use backseat_s7k::{BluefinChecksum, Chars, DeviceId, FRAME_LIMIT, Frame, FrameHeader, FrameWriter, Reserved, Time7k};
use backseat_units::math::{exp, sin, sin_cos};
use backseat_units::{EastNorth, LocalFrame, Position, Utc};

/// 2026-11-23T14:00:00Z.
pub(crate) const START_S: u64 = 1_795_442_400;
/// How long the survey takes.
pub(crate) const SECONDS: u64 = 60;
pub(crate) const SPEED_MPS: f64 = 1.5;
pub(crate) const HEADING_DEG: f64 = 40.0;
pub(crate) const ALTITUDE_M: f64 = 10.0;
pub(crate) const DEPTH_M: f64 = 30.0;
pub(crate) const LATITUDE_DEG: f64 = 42.3;
pub(crate) const LONGITUDE_DEG: f64 = -70.9;
pub(crate) const SOUND_SPEED_MPS: f64 = 1500.0;
/// Samples of a sidescan channel, one each 67 us: 50.25 m.
pub(crate) const SAMPLES: u32 = 1000;
pub(crate) const SAMPLE_US: u32 = 67;
/// Samples of a sub-bottom trace, one each 46 us.
pub(crate) const TRACE_SAMPLES: u32 = 800;
pub(crate) const TRACE_US: u32 = 46;
/// Where the block is: seconds on the line, and metres across to starboard.
pub(crate) const BLOCK_S: f64 = 30.0;
pub(crate) const BLOCK_ACROSS_M: f64 = 20.0;
/// No ping of the high frequency from here until there.
pub(crate) const PAUSE_S: (f64, f64) = (40.0, 43.0);
/// Pings a second of the two sidescans and of the sub-bottom profiler.
pub(crate) const HIGH_HZ: u64 = 8;
pub(crate) const LOW_HZ: u64 = 4;
pub(crate) const TRACE_HZ: u64 = 2;

/// A record, whole.
pub(crate) type Bytes = Vec<u8>;

/// Noise that is the same in every run.
struct Noise(u64);

impl Noise {
    /// Between 0 and 1.
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        f64::from((self.0 >> 33) as u32) / f64::from(1_u32 << 31)
    }

    /// Around 1, never below 0.2: a few independent echoes summed.
    fn speckle(&mut self) -> f64 {
        0.2 + 1.6 * (self.next() + self.next() + self.next()) / 3.0
    }
}

pub(crate) fn utc(seconds: f64) -> Utc {
    Utc::from_unix_nanos(START_S * 1_000_000_000 + (seconds * 1e9) as u64)
}

pub(crate) fn time(seconds: f64) -> Time7k {
    Time7k::from_utc(utc(seconds))
}

/// The vehicle's position in degrees, latitude first.
pub(crate) fn position(seconds: f64) -> (f64, f64) {
    let frame = LocalFrame::new(Position::from_deg(LATITUDE_DEG, LONGITUDE_DEG).unwrap());
    let (east, north) = sin_cos(HEADING_DEG.to_radians());
    let along = SPEED_MPS * seconds;
    let position = frame.to_position(EastNorth::new(east * along, north * along));
    (position.latitude.as_deg(), position.longitude.as_deg())
}

pub(crate) fn altitude(seconds: f64) -> f64 {
    ALTITUDE_M + 0.5 * sin(seconds / 8.0)
}

/// The amplitudes of one side of a ping, in steps of the converter.
fn echoes(seconds: f64, starboard: bool, noise: &mut Noise) -> Vec<u16> {
    let height = altitude(seconds);
    let along = (seconds - BLOCK_S) * SPEED_MPS;
    let abeam = starboard && along.abs() < 1.5;
    let shadow_end = (BLOCK_ACROSS_M + 1.0) * height / (height - 1.5);
    (0..SAMPLES)
        .map(|sample| {
            let slant = f64::from(sample) * f64::from(SAMPLE_US) * 1e-6 * SOUND_SPEED_MPS / 2.0;
            let water = 25.0 * noise.speckle();
            if slant <= height {
                return water as u16;
            }
            let across = (slant * slant - height * height).sqrt();
            let seabed = 7000.0 * (height / slant) * exp(-slant / 60.0) * noise.speckle();
            let echo = match across - BLOCK_ACROSS_M {
                x if abeam && (0.0..1.0).contains(&x) => 8.0 * seabed,
                x if abeam && x >= 1.0 && across < shadow_end => 0.0,
                _ => seabed,
            };
            (water + echo).min(65_535.0) as u16
        })
        .collect()
}

fn framed(header: FrameHeader, write: impl FnOnce(&mut Vec<u8>), optional: Option<(u32, Vec<u8>)>) -> Bytes {
    let mut out = Vec::new();
    let mut frame = FrameWriter::begin(header, &mut out);
    write(frame.bytes());
    if let Some((id, bytes)) = optional {
        frame.begin_optional(id);
        frame.bytes().extend(bytes);
    }
    frame.finish(FRAME_LIMIT).unwrap();
    out
}

fn channel_header(side: ChannelSide, polarity: Polarity, bytes_per_sample: u8, samples: u32, us: u32) -> ChannelHeader {
    let reach = f64::from(samples) * f64::from(us) * 1e-6 * SOUND_SPEED_MPS / 2.0;
    ChannelHeader {
        number: side.code(),
        side,
        range_kind: RangeKind::Slant,
        polarity,
        bytes_per_sample,
        reserved_1: Reserved::default(),
        samples,
        start_us: 0,
        sample_interval_us: us,
        range_m: reach as f32,
        full_scale_v: -1.0,
        name: Chars::new(if side == ChannelSide::Port { "port" } else { "starboard" }).unwrap(),
        reserved_2: Reserved::default(),
    }
}

/// A sidescan ping. The high frequency has samples without sign, 20 bytes of header and version 4; the low one samples
/// with sign, 32 bytes of header and version 5.
fn sidescan(seconds: f64, ping: u32, high: bool, noise: &mut Noise) -> Bytes {
    let sides = [ChannelSide::Port, ChannelSide::Starboard];
    let polarity = if high { Polarity::Unipolar } else { Polarity::Bipolar };
    let samples: Vec<Vec<u8>> = sides
        .iter()
        .map(|side| {
            let echoes = echoes(seconds, *side == ChannelSide::Starboard, noise);
            let signed = |(index, echo): (usize, u16)| {
                let echo = i16::try_from(echo / 2).unwrap();
                if index % 2 == 0 { echo } else { -echo }
            };
            if high {
                echoes.into_iter().flat_map(u16::to_le_bytes).collect()
            } else {
                echoes
                    .into_iter()
                    .enumerate()
                    .flat_map(|echo| signed(echo).to_le_bytes())
                    .collect()
            }
        })
        .collect();
    let channels: Vec<Channel<'_>> = sides
        .iter()
        .zip(&samples)
        .map(|(side, bytes)| Channel {
            header: channel_header(*side, polarity, 2, SAMPLES, SAMPLE_US),
            bytes,
        })
        .collect();
    let empty = SideScanHeader::read(&[0; SideScanHeader::SIZE]).unwrap();
    let edgetech = [0, 1].into_iter().flat_map(|channel| {
        let mut out = Vec::new();
        SideScanHeader {
            subsystem: 20 + u16::from(high),
            channel,
            ping,
            packet: 1,
            samples: SAMPLES,
            sample_interval_ns: SAMPLE_US * 1000,
            weighting_factor: 12,
            adc_gain: 4,
            range_dm: 502,
            pulse_id: 7,
            year: 2026,
            day: 327,
            hour: 14,
            minute: (seconds / 60.0) as u16,
            second: (seconds % 60.0) as u16,
            heading_arcmin: (HEADING_DEG * 60.0) as i16,
            depth_cm: (DEPTH_M * 100.0) as u32,
            temperature_ddegc: 84,
            ..empty
        }
        .write(&mut out);
        out
    });
    let edgetech: Vec<u8> = edgetech.collect();
    let device = if high {
        DeviceId::SIDESCAN_HIGH
    } else {
        DeviceId::SIDESCAN_LOW
    };
    let header = FrameHeader::new(3000, device).at(time(seconds)).counted(ping);
    let (header, layout) = if high {
        (header, HeaderLayout::Spec)
    } else {
        (header.version_5(), HeaderLayout::Padded)
    };
    let imagery = ImageryHeader {
        time_ms: (seconds * 1000.0) as u32,
        ping: 1000 + ping,
        channels: 2,
        channel_bytes: 0,
        data_format: SampleFormat::Envelope,
    };
    framed(
        header,
        |out| Imagery::compose(imagery, layout, &channels, edgetech.len(), out).unwrap(),
        Some((SideScanHeader::OPTIONAL_ID, edgetech.clone())),
    )
}

/// In-phase and quadrature of a trace: the bottom, and two layers below it.
pub(crate) fn trace(seconds: f64) -> Vec<[i16; 2]> {
    let bottom = altitude(seconds) * 2.0 / SOUND_SPEED_MPS;
    (0..TRACE_SAMPLES)
        .map(|sample| {
            let at = f64::from(sample) * f64::from(TRACE_US) * 1e-6;
            let layers = [(0.0, 12_000.0), (0.003, 5_000.0), (0.007, 2_500.0)];
            let amplitude: f64 = layers
                .iter()
                .map(|(below, strength)| {
                    let off = (at - bottom - below) / 2e-4;
                    strength * exp(-off * off)
                })
                .sum();
            let (sin, cos) = sin_cos(f64::from(sample) * 0.8);
            [(amplitude * cos + 12.0) as i16, (amplitude * sin) as i16]
        })
        .collect()
}

fn sub_bottom(seconds: f64, ping: u32) -> Bytes {
    let bytes: Vec<u8> = trace(seconds)
        .iter()
        .flatten()
        .flat_map(|part| part.to_le_bytes())
        .collect();
    let channel = Channel {
        header: channel_header(ChannelSide::Port, Polarity::Bipolar, 4, TRACE_SAMPLES, TRACE_US),
        bytes: &bytes,
    };
    let mut segy = vec![0; SegyHeader::SIZE];
    // Coordinates in seconds of arc, rounded to whole ones.
    let (latitude, longitude) = position(seconds);
    segy[28..30].copy_from_slice(&1_i16.to_le_bytes());
    segy[8..12].copy_from_slice(&(5000 + ping).to_le_bytes());
    segy[72..76].copy_from_slice(&((longitude * 3600.0).round() as i32).to_le_bytes());
    segy[76..80].copy_from_slice(&((latitude * 3600.0).round() as i32).to_le_bytes());
    segy[88..90].copy_from_slice(&2_i16.to_le_bytes());
    segy[34..36].copy_from_slice(&EdgeTechFormat::Complex.code().to_le_bytes());
    segy[114..116].copy_from_slice(&u16::try_from(TRACE_SAMPLES).unwrap().to_le_bytes());
    segy[116..120].copy_from_slice(&(TRACE_US * 1000).to_le_bytes());
    segy[124..126].copy_from_slice(&2_i16.to_le_bytes());
    segy[166..168].copy_from_slice(&3_i16.to_le_bytes());
    segy[168..170].copy_from_slice(&9_i16.to_le_bytes());
    let imagery = ImageryHeader {
        time_ms: (seconds * 1000.0) as u32,
        ping: 5000 + ping,
        channels: 1,
        channel_bytes: 0,
        data_format: SampleFormat::Complex,
    };
    let header = FrameHeader::new(3001, DeviceId::SUB_BOTTOM)
        .at(time(seconds))
        .counted(ping);
    framed(
        header,
        |out| Imagery::compose(imagery, HeaderLayout::Spec, &[channel], segy.len(), out).unwrap(),
        Some((SegyHeader::OPTIONAL_ID, segy.clone())),
    )
}

pub(crate) fn navigation_frame(seconds: f64) -> NavigationFrame {
    let (latitude, longitude) = position(seconds);
    let (east, north) = sin_cos(HEADING_DEG.to_radians());
    let quality = NavigationField::ALL
        .iter()
        .fold(NavigationQuality(0), |set, field| set.with(*field));
    NavigationFrame {
        quality,
        latitude_rad: latitude.to_radians(),
        longitude_rad: longitude.to_radians(),
        speed_mps: SPEED_MPS as f32,
        depth_m: DEPTH_M,
        altitude_m: altitude(seconds),
        roll_rad: 0.01,
        pitch_rad: -0.02,
        yaw_rad: HEADING_DEG.to_radians() as f32,
        northing_rate_mps: (SPEED_MPS * north) as f32,
        easting_rate_mps: (SPEED_MPS * east) as f32,
        position_time_s: seconds,
        attitude_time_s: seconds,
        ..NavigationFrame::default()
    }
}

/// Navigation at 1 Hz, with five frames in each record.
fn navigation(second: u64, count: u32) -> Bytes {
    let at = |index: u64| second as f64 + index as f64 / 5.0;
    let frames: Vec<_> = (0..5)
        .map(|index| (time(at(index)), navigation_frame(at(index))))
        .collect();
    let header = FrameHeader::new(3100, DeviceId::BLUEFIN)
        .at(time(second as f64))
        .counted(count);
    let write = |out: &mut Vec<u8>| {
        let ms = u32::try_from(second * 1000).unwrap();
        BluefinRecord::compose_navigation(ms, &frames, BluefinChecksum::WholePacket, out).unwrap();
    };
    framed(header, write, None)
}

fn environment(second: u64) -> Bytes {
    let frame = EnvironmentFrame {
        quality: EnvironmentQuality(1),
        sound_speed_mps: SOUND_SPEED_MPS as f32,
        reserved: Reserved::default(),
    };
    let header = FrameHeader::new(3100, DeviceId::BLUEFIN).at(time(second as f64 + 0.5));
    let header = FrameHeader {
        enumerator: 1,
        ..header
    }
    .counted(u32::try_from(second / 10 + 1).unwrap());
    let write = |out: &mut Vec<u8>| {
        BluefinRecord::compose_environment(0, &[(time(second as f64), frame)], BluefinChecksum::DataOnly, out).unwrap();
    };
    framed(header, write, None)
}

fn controller(seconds: f64) -> [Bytes; 4] {
    let time_message = TimeMessage::read(&[37, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]).unwrap();
    let numbers = |list: &[i32]| list.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>();
    let text = |list: &[i32], text: &str| {
        let mut bytes = numbers(list);
        bytes.extend_from_slice(&(text.len() as u32).to_le_bytes());
        bytes.extend_from_slice(text.as_bytes());
        bytes
    };
    let header = |number| FrameHeader::new(number, DeviceId::LOGGER).at(time(seconds)).counted(1);
    [
        framed(header(7400), |out| time_message.write(out), None),
        framed(header(11_000), |out| out.extend(text(&[-1, 1, 1], "1")), None),
        framed(header(11_001), |out| out.extend(numbers(&[1, -1, 1])), None),
        framed(
            header(11_002),
            |out| out.extend(text(&[0, -1, 3], "Logging = 1, dive.s7k, 0.001")),
            None,
        ),
    ]
}

/// All records in the order of time.
pub(crate) fn records() -> Vec<Bytes> {
    let mut noise = Noise(7);
    let mut timed: Vec<(f64, Bytes)> = controller(0.0).into_iter().map(|record| (0.0, record)).collect();
    for second in 0..=SECONDS {
        timed.push((second as f64, navigation(second, u32::try_from(second).unwrap() + 1)));
        if second % 10 == 0 {
            timed.push((second as f64 + 0.5, environment(second)));
        }
    }
    for (high, rate) in [(true, HIGH_HZ), (false, LOW_HZ)] {
        for ping in 0..SECONDS * rate {
            let at = ping as f64 / rate as f64;
            if high && (PAUSE_S.0..PAUSE_S.1).contains(&at) {
                continue;
            }
            timed.push((at, sidescan(at, u32::try_from(ping).unwrap() + 1, high, &mut noise)));
        }
    }
    for ping in 0..SECONDS * TRACE_HZ {
        let at = ping as f64 / TRACE_HZ as f64;
        timed.push((at, sub_bottom(at, u32::try_from(ping).unwrap() + 1)));
    }
    timed.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    timed.into_iter().map(|(_, record)| record).collect()
}

/// The records as a closed file.
pub(crate) fn file(records: &[Bytes]) -> Bytes {
    let info = FileInfo {
        file_id: [1, 2],
        session_id: [3, 4],
        recorder: Chars::new("PLC").unwrap(),
        recorder_version: Chars::new("1.02.03").unwrap(),
        user_name: Chars::new("survey").unwrap(),
        notes: Chars::new("a block to starboard").unwrap(),
        devices: [11_000, 11_001, 11_002, 11_100]
            .map(|device| (DeviceId(device), 0))
            .to_vec(),
        version_5: false,
    };
    let mut writer = FileWriter::create(Cursor::new(Vec::new()), info, time(0.0)).unwrap();
    for record in records {
        writer.write(&Frame::read(record, FRAME_LIMIT).unwrap()).unwrap();
    }
    writer.finish(time(SECONDS as f64)).unwrap().into_inner()
}

/// The survey without a fault.
pub(crate) fn clean() -> Bytes {
    file(&records())
}

/// Where [`damaged`] is damaged, in bytes from the start.
#[derive(Debug)]
pub(crate) struct Faults {
    /// A record with a wrong checksum that it claims.
    pub(crate) wrong_checksum: usize,
    /// A record with a value outside its range, and the value's own place.
    pub(crate) value: usize,
    /// 100 bytes that are no record.
    pub(crate) noise: usize,
    /// A record whose sync pattern is overwritten, and its length.
    pub(crate) overwritten: (usize, usize),
    /// How many bytes are at the end that are no whole record: the catalogue is cut.
    pub(crate) cut: usize,
}

/// The survey with every kind of fault.
pub(crate) fn damaged() -> (Bytes, Faults) {
    let mut bytes = clean();
    let index = backseat_s7k::file::Index::scan(Cursor::new(&bytes)).unwrap();
    let of = |record_type: u32, number: usize| {
        let found = index
            .entries
            .iter()
            .filter(|entry| entry.record_type == record_type)
            .nth(number)
            .unwrap();
        (usize::try_from(found.offset).unwrap(), found.size as usize)
    };
    // A flipped bit in the samples.
    let (wrong_checksum, size) = of(3000, 10);
    bytes[wrong_checksum + size / 2] ^= 1;
    // Not claimed: with a right sum, and with a wrong one.
    for (number, spoil) in [(20, false), (21, true)] {
        let (at, size) = of(3000, number);
        bytes[at + 48] &= !1;
        let end = at + size - 4;
        let sum = backseat_s7k::byte_sum(&bytes[at..end]) + u32::from(spoil);
        bytes[end..end + 4].copy_from_slice(&sum.to_le_bytes());
    }
    // A latitude of 3 rad, with a checksum that is right.
    let (at, size) = of(3100, 5);
    let value = at + 64 + 32 + 32 + 4;
    bytes[value..value + 8].copy_from_slice(&3.0_f64.to_le_bytes());
    let end = at + size - 4;
    let sum = backseat_s7k::byte_sum(&bytes[at..end]);
    bytes[end..end + 4].copy_from_slice(&sum.to_le_bytes());
    // A record that is none any more.
    let overwritten = of(3001, 30);
    bytes[overwritten.0 + 4..overwritten.0 + 8].copy_from_slice(&[0xEE; 4]);
    // The end is missing.
    let catalog = of(7300, 0);
    bytes.truncate(catalog.0 + 500);
    // Bytes between two records, which move everything behind them.
    let (noise, _) = of(3001, 60);
    bytes.splice(noise..noise, [0x55; 100]);
    let faults = Faults {
        wrong_checksum,
        value,
        noise,
        overwritten,
        cut: 500,
    };
    (bytes, faults)
}
