//! GeoTIFF grids: from the decoder's own encoder where it can write them, and built by hand where it cannot (tiles, big
//! endian).

use std::io::Cursor;

use backseat_units::EastNorth;
use backseat_world::{Grid, World, WorldConfig};
use tiff::encoder::colortype::{ColorType, Gray8, Gray16, Gray32Float, Gray64Float, GrayI16, GrayI32};
use tiff::encoder::{Compression, TiffEncoder, TiffValue};
use tiff::tags::{Predictor, Tag};

/// Five by four cells; the last one is marked as no data.
pub(crate) const VALUES: [i16; 20] = [
    10, 11, 12, 13, 14, 20, 21, 22, 23, 24, 30, 31, 32, 33, 34, 40, 41, 42, 43, -999,
];

/// A GeoTIFF of a north-up grid of 10 m cells whose north-western corner is 25 m west and 20 m north of the origin.
fn encode<C: ColorType>(values: &[C::Inner], compression: Compression, predictor: Predictor) -> Vec<u8>
where
    [C::Inner]: TiffValue,
{
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut bytes)
        .unwrap()
        .with_compression(compression)
        .with_predictor(predictor);
    let mut image = encoder.new_image::<C>(5, 4).unwrap();
    image.rows_per_strip(2).unwrap();
    let tags = image.encoder();
    tags.write_tag(Tag::ModelPixelScaleTag, &[10.0, 10.0, 0.0][..]).unwrap();
    tags.write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, -25.0, 20.0, 0.0][..])
        .unwrap();
    tags.write_tag(Tag::GdalNodata, "-999").unwrap();
    image.write_data(values).unwrap();
    bytes.into_inner()
}

pub(crate) fn float_grid() -> Vec<u8> {
    let values: Vec<f32> = VALUES.iter().map(|value| f32::from(*value)).collect();
    encode::<Gray32Float>(&values, Compression::Deflate(Default::default()), Predictor::None)
}

/// The grid that every encoding of [`VALUES`] must give.
fn expected() -> Grid {
    let mut text = "ncols 5 nrows 4 xllcorner -25 yllcorner -20 cellsize 10 nodata_value -999".to_owned();
    for value in VALUES {
        text.push_str(&format!(" {value}"));
    }
    Grid::from_esri_ascii(&text).unwrap()
}

#[test]
fn integers_and_floats_are_read_packed_and_unpacked() {
    let expected = expected();
    let float: Vec<f32> = VALUES.iter().map(|value| f32::from(*value)).collect();
    let double: Vec<f64> = VALUES.iter().map(|value| f64::from(*value)).collect();
    let long: Vec<i32> = VALUES.iter().map(|value| i32::from(*value)).collect();
    for compression in [
        Compression::Uncompressed,
        Compression::Lzw,
        Compression::Deflate(Default::default()),
        Compression::Packbits,
    ] {
        let predictor = Predictor::None;
        for bytes in [
            encode::<Gray32Float>(&float, compression, predictor),
            encode::<Gray64Float>(&double, compression, predictor),
            encode::<GrayI16>(&VALUES, compression, predictor),
            encode::<GrayI32>(&long, compression, predictor),
            encode::<GrayI16>(&VALUES, compression, Predictor::Horizontal),
        ] {
            assert_eq!(Grid::from_bytes(&bytes).unwrap(), expected);
        }
    }
}

#[test]
fn unsigned_integers_are_read() {
    let words: Vec<u16> = VALUES.iter().map(|value| value.unsigned_abs()).collect();
    let bytes: Vec<u8> = words.iter().map(|value| (*value).min(255) as u8).collect();
    let grid = Grid::from_geotiff(&encode::<Gray16>(&words, Compression::Lzw, Predictor::None)).unwrap();
    assert_eq!((grid.value(0, 0), grid.value(3, 4)), (Some(10.0), Some(999.0)));
    let grid = Grid::from_geotiff(&encode::<Gray8>(&bytes, Compression::Lzw, Predictor::None)).unwrap();
    assert_eq!((grid.value(3, 3), grid.value(3, 4)), (Some(43.0), Some(255.0)));
}

#[test]
fn big_tiffs_are_read() {
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new_big(&mut bytes).unwrap();
    let mut image = encoder.new_image::<GrayI16>(5, 4).unwrap();
    let tags = image.encoder();
    tags.write_tag(Tag::ModelPixelScaleTag, &[10.0, 10.0, 0.0][..]).unwrap();
    tags.write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, -25.0, 20.0, 0.0][..])
        .unwrap();
    tags.write_tag(Tag::GdalNodata, "-999").unwrap();
    image.write_data(&VALUES).unwrap();
    let bytes = bytes.into_inner();
    assert_eq!(Grid::from_bytes(&bytes).unwrap(), expected());
    for length in 0..bytes.len() {
        assert!(Grid::from_bytes(&bytes[..length]).is_err(), "{length}");
    }
}

#[test]
fn a_world_uses_a_geotiff_grid() {
    let text = "
        [origin]
        latitude_deg = 42.3
        longitude_deg = -70.9
        [seabed]
        grid = \"bed.tif\"
        grid_nodata_depth_m = 50
    ";
    let config: WorldConfig = toml::from_str(text).unwrap();
    let grid = Grid::from_bytes(&float_grid()).unwrap();
    let world = World::with_grid(&config, 1, Some(grid.clone())).unwrap();
    // The middle of the top row of cells, and the cell without data.
    assert_eq!(world.water_depth_m(EastNorth::new(0.0, 15.0)), 12.0);
    assert_eq!(world.water_depth_m(EastNorth::new(20.0, -15.0)), 50.0);
    let gradient = world.gradient(EastNorth::new(-10.0, 10.0));
    assert!((gradient.east_m - 0.1).abs() < 1e-12 && (gradient.north_m + 1.0).abs() < 1e-12);
    // A name without a grid and a grid without a name are refused.
    assert!(World::new(&config, 1).is_err());
    let unnamed = WorldConfig {
        seabed: backseat_world::SeabedConfig::default(),
        ..config
    };
    let error = World::with_grid(&unnamed, 1, Some(grid)).unwrap_err();
    assert_eq!(error.to_string(), "seabed.grid: expected the name of the grid's file");
}

/// A TIFF built by hand: big endian and uncompressed, with tags as (number, type, values), and with the pixels after
/// them.
fn by_hand(tags: &[(u16, u16, Vec<f64>)], pixels: &[u8]) -> Vec<u8> {
    let mut bytes = b"MM\0\x2a\0\0\0\x08".to_vec();
    let directory = 8 + 2 + 12 * tags.len() + 4;
    let (mut entries, mut behind) = (Vec::new(), Vec::new());
    for (tag, kind, values) in tags {
        let mut content = Vec::new();
        for value in values {
            match kind {
                2 => content.push(*value as u8),
                3 => content.extend((*value as u16).to_be_bytes()),
                4 => content.extend((*value as u32).to_be_bytes()),
                _ => content.extend(value.to_be_bytes()),
            }
        }
        entries.extend(tag.to_be_bytes());
        entries.extend(kind.to_be_bytes());
        entries.extend((values.len() as u32).to_be_bytes());
        if content.len() <= 4 {
            content.resize(4, 0);
            entries.extend(content);
        } else {
            entries.extend(((directory + behind.len()) as u32).to_be_bytes());
            behind.extend(content);
        }
    }
    bytes.extend((tags.len() as u16).to_be_bytes());
    bytes.extend(entries);
    bytes.extend([0; 4]);
    bytes.extend(behind);
    bytes.extend(pixels);
    bytes
}

/// A TIFF of 3 by 2 integers of 16 bits in one tile of 16 by 16, with these additional tags.
pub(crate) fn tiled(more: &[(u16, u16, Vec<f64>)]) -> Vec<u8> {
    let mut pixels = vec![0u8; 512];
    for (index, value) in [(0, 7u16), (1, 8), (2, 9), (16, 17), (17, 18), (18, 19)] {
        pixels[2 * index..2 * index + 2].copy_from_slice(&value.to_be_bytes());
    }
    let build = |offset: f64| {
        let mut tags = vec![
            (256, 3, vec![3.0]),
            (257, 3, vec![2.0]),
            (258, 3, vec![16.0]),
            (259, 3, vec![1.0]),
            (262, 3, vec![1.0]),
            (277, 3, vec![1.0]),
            (322, 3, vec![16.0]),
            (323, 3, vec![16.0]),
            (324, 4, vec![offset]),
            (325, 4, vec![512.0]),
            (339, 3, vec![2.0]),
        ];
        tags.extend_from_slice(more);
        by_hand(&tags, &pixels)
    };
    let length = build(0.0).len();
    build((length - 512) as f64)
}

pub(crate) fn georeference() -> Vec<(u16, u16, Vec<f64>)> {
    vec![
        (33550, 12, vec![0.5, 0.25, 0.0]),
        (33922, 12, vec![1.0, 1.0, 0.0, -70.0, 42.0, 0.0]),
        (
            34735,
            3,
            vec![1.0, 1.0, 0.0, 2.0, 1024.0, 0.0, 1.0, 2.0, 1025.0, 0.0, 1.0, 2.0],
        ),
    ]
}

#[test]
fn tiles_points_and_the_files_own_frame_are_read() {
    let grid = Grid::from_geotiff(&tiled(&georeference())).unwrap();
    assert_eq!((grid.columns(), grid.rows()), (3, 2));
    assert_eq!((grid.value(0, 2), grid.value(1, 0)), (Some(9.0), Some(17.0)));
    let config = |frame: &str| -> WorldConfig {
        toml::from_str(&format!(
            "[origin]\nlatitude_deg = 42.0\nlongitude_deg = -70.0\n[seabed]\ngrid = \"a.tif\"\ngrid_frame = \"{frame}\""
        ))
        .unwrap()
    };
    // The pixel is a point: the tie point is the centre of the second column and row.
    let world = World::with_grid(&config("geographic"), 1, Some(grid.clone())).unwrap();
    let depth_m = world.water_depth_m(EastNorth::default());
    assert!((depth_m - 18.0).abs() < 1e-6, "{depth_m}");
    let error = World::with_grid(&config("local"), 1, Some(grid)).unwrap_err();
    assert_eq!(
        error.to_string(),
        "seabed.grid_frame: expected what GTModelType in the GeoTIFF says"
    );
}

#[test]
fn missing_and_invalid_tags_are_named() {
    let message = |bytes: &[u8]| {
        let message = Grid::from_geotiff(bytes).unwrap_err().to_string();
        assert!(!message.contains('\n'), "{message}");
        message
    };
    assert_eq!(
        message(&tiled(&[])),
        "grid, GeoTIFF: ModelPixelScale (33550) is missing, expected two numbers above 0: the width and height of a \
         pixel"
    );
    let mut tags = georeference();
    tags[0].2[1] = 0.0;
    assert!(message(&tiled(&tags)).starts_with("grid, GeoTIFF: ModelPixelScale (33550) is 0, expected"));
    tags[0].2[1] = 1.0;
    tags[1].2.truncate(3);
    assert!(message(&tiled(&tags)).starts_with("grid, GeoTIFF: ModelTiepoint (33922) is 3 numbers, expected"));
    let whole = tiled(&georeference());
    let mut tags = georeference();
    tags.push((42113, 2, vec![f64::from(b'9'), 0.0]));
    assert_eq!(Grid::from_geotiff(&tiled(&tags)).unwrap().value(0, 2), None);
    tags[3].2[0] = f64::from(b'x');
    assert_eq!(
        message(&tiled(&tags)),
        "grid, GeoTIFF: GDAL_NODATA (42113) is `x`, expected a number"
    );
    for length in [0, 1, 7, 60, whole.len() - 480] {
        assert!(Grid::from_geotiff(&whole[..length]).is_err(), "{length}");
    }
    // A value beyond any sea, with its cell.
    let mut values: Vec<f32> = VALUES.iter().map(|value| f32::from(*value)).collect();
    values[7] = 1e9;
    let bytes = encode::<Gray32Float>(&values, Compression::Uncompressed, Predictor::None);
    assert_eq!(
        message(&bytes),
        "grid, GeoTIFF: a cell is 1000000000 (row 2, column 3), expected a number, -12000 to 12000 m"
    );
    values[7] = f32::NAN;
    let bytes = encode::<Gray32Float>(&values, Compression::Uncompressed, Predictor::None);
    assert_eq!(Grid::from_geotiff(&bytes).unwrap().value(1, 2), None);
}
