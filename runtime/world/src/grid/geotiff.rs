use std::io::Cursor;
use std::sync::Arc;

use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::{CompressionMethod, Tag};
use tiff::{ColorType, TiffError};

use super::{Grid, GridFrame, Layout, NO_DATA, VALUE_EXPECTED, VALUE_MAX_M, directory, quoted};
use crate::error::WorldError;

/// The greatest ratio of packing by LZW and deflate: a 12-bit LZW code stands for up to 4 kB, and deflate reaches 1032
/// to 1 (zlib's technical details).
const PACKING_MAX: usize = 1400;
/// GTModelTypeGeoKey and GTRasterTypeGeoKey: GeoTIFF 1.1, section 7.5.
const MODEL_TYPE: u16 = 1024;
const RASTER_TYPE: u16 = 1025;

type Source<'bytes> = Decoder<Cursor<&'bytes [u8]>>;

pub(super) fn read(bytes: &[u8]) -> Result<Grid, WorldError> {
    directory::inspect(bytes)?;
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(unreadable)?;
    let (width, height) = decoder.dimensions().map_err(unreadable)?;
    let (columns, rows) = (width as usize, height as usize);
    let bytes_needed = columns * rows * sample_bytes(&mut decoder)?;
    let compression = decoder.find_tag_unsigned::<u16>(Tag::Compression).map_err(unreadable)?;
    let packed = compression.is_some_and(|method| method != CompressionMethod::None.to_u16());
    let holds = bytes.len().saturating_mul(if packed { PACKING_MAX } else { 1 });
    if bytes_needed > holds {
        let found = format!("{} bytes long", bytes.len());
        return Err(fault(
            "the file",
            found,
            "enough for the image that its tags describe: it is truncated",
        ));
    }
    let layout = layout(&mut decoder, columns, rows)?;
    let no_data = no_data(&mut decoder)?;
    let mut limits = Limits::default();
    limits.decoding_buffer_size = bytes_needed;
    limits.intermediate_buffer_size = bytes.len();
    let mut decoder = decoder.with_limits(limits);
    let values = match decoder.read_image().map_err(unreadable)? {
        DecodingResult::U8(values) => cells(columns, no_data, values.into_iter().map(f64::from)),
        DecodingResult::I8(values) => cells(columns, no_data, values.into_iter().map(f64::from)),
        DecodingResult::U16(values) => cells(columns, no_data, values.into_iter().map(f64::from)),
        DecodingResult::I16(values) => cells(columns, no_data, values.into_iter().map(f64::from)),
        DecodingResult::U32(values) => cells(columns, no_data, values.into_iter().map(f64::from)),
        DecodingResult::I32(values) => cells(columns, no_data, values.into_iter().map(f64::from)),
        // The tag is a text and may have more digits than the cells, so it is rounded as they are.
        DecodingResult::F32(values) => {
            let no_data = no_data.map(|value| f64::from(value as f32));
            cells(columns, no_data, values.into_iter().map(f64::from))
        }
        DecodingResult::F64(values) => cells(columns, no_data, values.into_iter()),
        DecodingResult::U64(_) | DecodingResult::I64(_) | DecodingResult::F16(_) => Err(fault(
            "SampleFormat",
            "64-bit integers or half floats".to_owned(),
            SAMPLES_EXPECTED,
        )),
    }?;
    if values.len() != columns * rows {
        let found = format!("{} values", values.len());
        return Err(fault("the image", found, "one for each cell"));
    }
    Ok(Grid {
        layout,
        values: Arc::new(values),
    })
}

const SAMPLES_EXPECTED: &str = "one band of integers of 8, 16 or 32 bits, or floats of 32 or 64";

/// Bytes per cell.
fn sample_bytes(decoder: &mut Source<'_>) -> Result<usize, WorldError> {
    let color = decoder.colortype().map_err(unreadable)?;
    if let ColorType::Gray(bits) = color
        && matches!(bits, 8 | 16 | 32 | 64)
    {
        return Ok(usize::from(bits / 8));
    }
    Err(fault("the image", format!("{color:?}"), SAMPLES_EXPECTED))
}

fn cells(
    columns: usize,
    no_data: Option<f64>,
    values: impl ExactSizeIterator<Item = f64>,
) -> Result<Vec<f32>, WorldError> {
    let mut cells = Vec::with_capacity(values.len());
    for value in values {
        if value.is_nan() || no_data == Some(value) {
            cells.push(NO_DATA);
        } else if value.abs() <= VALUE_MAX_M {
            cells.push(value as f32);
        } else {
            let (row, column) = (cells.len() / columns + 1, cells.len() % columns + 1);
            return Err(fault(
                "a cell",
                format!("{value} (row {row}, column {column})"),
                VALUE_EXPECTED,
            ));
        }
    }
    Ok(cells)
}

fn layout(decoder: &mut Source<'_>, columns: usize, rows: usize) -> Result<Layout, WorldError> {
    let scale_expected = "two numbers above 0: the width and height of a pixel";
    let scale = floats(decoder, Tag::ModelPixelScaleTag)?;
    let &[cell_east, cell_north, ..] = scale.as_slice() else {
        return Err(fault("ModelPixelScale (33550)", absent(&scale), scale_expected));
    };
    for cell in [cell_east, cell_north] {
        if !(cell > 0.0 && cell <= 1e6) {
            return Err(fault("ModelPixelScale (33550)", format!("{cell}"), scale_expected));
        }
    }
    let tie = floats(decoder, Tag::ModelTiepointTag)?;
    let &[column, row, _, x, y, _] = tie.as_slice() else {
        let expected = "one tie point: six numbers";
        return Err(fault("ModelTiepoint (33922)", absent(&tie), expected));
    };
    for number in [column, row, x, y] {
        if number.is_nan() || number.abs() > 1e9 {
            return Err(fault(
                "ModelTiepoint (33922)",
                format!("{number}"),
                "coordinates, -1e9 to 1e9",
            ));
        }
    }
    let keys = geo_keys(decoder)?;
    let key = |wanted: u16| keys.iter().find(|(key, _)| *key == wanted).map(|(_, value)| *value);
    // With PixelIsArea, the default, raster coordinates are those of corners; with PixelIsPoint, those of centres.
    let half = if key(RASTER_TYPE) == Some(2) { 0.0 } else { 0.5 };
    Ok(Layout {
        columns,
        rows,
        west: x + (half - column) * cell_east,
        north: y - (half - row) * cell_north,
        cell_east,
        cell_north,
        declared: match key(MODEL_TYPE) {
            Some(1) => Some(GridFrame::Local),
            Some(2) => Some(GridFrame::Geographic),
            _ => None,
        },
    })
}

/// The keys of the GeoKeyDirectory that have their value in the directory itself.
fn geo_keys(decoder: &mut Source<'_>) -> Result<Vec<(u16, u16)>, WorldError> {
    let Some(value) = decoder.find_tag(Tag::GeoKeyDirectoryTag).map_err(unreadable)? else {
        return Ok(Vec::new());
    };
    let numbers = value.into_u16_vec().map_err(unreadable)?;
    let (entries, _) = numbers.as_chunks::<4>();
    let keys = entries.iter().skip(1).filter(|[_, location, _, _]| *location == 0);
    Ok(keys.map(|&[key, _, _, value]| (key, value)).collect())
}

fn no_data(decoder: &mut Source<'_>) -> Result<Option<f64>, WorldError> {
    let Some(value) = decoder.find_tag(Tag::GdalNodata).map_err(unreadable)? else {
        return Ok(None);
    };
    let text = value.into_string().map_err(unreadable)?;
    let text = text.trim_matches(|c: char| c == '\0' || c.is_whitespace());
    text.parse()
        .map(Some)
        .map_err(|_| fault("GDAL_NODATA (42113)", quoted(text), "a number"))
}

fn floats(decoder: &mut Source<'_>, tag: Tag) -> Result<Vec<f64>, WorldError> {
    match decoder.find_tag(tag).map_err(unreadable)? {
        Some(value) => value.into_f64_vec().map_err(unreadable),
        None => Ok(Vec::new()),
    }
}

fn absent(numbers: &[f64]) -> String {
    if numbers.is_empty() {
        "missing".to_owned()
    } else {
        format!("{} numbers", numbers.len())
    }
}

fn unreadable(error: TiffError) -> WorldError {
    let mut found = error.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
    if let Some((cut, _)) = found.char_indices().nth(200) {
        found.truncate(cut);
    }
    fault(
        "the file",
        format!("unreadable ({found})"),
        "a complete GeoTIFF with one band",
    )
}

pub(super) fn fault(what: &'static str, found: String, expected: &'static str) -> WorldError {
    WorldError::GridTiff { what, found, expected }
}
