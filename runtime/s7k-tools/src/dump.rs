//! `dump`: records as JSON, one object a line.

mod record;

use std::io::Write;

use backseat_s7k::file::FileItem;
use backseat_s7k::record::Record;
use backseat_s7k::{Checksum, Frame, FrameHeader};
use serde::Serialize;

use self::record::{Content, content};
use crate::error::Error;
use crate::moment::Moment;
use crate::selection::Selection;
use crate::source::Source;

/// A line of `dump`.
#[derive(Serialize)]
struct Line<'a> {
    /// Bytes from the file's start.
    offset: u64,
    /// The time of the frame; `null` if it has none.
    utc: Option<Moment>,
    frame: FrameHeader,
    checksum: Sum,
    #[serde(flatten)]
    outcome: Outcome<'a>,
}

#[derive(Serialize)]
#[serde(rename_all = "snake_case")]
enum Outcome<'a> {
    Record(Box<Content<'a>>),
    Error(String),
}

#[derive(Serialize)]
struct Sum {
    state: &'static str,
    stored: u32,
}

/// Bytes that are no record.
#[derive(Serialize)]
struct Gap {
    offset: u64,
    bytes: u64,
    error: String,
}

/// How many records and damaged places `dump` wrote.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dumped {
    /// Records.
    pub records: u64,
    /// Places that are no record.
    pub damage: u64,
}

/// Writes one JSON object a line for each record of the selection, with its frame's header and all its fields, and with
/// its samples if they are wanted. A damaged place is an object with `offset`, `bytes` and `error`; a record that is not
/// what its type says has `error` instead of `record`.
///
/// # Errors
/// [`Error::Read`] and [`Error::Stdout`].
pub fn dump(source: &Source, selection: &Selection, samples: bool, out: &mut impl Write) -> Result<Dumped, Error> {
    let mut dumped = Dumped::default();
    let mut line = Vec::new();
    let mut records = source.records();
    while let Some(item) = records.next()? {
        line.clear();
        match item {
            FileItem::Record { frame, .. } if !selection.contains(frame.header()) => continue,
            FileItem::Record { offset, frame } => {
                dumped.records += 1;
                write_record(&mut line, offset, &frame, samples)
            }
            FileItem::Skipped(skipped) => {
                dumped.damage += 1;
                let gap = Gap {
                    offset: skipped.offset,
                    bytes: skipped.bytes,
                    error: skipped.why.to_string(),
                };
                serde_json::to_writer(&mut line, &gap)
            }
        }
        .map_err(|error| Error::Stdout(error.into()))?;
        line.push(b'\n');
        out.write_all(&line).map_err(Error::Stdout)?;
    }
    out.flush().map_err(Error::Stdout)?;
    Ok(dumped)
}

fn write_record(line: &mut Vec<u8>, offset: u64, frame: &Frame<'_>, samples: bool) -> serde_json::Result<()> {
    let record = Record::read(frame);
    let state = match frame.checksum() {
        Checksum::Valid => "valid",
        Checksum::Wrong { .. } => "wrong",
        Checksum::Unclaimed { right: true } => "unclaimed_right",
        Checksum::Unclaimed { right: false } => "unclaimed_wrong",
    };
    let outcome = match &record {
        Ok(record) => Outcome::Record(Box::new(content(record, frame, samples))),
        Err(error) => Outcome::Error(error.to_string()),
    };
    let object = Line {
        offset,
        utc: Moment::of(&frame.header().time),
        frame: *frame.header(),
        checksum: Sum {
            state,
            stored: frame.stored_checksum(),
        },
        outcome,
    };
    serde_json::to_writer(line, &object)
}
