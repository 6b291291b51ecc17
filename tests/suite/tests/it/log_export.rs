//! `backseat log export` and `spi decode` of a log: a flown dive in the formats of other programs, and one line for what
//! cannot be exported. `cargo xtask exports` opens the exports with readers that others wrote.

#![expect(clippy::unwrap_used, reason = "a file that cannot be read or written fails its test")]

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use backseat_recorder::{Log, LoggedInput, Record, read};
use backseat_suite::{Backseat, Finished, Mission};
use serde_json::Value;

/// A dive in which tracklines are inserted, and its log.
struct Dive {
    mission: Mission,
    path: PathBuf,
    log: Log,
}

static DIVE: LazyLock<Dive> = LazyLock::new(|| {
    let mission = Mission::copy("plume");
    let path = mission.beside("dive.mcap");
    let report = Backseat::new()
        .args(["sim", "--json", "--log"])
        .arg(&path)
        .mission(&mission)
        .run()
        .exit(0);
    assert!(report.json()["requests"]["accepted"].as_u64() > Some(0), "{report}");
    let log = read(&path).unwrap();
    Dive { mission, path, log }
});

impl Dive {
    /// Navigation's messages.
    fn navigation(&self) -> Vec<&Value> {
        let records = self.log.entries.iter();
        records
            .filter_map(|entry| {
                if let Record::Navigation(navigation) = &entry.record {
                    Some(navigation)
                } else {
                    None
                }
            })
            .collect()
    }

    fn deepest_m(&self) -> f64 {
        let depths = self.navigation().into_iter();
        depths
            .filter_map(|navigation| navigation["depth_m"].as_f64())
            .fold(0.0, f64::max)
    }
}

fn export(log: &Path, format: &str, out: &Path) -> Backseat {
    Backseat::new()
        .args(["log", "export"])
        .arg(log)
        .args(["--to", format, "--out"])
        .arg(out)
}

/// Exports the dive into a folder of its own.
fn exported(format: &str, out: &str) -> (tempfile::TempDir, PathBuf, Finished) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(out);
    let finished = export(&DIVE.path, format, &path).run().exit(0);
    assert_eq!(
        (finished.stdout.as_str(), finished.stderr.lines().count()),
        ("", 1),
        "{finished}"
    );
    assert!(
        finished.stderr.starts_with(&format!("{}: ", path.display())),
        "{finished}"
    );
    (folder, path, finished)
}

#[test]
fn qgis_gets_the_track_the_truth_the_fence_the_plan_and_the_inserts() {
    let (_folder, path, finished) = exported("geojson", "map.geojson");
    let map: Value = serde_json::from_slice(&fs::read(path).unwrap()).unwrap();
    let features = map["features"].as_array().unwrap();
    assert!(
        finished.stderr.ends_with(&format!(": {} features\n", features.len())),
        "{finished}"
    );
    let layer = |name: &'static str| {
        features
            .iter()
            .filter(move |feature| feature["properties"]["layer"] == name)
    };
    let line = &layer("track").next().unwrap()["geometry"];
    assert_eq!(line["type"], "LineString");
    let positions = line["coordinates"].as_array().unwrap();
    assert_eq!(positions.len(), DIVE.navigation().len());
    let height = |position: &Value| position[2].as_f64().unwrap();
    let lowest_m = positions.iter().map(height).fold(0.0, f64::min);
    assert_eq!(lowest_m, -DIVE.deepest_m());
    let first = DIVE.navigation()[0];
    assert_eq!(
        (&positions[0][0], &positions[0][1]),
        (&first["longitude_deg"], &first["latitude_deg"])
    );
    let fence: Value = serde_json::from_str(&DIVE.mission.read("fence.geojson")).unwrap();
    assert_eq!(layer("fence").count(), fence["features"].as_array().unwrap().len());
    assert!(layer("truth").count() > 1);
}

#[test]
fn google_earth_gets_as_many_placemarks_as_the_program_says() {
    let (_folder, path, finished) = exported("kml", "map.kml");
    let map = fs::read_to_string(path).unwrap();
    let placemarks = map.matches("<Placemark>").count();
    assert!(
        finished.stderr.ends_with(&format!(": {placemarks} placemarks\n")),
        "{finished}"
    );
    assert!(map.starts_with("<?xml version=\"1.0\" encoding=\"UTF-8\"?>"));
    for part in ["<name>Track</name>", "<name>True track</name>", "<name>Fence</name>"] {
        assert!(map.contains(part), "{part}");
    }
}

#[test]
fn pandas_and_duckdb_get_a_table_of_each_channel() {
    for format in ["csv", "parquet"] {
        let (_folder, path, finished) = exported(format, "tables");
        let index: Value = serde_json::from_slice(&fs::read(path.join("tables.json")).unwrap()).unwrap();
        let tables = index["tables"].as_array().unwrap();
        assert!(
            finished.stderr.contains(&format!(": {} tables with ", tables.len())),
            "{finished}"
        );
        let of = |topic: &str| tables.iter().find(|table| table["topic"] == topic).unwrap();
        assert_eq!(of("/navigation")["rows"], DIVE.navigation().len());
        assert_eq!(
            (&index["complete"], &index["run"]["mission"]),
            (&true.into(), &"plume".into())
        );
        let file = path.join(of("/navigation")["file"].as_str().unwrap());
        let content = fs::read(file).unwrap();
        if format == "parquet" {
            assert!(content.starts_with(b"PAR1") && content.ends_with(b"PAR1"));
            continue;
        }
        let text = String::from_utf8(content).unwrap();
        let mut lines = text.lines();
        let columns: Vec<&str> = lines.next().unwrap().split(',').collect();
        assert_eq!(columns[..2], ["time", "t_s"]);
        let depth = columns.iter().position(|column| *column == "depth_m").unwrap();
        let depths = lines.map(|line| line.split(',').nth(depth).unwrap().parse::<f64>().unwrap());
        assert_eq!(depths.fold(0.0, f64::max), DIVE.deepest_m());
    }
}

#[test]
fn one_channel_goes_to_standard_output_too() {
    // `/dev/stdout` leads here. A mistake there could replace the link for the whole computer, and here it cannot.
    let finished = export(&DIVE.path, "csv", Path::new("/proc/self/fd/1"))
        .args(["--channel", "/navigation"])
        .run()
        .exit(0);
    assert!(finished.stdout.starts_with("time,t_s,"), "{finished}");
    assert_eq!(finished.stdout.lines().count(), 1 + DIVE.navigation().len());
}

#[test]
fn moos_gets_navigation_by_its_names() {
    let (_folder, path, finished) = exported("alog", "dive.alog");
    let log = fs::read_to_string(path).unwrap();
    let header: Vec<&str> = log.lines().take_while(|line| line.starts_with("%%")).collect();
    assert_eq!(header.len(), 5, "{header:?}");
    assert!(
        header[1].ends_with(" dive.alog") && header[3].starts_with("%% LOGSTART "),
        "{header:?}"
    );
    let lines: Vec<Vec<&str>> = log
        .lines()
        .skip(5)
        .map(|line| line.split_whitespace().collect())
        .collect();
    assert!(
        finished.stderr.ends_with(&format!(": {} lines\n", lines.len())),
        "{finished}"
    );
    let depths = lines.iter().filter(|line| line[1] == "NAV_DEPTH");
    let depths: Vec<f64> = depths.map(|line| line[3].parse().unwrap()).collect();
    assert_eq!(depths.len(), DIVE.navigation().len());
    assert_eq!(depths.into_iter().fold(0.0, f64::max), DIVE.deepest_m());
    let times: Vec<f64> = lines.iter().map(|line| line[0].parse().unwrap()).collect();
    assert!(times.is_sorted());
}

#[test]
fn data_centres_get_a_trajectory_in_netcdf() {
    let (_folder, path, finished) = exported("netcdf", "dive.nc");
    let file = fs::read(&path).unwrap();
    // NetCDF classic with offsets of 64 bits.
    assert!(file.starts_with(b"CDF\x02"));
    let rows = DIVE.navigation().len();
    assert!(finished.stderr.contains(&format!(": {rows} rows of ")), "{finished}");
    // A pipe takes it too, because it is written from its first byte to its last.
    let piped = export(&DIVE.path, "netcdf", Path::new("/proc/self/fd/1")).run().exit(0);
    assert!(piped.stdout.starts_with("CDF"), "{}", piped.stderr);
}

#[test]
fn spi_decode_reads_the_sentences_of_a_log_in_both_directions() {
    let finished = Backseat::new()
        .args(["spi", "decode", "--json"])
        .arg(&DIVE.path)
        .run()
        .exit(0);
    let (mut to_vehicle, mut from_vehicle) = (Vec::new(), Vec::new());
    for entry in &DIVE.log.entries {
        if let Record::Sent(bytes) = &entry.record {
            to_vehicle.extend_from_slice(bytes);
        } else if let Record::Input(LoggedInput::Received(bytes)) = &entry.record {
            from_vehicle.extend_from_slice(bytes);
        }
    }
    let [sent, received] = [to_vehicle, from_vehicle].map(|bytes| bytes.iter().filter(|byte| **byte == b'\n').count());
    assert!(sent > 0 && received > sent, "{sent}, {received}");
    assert_eq!(finished.stdout.lines().count(), sent + received);
    let mut last_s = 0.0;
    for line in finished.stdout.lines() {
        let sentence: Value = serde_json::from_str(line).unwrap();
        let received_s = sentence["received_s"].as_f64().unwrap();
        assert!(received_s >= last_s && sentence["error"].is_null(), "{line}");
        last_s = received_s;
    }
}

#[test]
fn a_log_cut_short_is_exported_as_far_as_it_goes_and_the_program_says_where_it_ends() {
    let folder = tempfile::tempdir().unwrap();
    let cut = folder.path().join("cut.mcap");
    let mut bytes = fs::read(&DIVE.path).unwrap();
    bytes.truncate(bytes.len() / 2);
    fs::write(&cut, bytes).unwrap();
    for (format, out) in [
        ("geojson", "map.geojson"),
        ("kml", "map.kml"),
        ("csv", "csv"),
        ("parquet", "parquet"),
        ("alog", "dive.alog"),
        ("netcdf", "dive.nc"),
    ] {
        let finished = export(&cut, format, &folder.path().join(out)).run().exit(0);
        let lines: Vec<&str> = finished.stderr.lines().collect();
        assert_eq!(lines.len(), 2, "{finished}");
        assert!(lines[0].contains("cut.mcap: cut short: the log ends at "), "{finished}");
        assert!(folder.path().join(out).exists());
    }
    let decoded = Backseat::new().args(["spi", "decode"]).arg(&cut).run().exit(0);
    assert!(decoded.stderr.starts_with("cut short: "), "{}", decoded.stderr);
}

/// The line with which an export is refused. The folder has a log, the text `notes.txt` and the folder `thesis`.
fn refused(log: &str, arguments: &[&str]) -> String {
    let folder = tempfile::tempdir().unwrap();
    fs::copy(&DIVE.path, folder.path().join("dive.mcap")).unwrap();
    fs::write(folder.path().join("notes.txt"), "not a log\n").unwrap();
    fs::create_dir(folder.path().join("thesis")).unwrap();
    fs::write(folder.path().join("thesis/chapter.tex"), "mine").unwrap();
    let line = Backseat::new()
        .in_folder(folder.path())
        .args(["log", "export", log])
        .args(arguments.iter().copied())
        .run()
        .refusal();
    let mut names: Vec<_> = fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
        .collect();
    names.sort();
    assert_eq!(names, ["dive.mcap", "notes.txt", "thesis"], "{line}");
    assert_eq!(fs::read(folder.path().join("notes.txt")).unwrap(), b"not a log\n");
    assert_eq!(fs::read(folder.path().join("thesis/chapter.tex")).unwrap(), b"mine");
    line
}

#[test]
fn what_cannot_be_exported_gets_one_line_and_changes_nothing() {
    for (log, arguments, expected) in [
        (
            "nowhere.mcap",
            &["--to", "kml", "--out", "map.kml"][..],
            "error: nowhere.mcap: cannot read: No such file or directory (os error 2)",
        ),
        (
            "notes.txt",
            &["--to", "kml", "--out", "map.kml"],
            "error: notes.txt: is not an MCAP file: expected the log of a run, written by `run`, `fly` or `sim --log`",
        ),
        (
            "thesis",
            &["--to", "kml", "--out", "map.kml"],
            "error: thesis: is a folder: expected the log of a run, written by `run`, `fly` or `sim --log`",
        ),
        (
            "dive.mcap",
            &["--to", "csv", "--out", "notes.txt"],
            "error: notes.txt: is a file: name a folder for the tables",
        ),
        (
            "dive.mcap",
            &["--to", "csv", "--out", "thesis"],
            "error: thesis: is a folder with files that no export wrote, such as chapter.tex: name a new or an empty folder",
        ),
        (
            "dive.mcap",
            &["--to", "kml", "--out", "thesis"],
            "error: thesis: is a folder: name a file in it",
        ),
        (
            "dive.mcap",
            &["--to", "alog", "--out", "dive.mcap"],
            "error: dive.mcap: is the log itself: name another file",
        ),
        (
            "dive.mcap",
            &["--to", "kml", "--out", "nowhere/map.kml"],
            "error: nowhere/map.kml: cannot write: No such file or directory (os error 2)",
        ),
        (
            "dive.mcap",
            &["--to", "kml", "--out", "/proc/map.kml"],
            "error: /proc/map.kml: cannot write: No such file or directory (os error 2)",
        ),
        (
            "dive.mcap",
            &["--to", "csv", "--out", "/proc/tables"],
            "error: /proc/tables: cannot write: No such file or directory (os error 2)",
        ),
        (
            "dive.mcap",
            &["--to", "kml", "--out", "map.kml", "--channel", "/navigation"],
            "error: invalid --channel: it is an option of --to csv and parquet only, and not of --to kml",
        ),
        (
            "dive.mcap",
            &["--to", "csv", "--out", "tables", "--every", "1"],
            "error: invalid --every: it is an option of --to geojson and kml only, and not of --to csv",
        ),
    ] {
        assert_eq!(refused(log, arguments), expected);
    }
    let line = refused("dive.mcap", &["--to", "csv", "--out", "x.csv", "--channel", "/nav"]);
    assert!(
        line.starts_with("error: dive.mcap: no channel /nav; the log has "),
        "{line}"
    );
}

#[test]
fn an_unknown_format_gets_those_that_there_are() {
    let finished = export(&DIVE.path, "gpx", Path::new("map.gpx")).run().exit(2);
    for part in [
        "invalid value 'gpx' for '--to <TO>'",
        "geojson, kml, csv, parquet, alog, netcdf",
    ] {
        assert!(finished.stderr.contains(part), "{finished}");
    }
}

#[test]
fn a_disk_that_is_full_leaves_an_earlier_export_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    for (format, out) in [("alog", "dive.alog"), ("netcdf", "dive.nc")] {
        let path = folder.path().join(out);
        fs::write(&path, "earlier").unwrap();
        let line = export(&DIVE.path, format, &path).file_max_kib(16).run().refusal();
        assert!(
            line.ends_with(&format!("{out}: cannot write: File too large (os error 27)")),
            "{line}"
        );
        assert_eq!(fs::read(&path).unwrap(), b"earlier");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
}
