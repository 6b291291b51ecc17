//! Exports the log of a run to the formats of other programs.
//!
//! A log is an MCAP file as `backseat-recorder` describes it. This crate knows few of its channels by name. For tables, a
//! channel is a topic with a JSON schema, whose properties are columns; for maps, a channel with the schema
//! `foxglove.GeoJSON` is a layer. So a channel that is new in the log needs no change here.
//!
//! An export reads the log's file twice, in a stream: first to find the columns of each channel, the gaps and the end,
//! and then to write. Memory is bounded by the largest chunk of the log, by the row groups of Parquet, and for maps and
//! NetCDF by the number of positions. NetCDF has a fixed table of variables, because their names are those of conventions.
//!
//! A log without its end, as a killed process leaves it, is exported as far as it goes, and so is a damaged one. Each
//! remark of [`Exported::remarks`] says what is missing.

mod alog;
mod contents;
mod error;
mod flatten;
mod geojson;
mod kml;
mod map;
mod netcdf;
mod output;
mod schema;
mod source;
mod table;
mod tables;
mod time;

use std::path::Path;

pub use error::Error;
use source::Source;
use tables::Form;

/// A format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// A map for QGIS and other geographic information systems: one FeatureCollection (RFC 7946).
    Geojson,
    /// A map for Google Earth.
    Kml,
    /// Tables as comma-separated values.
    Csv,
    /// Tables as Apache Parquet.
    Parquet,
    /// The log of MOOS.
    Alog,
    /// The trajectory as NetCDF by the conventions CF and ACDD.
    Netcdf,
}

impl Format {
    const fn name(self) -> &'static str {
        match self {
            Self::Geojson => "geojson",
            Self::Kml => "kml",
            Self::Csv => "csv",
            Self::Parquet => "parquet",
            Self::Alog => "alog",
            Self::Netcdf => "netcdf",
        }
    }
}

/// What to export.
#[derive(Clone, Copy, Debug)]
pub struct Export<'a> {
    /// The log.
    pub log: &'a Path,
    /// The format.
    pub to: Format,
    /// The file or, for tables of all channels, the folder.
    pub out: &'a Path,
    /// The only channel, for tables.
    pub channel: Option<&'a str>,
    /// The time between two points of a track, seconds, for maps; [`EVERY_S`] if it is `None`.
    pub every_s: Option<f64>,
}

/// The usual time between two points of a track, seconds.
pub const EVERY_S: f64 = 10.0;

/// What was exported.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Exported {
    /// What was written, in one line.
    pub summary: String,
    /// What is missing of the log, a line each.
    pub remarks: Vec<String>,
}

/// Exports a log.
///
/// # Errors
///
/// Every [`Error`]. Nothing has been written then, and what was at [`Export::out`] before is still there.
pub fn export(export: &Export<'_>) -> Result<Exported, Error> {
    let Export {
        log, to, out, channel, ..
    } = *export;
    let is_map = matches!(to, Format::Geojson | Format::Kml);
    let is_table = matches!(to, Format::Csv | Format::Parquet);
    let option = |option, formats: &str| {
        let fault = format!("it is an option of --to {formats} only, and not of --to {}", to.name());
        Err(Error::Option { option, fault })
    };
    if channel.is_some() && !is_table {
        return option("--channel", "csv and parquet");
    }
    if export.every_s.is_some() && !is_map {
        return option("--every", "geojson and kml");
    }
    let every_s = export.every_s.unwrap_or(EVERY_S);
    let source = Source::open(log)?;
    if is_same_file(log, out) {
        return Err(Error::output(out, "is the log itself: name another file"));
    }
    match to {
        Format::Geojson => geojson::export(&source, every_s, out),
        Format::Kml => kml::export(&source, every_s, out),
        Format::Csv => tables::export(&source, Form::Csv, channel, out),
        Format::Parquet => tables::export(&source, Form::Parquet, channel, out),
        Format::Alog => alog::export(&source, out),
        Format::Netcdf => netcdf::export(&source, out),
    }
}

/// What a log has, as `tables.json` of an export of all tables says it: `run`, `start`, `seconds`, `complete`, `gaps`, and
/// `tables` with topic, schema, rows and columns of each channel. Nothing is written.
///
/// # Errors
///
/// Those of reading a log.
pub fn describe(log: &Path) -> Result<serde_json::Value, Error> {
    tables::describe(&Source::open(log)?)
}

fn is_same_file(log: &Path, out: &Path) -> bool {
    match (log.canonicalize(), out.canonicalize()) {
        (Ok(log), Ok(out)) => log == out,
        (Ok(_) | Err(_), _) => false,
    }
}

/// `1 row`, `2 rows`.
fn counted(number: u64, what: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{number} {what}{plural}")
}
