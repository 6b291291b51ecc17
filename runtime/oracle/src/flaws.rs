use std::collections::VecDeque;
use std::time::Duration;

use crate::moment::Moment;
use crate::rule::Rule;

/// How long nothing may steer after a flaw of navigation: 10 s, less the possible difference between two measurements.
pub(crate) const STEADY: Duration = Duration::from_millis(9900);

/// Something that shows that nothing may steer by navigation or by the vehicle's clock.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flaw {
    /// The runtime cannot have seen the flaw before this, and so cannot count from an earlier time.
    pub(crate) since: Moment,
    /// When the sentence that shows the flaw left the vehicle.
    pub(crate) told: Moment,
    pub(crate) what: What,
}

/// What is wrong, with figures.
#[derive(Clone, Copy, Debug)]
pub(crate) enum What {
    /// The reported position moved away from the truth by so much within a window.
    Untrue { off_m: f64, span_s: f64 },
    /// Navigation came without velocities for so long.
    NoVelocity { for_s: f64 },
    /// The vehicle's clock was set by at least so much.
    ClockSet { by_s: f64 },
}

impl What {
    pub(crate) const fn rule(self) -> Rule {
        match self {
            Self::Untrue { .. } => Rule::NavigationUntrue,
            Self::NoVelocity { .. } => Rule::VelocityMissing,
            Self::ClockSet { .. } => Rule::ClockSet,
        }
    }
}

impl std::fmt::Display for What {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Untrue { off_m, span_s } => {
                write!(
                    f,
                    "navigation had moved {off_m:.1} m away from the truth within {span_s:.1} s"
                )
            }
            Self::NoVelocity { for_s } => write!(f, "navigation had come without velocities for {for_s:.1} s"),
            Self::ClockSet { by_s } => write!(f, "the vehicle's clock had been set by at least {by_s:.1} s"),
        }
    }
}

/// The flaws of the last seconds.
#[derive(Clone, Debug, Default)]
pub(crate) struct Flaws(VecDeque<Flaw>);

impl Flaws {
    const MAX: usize = 256;

    pub(crate) fn add(&mut self, flaw: Flaw) {
        if self.0.len() == Self::MAX {
            self.0.pop_front();
        }
        self.0.push_back(flaw);
    }

    /// Drops the flaws that were sent from this time on, which the runtime may never have read. Returns whether one of
    /// them was of the vehicle's clock.
    pub(crate) fn unread_from(&mut self, told: Moment) -> bool {
        let of_clock = |flaw: &Flaw| flaw.told >= told && flaw.what.rule() == Rule::ClockSet;
        let clock = self.0.iter().any(of_clock);
        self.0.retain(|flaw| flaw.told < told);
        clock
    }

    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }

    /// For each rule, the newest flaw that was sent before `heard` and after which nothing may steer yet.
    pub(crate) fn standing(&mut self, now: Moment, heard: Moment) -> Vec<Flaw> {
        self.0.retain(|flaw| now.since(flaw.since) < STEADY);
        let mut standing: Vec<Flaw> = Vec::new();
        for flaw in self.0.iter().rev().filter(|flaw| flaw.told <= heard) {
            if standing.iter().all(|other| other.what.rule() != flaw.what.rule()) {
                standing.push(*flaw);
            }
        }
        standing
    }
}
