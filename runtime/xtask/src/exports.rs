use std::process::Command;

use anyhow::Result;

use crate::cargo::{cargo, root, run, target};
use crate::cross::python;

/// Readers that others wrote, of SEG-Y, XTF, GeoTIFF and PNG.
const PACKAGES: [&str; 3] = ["segyio==1.9.14", "pyxtf==1.5.0", "rasterio==1.4.4"];

/// Composes the survey of the tests, exports it to every format, and opens the exports.
pub(crate) fn exports() -> Result<()> {
    let programs = python("readers", &PACKAGES)?;
    let folder = target()?.join("exports");
    let path = folder.display().to_string();
    cargo(&[
        "run",
        "--quiet",
        "--package",
        "backseat-s7k-tools",
        "--example",
        "survey",
        "--",
        &path,
    ])?;
    let script = root()?.join("tests/suite/scripts/sonar_exports.py");
    run(Command::new(programs.join("python")).arg("-B").arg(script).arg(&folder))
}
