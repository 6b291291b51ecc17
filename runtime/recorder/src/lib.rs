//! The log of a run, in MCAP.
//!
//! Each run has one MCAP file (<https://mcap.dev/spec>), uncompressed, which [`Recorder`] writes and [`read`] reads. It
//! holds every input of core in the order in which core handled them, so that core can be replayed from the file alone.
//! It also holds decoded data for people, viewers and plotting tools.
//!
//! `log_time` (and `publish_time`, which is the same) is the UTC at the run's start plus the run's own time,
//! nanoseconds since 1970. It never falls from one message to the next, whatever their channels. `sequence` counts the
//! messages of all channels from 0 in the order in which they were written (it wraps at 2^32), which orders messages of
//! the same instant. [`Recorder::start`] comes first. After each input come the outputs that core produced for it.
//!
//! | channel | schema | what | how much |
//! |---|---|---|---|
//! | `/link/from_vehicle` | `backseat.Bytes` | bytes of one read of the link, an input of core | all |
//! | `/link/to_vehicle` | `backseat.Bytes` | bytes of one write to the link, an output of core | all |
//! | `/core/input` | `backseat.Input` | every other input: how core started, steps returned by plugins, the operator, bytes of external sources, the link's state | all |
//! | `/core/output` | `backseat.Output` | every other output: connect, reset, invoke, restart, bytes for external sources, reserve, finish | all |
//! | `/notes` | `backseat.Note` | what is worth knowing, with a line of text in `text` | all |
//! | `/requests` | `backseat.Request` | the same for requests, plugins' and others': each state that each one came to | all |
//! | `/control` | `backseat.Control` | the same for control gained and lost | all |
//! | `/navigation` | `backseat.Navigation` | navigation as the monitor sees it | by [`Rate`] |
//! | `/truth` | `backseat.Truth` | what only the simulation knows | by [`Rate`] |
//! | `/vehicle` | `backseat.Vehicle` | lines of the simulated vehicle's own log | all |
//!
//! **Messages** are JSON, and each channel has a JSON schema ([`Channel::schema`]) that Foxglove and Lichtblick read:
//! each property has one type, at every depth, and a list has elements of one type. So
//!
//! - an absent value is left out;
//! - bytes are the string `text` if they are UTF-8, and otherwise the string `base64`. A message of the link may hold any
//!   part of any number of sentences, exactly as it was read or written;
//! - a variant of an enum takes two properties: `"act": "order"` has the variant's name, and `act_order` its content, if
//!   it has any. A tuple is an object with the properties `1`, `2` and so on. An element of a list that is a variant is an
//!   object with `is` and `is_…`, and one that is a list is an object with `items`;
//! - a number that JSON cannot express takes another property: `"heading_deg_is": "nan"`, `"inf"` or `"-inf"`. A plugin's
//!   request may contain any value.
//!
//! Numbers in `/core/input` are preserved bit for bit.
//!
//! **Derived channels** hold nothing new: they are for viewers, and [`read`] skips them. A channel exists only if it has a
//! message.
//!
//! | channel | schema | what | how much |
//! |---|---|---|---|
//! | `/position` | `foxglove.LocationFix` | navigation; `altitude` is the depth with its sign changed | once a second |
//! | `/log` | `foxglove.Log` | what plugins logged, notes, new states of requests (of modifies only what went wrong or ended them), lines of `/vehicle`; `name` is `plugin NAME`, `runtime` or `vehicle` | all |
//! | `/map/fence` | `foxglove.GeoJSON` | the fence | once |
//! | `/map/plan` | `foxglove.GeoJSON` | the vehicle's plan (BFPLN), each time that core has heard all of it and it differs from the last; of at most 10,000 points | all |
//! | `/map/reach` | `foxglove.GeoJSON` | where the live modify can lead until the vehicle has noticed our silence and turned away, as the safety monitor judges it; empty when nothing steers any more | each second, deployed only |
//! | `/map/inserts` | `foxglove.GeoJSON` | inserts as they were sent, with identifier, kind, state, plugin and tag: the last 64, of which those that are over go first | each second in which one has changed |
//! | `/map/requests` | `foxglove.GeoJSON` | inserts as plugins asked for them, with state and, if refused, the reason: the last 32. The same request, refused again, replaces the one before | each second in which one has changed |
//! | `/sensors/NAME` | `backseat.NAME` | sentences of the vehicle that are measurements or states, decoded: BFTEL, BFSVS, BFRCM, BFRDP, BFRVL, BFRBS, BFERC, BFDVL, BFDV2, BFIMU, BFCTD, BFRNV, BFPIT, BFCNV, BFTRM, BFBOY | by [`Rate`], each compass and battery by itself |
//!
//! | `/shadow` | `backseat.Shadow` | what the plugins of `run --shadow` asked for, step by step, and the safety monitor's judgement: nothing of it is sent | all |
//!
//! The properties of a sensor have the names and units of `backseat spi list NAME`. Several values of one name are
//! numbered from 1 (`ranges_m_1`), because the vehicle may leave one empty. A sentence that cannot be read makes no
//! message.
//!
//! In a deployed log, `invoke` outputs hold the whole input of the step. In a simulation's log they hold the plugin
//! only: core can compute the rest again from its inputs, and it would be half of the file.
//!
//! What a simulation does to the process that it runs is on `/notes`, with the property `simulation` ([`Remark`]): core
//! did not write it, and does not write it in a replay.
//!
//! **Metadata**, one record named `backseat`: `format` (2; a log of another format is refused), `version`, `mission`, `seed` (absent at sea), `rate`
//! (`simulation` or `deployed`), `utc_at_start_ns`, `origin_latitude_deg` and `origin_longitude_deg`, `mission_sha256`
//! and `fence_sha256` (of the attachments). One record named `components`: the SHA-256 of each plugin's component by its
//! attachment's name. One record named `descriptions`: what each plugin says about itself, JSON, by the plugin's name.
//!
//! **Metres** on every channel count east and north of that origin, which is the origin of the fence's frame. A
//! simulation's truth is converted to it. Only the attached `world.toml` has an origin of its own.
//!
//! **Attachments**: `mission.toml` (as resolved), `fence.geojson`, `world.toml` (only in simulation),
//! `components/NAME.wasm` (those over [`COMPONENT_LIMIT`] only by their hash), `components/SHA256.wasm` (a version that
//! took a plugin's place in mid-run, just before that; it has the same limit), `plan.toml` (the plan that the mission
//! names), `as-read/NAME` (the fence's file, if `fence.geojson` was written from it: positions are rounded then).
//!
//! **Gaps.** A deployed runtime does not wait for the disk. Records that the disk does not accept in time are left out.
//! A `gap` on `/core/input` has the time since when records are missing, and their number. What follows a gap cannot be
//! replayed from the start.
//!
//! **Parts.** A deployed runtime can begin a new file after some time or size: each file is a whole log, whose metadata has
//! its number as `part` (the first one has none). Sequence numbers and times go on. Later parts have the components by
//! their hashes alone. [`join`] makes one log of all parts, which a replay needs.
//!
//! **After a killed process.** Each MCAP chunk is assembled in memory, written whole, and handed to the operating
//! system: every second of the run's time when deployed, every 60 s or 256 KiB in simulation. A file without its end can
//! be read up to its last whole chunk by [`read`], by `mcap recover`, and by the Python package's streaming reader
//! (`NonSeekingReader`), which raises an exception there. The recorder does not sync the file to the disk, so a power
//! cut can lose what the operating system had not written, usually the last 30 s.

mod bytes;
mod channel;
mod chunks;
mod decimation;
mod encode;
mod error;
mod header;
mod join;
mod log;
mod measures;
mod message;
mod plain;
mod raw;
mod reader;
mod recorder;
mod remark;
mod schema;
mod shadow;
mod topics;
mod view;

pub use channel::Channel;
pub use chunks::Message;
pub use encode::{Encoded, Encoder, encode_input};
pub use error::RecorderError;
pub use header::{COMPONENT_LIMIT, Header, Rate, Sources};
pub use join::{JoinError, Joined, join};
pub use log::{Attachment, Entry, Log, Record, Run, parse, read};
pub use message::{LoggedInput, described as describe_state};
pub use reader::LogReader;
pub use recorder::{Listener, Recorder};
pub use remark::Remark;
pub use shadow::{Judged, ShadowStep};
pub use topics::schema_of;
