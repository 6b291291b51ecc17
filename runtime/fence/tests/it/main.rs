//! Fences as files and what is judged against them, a file a subject.

mod files;
mod formats;
mod kml;
mod places;
mod refusals;
mod renamed;
mod round;
mod saved;
mod several;
