use backseat_units::OutOfRange;

/// A world that cannot be: which key or which place of a file, and what was expected there.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WorldError {
    /// A number outside what its key allows.
    #[error("{key} is {value}, expected {expected}")]
    Value {
        /// The key with its section: `seabed.depth_m`.
        key: &'static str,
        /// The number that was given (the offending end of a span).
        value: f64,
        /// What is allowed, in words.
        expected: &'static str,
    },
    /// A key that does not go with the others.
    #[error("{key}: expected {expected}")]
    Conflict {
        /// The key with its section: `seabed.grid_frame`.
        key: &'static str,
        /// What would go with the others, in words.
        expected: &'static str,
    },
    /// The origin is not on the globe.
    #[error("origin: {0}")]
    Origin(#[from] OutOfRange),
    /// The configuration names a grid and none came with it.
    #[error("seabed.grid is `{path}`, expected the grid of that file: only its name was given")]
    GridNotGiven {
        /// The path, as the configuration has it.
        path: String,
    },
    /// A grid's text that cannot be read.
    #[error("grid, line {line}: {found}, expected {expected}")]
    GridText {
        /// Line of the file, from 1.
        line: usize,
        /// What stands there.
        found: String,
        /// What should.
        expected: String,
    },
    /// A GeoTIFF that cannot be read.
    #[error("grid, GeoTIFF: {what} is {found}, expected {expected}")]
    GridTiff {
        /// The tag, or the place in the file.
        what: &'static str,
        /// What stands there.
        found: String,
        /// What should.
        expected: &'static str,
    },
    /// A cell of the grid without a value, and no depth given for such cells.
    #[error("grid, row {row}, column {column}: no data, expected a value there or seabed.grid_nodata_depth_m")]
    GridNoData {
        /// Row, from 1, the northernmost first.
        row: usize,
        /// Column, from 1, the westernmost first.
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

/// Checks one key of a configuration against the others.
pub(crate) fn agree(ok: bool, key: &'static str, expected: &'static str) -> Result<(), WorldError> {
    if ok {
        Ok(())
    } else {
        Err(WorldError::Conflict { key, expected })
    }
}
