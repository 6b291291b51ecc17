//! `verify`: what is wrong with a recording.

use std::io::Write;

use backseat_s7k::Checksum;
use backseat_s7k::file::FileItem;
use backseat_s7k::record::Record;
use serde::Serialize;

use crate::catalogue::{Catalogue, CatalogueAudit};
use crate::error::Error;
use crate::navigated::Navigated;
use crate::parts::faults;
use crate::source::Source;

/// How many findings of each kind a recording has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Verdict {
    /// Records.
    pub records: u64,
    /// Places that are no record.
    pub damage: u64,
    /// Records with a wrong checksum that they claim to be right.
    pub checksums: u64,
    /// Records that are not what their type says.
    pub records_undecodable: u64,
    /// Values outside their ranges.
    pub values: u64,
    /// Differences between the catalogue and the records.
    pub catalogue_differences: u64,
    /// Whether there is a catalogue. A recording without one is no finding.
    pub catalogue: Catalogue,
    /// Why no ping can be placed on a map, if so. This is no finding: the records themselves are right.
    pub warning: Option<String>,
}

/// One finding, as `--json` prints it.
#[derive(Debug, Serialize)]
struct Finding<'a> {
    offset: u64,
    kind: &'static str,
    finding: &'a str,
}

impl Verdict {
    /// Whether nothing is wrong.
    #[must_use]
    pub const fn is_right(&self) -> bool {
        self.damage == 0
            && self.checksums == 0
            && self.records_undecodable == 0
            && self.values == 0
            && self.catalogue_differences == 0
    }
}

impl core::fmt::Display for Verdict {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{} records: ", self.records)?;
        if self.is_right() {
            f.write_str("nothing wrong")?;
        } else {
            let kinds = [
                (self.damage, "damaged place", "damaged places"),
                (self.checksums, "wrong checksum", "wrong checksums"),
                (
                    self.records_undecodable,
                    "record that is not what its type says",
                    "records that are not what their types say",
                ),
                (self.values, "value outside its range", "values outside their ranges"),
                (
                    self.catalogue_differences,
                    "difference in the catalogue",
                    "differences in the catalogue",
                ),
            ];
            let found: Vec<String> = kinds
                .iter()
                .filter(|(number, _, _)| *number > 0)
                .map(|(number, one, many)| format!("{number} {}", if *number == 1 { one } else { many }))
                .collect();
            f.write_str(&found.join(", "))?;
        }
        if self.catalogue == Catalogue::Absent {
            f.write_str("; no catalogue")?;
        }
        if let Some(warning) = &self.warning {
            write!(f, "; warning: {warning}")?;
        }
        Ok(())
    }
}

/// Reads a recording in one pass and writes a line for each finding, with its place in bytes from the file's start.
///
/// # Errors
/// [`Error::Read`] and [`Error::Stdout`].
pub fn verify(source: &Source, json: bool, out: &mut impl Write) -> Result<Verdict, Error> {
    let mut write = |offset: u64, kind: &'static str, finding: &str| -> Result<(), Error> {
        let line = if json {
            serde_json::to_string(&Finding { offset, kind, finding }).map_err(|error| Error::Stdout(error.into()))?
        } else {
            format!("byte {offset}: {finding}")
        };
        writeln!(out, "{line}").map_err(Error::Stdout)
    };
    let mut verdict = Verdict {
        records: 0,
        damage: 0,
        checksums: 0,
        records_undecodable: 0,
        values: 0,
        catalogue_differences: 0,
        catalogue: Catalogue::Absent,
        warning: None,
    };
    let mut navigated = Navigated::default();
    let mut catalogue = CatalogueAudit::begin(source)?;
    let mut differences = 0;
    let mut records = source.records();
    while let Some(item) = records.next()? {
        let (offset, frame) = match item {
            FileItem::Record { offset, frame } => (offset, frame),
            FileItem::Skipped(skipped) => {
                verdict.damage += 1;
                let (bytes, why) = (skipped.bytes, skipped.why);
                write(
                    skipped.offset,
                    "damage",
                    &format!("{bytes} bytes are not a record: {why}"),
                )?;
                continue;
            }
        };
        verdict.records += 1;
        let header = frame.header();
        if let Checksum::Wrong { stored, computed } = frame.checksum() {
            verdict.checksums += 1;
            let (record_type, size) = (header.record_type, header.size);
            let text = format!(
                "record {record_type} of {size} bytes: checksum {stored:#010x} is wrong, {computed:#010x} is right"
            );
            write(offset, "checksum", &text)?;
        }
        match Record::read(&frame) {
            Ok(record) => {
                navigated.add(header, &record);
                for (at, fault) in faults(&frame, &record) {
                    verdict.values += 1;
                    write(
                        offset + at as u64,
                        "value",
                        &format!("record {}: {fault}", header.record_type),
                    )?;
                }
            }
            Err(error) => {
                verdict.records_undecodable += 1;
                write(offset, "record", &error.to_string())?;
            }
        }
        catalogue.record(offset, header, &mut |at, text| {
            differences += 1;
            write(at, "catalogue", &text)
        })?;
    }
    verdict.catalogue = catalogue.finish(&mut |at, text| {
        differences += 1;
        write(at, "catalogue", &text)
    })?;
    verdict.catalogue_differences = differences;
    verdict.warning = navigated.warning();
    out.flush().map_err(Error::Stdout)?;
    Ok(verdict)
}
