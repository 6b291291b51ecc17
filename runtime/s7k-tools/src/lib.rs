//! Tools for people who work with recordings in the RESON 7k format (.s7k): what is in one, its records as JSON, its
//! faults, a part of it, and its contents in the formats of other programs.
//!
//! Each tool reads its [`Source`] in one or several passes and holds one record at a time. What grows with the recording
//! is bounded: positions are thinned out, lists are cut, a mosaic has a limit.

mod catalogue;
mod cut;
mod dump;
mod error;
mod export;
mod info;
mod listed;
mod moment;
mod navigated;
mod output;
mod parts;
mod selection;
mod sidescan;
mod source;
mod track;
mod unmatched;
mod verify;

pub use catalogue::Catalogue;
pub use cut::{Cut, cut};
pub use dump::{Dumped, dump};
pub use error::{Error, InputFault};
pub use export::{
    Blend, Crs, CsvOf, Exported, Mosaic, Nadir, Signal, Waterfall, export_csv, export_mosaic, export_segy,
    export_waterfall, export_xtf,
};
pub use info::{
    BluefinChecksums, Checksums, CountGap, Damage, DamagedPlace, FileHeader, Group, HeaderLayouts, Info, Place,
    TimeGap, info, write_info,
};
pub use listed::{LIST_MAX, Listed};
pub use moment::{Moment, MomentError};
pub use selection::Selection;
pub use sidescan::{AltitudeFrom, GainBy};
pub use source::Source;
pub use verify::{Verdict, verify};
