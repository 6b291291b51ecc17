//! The picture of a run.

mod picture;
