//! The world from outside: what is drawn, files of grids, and invalid files.

#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

mod geotiff;
mod golden;
mod hostile;
