//! The long runs, shortened for every change.

mod real_time;

use backseat_soak::year::{self, Year};

#[test]
fn a_day_with_faults() {
    let report = year::run(&Year {
        days: 1,
        seed: 1,
        intensity: 0.05,
    })
    .unwrap();
    assert_eq!(report.faults(), Vec::<String>::new(), "{report}");
    assert!(
        report.faults_played > 50 && report.excused > 0 && report.commands > 20_000,
        "{report}"
    );
    assert!(report.navigation > 600_000, "{report}");
}
