use backseat_hunt::{Plan, Range};
use backseat_test_support::plugins;

/// Requirement 024 takes control away where navigation is implausible. `backseat-hunt alarms` flies more missions of
/// this kind.
#[test]
fn navigation_that_is_well_is_never_found_untrue() {
    let range = Range::new(plugins()).unwrap();
    let mut leases = 0;
    for seed in 1..=36 {
        let flight = range.fly(&Plan::draw_clean(seed, 1.0)).unwrap();
        let alarms: Vec<_> = flight.alarms().collect();
        assert_eq!(alarms, [], "seed {seed}");
        assert_eq!(flight.failures, [], "seed {seed}");
        leases += flight.report.seen.leases;
    }
    // Enough must have been exercised.
    assert!(leases > 500, "{leases}");
}
