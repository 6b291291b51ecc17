//! Standard error, behind a bounded queue with a thread of its own (safety requirement 022): a terminal that is slow, stuck
//! or gone holds nobody up. What finds no room is dropped and counted, and the count is told when there is room again.

use std::io::{self, Write};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, OnceLock};
use std::thread;
use std::time::Duration;

/// How many lines wait at most. A line is at most a few KiB long.
const LINES_MAX: usize = 1024;
/// How long the end of the program waits until all lines are out.
const FAREWELL: Duration = Duration::from_millis(200);

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
    /// Tells whoever waits that all before it is out.
    Mark(SyncSender<()>),
}

/// Writes into the queue, as `tracing`'s subscriber wants it: a write is a line.
#[derive(Debug)]
pub(crate) struct Lines;

impl Write for Lines {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        put(line.to_vec());
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// As `eprintln!`, but never waits and never fails.
pub(crate) fn tell(text: &str) {
    put(format!("{text}\n").into_bytes());
}

/// Takes standard error over, and what panics say with it. Before anything is said.
pub(crate) fn start() {
    let _terminal = terminal();
    std::panic::set_hook(Box::new(|panic| {
        let thread = thread::current();
        tell(&format!(
            "thread '{}' {panic}",
            thread.name().unwrap_or("without a name")
        ));
    }));
}

/// Waits until all is out, for [`FAREWELL`] at most.
pub(crate) fn finish() {
    let (out, is_out) = sync_channel(1);
    if terminal().lines.try_send(Entry::Mark(out)).is_ok() {
        // Whoever does not read by now will not.
        let _late = is_out.recv_timeout(FAREWELL);
    }
}

fn terminal() -> &'static Terminal {
    TERMINAL.get_or_init(|| Terminal::new(io::stderr()))
}

fn put(line: Vec<u8>) {
    terminal().put(line);
}

impl Terminal {
    fn new(out: impl Write + Send + 'static) -> Self {
        let (lines, entries) = sync_channel(LINES_MAX);
        let dropped = Arc::new(AtomicU64::new(0));
        let counted = Arc::clone(&dropped);
        let thread = thread::Builder::new().name("stderr".to_owned());
        // Without a thread nothing is said, and every line is counted as dropped.
        let _started = thread.spawn(move || write_out(out, &entries, &counted));
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
            let told = format!("{lost} lines were dropped: standard error took them too slowly\n");
            // Where nobody reads there is nobody to be told, here and below.
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

    /// Takes a line each time that it is let.
    struct Stuck {
        lets: Receiver<()>,
        taken: Sender<String>,
    }

    impl Write for Stuck {
        fn write(&mut self, line: &[u8]) -> io::Result<usize> {
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
        let (lets, wait) = channel();
        let (taken, told) = channel();
        let terminal = Terminal::new(Stuck { lets: wait, taken });
        for line in 0..LINES_MAX + 100 {
            terminal.put(format!("{line}\n").into_bytes());
        }
        let lost = terminal.dropped.load(Ordering::Relaxed);
        assert!((99..=100).contains(&lost), "{lost}");
        for _ in 0..=LINES_MAX {
            lets.send(()).unwrap();
        }
        let told: Vec<String> = told.iter().take(LINES_MAX + 1).collect();
        let count = format!("{lost} lines were dropped: standard error took them too slowly\n");
        assert_eq!(
            told.iter().filter(|line| **line == count).count(),
            1,
            "{:?}",
            &told[..3]
        );
        // Its reader goes away: what is said then is said to nobody, and harms nobody.
        drop(lets);
        terminal.put(b"nobody\n".to_vec());
    }

    /// Panics at whatever it is given.
    struct Panics;

    impl Write for Panics {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            panic!("as it is meant to")
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
