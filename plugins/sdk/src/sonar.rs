//! Tools for plugins that look at sonar data.

pub mod coverage;
