//! Files of records (.s7k): a file header first, records one behind the other, a catalogue last.
//!
//! Header and catalogue may be missing, as in a file whose writer was killed.

mod index;
mod reader;
mod rotation;
mod writer;

pub use index::{Index, IndexEntry, IndexError};
pub use reader::{FileItem, FileReader, Frames, Skipped};
pub use rotation::{Folder, RotatingWriter, Rotation};
pub use writer::{FileInfo, FileWriter, LogFile};

#[cfg(test)]
mod tests;
