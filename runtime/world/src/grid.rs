//! A grid of depths or elevations, with the values of its file.

mod directory;
mod esri_ascii;
mod geotiff;

use core::fmt;
use std::sync::Arc;

use serde::Deserialize;

use crate::error::WorldError;

/// What the coordinates of a grid are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GridFrame {
    /// Metres east and north of the world's origin.
    #[default]
    Local,
    /// Degrees of longitude and latitude, WGS84.
    Geographic,
}

/// What the values of a grid are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GridPositive {
    /// Depths: positive under water.
    #[default]
    Down,
    /// Elevations: negative under water.
    Up,
}

/// A regular grid with a value at the centre of each cell, rows from the north, columns from the west.
///
/// Values are stored in single precision (half a millimetre at 6000 m). Clones share them, so you can read a file once
/// and draw any number of worlds over it.
#[derive(Clone, PartialEq)]
pub struct Grid {
    layout: Layout,
    /// [`NO_DATA`] where the file has no value.
    values: Arc<Vec<f32>>,
}

/// The positions of a grid's cells, in the unit of its file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Layout {
    pub(crate) columns: usize,
    pub(crate) rows: usize,
    /// Centre of the first column.
    pub(crate) west: f64,
    /// Centre of the first row.
    pub(crate) north: f64,
    /// Width and height of a cell.
    pub(crate) cell_east: f64,
    pub(crate) cell_north: f64,
    /// What the file says about its coordinates, if it says anything.
    pub(crate) declared: Option<GridFrame>,
}

/// Marks a cell without a value. No depth or elevation is as great, see [`VALUE_MAX_M`].
const NO_DATA: f32 = f32::MAX;
/// More than any depth of the sea and any height of a mountain, metres.
const VALUE_MAX_M: f64 = 12_000.0;
/// The most cells that a grid may have. They take 100 MB.
const CELLS_MAX: usize = 25_000_000;
/// The text for error messages.
const VALUE_EXPECTED: &str = "a number, -12000 to 12000 m";

/// A value of the bilinear surface, and its slopes per unit of the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sample {
    pub(crate) value: f64,
    pub(crate) slope_east: f64,
    pub(crate) slope_north: f64,
}

impl Grid {
    /// Reads the content of a file: a GeoTIFF if the first bytes say so, otherwise an ESRI ASCII grid.
    ///
    /// # Errors
    /// [`WorldError`] as [`Grid::from_geotiff`] and [`Grid::from_esri_ascii`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, WorldError> {
        if bytes.starts_with(b"II") || bytes.starts_with(b"MM") {
            return Self::from_geotiff(bytes);
        }
        match core::str::from_utf8(bytes) {
            Ok(text) => Self::from_esri_ascii(text),
            Err(error) => {
                let before = bytes.get(..error.valid_up_to()).unwrap_or_default();
                Err(WorldError::GridText {
                    line: 1 + before.iter().filter(|byte| **byte == b'\n').count(),
                    found: "bytes that are not text".to_owned(),
                    expected: "an ESRI ASCII grid or a GeoTIFF".to_owned(),
                })
            }
        }
    }

    /// Reads an ESRI ASCII grid: `ncols`, `nrows`, `xllcorner` or `xllcenter`, `yllcorner` or `yllcenter`, `cellsize`
    /// and optionally `NODATA_value` (-9999 if it is absent), in upper or lower case and in any order; then the values,
    /// rows from the north, on any number of lines.
    ///
    /// Source: ESRI, "Esri ASCII raster format", ArcGIS documentation.
    ///
    /// # Errors
    /// [`WorldError::GridText`] with line and value if the text does not have that form, if a value is beyond ±12,000
    /// m, or if the grid has fewer than two rows or columns or more than 25 million cells. The length of the text
    /// bounds the memory, whatever the header says.
    pub fn from_esri_ascii(text: &str) -> Result<Self, WorldError> {
        esri_ascii::read(text)
    }

    /// Reads the first image of a GeoTIFF: one band of integers or floats, in strips or tiles, uncompressed, LZW,
    /// deflate or PackBits. North must be up: the file has a pixel scale and one tie point. A value equal to
    /// `GDAL_NODATA`, or NaN, means no data.
    ///
    /// Source: OGC 19-008r4, GeoTIFF 1.1, annex B (tags) and section 7.5 (raster space); GDAL's documentation for
    /// `GDAL_NODATA`.
    ///
    /// # Errors
    /// [`WorldError::GridTiff`] if the file does not have that form or is truncated, if a value is beyond ±12,000 m, or
    /// if the grid has fewer than two rows or columns or more than 25 million cells. What a file of this length can
    /// hold bounds the memory, whatever its tags say.
    pub fn from_geotiff(bytes: &[u8]) -> Result<Self, WorldError> {
        geotiff::read(bytes)
    }

    /// Number of columns, 2 or more.
    #[must_use]
    pub const fn columns(&self) -> usize {
        self.layout.columns
    }

    /// Number of rows, 2 or more.
    #[must_use]
    pub const fn rows(&self) -> usize {
        self.layout.rows
    }

    /// The value of a cell in the file, metres. `row` counts from 0 in the north, `column` from 0 in the west. `None`
    /// for a cell without data and outside the grid.
    #[must_use]
    pub fn value(&self, row: usize, column: usize) -> Option<f64> {
        if column >= self.layout.columns {
            return None;
        }
        let value = *self
            .values
            .get(row.checked_mul(self.layout.columns)?.checked_add(column)?)?;
        (value != NO_DATA).then_some(f64::from(value))
    }

    pub(crate) const fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Row and column, from 0, of the first cell without a value.
    pub(crate) fn first_without_data(&self) -> Option<(usize, usize)> {
        let index = self.values.iter().position(|value| *value == NO_DATA)?;
        Some((index / self.layout.columns, index % self.layout.columns))
    }

    /// The bilinear surface through the centres of the cells, at a place in the file's unit. Outside the outermost
    /// centres it is level and has the nearest value. Cells without a value have the value `no_data`.
    pub(crate) fn sample(&self, x: f64, y: f64, no_data: f64) -> Sample {
        let layout = &self.layout;
        let (column, across, east_per_unit) = share(x - layout.west, layout.cell_east, layout.columns);
        let (row, down, south_per_unit) = share(layout.north - y, layout.cell_north, layout.rows);
        let corner = |row: usize, column: usize| match self.values.get(row * layout.columns + column) {
            Some(value) if *value != NO_DATA => f64::from(*value),
            _ => no_data,
        };
        let (north_west, north_east) = (corner(row, column), corner(row, column + 1));
        let (south_west, south_east) = (corner(row + 1, column), corner(row + 1, column + 1));
        let north = north_west + (north_east - north_west) * across;
        let south = south_west + (south_east - south_west) * across;
        let (along_north, along_south) = (north_east - north_west, south_east - south_west);
        Sample {
            value: north + (south - north) * down,
            slope_east: (along_north + (along_south - along_north) * down) * east_per_unit,
            slope_north: (north - south) * south_per_unit,
        }
    }
}

impl fmt::Debug for Grid {
    /// Leaves out the values, because there may be millions.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Grid")
            .field("layout", &self.layout)
            .finish_non_exhaustive()
    }
}

/// For a distance from the first centre: the index of its cell, how far it is into the cell (0 to 1), and how much of a
/// cell one unit is. The last is 0 outside, where the surface is level.
fn share(distance: f64, cell: f64, count: usize) -> (usize, f64, f64) {
    let cells = distance / cell;
    let last = (count - 1) as f64;
    let inside = (0.0..=last).contains(&cells);
    let cells = cells.clamp(0.0, last);
    let index = (cells as usize).min(count - 2);
    (index, cells - index as f64, if inside { 1.0 / cell } else { 0.0 })
}

/// Text from a file, cut short so that it fits into a message of one line.
fn quoted(text: &str) -> String {
    let mut quoted: String = text.chars().take(40).flat_map(char::escape_debug).collect();
    if text.chars().nth(40).is_some() {
        quoted.push_str("...");
    }
    format!("`{quoted}`")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> Grid {
        Grid::from_esri_ascii("ncols 3 nrows 2 xllcenter 10 yllcenter 20 cellsize 4\n1 2 4\n8 16 32").unwrap()
    }

    #[test]
    fn the_surface_passes_through_the_centres_and_is_bilinear_between() {
        let grid = grid();
        assert_eq!((grid.rows(), grid.columns()), (2, 3));
        assert_eq!(
            (grid.value(0, 2), grid.value(1, 0), grid.value(1, 3)),
            (Some(4.0), Some(8.0), None)
        );
        assert_eq!(grid.sample(14.0, 24.0, 0.0).value, 2.0);
        assert_eq!(grid.sample(18.0, 20.0, 0.0).value, 32.0);
        // A quarter of a cell east and half a cell south: the mean of 1 + 0.25 and 8 + 2.
        let sample = grid.sample(11.0, 22.0, 0.0);
        assert_eq!(sample.value, (1.25 + 10.0) / 2.0);
        assert_eq!(sample.slope_east, (1.0 + 8.0) / 2.0 / 4.0);
        assert_eq!(sample.slope_north, (1.25 - 10.0) / 4.0);
    }

    #[test]
    fn outside_a_grid_has_the_value_of_its_nearest_edge() {
        let grid = grid();
        let beyond = grid.sample(1000.0, 22.0, 0.0);
        assert_eq!((beyond.value, beyond.slope_east, beyond.slope_north), (18.0, 0.0, -7.0));
        let corner = grid.sample(-1e300, 1e300, 0.0);
        assert_eq!((corner.value, corner.slope_east, corner.slope_north), (1.0, 0.0, 0.0));
        assert!(grid.sample(f64::NAN, 20.0, 0.0).value.is_nan());
    }

    #[test]
    fn a_file_that_is_neither_text_nor_tiff_is_rejected_with_its_line() {
        let error = Grid::from_bytes(b"ncols 2\n\xff\xfe").unwrap_err();
        assert_eq!(
            error.to_string(),
            "grid, line 2: bytes that are not text, expected an ESRI ASCII grid or a GeoTIFF"
        );
    }
}
