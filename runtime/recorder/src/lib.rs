//! The log of a run, in MCAP.
//!
//! One MCAP file a run (<https://mcap.dev/spec>), uncompressed, written by [`Recorder`] and read back by [`read`]. It
//! holds every input of core in the order in which core handled it, so that core can be replayed from the file alone,
//! and beside that what people and plotting tools want decoded.
//!
//! `log_time` (and `publish_time`, the same) is the run's UTC at its start plus the run's own time, nanoseconds since
//! 1970. `sequence` counts all messages of all channels from 0 in the order in which they were written (it wraps at
//! 2^32): it puts messages of the same instant in order. [`Recorder::start`] comes first; after each input come the
//! outputs that core gave for it.
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
//! Raw channels have the message encoding `application/octet-stream` and no schema: a chunk holds any part of any
//! number of sentences. JSON channels carry a JSON schema, which is their reference ([`Channel::schema`]). Figures in
//! `/core/input` survive bit for bit; what JSON has no number for is written `"nan"`, `"inf"` and `"-inf"`, for a
//! plugin may ask for anything.
//!
//! `invoke` outputs carry the whole step input in a deployed log. In a simulation's they carry the plugin alone:
//! core makes the rest again from the inputs, and it would be half of the file.
//!
//! **Metadata**, one record named `backseat`: `format` (1), `version`, `mission`, `seed` (absent at sea), `rate`
//! (`simulation` or `deployed`), `utc_at_start_ns`, `mission_sha256` and `fence_sha256` (of the attachments). One
//! record named `components`: the SHA-256 of each plugin's component by its attachment's name.
//!
//! **Attachments**: `mission.toml` (as resolved), `fence.geojson`, `components/NAME.wasm` (those over
//! [`COMPONENT_LIMIT`] only by their hash).
//!
//! **Gaps.** A deployed runtime waits for no disk. What the disk does not take in time is left out, and a `gap` on
//! `/core/input` says since when and how many records: whatever follows one can no longer be replayed from the start.
//!
//! **What a killed process leaves.** Each MCAP chunk is put together in memory and written whole, then handed to the
//! operating system: every 3 s of the run's time when deployed, every 60 s or 256 KiB in simulation. A file that
//! lacks its end is read up to its last whole chunk by [`read`], by `mcap recover`, and by the Python package's
//! streaming reader (`NonSeekingReader`), which raises at the end of what there is. Nothing is forced to the disk: a power cut
//! can cost what the operating system had not written, as a rule the last 30 s.

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
