use backseat_hunt::{Coverage, Hunt, Order, Plan};
use backseat_test_support::plugins;

/// A short hunt. `cargo xtask hunt` flies as many missions as there is time for.
#[test]
fn drawn_missions_with_drawn_faults_do_nothing_unsafe_and_converge() {
    let coverage = fly(Plan::draw, 60);
    // Enough must have been exercised.
    assert!(coverage.with_both >= 50 && coverage.faults > 200, "{coverage}");
}

#[test]
fn inserts_that_are_led_round_walls_and_taken_back_do_nothing_unsafe() {
    let coverage = fly(Plan::draw_detours, 10);
    assert!(coverage.with_both >= 6, "{coverage}");
}

/// Flies this many missions, none of which may fail.
#[track_caller]
fn fly(draw: fn(u64) -> Plan, runs: u64) -> Coverage {
    let order = Order {
        plugins: plugins().to_path_buf(),
        draw,
        first: 1,
        runs,
        workers: 2,
        stop_at_failure: false,
    };
    let hunt = Hunt::fly(&order, |_| true).expect("missions that can be made");
    let found: Vec<String> = hunt
        .failed
        .values()
        .flatten()
        .map(|(plan, failure)| format!("seed {}: {}", plan.seed, failure.text))
        .collect();
    assert!(found.is_empty(), "{}\n{}", found.join("\n"), hunt.coverage);
    assert_eq!(hunt.coverage.flights, runs);
    hunt.coverage
}
