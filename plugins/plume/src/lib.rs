//! Maps a scalar plume and circles its maximum.
