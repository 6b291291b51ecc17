//! The long runs in real time, shortened for every change.

use std::sync::{Mutex, PoisonError};

use backseat_soak::beside::{self, Beside};
use backseat_soak::kills::{self, Kills};
use backseat_soak::tcp::{self, Tcp};

/// Runs in real time run alone here, because on a machine that is busy with another both would be late.
static ALONE: Mutex<()> = Mutex::new(());

#[test]
fn ten_seconds_of_tcp() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let report = tcp::run(&Tcp {
        minutes: 10.0 / 60.0,
        clients: 10,
        program: None,
    })
    .unwrap();
    assert_eq!(report.faults(), Vec::<String>::new(), "{report}");
    assert!(report.by_log.0 > 1500 && report.by_log.1 > 80, "{report}");
}

#[test]
fn sr_007_twenty_kills_stops_and_cuts() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let report = kills::run(&Kills {
        trials: 20,
        seed: 2,
        hovering_share: 0.2,
        inserting_share: 0.2,
        at_once: 20,
        only: None,
        keep: None,
    })
    .unwrap();
    assert_eq!(report.faults(), Vec::<String>::new(), "{report}");
    assert_eq!(report.flown(), 20, "{report}");
    assert!(report.stood() >= 12 && report.identifiers() >= 3, "{report}");
}

#[test]
fn sr_006_the_worst_plugins_beside_a_good_one_at_sea() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let faults = ["trap", "loop", "grow", "flood", "log_flood", "huge_string"];
    let report = beside::run(&Beside {
        faults: faults.map(str::to_owned).to_vec(),
        seconds: 8.0,
        at_once: 2,
    })
    .unwrap();
    assert_eq!(report.faults(), Vec::<String>::new(), "{report}");
    for fault in ["trap", "loop", "grow", "flood", "huge_string"] {
        assert!(report.failures(fault) > 0, "{fault} did not happen\n{report}");
    }
}
