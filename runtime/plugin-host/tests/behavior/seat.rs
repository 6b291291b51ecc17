//! Another version in a plugin's place.

use backseat_core::Restarted;
use backseat_core::plugin::{Event, FaultKind, PluginFault, Refusal, RequestState, Returned, StepInput, Version};
use backseat_core::refusal::{Reason, Uncontrolled, ZoneRule};
use backseat_plugin_host::{Budget, Plugin, Seat};

use crate::fixture::{breach, fault_kind, faulty, input, only_modify, template};

fn version(trial_steps: u32) -> Version {
    Version {
        version: "0.2.0".to_owned(),
        sha256: "ab".repeat(32),
        trial_steps,
    }
}

fn steady() -> Plugin {
    faulty("none", 0, Budget::default())
}

fn tag(returned: &Returned) -> u64 {
    only_modify(returned).tag
}

/// A seat that has done the steps of the first seconds.
fn seat(plugin: Plugin, seconds: u64) -> Seat {
    let mut seat = Seat::new(plugin);
    for second in 0..seconds {
        assert_eq!(tag(&seat.step(&input(second))), second + 1);
    }
    seat
}

fn refused(second: u64, tag: u64, refusal: Refusal) -> StepInput {
    StepInput {
        events: vec![Event::Outcome {
            tag,
            state: RequestState::Rejected(refusal),
        }],
        ..input(second)
    }
}

#[test]
fn a_version_takes_over_the_state_of_the_one_before_and_passes_its_trial() {
    let mut seat = seat(steady(), 5);
    seat.offer(steady(), version(3));
    assert_eq!(
        tag(&seat.step(&input(5))),
        6,
        "the present one is stepped until the restart"
    );
    let taken = seat.restart();
    assert_eq!((taken.result, taken.lost_steps), (Ok(()), 0));
    for second in 6..9 {
        assert_eq!(seat.take_passed(), None);
        assert_eq!(tag(&seat.step(&input(second))), second + 1, "it counts on");
    }
    assert_eq!(seat.take_passed(), Some(version(3)));
    assert_eq!(seat.take_passed(), None);
    // A later restart is its own.
    assert_eq!(seat.restart().lost_steps, 3);
    assert_eq!(tag(&seat.step(&input(9))), 7);
}

#[test]
fn a_version_that_fails_on_trial_gives_way_to_the_one_before_with_its_state() {
    for fault in ["trap", "loop", "grow", "error", "huge_string"] {
        let mut seat = seat(steady(), 5);
        // The state has the time of the first step, so the fault begins at 7 s.
        seat.offer(faulty(fault, 7, Budget::default()), version(30));
        assert_eq!(seat.restart().result, Ok(()));
        assert_eq!(tag(&seat.step(&input(5))), 6);
        assert_eq!(tag(&seat.step(&input(6))), 7);
        let failed = seat.step(&input(7));
        assert_eq!(fault_kind(&failed), Some(FaultKind::Trial), "{fault}");
        let text = failed.result.unwrap_err().text;
        assert!(text.starts_with("version 0.2.0 on trial: "), "{text}");
        let back = seat.restart();
        assert_eq!((back.result, back.lost_steps), (Ok(()), 3), "{fault}");
        assert_eq!(tag(&seat.step(&input(8))), 6, "it counts on where it was replaced");
        assert_eq!(seat.take_passed(), None);
    }
}

#[test]
fn a_version_gives_way_if_it_is_refused_what_it_asks_for() {
    let zone = || breach(ZoneRule::KeepIn, 12.5);
    let gives_way = |event: StepInput| {
        let mut seat = seat(steady(), 5);
        seat.offer(steady(), version(30));
        assert_eq!(seat.restart().result, Ok(()));
        assert_eq!(tag(&seat.step(&input(5))), 6);
        let returned = seat.step(&event);
        let kind = fault_kind(&returned);
        if let Err(fault) = returned.result {
            assert!(
                fault.text.starts_with("version 0.2.0 on trial: refused: keep-in: "),
                "{}",
                fault.text
            );
        }
        kind
    };
    assert_eq!(gives_way(refused(6, 6, zone())), Some(FaultKind::Trial));
    // A request of the version before.
    assert_eq!(gives_way(refused(6, 5, zone())), None);
    // The vehicle's state, and not the request.
    assert_eq!(gives_way(refused(6, 6, Reason::NavigationIsStale.into())), None);
    assert_eq!(gives_way(refused(6, 6, Uncontrolled::OperatorHolds.into())), None);
}

#[test]
fn a_version_without_a_trial_is_not_replaced() {
    let mut seat = seat(steady(), 5);
    seat.offer(faulty("trap", 7, Budget::default()), version(0));
    assert_eq!(seat.restart().result, Ok(()));
    for second in 5..7 {
        assert_eq!(tag(&seat.step(&input(second))), second + 1);
    }
    assert_eq!(fault_kind(&seat.step(&input(7))), Some(FaultKind::Trap));
    assert_eq!(seat.take_passed(), None);
}

#[test]
fn a_version_that_cannot_restore_the_state_leaves_the_present_one_as_it_is() {
    let mut seat = Seat::new(template());
    let before = seat.step(&input(0));
    seat.offer(steady(), version(30));
    let refused = seat.restart().result.unwrap_err();
    assert_eq!(refused.kind, FaultKind::Trial);
    assert!(refused.text.starts_with("restore: "), "{}", refused.text);
    let mut alone = template();
    assert_eq!(alone.step(&input(0)), before);
    assert_eq!(
        seat.step(&input(1)).result.unwrap(),
        alone.step(&input(1)).result.unwrap(),
        "nothing has changed"
    );
}

#[test]
fn a_version_replaces_one_that_has_failed_from_its_last_snapshot() {
    let budget = Budget {
        snapshot_every_steps: 3,
        ..Budget::default()
    };
    let mut seat = seat(faulty("trap", 5, budget), 5);
    assert_eq!(fault_kind(&seat.step(&input(5))), Some(FaultKind::Trap));
    seat.offer(steady(), version(30));
    let taken = seat.restart();
    // The snapshot was taken after the third step.
    assert_eq!((taken.result, taken.lost_steps), (Ok(()), 3));
    assert_eq!(tag(&seat.step(&input(6))), 4);
}

/// What a run of a seat has recorded.
enum Recorded {
    Step(Box<(StepInput, Returned)>),
    Offer(&'static str),
    Restart(Restarted),
}

fn offered(fault: &str) -> Plugin {
    faulty(fault, 7, Budget::default())
}

#[test]
fn a_recorded_run_with_swaps_is_repeated_to_the_bit() {
    let mut live = Seat::new(steady());
    let mut recorded = Vec::new();
    let step = |live: &mut Seat, recorded: &mut Vec<Recorded>, second| {
        let returned = live.step(&input(second));
        recorded.push(Recorded::Step(Box::new((input(second), returned))));
    };
    for second in 0..5 {
        step(&mut live, &mut recorded, second);
    }
    for fault in ["none", "trap", "big_snapshot"] {
        live.offer(offered(fault), version(4));
        recorded.push(Recorded::Offer(fault));
        recorded.push(Recorded::Restart(live.restart()));
        for second in 5..9 {
            step(&mut live, &mut recorded, second);
            let failed = |it: &Recorded| matches!(it, Recorded::Step(step) if step.1.result.is_err());
            if recorded.last().is_some_and(failed) {
                recorded.push(Recorded::Restart(live.restart()));
            }
        }
    }
    let failed = |it: &&Recorded| matches!(it, Recorded::Step(step) if step.1.result.is_err());
    let trials = recorded.iter().filter(failed);
    assert!(trials.count() > 0);
    let mut again = Seat::new(steady());
    for it in recorded {
        match it {
            Recorded::Step(step) => {
                let (input, returned) = *step;
                assert_eq!(again.step_again(&input, &returned), returned);
            }
            Recorded::Offer(fault) => again.offer(offered(fault), version(4)),
            Recorded::Restart(restarted) => assert_eq!(again.restart_again(&restarted), restarted),
        }
    }
}

/// At sea the clock may end a step, a restart or the snapshot of a swap; a replay has no clock.
#[test]
fn what_the_clock_has_ended_is_ended_again() {
    let mut replayed = seat(steady(), 5);
    replayed.offer(steady(), version(30));
    // The snapshot did not return in time, so that the five steps were lost, and the version before with them.
    let taken = replayed.restart_again(&Restarted {
        fuel: 0,
        lost_steps: 5,
        result: Ok(()),
    });
    assert_eq!((taken.result, taken.lost_steps), (Ok(()), 5));
    let fault = PluginFault {
        kind: FaultKind::Trial,
        text: "version 0.2.0 on trial: ran past its deadline".to_owned(),
    };
    let recorded = Returned {
        fuel: 0,
        log: Vec::new(),
        measures: Vec::new(),
        result: Err(fault.clone()),
    };
    assert_eq!(replayed.step_again(&input(5), &recorded).result, Err(fault));
    let back = replayed.restart_again(&Restarted {
        fuel: 0,
        lost_steps: 6,
        result: Ok(()),
    });
    assert_eq!(back.lost_steps, 6);
}
