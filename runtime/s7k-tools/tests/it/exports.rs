//! What each export writes, read back here without a reader of the format where that is simple. Readers that others
//! wrote open the same files in `tests/suite/scripts/sonar_exports.py`.

use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;

use backseat_s7k_tools::{
    AltitudeFrom, Blend, CsvOf, GainBy, Mosaic, Nadir, Selection, Signal, Source, Waterfall, export_csv, export_mosaic,
    export_segy, export_waterfall, export_xtf,
};
use tempfile::TempDir;

use crate::compose;
use crate::tools::recording;

struct Dive {
    folder: TempDir,
    source: Source,
}

impl Dive {
    fn of(bytes: &[u8]) -> Self {
        let (folder, path) = recording(bytes);
        let source = Source::open(&path).unwrap();
        Self { folder, source }
    }

    fn out(&self) -> PathBuf {
        self.folder.path().join("out")
    }

    fn written(&self) -> Vec<u8> {
        std::fs::read(self.out()).unwrap()
    }

    /// An error without the recording's path; nothing may have been written.
    fn refused<T: core::fmt::Debug>(&self, result: Result<T, backseat_s7k_tools::Error>) -> String {
        let error = result.unwrap_err().to_string();
        assert!(!error.contains('\n'), "{error}");
        assert_eq!(std::fs::read_dir(self.folder.path()).unwrap().count(), 1, "{error}");
        error.replace(&format!("{}: ", self.source.path().display()), "")
    }
}

fn device(number: u32) -> Selection {
    Selection {
        devices: vec![number],
        ..Selection::default()
    }
}

/// The survey without the records of some types.
fn without(types: &[u32]) -> Vec<u8> {
    let records: Vec<_> = compose::records()
        .into_iter()
        .filter(|record| !types.contains(&u32::from_le_bytes(record[32..36].try_into().unwrap())))
        .collect();
    compose::file(&records)
}

fn picture(bytes: &[u8]) -> (usize, usize, Vec<u8>) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    (info.width as usize, info.height as usize, pixels)
}

fn mean(pixels: &[u8], width: usize, rows: core::ops::Range<usize>, columns: core::ops::Range<usize>) -> f64 {
    let count = rows.len() * columns.len();
    let sum: u64 = rows
        .flat_map(|row| columns.clone().map(move |column| (row, column)))
        .map(|(row, column)| u64::from(pixels[row * width + column]))
        .sum();
    sum as f64 / count as f64
}

#[test]
fn a_picture_shows_the_block_and_its_shadow_where_they_are() {
    let dive = Dive::of(&compose::clean());
    for (ground, face, shadow) in [(false, 445..455, 470..520), (true, 401..414, 425..480)] {
        let drawing = Waterfall {
            ground,
            ..Waterfall::default()
        };
        let done = export_waterfall(&dive.source, &device(11_002), &drawing, &dive.out()).unwrap();
        assert_eq!(
            done.to_string(),
            "2000 x 456 pixels, 50.2 m to each side, 0.050 m a column"
        );
        let (width, height, pixels) = picture(&dive.written());
        assert_eq!((width, height), (2000, 456));
        // Abeam at 30 s, which is ping 240 from the bottom.
        let rows = 455 - 243..455 - 237;
        let at = |columns: core::ops::Range<usize>| {
            mean(&pixels, width, rows.clone(), 1000 + columns.start..1000 + columns.end)
        };
        assert!(at(face.clone()) > 240.0, "{ground} {}", at(face));
        assert!(at(shadow.clone()) < 15.0, "{ground} {}", at(shadow));
        // The seabed is grey to both sides, near and far.
        for columns in [300..450, 700..850, 1150..1300, 1600..1750] {
            let shade = mean(&pixels, width, 300..400, columns.clone());
            assert!((85.0..125.0).contains(&shade), "{ground} {columns:?} {shade}");
        }
    }
}

#[test]
fn without_gain_a_picture_darkens_with_range() {
    let dive = Dive::of(&compose::clean());
    let drawing = Waterfall {
        gain: GainBy::None,
        width: Some(600),
        ground: true,
        ..Waterfall::default()
    };
    export_waterfall(&dive.source, &device(11_002), &drawing, &dive.out()).unwrap();
    let (width, _, pixels) = picture(&dive.written());
    assert_eq!(width, 600);
    assert!(mean(&pixels, width, 0..100, 320..360) > mean(&pixels, width, 0..100, 540..580) + 60.0);
}

#[test]
fn without_navigation_the_first_bottom_return_gives_the_altitude() {
    let dive = Dive::of(&without(&[3100]));
    let drawing = Waterfall {
        ground: true,
        ..Waterfall::default()
    };
    export_waterfall(&dive.source, &device(11_002), &drawing, &dive.out()).unwrap();
    let (width, _, pixels) = picture(&dive.written());
    assert!(mean(&pixels, width, 212..218, 1401..1414) > 240.0);
    let navigation = Waterfall {
        altitude: AltitudeFrom::Navigation,
        ..drawing
    };
    std::fs::remove_file(dive.out()).unwrap();
    assert_eq!(
        dive.refused(export_waterfall(
            &dive.source,
            &device(11_002),
            &navigation,
            &dive.out()
        )),
        "no altitude, which --ground needs: navigation (record 3100) has none, and no first bottom return is seen; leave \
         --ground out"
    );
}

#[test]
fn several_devices_or_none_are_refused_with_what_there_is() {
    let dive = Dive::of(&compose::clean());
    let all = Selection::default();
    assert_eq!(
        dive.refused(export_xtf(&dive.source, &all, None, &dive.out())),
        "sidescan of several devices: choose one of 11001 (240 records), 11002 (456 records) with --device"
    );
    let wide = Waterfall {
        width: Some(1),
        ..Waterfall::default()
    };
    assert_eq!(
        dive.refused(export_waterfall(&dive.source, &device(11_002), &wide, &dive.out())),
        "invalid --width: expected 2 to 16384 pixels"
    );
    let dive = Dive::of(&without(&[3000, 3001, 3100]));
    for (result, what) in [
        (
            export_xtf(&dive.source, &all, None, &dive.out()),
            "sidescan (record 3000)",
        ),
        (
            export_segy(&dive.source, &all, Signal::Envelope, 0, &dive.out()),
            "sub-bottom profile (record 3001)",
        ),
        (
            export_csv(&dive.source, &all, CsvOf::Navigation, &dive.out()),
            "navigation (record 3100)",
        ),
    ] {
        let expected = format!("no {what} to export: see `backseat s7k info` for what there is");
        assert_eq!(dive.refused(result), expected);
    }
}

/// A GeoTIFF's cells, its size, and its corner and cell size on the map.
fn raster(dive: &Dive) -> (usize, usize, Vec<u8>, [f64; 2], [f64; 2]) {
    let mut decoder = tiff::decoder::Decoder::new(BufReader::new(File::open(dive.out()).unwrap())).unwrap();
    let (width, height) = decoder.dimensions().unwrap();
    let scale = decoder.get_tag_f64_vec(tiff::tags::Tag::ModelPixelScaleTag).unwrap();
    let tie = decoder.get_tag_f64_vec(tiff::tags::Tag::ModelTiepointTag).unwrap();
    let tiff::decoder::DecodingResult::U8(cells) = decoder.read_image().unwrap() else {
        panic!("not 8 bits");
    };
    (
        width as usize,
        height as usize,
        cells,
        [tie[3], tie[4]],
        [scale[0], scale[1]],
    )
}

#[test]
fn a_mosaic_has_no_hole_between_its_pings() {
    let dive = Dive::of(&compose::clean());
    let mosaic = Mosaic {
        resolution_m: 0.5,
        ..Mosaic::default()
    };
    let done = export_mosaic(&dive.source, &device(11_002), &mosaic, &dive.out()).unwrap();
    let (width, height, cells, corner, size) = raster(&dive);
    assert_eq!(
        done.to_string(),
        format!("{width} x {height} cells of 0.5 m, EPSG:32619")
    );
    assert_eq!(size, [0.5, 0.5]);
    // The line begins at 42.3 N, 70.9 W, heading 040: in zone 19 here, as PROJ 9.7 computes it. The swath is before this
    // place and not behind it.
    let (east, north) = (343_385.022_7, 4_684_833.754_5);
    let cell = |along_m: f64| {
        let (sin, cos) = backseat_units::math::sin_cos(compose::HEADING_DEG.to_radians());
        let (x, y) = (east + along_m * sin - corner[0], corner[1] - north - along_m * cos);
        cells[(y / 0.5) as usize * width + (x / 0.5) as usize]
    };
    assert_eq!((cell(-1.0), cell(1.0) > 0), (0, true));
    // A cell without data has a neighbour on each side without data too, or is at the edge of the swath: no single hole.
    let holes = (1..height - 1)
        .flat_map(|row| (1..width - 1).map(move |column| row * width + column))
        .filter(|index| {
            let around = [index - 1, index + 1, index - width, index + width];
            cells[*index] == 0 && around.iter().all(|index| cells[*index] > 0)
        })
        .count();
    assert_eq!(holes, 0);
}

#[test]
fn the_strip_below_the_vehicle_is_dropped_if_it_is_asked() {
    let dive = Dive::of(&compose::clean());
    let covered = |nadir, blend| {
        let mosaic = Mosaic {
            resolution_m: 0.5,
            nadir,
            blend,
            ..Mosaic::default()
        };
        export_mosaic(&dive.source, &device(11_002), &mosaic, &dive.out()).unwrap();
        raster(&dive).2.iter().filter(|cell| **cell > 0).count() as f64 * 0.25
    };
    let (kept, dropped) = (
        covered(Nadir::Keep, Blend::Last),
        covered(Nadir::Drop, Blend::Brightest),
    );
    // 3 m to each side of 85 m of line.
    assert!((kept - dropped - 6.0 * 85.0).abs() < 40.0, "{kept} {dropped}");
    assert!((covered(Nadir::Below, Blend::Mean) - kept).abs() < 1.0);
}

#[test]
fn a_mosaic_over_the_limit_of_memory_says_which_resolution_fits() {
    let dive = Dive::of(&compose::clean());
    let fine = Mosaic {
        resolution_m: 0.02,
        memory_mib: 16,
        ..Mosaic::default()
    };
    let refused = dive.refused(export_mosaic(&dive.source, &device(11_002), &fine, &dive.out()));
    let begin = "the mosaic would have 6661 x 6621 cells, 379 MiB, over the limit of 16 MiB: set --resolution to ";
    let rest = refused.strip_prefix(begin).unwrap_or_else(|| panic!("{refused}"));
    assert!(
        rest.ends_with(" or more, raise --memory, or export a part with --from and --until"),
        "{refused}"
    );
    let fits = Mosaic {
        resolution_m: rest.split(' ').next().unwrap().parse().unwrap(),
        ..fine
    };
    export_mosaic(&dive.source, &device(11_002), &fits, &dive.out()).unwrap();
}

#[test]
fn a_mosaic_without_positions_is_refused() {
    let dive = Dive::of(&without(&[3100]));
    assert_eq!(
        dive.refused(export_mosaic(
            &dive.source,
            &device(11_002),
            &Mosaic::default(),
            &dive.out()
        )),
        "no ping has a position and a heading: a mosaic needs navigation (record 3100) at the times of the pings; export \
         a picture instead (--to png)"
    );
    let coarse = Mosaic {
        resolution_m: f64::NAN,
        ..Mosaic::default()
    };
    assert_eq!(
        dive.refused(export_mosaic(&dive.source, &device(11_002), &coarse, &dive.out())),
        "invalid --resolution: expected 0.01 to 1000 m"
    );
}

fn big(bytes: &[u8], at: usize) -> i32 {
    i32::from_be_bytes(bytes[at..at + 4].try_into().unwrap())
}

#[test]
fn traces_have_their_samples_and_their_places() {
    let dive = Dive::of(&compose::clean());
    let all = Selection::default();
    let done = export_segy(&dive.source, &all, Signal::Envelope, 0, &dive.out()).unwrap();
    assert_eq!(done.to_string(), "120 traces of 800 samples, one each 46 us");
    let bytes = dive.written();
    assert_eq!(bytes.len(), 3600 + 120 * (240 + 3200));
    // "C 1 SUB" in EBCDIC.
    assert_eq!(bytes[..7], [0xC3, 0x40, 0xF1, 0x40, 0xE2, 0xE4, 0xC2]);
    let trace = &bytes[3600 + 7 * 3440..][..3440];
    let (latitude, longitude) = compose::position(3.5);
    assert!((f64::from(big(trace, 72)) / 1000.0 - longitude * 3600.0).abs() < 6e-4);
    assert!((f64::from(big(trace, 76)) / 1000.0 - latitude * 3600.0).abs() < 6e-4);
    // Half a second, in microseconds.
    assert_eq!((big(trace, 0), big(trace, 8), big(trace, 232)), (8, 5008, 500_000));
    for (index, [i, q]) in compose::trace(3.5).into_iter().enumerate() {
        let found = f32::from_be_bytes(trace[240 + 4 * index..][..4].try_into().unwrap());
        let expected = (f32::from(i) * f32::from(i) + f32::from(q) * f32::from(q)).sqrt();
        assert_eq!(found, expected, "{index}");
    }
}

#[test]
fn without_navigation_a_trace_has_the_position_of_its_own_header() {
    let dive = Dive::of(&without(&[3100]));
    let all = Selection::default();
    let done = export_segy(&dive.source, &all, Signal::Real, 0, &dive.out()).unwrap();
    assert_eq!(
        done.notes,
        ["traces with the position of EdgeTech's header, because navigation has none: 120"]
    );
    let bytes = dive.written();
    assert_eq!((big(&bytes, 3672), big(&bytes, 3676)), (-255_240_000, 152_280_000));
    assert_eq!(bytes[3600 + 88..3600 + 90], [0, 2], "seconds of arc");
    assert_eq!(
        f32::from_be_bytes(bytes[3840..3844].try_into().unwrap()),
        f32::from(compose::trace(0.0)[0][0])
    );
    std::fs::remove_file(dive.out()).unwrap();
    assert_eq!(
        dive.refused(export_segy(&dive.source, &all, Signal::Envelope, 1, &dive.out())),
        "no sub-bottom profile has a channel 1: try --channel 0"
    );
}

#[test]
fn a_trace_without_a_position_has_neither_coordinates_nor_their_units() {
    let mut records = compose::records();
    let number = |record: &[u8], at: usize| u32::from_le_bytes(record[at..at + 4].try_into().unwrap());
    records.retain(|record| number(record, 32) != 3100);
    for record in records.iter_mut().filter(|record| number(record, 32) == 3001) {
        // Source and group in EdgeTech's header, which is the optional data.
        let at = number(record, 12) as usize + 72;
        record[at..at + 16].fill(0);
    }
    let dive = Dive::of(&compose::file(&records));
    let done = export_segy(&dive.source, &Selection::default(), Signal::Real, 0, &dive.out()).unwrap();
    assert_eq!(done.notes, ["traces without a position: 120"]);
    let bytes = dive.written();
    for trace in bytes[3600..].chunks(3440) {
        assert_eq!(trace[72..90], [0; 18]);
        assert_eq!(trace[180..188], [0; 8]);
    }
}

#[test]
fn exports_of_a_damaged_recording_have_what_is_whole() {
    let dive = Dive::of(&compose::damaged().0);
    let all = Selection::default();
    // One trace is overwritten.
    let done = export_segy(&dive.source, &all, Signal::Envelope, 0, &dive.out()).unwrap();
    assert!(done.written.starts_with("119 traces"), "{done}");
    let done = export_xtf(&dive.source, &device(11_002), None, &dive.out()).unwrap();
    assert!(done.written.starts_with("456 pings"), "{done}");
    let done = export_csv(&dive.source, &all, CsvOf::Navigation, &dive.out()).unwrap();
    assert_eq!(
        done.to_string(),
        "305 rows; frames whose checksum is right by neither reading of the specification: 1; left out: 4192 bytes that \
         are not a record, in 3 places (see `backseat s7k verify`)"
    );
    export_mosaic(&dive.source, &device(11_002), &Mosaic::default(), &dive.out()).unwrap();
}

#[test]
fn csv_has_all_fields_and_a_column_for_each_quality_bit() {
    let dive = Dive::of(&compose::clean());
    export_csv(&dive.source, &Selection::default(), CsvOf::Navigation, &dive.out()).unwrap();
    let mut reader = csv::Reader::from_path(dive.out()).unwrap();
    let head = reader.headers().unwrap().clone();
    assert_eq!(head.len(), 10 + 18 + 17);
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    let cell = |row: usize, name: &str| {
        rows[row]
            .get(head.iter().position(|head| head == name).unwrap())
            .unwrap()
    };
    assert_eq!(cell(7, "frame_utc"), "2026-11-23T14:00:01.399999Z");
    assert_eq!(
        cell(7, "latitude_rad").parse::<f64>().unwrap(),
        compose::navigation_frame(1.4).latitude_rad
    );
    assert_eq!(
        cell(7, "yaw_rad").parse::<f32>().unwrap(),
        compose::navigation_frame(1.4).yaw_rad
    );
    assert_eq!(
        (cell(7, "quality"), cell(7, "altitude_valid"), cell(7, "frame")),
        ("131071", "1", "2")
    );
    export_csv(&dive.source, &Selection::default(), CsvOf::Environment, &dive.out()).unwrap();
    let text = String::from_utf8(dive.written()).unwrap();
    assert!(
        text.lines()
            .next()
            .unwrap()
            .ends_with("frame_checksum,quality,sound_speed_mps,sound_speed_valid"),
        "{text}"
    );
    assert!(text.lines().nth(1).unwrap().ends_with(",1,1500,1"), "{text}");
}

#[test]
fn an_export_to_a_full_disk_names_the_output() {
    let dive = Dive::of(&compose::clean());
    let full = PathBuf::from("/dev/full");
    let all = Selection::default();
    let results = [
        export_csv(&dive.source, &all, CsvOf::Navigation, &full),
        export_segy(&dive.source, &all, Signal::Envelope, 0, &full),
        export_xtf(&dive.source, &device(11_002), None, &full),
        export_waterfall(&dive.source, &device(11_002), &Waterfall::default(), &full),
        export_mosaic(&dive.source, &device(11_002), &Mosaic::default(), &full),
    ];
    for result in results {
        let error = result.unwrap_err().to_string();
        let begin = "/dev/full: cannot write: No space left on device (os error 28): free some space";
        assert!(error.starts_with(begin), "{error}");
    }
}
