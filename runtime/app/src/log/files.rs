//! Commands that take several logs.

use std::path::{Path, PathBuf};

use anyhow::Result;

use crate::one_line;
use crate::terminal::tell;

/// Does the same with each log. A log that cannot be read does not prevent the next. Returns whether all were good; the
/// error is that of the last log that had one.
pub(super) fn each(files: &[PathBuf], mut act: impl FnMut(&Path) -> Result<bool>) -> Result<bool> {
    let (mut good, mut failed) = (true, None);
    for file in files {
        match act(file) {
            Ok(passed) => good &= passed,
            Err(error) => {
                if let Some(earlier) = failed.replace(error) {
                    tell(&format!("error: {}", one_line(&earlier)));
                }
            }
        }
    }
    failed.map_or(Ok(good), Err)
}
