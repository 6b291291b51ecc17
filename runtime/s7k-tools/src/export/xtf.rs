//! Sidescan (records 3000) as XTF: file header, then a ping header with two channels for each ping.
//!
//! Source: *eXtended Triton Format (XTF), File Format Specification*, revision 42 (2020). Numbers are little-endian.

use std::io::Write;
use std::path::Path;

use backseat_s7k::FrameHeader;
use backseat_s7k::record::{Imagery, RangeKind, Samples, SideScanHeader};
use chrono::{Datelike, Timelike};

use super::Exported;
use crate::error::Error;
use crate::moment::Moment;
use crate::output::Output;
use crate::selection::Selection;
use crate::sidescan::{AltitudeFrom, Line, SIDES, Side, Sides, channel, reach_m};
use crate::source::Source;
use crate::track::Pose;

const FILE_HEADER: usize = 1024;
const CHANNEL_INFO: usize = 128;
const PING_HEADER: usize = 256;
const CHANNEL_HEADER: usize = 64;
/// Every record is so many bytes long, or a multiple.
const RECORD_UNIT: usize = 64;
/// The mark at the start of each record.
const MAGIC: u16 = 0xFACE;

/// Bytes that are set at their places.
struct Part<'a>(&'a mut [u8]);

impl Part<'_> {
    fn put<const N: usize>(&mut self, at: usize, bytes: [u8; N]) {
        self.0[at..at + N].copy_from_slice(&bytes);
    }

    fn u16(&mut self, at: usize, value: u16) {
        self.put(at, value.to_le_bytes());
    }

    fn u32(&mut self, at: usize, value: u32) {
        self.put(at, value.to_le_bytes());
    }

    #[expect(clippy::cast_possible_truncation, reason = "the format has 32-bit numbers")]
    fn f32(&mut self, at: usize, value: f64) {
        self.put(at, (value as f32).to_le_bytes());
    }

    fn f64(&mut self, at: usize, value: f64) {
        self.put(at, value.to_le_bytes());
    }

    /// A text of at most `room` bytes, the last of which stays zero.
    fn text(&mut self, at: usize, room: usize, text: &str) {
        let bytes: Vec<u8> = text
            .chars()
            .map(|c| if c.is_ascii() { c as u8 } else { b'?' })
            .take(room - 1)
            .collect();
        self.0[at..at + bytes.len()].copy_from_slice(&bytes);
    }
}

/// Writes the sidescan of a selection, which must be of one device. Samples are unsigned, of two bytes (of four if the
/// recording has four): the amplitude as it is recorded.
///
/// # Errors
/// [`Error::Read`] and [`Error::Write`]; [`Error::Contents`] if there is no sidescan, or of several devices.
pub fn export_xtf(
    source: &Source,
    selection: &Selection,
    sound_speed_mps: Option<f64>,
    out: &Path,
) -> Result<Exported, Error> {
    let line = Line::survey(source, selection, AltitudeFrom::Navigation, sound_speed_mps)?;
    let failed = |error| Error::write(out, error);
    let mut output = std::io::BufWriter::new(Output::create(out, source)?);
    let (mut sides, mut buffer, mut record) = (Sides::default(), Vec::new(), Vec::new());
    let wide = line
        .pings
        .first()
        .map_or(Ok(None), |ping| line.read(ping, &mut buffer, &mut sides, is_wide))?;
    let bytes_per_sample = if wide == Some(true) { 4 } else { 2 };
    let mut written = 0_u64;
    let (mut without_position, mut without_time, mut clipped) = (0, 0, 0);
    for (index, ping) in line.pings.iter().enumerate() {
        let done = line.read(ping, &mut buffer, &mut sides, |header, imagery, sides| {
            let mut header_bytes = Vec::new();
            if index == 0 {
                header_bytes = file_header(source, imagery, header, bytes_per_sample);
            }
            let time = Moment::of(&header.time);
            let pose = line.pose(header);
            without_position += usize::from(pose.position_deg.is_none());
            without_time += usize::from(time.is_none());
            record.clear();
            clipped += packet(
                &mut record,
                imagery,
                sides,
                bytes_per_sample,
                &Facts {
                    time,
                    pose,
                    line: &line,
                },
            );
            header_bytes
        })?;
        if let Some(header) = done {
            output
                .write_all(&header)
                .and_then(|()| output.write_all(&record))
                .map_err(failed)?;
            written += 1;
        }
    }
    let output = output.into_inner().map_err(|error| failed(error.into_error()))?;
    output.commit()?;
    let mut exported = Exported::new(format!("{written} pings of two channels"));
    exported.note_if(
        without_position,
        "pings without a position, because navigation (record 3100) has none at their times",
    );
    exported.note_if(without_time, "pings without a time");
    exported.note_if(clipped, "samples clipped at the greatest number");
    exported.note_left_out(source);
    Ok(exported)
}

/// Whether samples need four bytes.
fn is_wide(_: &FrameHeader, imagery: &Imagery<'_>, _: &Sides) -> bool {
    imagery
        .channels()
        .any(|channel| matches!(imagery.samples(&channel), Samples::U32(_) | Samples::I32(_)))
}

fn file_header(source: &Source, imagery: &Imagery<'_>, frame: &FrameHeader, bytes_per_sample: u16) -> Vec<u8> {
    let mut bytes = vec![0; FILE_HEADER];
    let mut header = Part(&mut bytes);
    header.put(0, [0x7B, 1]);
    // Eight letters fill the field, which then has no closing zero.
    header.text(2, 9, "backseat");
    header.text(10, 8, env!("CARGO_PKG_VERSION"));
    header.text(18, 16, "EdgeTech FS-DW");
    header.text(36, 64, &format!("from a RESON 7k recording, device {}", frame.device));
    let name = source
        .path()
        .file_name()
        .map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    header.text(100, 64, &name);
    // Positions in degrees.
    header.u16(164, 3);
    header.u16(166, 2);
    for (index, side) in SIDES.into_iter().enumerate() {
        let mut info = Part(&mut bytes[256 + index * CHANNEL_INFO..256 + (index + 1) * CHANNEL_INFO]);
        let channel = channel(imagery, side);
        let ground = channel.is_some_and(|channel| channel.header.range_kind == RangeKind::Ground);
        // 1: port, 2: starboard. Corrections: 1 slant range, 2 ground range.
        info.put(0, [side.code() + 1, u8::try_from(index).unwrap_or(0)]);
        info.u16(2, if ground { 2 } else { 1 });
        info.u16(4, 1);
        info.u16(6, bytes_per_sample);
        // Readers of old files take this for the number of samples.
        info.u32(8, channel.map_or(0, |channel| channel.header.samples));
        info.text(12, 16, if index == 0 { "port" } else { "starboard" });
        if let Some(volts) = channel
            .map(|channel| f64::from(channel.header.full_scale_v))
            .filter(|volts| *volts > 0.0)
        {
            info.f32(28, volts);
        }
        // Format of a sample: 2 is four bytes, 3 is two bytes.
        info.put(74, [if bytes_per_sample == 4 { 2 } else { 3 }]);
    }
    bytes
}

/// What a ping's headers say beside its imagery.
struct Facts<'a, 's> {
    time: Option<Moment>,
    pose: Pose,
    line: &'a Line<'s>,
}

/// Writes a record; returns how many samples are clipped.
fn packet(
    out: &mut Vec<u8>,
    imagery: &Imagery<'_>,
    sides: &Sides,
    bytes_per_sample: u16,
    facts: &Facts<'_, '_>,
) -> usize {
    let samples: usize = sides
        .iter()
        .map(|side| side.amplitudes.len() * usize::from(bytes_per_sample))
        .sum();
    let length = (PING_HEADER + 2 * CHANNEL_HEADER + samples).next_multiple_of(RECORD_UNIT);
    out.resize(PING_HEADER, 0);
    ping_header(&mut Part(out), imagery, length, facts);
    let edgetech: Vec<SideScanHeader> = imagery.side_scan_headers().collect();
    let mut clipped = 0;
    for (index, (side, found)) in SIDES.into_iter().zip(sides).enumerate() {
        let start = out.len();
        out.resize(start + CHANNEL_HEADER, 0);
        let kind = channel(imagery, side);
        let start_us = kind.map_or(0, |channel| channel.header.start_us);
        channel_header(
            &mut Part(&mut out[start..]),
            index,
            found,
            start_us,
            edgetech.get(index),
            facts,
        );
        clipped += write_samples(out, found, bytes_per_sample);
    }
    out.resize(length, 0);
    clipped
}

fn ping_header(header: &mut Part<'_>, imagery: &Imagery<'_>, length: usize, facts: &Facts<'_, '_>) {
    header.u16(0, MAGIC);
    // Header type 0, sonar; two channels follow.
    header.u16(4, 2);
    header.u32(10, u32::try_from(length).unwrap_or(u32::MAX));
    if let Some(time) = facts.time {
        let time = time.calendar();
        let byte = |value: u32| u8::try_from(value).unwrap_or_default();
        let day = [byte(time.month()), byte(time.day())];
        let clock = [
            byte(time.hour()),
            byte(time.minute()),
            byte(time.second()),
            byte(time.nanosecond() / 10_000_000),
        ];
        header.u16(14, u16::try_from(time.year()).unwrap_or_default());
        header.put(16, day);
        header.put(18, clock);
        header.u16(22, u16::try_from(time.ordinal()).unwrap_or_default());
        // The time of the position is that of the ping: it is interpolated.
        header.put(148, clock);
        header.u32(
            232,
            time.num_seconds_from_midnight() * 1000 + time.nanosecond() / 1_000_000,
        );
        header.put(236, clock);
    }
    let ping = imagery.header.ping;
    header.u32(24, ping);
    header.u32(28, ping);
    // Half the speed of sound, as the format has it.
    header.f32(32, facts.line.sound_speed_mps / 2.0);
    let pose = &facts.pose;
    if let Some((latitude, longitude)) = pose.position_deg {
        // Of the ship, and of the sonar: north first.
        for at in [128, 160] {
            header.f64(at, latitude);
            header.f64(at + 8, longitude);
        }
    }
    let knots = pose.speed_mps.unwrap_or(0.0) / (1852.0 / 3600.0);
    let heading_deg = pose.heading_deg.unwrap_or(0.0);
    header.f32(120, knots);
    header.f32(124, heading_deg);
    header.f32(152, knots);
    header.f32(192, pose.depth_m.unwrap_or(0.0));
    header.f32(196, pose.altitude_m.unwrap_or(0.0));
    header.f32(204, pose.pitch_deg.unwrap_or(0.0));
    header.f32(208, pose.roll_deg.unwrap_or(0.0));
    header.f32(212, heading_deg);
    header.u32(224, imagery.header.time_ms);
}

fn channel_header(
    header: &mut Part<'_>,
    index: usize,
    side: &Side,
    start_us: u32,
    edgetech: Option<&SideScanHeader>,
    facts: &Facts<'_, '_>,
) {
    header.u16(0, u16::try_from(index).unwrap_or(0));
    // Method 2: nothing was left out.
    header.u16(2, 2);
    let reach = reach_m(&[side.clone(), Side::default()]);
    if side.ground {
        header.f32(8, reach);
    } else {
        header.f32(4, reach);
        header.f32(12, f64::from(start_us) * 1e-6);
        header.f32(16, 2.0 * (reach - side.first_m) / facts.line.sound_speed_mps);
    }
    header.u32(42, u32::try_from(side.amplitudes.len()).unwrap_or(u32::MAX));
    if let Some(edgetech) = edgetech {
        // N, where a step is 2^-N volts.
        header.put(58, edgetech.weighting_factor.to_le_bytes());
        header.u16(30, edgetech.adc_gain);
    }
}

fn write_samples(out: &mut Vec<u8>, side: &Side, bytes_per_sample: u16) -> usize {
    let mut clipped = 0;
    for amplitude in &side.amplitudes {
        let value = f64::from(*amplitude).round();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        if bytes_per_sample == 4 {
            clipped += usize::from(value > f64::from(u32::MAX));
            out.extend((value.min(f64::from(u32::MAX)) as u32).to_le_bytes());
        } else {
            clipped += usize::from(value > f64::from(u16::MAX));
            out.extend((value.min(f64::from(u16::MAX)) as u16).to_le_bytes());
        }
    }
    clipped
}
