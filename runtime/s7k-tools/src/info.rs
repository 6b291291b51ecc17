//! `info`: what a recording holds.

mod group;
mod text;

use std::collections::BTreeMap;
use std::io::Write;

use backseat_s7k::file::{FileItem, IndexEntry};
use backseat_s7k::record::{HeaderLayout, Record};
use backseat_s7k::{BluefinChecksum, Checksum, Frame};
use serde::Serialize;

use crate::catalogue::{Catalogue, CatalogueAudit};
use crate::error::Error;
use crate::listed::Listed;
use crate::moment::Moment;
use crate::navigated::Navigated;
use crate::source::Source;

pub use group::{CountGap, Group, TimeGap};

/// What a recording holds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Info {
    /// Its length, bytes.
    pub bytes: u64,
    /// How many records.
    pub records: u64,
    /// The earliest time.
    pub first: Option<Moment>,
    /// The latest time.
    pub last: Option<Moment>,
    /// Records in each protocol version.
    pub protocol_versions: BTreeMap<u16, u64>,
    /// What its file header says; `None` if it has none.
    pub file_header: Option<FileHeader>,
    /// How long the headers of records 3000 and 3001 are.
    pub header_layouts: HeaderLayouts,
    /// The records' checksums.
    pub checksums: Checksums,
    /// The checksums of the frames in records 3100.
    pub bluefin_checksums: BluefinChecksums,
    /// Records that are not what their type says.
    pub undecodable: Listed<Place>,
    /// Whether the catalogue is right.
    pub catalogue: Catalogue,
    /// Places that are no record.
    pub damage: Damage,
    /// Why no ping can be placed on a map, if so: no navigation, or none at that time.
    pub warning: Option<String>,
    /// The records by type and device.
    pub groups: Vec<Group>,
}

/// What a file header says.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FileHeader {
    /// The program that recorded.
    pub recorder: String,
    /// Its version.
    pub recorder_version: String,
    /// A name that the user gave.
    pub user_name: String,
    /// Notes.
    pub notes: String,
    /// Devices and enumerators.
    pub devices: Vec<(u32, u16)>,
}

/// How many records 3000 and 3001 have which length of header.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct HeaderLayouts {
    /// 20 bytes, as specified.
    pub spec: u64,
    /// 32 bytes.
    pub padded: u64,
}

/// How many records have which checksum.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Checksums {
    /// Claimed, and right.
    pub valid: u64,
    /// Not claimed, and right all the same.
    pub unclaimed_right: u64,
    /// Not claimed, and not right.
    pub unclaimed_wrong: u64,
    /// Claimed, and wrong.
    pub wrong: Listed<Place>,
}

/// By which reading of the specification the checksums of Bluefin frames are right.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct BluefinChecksums {
    /// CRC-32 over the whole packet, with the checksum as zero.
    pub whole_packet: u64,
    /// CRC-32 over the data.
    pub data_only: u64,
    /// Zero: none.
    pub none: u64,
    /// By neither.
    pub neither: u64,
}

/// A place, and what is wrong there.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Place {
    /// Bytes from the file's start.
    pub offset: u64,
    /// What is wrong.
    pub fault: String,
}

/// Places that are no record.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Damage {
    /// Their length in all, bytes.
    pub bytes: u64,
    /// The places.
    pub places: Listed<DamagedPlace>,
}

/// A place that is no record.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DamagedPlace {
    /// Bytes from the file's start.
    pub offset: u64,
    /// Its length, bytes.
    pub bytes: u64,
    /// What is wrong with its first bytes.
    pub fault: String,
}

/// Reads a recording in one pass and says what it holds.
///
/// # Errors
/// [`Error::Read`].
pub fn info(source: &Source) -> Result<Info, Error> {
    let mut gathering = Gathering::default();
    let mut catalogue = CatalogueAudit::begin(source)?;
    let mut records = source.records();
    while let Some(item) = records.next()? {
        match item {
            FileItem::Record { offset, frame } => {
                gathering.add(offset, &frame);
                catalogue.record(offset, frame.header(), &mut |_, _| Ok(()))?;
            }
            FileItem::Skipped(skipped) => {
                gathering.damage.bytes += skipped.bytes;
                gathering.damage.places.push(DamagedPlace {
                    offset: skipped.offset,
                    bytes: skipped.bytes,
                    fault: skipped.why.to_string(),
                });
            }
        }
    }
    let catalogue = catalogue.finish(&mut |_, _| Ok(()))?;
    Ok(gathering.finish(source.bytes(), catalogue))
}

/// Prints it for people, or as one JSON object.
///
/// # Errors
/// [`Error::Stdout`].
pub fn write_info(info: &Info, source: &Source, json: bool, out: &mut impl Write) -> Result<(), Error> {
    /// The path in front of everything else.
    #[derive(Serialize)]
    struct Named<'a> {
        file: std::borrow::Cow<'a, str>,
        #[serde(flatten)]
        info: &'a Info,
    }
    let file = source.path().to_string_lossy();
    let text = if json {
        let named = Named { file, info };
        serde_json::to_string(&named).map_err(|error| Error::Stdout(error.into()))? + "\n"
    } else {
        text::text(&file, info)
    };
    out.write_all(text.as_bytes())
        .and_then(|()| out.flush())
        .map_err(Error::Stdout)
}

#[derive(Debug, Default)]
struct Gathering {
    records: u64,
    protocol_versions: BTreeMap<u16, u64>,
    file_header: Option<FileHeader>,
    header_layouts: HeaderLayouts,
    checksums: Checksums,
    bluefin_checksums: BluefinChecksums,
    undecodable: Listed<Place>,
    damage: Damage,
    navigated: Navigated,
    groups: BTreeMap<(u32, u32, u16), group::Gathering>,
}

impl Gathering {
    fn add(&mut self, offset: u64, frame: &Frame<'_>) {
        let header = frame.header();
        self.records += 1;
        *self.protocol_versions.entry(header.version).or_default() += 1;
        let key = (header.record_type, header.device.0, header.enumerator);
        self.groups.entry(key).or_default().add(&IndexEntry {
            offset,
            size: header.size,
            record_type: header.record_type,
            device: header.device,
            enumerator: header.enumerator,
            time: header.time,
            record_count: header.record_count,
        });
        match frame.checksum() {
            Checksum::Valid => self.checksums.valid += 1,
            Checksum::Unclaimed { right: true } => self.checksums.unclaimed_right += 1,
            Checksum::Unclaimed { right: false } => self.checksums.unclaimed_wrong += 1,
            Checksum::Wrong { stored, computed } => self.checksums.wrong.push(Place {
                offset,
                fault: format!("{stored:#010x} is stored, {computed:#010x} is right"),
            }),
        }
        match Record::read(frame) {
            Ok(record) => {
                self.navigated.add(header, &record);
                self.record(offset, &record);
            }
            Err(error) => self.undecodable.push(Place {
                offset,
                fault: error.to_string(),
            }),
        }
    }

    fn record(&mut self, offset: u64, record: &Record<'_>) {
        match record {
            Record::SideScan(imagery) | Record::SubBottom(imagery) => match imagery.layout() {
                HeaderLayout::Spec => self.header_layouts.spec += 1,
                HeaderLayout::Padded => self.header_layouts.padded += 1,
            },
            Record::Bluefin(record) => {
                for frame in record.frames() {
                    let counts = &mut self.bluefin_checksums;
                    let matches = |reading| frame.checksum_matches(reading) == Some(true);
                    let count = if matches(BluefinChecksum::WholePacket) {
                        &mut counts.whole_packet
                    } else if matches(BluefinChecksum::DataOnly) {
                        &mut counts.data_only
                    } else if frame.header.checksum == 0 {
                        &mut counts.none
                    } else {
                        &mut counts.neither
                    };
                    *count += 1;
                }
            }
            Record::FileHeader(record) if offset == 0 => {
                let devices = record.devices().map(|device| (device.device.0, device.enumerator));
                self.file_header = Some(FileHeader {
                    recorder: record.header.recorder.text().into_owned(),
                    recorder_version: record.header.recorder_version.text().into_owned(),
                    user_name: record.header.user_name.text().into_owned(),
                    notes: record.header.notes.text().into_owned(),
                    devices: devices.collect(),
                });
            }
            Record::FileHeader(_)
            | Record::Catalog(_)
            | Record::Time(..)
            | Record::Command(_)
            | Record::Acknowledge(..)
            | Record::Message(_)
            | Record::Other(_) => {}
        }
    }

    fn finish(self, bytes: u64, catalogue: Catalogue) -> Info {
        let groups: Vec<Group> = self.groups.into_iter().map(|(key, group)| group.finish(key)).collect();
        Info {
            bytes,
            records: self.records,
            first: groups.iter().filter_map(|group| group.first).min(),
            last: groups.iter().filter_map(|group| group.last).max(),
            protocol_versions: self.protocol_versions,
            file_header: self.file_header,
            header_layouts: self.header_layouts,
            checksums: self.checksums,
            bluefin_checksums: self.bluefin_checksums,
            undecodable: self.undecodable,
            catalogue,
            damage: self.damage,
            warning: self.navigated.warning(),
            groups,
        }
    }
}
