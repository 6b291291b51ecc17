//! The hunt, reduced: see the files.

mod hunt;
mod plans;
mod sum;
