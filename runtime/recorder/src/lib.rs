//! The log of a run, in MCAP.
//!
//! Each run has one MCAP file (<https://mcap.dev/spec>), uncompressed, which [`Recorder`] writes and [`read`] reads. It
//! holds every input of core in the order in which core handled them, so that core can be replayed from the file alone.
//! It also holds decoded data for people and plotting tools.
//!
//! `log_time` (and `publish_time`, which is the same) is the UTC at the run's start plus the run's own time,
//! nanoseconds since 1970. `sequence` counts the messages of all channels from 0 in the order in which they were
//! written (it wraps at 2^32), which orders messages of the same instant. [`Recorder::start`] comes first. After each
//! input come the outputs that core produced for it.
//!
//! | channel | encoding | what | how much |
//! |---|---|---|---|
//! | `/link/from_vehicle` | raw | bytes of one read of the link, an input of core | all |
//! | `/link/to_vehicle` | raw | bytes of one write to the link, an output of core | all |
//! | `/core/input` | JSON | every other input: how core started, steps returned by plugins, the operator, bytes of external sources, the link's state | all |
//! | `/core/output` | JSON | every other output: connect, reset, invoke, restart, bytes for external sources, reserve, finish | all |
//! | `/notes` | JSON | what is worth knowing, with a line of text in `text` | all |
//! | `/requests` | JSON | the same for requests, plugins' and others': each state that each one came to | all |
//! | `/control` | JSON | the same for control gained and lost | all |
//! | `/navigation` | JSON | navigation as the monitor sees it | by [`Rate`] |
//! | `/truth` | JSON | what only the simulation knows | by [`Rate`] |
//! | `/vehicle` | JSON | lines of the simulated vehicle's own log | all |
//!
//! Raw channels have the message encoding `application/octet-stream` and no schema: a message may hold any part of any
//! number of sentences. JSON channels have a JSON schema, which documents them ([`Channel::schema`]). Numbers in
//! `/core/input` are preserved bit for bit. Values that JSON cannot express are written as `"nan"`, `"inf"` and
//! `"-inf"`, because a plugin's request may contain any value.
//!
//! In a deployed log, `invoke` outputs hold the whole input of the step. In a simulation's log they hold the plugin
//! only: core can compute the rest again from its inputs, and it would be half of the file.
//!
//! **Metadata**, one record named `backseat`: `format` (1), `version`, `mission`, `seed` (absent at sea), `rate`
//! (`simulation` or `deployed`), `utc_at_start_ns`, `mission_sha256` and `fence_sha256` (of the attachments). One
//! record named `components`: the SHA-256 of each plugin's component by its attachment's name.
//!
//! **Attachments**: `mission.toml` (as resolved), `fence.geojson`, `components/NAME.wasm` (those over
//! [`COMPONENT_LIMIT`] only by their hash).
//!
//! **Gaps.** A deployed runtime does not wait for the disk. Records that the disk does not accept in time are left out.
//! A `gap` on `/core/input` has the time since when records are missing, and their number. What follows a gap cannot be
//! replayed from the start.
//!
//! **After a killed process.** Each MCAP chunk is assembled in memory, written whole, and handed to the operating
//! system: every 3 s of the run's time when deployed, every 60 s or 256 KiB in simulation. A file without its end can
//! be read up to its last whole chunk by [`read`], by `mcap recover`, and by the Python package's streaming reader
//! (`NonSeekingReader`), which raises an exception there. The recorder does not sync the file to the disk, so a power
//! cut can lose what the operating system had not written, usually the last 30 s.

mod bytes;
mod channel;
mod error;
mod header;
mod log;
mod message;
mod raw;
mod recorder;
mod request;

pub use channel::Channel;
pub use error::RecorderError;
pub use header::{COMPONENT_LIMIT, Header, Rate};
pub use log::{Attachment, Entry, Log, Record, Run, parse, read};
pub use message::LoggedInput;
pub use recorder::Recorder;
