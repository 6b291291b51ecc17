//! The tables against the code that reads the files.

mod campaign;
mod document;
mod faults;
mod fence;
mod held;
mod mission;
mod pages;
mod prose;
mod script;
mod world;
