use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::Duration;

use tempfile::TempDir;

use crate::clock::eventually;

/// A disk that hangs on command, for a program started by [`crate::Backseat::stalled`]; `tests/stall` explains how. The
/// disk recovers when this is dropped.
#[derive(Debug)]
pub struct Stall {
    flag: PathBuf,
    _folder: TempDir,
}

impl Default for Stall {
    fn default() -> Self {
        Self::new()
    }
}

impl Stall {
    /// A stall that has not begun.
    ///
    /// # Panics
    ///
    /// If there is no room for a temporary folder.
    #[must_use]
    pub fn new() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder can be made");
        Self {
            flag: folder.path().join("stalled"),
            _folder: folder,
        }
    }

    pub(crate) fn flag(&self) -> &Path {
        &self.flag
    }

    /// From now on calls hang.
    ///
    /// # Panics
    ///
    /// If the flag cannot be set.
    pub fn begin(&self) {
        File::create(&self.flag).expect("the folder is ours");
    }

    /// Calls that hang continue, and no further call hangs.
    ///
    /// # Panics
    ///
    /// If the flag cannot be removed.
    pub fn end(&self) {
        fs::remove_file(&self.flag).expect("it has begun");
    }

    /// The calls that hung, in order: the function and the file, such as `write /tmp/logs/a.mcap`.
    #[must_use]
    pub fn held(&self) -> Vec<String> {
        let text = fs::read_to_string(self.flag.with_extension("held")).unwrap_or_default();
        text.lines().map(str::to_owned).collect()
    }

    /// Waits until a call hangs whose function and file contain these texts.
    ///
    /// # Panics
    ///
    /// If none does.
    pub fn holds(&self, function: &str, file: &str, within: Duration) {
        let is = |call: &String| call.starts_with(function) && call.contains(file);
        eventually(
            within,
            || self.held().iter().any(is).then_some(()),
            || format!("no {function} of {file} hangs, only: {:?}", self.held()),
        );
    }
}
