use std::fs::File;
use std::io::Read;
use std::path::Path;

use backseat_world::Grid;

use crate::error::MissionError;

/// The largest file that is read, bytes: eighty for each cell of the largest grid.
const BYTES_MAX: u64 = 2_000_000_000;

/// Reads a seabed's grid.
///
/// # Errors
/// [`MissionError`] where the file cannot be read, is too large or is no grid: the file, and its line or tag.
pub(crate) fn read_grid(path: &Path) -> Result<Grid, MissionError> {
    let failed = |source| MissionError::Read {
        path: path.to_path_buf(),
        source,
    };
    let value = |message| MissionError::Value {
        path: path.to_path_buf(),
        message,
    };
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(failed)?;
    file.take(BYTES_MAX + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > BYTES_MAX {
        return Err(value(format!(
            "the file is over {BYTES_MAX} bytes, expected at most that"
        )));
    }
    Grid::from_bytes(&bytes).map_err(|error| value(error.to_string()))
}
