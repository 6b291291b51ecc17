//! Shows a map that was drawn.

use std::path::Path;
use std::sync::mpsc::channel;
use std::thread;
use std::time::Duration;

use tracing::warn;

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
