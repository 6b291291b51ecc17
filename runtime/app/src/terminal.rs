//! Standard error, behind a bounded queue with a thread of its own (safety requirement 022), so that a slow, stuck or
//! closed terminal delays nothing. Lines that find no room are dropped and counted, and the count is printed when there
//! is room again.

use std::fs::File;
use std::io::{self, Write};
use std::os::fd::AsFd as _;
use std::os::unix::fs::MetadataExt as _;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, OnceLock};
use std::thread;
use std::time::Duration;

use tracing::{Level, Metadata};
use tracing_subscriber::fmt::MakeWriter;

use crate::aside;

/// How many lines may wait. A line is at most a few KiB long.
const LINES_MAX: usize = 1024;
/// How long the end of the program waits until all lines are written.
const FAREWELL: Duration = Duration::from_millis(200);

#[cfg(feature = "simulation")]
static SHARED: OnceLock<indicatif::ProgressBar> = OnceLock::new();
static TERMINAL: OnceLock<Terminal> = OnceLock::new();

/// The queue.
#[derive(Debug)]
struct Terminal {
    lines: SyncSender<Entry>,
    dropped: Arc<AtomicU64>,
}

#[derive(Debug)]
enum Entry {
    Line(Vec<u8>),
    /// Reports that everything before it has been written.
    Mark(SyncSender<()>),
}

/// The queue, for `tracing`'s subscriber.
#[derive(Debug)]
pub(crate) struct ByLevel;

/// Writes lines of one level into the queue: each write is one line.
#[derive(Debug)]
pub(crate) struct Lines(Level);

impl<'a> MakeWriter<'a> for ByLevel {
    type Writer = Lines;

    fn make_writer(&'a self) -> Lines {
        Lines(Level::INFO)
    }

    fn make_writer_for(&'a self, metadata: &Metadata<'_>) -> Lines {
        Lines(*metadata.level())
    }
}

impl Write for Lines {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        put(with_priority(self.0, line));
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Like `eprintln!`, but it never waits and never fails.
pub(crate) fn tell(text: &str) {
    put(format!("{text}\n").into_bytes());
}

/// Like [`tell`], of what ends the program.
pub(crate) fn tell_error(text: &str) {
    put(with_priority(Level::ERROR, format!("{text}\n").as_bytes()));
}

/// Whether standard error is the stream that systemd has connected to its journal (`JOURNAL_STREAM` of systemd.exec(5)).
pub(crate) fn is_journal() -> bool {
    static JOURNAL: OnceLock<bool> = OnceLock::new();
    *JOURNAL.get_or_init(|| {
        let named = std::env::var("JOURNAL_STREAM").unwrap_or_default();
        let stream = io::stderr().as_fd().try_clone_to_owned();
        let about = stream.and_then(|stream| File::from(stream).metadata());
        about.is_ok_and(|about| named == format!("{}:{}", about.dev(), about.ino()))
    })
}

/// The line with its priority before it, as the journal reads it (sd-daemon(3)); elsewhere as it is.
fn with_priority(level: Level, line: &[u8]) -> Vec<u8> {
    let priority: &[u8] = match level {
        _ if !is_journal() => b"",
        Level::ERROR => b"<3>",
        Level::WARN => b"<4>",
        Level::INFO => b"<6>",
        Level::DEBUG | Level::TRACE => b"<7>",
    };
    [priority, line].concat()
}

/// Takes over standard error and the messages of panics. Call this before anything is printed.
pub(crate) fn start() {
    let _terminal = terminal();
    std::panic::set_hook(Box::new(|panic| {
        let thread = thread::current();
        tell_error(&format!(
            "thread '{}' {panic}",
            thread.name().unwrap_or("without a name")
        ));
    }));
}

/// Waits until all lines are written, at most [`FAREWELL`].
pub(crate) fn finish() {
    let (out, is_out) = sync_channel(1);
    if terminal().lines.try_send(Entry::Mark(out)).is_ok() {
        // A terminal that has not accepted the lines by now is given up.
        let _late = is_out.recv_timeout(FAREWELL);
    }
}

/// Lines stand above this status line from now on.
#[cfg(feature = "simulation")]
pub(crate) fn share(bar: &indicatif::ProgressBar) {
    // There is one status line at most.
    let _first = SHARED.set(bar.clone());
}

fn terminal() -> &'static Terminal {
    TERMINAL.get_or_init(|| Terminal::new(Screen))
}

/// Standard error, perhaps with a status line at its foot.
struct Screen;

impl Write for Screen {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        #[cfg(feature = "simulation")]
        if let Some(bar) = SHARED.get().filter(|bar| !bar.is_finished()) {
            return bar.suspend(|| io::stderr().write(line));
        }
        io::stderr().write(line)
    }

    fn flush(&mut self) -> io::Result<()> {
        io::stderr().flush()
    }
}

fn put(line: Vec<u8>) {
    terminal().put(line);
}

impl Terminal {
    fn new(out: impl Write + Send + 'static) -> Self {
        let (lines, entries) = sync_channel(LINES_MAX);
        let dropped = Arc::new(AtomicU64::new(0));
        let counted = Arc::clone(&dropped);
        // If the thread cannot start, nothing is printed and every line counts as dropped.
        let _started = aside::spawn("stderr", move || write_out(out, &entries, &counted));
        Self { lines, dropped }
    }

    fn put(&self, line: Vec<u8>) {
        match self.lines.try_send(Entry::Line(line)) {
            Ok(()) => {}
            Err(TrySendError::Full(_) | TrySendError::Disconnected(_)) => {
                self.dropped.fetch_add(1, Ordering::Relaxed);
            }
        }
    }
}

fn write_out(mut out: impl Write, entries: &Receiver<Entry>, dropped: &AtomicU64) {
    while let Ok(entry) = entries.recv() {
        let lost = dropped.swap(0, Ordering::Relaxed);
        if lost > 0 {
            let told = format!("{lost} lines were dropped: standard error was too slow\n");
            // If the reader has closed standard error, no one is left to tell, here and below.
            let _gone = out.write_all(told.as_bytes());
        }
        match entry {
            Entry::Line(line) => {
                let _gone = out.write_all(&line);
            }
            Entry::Mark(out) => {
                let _gone = out.try_send(());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Sender, channel};

    use super::*;

    /// Accepts one line each time that the test lets it.
    struct Stuck {
        asks: Sender<()>,
        lets: Receiver<()>,
        taken: Sender<String>,
    }

    impl Write for Stuck {
        fn write(&mut self, line: &[u8]) -> io::Result<usize> {
            let _gone = self.asks.send(());
            if self.lets.recv().is_err() {
                return Err(io::ErrorKind::BrokenPipe.into());
            }
            let _gone = self.taken.send(String::from_utf8_lossy(line).into_owned());
            Ok(line.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn sr_022_a_terminal_that_is_stuck_costs_lines_and_says_how_many() {
        let (asks, stuck) = channel();
        let (lets, wait) = channel();
        let (taken, told) = channel();
        let terminal = Terminal::new(Stuck {
            asks,
            lets: wait,
            taken,
        });
        terminal.put(b"first\n".to_vec());
        stuck.recv().unwrap();
        for line in 0..LINES_MAX + 100 {
            terminal.put(format!("{line}\n").into_bytes());
        }
        assert_eq!(terminal.dropped.load(Ordering::Relaxed), 100);
        // The first line, the count and those that found room.
        for _ in 0..LINES_MAX + 2 {
            lets.send(()).unwrap();
        }
        let told: Vec<String> = told.iter().take(LINES_MAX + 2).collect();
        let count = "100 lines were dropped: standard error was too slow\n";
        assert_eq!(told.iter().filter(|line| *line == count).count(), 1, "{:?}", &told[..3]);
        // Its reader closes: later lines are lost and do no harm.
        drop(lets);
        terminal.put(b"nobody\n".to_vec());
    }

    /// Panics on every write.
    struct Panics;

    impl Write for Panics {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            panic!("the test panics in a write")
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn sr_022_a_terminal_whose_thread_panics_is_waited_for_by_nobody() {
        let terminal = Terminal::new(Panics);
        let is_gone = || {
            let line = Entry::Line(b"on\n".to_vec());
            matches!(terminal.lines.try_send(line), Err(TrySendError::Disconnected(_)))
        };
        while !is_gone() {
            thread::yield_now();
        }
        let before = terminal.dropped.load(Ordering::Relaxed);
        for line in 0..2 * LINES_MAX {
            terminal.put(format!("{line}\n").into_bytes());
        }
        let lost = terminal.dropped.load(Ordering::Relaxed) - before;
        assert_eq!(lost, 2 * LINES_MAX as u64, "every line is counted");
    }
}
