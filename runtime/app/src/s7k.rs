//! `backseat s7k`: connects the tools for 7k recordings to files and standard streams.

mod export;

use std::fmt::Display;
use std::io::{self, BufWriter};
use std::path::PathBuf;

use anyhow::Result;
use backseat_s7k_tools::{Error, Moment, Selection, Source, cut, dump, info, verify, write_info};
use clap::{Args, Subcommand};

use self::export::S7kExport;

#[derive(Debug, Subcommand)]
pub(crate) enum S7k {
    /// Show what a recording contains: types, devices, times, rates, gaps, checksums, catalogue, damage
    ///
    /// One line for each record type and device gives the number of records, their bytes, the first and last time, and
    /// the rate. A gap in time is an interval more than three times as long as the median. A gap in the record counts
    /// is a count that does not follow the one before. A checksum counts only if the record claims it (flag bit 0);
    /// records that claim none are compared all the same and listed apart.
    ///
    /// Exit code: 0 even if the recording has faults (use `verify`), 2 if it cannot be read.
    Info(S7kInfo),
    /// Print records as JSON, one object a line, with the frame header and all fields
    ///
    /// Each object has `offset` (bytes from the start of the file), `utc`, `frame`, `checksum`, and `record`, or `error`
    /// if the record is not what its type says. Samples are printed with --samples only. A damaged place is an object
    /// with `offset`, `bytes` and `error`, whatever is selected.
    ///
    /// Exit code: 0 even if the recording has faults, 2 if it cannot be read.
    Dump(S7kDump),
    /// Check a recording; print one line for each fault, with its byte offset
    ///
    /// The faults: bytes that are no record, wrong checksums, records that are not what their type says, values outside
    /// the ranges of the specification, and a catalogue that differs from the records. A missing catalogue, a checksum
    /// that a record does not claim, and the checksum of a Bluefin frame (the specification does not say how it is
    /// computed) are no faults; see `info`.
    ///
    /// Exit code: 0 if there is no fault, 1 if there is one, 2 if the file cannot be read.
    Verify(S7kVerify),
    /// Write a part of a recording as a recording of its own, with file header and catalogue
    ///
    /// The records are copied byte for byte. The file header keeps the names and the session of the original and has an
    /// identity of its own. Damaged places are left out. Records without a time are left out if --from or --to is given.
    Cut(S7kCut),
    /// Convert a recording to SEG-Y, PNG, GeoTIFF, CSV or XTF
    ///
    /// An export of sonar data has one device: name it with --device if the recording has several. A line on standard
    /// error says what was written and what had to be left out.
    ///
    /// Exit code: 0 if the file was written, 2 if not.
    Export(S7kExport),
}

/// The recording that a command reads.
#[derive(Debug, Args)]
pub(crate) struct Recording {
    /// The recording (.s7k)
    #[arg(value_name = "FILE")]
    file: PathBuf,
}

impl Recording {
    fn open(&self) -> Result<Source, Error> {
        Source::open(&self.file)
    }
}

/// The recordings that a command reads as one.
#[derive(Debug, Args)]
pub(crate) struct Recordings {
    /// The recording (.s7k); several files of one recording are read as one, in the order of their times
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
}

impl Recordings {
    fn open(&self) -> Result<Source, Error> {
        Source::join(&self.files)
    }
}

#[derive(Debug, Args)]
pub(crate) struct S7kInfo {
    #[command(flatten)]
    recording: Recording,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct S7kDump {
    #[command(flatten)]
    recording: Recording,
    /// Print the samples of sonar records too
    #[arg(long)]
    samples: bool,
    #[command(flatten)]
    selected: Selected,
}

#[derive(Debug, Args)]
pub(crate) struct S7kVerify {
    #[command(flatten)]
    recording: Recording,
    /// Print a JSON object for each fault, one a line
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct S7kCut {
    #[command(flatten)]
    recordings: Recordings,
    /// Write to this file; it is replaced if it exists, once the new one is complete
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    #[command(flatten)]
    selected: Selected,
}

/// Which records are meant.
#[derive(Debug, Args)]
pub(crate) struct Selected {
    /// Only these record types [default: all]
    #[arg(long = "type", value_name = "3000,3001", value_delimiter = ',')]
    types: Vec<u32>,
    /// Only these devices [default: all]
    #[arg(long = "device", value_name = "11001,11002", value_delimiter = ',')]
    devices: Vec<u32>,
    /// Only records at this time in UTC or later, such as 2026-11-23T14:05:07.25 or 2026-327T14:05:07.25
    #[arg(long, value_name = "TIME")]
    from: Option<Moment>,
    /// Only records before this time in UTC
    #[arg(long, visible_alias = "until", value_name = "TIME")]
    to: Option<Moment>,
}

impl Selected {
    fn selection(&self) -> Selection {
        Selection {
            types: self.types.clone(),
            devices: self.devices.clone(),
            from: self.from,
            to: self.to,
        }
    }
}

pub(crate) fn s7k(command: &S7k) -> Result<bool> {
    let mut out = BufWriter::new(io::stdout().lock());
    match command {
        S7k::Info(arguments) => {
            let source = arguments.recording.open()?;
            let info = info(&source)?;
            finished(write_info(&info, &source, arguments.json, &mut out))?;
        }
        S7k::Dump(arguments) => {
            let source = arguments.recording.open()?;
            let selection = arguments.selected.selection();
            finished(dump(&source, &selection, arguments.samples, &mut out))?;
        }
        S7k::Verify(arguments) => {
            let source = arguments.recording.open()?;
            if let Some(verdict) = finished(verify(&source, arguments.json, &mut out))? {
                tell(&verdict);
                return Ok(verdict.is_right());
            }
        }
        S7k::Cut(arguments) => {
            let source = arguments.recordings.open()?;
            if let Some(done) = finished(cut(&source, &arguments.selected.selection(), &arguments.out))? {
                tell(&done);
            }
        }
        S7k::Export(arguments) => {
            if let Some(done) = finished(arguments.export())? {
                tell(&done);
            }
        }
    }
    Ok(true)
}

fn tell(what: &impl Display) {
    crate::terminal::tell(&what.to_string());
}

/// `None` where the reader of the output has closed it, which is no error.
fn finished<T>(result: Result<T, Error>) -> Result<Option<T>, Error> {
    match result {
        Ok(value) => Ok(Some(value)),
        Err(error) if error.is_broken_pipe() => Ok(None),
        Err(error) => Err(error),
    }
}
