//! The exploration itself, as far as it takes seconds.

mod bounded;
mod fingerprints;
#[cfg(feature = "mutations")]
mod mutations;
mod planted;
