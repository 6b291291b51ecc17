//! Sub-bottom profiles (records 3001) as SEG-Y revision 1: a trace for each ping.
//!
//! Source: SEG Technical Standards Committee, *SEG Y rev 1 Data Exchange format* (2002). Numbers are big-endian.

use std::io::Write;
use std::path::Path;

use backseat_s7k::FrameHeader;
use backseat_s7k::record::{Channel, CoordinateUnits, Imagery, Record, Samples, SegyHeader};
use chrono::{Datelike, Timelike};

use super::Exported;
use super::ebcdic::ebcdic;
use crate::error::Error;
use crate::moment::Moment;
use crate::output::Output;
use crate::selection::Selection;
use crate::sidescan::device;
use crate::source::Source;
use crate::track::{Pose, Track};

/// What the samples of a trace are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Signal {
    /// The envelope: as it is recorded, or the magnitude of complex samples.
    #[default]
    Envelope,
    /// The real part of complex samples (in-phase), with its sign.
    Real,
}

/// The most samples that a trace's header can count.
const SAMPLES_MAX: u32 = 32_767;
/// The longest sample interval that a trace's header can have, microseconds.
const INTERVAL_MAX_US: u32 = 32_767;
/// Coordinates are in thousandths of a second of arc.
const COORDINATE_SCALE: i16 = -1000;
/// Heights are in centimetres.
const HEIGHT_SCALE: i16 = -100;

/// What all traces have in common.
struct Common {
    device: u32,
    channel: usize,
    samples: u32,
    interval_us: u32,
    traces: u64,
}

/// Writes channel `channel` (from 0) of the sub-bottom profiles of a selection, which must be of one device. Samples are
/// 32-bit IEEE numbers in steps of the converter. Shorter traces are filled up with zeros.
///
/// # Errors
/// [`Error::Read`] and [`Error::Write`]; [`Error::Contents`] if there is no profile, if its samples cannot be that
/// signal, or if a trace does not fit into the format.
pub fn export_segy(
    source: &Source,
    selection: &Selection,
    signal: Signal,
    channel: usize,
    out: &Path,
) -> Result<Exported, Error> {
    let device = device(source, selection, 3001, "sub-bottom profile")?;
    let common = survey(source, selection, device, channel)?;
    let track = Track::read(source)?;
    let failed = |error| Error::write(out, error);
    let mut output = std::io::BufWriter::new(Output::create(out, source)?);
    let mut bytes = textual_header(source, &common, signal);
    binary_header(&mut bytes, &common);
    output.write_all(&bytes).map_err(failed)?;
    let (mut number, mut without_position, mut by_header) = (0_u32, 0, 0);
    let mut trace = Vec::new();
    each_trace(source, selection, &common, |header, imagery, found| {
        number += 1;
        let pose = Moment::of(&header.time).map_or_else(Pose::default, |time| track.at(time));
        let segy = imagery.segy_headers().nth(channel);
        let own = segy.and_then(|segy| own_position(&segy));
        let position = pose.position_deg.or(own);
        without_position += usize::from(position.is_none());
        by_header += usize::from(pose.position_deg.is_none() && own.is_some());
        trace.clear();
        let place = TracePlace {
            number,
            pose,
            position,
            segy,
        };
        trace_header(&mut trace, &common, header, imagery, &found, &place);
        if !samples(&mut trace, &imagery.samples(&found), signal) {
            let what = match signal {
                Signal::Envelope => "its samples are neither an envelope of 1, 2 or 4 bytes nor complex of 4 bytes",
                Signal::Real => "its samples are not complex and have no real part: export the envelope instead",
            };
            return Err(Error::contents(source.path(), format!("trace {number}: {what}")));
        }
        trace.resize(240 + 4 * common.samples as usize, 0);
        output.write_all(&trace).map_err(failed)
    })?;
    let output = output.into_inner().map_err(|error| failed(error.into_error()))?;
    output.commit()?;
    let Common {
        samples, interval_us, ..
    } = common;
    let mut exported = Exported::new(format!(
        "{number} traces of {samples} samples, one each {interval_us} us"
    ));
    exported.note_if(
        by_header,
        "traces with the position of EdgeTech's header, because navigation has none",
    );
    exported.note_if(without_position, "traces without a position");
    exported.note_left_out(source);
    Ok(exported)
}

/// Visits the traces.
fn each_trace(
    source: &Source,
    selection: &Selection,
    common: &Common,
    mut visit: impl FnMut(&FrameHeader, &Imagery<'_>, Channel<'_>) -> Result<(), Error>,
) -> Result<(), Error> {
    source.each_record(|_, frame| {
        let header = frame.header();
        if header.record_type != 3001 || header.device.0 != common.device || !selection.contains(header) {
            return Ok(());
        }
        let Ok(Record::SubBottom(imagery)) = Record::read(frame) else {
            return Ok(());
        };
        match imagery.channels().nth(common.channel) {
            Some(channel) => visit(header, &imagery, channel),
            None => Ok(()),
        }
    })
}

/// Finds what all traces have in common, and refuses what the format cannot say.
fn survey(source: &Source, selection: &Selection, device: u32, channel: usize) -> Result<Common, Error> {
    let refuse = |what: String| Error::contents(source.path(), what);
    let mut common = Common {
        device,
        channel,
        samples: 0,
        interval_us: 0,
        traces: 0,
    };
    let (mut samples, mut traces, mut interval) = (0, 0, None);
    each_trace(source, selection, &common, |header, imagery, found| {
        let own = imagery
            .segy_headers()
            .nth(channel)
            .map_or(0, |segy| segy.sample_interval_ns / 1000);
        let interval_us = match found.header.sample_interval_us {
            0 => own,
            interval_us => interval_us,
        };
        let first = *interval.get_or_insert(interval_us);
        if first != interval_us {
            return Err(refuse(format!(
                "the sample interval changes from {first} us to {interval_us} us at {}, and a SEG-Y file has one: \
                 export before and behind it with --from and --until",
                header.time
            )));
        }
        samples = samples.max(found.header.samples);
        traces += 1;
        Ok(())
    })?;
    (common.samples, common.traces, common.interval_us) = (samples, traces, interval.unwrap_or(0));
    if traces == 0 {
        return Err(refuse(format!(
            "no sub-bottom profile has a channel {channel}: try --channel 0"
        )));
    }
    if samples > SAMPLES_MAX {
        return Err(refuse(format!(
            "a trace has {samples} samples, and SEG-Y counts {SAMPLES_MAX} at most"
        )));
    }
    if common.interval_us == 0 || common.interval_us > INTERVAL_MAX_US {
        return Err(refuse(format!(
            "the sample interval is {} us, and SEG-Y has 1 to {INTERVAL_MAX_US} us",
            common.interval_us
        )));
    }
    Ok(common)
}

/// 40 lines of 80 characters.
fn textual_header(source: &Source, common: &Common, signal: Signal) -> Vec<u8> {
    let name = source
        .path()
        .file_name()
        .map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let signal = match signal {
        Signal::Envelope => "ENVELOPE (MAGNITUDE OF COMPLEX SAMPLES)",
        Signal::Real => "REAL PART OF COMPLEX SAMPLES",
    };
    let lines = [
        format!(
            "SUB-BOTTOM PROFILE OF A RESON 7K RECORDING, WRITTEN BY BACKSEAT {}",
            env!("CARGO_PKG_VERSION")
        ),
        format!("RECORDING: {name}"),
        format!(
            "DEVICE {}, CHANNEL {}, {} TRACES",
            common.device, common.channel, common.traces
        ),
        format!("{} SAMPLES A TRACE, ONE EACH {} US", common.samples, common.interval_us),
        format!("SAMPLES: {signal}"),
        "SAMPLE FORMAT: 32-BIT IEEE NUMBERS, STEPS OF THE CONVERTER".to_owned(),
        "BYTES 169-170: N, WHERE A STEP IS 2**-N VOLTS (NOT APPLIED)".to_owned(),
        "BYTES 73-88: SECONDS OF ARC, LONGITUDE AND LATITUDE (WGS84), SCALED".to_owned(),
        "BYTES 41-44: MINUS DEPTH OF THE VEHICLE; 61-64: WATER DEPTH; METRES, SCALED".to_owned(),
        "BYTES 157-166: TIME OF THE RECORD, UTC; 233-236: MICROSECONDS OF THE SECOND".to_owned(),
    ];
    let mut text = Vec::with_capacity(3200);
    for number in 1..=40 {
        let line = match number {
            39 => "SEG Y REV1",
            40 => "END TEXTUAL HEADER",
            _ => lines.get(number - 1).map_or("", String::as_str),
        };
        let line = format!("C{number:>2} {line}");
        text.extend(ebcdic(&format!("{line:<80.80}")));
    }
    text
}

/// A part of a header, written at its places.
struct Header<'a>(&'a mut [u8]);

impl Header<'_> {
    /// Places are counted from 1, as the standard does.
    fn i16(&mut self, place: usize, value: i16) {
        self.0[place - 1..place + 1].copy_from_slice(&value.to_be_bytes());
    }

    fn i32(&mut self, place: usize, value: i32) {
        self.0[place - 1..place + 3].copy_from_slice(&value.to_be_bytes());
    }

    fn u32(&mut self, place: usize, value: u32) {
        self.0[place - 1..place + 3].copy_from_slice(&value.to_be_bytes());
    }
}

fn short(value: u32) -> i16 {
    i16::try_from(value).unwrap_or(i16::MAX)
}

fn binary_header(out: &mut Vec<u8>, common: &Common) {
    let start = out.len();
    out.resize(start + 400, 0);
    // The standard counts on from the textual header.
    let mut header = Header(&mut out[start..]);
    let mut set = |place: usize, value: i16| header.i16(place - 3200, value);
    set(3213, 1);
    set(3217, short(common.interval_us));
    set(3219, short(common.interval_us));
    set(3221, short(common.samples));
    set(3223, short(common.samples));
    // 4-byte IEEE numbers, as recorded, metres, revision 1.0, all traces of one length.
    set(3225, 5);
    set(3229, 1);
    set(3255, 1);
    set(3501, 0x0100);
    set(3503, 1);
}

/// Where a trace is.
struct TracePlace {
    number: u32,
    pose: Pose,
    position: Option<(f64, f64)>,
    segy: Option<SegyHeader>,
}

fn trace_header(
    out: &mut Vec<u8>,
    common: &Common,
    frame: &FrameHeader,
    imagery: &Imagery<'_>,
    channel: &Channel<'_>,
    place: &TracePlace,
) {
    out.resize(240, 0);
    let mut header = Header(out);
    let ping = imagery.header.ping;
    header.u32(1, place.number);
    header.u32(5, place.number);
    header.u32(9, ping);
    header.u32(13, 1);
    header.u32(17, ping);
    header.i16(29, 1);
    header.i16(31, 1);
    header.i16(35, 1);
    #[expect(clippy::cast_possible_truncation, reason = "saturates, and depths are below 20 km")]
    let scaled = |value: f64, scale: i16| (value * f64::from(-scale)).round() as i32;
    let (depth, altitude) = (place.pose.depth_m, place.pose.altitude_m);
    if let Some(depth) = depth {
        header.i32(41, scaled(-depth, HEIGHT_SCALE));
        header.i32(49, scaled(depth, HEIGHT_SCALE));
    }
    if let (Some(depth), Some(altitude)) = (depth, altitude) {
        header.i32(61, scaled(depth + altitude, HEIGHT_SCALE));
        header.i32(65, scaled(depth + altitude, HEIGHT_SCALE));
    }
    header.i16(69, HEIGHT_SCALE);
    header.i16(71, COORDINATE_SCALE);
    if let Some((latitude, longitude)) = place.position {
        for (at, degrees) in [(73, longitude), (77, latitude), (81, longitude), (85, latitude)] {
            header.i32(at, scaled(degrees * 3600.0, COORDINATE_SCALE));
        }
        header.i32(181, scaled(longitude * 3600.0, COORDINATE_SCALE));
        header.i32(185, scaled(latitude * 3600.0, COORDINATE_SCALE));
        // Seconds of arc. Without a position the coordinates and their units are 0.
        header.i16(89, 2);
    }
    header.i16(109, short((channel.header.start_us + 500) / 1000));
    header.i16(115, short(common.samples));
    header.i16(117, short(common.interval_us));
    if let Some(segy) = place.segy {
        header.i16(127, short(u32::from(segy.start_frequency_dahz) * 10));
        header.i16(129, short(u32::from(segy.end_frequency_dahz) * 10));
        header.i16(131, short(u32::from(segy.sweep_ms)));
        header.i16(169, segy.weighting_factor);
    }
    if let Some(time) = Moment::of(&frame.time) {
        let time = time.calendar();
        header.i16(157, short(u32::try_from(time.year()).unwrap_or_default()));
        header.i16(159, short(time.ordinal()));
        header.i16(161, short(time.hour()));
        header.i16(163, short(time.minute()));
        header.i16(165, short(time.second()));
        // 4: UTC.
        header.i16(167, 4);
        header.u32(233, time.nanosecond() / 1000);
    }
    header.u32(197, ping);
}

/// Latitude and longitude of EdgeTech's own header, degrees; `None` if it has none. All zero is none.
fn own_position(segy: &SegyHeader) -> Option<(f64, f64)> {
    if segy.coordinate_units != CoordinateUnits::SecondsOfArc {
        return None;
    }
    // The group's are finer: ten-thousandths of a minute.
    let (x, y, a_degree) = if (segy.group_x, segy.group_y) == (0, 0) {
        (segy.source_x, segy.source_y, 3600.0)
    } else {
        (segy.group_x, segy.group_y, 600_000.0)
    };
    let (latitude, longitude) = (f64::from(y) / a_degree, f64::from(x) / a_degree);
    let plausible = (x, y) != (0, 0) && latitude.abs() <= 90.0 && longitude.abs() <= 180.0;
    plausible.then_some((latitude, longitude))
}

/// Appends the samples; false if they cannot be that signal.
fn samples(out: &mut Vec<u8>, samples: &Samples<'_>, signal: Signal) -> bool {
    let start = out.len();
    match signal {
        Signal::Envelope => {
            let mut amplitudes = Vec::new();
            samples.amplitudes(&mut amplitudes);
            out.extend(amplitudes.into_iter().flat_map(f32::to_be_bytes));
        }
        Signal::Real => out.extend(samples.complex().flat_map(|[real, _]| f32::from(real).to_be_bytes())),
    }
    out.len() - start == 4 * samples.len() && !matches!(samples, Samples::Raw { .. })
}
