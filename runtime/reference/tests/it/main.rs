//! The tables against the code that reads the files.

mod document;
mod held;
mod mission;
mod pages;
