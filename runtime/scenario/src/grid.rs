use std::fs::File;
use std::io::Read;
use std::path::Path;

use backseat_world::Grid;

use crate::error::ScenarioError;

/// The largest file that is read, bytes: eighty for each cell of the largest grid.
const BYTES_MAX: u64 = 2_000_000_000;

/// Reads a seabed's grid.
///
/// # Errors
///
/// [`ScenarioError`] with the file and its line or tag, if the file cannot be read, is too large or is not a valid
/// grid.
pub(crate) fn read_grid(path: &Path) -> Result<Grid, ScenarioError> {
    let failed = |source| ScenarioError::Read {
        path: path.to_path_buf(),
        source,
    };
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(failed)?;
    file.take(BYTES_MAX + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > BYTES_MAX {
        return Err(ScenarioError::GridSize {
            path: path.to_path_buf(),
            bytes_max: BYTES_MAX,
        });
    }
    Grid::from_bytes(&bytes).map_err(|source| ScenarioError::Grid {
        path: path.to_path_buf(),
        source,
    })
}
