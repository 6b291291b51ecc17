//! Sidescan (records 3000) as a picture: a row for each ping, port to the left, the vehicle running up.

use std::io::{self, Write};
use std::path::Path;

use super::Exported;
use crate::error::Error;
use crate::output::Output;
use crate::selection::Selection;
use crate::sidescan::{AltitudeFrom, Gain, GainBy, Grid, Line, PingPlace, Sides, fill};
use crate::source::Source;

/// How to draw a waterfall.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Waterfall {
    /// Along the seabed, instead of along the ray.
    pub ground: bool,
    /// Where the altitude comes from, for `ground`.
    pub altitude: AltitudeFrom,
    /// What amplitudes are divided by.
    pub gain: GainBy,
    /// Width of the picture, pixels; as many as samples, and at most 2000, if it is not set.
    pub width: Option<u32>,
    /// Speed of sound, m/s; of record 3100, or 1500, if it is not set.
    pub sound_speed_mps: Option<f64>,
}

/// The widest picture, pixels.
pub(crate) const WIDTH_MAX: u32 = 16_384;
/// The most columns of a side that are drawn unasked.
const COLUMNS_USUAL: usize = 1000;
/// The highest picture, pixels: most viewers open no higher ones.
const ROWS_MAX: usize = 60_000;

/// Draws the sidescan of a selection, which must be of one device, as a PNG of grey.
///
/// # Errors
/// [`Error::Read`] and [`Error::Write`]; [`Error::Contents`] if there is no sidescan, of several devices, too many pings
/// for a picture, or no altitude for `ground`; [`Error::Option`] for a width out of range.
pub fn export_waterfall(
    source: &Source,
    selection: &Selection,
    drawing: &Waterfall,
    out: &Path,
) -> Result<Exported, Error> {
    if drawing.width.is_some_and(|width| !(2..=WIDTH_MAX).contains(&width)) {
        return Err(Error::Option {
            option: "--width",
            fault: format!("expected 2 to {WIDTH_MAX} pixels"),
        });
    }
    let line = Line::survey(source, selection, drawing.altitude, drawing.sound_speed_mps)?;
    let blind = if drawing.ground { line.without_altitude() } else { 0 };
    if blind == line.pings.len() {
        let what = "no altitude, which --ground needs: navigation (record 3100) has none, and no first bottom return \
                    is seen; leave --ground out";
        return Err(Error::contents(source.path(), what));
    }
    if line.pings.len() > ROWS_MAX {
        let what = format!(
            "{} pings, and a picture has at most {ROWS_MAX} rows: export a part of it with --from and --until",
            line.pings.len()
        );
        return Err(Error::contents(source.path(), what));
    }
    let columns = drawing
        .width
        .map_or(line.samples.min(COLUMNS_USUAL), |width| width as usize / 2);
    #[expect(clippy::cast_precision_loss, reason = "at most 8192 columns")]
    let grid = Grid {
        columns,
        step_m: line.reach_m / columns as f64,
    };
    let mut gain = Gain::new(columns);
    let mut rows = Rows::new(&line, grid, drawing.ground);
    for ping in &line.pings {
        for (side, row) in rows.of(ping)?.iter().enumerate() {
            gain.add(side, row);
        }
    }
    let scale = gain.finish(drawing.gain);
    let failed = |error: io::Error| Error::write(out, error);
    let mut output = Output::create(out, source)?;
    let (width, height) = (2 * columns, line.pings.len());
    let size = |pixels: usize| u32::try_from(pixels).unwrap_or(u32::MAX);
    let mut encoder = png::Encoder::new(&mut output, size(width), size(height));
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    let text = format!("port left, time upwards, {:.3} m to each side", line.reach_m);
    encoder
        .add_text_chunk("Description".to_owned(), text)
        .map_err(|error| failed(plain(error)))?;
    let mut writer = encoder.write_header().map_err(|error| failed(plain(error)))?;
    let mut stream = writer.stream_writer().map_err(|error| failed(plain(error)))?;
    let mut pixels = vec![0; width];
    // The first ping is the lowest row, so that the picture is not mirrored.
    for ping in line.pings.iter().rev() {
        let [port, starboard] = rows.of(ping)?;
        for (column, amplitude) in port.iter().enumerate() {
            pixels[columns - 1 - column] = shade(scale.shade(0, column, *amplitude));
        }
        for (column, amplitude) in starboard.iter().enumerate() {
            pixels[columns + column] = shade(scale.shade(1, column, *amplitude));
        }
        stream.write_all(&pixels).map_err(failed)?;
    }
    stream.finish().map_err(|error| failed(plain(error)))?;
    writer.finish().map_err(|error| failed(plain(error)))?;
    output.commit()?;
    let mut exported = Exported::new(format!(
        "{width} x {height} pixels, {:.1} m to each side, {:.3} m a column",
        line.reach_m, grid.step_m
    ));
    exported.note_if(blind, "pings without an altitude, which are black");
    exported.note_left_out(source);
    Ok(exported)
}

/// The file's own error, which says more than the encoder's.
fn plain(error: png::EncodingError) -> io::Error {
    match error {
        png::EncodingError::IoError(error) => error,
        other @ (png::EncodingError::Format(_)
        | png::EncodingError::Parameter(_)
        | png::EncodingError::LimitsExceeded) => io::Error::other(other.to_string()),
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 255")]
pub(super) fn shade(shade: f32) -> u8 {
    shade.round() as u8
}

/// Rows of pings on a grid.
pub(super) struct Rows<'a, 's> {
    line: &'a Line<'s>,
    grid: Grid,
    ground: bool,
    sides: Sides,
    buffer: Vec<u8>,
    rows: [Vec<f32>; 2],
}

impl<'a, 's> Rows<'a, 's> {
    pub(super) fn new(line: &'a Line<'s>, grid: Grid, ground: bool) -> Self {
        Self {
            line,
            grid,
            ground,
            sides: Sides::default(),
            buffer: Vec::new(),
            rows: [Vec::new(), Vec::new()],
        }
    }

    /// Port and starboard of a ping, from the vehicle outwards.
    pub(super) fn of(&mut self, ping: &PingPlace) -> Result<&[Vec<f32>; 2], Error> {
        let Self {
            line,
            grid,
            ground,
            sides,
            buffer,
            rows,
        } = self;
        let altitude_m = ping.altitude_m().filter(|_| *ground);
        line.read(ping, buffer, sides, |_, _, sides| {
            for (side, row) in sides.iter().zip(rows.iter_mut()) {
                if *ground && altitude_m.is_none() && !side.ground {
                    row.clear();
                    row.resize(grid.columns, f32::NAN);
                } else {
                    fill(side, *grid, altitude_m, row);
                }
            }
        })?;
        Ok(&self.rows)
    }
}
