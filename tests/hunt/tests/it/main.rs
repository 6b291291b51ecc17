//! The hunt, reduced: see the files.

mod alarms;
mod hunt;
mod plans;
mod sum;
