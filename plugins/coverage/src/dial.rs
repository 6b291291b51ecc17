use backseat_sdk::{EndKind, State};
use serde::{Deserialize, Serialize};

const SECOND_NS: u64 = 1_000_000_000;
/// The time between two requests for the same setting.
const AGAIN_NS: u64 = 10 * SECOND_NS;

/// A setting of the sonar that the plugin changes by requests: the value that is wanted, and the one that was accepted.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Dial {
    wanted: Option<f64>,
    accepted: Option<f64>,
    open: Option<(u64, f64)>,
    not_before_ns: u64,
    failures: u32,
    /// Nobody knows which value the sonar has.
    is_unsure: bool,
}

impl Dial {
    /// Wants a value from now on.
    pub(crate) fn want(&mut self, value: f64) {
        if self.wanted != Some(value) {
            self.wanted = Some(value);
            self.failures = 0;
        }
    }

    /// Gives the wanted value up.
    pub(crate) fn give_up(&mut self) {
        self.wanted = None;
    }

    /// The value that is wanted, or was.
    pub(crate) const fn wanted(&self) -> Option<f64> {
        self.wanted
    }

    /// The value that was accepted last.
    pub(crate) const fn accepted(&self) -> Option<f64> {
        self.accepted
    }

    /// Whether nobody knows which value the sonar has, because a request has failed.
    pub(crate) const fn is_unsure(&self) -> bool {
        self.is_unsure
    }

    /// How often the wanted value was refused or has failed.
    pub(crate) const fn failures(&self) -> u32 {
        self.failures
    }

    /// Whether the sonar has the wanted value, or none is wanted.
    pub(crate) fn is_settled(&self) -> bool {
        self.wanted.is_none() || self.wanted == self.accepted
    }

    /// The value to request now under the tag. The next request comes ten seconds later at the earliest.
    pub(crate) fn ask(&mut self, tag: u64, now_ns: u64) -> Option<f64> {
        if self.is_settled() || self.open.is_some() || now_ns < self.not_before_ns {
            return None;
        }
        let value = self.wanted?;
        self.open = Some((tag, value));
        self.not_before_ns = now_ns + AGAIN_NS;
        Some(value)
    }

    /// Takes in the outcome of a request. Returns the value if it was refused or has failed.
    pub(crate) fn hear(&mut self, tag: u64, state: &State) -> Option<f64> {
        let (_, value) = self.open.filter(|(open, _)| *open == tag)?;
        let is_done = match state {
            State::Sent | State::Pending | State::Started | State::Accepted => return None,
            State::Ended(ended) => ended.kind == EndKind::Done,
            State::Rejected(_) | State::Failed(_) | State::TimedOut | State::Unknown | State::Cancelled => false,
        };
        self.open = None;
        if is_done {
            self.accepted = Some(value);
            self.is_unsure = false;
            return None;
        }
        if !matches!(state, State::Rejected(_)) {
            // The sonar may have the value or not.
            self.accepted = None;
            self.is_unsure = true;
        }
        self.failures += 1;
        Some(value)
    }

    /// The sonar may have another value by now: the wanted one is requested again.
    pub(crate) const fn forget(&mut self) {
        self.accepted = None;
    }

    /// Compares with what is open at a restart.
    pub(crate) fn restored(&mut self, open: &[u64]) {
        if self.open.is_some_and(|(tag, _)| !open.contains(&tag)) {
            self.open = None;
            self.accepted = None;
            self.is_unsure = true;
        }
    }

    /// Whether the tag is that of its open request.
    pub(crate) fn owns(&self, tag: u64) -> bool {
        self.open.is_some_and(|(open, _)| open == tag)
    }
}

#[cfg(test)]
mod tests {
    use backseat_sdk::{Ended, Refusal, Rule};

    use super::*;

    #[test]
    fn a_value_is_requested_until_it_is_accepted_and_not_faster_than_every_ten_seconds() {
        let mut dial = Dial::default();
        assert_eq!(dial.ask(1, 0), None);
        dial.want(75.0);
        assert_eq!((dial.ask(1, 0), dial.ask(2, 60 * SECOND_NS)), (Some(75.0), None));
        let refused = State::Rejected(Refusal::new(Rule::State, "not ready"));
        assert_eq!((dial.hear(9, &refused), dial.hear(1, &refused)), (None, Some(75.0)));
        assert_eq!((dial.failures(), dial.is_settled()), (1, false));
        assert_eq!(dial.ask(3, 5 * SECOND_NS), None);
        assert_eq!(dial.ask(3, 10 * SECOND_NS), Some(75.0));
        assert_eq!(dial.hear(3, &State::Accepted), None);
        dial.hear(3, &State::Ended(Ended::new(EndKind::Done, "set")));
        assert_eq!((dial.accepted(), dial.is_settled()), (Some(75.0), true));
        dial.want(75.0);
        assert_eq!(dial.ask(4, 100 * SECOND_NS), None);
        dial.forget();
        assert_eq!(dial.ask(4, 100 * SECOND_NS), Some(75.0));
    }

    #[test]
    fn after_a_restart_an_unknown_outcome_is_requested_again() {
        let mut dial = Dial::default();
        dial.want(0.0);
        dial.ask(1, 0);
        dial.restored(&[1]);
        assert!(dial.owns(1));
        dial.restored(&[]);
        assert_eq!(dial.ask(2, 10 * SECOND_NS), Some(0.0));
    }
}
