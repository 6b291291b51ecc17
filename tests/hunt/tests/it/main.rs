//! The hunt in a short form: see the files.

mod alarms;
mod hunt;
mod plans;
mod sum;
