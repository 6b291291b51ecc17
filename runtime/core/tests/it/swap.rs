//! Another version of a plugin, in the middle of a run.

use std::time::Duration;

use backseat_core::plugin::{Event, FaultKind, PluginId, Request, Version};
use backseat_core::{FailAction, Input, Note, Operator};
use backseat_units::Timestamp;

use crate::course::{good_line, modify, plugin};
use crate::trial::{Seen, Setup, Trial};

fn swap(trial: &mut Trial, plugin: usize) -> Timestamp {
    let at = trial.now;
    let version = Version {
        version: "0.2.0".to_owned(),
        sha256: "ab".repeat(32),
        trial_steps: 30,
    };
    trial.feed(Input::Swap(PluginId(plugin), version));
    at
}

fn restarts(trial: &Trial, since: Timestamp) -> Vec<Timestamp> {
    let restarts = trial.seen.iter().filter(|(_, seen)| *seen == Seen::Restart(0));
    restarts.map(|(at, _)| *at).filter(|at| *at >= since).collect()
}

fn notes(trial: &Trial, since: Timestamp, is: impl Fn(&Note) -> bool) -> usize {
    let notes = trial.notes().into_iter();
    notes.filter(|(at, note)| *at >= since && is(note)).count()
}

#[test]
fn a_version_takes_over_between_two_steps_and_the_lease_goes_on() {
    let mut trial = Trial::steering();
    trial.ask(0, [good_line(2)]);
    trial.run_for(0.5);
    let at = swap(&mut trial, 0);
    trial.run_for(5.0);
    assert_eq!(restarts(&trial, at), [at], "at once, without a back-off");
    assert_eq!(notes(&trial, at, |note| matches!(note, Note::PluginSwapped { .. })), 1);
    assert_eq!(notes(&trial, at, |note| matches!(note, Note::PluginFailed { .. })), 0);
    let (begun, first) = trial.steps(0).into_iter().find(|(step, _)| *step > at).unwrap();
    assert!(begun.since(at) < Duration::from_secs(1), "{begun}");
    assert!(
        matches!(&first.events[0], Event::Restored { open, .. } if open.contains(&2)),
        "{:?}",
        first.events
    );
    assert_eq!(first.events[1], Event::Control(true));
    assert!(trial.sent_since("EMB", at).is_empty(), "the lease goes on");
    assert!(trial.sent_since("RMB", at).len() >= 4, "and is refreshed");
    assert!(trial.commands("RCN").is_empty(), "inserts go on too");
}

#[test]
fn a_swap_waits_for_the_step_that_is_under_way() {
    let mut trial = Trial::under_way();
    trial.script(0, |_| (Duration::from_millis(700), Ok(Vec::new())));
    trial.run_for(1.3);
    let begun = trial.steps(0).last().unwrap().0;
    let at = swap(&mut trial, 0);
    assert!(restarts(&trial, at).is_empty(), "a step is under way since {begun}");
    trial.run_for(2.0);
    let restarted = restarts(&trial, at)[0];
    assert_eq!(restarted.since(begun), Duration::from_millis(700), "when it returned");
    let steps = trial.steps(0);
    assert!(steps.iter().all(|(step, _)| *step <= begun || *step > restarted));
}

#[test]
fn what_happens_during_a_swap_is_told_to_the_version_that_takes_over() {
    let mut trial = Trial::under_way();
    trial.run_for(0.5);
    let at = swap(&mut trial, 0);
    trial.feed(Input::Operator(Operator::Hold));
    trial.run_for(1.0);
    let first = trial.steps(0).into_iter().find(|(step, _)| *step > at).unwrap().1;
    assert!(matches!(first.events[0], Event::Restored { .. }), "{:?}", first.events);
    assert!(first.events[1..].contains(&Event::Control(false)), "{:?}", first.events);
}

#[test]
fn a_version_that_cannot_take_over_changes_nothing() {
    let mut trial = Trial::steering();
    trial.restart_fails = Some(FaultKind::Trial);
    let at = swap(&mut trial, 0);
    trial.run_for(5.0);
    assert_eq!(restarts(&trial, at).len(), 1);
    assert_eq!(
        notes(&trial, at, |note| matches!(note, Note::PluginNotSwapped { .. })),
        1
    );
    assert_eq!(notes(&trial, at, |note| matches!(note, Note::PluginFailed { .. })), 0);
    assert!(trial.sent_since("EMB", at).is_empty());
    let later = trial.steps(0).into_iter().filter(|(step, _)| *step > at);
    let restored = |event: &Event| matches!(event, Event::Restored { .. });
    assert!(later.clone().count() > 4, "the version before is stepped");
    assert_eq!(later.flat_map(|(_, step)| step.events).filter(restored).count(), 0);
}

#[test]
fn sr_006_a_version_that_fails_on_trial_loses_the_lease_and_the_one_before_comes_back_at_once() {
    let mut first = plugin("first");
    first.on_failure = FailAction::Abort;
    let plugins = vec![first, plugin("second")];
    let mut trial = Trial::with_under_way(Setup {
        plugins,
        ..Setup::default()
    });
    trial.ask(0, [Request::Modify(modify(1))]);
    trial.run_for(0.5);
    assert!(trial.core.is_steering());
    for _ in 0..8 {
        let failed = trial.now;
        trial.fail(0, FaultKind::Trial);
        trial.run_for(0.3);
        assert_eq!(restarts(&trial, failed).len(), 1, "without a back-off, however often");
        let restarted = restarts(&trial, failed)[0];
        let stepped = trial.steps(0).into_iter().find(|(at, _)| *at > restarted);
        let (stepped, first) = stepped.expect("it is stepped at once");
        assert!(stepped.since(restarted) < Duration::from_millis(20), "{stepped}");
        assert!(matches!(first.events[0], Event::Restored { .. }), "{:?}", first.events);
    }
    assert_eq!(trial.commands("EMB").len(), 1, "its lease has ended");
    assert!(
        trial.commands("ABT").is_empty(),
        "on_failure is for the version that the mission names"
    );
    trial.ask(0, [Request::Modify(modify(2))]);
    trial.run_for(0.5);
    assert!(trial.core.is_steering());
}

#[test]
fn a_swap_revives_a_plugin_that_is_quarantined() {
    let mut trial = Trial::under_way();
    for _ in 0..6 {
        trial.fail(0, FaultKind::Trap);
        trial.run_for(60.0);
    }
    let quarantined = trial.now;
    trial.run_for(5.0);
    assert!(trial.steps(0).iter().all(|(at, _)| *at < quarantined));
    swap(&mut trial, 0);
    trial.run_for(1.0);
    assert!(trial.steps(0).iter().any(|(at, _)| *at > quarantined));
    trial.ask(0, [Request::Modify(modify(1))]);
    trial.run_for(0.5);
    assert!(trial.core.is_steering());
}

#[test]
fn a_plugin_that_is_not_there_is_not_swapped() {
    let mut trial = Trial::under_way();
    let at = swap(&mut trial, 9);
    trial.run_for(1.0);
    assert_eq!(notes(&trial, at, |note| matches!(note, Note::PluginSwap { .. })), 0);
}
