use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::{self, Cursor, Seek, SeekFrom, Write};
use std::rc::Rc;

use super::*;
use crate::frame::{FRAME_LIMIT, Frame, FrameError, FrameHeader, FrameWriter};
use crate::record::Record;
use crate::{Chars, DeviceId, Time7k};

fn info() -> FileInfo {
    FileInfo {
        file_id: [1, 2],
        session_id: [3, 4],
        recorder: Chars::new("backseat").unwrap(),
        devices: vec![(DeviceId::SIDESCAN_HIGH, 0), (DeviceId::BLUEFIN, 1)],
        ..FileInfo::default()
    }
}

/// A record of a type that this crate does not decode, with its number and so many bytes.
fn record(number: u32, length: usize) -> Vec<u8> {
    let mut out = Vec::new();
    let mut frame = FrameWriter::begin(FrameHeader::new(9000, DeviceId(7)).counted(number), &mut out);
    frame
        .bytes()
        .extend((0..length).map(|index| u8::try_from(index % 251).unwrap()));
    frame.finish(FRAME_LIMIT).unwrap();
    out
}

fn frame(bytes: &[u8]) -> Frame<'_> {
    Frame::read(bytes, FRAME_LIMIT).unwrap()
}

/// A file of so many records of 100 bytes and more, closed or not.
fn file(records: u32, closed: bool) -> Vec<u8> {
    let mut writer = FileWriter::create(Cursor::new(Vec::new()), info(), Time7k::NONE).unwrap();
    for number in 0..records {
        writer.write(&frame(&record(number, 100 + number as usize))).unwrap();
    }
    if closed {
        writer.finish(Time7k::NONE).unwrap().into_inner()
    } else {
        writer_bytes(writer)
    }
}

/// What a writer that is killed leaves.
fn writer_bytes(writer: FileWriter<Cursor<Vec<u8>>>) -> Vec<u8> {
    let length = usize::try_from(writer.length()).unwrap();
    let closed = writer.finish(Time7k::NONE).unwrap().into_inner();
    let mut bytes = closed[..length].to_vec();
    let unclosed = FileWriter::create(Cursor::new(Vec::new()), info(), Time7k::NONE).unwrap();
    let header = usize::try_from(unclosed.length()).unwrap();
    bytes[..header].copy_from_slice(&unclosed_header()[..header]);
    bytes
}

fn unclosed_header() -> Vec<u8> {
    /// A file that forgets nothing, to look at after its writer is gone.
    #[derive(Clone, Debug)]
    struct Shared(Rc<RefCell<Cursor<Vec<u8>>>>);
    impl Write for Shared {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.borrow_mut().write(bytes)
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }
    impl Seek for Shared {
        fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
            self.0.borrow_mut().seek(to)
        }
    }
    impl LogFile for Shared {
        fn truncate(&mut self, length: u64) -> io::Result<()> {
            self.0.borrow_mut().truncate(length)
        }
    }
    let shared = Shared(Rc::default());
    drop(FileWriter::create(shared.clone(), info(), Time7k::NONE).unwrap());
    Rc::into_inner(shared.0).unwrap().into_inner().into_inner()
}

/// The records' numbers, and what was skipped.
fn read(bytes: &[u8]) -> (Vec<u32>, Vec<Skipped>) {
    let (mut records, mut skipped) = (Vec::new(), Vec::new());
    for item in Frames::new(bytes) {
        match item {
            FileItem::Record { offset, frame } => {
                let at = usize::try_from(offset).unwrap();
                assert_eq!(frame.bytes(), &bytes[at..at + frame.bytes().len()]);
                if frame.header().record_type == 9000 {
                    records.push(frame.header().record_count);
                }
            }
            FileItem::Skipped(bytes) => skipped.push(bytes),
        }
    }
    (records, skipped)
}

/// As [`read`], from a source that gives few bytes at once.
fn read_slowly(bytes: &[u8], at_once: usize) -> (Vec<u32>, Vec<Skipped>) {
    struct Slow<'a>(&'a [u8], usize);
    impl io::Read for Slow<'_> {
        fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
            let count = self.1.min(out.len()).min(self.0.len());
            out[..count].copy_from_slice(&self.0[..count]);
            self.0 = &self.0[count..];
            Ok(count)
        }
    }
    let mut reader = FileReader::new(Slow(bytes, at_once));
    let (mut records, mut skipped) = (Vec::new(), Vec::new());
    while let Some(item) = reader.next().unwrap() {
        match item {
            FileItem::Record { frame, .. } if frame.header().record_type == 9000 => {
                records.push(frame.header().record_count);
            }
            FileItem::Record { .. } => {}
            FileItem::Skipped(bytes) => skipped.push(bytes),
        }
    }
    (records, skipped)
}

#[test]
fn a_closed_file_has_its_header_first_and_its_catalogue_last() {
    let bytes = file(3, true);
    let items: Vec<FileItem<'_>> = Frames::new(&bytes).collect();
    let types: Vec<u32> = items
        .iter()
        .map(|item| match item {
            FileItem::Record { frame, .. } => frame.header().record_type,
            FileItem::Skipped(skipped) => panic!("{skipped}"),
        })
        .collect();
    assert_eq!(types, [7200, 9000, 9000, 9000, 7300]);
    let FileItem::Record { frame: first, .. } = items[0] else {
        panic!()
    };
    let Record::FileHeader(header) = Record::read(&first).unwrap() else {
        panic!()
    };
    assert_eq!(header.header.recorder.text(), "backseat");
    assert_eq!(
        header
            .devices()
            .map(|device| (device.device.0, device.enumerator))
            .collect::<Vec<_>>(),
        [(11_002, 0), (11_100, 1)]
    );
    let FileItem::Record { offset, frame: last } = items[4] else {
        panic!()
    };
    assert_eq!(header.catalog().unwrap().offset, offset);
    let Record::Catalog(catalog) = Record::read(&last).unwrap() else {
        panic!()
    };
    assert_eq!(
        catalog.entries().map(|entry| entry.record_type).collect::<Vec<_>>(),
        [7200, 9000, 9000, 9000]
    );
    assert!(items.iter().all(|item| matches!(item, FileItem::Record { frame, .. }
        if frame.checksum() == crate::Checksum::Valid)));
}

#[test]
fn an_index_is_the_same_with_and_without_the_catalogue() {
    let bytes = file(20, true);
    let scanned = Index::scan(Cursor::new(&bytes)).unwrap();
    assert_eq!(
        (scanned.entries.len(), scanned.skipped.len(), scanned.bytes),
        (22, 0, bytes.len() as u64)
    );
    assert_eq!(Index::from_catalog(Cursor::new(&bytes)).unwrap(), scanned);
    let unclosed = file(20, false);
    assert!(matches!(
        Index::from_catalog(Cursor::new(&unclosed)),
        Err(IndexError::NoCatalog)
    ));
    assert_eq!(Index::scan(Cursor::new(&unclosed)).unwrap().entries.len(), 21);
}

#[test]
fn a_catalogue_longer_than_the_limit_of_records_is_read() {
    // 350,000 entries of 48 bytes are over 16 MiB.
    let mut writer = FileWriter::create(Cursor::new(Vec::new()), info(), Time7k::NONE).unwrap();
    let record = record(1, 0);
    for _ in 0..350_000 {
        writer.write(&frame(&record)).unwrap();
    }
    let bytes = writer.finish(Time7k::NONE).unwrap().into_inner();
    let index = Index::from_catalog(Cursor::new(&bytes)).unwrap();
    assert_eq!(index.entries.len(), 350_002);
}

#[test]
fn a_catalogue_that_lies_is_refused() {
    let mut bytes = file(3, true);
    let catalog = Index::scan(Cursor::new(&bytes)).unwrap().entries[4].offset;
    let entry = usize::try_from(catalog).unwrap() + 64 + 14 + 48;
    bytes[entry + 4..entry + 12].copy_from_slice(&9999_u64.to_le_bytes());
    let error = Index::from_catalog(Cursor::new(&bytes)).unwrap_err().to_string();
    assert!(
        error.starts_with("entry 1 of the catalogue points to bytes 9999 to "),
        "{error}"
    );
    let cut = &bytes[..usize::try_from(catalog).unwrap()];
    let error = Index::from_catalog(Cursor::new(cut)).unwrap_err().to_string();
    assert_eq!(
        error,
        format!("no catalogue at byte {catalog}, where the file header says that it is")
    );
    assert!(matches!(
        Index::from_catalog(Cursor::new(b"")),
        Err(IndexError::NoCatalog)
    ));
}

#[test]
fn a_file_cut_anywhere_reads_up_to_the_cut() {
    let bytes = file(8, true);
    let entries = Index::scan(Cursor::new(&bytes)).unwrap().entries;
    for cut in 0..=bytes.len() {
        let whole = entries
            .iter()
            .filter(|entry| entry.offset + u64::from(entry.size) <= cut as u64);
        let expected: Vec<u32> = whole
            .clone()
            .filter(|entry| entry.record_type == 9000)
            .map(|entry| entry.record_count)
            .collect();
        let end = whole
            .max_by_key(|entry| entry.offset)
            .map_or(0, |entry| entry.offset + u64::from(entry.size));
        let (records, skipped) = read(&bytes[..cut]);
        assert_eq!(records, expected, "cut at {cut}");
        let left: u64 = skipped.iter().map(|skipped| skipped.bytes).sum();
        assert_eq!(end + left, cut as u64);
        let index = Index::scan(Cursor::new(&bytes[..cut])).unwrap();
        assert_eq!(
            index.entries.len(),
            entries
                .iter()
                .filter(|entry| entry.offset + u64::from(entry.size) <= cut as u64)
                .count()
        );
    }
}

#[test]
fn damage_costs_the_records_that_it_touches() {
    let good = file(8, true);
    let entries = Index::scan(Cursor::new(&good)).unwrap().entries;
    let damage = |place: usize, bytes: &[u8]| {
        let mut damaged = good.clone();
        damaged[place..place + bytes.len()].copy_from_slice(bytes);
        let found = read(&damaged);
        assert_eq!(read_slowly(&damaged, 50), found, "read in pieces of 50 bytes");
        let index = Index::scan(Cursor::new(&damaged)).unwrap();
        let numbers: Vec<u32> = index
            .entries
            .iter()
            .filter(|entry| entry.record_type == 9000)
            .map(|entry| entry.record_count)
            .collect();
        (found, numbers)
    };
    // Record 3 is entry 4.
    let start = usize::try_from(entries[4].offset).unwrap();
    let without_3 = vec![0, 1, 2, 4, 5, 6, 7];
    let ((records, skipped), indexed) = damage(start + 4, &[9; 4]);
    assert_eq!((&records, &indexed), (&without_3, &without_3));
    assert_eq!(
        (skipped.len(), skipped[0].offset, skipped[0].bytes),
        (1, entries[4].offset, u64::from(entries[4].size))
    );
    // A size above the limit, below the least, and a version of old.
    for bytes in [u32::MAX, 12] {
        let ((records, skipped), indexed) = damage(start + 8, &bytes.to_le_bytes());
        assert_eq!((&records, &indexed, skipped.len()), (&without_3, &without_3, 1));
        assert!(matches!(skipped[0].why, FrameError::Size { .. }));
    }
    let ((records, skipped), _) = damage(start, &[2, 0]);
    assert_eq!(
        (records, skipped[0].why),
        (without_3.clone(), FrameError::Version { version: 2 })
    );
    // A size that swallows two more records: they are found inside.
    let size = entries[4].size + entries[5].size + 9;
    let ((records, skipped), _) = damage(start + 8, &size.to_le_bytes());
    assert_eq!((records, skipped.len()), (without_3, 1));
    // Data only: the record is read, and its checksum tells.
    let ((records, skipped), _) = damage(start + 80, &[0xEE]);
    assert_eq!((records.len(), skipped.len()), (8, 0));
}

#[test]
fn bytes_that_are_no_file_are_skipped_whole() {
    let text = b"#!/bin/sh\necho this is no .s7k file\n".repeat(300);
    let (records, skipped) = read(&text);
    assert_eq!(
        (records.len(), skipped.len(), skipped[0].bytes),
        (0, 1, text.len() as u64)
    );
    assert_eq!(read_slowly(&text, 77), (vec![], skipped));
    assert_eq!(read(b""), (vec![], vec![]));
}

/// A folder in memory, whose disk has room for so many bytes.
#[derive(Clone, Default)]
struct Memory {
    files: Rc<RefCell<BTreeMap<String, Cursor<Vec<u8>>>>>,
    room: Option<usize>,
}

struct MemoryFile(Memory, String);

impl Memory {
    fn used(&self) -> usize {
        self.files.borrow().values().map(|file| file.get_ref().len()).sum()
    }

    fn with<T>(&self, name: &str, act: impl FnOnce(&mut Cursor<Vec<u8>>) -> T) -> T {
        act(self.files.borrow_mut().get_mut(name).unwrap())
    }
}

impl Folder for Memory {
    type File = MemoryFile;

    fn create(&mut self, name: &str) -> io::Result<MemoryFile> {
        assert!(
            self.files
                .borrow_mut()
                .insert(name.to_owned(), Cursor::default())
                .is_none()
        );
        Ok(MemoryFile(self.clone(), name.to_owned()))
    }
}

impl Write for MemoryFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let left = self
            .0
            .room
            .map_or(bytes.len(), |room| room.saturating_sub(self.0.used()));
        if left == 0 {
            return Err(io::Error::from(io::ErrorKind::StorageFull));
        }
        self.0.with(&self.1, |file| file.write(&bytes[..left.min(bytes.len())]))
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for MemoryFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.0.with(&self.1, |file| file.seek(to))
    }
}

impl LogFile for MemoryFile {
    fn truncate(&mut self, length: u64) -> io::Result<()> {
        self.0.with(&self.1, |file| file.truncate(length))
    }
}

#[test]
fn a_series_keeps_to_its_size_and_repeats_its_last_records() {
    let folder = Memory::default();
    let rotation = Rotation {
        file_size: 6000,
        overlap: 2,
    };
    let mut writer = RotatingWriter::new(folder.clone(), "line".to_owned(), info(), rotation);
    assert_eq!(writer.current(), None);
    for number in 0..40 {
        writer.write(&frame(&record(number, 500))).unwrap();
    }
    let (name, length) = writer.current().unwrap();
    assert_eq!((name.as_str(), length > 600), ("line_0006.s7k", true));
    writer.finish(Time7k::NONE).unwrap();
    let files = folder.files.borrow();
    let mut next = 0;
    for (index, (name, file)) in files.iter().enumerate() {
        let bytes = file.get_ref();
        assert!(bytes.len() <= 6000, "{name}: {}", bytes.len());
        let (records, skipped) = read(bytes);
        assert_eq!(skipped, []);
        assert_eq!(
            Index::from_catalog(Cursor::new(bytes)).unwrap(),
            Index::scan(Cursor::new(bytes)).unwrap()
        );
        let first = if index == 0 { 0 } else { next - 2 };
        assert_eq!(
            records,
            (first..first + u32::try_from(records.len()).unwrap()).collect::<Vec<_>>(),
            "{name}"
        );
        next = records.last().unwrap() + 1;
    }
    assert_eq!(next, 40);
}

#[test]
fn a_series_goes_on_under_another_name_with_its_last_records() {
    let folder = Memory::default();
    let rotation = Rotation {
        file_size: u64::MAX,
        overlap: 2,
    };
    let mut writer = RotatingWriter::new(folder.clone(), "a".to_owned(), info(), rotation);
    for number in 0..4 {
        writer.write(&frame(&record(number, 50))).unwrap();
    }
    for stem in ["b", "c"] {
        writer.set_series(stem.to_owned(), info());
        assert_eq!(writer.current().unwrap().0, "a_0000.s7k");
    }
    writer.switch(Time7k::NONE).unwrap();
    writer.write(&frame(&record(4, 50))).unwrap();
    writer.switch(Time7k::NONE).unwrap();
    writer.write(&frame(&record(5, 50))).unwrap();
    assert_eq!(writer.current().unwrap().0, "c_0001.s7k");
    writer.finish(Time7k::NONE).unwrap();
    let files = folder.files.borrow();
    let held: Vec<(&str, Vec<u32>, u64)> = files
        .iter()
        .map(|(name, file)| {
            let header = Frame::read(file.get_ref(), FRAME_LIMIT).unwrap();
            let Ok(Record::FileHeader(header)) = Record::read(&header) else {
                panic!("{name} has no header");
            };
            (name.as_str(), read(file.get_ref()).0, header.header.file_id_2)
        })
        .collect();
    assert_eq!(
        held,
        [
            ("a_0000.s7k", vec![0, 1, 2, 3], 2),
            ("c_0000.s7k", vec![2, 3, 4], 2),
            ("c_0001.s7k", vec![3, 4, 5], 3)
        ]
    );
}

#[test]
fn a_record_longer_than_a_file_may_be_has_a_file_of_its_own() {
    let folder = Memory::default();
    let rotation = Rotation {
        file_size: 100,
        overlap: 1000,
    };
    let mut writer = RotatingWriter::new(folder.clone(), "line".to_owned(), info(), rotation);
    for number in 0..3 {
        writer.write(&frame(&record(number, 5000))).unwrap();
    }
    writer.finish(Time7k::NONE).unwrap();
    let numbers: Vec<Vec<u32>> = folder
        .files
        .borrow()
        .values()
        .map(|file| read(file.get_ref()).0)
        .collect();
    assert_eq!(numbers, [[0], [1], [2]]);
}

#[test]
fn a_full_disk_leaves_whole_records() {
    let folder = Memory {
        room: Some(3000),
        ..Memory::default()
    };
    let rotation = Rotation {
        file_size: 1 << 30,
        overlap: 0,
    };
    let mut writer = RotatingWriter::new(folder.clone(), "line".to_owned(), info(), rotation);
    let mut written = 0;
    let error = loop {
        match writer.write(&frame(&record(written, 400))) {
            Ok(()) => written += 1,
            Err(error) => break error,
        }
    };
    assert_eq!(error.kind(), io::ErrorKind::StorageFull);
    let bytes = folder.files.borrow()["line_0000.s7k"].get_ref().clone();
    let (records, skipped) = read(&bytes);
    assert_eq!((records, skipped), ((0..written).collect(), vec![]));
    // A smaller record may still have room, and follows the last whole one.
    writer.write(&frame(&record(written, 1))).unwrap();
    let bytes = folder.files.borrow()["line_0000.s7k"].get_ref().clone();
    assert_eq!(read(&bytes), ((0..=written).collect(), vec![]));
}

#[test]
fn what_is_read_and_written_again_is_the_same_file() {
    let bytes = file(9, true);
    let mut out = Vec::new();
    for item in Frames::new(&bytes) {
        let FileItem::Record { frame, .. } = item else { panic!() };
        out.extend_from_slice(frame.bytes());
    }
    assert_eq!(out, bytes);
}
