//! The speed table.
