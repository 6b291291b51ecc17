//! Sidescan (records 3000) as a georeferenced mosaic: GeoTIFF.

use std::path::Path;

use backseat_units::Position;
use backseat_units::math::sin_cos;
use nalgebra::Vector2;

use super::Exported;
use super::geotiff::{Georeference, write_geotiff};
use super::projection::{Crs, Projection};
use super::raster::{Blend, CELL_BYTES, Nadir, Raster, WEAK};
use super::waterfall::Rows;
use crate::error::Error;
use crate::moment::Moment;
use crate::selection::Selection;
use crate::sidescan::{AltitudeFrom, Gain, GainBy, Grid, Line, PingPlace, Sides};
use crate::source::Source;
use crate::track::Pose;

/// How to make a mosaic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mosaic {
    /// The coordinates.
    pub crs: Crs,
    /// Size of a cell, metres.
    pub resolution_m: f64,
    /// How samples share a cell.
    pub blend: Blend,
    /// What becomes of the strip below the vehicle.
    pub nadir: Nadir,
    /// Where the altitude comes from.
    pub altitude: AltitudeFrom,
    /// What amplitudes are divided by.
    pub gain: GainBy,
    /// Speed of sound, m/s; of record 3100, or 1500, if it is not set.
    pub sound_speed_mps: Option<f64>,
    /// The most memory that the raster may take, MiB.
    pub memory_mib: u64,
}

impl Default for Mosaic {
    fn default() -> Self {
        Self {
            crs: Crs::default(),
            resolution_m: 0.25,
            blend: Blend::default(),
            nadir: Nadir::default(),
            altitude: AltitudeFrom::default(),
            gain: GainBy::default(),
            sound_speed_mps: None,
            memory_mib: 512,
        }
    }
}

/// Samples are laid so close that no cell between two of them stays empty: this part of a cell apart.
const SPACING: f64 = 0.7;
/// The most columns of a side.
const COLUMNS_MAX: usize = 20_000;
/// Pings farther apart than this are not joined, seconds.
const JOINED_S: f64 = 3.0;
/// The strip below the vehicle reaches to this part of the altitude on each side.
const NADIR_PART: f64 = 0.3;

/// Where a ping is on the map.
#[derive(Clone, Copy, Debug)]
struct Placed {
    at: Moment,
    /// The vehicle.
    centre: Vector2<f64>,
    /// A metre to starboard.
    starboard: Vector2<f64>,
    /// The strip below the vehicle reaches so far, metres.
    nadir_m: f64,
}

/// Lays the sidescan of a selection, which must be of one device, on a map and writes it as an 8-bit GeoTIFF: 1 to 255,
/// and 0 where nothing is. Ranges are along the seabed, which is taken to be flat. Between pings values are
/// interpolated.
///
/// # Errors
/// [`Error::Read`] and [`Error::Write`]; [`Error::Contents`] if there is no sidescan, of several devices, no position or
/// altitude, or if the raster would be over the limit; [`Error::Option`] for an option out of range.
pub fn export_mosaic(source: &Source, selection: &Selection, mosaic: &Mosaic, out: &Path) -> Result<Exported, Error> {
    if !(0.01..=1000.0).contains(&mosaic.resolution_m) {
        return Err(Error::Option {
            option: "--resolution",
            fault: "expected 0.01 to 1000 m".to_owned(),
        });
    }
    let line = Line::survey(source, selection, mosaic.altitude, mosaic.sound_speed_mps)?;
    let survey = Survey::of(source, &line, mosaic)?;
    let mut raster = survey.raster(source, mosaic)?;
    let grid = survey.grid;
    let mut rows = Rows::new(&line, grid, true);
    let mut gain = Gain::new(grid.columns);
    for (ping, _) in &survey.placed {
        for (side, row) in rows.of(ping)?.iter().enumerate() {
            gain.add(side, row);
        }
    }
    let scale = gain.finish(mosaic.gain);
    let mut before: Option<(Placed, [Vec<f32>; 2])> = None;
    for (ping, placed) in &survey.placed {
        let mut shades = [Vec::new(), Vec::new()];
        for (side, (row, shades)) in rows.of(ping)?.iter().zip(&mut shades).enumerate() {
            shades.extend(
                row.iter()
                    .enumerate()
                    .map(|(column, amplitude)| scale.shade(side, column, *amplitude)),
            );
        }
        if let Some((placed_before, shades_before)) = &before
            && placed.at.seconds_since(placed_before.at).abs() <= JOINED_S
        {
            survey.lay(&mut raster, mosaic, (placed_before, shades_before), (placed, &shades));
        }
        before = Some((*placed, shades));
    }
    let georeference = Georeference {
        epsg: survey.projection.epsg(),
        projected: matches!(survey.projection, Projection::Utm { .. }),
        cell: survey.cell,
        corner: Vector2::new(survey.corner.x, survey.opposite.y),
    };
    write_geotiff(source, &raster, &georeference, out)?;
    let mut exported = Exported::new(format!(
        "{} x {} cells of {} m, EPSG:{}",
        raster.width, raster.height, mosaic.resolution_m, georeference.epsg
    ));
    exported.note_if(survey.unplaced, "pings left out without a time, position or heading");
    exported.note_if(survey.blind, "pings left out without an altitude");
    exported.note_left_out(source);
    Ok(exported)
}

impl Placed {
    /// The place at so many metres to starboard (to port if negative).
    fn across(&self, metres: f64) -> Vector2<f64> {
        self.centre + self.starboard * metres
    }
}

/// What the first passes find.
struct Survey {
    projection: Projection,
    placed: Vec<(PingPlace, Placed)>,
    unplaced: usize,
    blind: usize,
    grid: Grid,
    /// Size of a cell on the map.
    cell: Vector2<f64>,
    /// The corner in the south-west.
    corner: Vector2<f64>,
    /// The corner in the north-east.
    opposite: Vector2<f64>,
}

impl Survey {
    fn of(source: &Source, line: &Line<'_>, mosaic: &Mosaic) -> Result<Self, Error> {
        let mut survey: Option<Self> = None;
        let (mut unplaced, mut blind) = (0, 0);
        let (mut buffer, mut sides) = (Vec::new(), Sides::default());
        for ping in &line.pings {
            let found = line.read(ping, &mut buffer, &mut sides, |header, imagery, _| {
                let ground = crate::sidescan::is_ground(imagery);
                (Moment::of(&header.time), line.pose(header), ground)
            })?;
            let Some((Some(at), pose, ground)) = found else {
                unplaced += 1;
                continue;
            };
            let Some((position, heading_deg)) = place(&pose) else {
                unplaced += 1;
                continue;
            };
            let altitude_m = match (ping.altitude_m(), ground) {
                (_, true) => 0.0,
                (Some(altitude_m), false) => altitude_m,
                (None, false) => {
                    blind += 1;
                    continue;
                }
            };
            let survey = survey.get_or_insert_with(|| Self::begin(mosaic, line, position));
            survey.add(*ping, at, position, heading_deg, altitude_m, line.reach_m);
        }
        match survey {
            Some(survey) => Ok(Self {
                unplaced,
                blind,
                ..survey
            }),
            None if blind > 0 => Err(Error::contents(
                source.path(),
                "no altitude, which a mosaic needs: navigation (record 3100) has none, and no first bottom return is \
                 seen; export a picture instead (--to png)",
            )),
            None => Err(Error::contents(
                source.path(),
                "no ping has a position and a heading: a mosaic needs navigation (record 3100) at the times of the \
                 pings; export a picture instead (--to png)",
            )),
        }
    }

    fn begin(mosaic: &Mosaic, line: &Line<'_>, first: Position) -> Self {
        let projection = Projection::new(mosaic.crs, first);
        let step_m = SPACING * mosaic.resolution_m;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "positive, and limited"
        )]
        let columns = (line.reach_m / step_m).ceil().min(COLUMNS_MAX as f64) as usize;
        let cell = match projection {
            Projection::Utm { .. } => Vector2::repeat(mosaic.resolution_m),
            Projection::Wgs84 => projection.per_metre(first).diagonal() * mosaic.resolution_m,
        };
        Self {
            projection,
            placed: Vec::new(),
            unplaced: 0,
            blind: 0,
            grid: Grid {
                columns: columns.max(1),
                step_m: step_m.max(line.reach_m / COLUMNS_MAX as f64),
            },
            cell,
            corner: Vector2::repeat(f64::INFINITY),
            opposite: Vector2::repeat(f64::NEG_INFINITY),
        }
    }

    fn add(
        &mut self,
        ping: PingPlace,
        at: Moment,
        position: Position,
        heading_deg: f64,
        altitude_m: f64,
        reach_m: f64,
    ) {
        let (sin, cos) = sin_cos(heading_deg.to_radians());
        let placed = Placed {
            at,
            centre: self.projection.project(position),
            starboard: self.projection.per_metre(position) * Vector2::new(cos, -sin),
            nadir_m: NADIR_PART * altitude_m,
        };
        // Along the seabed the swath is shorter than the ray.
        let reach_m = (reach_m * reach_m - altitude_m * altitude_m).max(0.0).sqrt();
        for corner in [placed.across(-reach_m), placed.across(reach_m)] {
            self.corner = self.corner.inf(&corner);
            self.opposite = self.opposite.sup(&corner);
        }
        self.placed.push((ping, placed));
    }

    /// Makes the raster, if it is not over the limit.
    fn raster(&self, source: &Source, mosaic: &Mosaic) -> Result<Raster, Error> {
        let cells = (self.opposite - self.corner).component_div(&self.cell);
        let (width, height) = (cells.x.ceil().max(1.0) + 1.0, cells.y.ceil().max(1.0) + 1.0);
        #[expect(clippy::cast_precision_loss, reason = "a size needs no more digits")]
        let needed_mib = width * height * CELL_BYTES as f64 / f64::from(1 << 20);
        #[expect(clippy::cast_precision_loss, reason = "a size needs no more digits")]
        let limit_mib = mosaic.memory_mib as f64;
        if needed_mib > limit_mib {
            let coarser = mosaic.resolution_m * (needed_mib / limit_mib).sqrt();
            let what = format!(
                "the mosaic would have {width} x {height} cells, {needed_mib:.0} MiB, over the limit of {limit_mib} MiB: \
                 set --resolution to {:.2} or more, raise --memory, or export a part with --from and --until",
                (coarser * 1.01 * 100.0).ceil() / 100.0
            );
            return Err(Error::contents(source.path(), what));
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "within the limit of memory"
        )]
        Ok(Raster::new(width as usize, height as usize, mosaic.blend))
    }

    /// A place on the map in cells from the upper left corner.
    fn cell_of(&self, place: Vector2<f64>) -> Vector2<f64> {
        Vector2::new(
            (place.x - self.corner.x) / self.cell.x,
            (self.opposite.y - place.y) / self.cell.y,
        )
    }

    /// Fills the strip between two pings.
    fn lay(
        &self,
        raster: &mut Raster,
        mosaic: &Mosaic,
        (a, shades_a): (&Placed, &[Vec<f32>; 2]),
        (b, shades_b): (&Placed, &[Vec<f32>; 2]),
    ) {
        #[expect(clippy::cast_precision_loss, reason = "at most 20,000 columns")]
        let reach_m = self.grid.columns as f64 * self.grid.step_m;
        let apart = |metres: f64| (b.across(metres) - a.across(metres)).component_div(&self.cell).norm();
        let farthest = apart(-reach_m).max(apart(reach_m));
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "positive, and limited"
        )]
        let steps = (farthest / SPACING).ceil().clamp(1.0, 1e5) as u32;
        for step in 0..steps {
            let part = f64::from(step) / f64::from(steps);
            #[expect(clippy::cast_possible_truncation, reason = "a part of 1")]
            let weight_b = part as f32;
            let placed = Placed {
                at: a.at,
                centre: a.centre.lerp(&b.centre, part),
                starboard: a.starboard.lerp(&b.starboard, part),
                nadir_m: a.nadir_m + (b.nadir_m - a.nadir_m) * part,
            };
            for (side, sign) in [-1.0, 1.0].into_iter().enumerate() {
                for (column, (a, b)) in shades_a[side].iter().zip(&shades_b[side]).enumerate() {
                    // 0 is no sample.
                    if *a < 1.0 || *b < 1.0 {
                        continue;
                    }
                    #[expect(clippy::cast_precision_loss, reason = "at most 20,000 columns")]
                    let metres = (column as f64 + 0.5) * self.grid.step_m;
                    let weight = match mosaic.nadir {
                        Nadir::Below if metres < placed.nadir_m => WEAK,
                        Nadir::Drop if metres < placed.nadir_m => continue,
                        Nadir::Below | Nadir::Drop | Nadir::Keep => 1.0,
                    };
                    let shade = a + (b - a) * weight_b;
                    raster.lay(self.cell_of(placed.across(sign * metres)), shade, weight);
                }
            }
        }
    }
}

fn place(pose: &Pose) -> Option<(Position, f64)> {
    let (latitude, longitude) = pose.position_deg?;
    let position = Position::from_deg(latitude, longitude).ok()?;
    Some((position, pose.heading_deg?))
}
