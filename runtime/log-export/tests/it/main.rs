//! What exports contain, and what they do with logs and outputs that are not as they should be. The log is the one that
//! the example `dive` composes; `cargo xtask exports` compares its exports with readers that others wrote.

#![expect(clippy::unwrap_used, reason = "a test fails where a file cannot be written or read")]

#[path = "../../examples/dive/compose.rs"]
mod compose;
mod damage;
mod maps;
mod netcdf;
mod tables;

use std::path::{Path, PathBuf};

use backseat_log_export::{Error, Export, Exported, Format, export};
use tempfile::TempDir;

const FORMATS: [(Format, &str); 6] = [
    (Format::Geojson, "map.geojson"),
    (Format::Kml, "map.kml"),
    (Format::Csv, "csv"),
    (Format::Parquet, "parquet"),
    (Format::Alog, "log.alog"),
    (Format::Netcdf, "track.nc"),
];

/// A log in a folder of its own.
struct Desk {
    folder: TempDir,
    log: PathBuf,
}

impl Desk {
    fn with(log: &[u8]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("dive.mcap");
        std::fs::write(&path, log).unwrap();
        Self { folder, log: path }
    }

    fn at(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn export(&self, to: Format, out: &str) -> Result<Exported, Error> {
        export(&Export {
            log: &self.log,
            to,
            out: &self.at(out),
            channel: None,
            every_s: None,
        })
    }

    /// Exports, and reads the file.
    #[track_caller]
    fn exported(&self, to: Format, out: &str) -> String {
        self.export(to, out).unwrap();
        std::fs::read_to_string(self.at(out)).unwrap()
    }

    /// The names in the folder.
    fn names(&self) -> Vec<String> {
        names(self.folder.path())
    }
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}
