use std::fs;

use backseat_hunt::{Plan, Range};
use backseat_test_support::{plugins, workspace};

/// The failures that the hunt has found do not occur any more.
#[test]
fn no_plan_that_once_failed_fails_again() {
    let range = Range::new(plugins()).unwrap();
    let mut flown = 0;
    for entry in fs::read_dir(workspace().join("tests/plans")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        let plan = Plan::from_toml(&fs::read_to_string(&path).unwrap())
            .unwrap_or_else(|error| panic!("{}: {error:#}", path.display()));
        let flight = range.fly(&plan).unwrap();
        assert_eq!(flight.failures, [], "{}", path.display());
        flown += 1;
    }
    assert!(flown > 0, "tests/plans has no plan");
}
