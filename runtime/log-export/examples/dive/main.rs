//! Writes the log of the tests into a folder, with every export of it, for a script in `tests/suite/scripts` to open with
//! readers that others wrote. A log that is given is taken instead.
//!
//! ```sh
//! cargo run -p backseat-log-export --example dive -- FOLDER [LOG]
//! python tests/suite/scripts/log_exports.py FOLDER
//! ```

#[allow(
    clippy::allow_attributes,
    dead_code,
    reason = "shared with the tests, which use all of it"
)]
mod compose;

use std::error::Error;
use std::path::PathBuf;

use backseat_log_export::{Export, Format, export};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let folder = arguments.next().ok_or("name a folder")?;
    std::fs::create_dir_all(&folder)?;
    let log = folder.join("log.mcap");
    match arguments.next() {
        Some(other) => std::fs::copy(other, &log).map(drop)?,
        None => std::fs::write(&log, compose::whole())?,
    }
    for (to, out) in [
        (Format::Geojson, "map.geojson"),
        (Format::Kml, "map.kml"),
        (Format::Csv, "csv"),
        (Format::Parquet, "parquet"),
        (Format::Alog, "log.alog"),
        (Format::Netcdf, "track.nc"),
    ] {
        export(&Export {
            log: &log,
            to,
            out: &folder.join(out),
            channel: None,
            every_s: None,
        })?;
    }
    Ok(())
}
