use std::time::Duration;

use backseat_units::{TimeOfDay, Timestamp};

/// How old the vehicle's newest navigation is, by the time of its solution. Arrival alone makes nothing fresh.
#[derive(Clone, Debug, Default)]
pub(crate) struct Navigation {
    newest: Option<Newest>,
}

#[derive(Clone, Copy, Debug)]
struct Newest {
    solution: TimeOfDay,
    /// The same, going on over midnight, nanoseconds.
    solution_ns: i64,
    /// The smallest difference seen between the run's time at the write and the solution's, nanoseconds.
    offset_ns: i64,
}

impl Navigation {
    /// A solution that goes back further than this is another clock, nanoseconds.
    const RESTART_NS: i64 = -1_000_000_000;

    /// Forgets all, for a new connection.
    pub(crate) fn clear(&mut self) {
        self.newest = None;
    }

    /// The vehicle wrote a BFNVG. Whether its solution time advanced.
    pub(crate) fn heard(&mut self, at: Timestamp, solution: TimeOfDay) -> bool {
        let at_ns = nanos(at);
        let Some(newest) = &mut self.newest else {
            let solution_ns = nanos_of(solution);
            self.newest = Some(Newest {
                solution,
                solution_ns,
                offset_ns: at_ns - solution_ns,
            });
            return true;
        };
        let step_ns = solution.nanos_since(newest.solution);
        if step_ns < Self::RESTART_NS {
            self.newest = None;
            return self.heard(at, solution);
        }
        if step_ns <= 0 {
            return false;
        }
        newest.solution = solution;
        newest.solution_ns = newest.solution_ns.saturating_add(step_ns);
        newest.offset_ns = newest.offset_ns.min(at_ns.saturating_sub(newest.solution_ns));
        true
    }

    /// How old the newest solution is; `None` where there was none on this connection.
    pub(crate) fn age(&self, now: Timestamp) -> Option<Duration> {
        let newest = self.newest?;
        let solved_ns = newest.solution_ns.saturating_add(newest.offset_ns);
        let age_ns = nanos(now).saturating_sub(solved_ns);
        Some(Duration::from_nanos(u64::try_from(age_ns).unwrap_or(0)))
    }
}

fn nanos(at: Timestamp) -> i64 {
    i64::try_from(at.as_nanos()).unwrap_or(i64::MAX)
}

fn nanos_of(time: TimeOfDay) -> i64 {
    i64::try_from(time.as_nanos()).unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_an_advancing_solution_is_fresh_and_a_late_one_is_old() {
        let tod = |millis: u64| TimeOfDay::from_nanos(millis * 1_000_000).unwrap();
        let ms = Timestamp::from_millis;
        let age = |navigation: &Navigation, at| navigation.age(ms(at)).unwrap().as_millis();
        let mut navigation = Navigation::default();
        assert_eq!(navigation.age(ms(0)), None);
        assert!(navigation.heard(ms(1000), tod(86_399_950)));
        assert!(navigation.heard(ms(1100), tod(86_400_050 % 86_400_000)));
        assert_eq!(age(&navigation, 1150), 50);
        assert!(!navigation.heard(ms(3000), tod(50)));
        assert_eq!(age(&navigation, 3000), 1900);
        // Written 2 s after it was solved.
        assert!(navigation.heard(ms(4000), tod(950)));
        assert_eq!(age(&navigation, 4000), 2000);
        // Another clock.
        assert!(navigation.heard(ms(4100), tod(40_000_000)));
        assert!(navigation.heard(ms(4200), tod(10_000_000)));
        assert_eq!(age(&navigation, 4200), 0);
    }
}
