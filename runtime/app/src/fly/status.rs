//! The screen of a flight: two status lines on a terminal, and a line each ten seconds elsewhere.

use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use anyhow::Result;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use tracing::{info, warn};

use super::watch::Flight;
use crate::clock::{Clock, pause};
use crate::terminal;

/// How often the state is shown, real time: on a terminal, and elsewhere.
const REDRAW_EVERY: Duration = Duration::from_millis(200);
const LINE_EVERY: Duration = Duration::from_secs(10);
/// A flight that is slower than this part of the speed that was asked for is worth a line.
const SLOW: f64 = 0.7;

/// A thread that shows a flight until the end.
pub(super) struct Screen {
    over: Arc<AtomicBool>,
    began: Clock,
    thread: Option<thread::JoinHandle<()>>,
}

impl Screen {
    pub(super) fn start(flight: Arc<Flight>, clock: Clock, times: f64) -> Result<Self> {
        let over = Arc::new(AtomicBool::new(false));
        let began = Clock::start();
        let shown = Show {
            flight,
            clock,
            real: began,
            times,
            over: Arc::clone(&over),
        };
        let thread = thread::Builder::new()
            .name("screen".to_owned())
            .spawn(|| shown.show())?;
        Ok(Self {
            over,
            began,
            thread: Some(thread),
        })
    }

    /// The real time since the start.
    pub(super) fn real(&self) -> Duration {
        self.began.elapsed()
    }

    /// Shows nothing more.
    pub(super) fn end(&mut self) {
        self.over.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // A thread that has panicked has said so.
            let _panicked = thread.join();
        }
    }
}

struct Show {
    flight: Arc<Flight>,
    clock: Clock,
    real: Clock,
    times: f64,
    over: Arc<AtomicBool>,
}

impl Show {
    fn show(self) {
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(8));
            bar.set_style(ProgressStyle::with_template("{wide_msg}\n{prefix}").expect("the template is valid"));
            bar
        });
        if let Some(bar) = &bar {
            terminal::share(bar);
        }
        let mut line_at = LINE_EVERY;
        let mut before = (Duration::ZERO, Duration::ZERO);
        let mut slow = false;
        while !self.over.load(Ordering::Relaxed) {
            pause(REDRAW_EVERY);
            let (real, time) = (self.real.elapsed(), self.clock.elapsed());
            let (doing, place) = self.flight.lines();
            if let Some(bar) = &bar {
                bar.set_message(doing.clone());
                bar.set_prefix(place.clone());
                bar.tick();
            }
            if real < line_at {
                continue;
            }
            line_at = real + LINE_EVERY;
            if bar.is_none() {
                info!("{doing} | {place}");
            }
            let reached = (time - before.1).as_secs_f64() / (real - before.0).as_secs_f64().max(1e-9);
            before = (real, time);
            if reached < SLOW * self.times && !std::mem::replace(&mut slow, true) {
                warn!(
                    "this computer flies at {reached:.1} instead of {} x real time: the flight takes longer, and by its own \
                     clock nothing comes later",
                    self.times
                );
            }
        }
        if let Some(bar) = bar {
            bar.finish_and_clear();
        }
    }
}
