//! Compiled components that outlive the process that compiled them, in a folder of the user's own.
//!
//! Compiling is slow (0.7 s for a plugin in Rust, 20 s for one in Python), and its result is the same each time. A
//! [`Host`](crate::Host) with a cache writes what it has compiled into a file, and a later process loads that file, as
//! long as component, engine and settings are the same ([`key`]).
//!
//! # What is trusted
//! A compiled component is native code, and the engine checks little of it. Whoever writes such a file can do what this
//! program can do. So a file is loaded only if nobody but this user (or root) can have written it:
//! - the folder is no link, belongs to the effective user, and gives others no access ([`folder`]);
//! - the file is a regular file and no link, belongs to the effective user, and has mode 0600. These are read from the
//!   open file;
//! - its header names this component and this engine, and the BLAKE3 of the rest is the one that the header records
//!   ([`entry`]). The hash is no signature: it shows damage, not intent;
//! - what is hashed is copied in the same pass into a file in memory, which is then sealed ([`held`]), and the engine maps
//!   that one. So nobody can exchange or change it between check and use.
//!
//! A file that fails a check is not loaded. The component is compiled anew, the file is replaced, and one line says what
//! was wrong with it. Nothing that is wrong with the cache ends a run.
//!
//! # Time and room
//! A disk that does not answer costs [`PATIENCE`], once (safety requirement 022). The folder holds at most [`ROOM_BYTES`]
//! by default: what was used least recently is removed first, and only files with names that this program gives are ever
//! removed ([`room`]).

mod artefact;
mod entry;
mod fault;
mod folder;
mod held;
mod key;
mod place;
mod room;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::time::Duration;

use wasmtime::component::Component;

use self::artefact::Artefact;
use self::fault::Fault;
use self::folder::Folder;
pub(crate) use self::key::Key;
pub use self::room::ROOM_BYTES;

/// How long a read or a write of the cache is waited for. A disk that takes longer is slower than a compiler.
pub const PATIENCE: Duration = Duration::from_secs(5);

/// A folder of compiled components. A clone is another handle to the same one.
#[derive(Clone)]
pub struct Cache {
    inner: Arc<Inner>,
}

struct Inner {
    folder: PathBuf,
    room: u64,
    tell: Box<dyn Fn(Notice) + Send + Sync>,
    /// Nothing more is looked for, or written.
    unread: AtomicBool,
    unwritten: AtomicBool,
}

/// What a cache has to say, in one line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Notice {
    /// The cache cannot be used here, which costs time and nothing else. Once for reading and once for writing.
    Unusable(String),
    /// Something in the cache is not as this program leaves it, and was not used.
    Odd(String),
}

impl std::fmt::Display for Notice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (Self::Unusable(text) | Self::Odd(text)) = self;
        f.write_str(text)
    }
}

impl Cache {
    /// The cache in this folder, which is created when something is first written. `tell` is called for each [`Notice`],
    /// from the thread that loads a component.
    #[must_use]
    pub fn new(folder: impl Into<PathBuf>, tell: impl Fn(Notice) + Send + Sync + 'static) -> Self {
        Self::with_room(folder, ROOM_BYTES, tell)
    }

    /// The same, with room for so many bytes.
    #[must_use]
    pub fn with_room(folder: impl Into<PathBuf>, room: u64, tell: impl Fn(Notice) + Send + Sync + 'static) -> Self {
        let folder: PathBuf = folder.into();
        Self {
            inner: Arc::new(Inner {
                // A slash at its end would let the last part be a link.
                folder: folder.components().collect(),
                room,
                tell: Box::new(tell),
                unread: AtomicBool::new(false),
                unwritten: AtomicBool::new(false),
            }),
        }
    }

    /// The user's cache, as the environment names it: `BACKSEAT_CACHE`, `XDG_CACHE_HOME/backseat` or
    /// `HOME/.cache/backseat`. `None` if `BACKSEAT_CACHE` is `off`, and if there is no such folder, which `tell` reports.
    /// `BACKSEAT_CACHE_MAX_MIB` is its room.
    #[must_use]
    pub fn of_user(tell: impl Fn(Notice) + Send + Sync + 'static) -> Option<Self> {
        let environment = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
        let room = match place::room(environment) {
            Ok(room) => room,
            Err(text) => {
                tell(Notice::Odd(text));
                ROOM_BYTES
            }
        };
        match place::place(environment) {
            place::Place::Folder(folder) => Some(Self::with_room(folder, room, tell)),
            place::Place::Off => None,
            place::Place::Nowhere => {
                tell(Notice::Unusable(
                    "no cache of compiled plugins: none of BACKSEAT_CACHE, XDG_CACHE_HOME and HOME is set; each start \
                     compiles them"
                        .to_owned(),
                ));
                None
            }
        }
    }

    /// Its folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.inner.folder
    }

    /// Whether it has been read and written so far without finding that it cannot be.
    #[must_use]
    pub fn is_in_use(&self) -> bool {
        let Inner { unread, unwritten, .. } = &*self.inner;
        !unread.load(Ordering::Relaxed) && !unwritten.load(Ordering::Relaxed)
    }

    /// The compiled component with this key, if there is one that this user wrote.
    pub(crate) fn find(&self, plugin: &str, key: &Key) -> Option<Component> {
        let inner = &*self.inner;
        if inner.unread.load(Ordering::Relaxed) {
            return None;
        }
        let (folder, wanted) = (inner.folder.clone(), key.clone());
        let read = patiently(PATIENCE, move || match Folder::open(&folder)? {
            Some(folder) => Artefact::read(&folder, &wanted),
            None => Ok(None),
        });
        let found = match read {
            Ok(found) => found,
            Err(late) => Err(Fault::late(&inner.folder, late)),
        };
        match found.and_then(|artefact| artefact.map(Artefact::load).transpose()) {
            Ok(component) => component,
            Err(fault) if fault.is_of_a_file() => {
                (inner.tell)(Notice::Odd(format!(
                    "cache: {fault}: not loaded; plugin `{plugin}` is compiled anew"
                )));
                None
            }
            Err(fault) => {
                inner.unread.store(true, Ordering::Relaxed);
                inner.unwritten.store(true, Ordering::Relaxed);
                (inner.tell)(fault.notice("no cache of compiled plugins", "each start compiles them"));
                None
            }
        }
    }

    /// Keeps a component for later processes.
    pub(crate) fn keep(&self, key: &Key, component: &Component) {
        let inner = &*self.inner;
        if inner.unwritten.load(Ordering::Relaxed) {
            return;
        }
        let kept = component
            .serialize()
            .map_err(|error| Fault::of_engine(&inner.folder, &error))
            .and_then(|artefact| {
                let (folder, room, key) = (inner.folder.clone(), inner.room, key.clone());
                let written = patiently(PATIENCE, move || Folder::create(&folder)?.write(&key, &artefact, room));
                written.unwrap_or_else(|late| Err(Fault::late(&inner.folder, late)))
            });
        if let Err(fault) = kept {
            inner.unwritten.store(true, Ordering::Relaxed);
            (inner.tell)(fault.notice("compiled plugins are not kept", "the next start compiles them again"));
        }
    }
}

/// Why something was not waited for any longer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Late {
    /// It took longer than it may.
    Slow,
    /// Its thread could not start, or panicked.
    Gone,
}

/// Does something on a thread of its own, which nobody waits for after this time: a call to a disk that does not answer
/// cannot be ended.
fn patiently<T: Send + 'static>(time: Duration, work: impl FnOnce() -> T + Send + 'static) -> Result<T, Late> {
    let (done, result) = mpsc::sync_channel(1);
    std::thread::Builder::new()
        .name("cache".to_owned())
        .spawn(move || {
            // The receiver is gone if it took too long.
            let _ = done.send(work());
        })
        .map_err(|_| Late::Gone)?;
    result.recv_timeout(time).map_err(|error| match error {
        mpsc::RecvTimeoutError::Timeout => Late::Slow,
        mpsc::RecvTimeoutError::Disconnected => Late::Gone,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sr_022_a_disk_that_does_not_answer_is_not_waited_for() {
        let (recovers, recovered) = mpsc::channel::<()>();
        let stuck = patiently(Duration::from_millis(20), move || recovered.recv().is_ok());
        assert_eq!(stuck, Err(Late::Slow));
        drop(recovers);
        assert_eq!(patiently(PATIENCE, || 7), Ok(7));
        let panicked: Result<(), Late> = patiently(PATIENCE, || panic!("the test panics"));
        assert_eq!(panicked, Err(Late::Gone));
    }
}
