use std::fs;

use backseat_hunt::{Plan, Range};
use backseat_test_support::{plugins, workspace};

use crate::flight::Log;

/// How many drawn plans are flown here; `cargo xtask soak` flies a hundred.
const DRAWN: u64 = 3;
/// Every so many of the kept plans is flown here.
const EVERY: usize = 12;
/// And these, in which plugins are restarted.
const RESTARTED: [&str; 2] = ["inserts-open-6454.toml", "jump-ignored-4008222.toml"];

/// Faults of link and vehicle, plugins that fail, processes that are killed, stopped and started again, a full disk, and
/// the operator.
#[test]
fn runs_with_faults_are_replayed_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let range = Range::new(plugins()).unwrap();
    let mut kept: Vec<_> = fs::read_dir(workspace().join("tests/plans"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    kept.sort();
    let restarted = kept
        .iter()
        .filter(|path| RESTARTED.iter().any(|name| path.ends_with(name)));
    let kept = kept.iter().step_by(EVERY).chain(restarted).map(|path| {
        let plan = Plan::from_toml(&fs::read_to_string(path).unwrap()).unwrap();
        (path.display().to_string(), plan)
    });
    let drawn = (0..DRAWN).map(|seed| (format!("seed {seed}"), Plan::draw(seed)));
    let (mut processes, mut restarts, mut unplayed, mut steps) = (0, 0, 0, 0);
    for (name, plan) in kept.chain(drawn) {
        let path = folder.path().join("run.mcap");
        range.fly_logged(&plan, &path).unwrap();
        let report = Log::read(&path).replay();
        assert_eq!(report.identical, Some(true), "{name}: {:#?}", report.first_difference);
        processes += report.processes;
        for plugin in &report.plugins {
            steps += plugin.steps;
            restarts += plugin.restarts;
            unplayed += plugin.unplayed;
        }
    }
    assert!(processes > DRAWN + 2, "no process was killed: {processes}");
    assert!(
        steps > 10_000 && restarts > 0 && unplayed > 0,
        "{steps} {restarts} {unplayed}"
    );
}
