use backseat_units::OutOfRange;

/// Why a world cannot be made: the key, or the place in a file, and what was expected there.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WorldError {
    /// A number is out of the range of its key.
    #[error("{key} is {value}, expected {expected}")]
    Value {
        /// The key with its section: `seabed.depth_m`.
        key: &'static str,
        /// The number (of a span, the end that is out of range).
        value: f64,
        /// The allowed range, in words.
        expected: &'static str,
    },
    /// A key cannot be combined with the others.
    #[error("{key}: expected {expected}")]
    Conflict {
        /// The key with its section: `seabed.grid_frame`.
        key: &'static str,
        /// What can be combined with the others, in words.
        expected: &'static str,
    },
    /// The origin is not on the globe.
    #[error("origin: {0}")]
    Origin(#[from] OutOfRange),
    /// The configuration names a grid, but the caller passed none.
    #[error("seabed.grid is `{path}`, but the caller passed no grid: expected the content of that file")]
    GridNotGiven {
        /// The path from the configuration.
        path: String,
    },
    /// The text of a grid cannot be read.
    #[error("grid, line {line}: {found}, expected {expected}")]
    GridText {
        /// Line of the file, from 1.
        line: usize,
        /// What was found there.
        found: String,
        /// What was expected there.
        expected: String,
    },
    /// A GeoTIFF cannot be read.
    #[error("grid, GeoTIFF: {what} is {found}, expected {expected}")]
    GridTiff {
        /// The tag, or the place in the file.
        what: &'static str,
        /// What was found there.
        found: String,
        /// What was expected there.
        expected: &'static str,
    },
    /// A cell of the grid has no value, and the configuration gives no depth for such cells.
    #[error("grid, row {row}, column {column}: no data, expected a value there or seabed.grid_nodata_depth_m")]
    GridNoData {
        /// Row, from 1, counted from the north.
        row: usize,
        /// Column, from 1, counted from the west.
        column: usize,
    },
}

/// Checks one number of a configuration.
pub(crate) fn check(ok: bool, key: &'static str, value: f64, expected: &'static str) -> Result<(), WorldError> {
    if ok {
        Ok(())
    } else {
        Err(WorldError::Value { key, value, expected })
    }
}

/// Checks whether a key of a configuration can be combined with the others.
pub(crate) fn agree(ok: bool, key: &'static str, expected: &'static str) -> Result<(), WorldError> {
    if ok {
        Ok(())
    } else {
        Err(WorldError::Conflict { key, expected })
    }
}
