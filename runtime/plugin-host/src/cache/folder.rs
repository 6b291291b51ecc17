//! The folder, and who may have written into it.

use std::fs::{DirBuilder, File, Metadata, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use rustix::fs::{AtFlags, Mode, OFlags, Timespec, Timestamps, UTIME_NOW};
use rustix::io::Errno;

use crate::cache::entry;
use crate::cache::fault::{Fault, Flaw};
use crate::cache::key::Key;
use crate::cache::room::{self, DRAFT, Kept};

/// The largest file that is read, bytes: many times what a component of [`crate::COMPONENT_BYTES`] compiles to.
const FILE_BYTES_MAX: u64 = 1 << 30;
/// What stays free on the disk, bytes: the log of a dive is worth more than the next start's second.
const FREE_BYTES: u64 = 256 << 20;
/// How many names of drafts are tried. One that exists is left over from a process of the same number.
const DRAFTS: u32 = 16;

/// The opened folder, which is ours alone.
pub(super) struct Folder {
    path: PathBuf,
    file: File,
}

impl Folder {
    /// Opens the folder. `None` if there is none.
    pub(super) fn open(path: &Path) -> Result<Option<Self>, Fault> {
        // The numbers of these flags are small.
        let flags = (OFlags::DIRECTORY | OFlags::NOFOLLOW).bits().cast_signed();
        let file = match OpenOptions::new().read(true).custom_flags(flags).open(path) {
            Ok(file) => file,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            Err(error) => {
                let link = path.symlink_metadata().is_ok_and(|found| found.is_symlink());
                return Err(if link {
                    Fault::new(path, Flaw::FolderLink)
                } else {
                    Fault::of_folder(path, &error)
                });
            }
        };
        let found = file.metadata().map_err(|error| Fault::of_folder(path, &error))?;
        let (owner, user) = (found.uid(), user());
        if owner != user {
            return Err(Fault::new(path, Flaw::FolderOwner { owner, user }));
        }
        let mode = found.mode() & 0o7777;
        if mode & 0o077 != 0 {
            return Err(Fault::new(path, Flaw::FolderMode { mode }));
        }
        let path = path.to_owned();
        Ok(Some(Self { path, file }))
    }

    /// Opens the folder, and creates it where it is missing.
    pub(super) fn create(path: &Path) -> Result<Self, Fault> {
        if let Some(folder) = Self::open(path)? {
            return Ok(folder);
        }
        let create = || {
            if let Some(parent) = path.parent() {
                std::fs::create_dir_all(parent)?;
            }
            match DirBuilder::new().mode(0o700).create(path) {
                // Another process was quicker.
                Err(error) if error.kind() == ErrorKind::AlreadyExists => Ok(()),
                created => created,
            }
        };
        create().map_err(|error| Fault::of_folder(path, &error))?;
        Self::open(path)?.ok_or_else(|| Fault::of_folder(path, &ErrorKind::NotFound.into()))
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Opens a file that only this user can have written, and tells its length. `None` if there is none.
    pub(super) fn file(&self, name: &str) -> Result<Option<(File, u64)>, Fault> {
        let path = self.path.join(name);
        let fault = |flaw| Err(Fault::new(&path, flaw));
        // A pipe is opened without waiting for somebody to write.
        let flags = OFlags::RDONLY | OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::CLOEXEC;
        let file = match rustix::fs::openat(&self.file, name, flags, Mode::empty()) {
            Ok(file) => File::from(file),
            Err(Errno::NOENT) => return Ok(None),
            Err(Errno::LOOP) => return fault(Flaw::Link),
            Err(error) => return Err(Fault::of_read(&path, &error.into())),
        };
        let read_error = |error: io::Error| Fault::of_read(&path, &error);
        let found = file.metadata().map_err(read_error)?;
        if let Some(flaw) = not_ours(&found) {
            return fault(flaw);
        }
        if found.len() > FILE_BYTES_MAX {
            return fault(Flaw::Length {
                records: FILE_BYTES_MAX,
                has: found.len(),
            });
        }
        // What was used last is removed last. On a disk that cannot be written nothing is removed.
        let _unmarked = rustix::fs::futimens(&file, &used_now());
        Ok(Some((file, found.len())))
    }

    /// Writes an artefact whole or not at all, and makes room for it before. It is not synced: what a loss of power
    /// leaves of it is noticed when it is read.
    pub(super) fn write(&self, key: &Key, artefact: &[u8], room: u64) -> Result<(), Fault> {
        let header = entry::header(key, artefact);
        let needed = header.len() as u64 + artefact.len() as u64;
        let (draft, mut file) = self.draft()?;
        let mut written = || -> Result<(), Fault> {
            let write_error = |error: io::Error| Fault::of_write(&self.path, &error);
            rustix::fs::fchmod(&file, Mode::RUSR | Mode::WUSR).map_err(|error| write_error(error.into()))?;
            let found = file.metadata().map_err(write_error)?;
            if not_ours(&found).is_some() {
                return Err(Fault::new(&self.path, Flaw::Unkept));
            }
            self.make_room(needed, room, found.mtime())?;
            file.write_all(&header)
                .and_then(|()| file.write_all(artefact))
                .map_err(write_error)?;
            rustix::fs::renameat(&self.file, &draft, &self.file, key.file_name())
                .map_err(|error| write_error(error.into()))
        };
        let written = written();
        if written.is_err() {
            let _gone = self.remove(&draft);
        }
        written
    }

    /// Creates a file that no other process has.
    fn draft(&self) -> Result<(String, File), Fault> {
        let flags = OFlags::WRONLY | OFlags::CREATE | OFlags::EXCL | OFlags::NOFOLLOW | OFlags::CLOEXEC;
        let mut taken = Errno::EXIST;
        for number in 0..DRAFTS {
            let name = format!("{DRAFT}{}-{number}", std::process::id());
            match rustix::fs::openat(&self.file, &name, flags, Mode::RUSR | Mode::WUSR) {
                Ok(file) => return Ok((name, File::from(file))),
                Err(Errno::EXIST) => {}
                Err(error) => {
                    taken = error;
                    break;
                }
            }
        }
        Err(Fault::of_write(&self.path, &taken.into()))
    }

    /// Removes what is in the way of so many bytes. `now_s` is the present time by the clock of the disk, which also
    /// stamped the files.
    fn make_room(&self, needed: u64, room: u64, now_s: i64) -> Result<(), Fault> {
        let kept = self.kept().map_err(|error| Fault::of_write(&self.path, &error))?;
        let Some(removed) = room::removed(kept, needed, room, now_s) else {
            let room_mib = room >> 20;
            return Err(Fault::new(
                &self.path,
                Flaw::Room {
                    room_mib,
                    bytes: needed,
                },
            ));
        };
        for name in removed {
            // Another process may have been quicker.
            let _gone = self.remove(&name);
        }
        let disk = rustix::fs::fstatvfs(&self.file).map_err(|error| Fault::of_write(&self.path, &error.into()))?;
        let free = disk.f_bavail.saturating_mul(disk.f_frsize);
        if free < needed.saturating_add(FREE_BYTES) {
            let (free_mib, needed_mib) = (free >> 20, (needed + FREE_BYTES).div_ceil(1 << 20));
            return Err(Fault::new(&self.path, Flaw::Full { free_mib, needed_mib }));
        }
        Ok(())
    }

    /// The files in it that have names of ours.
    fn kept(&self) -> io::Result<Vec<Kept>> {
        let mut kept = Vec::new();
        for entry in rustix::fs::Dir::read_from(&self.file)? {
            let entry = entry?;
            let Some(kind) = entry.file_name().to_str().ok().and_then(room::kind) else {
                continue;
            };
            let name = entry.file_name().to_string_lossy().into_owned();
            // It may be gone by now.
            let Ok(found) = rustix::fs::statat(&self.file, &name, AtFlags::SYMLINK_NOFOLLOW) else {
                continue;
            };
            kept.push(Kept {
                name,
                kind,
                bytes: u64::try_from(found.st_size).unwrap_or(0),
                used_s: found.st_mtime,
            });
        }
        Ok(kept)
    }

    fn remove(&self, name: &str) -> io::Result<()> {
        Ok(rustix::fs::unlinkat(&self.file, name, AtFlags::empty())?)
    }
}

/// The effective user, with whose rights this program reads and writes.
fn user() -> u32 {
    rustix::process::geteuid().as_raw()
}

/// Why somebody else may have written a file.
fn not_ours(found: &Metadata) -> Option<Flaw> {
    let (owner, user, mode) = (found.uid(), user(), found.mode() & 0o7777);
    if !found.is_file() {
        Some(Flaw::Kind)
    } else if owner != user {
        Some(Flaw::Owner { owner, user })
    } else if mode != 0o600 {
        Some(Flaw::Mode { mode })
    } else {
        None
    }
}

fn used_now() -> Timestamps {
    let now = Timespec {
        tv_sec: 0,
        tv_nsec: UTIME_NOW,
    };
    Timestamps {
        last_access: now,
        last_modification: now,
    }
}
