//! `export`: the contents of a recording in the formats of other programs.

mod csv;
mod ebcdic;
mod geotiff;
mod mosaic;
mod projection;
mod raster;
mod segy;
mod waterfall;
mod xtf;

pub use csv::{CsvOf, export_csv};
pub use mosaic::{Mosaic, export_mosaic};
pub use projection::Crs;
pub use raster::{Blend, Nadir};
pub use segy::{Signal, export_segy};
pub use waterfall::{Waterfall, export_waterfall};
pub use xtf::export_xtf;

use crate::source::{LeftOut, Source};

/// What an export wrote, and what it had to leave out.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Exported {
    /// What was written.
    pub written: String,
    /// What a reader of the output should know.
    pub notes: Vec<String>,
}

impl Exported {
    fn new(written: String) -> Self {
        Self {
            written,
            notes: Vec::new(),
        }
    }

    /// The damaged places of the recording.
    fn note_left_out(&mut self, source: &Source) {
        let LeftOut { places, bytes } = source.left_out();
        if places > 0 {
            self.notes.push(format!(
                "left out: {bytes} bytes that are not a record, in {places} {} (see `backseat s7k verify`)",
                if places == 1 { "place" } else { "places" }
            ));
        }
    }

    fn note_if(&mut self, count: usize, what: &str) {
        if count > 0 {
            self.notes.push(format!("{what}: {count}"));
        }
    }
}

impl core::fmt::Display for Exported {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(&self.written)?;
        for note in &self.notes {
            write!(f, "; {note}")?;
        }
        Ok(())
    }
}
