//! Compares the catalogue of a recording with its records, in one pass over both.

use std::io::{BufReader, Read};

use backseat_s7k::record::{CatalogEntry, CatalogHeader, CatalogLocation};
use backseat_s7k::{FrameHeader, read_header};
use serde::Serialize;

use crate::error::Error;
use crate::source::{Part, Source};

/// What is known of a recording's catalogue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case", tag = "state")]
pub enum Catalogue {
    /// The recording names none: it was not closed, or its writer makes none.
    Absent,
    /// The file header names one that is not there.
    NotThere {
        /// Where it would begin, in bytes from the start.
        offset: u64,
    },
    /// It has an entry for every record, and each is right.
    Matches {
        /// Where it begins, in bytes from the start.
        offset: u64,
        /// Its entries.
        entries: u32,
    },
    /// It differs from the records.
    Differs {
        /// Where it begins, in bytes from the start.
        offset: u64,
        /// Its entries.
        entries: u32,
        /// How many differences there are.
        differences: u64,
    },
}

/// Takes the records in the order of the file, and reports what the catalogue says otherwise.
pub(crate) struct CatalogueAudit<'s> {
    state: Catalogue,
    entries: Option<Entries<'s>>,
    next: Option<CatalogEntry>,
}

/// Entries as they are read.
struct Entries<'s> {
    source: &'s Source,
    part: BufReader<Part<'s>>,
    /// Where the first entry lies.
    at: u64,
    /// How many have been read.
    read: u32,
    count: u32,
}

/// Where the entries begin in a catalogue's frame.
const ENTRIES_AT: u64 = (FrameHeader::SIZE + CatalogHeader::SIZE) as u64;

impl<'s> CatalogueAudit<'s> {
    pub(crate) fn begin(source: &'s Source) -> Result<Self, Error> {
        let Some(CatalogLocation { offset, .. }) = source.catalog() else {
            return Ok(Self {
                state: Catalogue::Absent,
                entries: None,
                next: None,
            });
        };
        let mut start = [0; ENTRIES_AT as usize];
        let there = offset.checked_add(ENTRIES_AT).is_some_and(|end| end <= source.bytes());
        if there {
            source
                .part(offset)
                .read_exact(&mut start)
                .map_err(|error| source.read_error(error))?;
        }
        let header = read_header(&start, source.limit())
            .ok()
            .filter(|header| header.record_type == 7300);
        let list = CatalogHeader::read(&start[FrameHeader::SIZE..]).ok();
        let (Some(header), Some(list)) = (header, list) else {
            return Ok(Self {
                state: Catalogue::NotThere { offset },
                entries: None,
                next: None,
            });
        };
        let room = u64::from(header.size)
            .min(source.bytes() - offset)
            .saturating_sub(ENTRIES_AT + 4);
        let fit = u32::try_from(room / CatalogEntry::SIZE as u64).unwrap_or(u32::MAX);
        let mut entries = Entries {
            source,
            part: BufReader::new(source.part(offset + ENTRIES_AT)),
            at: offset + ENTRIES_AT,
            read: 0,
            count: list.entries.min(fit),
        };
        Ok(Self {
            state: Catalogue::Matches {
                offset,
                entries: list.entries,
            },
            next: entries.next()?,
            entries: Some(entries),
        })
    }

    /// The next record of the file.
    pub(crate) fn record(
        &mut self,
        offset: u64,
        header: &FrameHeader,
        found: &mut dyn FnMut(u64, String) -> Result<(), Error>,
    ) -> Result<(), Error> {
        if self.entries.is_none() {
            return Ok(());
        }
        while let Some(entry) = self.next.filter(|entry| entry.offset < offset) {
            self.no_record(&entry, found)?;
            self.advance(found)?;
        }
        match self.next.filter(|entry| entry.offset == offset) {
            Some(entry) => {
                for what in differences(&entry, header) {
                    let (number, at) = self.place();
                    let text = format!("catalogue entry {number}: {what} at byte {offset}");
                    self.differ(at, text, found)?;
                }
                self.advance(found)
            }
            // The catalogue has no entry for itself. Without an order nothing is missing.
            None if self.entries.is_some() && !self.is_catalogue(offset) => {
                let text = format!("a record of type {} is not in the catalogue", header.record_type);
                self.differ(offset, text, found)
            }
            None => Ok(()),
        }
    }

    /// The end of the file.
    pub(crate) fn finish(
        mut self,
        found: &mut dyn FnMut(u64, String) -> Result<(), Error>,
    ) -> Result<Catalogue, Error> {
        while let Some(entry) = self.next {
            self.no_record(&entry, found)?;
            self.advance(found)?;
        }
        match self.state {
            Catalogue::NotThere { offset } => {
                found(
                    0,
                    format!("the file header names a catalogue at byte {offset}, and there is none"),
                )?;
            }
            Catalogue::Matches { offset, entries } | Catalogue::Differs { offset, entries, .. } => {
                if self.entries.as_ref().is_some_and(|list| list.count < entries) {
                    let text = format!("the catalogue says that it has {entries} entries, and is too short for them");
                    self.differ(offset, text, found)?;
                }
            }
            Catalogue::Absent => {}
        }
        Ok(self.state)
    }

    fn is_catalogue(&self, record: u64) -> bool {
        match self.state {
            Catalogue::Matches { offset, .. } | Catalogue::Differs { offset, .. } => offset == record,
            Catalogue::Absent | Catalogue::NotThere { .. } => false,
        }
    }

    /// Number and place of the entry that is compared.
    fn place(&self) -> (u32, u64) {
        self.entries.as_ref().map_or((0, 0), |entries| {
            let number = entries.read.saturating_sub(1);
            (number, entries.at + u64::from(number) * CatalogEntry::SIZE as u64)
        })
    }

    fn no_record(
        &mut self,
        entry: &CatalogEntry,
        found: &mut dyn FnMut(u64, String) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let (number, at) = self.place();
        let text = format!(
            "catalogue entry {number}: it points to byte {}, where no record begins",
            entry.offset
        );
        self.differ(at, text, found)
    }

    fn advance(&mut self, found: &mut dyn FnMut(u64, String) -> Result<(), Error>) -> Result<(), Error> {
        let Some(entries) = &mut self.entries else {
            return Ok(());
        };
        let before = self.next.map_or(0, |entry| entry.offset);
        self.next = entries.next()?;
        if self.next.is_some_and(|entry| entry.offset <= before) {
            let (number, at) = self.place();
            let text = format!(
                "catalogue entry {number}: it is not in the order of the file; entries from here on are not compared"
            );
            self.differ(at, text, found)?;
            self.next = None;
            self.entries = None;
        }
        Ok(())
    }

    fn differ(
        &mut self,
        at: u64,
        text: String,
        found: &mut dyn FnMut(u64, String) -> Result<(), Error>,
    ) -> Result<(), Error> {
        self.state = match self.state {
            Catalogue::Matches { offset, entries } => Catalogue::Differs {
                offset,
                entries,
                differences: 1,
            },
            Catalogue::Differs {
                offset,
                entries,
                differences,
            } => Catalogue::Differs {
                offset,
                entries,
                differences: differences + 1,
            },
            state @ (Catalogue::Absent | Catalogue::NotThere { .. }) => state,
        };
        found(at, text)
    }
}

impl Entries<'_> {
    fn next(&mut self) -> Result<Option<CatalogEntry>, Error> {
        if self.read == self.count {
            return Ok(None);
        }
        let mut bytes = [0; CatalogEntry::SIZE];
        self.part
            .read_exact(&mut bytes)
            .map_err(|error| self.source.read_error(error))?;
        self.read += 1;
        Ok(CatalogEntry::read(&bytes).ok())
    }
}

/// What an entry says otherwise than the record's own header.
fn differences(entry: &CatalogEntry, header: &FrameHeader) -> Vec<String> {
    let low = |number: u32| (number & 0xFFFF) as u16;
    let pairs = [
        ("size", entry.size.to_string(), header.size.to_string()),
        (
            "type",
            entry.record_type.to_string(),
            low(header.record_type).to_string(),
        ),
        ("device", entry.device.to_string(), low(header.device.0).to_string()),
        (
            "enumerator",
            entry.enumerator.to_string(),
            header.enumerator.to_string(),
        ),
        ("time", entry.time.to_string(), header.time.to_string()),
        (
            "record count",
            entry.record_count.to_string(),
            header.record_count.to_string(),
        ),
    ];
    let differ = pairs.into_iter().filter(|(_, entry, record)| entry != record);
    differ
        .map(|(name, entry, record)| format!("{name} {entry}, but {record} in the record"))
        .collect()
}
