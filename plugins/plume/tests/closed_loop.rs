//! The plugin surveys drawn plumes with a simple vehicle, in closed loop: how well it finds the maximum, and how it
//! behaves when something goes wrong.

#![expect(
    clippy::unwrap_used,
    clippy::wildcard_enum_match_arm,
    reason = "in a harness, everything unexpected fails the test"
)]

mod sea;

use backseat_sdk::testing::with_fence;
use backseat_sdk::{Event, Plugin, Request, Restored, State, StepInput};
use backseat_sdk::{Failure, Refusal, Rule};
use plume::Plume;
use sea::{Field, Trial, config};

#[test]
fn it_circles_the_maximum_in_nearly_every_world() {
    const WORLDS: u64 = 150;
    let mut offs: Vec<(f64, u64)> = Vec::new();
    let mut longest_s = 0;
    for seed in 0..WORLDS {
        let mut trial = Trial::new(seed);
        longest_s = longest_s.max(trial.run());
        assert!(trial.done, "world {seed} does not end");
        assert!(trial.most_open <= 3, "{} open in world {seed}", trial.most_open);
        assert_eq!(trial.gaps, 0, "the vehicle had nothing to fly in world {seed}");
        offs.push((trial.circle_off_m(), seed));
    }
    offs.sort_by(|one, other| one.0.total_cmp(&other.0));
    let within = |metres: f64| offs.iter().filter(|(off_m, _)| *off_m < metres).count();
    eprintln!(
        "median {:.1} m, worst {:?}, within 15 m {}, longest {longest_s} s",
        offs[offs.len() / 2].0,
        &offs[offs.len() - 4..],
        within(15.0)
    );
    // 99 of 100 within 15 m, and all within 25 m.
    assert!(within(15.0) * 100 >= 99 * offs.len(), "{:?}", &offs[offs.len() - 6..]);
    assert_eq!(within(25.0), offs.len(), "{:?}", offs.last());
}

#[test]
fn a_restored_instance_continues_identically() {
    let mut trial = Trial::new(5);
    for _ in 0..4000 {
        trial.step();
    }
    let snapshot = trial.plugin.snapshot();
    assert!(snapshot.len() < 100_000, "{}", snapshot.len());
    let mut second = Plume::new(config(trial.field())).unwrap();
    second.restore(&snapshot).unwrap();
    for _ in 0..9000 {
        let input = trial.input();
        let requests = trial.plugin.step(&input).unwrap();
        assert_eq!(requests, second.step(&input).unwrap());
        trial.fly(&requests);
    }
    assert!(trial.done, "the comparison covers the rest of the survey");
    assert_eq!(trial.plugin.snapshot(), second.snapshot());
    assert!(second.restore(&snapshot[..9]).unwrap_err().contains("does not parse"));
}

#[test]
fn after_a_failure_nothing_is_requested_twice_and_the_survey_succeeds() {
    let mut trial = Trial::new(8);
    for _ in 0..1200 {
        trial.step();
    }
    let snapshot = trial.plugin.snapshot();
    let before = trial.asked;
    for _ in 0..1100 {
        trial.step();
    }
    let lost = trial.asked - before;
    trial.plugin = Plume::new(config(trial.field())).unwrap();
    trial.plugin.restore(&snapshot).unwrap();
    trial.events = vec![Event::Restored(Restored {
        lost_steps: 1100,
        open: trial.open_tags(),
    })];
    trial.run();
    assert!(trial.done && lost >= 1);
    assert!(trial.circle_off_m() < 25.0, "{}", trial.circle_off_m());
    // At most the legs that were flown unseen are flown again.
    let legs = 2 + 1 + (500.0f64 / 60.0).ceil() as u32;
    assert!(trial.asked <= legs + lost, "{} asked, {legs} legs", trial.asked);
}

#[test]
fn a_line_that_does_not_fit_is_cut_to_the_part_that_does() {
    let mut trial = Trial::new(11);
    // Nothing may go farther than 200 m to the east.
    fn bounds(request: &Request) -> Option<Refusal> {
        match request {
            Request::Trackline(line) if line.start.longitude.max(line.end.longitude) > -70.5976 => {
                Some(Refusal::new(Rule::KeepIn, "keep-in zone 'box' left by 31.2 m"))
            }
            _ => None,
        }
    }
    trial.answer = |request, _| bounds(request).map(State::Rejected);
    with_fence(bounds, || trial.run());
    assert!(trial.done);
    assert!(trial.circle.is_some(), "{:?}", trial.messages);
    assert!(trial.asked < 80, "{}", trial.asked);
}

#[test]
fn a_circle_that_does_not_fit_is_made_smaller() {
    fn room(request: &Request) -> Option<Refusal> {
        match request {
            Request::Trackcircle(circle) if circle.radius > 40.0 => Some(Refusal::new(Rule::KeepOut, "keep-out")),
            _ => None,
        }
    }
    let mut trial = Trial::new(12);
    trial.answer = |request, _| room(request).map(State::Rejected);
    with_fence(room, || trial.run());
    let circle = trial.circle.as_ref().unwrap();
    assert!((30.0..40.0).contains(&circle.radius), "{}", circle.radius);
    assert_eq!(trial.gaps, 0);
}

#[test]
fn failures_and_passing_refusals_are_tried_again_a_bounded_number_of_times() {
    let mut flaky = Trial::new(13);
    flaky.answer = |_, asked| match asked % 5 {
        1 => Some(State::Failed(Failure::Vehicle("busy".into()))),
        2 => Some(State::TimedOut),
        3 => Some(State::Rejected(Refusal::new(
            Rule::Plan,
            "plan unknown: cannot check the way to the insert",
        ))),
        _ => None,
    };
    with_fence(|_| None, || flaky.run());
    assert!(flaky.done && flaky.circle_off_m() < 25.0, "{}", flaky.circle_off_m());

    let mut dead = Trial::new(13);
    dead.answer = |_, _| Some(State::TimedOut);
    dead.run();
    assert!(dead.done && dead.circle.is_none(), "{:?}", dead.messages);
    assert!(dead.asked <= 3 * 10, "{}", dead.asked);
}

#[test]
fn without_control_it_makes_no_requests_and_continues_when_control_returns() {
    let mut trial = Trial::new(14);
    for _ in 0..2000 {
        trial.step();
    }
    trial.control = false;
    let asked = trial.asked;
    for _ in 0..3600 {
        trial.step();
    }
    assert_eq!(trial.asked, asked);
    trial.control = true;
    trial.run();
    assert!(trial.done && trial.circle_off_m() < 25.0, "{}", trial.circle_off_m());
}

#[test]
fn an_empty_input_is_accepted() {
    let mut plugin = Plume::new(config(&Field::drawn(1))).unwrap();
    assert_eq!(plugin.step(&StepInput::default()).unwrap(), []);
    let control = StepInput {
        control: true,
        ..StepInput::default()
    };
    assert_eq!(plugin.step(&control).unwrap(), []);
}
