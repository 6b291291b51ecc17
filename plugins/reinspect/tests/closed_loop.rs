//! The plugin against a vehicle with a simulated sidescan.

mod sea;

use backseat_sdk::{Event, Failure, Plugin, Refusal, Restored, Rule, State};
use reinspect::Reinspect;

use sea::{Trial, config};

#[test]
fn it_circles_the_boxes_and_leaves_the_rocks() {
    let (mut found, mut of, mut wrong, mut confirmed) = (0, 0, 0, 0);
    for seed in 1..=4 {
        let mut trial = Trial::new(seed);
        trial.run();
        let score = trial.score(8.0);
        println!("seed {seed}: {score:?}\n  {}", trial.messages.join("\n  "));
        found += score.0;
        of += score.1;
        wrong += score.2;
        confirmed += trial.messages.iter().filter(|text| text.contains("confirmed")).count();
        assert_eq!(trial.messages.len(), trial.circles.len(), "each circle has its verdict");
    }
    assert!(found + 1 >= of, "{found} of {of} boxes have a circle");
    assert!(wrong <= 1, "{wrong} circles have no box");
    assert!(confirmed + 1 >= found, "{confirmed} of {found} are confirmed");
}

#[test]
fn a_restored_instance_goes_on_as_the_first_would() {
    let mut trial = Trial::new(2);
    while !trial.is_circling() {
        assert!(trial.step());
    }
    let mut second = Reinspect::new(config()).unwrap().with_fence(|_| false);
    let snapshot = trial.plugin.snapshot();
    assert!(snapshot.len() < 200_000, "{} bytes", snapshot.len());
    second.restore(&snapshot).unwrap();
    while let Some(input) = trial.input() {
        let requests = trial.plugin.step(&input).unwrap();
        assert_eq!(requests, second.step(&input).unwrap());
        trial.obey(&requests);
    }
    assert!(!trial.circles.is_empty() && !trial.messages.is_empty());
    assert_eq!(trial.plugin.snapshot(), second.snapshot());
    assert!(second.restore(&snapshot[..9]).unwrap_err().contains("does not parse"));
}

#[test]
fn after_a_failure_no_circle_is_flown_twice() {
    let mut trial = Trial::new(3);
    for _ in 0..400 {
        trial.step();
    }
    let snapshot = trial.plugin.snapshot();
    while !trial.is_circling() {
        assert!(trial.step());
    }
    trial.plugin = Reinspect::new(config()).unwrap().with_fence(|_| false);
    trial.plugin.restore(&snapshot).unwrap();
    let open = trial.open_tags();
    trial.events = vec![Event::Restored(Restored { lost_steps: 900, open })];
    trial.run();
    for (index, circle) in trial.circles.iter().enumerate() {
        let again = trial.circles[index + 1..]
            .iter()
            .filter(|other| trial.local(other.centre).distance_m(trial.local(circle.centre)) < 15.0);
        // What was requested after the snapshot is not known any more: it is cancelled, and may be found again.
        assert!(again.count() <= trial.cancelled.len(), "{:?}", trial.circles);
    }
    assert!(trial.score(8.0).0 >= 2);
}

#[test]
fn a_circle_that_does_not_fit_has_another_radius() {
    let mut trial = Trial::new(1);
    trial.plugin = Reinspect::new(config())
        .unwrap()
        .with_fence(|request| matches!(request, backseat_sdk::Request::Trackcircle(circle) if circle.radius > 22.0));
    trial.run();
    assert!(!trial.circles.is_empty());
    assert!(trial.circles.iter().all(|circle| circle.radius == 20.0));

    let mut narrow = Trial::new(1);
    narrow.plugin = Reinspect::new(config()).unwrap().with_fence(|_| true);
    narrow.run();
    assert_eq!(narrow.asked, 0, "nothing is requested that the fence refuses");
}

#[test]
fn refused_and_failed_circles_are_requested_a_bounded_number_of_times() {
    let mut flaky = Trial::new(4);
    flaky.answer = |_, asked| match asked % 4 {
        1 => Some(State::Failed(Failure::Vehicle("busy".into()))),
        2 => Some(State::TimedOut),
        3 => Some(State::Rejected(Refusal::new(Rule::Plan, "plan unknown"))),
        _ => None,
    };
    flaky.run();
    let (found, of, _) = flaky.score(8.0);
    assert!(found + 1 >= of, "{found} of {of}");

    let mut dead = Trial::new(4);
    dead.answer = |_, _| Some(State::TimedOut);
    dead.run();
    assert!(dead.asked <= 3 * 12 && dead.asked >= 3, "{}", dead.asked);
}

#[test]
fn without_control_it_requests_nothing_and_goes_on_looking() {
    let mut trial = Trial::new(2);
    trial.control = false;
    for _ in 0..2200 {
        trial.step();
    }
    assert_eq!(trial.asked, 0);
    assert!(!trial.plugin.sightings().objects().is_empty());
    trial.control = true;
    trial.run();
    assert!(trial.asked > 0);
}
