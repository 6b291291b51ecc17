//! Invalid files: no bytes make a reader panic, or take more memory than their length justifies.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use backseat_world::Grid;
use proptest::prelude::*;

use crate::geotiff::{float_grid, georeference, tiled};

/// Counts the memory that this thread has allocated, and the most that it had.
struct Counting;

thread_local! {
    static HELD: Cell<isize> = const { Cell::new(0) };
    static MOST: Cell<isize> = const { Cell::new(0) };
}

fn count(bytes: isize) {
    let held = HELD.get() + bytes;
    HELD.set(held);
    MOST.set(MOST.get().max(held));
}

#[expect(
    unsafe_code,
    reason = "an allocator needs unsafe code; this one only counts and passes the calls on"
)]
// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as isize);
        // SAFETY: the caller keeps the contract of `GlobalAlloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count(-(layout.size() as isize));
        // SAFETY: the caller keeps the contract of `GlobalAlloc`.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Reads a grid and returns the most memory that was allocated meanwhile, in bytes.
fn reading_holds(bytes: &[u8]) -> usize {
    let before = HELD.get();
    MOST.set(before);
    drop(Grid::from_bytes(bytes));
    usize::try_from(MOST.get() - before).unwrap_or(0)
}

/// A value of a text has at least two bytes there and takes four. The decoder of TIFF keeps each number of a tag in 32
/// bytes.
const FACTOR: usize = 64;
/// For a packed image: deflate and LZW reach a thousand to one, and for a moment the unpacked data exists twice.
const FACTOR_PACKED: usize = 2800;
/// Messages, and the decoder's own tables (a deflate window and its trees).
const FIXED: usize = 200_000;

fn assert_bounded(bytes: &[u8], factor: usize) {
    let held = reading_holds(bytes);
    assert!(
        held <= factor * bytes.len() + FIXED,
        "{held} bytes for a file of {}",
        bytes.len()
    );
}

#[test]
fn a_header_alone_takes_no_memory() {
    for text in [
        "ncols 4000000000 nrows 4000000000 xllcorner 0 yllcorner 0 cellsize 1 5",
        "ncols 5000 nrows 5000 xllcorner 0 yllcorner 0 cellsize 1 5",
        "ncols 1e308 nrows 1e308 xllcorner 0 yllcorner 0 cellsize 1",
        "ncols 25000000 nrows 2 xllcorner 0 yllcorner 0 cellsize 1",
    ] {
        assert!(Grid::from_bytes(text.as_bytes()).is_err());
        assert!(reading_holds(text.as_bytes()) < 10_000);
    }
    // The same in the tags of a TIFF: the width, a tile's width, the offsets and sizes of tiles, the samples of a
    // pixel, and the scale.
    let whole = tiled(&georeference());
    let patched = |tag: u16, kind: u16, count: u32, value: u32| {
        let mut bytes = whole.clone();
        let at = (10..)
            .step_by(12)
            .find(|at| bytes[*at..at + 2] == tag.to_be_bytes())
            .unwrap();
        bytes[at + 2..at + 4].copy_from_slice(&kind.to_be_bytes());
        bytes[at + 4..at + 8].copy_from_slice(&count.to_be_bytes());
        bytes[at + 8..at + 12].copy_from_slice(&value.to_be_bytes());
        bytes
    };
    for bytes in [
        patched(256, 4, 1, 4_000_000_000),
        patched(256, 4, 1, 5_000_000),
        patched(322, 4, 1, 4_000_000_000),
        patched(324, 4, 4_000_000_000, 8),
        patched(325, 4, 1, 4_000_000_000),
        patched(277, 4, 1, 65_535),
        patched(33550, 12, 400_000_000, 8),
    ] {
        let error = Grid::from_bytes(&bytes).unwrap_err().to_string();
        assert!(error.starts_with("grid, GeoTIFF: ") && !error.contains('\n'), "{error}");
        assert_bounded(&bytes, FACTOR);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn any_bytes_are_read_or_refused(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        assert_bounded(&bytes, FACTOR_PACKED);
    }

    #[test]
    fn any_text_of_a_grid_is_read_or_refused(
        words in proptest::collection::vec("(ncols|NROWS|xllcorner|yllcenter|cellsize|nodata_value|nan|-?[0-9]{1,10}|1e308|x|\n)", 0..40),
    ) {
        assert_bounded(words.join(" ").as_bytes(), FACTOR);
    }

    #[test]
    fn a_damaged_tiff_is_read_or_refused(
        which in any::<bool>(), cut in 0.0..1.3f64, faults in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
    ) {
        let mut bytes = if which { float_grid() } else { tiled(&georeference()) };
        // Half of the faults hit the first 200 bytes, where the tiled file has its directory: they have the most effect
        // there.
        for (number, (at, byte)) in faults.iter().enumerate() {
            let length = if number % 2 == 0 { bytes.len() } else { bytes.len().min(200) };
            let at = at.index(length);
            bytes[at] = *byte;
        }
        let length = (cut * bytes.len() as f64) as usize;
        bytes.truncate(length);
        assert_bounded(&bytes, FACTOR_PACKED);
    }
}
