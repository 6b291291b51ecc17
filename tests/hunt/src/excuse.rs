//! The only excuse for a runtime that never sends anything again: no plugin is left.

use std::collections::BTreeMap;

use crate::fault::Fault;
use crate::plan::Planned;

/// The faults of [`crate::PLUGIN_FAULTS`] with which a plugin fails in each step. With the others it makes requests
/// that are refused, or none, and recovers when the fault is over.
const FAILING: [&str; 10] = [
    "trap",
    "loop",
    "grow",
    "flood",
    "error",
    "huge_string",
    "big_snapshot",
    "nine_frames",
    "long_frame",
    "long_topside",
];
/// A plugin that fails more often is quarantined for good (`runtime/core`, conductor).
const FAILURES_MAX: u64 = 5;

/// Whether every plugin met a fault that makes it fail, and has failed so often that it is quarantined. `plugins` has
/// their names in the order of their slots.
pub(crate) fn none_is_left<'a>(
    plugins: impl IntoIterator<Item = &'a str>,
    faults: &[Planned],
    failures: &BTreeMap<String, u64>,
) -> bool {
    plugins.into_iter().enumerate().all(|(slot, name)| {
        let fails = |planned: &Planned| match &planned.fault {
            Fault::Plugin { slot: at, fault, .. } => *at == slot && FAILING.contains(&fault.as_str()),
            Fault::AllTrap { .. } => true,
            Fault::Vehicle(_)
            | Fault::Swap { .. }
            | Fault::Kill { .. }
            | Fault::Stop { .. }
            | Fault::Hold { .. }
            | Fault::DiskFull { .. } => false,
        };
        faults.iter().any(fails) && failures.get(name).is_some_and(|count| *count > FAILURES_MAX)
    })
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use backseat_units::Timestamp;

    use super::*;
    use crate::fault::PLUGIN_FAULTS;
    use crate::plan::Come;

    const LASTS: Duration = Duration::from_secs(60);

    fn planned(fault: Fault) -> Planned {
        Planned {
            come: Come::At(Timestamp::from_secs(100)),
            fault,
        }
    }

    fn fault(slot: usize, fault: &str) -> Planned {
        planned(Fault::Plugin {
            slot,
            fault: fault.to_owned(),
            lasts: LASTS,
        })
    }

    fn left(faults: &[Planned], [first, second]: [u64; 2]) -> bool {
        let failures = BTreeMap::from([("first".to_owned(), first), ("second".to_owned(), second)]);
        !none_is_left(["first", "second"], faults, &failures)
    }

    #[test]
    fn only_plugins_that_are_all_quarantined_by_a_fault_that_can_do_it_excuse_silence() {
        assert!(!left(&[planned(Fault::AllTrap { lasts: LASTS })], [6, 6]));
        assert!(!left(&[fault(0, "trap"), fault(1, "grow")], [6, 7]));
        // One of them is still running.
        assert!(left(&[planned(Fault::AllTrap { lasts: LASTS })], [6, 5]));
        assert!(left(&[fault(0, "trap"), fault(0, "grow")], [6, 6]));
        // Whatever the cause was, it was not this.
        assert!(left(&[fault(0, "trap"), fault(1, "nan")], [6, 6]));
        assert!(left(&[planned(Fault::Stop { lasts: LASTS })], [6, 6]));
        assert!(left(&[], [0, 0]));
    }

    #[test]
    fn every_fault_that_excuses_is_one_of_the_plugins() {
        assert!(FAILING.iter().all(|fault| PLUGIN_FAULTS.contains(fault)));
    }
}
