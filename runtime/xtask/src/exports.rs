use std::process::Command;

use anyhow::Result;

use crate::cargo::{cargo, root, run, target};
use crate::cross::python;

/// Readers that others wrote, of SEG-Y, XTF, GeoTIFF and PNG.
const SONAR_PACKAGES: [&str; 3] = ["segyio==1.9.14", "pyxtf==1.5.0", "rasterio==1.4.4"];
/// Readers that others wrote, of MCAP, CSV, Parquet, GeoJSON, KML and NetCDF, and the checker of NetCDF's conventions.
const LOG_PACKAGES: [&str; 9] = [
    "mcap==1.6.0",
    "pandas==3.1.1",
    "pyarrow==26.0.1",
    "shapely==2.2.0",
    "fastkml==1.4.0",
    "lxml==6.1.3",
    "xarray==2026.9.0",
    "scipy==1.17.1",
    "compliance-checker==6.1.0",
];

/// Composes the recording and the log of the tests, exports them to every format, and opens the exports.
pub(crate) fn exports() -> Result<()> {
    compare(
        "readers",
        &SONAR_PACKAGES,
        ["backseat-s7k-tools", "survey"],
        "sonar_exports.py",
    )?;
    compare(
        "log-readers",
        &LOG_PACKAGES,
        ["backseat-log-export", "dive"],
        "log_exports.py",
    )
}

/// Runs an example, which writes into a folder, and then a script with these packages, which compares what is there.
fn compare(name: &str, packages: &[&str], [package, example]: [&str; 2], script: &str) -> Result<()> {
    let programs = python(name, packages)?;
    let folder = target()?.join("exports").join(example);
    let path = folder.display().to_string();
    cargo(&[
        "run",
        "--quiet",
        "--package",
        package,
        "--example",
        example,
        "--",
        &path,
    ])?;
    let script = root()?.join("tests/suite/scripts").join(script);
    run(Command::new(programs.join("python")).arg("-B").arg(script).arg(&folder))
}
