//! The one place of the project that runs native code which this process has not compiled.

#![expect(
    unsafe_code,
    reason = "nobody can check native code: the other half of this module checks where it comes from"
)]

use std::fs::File;
use std::io::{self, Seek};
use std::path::PathBuf;

use wasmtime::component::Component;

use crate::cache::entry::{self, NotCopied};
use crate::cache::fault::{Fault, Flaw};
use crate::cache::folder::Folder;
use crate::cache::held::{Draft, Held};
use crate::cache::key::Key;

/// What a file of the cache holds, in memory, after every check was passed. [`Artefact::read`] is the only way to get one.
pub(super) struct Artefact {
    path: PathBuf,
    key: Key,
    held: Held,
}

impl Artefact {
    /// Reads the file for this key, if there is one, and checks owner, mode, kind, header and hash.
    pub(super) fn read(folder: &Folder, key: &Key) -> Result<Option<Self>, Fault> {
        let name = key.file_name();
        let Some((file, bytes)) = folder.file(&name)? else {
            return Ok(None);
        };
        let path = folder.path().join(name);
        let sealed = Draft::file().and_then(|draft| copied(&file, bytes, key, draft));
        let copied = match sealed {
            Ok(copied) => copied,
            // No files in memory here, or not as large.
            Err(_) => (&file)
                .rewind()
                .and_then(|()| {
                    let draft = Draft::bytes(usize::try_from(bytes).unwrap_or(0));
                    copied(&file, bytes, key, draft)
                })
                .map_err(|error| Fault::of_read(&path, &error))?,
        };
        let held = copied.map_err(|flaw| Fault::new(&path, flaw))?;
        let key = key.clone();
        Ok(Some(Self { path, key, held }))
    }

    /// Makes it executable, on the engine of its key.
    pub(super) fn load(self) -> Result<Component, Fault> {
        let Self { path, key, held } = self;
        let engine = &key.engine;
        // SAFETY: `deserialize_file` and `deserialize` demand the unchanged result of `Component::serialize`, of any version
        // of wasmtime, and that the file never changes. What is held is that:
        // - `Folder::write` is the only code that writes a file with this header, and it writes what
        //   `Component::serialize` returned in `Cache::keep`. `Artefact::read` found the header, for this component and
        //   the settings of this very engine, and a BLAKE3 that the artefact still has. So damage is excluded, and so
        //   is the artefact of another plugin, which the engine would accept.
        // - Nobody else can have forged such a file: `Folder::read` read it from a regular file that belongs to the
        //   effective user and that only this user may write (mode 0600), in a folder of this user that nobody else may
        //   enter. It took owner, mode and kind from the descriptor from which it then read. Whoever can write as this
        //   user, or as root, can replace this program too.
        // - The bytes that were hashed are the bytes that are held: `entry::copy` hashes and copies each piece. The copy is a
        //   sealed file in memory, which the kernel lets nobody write, or it is memory of our own. So nothing changes it
        //   after the check.
        // What the engine itself checks: that it is a component's artefact, the first number of the engine's version,
        // the processor and its extensions, the settings. It takes the code on trust, and the tables that describe it.
        if let Some(sealed) = held.path()
            && let Ok(component) = unsafe { Component::deserialize_file(engine, sealed) }
        {
            return Ok(component);
        }
        // Without `/proc`, or where files in memory cannot be executed.
        let bytes = held.into_bytes().map_err(|error| Fault::of_read(&path, &error))?;
        // SAFETY: as above.
        unsafe { Component::deserialize(engine, bytes) }.map_err(|error| Fault::of_engine(&path, &error))
    }
}

/// Copies the artefact of a file into a draft. The error is the draft's; the flaw is the file's.
fn copied(file: &File, bytes: u64, key: &Key, mut draft: Draft) -> io::Result<Result<Held, Flaw>> {
    match entry::copy(file, bytes, key, &mut draft) {
        Ok(()) => draft.hold().map(Ok),
        Err(NotCopied::Flaw(flaw)) => Ok(Err(flaw)),
        Err(NotCopied::Written(error)) => Err(error),
    }
}
