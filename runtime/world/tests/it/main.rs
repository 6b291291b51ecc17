//! The world from outside: what is drawn, files of grids, and invalid files.

#![expect(clippy::unwrap_used, reason = "a test may stop where it fails")]

mod geotiff;
mod golden;
mod hostile;
