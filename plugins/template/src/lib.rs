//! The start of a new plugin.
