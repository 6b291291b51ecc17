//! Logging to .s7k files, as effects that a driver carries out.

mod folder;

use std::io;

use backseat_s7k::file::{FileInfo, RotatingWriter, Rotation};
use backseat_s7k::plc::CalendarTime;
use backseat_s7k::{Chars, DeviceId, Frame, Time7k};
use backseat_units::Utc;
use backseat_world::Stream;

use crate::config::{FILE_SIZE_MB, OVERLAP_MAX, PlcConfig, is_plain_text};
use folder::Disk;

/// Bytes in a megabyte, as the texts of the controller count them.
const MEGABYTE: u64 = 1_000_000;

/// A file of the controller, until it is closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct FileId(pub u32);

/// Where a file is, as the controller writes it. A driver decides which folder of its own that is.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct FilePlace {
    /// The folder of log files, as a client may have set it with the command "path": `D:\data`, or anything else.
    /// `None`: the controller's own folder, with `6046.sav` and `6046.cfg`.
    pub folder: Option<String>,
    /// The file's name, without separators.
    pub name: String,
}

impl core::fmt::Display for FilePlace {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Some(folder) = &self.folder else {
            return f.write_str(&self.name);
        };
        // A folder in the manner of Windows, as on the real controller, or of another system.
        let separator = if folder.contains('/') && !folder.contains('\\') {
            '/'
        } else {
            '\\'
        };
        write!(f, "{}{separator}{}", folder.trim_end_matches(['/', '\\']), self.name)
    }
}

/// What a driver does with a file. Effects are carried out in their order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FileEffect {
    /// Makes a file.
    Open {
        /// The file's number in the effects that follow.
        file: FileId,
        /// Its place.
        place: FilePlace,
        /// Whether a file of this name is replaced. If not, its existence is a failure.
        replace: bool,
    },
    /// Appends to a file.
    Append {
        /// The file.
        file: FileId,
        /// What.
        bytes: Vec<u8>,
    },
    /// Writes over a part of a file, within its length.
    Patch {
        /// The file.
        file: FileId,
        /// Where, in bytes from its start.
        at: u64,
        /// What.
        bytes: Vec<u8>,
    },
    /// Cuts a file.
    Truncate {
        /// The file.
        file: FileId,
        /// To this length, bytes.
        length: u64,
    },
    /// Closes a file. Its number is not used again.
    Close {
        /// The file.
        file: FileId,
    },
}

/// Why a driver could not carry out an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileFailure {
    /// The disk is full.
    Full,
    /// The file exists already.
    Exists,
    /// Any other failure.
    Other,
}

impl core::fmt::Display for FileFailure {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Full => "the disk is full",
            Self::Exists => "it exists already",
            Self::Other => "it cannot be written",
        })
    }
}

impl From<&io::Error> for FileFailure {
    fn from(error: &io::Error) -> Self {
        #[expect(clippy::wildcard_enum_match_arm, reason = "the standard library adds kinds")]
        match error.kind() {
            // A file may be no longer than its file system, or a limit of the process, allows.
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded | io::ErrorKind::FileTooLarge => Self::Full,
            io::ErrorKind::AlreadyExists => Self::Exists,
            _ => Self::Other,
        }
    }
}

/// The state of logging.
#[derive(Debug)]
pub(crate) struct Logger {
    disk: Disk,
    writer: Option<RotatingWriter<Disk>>,
    file_size_mb: u32,
    overlap: u32,
    /// The name that the command "switch" gave; `None` for automatic names.
    named: Option<String>,
    recorder_version: Chars<16>,
    session: [u64; 2],
    series: u64,
    /// The record as it stands in the file, to keep its memory.
    scratch: Vec<u8>,
}

impl Logger {
    /// `utc` is the start of the run: runs with one seed have files and a session of their own, as long as they do not
    /// start at the same time.
    pub(crate) fn new(config: &PlcConfig, seed: u64, utc: Utc) -> Self {
        let bytes = |mb: f64| (mb * MEGABYTE as f64) as u64;
        let mut stream = Stream::new(seed ^ scattered(utc.as_unix_nanos()), "plc session");
        Self {
            disk: Disk::new(
                config.logging.folder.clone(),
                bytes(config.disk.capacity_mb),
                bytes(config.disk.used_mb),
            ),
            writer: None,
            file_size_mb: config.logging.file_size_mb,
            overlap: config.logging.overlap_records,
            named: None,
            recorder_version: Chars::new(&config.version).unwrap_or_default(),
            session: [stream.next_u64(), stream.next_u64()],
            series: 0,
            scratch: Vec::new(),
        }
    }

    pub(crate) const fn is_on(&self) -> bool {
        self.writer.is_some()
    }

    pub(crate) fn has_room(&self) -> bool {
        self.disk.has_room()
    }

    pub(crate) fn free_percent(&self) -> f64 {
        self.disk.free_percent()
    }

    pub(crate) fn set_full(&self, full: bool) {
        self.disk.set_full(full);
    }

    /// The disk has so many bytes free.
    pub(crate) fn set_free(&self, bytes: u64) {
        self.disk.set_free(bytes);
    }

    /// A file of an earlier run.
    pub(crate) fn keep(&self, place: FilePlace) {
        self.disk.keep(place);
    }

    pub(crate) fn folder(&self) -> String {
        self.disk.folder()
    }

    /// The size at which the next file begins, megabytes, and the overlap, records.
    pub(crate) const fn setup(&self) -> (u32, u32) {
        (self.file_size_mb, self.overlap)
    }

    /// The file that is open and its length, bytes.
    pub(crate) fn current(&self) -> Option<(FileId, FilePlace, u64)> {
        let (file, place) = self.disk.open()?;
        let (_, length) = self.writer.as_ref()?.current()?;
        Some((file, place, length))
    }

    /// The file that is open, or else the one that the next record begins, and its length, bytes; `None` while logging is
    /// off.
    pub(crate) fn place(&self) -> Option<(FilePlace, u64)> {
        let next = self.disk.place(self.writer.as_ref()?.next_name());
        let current = self.current().map(|(_, place, length)| (place, length));
        Some(current.unwrap_or((next, 0)))
    }

    pub(crate) fn poll(&self) -> Option<FileEffect> {
        self.disk.poll()
    }

    pub(crate) fn store(&self, name: &str, text: &str) {
        self.disk.store(name, text.as_bytes());
    }

    /// Begins logging. There is no file before the first record.
    pub(crate) fn start(&mut self, utc: Utc, devices: &[DeviceId]) {
        if self.writer.is_none() {
            let stem = self.stem(utc);
            let writer = RotatingWriter::new(self.disk.clone(), stem, self.info(devices), self.rotation());
            self.writer = Some(writer);
        }
    }

    /// Ends logging: the open file gets its catalogue.
    pub(crate) fn stop(&mut self, time: Time7k) {
        let Some(writer) = self.writer.take() else { return };
        self.disk.set_ending(true);
        // Without room for its catalogue the file ends without one, which readers accept.
        drop(writer.finish(time));
        self.disk.set_ending(false);
    }

    /// Writes a record; the error says why logging cannot go on.
    pub(crate) fn write(&mut self, frame: &Frame<'_>) -> Result<(), FileFailure> {
        let Some(writer) = &mut self.writer else { return Ok(()) };
        self.scratch.clear();
        frame.write_recorded(&mut self.scratch);
        // It is the same frame but for a flag.
        let recorded = Frame::read(&self.scratch, usize::MAX);
        let written = writer.write(recorded.as_ref().unwrap_or(frame));
        written.map_err(|error| FileFailure::from(&error))
    }

    /// The command "switch": ends the file, and names the next. `None` is "Auto". False if the name was used.
    pub(crate) fn switch(&mut self, name: Option<&str>, utc: Utc, devices: &[DeviceId]) -> bool {
        let name = name.map(|name| match name.strip_suffix(".s7k") {
            Some(_) => name.to_owned(),
            None => format!("{name}.s7k"),
        });
        if name.as_ref().is_some_and(|name| self.disk.is_made(name)) {
            return false;
        }
        self.named = name;
        self.next_series(utc, devices);
        true
    }

    /// The command "path": the next file is in this folder.
    pub(crate) fn set_folder(&mut self, folder: &str, utc: Utc, devices: &[DeviceId]) {
        self.disk.set_folder(folder.to_owned());
        self.next_series(utc, devices);
    }

    /// The command "logging setup". Returns false, and changes nothing, if a value is outside its range.
    pub(crate) fn set_up(&mut self, file_size_mb: u32, overlap: u32) -> bool {
        if !FILE_SIZE_MB.contains(&file_size_mb) || overlap > OVERLAP_MAX {
            return false;
        }
        (self.file_size_mb, self.overlap) = (file_size_mb, overlap);
        let rotation = self.rotation();
        if let Some(writer) = &mut self.writer {
            writer.set_rotation(rotation);
        }
        true
    }

    /// Other sensors: the files that come list them.
    pub(crate) fn set_devices(&mut self, utc: Utc, devices: &[DeviceId]) {
        if self.writer.is_some() {
            self.next_series(utc, devices);
        }
    }

    fn next_series(&mut self, utc: Utc, devices: &[DeviceId]) {
        let Some(mut writer) = self.writer.take() else { return };
        self.disk.set_ending(true);
        drop(writer.switch(Time7k::from_utc(utc)));
        self.disk.set_ending(false);
        let stem = self.stem(utc);
        writer.set_series(stem, self.info(devices));
        writer.set_rotation(self.rotation());
        self.writer = Some(writer);
    }

    /// The beginning of the next files' names: what the client said, or the time.
    fn stem(&mut self, utc: Utc) -> String {
        if let Some(name) = self.named.clone().filter(|name| !self.disk.is_made(name)) {
            let stem = name.trim_end_matches(".s7k").to_owned();
            self.disk.set_exact(Some(name));
            return stem;
        }
        self.disk.set_exact(None);
        let time = CalendarTime::from_utc(utc);
        let (date, seconds) = (
            format!("{:04}{:02}{:02}", time.year, time.month, time.day),
            time.second_10us / 100_000,
        );
        let stem = self.named.as_ref().map_or_else(
            || format!("{date}_{:02}{:02}{seconds:02}", time.hour, time.minute),
            |name| name.trim_end_matches(".s7k").to_owned(),
        );
        // Several series may begin within a second.
        let mut unused = stem.clone();
        let mut number = 1_u32;
        while self.disk.is_made(&format!("{unused}_0000.s7k")) {
            number += 1;
            unused = format!("{stem}-{number}");
        }
        unused
    }

    fn rotation(&self) -> Rotation {
        Rotation {
            // A file with a name of its own grows without end: Table 16 has "size" for automatic names only.
            file_size: if self.named.is_some() {
                u64::MAX
            } else {
                u64::from(self.file_size_mb) * MEGABYTE
            },
            overlap: self.overlap,
        }
    }

    fn info(&mut self, devices: &[DeviceId]) -> FileInfo {
        self.series += 1;
        FileInfo {
            file_id: [self.session[0] ^ self.series, 0],
            session_id: self.session,
            recorder: Chars::new("RESON 6046 mock").unwrap_or_default(),
            recorder_version: self.recorder_version,
            devices: devices.iter().map(|device| (*device, 0)).collect(),
            ..FileInfo::default()
        }
    }
}

/// Numbers that differ in few bits become numbers that differ in many: the last step of the generator SplitMix64.
const fn scattered(number: u64) -> u64 {
    let number = (number ^ (number >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let number = (number ^ (number >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    number ^ (number >> 31)
}

/// Whether a client may name a file so. A comma would begin another parameter (2.5).
pub(crate) fn is_file_name(name: &str) -> bool {
    is_plain_text(name) && !name.contains([',', '/', '\\', ':', '*', '?', '"', '<', '>', '|']) && !name.starts_with('.')
}
