//! `cut`: a part of a recording as a recording of its own.

use std::collections::BTreeSet;
use std::path::Path;

use backseat_s7k::file::{FileInfo, FileItem, FileWriter};
use backseat_s7k::record::Record;
use backseat_s7k::{Chars, DeviceId, Frame, Time7k};

use crate::error::Error;
use crate::moment::Moment;
use crate::output::Output;
use crate::selection::Selection;
use crate::source::Source;

/// What `cut` wrote.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cut {
    /// Records, without file header and catalogue.
    pub records: u64,
    /// The new file's length, bytes.
    pub bytes: u64,
    /// Records of the source that are left out because they have no time.
    pub without_time: u64,
    /// Damaged places of the source, which are left out.
    pub damage: u64,
}

impl core::fmt::Display for Cut {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{} records, {} bytes", self.records, self.bytes)?;
        if self.without_time > 0 {
            write!(f, "; {} records have no time and are left out", self.without_time)?;
        }
        if self.damage > 0 {
            write!(f, "; {} damaged places are left out", self.damage)?;
        }
        Ok(())
    }
}

/// What the first pass finds.
#[derive(Default)]
struct Survey {
    info: FileInfo,
    devices: BTreeSet<(u32, u16)>,
    records: u64,
    without_time: u64,
    damage: u64,
    span: Option<(Moment, Moment)>,
    first: Time7k,
    last: Time7k,
}

/// File header and catalogue: the new file gets its own.
const OWN: [u32; 2] = [7200, 7300];

/// Writes the records of a selection, byte for byte, into a whole file: with a file header, which has the names of the
/// source's, and with a catalogue.
///
/// # Errors
/// [`Error::Read`] and [`Error::Write`]; [`Error::Contents`] if the selection has no record.
pub fn cut(source: &Source, selection: &Selection, out: &Path) -> Result<Cut, Error> {
    let survey = survey(source, selection)?;
    if survey.records == 0 {
        return Err(Error::contents(source.path(), nothing(&survey)));
    }
    let failed = |error| Error::write(out, error);
    let mut writer = FileWriter::create(Output::create(out, source)?, survey.info, survey.first).map_err(failed)?;
    source.each_record(|_, frame| {
        if is_meant(selection, frame) {
            writer.write(frame).map_err(failed)?;
        }
        Ok(())
    })?;
    let bytes = writer.closed_length(0) - backseat_s7k::record::CatalogEntry::SIZE as u64;
    writer.finish(survey.last).map_err(failed)?.commit()?;
    Ok(Cut {
        records: survey.records,
        bytes,
        without_time: survey.without_time,
        damage: survey.damage,
    })
}

fn is_meant(selection: &Selection, frame: &Frame<'_>) -> bool {
    !OWN.contains(&frame.header().record_type) && selection.contains(frame.header())
}

fn nothing(survey: &Survey) -> String {
    match survey.span {
        Some((first, last)) => format!(
            "no record matches: its records are from {first} to {last}; see `backseat s7k info` for types and devices"
        ),
        None => "no record matches, and none has a time: leave --from and --to out".to_owned(),
    }
}

fn survey(source: &Source, selection: &Selection) -> Result<Survey, Error> {
    let mut survey = Survey::default();
    // The same cut of the same recording has the same identity; another has another.
    let mut identity = Identity::default();
    identity.add(format!("{selection:?}").as_bytes());
    let mut records = source.records();
    while let Some(item) = records.next()? {
        let FileItem::Record { frame, .. } = item else {
            survey.damage += 1;
            continue;
        };
        let header = frame.header();
        if let Ok(Record::FileHeader(record)) = Record::read(&frame) {
            let header = record.header;
            survey.info.session_id = [header.session_id_1, header.session_id_2];
            survey.info.user_name = header.user_name;
            survey.info.notes = header.notes;
            survey.info.recorder = header.recorder;
            survey.info.recorder_version = header.recorder_version;
            identity.add(&header.file_id_1.to_le_bytes());
            identity.add(&header.file_id_2.to_le_bytes());
        }
        if OWN.contains(&header.record_type) {
            continue;
        }
        let time = Moment::of(&header.time);
        if let Some(time) = time {
            let (first, last) = survey.span.unwrap_or((time, time));
            survey.span = Some((first.min(time), last.max(time)));
        }
        if selection.contains(header) {
            identity.add(&frame.stored_checksum().to_le_bytes());
            survey.devices.insert((header.device.0, header.enumerator));
            if survey.records == 0 {
                survey.first = header.time;
                survey.info.version_5 = header.version == 5;
            }
            survey.last = header.time;
            survey.records += 1;
        } else if time.is_none() && (selection.from.is_some() || selection.to.is_some()) {
            survey.without_time += 1;
        }
    }
    if survey.info.recorder == Chars::default() {
        survey.info.recorder = Chars::new("backseat").unwrap_or_default();
        survey.info.recorder_version = Chars::new(env!("CARGO_PKG_VERSION")).unwrap_or_default();
    }
    survey.info.file_id = identity.0;
    survey.info.devices = survey
        .devices
        .iter()
        .map(|(device, enumerator)| (DeviceId(*device), *enumerator))
        .collect();
    Ok(survey)
}

/// A file's identity: two sums of its bytes (FNV-1a with different starts).
struct Identity([u64; 2]);

impl Default for Identity {
    fn default() -> Self {
        Self([0xCBF2_9CE4_8422_2325, 0x9AE1_6A3B_2F90_404F])
    }
}

impl Identity {
    fn add(&mut self, bytes: &[u8]) {
        for sum in &mut self.0 {
            for byte in bytes {
                *sum = (*sum ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01B3);
            }
        }
    }
}
