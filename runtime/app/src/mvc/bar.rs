use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::clock::{Clock, pause};
use crate::terminal;

/// How often the state is drawn, real time.
const REDRAW_EVERY: Duration = Duration::from_millis(250);
/// How long the screen is the operator's after an empty line.
const PROMPT_FOR: Duration = Duration::from_secs(30);
/// How long the end waits for the last drawing.
const FAREWELL: Duration = Duration::from_millis(200);

/// Two status lines at the foot of a terminal, drawn by a thread of their own: a terminal that nobody reads stalls that
/// thread alone.
#[derive(Debug)]
pub(super) struct Bar {
    shown: Arc<Shown>,
    /// Standard input is a terminal too, on which an operator may type.
    typed: bool,
    ended: Receiver<()>,
}

#[derive(Debug, Default)]
struct Shown {
    lines: Mutex<(String, String)>,
    prompt: AtomicBool,
    over: AtomicBool,
}

impl Bar {
    /// The bar, if standard error is a terminal.
    pub(super) fn start() -> Option<Self> {
        if !std::io::stderr().is_terminal() {
            return None;
        }
        let shown = Arc::new(Shown::default());
        let (end, ended) = channel();
        let thread = thread::Builder::new().name("screen".to_owned());
        let drawn = Arc::clone(&shown);
        let started = thread.spawn(move || {
            draw(&drawn);
            // The program may not wait any more.
            let _late = end.send(());
        });
        let typed = std::io::stdin().is_terminal();
        started.is_ok().then_some(Self { shown, typed, ended })
    }

    pub(super) fn set(&self, doing: String, mut place: String) {
        if self.typed {
            place.push_str(" | Enter: type a command");
        }
        let mut lines = self.shown.lines.lock().unwrap_or_else(PoisonError::into_inner);
        *lines = (doing, place);
    }

    /// Leaves the screen to an operator who types for some time, or takes it back.
    pub(super) fn prompt(&self, prompts: bool) {
        self.shown.prompt.store(prompts && self.typed, Ordering::Relaxed);
    }

    /// Clears the lines, if the terminal takes it.
    pub(super) fn end(&self) {
        self.shown.over.store(true, Ordering::Relaxed);
        let _late = self.ended.recv_timeout(REDRAW_EVERY + FAREWELL);
    }
}

fn draw(shown: &Shown) {
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(8));
    bar.set_style(ProgressStyle::with_template("{wide_msg}\n{prefix}").expect("the template is valid"));
    terminal::share(&bar);
    while !shown.over.load(Ordering::Relaxed) {
        if shown.prompt.load(Ordering::Relaxed) {
            // Lines wait meanwhile, so that nothing is printed into what is being typed.
            bar.suspend(|| prompt(shown));
            shown.prompt.store(false, Ordering::Relaxed);
        }
        let (doing, place) = shown.lines.lock().unwrap_or_else(PoisonError::into_inner).clone();
        bar.set_message(doing);
        bar.set_prefix(place);
        bar.tick();
        pause(REDRAW_EVERY);
    }
    bar.finish_and_clear();
}

fn prompt(shown: &Shown) {
    // A terminal that is gone shows nothing more.
    let _gone = std::io::stderr().write_all(b"command (`help` lists them): ");
    let since = Clock::start();
    let is_open = || shown.prompt.load(Ordering::Relaxed) && !shown.over.load(Ordering::Relaxed);
    while is_open() && since.elapsed() < PROMPT_FOR {
        pause(Duration::from_millis(50));
    }
}
