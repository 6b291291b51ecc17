//! Writes a map that was drawn, and shows it.

use std::fs;
use std::io::Read;
use std::path::Path;
use std::sync::mpsc::channel;
use std::thread;
use std::time::Duration;

use anyhow::{Context, Result, ensure};
use tracing::warn;

/// How each picture begins.
const SVG: &[u8] = b"<svg";

/// Empties the file of a map, so that a file that cannot be written is told before the run, and not after it.
///
/// # Errors
///
/// Those of [`write`].
pub(crate) fn begin(path: &Path) -> Result<()> {
    write(path, "")
}

/// Writes a map. It may take the place of another picture, and never of anything else: a slip of the hand must not cost the log
/// of a dive.
///
/// # Errors
///
/// In one line, if the file has something else than a picture, or cannot be written.
pub(crate) fn write(path: &Path, picture: &str) -> Result<()> {
    // A device or a pipe has nothing to lose, and reading from it could wait.
    if path.is_file() {
        let mut head = Vec::new();
        let file = fs::File::open(path).with_context(|| format!("{}", path.display()))?;
        file.take(SVG.len() as u64)
            .read_to_end(&mut head)
            .with_context(|| format!("{}", path.display()))?;
        ensure!(
            head.is_empty() || head == SVG,
            "--map {}: the file is no picture, and is left as it is: name another file",
            path.display()
        );
    }
    fs::write(path, picture).with_context(|| format!("{}", path.display()))
}

/// A viewer that has not failed by now shows the picture, and may run on.
const FAILS_WITHIN: Duration = Duration::from_secs(2);

/// Opens a file with the system's viewer. If there is none, a warning says so.
pub(crate) fn open(path: &Path) {
    let (ended, has_ended) = channel();
    let file = path.to_path_buf();
    thread::spawn(move || {
        // Nobody listens to a viewer that is closed later.
        let _late = ended.send(open::that(file));
    });
    if let Ok(Err(error)) = has_ended.recv_timeout(FAILS_WITHIN) {
        warn!("{} cannot be opened: {error}", path.display());
    }
}
