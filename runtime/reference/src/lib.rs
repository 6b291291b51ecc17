//! The reference of what a user writes in a file and of what a program prints: one entry for each key of `mission.toml`,
//! of `world.toml`, of a file of faults, of a script, of a zone of a fence, and of the report.
//!
//! The entries are TOML in `keys/`. The pages in `runtime/docs/reference`, the JSON Schemas in `missions/schemas` and
//! the output of `backseat explain` are made from them. Tests compare them with the code that reads the files: a key
//! without an entry, an entry without a key, a wrong default and a wrong range each fail.

mod entry;
mod exit;
mod find;
mod page;
mod reference;
mod schema;

pub use entry::{Choice, Entry, Kind};
pub use exit::{EXITS, Exit, MET, PANICKED, STOPPED, UNMET, UNUSABLE};
pub use find::{Found, find};
pub use page::{describe, exit_page, page};
pub use reference::{REFERENCES, Reference};
pub use schema::schema;
