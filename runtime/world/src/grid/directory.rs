//! Checks a TIFF's first directory before a decoder reads it: a tag of a few bytes can make a decoder allocate
//! gigabytes.
//!
//! Source: Adobe, TIFF Revision 6.0 (1992), section 2; for BigTIFF, the layout that libtiff 4 documents.

use std::collections::BTreeSet;

use super::{CELLS_MAX, geotiff::fault};
use crate::error::WorldError;

/// The greatest number of tags that is accepted; real files have about twenty.
const TAGS_MAX: u64 = 1024;
/// The greatest width and height of a tile.
const TILE_MAX: u64 = 65_536;

/// Rejects a first directory if its values do not lie inside the file, if its image has more than one band or more than
/// 25 million cells, or if its tiles are huge. For a file that passes, a decoder's memory stays within a small multiple
/// of the sizes of file and image.
pub(super) fn inspect(bytes: &[u8]) -> Result<(), WorldError> {
    let mut file = File {
        bytes,
        little_endian: bytes.starts_with(b"II"),
        big: false,
    };
    match file.unsigned(2, 2)? {
        42 => {}
        43 => file.big = true,
        version => return Err(fault("its version", version.to_string(), "42, or 43 for BigTIFF")),
    }
    let (offset_at, offset_size) = if file.big { (8, 8) } else { (4, 4) };
    let directory = file.unsigned(offset_at, offset_size)?;
    let (count_size, entry_size) = if file.big { (8, 20) } else { (2, 12) };
    let count = file.unsigned(directory, count_size)?;
    if count > TAGS_MAX {
        return Err(fault("the number of tags", count.to_string(), "at most 1024"));
    }
    let mut seen = BTreeSet::new();
    let (mut width, mut height) = (0, 0);
    for index in 0..count {
        let entry = directory + count_size + index * entry_size;
        let tag = file.unsigned(entry, 2)?;
        if !seen.insert(tag) {
            return Err(fault(
                "the directory",
                format!("ambiguous: it has tag {tag} twice"),
                "each tag once",
            ));
        }
        let first = file.value(entry)?;
        // A value that is not an unsigned number counts as the greatest one and is rejected below, because a decoder
        // may read it as a number.
        let number = first.unwrap_or(u64::MAX);
        match tag {
            256 => width = number,
            257 => height = number,
            277 if number != 1 => {
                return Err(fault("SamplesPerPixel", number.to_string(), "1: one band of depths"));
            }
            322 | 323 if number > TILE_MAX => {
                return Err(fault("the size of a tile", number.to_string(), "at most 65536"));
            }
            _ => {}
        }
    }
    let cells = width.saturating_mul(height);
    if width < 2 || height < 2 || cells > CELLS_MAX as u64 {
        let expected = "2 by 2 or more, and at most 25 million cells";
        return Err(fault("the image", format!("{width} by {height}"), expected));
    }
    Ok(())
}

struct File<'bytes> {
    bytes: &'bytes [u8],
    little_endian: bool,
    big: bool,
}

impl File<'_> {
    /// An unsigned number of up to eight bytes.
    fn unsigned(&self, at: u64, size: u64) -> Result<u64, WorldError> {
        let field = self.field(at, size)?;
        let push = |number: u64, byte: &u8| number << 8 | u64::from(*byte);
        Ok(if self.little_endian {
            field.iter().rev().fold(0, push)
        } else {
            field.iter().fold(0, push)
        })
    }

    fn field(&self, at: u64, size: u64) -> Result<&[u8], WorldError> {
        let range = || Some(usize::try_from(at).ok()?..usize::try_from(at.checked_add(size)?).ok()?);
        range().and_then(|range| self.bytes.get(range)).ok_or_else(|| {
            let found = format!("{} bytes long", self.bytes.len());
            fault("the file", found, "everything that its tags point to: it is truncated")
        })
    }

    /// Checks that the values of a directory entry lie inside the file. Returns the first value if it is an unsigned
    /// number.
    fn value(&self, entry: u64) -> Result<Option<u64>, WorldError> {
        let (count_size, room) = if self.big { (8, 8) } else { (4, 4) };
        let kind = self.unsigned(entry + 2, 2)?;
        let count = self.unsigned(entry + 4, count_size)?;
        let each = match kind {
            1 | 2 | 6 | 7 => 1,
            3 | 8 => 2,
            4 | 9 | 11 | 13 => 4,
            5 | 10 | 12 | 16 | 17 | 18 => 8,
            _ => return Ok(None),
        };
        let all = count.saturating_mul(each);
        let slot = entry + 4 + count_size;
        let at = if all <= room { slot } else { self.unsigned(slot, room)? };
        self.field(at, all)?;
        if count > 0 && matches!(kind, 1 | 3 | 4 | 16) {
            self.unsigned(at, each).map(Some)
        } else {
            Ok(None)
        }
    }
}
