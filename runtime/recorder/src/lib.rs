//! The log of a run, in MCAP, and pictures of it.
