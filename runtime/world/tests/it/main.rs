//! The world from outside: what is drawn, files of grids, and files that are none.

mod geotiff;
mod golden;
mod hostile;
