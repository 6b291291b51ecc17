//! The one place of the project that runs native code which this process has not compiled.

#![expect(
    unsafe_code,
    reason = "nobody can check native code: the other half of this module checks where it comes from"
)]

use std::path::PathBuf;

use wasmtime::component::Component;

use crate::cache::entry;
use crate::cache::fault::Fault;
use crate::cache::folder::Folder;
use crate::cache::key::Key;

/// A file of the cache, in memory, that passed every check. [`Artefact::read`] is the only way to get one.
pub(super) struct Artefact {
    path: PathBuf,
    key: Key,
    file: Vec<u8>,
}

impl Artefact {
    /// Reads the file for this key, if there is one, and checks owner, mode, kind, header and hash.
    pub(super) fn read(folder: &Folder, key: &Key) -> Result<Option<Self>, Fault> {
        let name = key.file_name();
        let Some(file) = folder.read(&name)? else {
            return Ok(None);
        };
        let path = folder.path().join(name);
        match entry::artefact(&file, key) {
            Ok(_) => Ok(Some(Self {
                path,
                key: key.clone(),
                file,
            })),
            Err(flaw) => Err(Fault::new(&path, flaw)),
        }
    }

    /// Makes it executable, on the engine of its key.
    pub(super) fn load(self) -> Result<Component, Fault> {
        // SAFETY: `deserialize` demands the unchanged result of `Component::serialize`, of any version of wasmtime.
        // These bytes are that:
        // - `Folder::write` is the only code that writes a file with this header, and it writes what
        //   `Component::serialize` returned in `Cache::keep`. `Artefact::read` found the header, for this component and
        //   the settings of this very engine, and a SHA-256 that the artefact still has. So damage is excluded, and so
        //   is the artefact of another plugin, which the engine would accept.
        // - Nobody else can have forged such a file: `Folder::read` read it from a regular file that belongs to the
        //   effective user and that only this user may write (mode 0600), in a folder of this user that nobody else may
        //   enter. It took owner, mode and kind from the descriptor from which it then read. Whoever can write as this
        //   user, or as root, can replace this program too.
        // - The bytes are in memory of our own since before the hash was taken, so nothing changes them after the check.
        // What the engine itself checks: that it is a component's artefact, the first number of the engine's version,
        // the processor and its extensions, the settings. It takes the code on trust, and the tables that describe it.
        let loaded = unsafe { Component::deserialize(&self.key.engine, &self.file[entry::HEADER..]) };
        loaded.map_err(|error| Fault::of_engine(&self.path, &error))
    }
}
