use std::collections::VecDeque;
use std::time::Duration;

use crate::moment::Moment;

/// After a refusal no lease may begin for this time. Each further refusal doubles the time.
const PAUSE: Duration = Duration::from_secs(1);
const PAUSE_MAX: Duration = Duration::from_secs(60);
/// After this time without a refusal, the next pause may be the shortest again.
const FORGIVEN: Duration = Duration::from_secs(25);
/// Refusals within this time count once, because they may be one refusal that came twice.
const ONE: Duration = Duration::from_millis(500);

/// The pause in which no lease may begin after the vehicle has refused a modify.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pause {
    /// When the last refusals left the vehicle, and the pause that each demands.
    refused: VecDeque<(Moment, Duration)>,
}

impl Pause {
    const MAX: usize = 8;

    /// The vehicle refused a modify of a live lease.
    pub(crate) fn refused(&mut self, at: Moment) {
        let pause = match self.refused.back() {
            Some((last, _)) if at.since(*last) < ONE => return,
            Some((last, pause)) if at.since(*last) < FORGIVEN => (*pause * 2).min(PAUSE_MAX),
            Some(_) | None => PAUSE,
        };
        if self.refused.len() == Self::MAX {
            self.refused.pop_front();
        }
        self.refused.push_back((at, pause));
    }

    /// Whether there was any refusal.
    pub(crate) fn is_any(&self) -> bool {
        !self.refused.is_empty()
    }

    /// The last refusal that was sent before `heard` and whose pause is not over.
    pub(crate) fn standing(&self, now: Moment, heard: Moment) -> Option<(Moment, Duration)> {
        let stands = |(at, pause): &&(Moment, Duration)| *at <= heard && now.since(*at) < *pause;
        self.refused.iter().rev().find(stands).copied()
    }

    pub(crate) fn clear(&mut self) {
        self.refused.clear();
    }
}
