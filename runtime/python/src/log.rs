//! The log of a run, by the exports of `backseat log export`.

use std::path::Path;

use backseat_log_export::{Export, Format, export};
use serde_json::Value;

use crate::error::Error;

/// What a log has, as `tables.json` of an export of all tables says it: `run`, `start`, `seconds`, `complete`, `gaps`,
/// and `tables` with topic, schema, rows and columns of each channel.
///
/// # Errors
///
/// [`Error::Log`].
pub fn describe(log: &Path) -> Result<Value, Error> {
    Ok(backseat_log_export::describe(log)?)
}

/// Writes one channel's table as Parquet. Returns what is missing of the log, a line each.
///
/// # Errors
///
/// [`Error::Log`], also where the log does not have the channel.
pub fn table(log: &Path, channel: &str, out: &Path) -> Result<Vec<String>, Error> {
    write(log, Format::Parquet, Some(channel), out)
}

/// Writes the trajectory as NetCDF. Returns what is missing of the log, a line each.
///
/// # Errors
///
/// [`Error::Log`], also where the log has no position.
pub fn trajectory(log: &Path, out: &Path) -> Result<Vec<String>, Error> {
    write(log, Format::Netcdf, None, out)
}

fn write(log: &Path, to: Format, channel: Option<&str>, out: &Path) -> Result<Vec<String>, Error> {
    let exported = export(&Export {
        log,
        to,
        out,
        channel,
        every_s: None,
    })?;
    Ok(exported.remarks)
}
