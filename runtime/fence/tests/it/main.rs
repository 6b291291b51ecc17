//! Reading fences from files and judging sweeps against them, one file for each subject.

mod files;
mod formats;
mod kml;
mod origin;
mod places;
mod refusals;
mod renamed;
mod round;
mod saved;
mod several;
