//! The plugin steers a simple vehicle over drawn seabeds, in closed loop: how well it follows the contour, and how it
//! behaves when something goes wrong.

#![expect(
    clippy::unwrap_used,
    clippy::wildcard_enum_match_arm,
    reason = "in a harness, everything unexpected fails the test"
)]

mod sea;

use backseat_sdk::{Event, Outcome, Plugin, Request, State, StepInput};
use backseat_sdk::{Refusal, Rule};
use isobath::Isobath;
use sea::{Sea, Trial, config};

/// The mission expects the plugin to come within 10 m of the contour in 600 s, and then to follow it with an RMS of at
/// most 10 m. This test demands an RMS of less than 6 m.
#[test]
fn it_finds_and_follows_the_contour_in_every_world() {
    let mut worst = (0.0, 0);
    let mut slowest = (0.0, 0);
    let mut sum = 0.0;
    const WORLDS: u64 = 150;
    for seed in 0..WORLDS {
        let mut trial = Trial::new(Sea::drawn(seed));
        let mut found_s = None;
        let (mut square, mut count) = (0.0, 0.0);
        for step in 0..2 * 2400 {
            trial.step();
            let off_m = trial.off_m();
            if off_m < 10.0 && found_s.is_none() {
                found_s = Some(f64::from(step) / 2.0);
            }
            if found_s.is_some() {
                square += off_m * off_m;
                count += 1.0;
            }
        }
        let found_s = found_s.unwrap_or(f64::INFINITY);
        let rms_m = f64::sqrt(square / count);
        if rms_m > worst.0 {
            worst = (rms_m, seed);
        }
        if found_s > slowest.0 {
            slowest = (found_s, seed);
        }
        sum += rms_m;
    }
    eprintln!(
        "worst RMS {worst:?}, slowest {slowest:?}, mean RMS {}",
        sum / WORLDS as f64
    );
    assert!(worst.0 < 6.0, "RMS {} m in world {}", worst.0, worst.1);
    assert!(slowest.0 < 600.0, "{} s in world {}", slowest.0, slowest.1);
}

#[test]
fn a_restored_instance_continues_identically() {
    let mut trial = Trial::new(Sea::drawn(7));
    for _ in 0..600 {
        trial.step();
    }
    let snapshot = trial.plugin.snapshot();
    let mut second = Isobath::new(config(trial.sea())).unwrap();
    second.restore(&snapshot).unwrap();
    for _ in 0..600 {
        let input = trial.input();
        let (first, second) = (trial.plugin.step(&input).unwrap(), second.step(&input).unwrap());
        assert_eq!(first, second);
        trial.fly(&first);
    }
    assert_eq!(trial.plugin.snapshot().len(), { second.snapshot().len() });
    assert_eq!(trial.plugin.snapshot(), second.snapshot());
    assert!(second.restore(&snapshot[..20]).unwrap_err().contains("does not parse"));
}

fn modifies(requests: &[Request]) -> usize {
    requests
        .iter()
        .filter(|request| matches!(request, Request::Modify(_)))
        .count()
}

#[test]
fn a_refused_heading_ends_the_modify_and_is_tried_again_later() {
    let mut trial = Trial::new(Sea::drawn(3));
    for _ in 0..400 {
        trial.step();
    }
    let Some(Request::Modify(asked)) = trial.last.clone() else {
        panic!("no modify")
    };
    let mut input = trial.input();
    input.events = vec![Event::Outcome(Outcome {
        tag: asked.tag,
        state: State::Rejected(Refusal::new(Rule::KeepIn, "keep-in zone 'box' left by 12.0 m")),
    })];
    let requests = trial.plugin.step(&input).unwrap();
    assert_eq!(requests, [Request::EndModify]);
    trial.fly(&requests);
    let mut asks = 0;
    for _ in 0..18 {
        let input = trial.input();
        asks += modifies(&trial.plugin.step(&input).unwrap());
        trial.fly(&[]);
    }
    assert_eq!(asks, 0, "it waits 10 s before it asks again");
    for _ in 0..4 {
        let input = trial.input();
        asks += modifies(&trial.plugin.step(&input).unwrap());
        trial.fly(&[]);
    }
    assert!(asks >= 1);
}

#[test]
fn without_control_it_makes_no_requests_and_continues_when_control_returns() {
    let mut trial = Trial::new(Sea::drawn(4));
    for _ in 0..1000 {
        trial.step();
    }
    trial.control = false;
    for _ in 0..60 {
        let input = trial.input();
        let requests = trial.plugin.step(&input).unwrap();
        assert_eq!(requests, []);
        trial.fly(&requests);
    }
    trial.control = true;
    let input = trial.input();
    assert_eq!(modifies(&trial.plugin.step(&input).unwrap()), 1);
}

#[test]
fn without_bottom_lock_it_keeps_its_heading_and_then_ends_the_modify() {
    let mut trial = Trial::new(Sea::drawn(5));
    for _ in 0..1000 {
        trial.step();
    }
    trial.lock = false;
    let mut headings = Vec::new();
    let mut ended_s = None;
    for step in 0..120 {
        let input = trial.input();
        let requests = trial.plugin.step(&input).unwrap();
        for request in &requests {
            match request {
                Request::Modify(modify) if step > 4 => headings.push(modify.heading),
                Request::EndModify => ended_s = Some(f64::from(step) / 2.0),
                _ => {}
            }
        }
        trial.fly(&requests);
    }
    assert!(
        headings.len() >= 5,
        "the modify is renewed while the heading is kept: {headings:?}"
    );
    assert!(headings.iter().all(|heading| *heading == headings[0]), "{headings:?}");
    let ended_s = ended_s.unwrap();
    assert!((29.0..32.0).contains(&ended_s), "{ended_s}");
    trial.lock = true;
    for _ in 0..4 {
        trial.step();
    }
    assert!(
        matches!(trial.last, Some(Request::Modify(_))),
        "it steers again once there is bottom lock"
    );
}

#[test]
fn a_lease_is_renewed_long_before_it_runs_out() {
    let mut trial = Trial::new(Sea::drawn(6));
    let mut last_ns = None;
    for _ in 0..2000 {
        let input = trial.input();
        let requests = trial.plugin.step(&input).unwrap();
        for request in &requests {
            if let Request::Modify(modify) = request {
                if let Some(last_ns) = last_ns {
                    assert!(input.now_ns - last_ns <= modify.duration_ns / 4);
                }
                last_ns = Some(input.now_ns);
            }
        }
        trial.fly(&requests);
    }
    assert!(last_ns.is_some());
}

#[test]
fn an_empty_input_is_accepted() {
    let mut plugin = Isobath::new(config(&Sea::drawn(1))).unwrap();
    assert_eq!(plugin.step(&StepInput::default()).unwrap(), []);
    let control = StepInput {
        control: true,
        ..StepInput::default()
    };
    assert_eq!(plugin.step(&control).unwrap(), []);
}
