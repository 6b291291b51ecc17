use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Instant;

use serde::Serialize;
use tokio::sync::watch;

use crate::about::{About, Kind};
use crate::feed::{Feed, Heard};
use crate::history::{History, Limits, Numbered};
use crate::item::Item;
use crate::metrics::Metrics;
use crate::pace::Pace;
use crate::teller::Teller;

/// What the browsers are shown: what happened, numbered and within bounds.
#[derive(Clone, Debug)]
pub struct Hub(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    about: About,
    /// The time of the newest item, seconds of the run, and when it came.
    newest: Mutex<Option<(f64, Instant)>>,
    history: Mutex<History>,
    metrics: Metrics,
    /// Whether nothing follows any more.
    over: AtomicBool,
    /// The number of the next item, for those who wait.
    news: watch::Sender<u64>,
}

#[expect(clippy::disallowed_methods, reason = "how old the newest item is, for people")]
fn now() -> Instant {
    Instant::now()
}

fn since(then: Instant) -> f64 {
    now().duration_since(then).as_secs_f64()
}

/// A number that differs from run to run.
fn some_number() -> String {
    let mut bytes = [0u8; 8];
    // Without random numbers a browser takes two runs for one until it is loaded again.
    getrandom::fill(&mut bytes).ok();
    format!("{:016x}", u64::from_le_bytes(bytes))
}

/// An item as it is written.
#[derive(Serialize)]
struct Written<'a> {
    n: u64,
    t: f64,
    #[serde(flatten)]
    item: &'a Item,
}

impl Hub {
    /// Shows nothing yet.
    #[must_use]
    pub fn new(about: &About, limits: Limits) -> Self {
        Self(Arc::new(Shared {
            about: About {
                run: some_number(),
                ..about.clone()
            },
            newest: Mutex::new(None),
            history: Mutex::new(History::new(limits)),
            metrics: Metrics::new(about),
            over: AtomicBool::new(false),
            news: watch::Sender::new(1),
        }))
    }

    /// Starts a thread that shows what it is told.
    ///
    /// # Errors
    ///
    /// If the thread cannot start.
    pub fn listen(&self, teller: Teller) -> std::io::Result<Feed> {
        let (feed, heard) = Feed::new();
        let hub = self.clone();
        thread::Builder::new()
            .name("console-teller".to_owned())
            .spawn(move || hub.follow(teller, &heard))?;
        Ok(feed)
    }

    fn follow(&self, mut teller: Teller, heard: &Heard) {
        let mut told_lost = 0;
        while let Ok(told) = heard.queue.recv() {
            let lost = heard.lost.load(Ordering::Relaxed);
            if lost > told_lost {
                let item = Item::Line {
                    level: "warn",
                    who: "console".to_owned(),
                    text: format!("{} messages found no room, and are not shown here", lost - told_lost),
                };
                told_lost = lost;
                self.add(told.now.as_secs_f64(), &item, true);
            }
            teller.hear(told.now, &told.topic, &told.data, |t, item, keep| {
                self.add(t, &item, keep)
            });
        }
        let text = "the run is over".to_owned();
        self.0.over.store(true, Ordering::Relaxed);
        self.add(teller.newest_s(), &Item::End { text }, true);
    }

    /// Adds what happened at `t` seconds. What is not kept reaches only browsers that listen now.
    pub fn add(&self, t: f64, item: &Item, keep: bool) {
        self.0.metrics.observe(item);
        let next = {
            let mut history = self.lock();
            let written = Written {
                n: history.next(),
                t: (t * 1000.0).round() / 1000.0,
                item,
            };
            // Each item can be written.
            let Ok(json) = serde_json::to_string(&written) else {
                return;
            };
            history.add(json.into(), keep);
            history.next()
        };
        *self.0.newest.lock().unwrap_or_else(PoisonError::into_inner) = Some((t, now()));
        self.0.news.send_replace(next);
    }

    /// Adds a line of somebody outside the run, now.
    pub(crate) fn say(&self, level: &'static str, who: &str, text: &str) {
        self.happened(&Item::Line {
            level,
            who: who.to_owned(),
            text: text.to_owned(),
        });
    }

    /// Adds what happened outside the run, now.
    pub(crate) fn happened(&self, item: &Item) {
        let newest = *self.0.newest.lock().unwrap_or_else(PoisonError::into_inner);
        self.add(newest.map_or(0.0, |(t, _)| t), item, true);
    }

    /// What is shown, as JSON, with the run's time if it goes on, and the pace of a simulation.
    pub(crate) fn about(&self, pace: Option<&Pace>) -> String {
        #[derive(Serialize)]
        struct Times {
            times: f64,
        }
        #[derive(Serialize)]
        struct Now<'a> {
            #[serde(flatten)]
            about: &'a About,
            #[serde(skip_serializing_if = "Option::is_none")]
            now: Option<f64>,
            #[serde(skip_serializing_if = "Option::is_none")]
            pace: Option<Times>,
        }
        let about = &self.0.about;
        let newest = *self.0.newest.lock().unwrap_or_else(PoisonError::into_inner);
        // A simulation's time may go faster, or stand.
        let now = newest
            .filter(|_| about.kind == Kind::Live)
            .map(|(t, came)| t + since(came));
        let pace = pace.map(|pace| Times { times: pace.told() });
        serde_json::to_string(&Now { about, now, pace }).unwrap_or_default()
    }

    pub(crate) fn metrics(&self) -> String {
        let newest = *self.0.newest.lock().unwrap_or_else(PoisonError::into_inner);
        let t = newest.map_or(0.0, |(t, came)| {
            let goes_on = self.0.about.kind == Kind::Live || self.is_over();
            t + if goes_on { since(came) } else { 0.0 }
        });
        self.0.metrics.text(t)
    }

    /// Whether nothing follows any more.
    pub(crate) fn is_over(&self) -> bool {
        self.0.over.load(Ordering::Relaxed)
    }

    pub(crate) fn history(&self) -> Vec<Numbered> {
        self.lock().all()
    }

    /// The items after a number; `None` if some of them are gone.
    pub(crate) fn after(&self, n: u64) -> Option<Vec<Numbered>> {
        self.lock().after(n)
    }

    pub(crate) fn news(&self) -> watch::Receiver<u64> {
        self.0.news.subscribe()
    }

    fn lock(&self) -> MutexGuard<'_, History> {
        // It is whole after each call.
        self.0.history.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
