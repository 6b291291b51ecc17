//! `backseat log export`: a log in the formats of other programs.

use std::path::PathBuf;

use anyhow::Result;
use backseat_log_export::{Export, Format, export};
use clap::{Args, ValueEnum};

use crate::terminal::tell;

#[derive(Debug, Args)]
pub(crate) struct LogExport {
    /// The log, written by `run`, `fly` or `sim --log`
    #[arg(value_name = "DIVE.mcap")]
    file: PathBuf,
    /// The format
    #[arg(long, value_enum)]
    to: FormatOption,
    /// Write to this file or, for all tables, this folder; an earlier export is replaced once the new one is complete
    #[arg(long, value_name = "PATH")]
    out: PathBuf,
    /// csv, parquet: only this channel, such as /navigation [default: all, each in a file of its own]
    #[arg(long, value_name = "TOPIC")]
    channel: Option<String>,
    /// geojson, kml: seconds between two points of a track, which have everything that the log says of the vehicle
    /// [default: 10]
    #[arg(long, value_name = "SECONDS", value_parser = period)]
    every: Option<f64>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum FormatOption {
    /// A map for QGIS (RFC 7946)
    Geojson,
    /// A map for Google Earth
    Kml,
    /// Tables of comma-separated values
    Csv,
    /// Tables for pandas, DuckDB and others
    Parquet,
    /// The log of MOOS
    Alog,
    /// The trajectory for data centres and xarray (CF 1.8)
    Netcdf,
}

impl From<FormatOption> for Format {
    fn from(option: FormatOption) -> Self {
        match option {
            FormatOption::Geojson => Self::Geojson,
            FormatOption::Kml => Self::Kml,
            FormatOption::Csv => Self::Csv,
            FormatOption::Parquet => Self::Parquet,
            FormatOption::Alog => Self::Alog,
            FormatOption::Netcdf => Self::Netcdf,
        }
    }
}

fn period(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if (0.001..=1e6).contains(&seconds) => Ok(seconds),
        _ => Err("expected 0.001 to 1000000 s".to_owned()),
    }
}

impl LogExport {
    pub(super) fn export(&self) -> Result<bool> {
        let exported = export(&Export {
            log: &self.file,
            to: self.to.into(),
            out: &self.out,
            channel: self.channel.as_deref(),
            every_s: self.every,
        });
        match exported {
            Ok(exported) => {
                exported.remarks.iter().for_each(|remark| tell(remark));
                tell(&exported.summary);
            }
            // Whoever read the output has had enough.
            Err(error) if error.is_broken_pipe() => {}
            Err(error) => return Err(error.into()),
        }
        Ok(true)
    }
}
