use backseat_sdk::{Ended, Failure, Outcome, VehicleSpeed};

use super::*;

fn plugin() -> TrimAndBuoyancy {
    TrimAndBuoyancy::new(Config {
        listen_s: 60.0,
        tries: 2,
        retry_s: 10.0,
    })
    .unwrap()
}

/// A step, in which the propeller turns so fast.
fn step(plugin: &mut TrimAndBuoyancy, seconds: u64, rpm: f64, events: &[Event]) -> Option<Request> {
    let speed = Event::Sample(Sample::VehicleSpeed(VehicleSpeed {
        age_ns: 0,
        thruster_rpm: rpm,
        water_speed: None,
    }));
    let input = StepInput {
        now_ns: seconds * SECOND_NS,
        control: true,
        events: [&[speed], events].concat(),
        ..StepInput::default()
    };
    let mut requests = plugin.step(&input).unwrap();
    assert!(requests.len() <= 1, "{requests:?}");
    requests.pop()
}

fn outcome(tag: u64, state: Fate) -> [Event; 1] {
    [Event::Outcome(Outcome { tag, state })]
}

fn done() -> Fate {
    Fate::Ended(Ended::new(EndKind::Done, "completed"))
}

fn failed() -> Fate {
    Fate::Failed(Failure::Vehicle("the tailcone is spinning".to_owned()))
}

const fn silent(tag: u64, silent: bool) -> Option<Request> {
    Some(Request::Silent(Silent { tag, silent }))
}

/// A plugin whose request for silence, with tag 3, has just been made at 200 s.
fn before_silence() -> TrimAndBuoyancy {
    let mut plugin = plugin();
    step(&mut plugin, 0, 0.0, &[]);
    step(&mut plugin, 10, 0.0, &[]);
    step(&mut plugin, 100, 0.0, &outcome(1, done()));
    assert_eq!(step(&mut plugin, 200, 0.0, &outcome(2, done())), silent(3, true));
    plugin
}

#[test]
fn it_waits_for_a_still_propeller() {
    let mut plugin = plugin();
    assert_eq!(step(&mut plugin, 0, 800.0, &[]), None);
    assert_eq!(step(&mut plugin, 10, 0.0, &[]), None);
    assert_eq!(step(&mut plugin, 12, 0.0, &[]), None);
    assert_eq!(step(&mut plugin, 13, 0.0, &[]), Some(Request::Buoyancy(1)));
    assert_eq!(step(&mut plugin, 14, 0.0, &[]), None);
}

#[test]
fn buoyancy_comes_first_then_trim_then_silence() {
    let mut plugin = plugin();
    step(&mut plugin, 0, 0.0, &[]);
    assert_eq!(step(&mut plugin, 10, 0.0, &[]), Some(Request::Buoyancy(1)));
    assert_eq!(step(&mut plugin, 20, 0.0, &outcome(1, Fate::Started)), None);
    assert_eq!(step(&mut plugin, 60, 0.0, &outcome(1, done())), Some(Request::Trim(2)));
    assert_eq!(step(&mut plugin, 90, 0.0, &outcome(2, done())), silent(3, true));
    assert_eq!(step(&mut plugin, 92, 0.0, &outcome(3, Fate::Started)), None);
    assert_eq!(step(&mut plugin, 151, 0.0, &[]), None);
    assert_eq!(step(&mut plugin, 152, 0.0, &[]), silent(4, false));
    assert_eq!(step(&mut plugin, 154, 0.0, &outcome(3, done())), None);
    assert_eq!(step(&mut plugin, 155, 0.0, &outcome(4, done())), None);
    assert_eq!(plugin.state.step, Step::Over);
    assert_eq!(step(&mut plugin, 400, 0.0, &[]), None);
}

#[test]
fn a_step_that_fails_is_tried_again_and_then_left_out() {
    let mut plugin = plugin();
    step(&mut plugin, 0, 0.0, &[]);
    assert_eq!(step(&mut plugin, 10, 0.0, &[]), Some(Request::Buoyancy(1)));
    assert_eq!(step(&mut plugin, 11, 0.0, &outcome(1, failed())), None);
    assert_eq!(step(&mut plugin, 20, 0.0, &[]), None);
    assert_eq!(step(&mut plugin, 21, 0.0, &[]), Some(Request::Buoyancy(2)));
    assert_eq!(
        step(&mut plugin, 22, 0.0, &outcome(2, failed())),
        Some(Request::Trim(3))
    );
    // What is said of the old step does not matter any more.
    assert_eq!(step(&mut plugin, 23, 0.0, &outcome(2, failed())), None);
    assert_eq!(plugin.state.step, Step::Trim);
}

#[test]
fn a_silence_that_cannot_begin_is_tried_again() {
    let mut plugin = before_silence();
    assert_eq!(step(&mut plugin, 201, 0.0, &outcome(3, failed())), None);
    assert_eq!(step(&mut plugin, 211, 0.0, &[]), silent(4, true));
    step(&mut plugin, 212, 0.0, &outcome(4, failed()));
    assert_eq!(plugin.state.step, Step::Over);
}

#[test]
fn a_silence_that_cannot_end_is_ended_again() {
    let mut plugin = before_silence();
    step(&mut plugin, 201, 0.0, &outcome(3, Fate::Started));
    assert_eq!(step(&mut plugin, 261, 0.0, &[]), silent(4, false));
    assert_eq!(step(&mut plugin, 263, 0.0, &outcome(4, Fate::TimedOut)), None);
    assert_eq!(step(&mut plugin, 273, 0.0, &[]), silent(5, false));
    // It may also end by itself.
    step(
        &mut plugin,
        280,
        0.0,
        &outcome(3, Fate::Ended(Ended::new(EndKind::Term, "lapsed"))),
    );
    assert_eq!(plugin.state.step, Step::Over);
}

#[test]
fn a_new_instance_waits_for_what_is_open_and_tries_again_what_is_not() {
    let mut first = plugin();
    step(&mut first, 0, 0.0, &[]);
    step(&mut first, 10, 0.0, &[]);
    let restored = |open: &[u64]| {
        [Event::Restored(backseat_sdk::Restored {
            lost_steps: 1,
            open: open.to_vec(),
        })]
    };
    let mut second = plugin();
    second.restore(&first.snapshot()).unwrap();
    assert_eq!(second.state, first.state);
    assert_eq!(step(&mut second, 20, 0.0, &restored(&[1])), None);
    assert_eq!(step(&mut second, 40, 0.0, &[]), None);

    second.restore(&first.snapshot()).unwrap();
    assert_eq!(step(&mut second, 20, 0.0, &restored(&[])), None);
    assert_eq!(step(&mut second, 30, 0.0, &[]), Some(Request::Buoyancy(2)));
    assert!(second.restore(&[255; 3]).is_err());
}

#[test]
fn invalid_settings_are_refused() {
    let refused = |listen_s, tries| {
        TrimAndBuoyancy::new(Config {
            listen_s,
            tries,
            retry_s: 10.0,
        })
        .unwrap_err()
    };
    assert!(refused(301.0, 2).starts_with("listen_s"));
    assert!(refused(60.0, 0).starts_with("tries"));
}
