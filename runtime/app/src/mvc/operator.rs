//! The lines that the operator types while the vehicle runs.

use std::io::{self, IsTerminal, Read, Stdin};
use std::thread;
use std::time::Duration;

use rustix::io::ioctl_fionread;
use rustix::process::getpgrp;
use rustix::termios::tcgetpgrp;
use tokio::sync::mpsc::{Receiver, Sender, channel};
use tracing::warn;

use crate::clock::pause;

/// How many lines may wait for the vehicle. Then no more are read, and whoever writes them waits.
const LINES_MAX: usize = 16;
/// A longer line is cut.
const LINE_MAX: usize = 4096;
/// How often the thread looks whether a line has been typed on a terminal.
const LOOKS_EVERY: Duration = Duration::from_millis(100);

/// The lines from standard input, read by a thread of their own. They may end at any time, and may never come.
#[derive(Debug)]
pub(crate) struct Lines(Option<Receiver<String>>);

impl Lines {
    /// Reads standard input from now on.
    pub(crate) fn of_stdin() -> Self {
        let (lines, received) = channel(LINES_MAX);
        let thread = thread::Builder::new().name("operator".to_owned());
        match thread.spawn(move || read(io::stdin(), &lines)) {
            Ok(_runs_to_the_end_of_the_program) => Self(Some(received)),
            Err(error) => {
                warn!("standard input is not read: {error}");
                Self(None)
            }
        }
    }

    /// No lines.
    pub(crate) const fn none() -> Self {
        Self(None)
    }

    /// The next line. Never comes after the end of the input.
    pub(crate) async fn next(&mut self) -> String {
        if let Some(lines) = &mut self.0
            && let Some(line) = lines.recv().await
        {
            return line;
        }
        self.0 = None;
        std::future::pending().await
    }
}

/// Reads until the end of the input, or until nobody takes lines any more.
fn read(mut stdin: Stdin, lines: &Sender<String>) {
    let terminal = stdin.is_terminal();
    let mut cutter = Cutter::default();
    let mut buffer = [0; LINE_MAX];
    loop {
        if terminal && !is_ours(&stdin) {
            pause(LOOKS_EVERY);
            continue;
        }
        match stdin.read(&mut buffer) {
            Ok(0) => break,
            Ok(count) => {
                for line in cutter.cut(&buffer[..count]) {
                    if lines.blocking_send(line).is_err() {
                        return;
                    }
                }
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(_) => break,
        }
    }
    if let Some(line) = cutter.rest() {
        // The program may have ended.
        let _gone = lines.blocking_send(line);
    }
}

/// Whether a line has been typed on the terminal, for us. To read as a job in the background would stop the whole
/// program (SIGTTIN), also if it came there while it was reading.
fn is_ours(stdin: &Stdin) -> bool {
    tcgetpgrp(stdin).is_ok_and(|group| group == getpgrp()) && ioctl_fionread(stdin).is_ok_and(|typed| typed > 0)
}

/// Cuts what is read into lines.
#[derive(Debug, Default)]
struct Cutter {
    partial: Vec<u8>,
    /// The line is too long, and its rest is dropped.
    full: bool,
}

impl Cutter {
    fn cut(&mut self, bytes: &[u8]) -> Vec<String> {
        let mut lines = Vec::new();
        for part in bytes.split_inclusive(|byte| *byte == b'\n') {
            let room = LINE_MAX - self.partial.len();
            self.full |= part.len() > room;
            self.partial.extend_from_slice(&part[..part.len().min(room)]);
            if part.ends_with(b"\n") {
                lines.extend(self.take());
            }
        }
        lines
    }

    /// What comes after the last line.
    fn rest(mut self) -> Option<String> {
        if self.partial.is_empty() { None } else { self.take() }
    }

    fn take(&mut self) -> Option<String> {
        self.full = false;
        let line = std::mem::take(&mut self.partial);
        Some(String::from_utf8_lossy(&line).trim_end().to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_whole_however_they_came() {
        let mut cutter = Cutter::default();
        assert_eq!(cutter.cut(b"con"), Vec::<String>::new());
        assert_eq!(cutter.cut(b"trol take\r\n\nsta"), ["control take", ""]);
        assert_eq!(cutter.rest().as_deref(), Some("sta"));
        assert_eq!(Cutter::default().rest(), None);
    }

    #[test]
    fn a_line_without_an_end_is_cut() {
        let mut cutter = Cutter::default();
        for _ in 0..100 {
            assert_eq!(cutter.cut(&[b'x'; 1000]), Vec::<String>::new());
        }
        assert_eq!(cutter.cut(b"y\nnext\n"), ["x".repeat(LINE_MAX), "next".to_owned()]);
    }
}
