//! Writes a series of files: each ends at a size, and the next repeats its last records.

use std::collections::VecDeque;
use std::io;

use super::writer::{FileInfo, FileWriter, LogFile};
use crate::Time7k;
use crate::frame::{FRAME_LIMIT, Frame};

/// Where files are made.
pub trait Folder {
    /// A file of this folder.
    type File: LogFile;

    /// Makes a new file. A file of this name that exists is an error.
    ///
    /// # Errors
    /// The folder's own.
    fn create(&mut self, name: &str) -> io::Result<Self::File>;
}

/// When a file ends, and what the next one repeats (command 26).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rotation {
    /// A file is at most so long, bytes, its catalogue included; but it holds at least one record of its own.
    pub file_size: u64,
    /// How many records of a file the next one repeats at its start. They take at most half of the next one.
    pub overlap: u32,
}

/// Writes a series of files, named `STEM_0000.s7k` and on. The second half of a file's identifier is that of the series
/// and the file's number added.
#[derive(Debug)]
pub struct RotatingWriter<D: Folder> {
    folder: D,
    info: FileInfo,
    stem: String,
    /// The stem of the file that is open, where it is another one.
    open_stem: Option<String>,
    rotation: Rotation,
    /// The number of the file that is open, and the file.
    open: Option<(u32, FileWriter<D::File>)>,
    number: u32,
    last: VecDeque<Vec<u8>>,
    last_bytes: u64,
    /// The file that is open holds a record that is not repeated.
    own: bool,
}

impl<D: Folder> RotatingWriter<D> {
    /// Makes no file before the first record. `stem` is the beginning of the files' names.
    pub const fn new(folder: D, stem: String, info: FileInfo, rotation: Rotation) -> Self {
        Self {
            folder,
            info,
            stem,
            open_stem: None,
            rotation,
            open: None,
            number: 0,
            last: VecDeque::new(),
            last_bytes: 0,
            own: false,
        }
    }

    /// The name of the file that is open, and its length in bytes.
    #[must_use]
    pub fn current(&self) -> Option<(String, u64)> {
        self.open.as_ref().map(|(number, writer)| {
            let stem = self.open_stem.as_ref().unwrap_or(&self.stem);
            (name(stem, *number), writer.length())
        })
    }

    /// The name of the file that is open, or else of the one that the next record begins.
    #[must_use]
    pub fn next_name(&self) -> String {
        self.current()
            .map_or_else(|| name(&self.stem, self.number), |(name, _)| name)
    }

    /// Writes a record; before it, ends the file if it would become too long, and begins the next.
    ///
    /// # Errors
    /// The folder's or the file's own. Files that were ended are whole; the record was not written.
    pub fn write(&mut self, frame: &Frame<'_>) -> io::Result<()> {
        let size = frame.bytes().len() as u64;
        let full = |writer: &FileWriter<D::File>| writer.closed_length(size) > self.rotation.file_size;
        if self.own && self.open.as_ref().is_some_and(|(_, writer)| full(writer)) {
            self.switch(frame.header().time)?;
        }
        if self.open.is_none() {
            // The frames of a file are of one version.
            self.info.version_5 = frame.header().version == 5;
            self.begin(frame.header().time)?;
        }
        if let Some((_, writer)) = &mut self.open {
            writer.write(frame)?;
        }
        self.own = true;
        self.keep(frame);
        Ok(())
    }

    /// Begins a file and repeats the last records of the one before.
    fn begin(&mut self, time: Time7k) -> io::Result<()> {
        let file = self.folder.create(&name(&self.stem, self.number))?;
        self.open_stem = None;
        let number = self.number;
        self.number += 1;
        let mut info = self.info.clone();
        info.file_id[1] = info.file_id[1].wrapping_add(u64::from(number));
        let mut writer = FileWriter::create(file, info, time)?;
        for record in &self.last {
            if let Ok(frame) = Frame::read(record, usize::MAX) {
                writer.write(&frame)?;
            }
        }
        self.own = false;
        self.open = Some((number, writer));
        Ok(())
    }

    /// Ends the file that is open. The next record begins another, which repeats the last records.
    ///
    /// # Errors
    /// The file's own; the file is closed in any case.
    pub fn switch(&mut self, time: Time7k) -> io::Result<()> {
        match self.open.take() {
            Some((_, writer)) => writer.finish(time).map(drop),
            None => Ok(()),
        }
    }

    /// Ends the series: the last file gets its catalogue.
    ///
    /// # Errors
    /// The file's own.
    pub fn finish(mut self, time: Time7k) -> io::Result<D> {
        self.switch(time)?;
        Ok(self.folder)
    }

    /// Sets the beginning of the names and the header of the files that come; their numbers begin at 0 again. The file
    /// that is open stays open and keeps its name: see [`Self::switch`]. The next file repeats the last records of the
    /// one before, whatever its name.
    pub fn set_series(&mut self, stem: String, info: FileInfo) {
        self.info = info;
        if self.stem != stem {
            let before = core::mem::replace(&mut self.stem, stem);
            if self.open.is_some() {
                self.open_stem.get_or_insert(before);
            }
            self.number = 0;
        }
    }

    /// Sets size and overlap for what comes.
    pub fn set_rotation(&mut self, rotation: Rotation) {
        self.rotation = rotation;
        self.shorten();
    }

    /// Keeps a copy of the record for the next file.
    fn keep(&mut self, frame: &Frame<'_>) {
        if self.rotation.overlap == 0 {
            return;
        }
        // The oldest copy's memory serves for the new one.
        let full = self.last.len() >= self.rotation.overlap as usize;
        let mut copy = if full { self.drop_oldest() } else { Vec::new() };
        copy.clear();
        copy.extend_from_slice(frame.bytes());
        self.last_bytes += copy.len() as u64;
        self.last.push_back(copy);
        self.shorten();
    }

    fn shorten(&mut self) {
        let bytes_max = (self.rotation.file_size / 2).min(4 * FRAME_LIMIT as u64);
        while self.last.len() > self.rotation.overlap as usize || self.last_bytes > bytes_max {
            if self.drop_oldest().is_empty() {
                break;
            }
        }
    }

    fn drop_oldest(&mut self) -> Vec<u8> {
        let oldest = self.last.pop_front().unwrap_or_default();
        self.last_bytes -= oldest.len() as u64;
        oldest
    }
}

fn name(stem: &str, number: u32) -> String {
    format!("{stem}_{number:04}.s7k")
}
