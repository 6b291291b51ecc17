//! Writes a raster as GeoTIFF (GeoTIFF 1.0, 6.3; OGC 19-008r4).

use std::path::Path;

use nalgebra::Vector2;
use tiff::TiffError;
use tiff::encoder::colortype::Gray8;
use tiff::encoder::compression::DeflateLevel;
use tiff::encoder::{Compression, TiffEncoder};
use tiff::tags::Tag;

use super::raster::Raster;
use crate::error::Error;
use crate::output::Output;
use crate::source::Source;

/// Where a raster is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Georeference {
    /// The coordinate system's number in the EPSG register.
    pub(super) epsg: u16,
    /// Whether its coordinates are metres, and not degrees.
    pub(super) projected: bool,
    /// Size of a cell.
    pub(super) cell: Vector2<f64>,
    /// The upper left corner.
    pub(super) corner: Vector2<f64>,
}

/// Keys: the kind of coordinates, what a cell is, the coordinate system, its unit.
const MODEL_TYPE: u16 = 1024;
const RASTER_TYPE: u16 = 1025;
const GEOGRAPHIC_TYPE: u16 = 2048;
const ANGULAR_UNITS: u16 = 2054;
const PROJECTED_TYPE: u16 = 3072;
const LINEAR_UNITS: u16 = 3076;
/// Rows that are compressed at once.
const STRIP_ROWS: usize = 64;

impl Georeference {
    /// The directory of keys: version 1, revision 1.0, four keys with short values.
    fn keys(&self) -> [u16; 20] {
        let (model, system, unit, code) = if self.projected {
            (1, PROJECTED_TYPE, LINEAR_UNITS, 9001)
        } else {
            (2, GEOGRAPHIC_TYPE, ANGULAR_UNITS, 9102)
        };
        let (a, b) = ([MODEL_TYPE, 0, 1, model], [RASTER_TYPE, 0, 1, 1]);
        let (c, d) = ([system, 0, 1, self.epsg], [unit, 0, 1, code]);
        let mut keys = [0; 20];
        for (place, key) in keys.chunks_exact_mut(4).zip([[1, 1, 0, 4], a, b, c, d]) {
            place.copy_from_slice(&key);
        }
        keys
    }
}

/// Writes it, with 0 as the value of cells without data.
pub(super) fn write_geotiff(source: &Source, raster: &Raster, place: &Georeference, out: &Path) -> Result<(), Error> {
    let mut output = Output::create(out, source)?;
    encode(raster, place, &mut output).map_err(|error| {
        let error = match error {
            TiffError::IoError(error) => error,
            TiffError::FormatError(_)
            | TiffError::UnsupportedError(_)
            | TiffError::LimitsExceeded
            | TiffError::IntSizeError
            | TiffError::UsageError(_) => std::io::Error::other(error.to_string()),
        };
        Error::write(out, error)
    })?;
    output.commit()
}

fn encode(raster: &Raster, place: &Georeference, output: &mut Output) -> Result<(), TiffError> {
    let mut encoder = TiffEncoder::new(output)?.with_compression(Compression::Deflate(DeflateLevel::Balanced));
    let (width, height) = (u32::try_from(raster.width)?, u32::try_from(raster.height)?);
    let mut image = encoder.new_image::<Gray8>(width, height)?;
    image.rows_per_strip(u32::try_from(STRIP_ROWS)?)?;
    let tags = image.encoder();
    tags.write_tag(Tag::ModelPixelScaleTag, &[place.cell.x, place.cell.y, 0.0][..])?;
    let tie = [0.0, 0.0, 0.0, place.corner.x, place.corner.y, 0.0];
    tags.write_tag(Tag::ModelTiepointTag, &tie[..])?;
    tags.write_tag(Tag::GeoKeyDirectoryTag, &place.keys()[..])?;
    tags.write_tag(Tag::GdalNodata, "0")?;
    tags.write_tag(Tag::Software, concat!("backseat ", env!("CARGO_PKG_VERSION")))?;
    // `write_strip` leaves strips uncompressed under a tag that says otherwise (tiff 0.11.3): the whole raster is given.
    let mut shades = Vec::with_capacity(raster.width * raster.height);
    for row in 0..raster.height {
        raster.row(row, &mut shades);
    }
    image.write_data(&shades)
}
