use backseat_hunt::{Campaign, Order};
use backseat_test_support::plugins;

/// A reduced hunt: `cargo xtask hunt` flies as many as there is time for.
#[test]
fn drawn_missions_with_drawn_troubles_do_nothing_unsafe_and_converge() {
    let order = Order {
        plugins: plugins().to_path_buf(),
        first: 1,
        runs: 60,
        workers: 2,
        stop_at_failure: false,
    };
    let campaign = Campaign::fly(&order, |_| true).unwrap();
    let found: Vec<String> = campaign
        .failed
        .values()
        .flatten()
        .map(|(plan, failure)| format!("seed {}: {}", plan.seed, failure.text))
        .collect();
    let coverage = &campaign.coverage;
    assert!(found.is_empty(), "{}\n{coverage}", found.join("\n"));
    // Not an empty victory.
    assert_eq!(coverage.flights, order.runs);
    assert!(coverage.with_both >= 50 && coverage.troubles > 200, "{coverage}");
}
