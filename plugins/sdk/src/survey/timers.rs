use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::{Event, Request, StepInput, Timer};

/// Timers with names instead of numbers: a step starts them, and a later one asks which have expired.
///
/// A restart keeps them if they are a part of the plugin's state: what expired in the lost steps expires at once.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Timers {
    /// When each one expires, on the clock of [`StepInput::now_ns`], and its number.
    due: BTreeMap<String, (u64, u64)>,
    last: u64,
}

impl Timers {
    /// Starts a timer, or starts it anew. Return the request from the step. A time of 0 expires in the next step.
    #[must_use]
    pub fn start(&mut self, name: &str, after: Duration, input: &StepInput) -> Request {
        let after_ns = u64::try_from(after.as_nanos()).unwrap_or(u64::MAX);
        self.last += 1;
        self.due
            .insert(name.to_owned(), (input.now_ns.saturating_add(after_ns), self.last));
        Request::Timer(Timer {
            id: self.last,
            after_ns,
        })
    }

    /// Forgets a timer.
    pub fn stop(&mut self, name: &str) {
        self.due.remove(name);
    }

    /// Whether it was started and has neither expired nor been stopped.
    #[must_use]
    pub fn is_running(&self, name: &str) -> bool {
        self.due.contains_key(name)
    }

    /// The timers that have expired, each once, in the order of their times.
    pub fn expired(&mut self, input: &StepInput) -> Vec<String> {
        let heard: BTreeSet<u64> = input
            .events
            .iter()
            .filter_map(|event| if let Event::Timer(id) = event { Some(*id) } else { None })
            .collect();
        let mut over: Vec<(u64, u64, String)> = Vec::new();
        self.due.retain(|name, (at_ns, id)| {
            let expired = heard.contains(id) || *at_ns <= input.now_ns;
            if expired {
                over.push((*at_ns, *id, name.clone()));
            }
            !expired
        });
        over.sort_unstable();
        over.into_iter().map(|(_, _, name)| name).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(now_s: u64, events: Vec<Event>) -> StepInput {
        StepInput {
            now_ns: now_s * 1_000_000_000,
            events,
            ..StepInput::default()
        }
    }

    #[test]
    fn a_timer_expires_once_by_its_event_or_by_its_time() {
        let mut timers = Timers::default();
        let asked = timers.start("ping", Duration::from_secs(5), &at(10, vec![]));
        assert!(matches!(asked, Request::Timer(timer) if timer.id == 1 && timer.after_ns == 5_000_000_000));
        let _ = timers.start("turn", Duration::from_secs(3), &at(10, vec![]));
        assert!(timers.is_running("ping"));
        assert!(timers.expired(&at(12, vec![])).is_empty());
        assert_eq!(timers.expired(&at(12, vec![Event::Timer(1)])), ["ping"]);
        assert!(!timers.is_running("ping"));
        // The event of the other one was lost in a restart.
        assert_eq!(timers.expired(&at(13, vec![])), ["turn"]);
        assert!(
            timers
                .expired(&at(99, vec![Event::Timer(1), Event::Timer(2)]))
                .is_empty()
        );
    }

    #[test]
    fn the_event_of_a_timer_that_was_started_anew_does_not_count() {
        let mut timers = Timers::default();
        let _ = timers.start("ping", Duration::from_secs(5), &at(10, vec![]));
        let _ = timers.start("ping", Duration::from_secs(5), &at(14, vec![]));
        assert!(timers.expired(&at(15, vec![Event::Timer(1)])).is_empty());
        timers.stop("ping");
        assert!(timers.expired(&at(99, vec![Event::Timer(2)])).is_empty());
    }

    #[test]
    fn timers_expire_in_the_order_of_their_times() {
        let mut timers = Timers::default();
        for (name, seconds) in [("b", 5), ("a", 7), ("c", 5)] {
            let _ = timers.start(name, Duration::from_secs(seconds), &at(0, vec![]));
        }
        assert_eq!(timers.expired(&at(8, vec![])), ["b", "c", "a"]);
    }
}
