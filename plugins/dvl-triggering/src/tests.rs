use backseat_sdk::{Dvl, EndKind, Ended, Outcome};

use super::*;

fn plugin() -> DvlTriggering {
    DvlTriggering::new(Config {
        trigger_s: 60.0,
        silence_max_s: 3.0,
        retry_s: 10.0,
    })
    .unwrap()
}

/// A step, in which the DVL measures.
fn step(plugin: &mut DvlTriggering, seconds: f64, events: &[Event]) -> Vec<(u64, bool, bool)> {
    let sample = Event::Sample(Sample::Dvl(Dvl {
        age_ns: 0,
        velocity_forward: Some(1.5),
        velocity_starboard: Some(0.0),
        velocity_down: Some(0.0),
        ranges: (None, None, None, None),
        temperature: None,
    }));
    silent_step(plugin, seconds, &[&[sample], events].concat())
}

fn silent_step(plugin: &mut DvlTriggering, seconds: f64, events: &[Event]) -> Vec<(u64, bool, bool)> {
    let input = StepInput {
        now_ns: nanoseconds(seconds),
        control: true,
        events: events.to_vec(),
        ..StepInput::default()
    };
    let requests = plugin.step(&input).unwrap();
    let steps = requests.iter().filter_map(|request| {
        if let Request::DvlTrigger(asked) = request {
            Some((asked.tag, asked.external, asked.triggering))
        } else {
            None
        }
    });
    steps.collect()
}

fn triggering() -> DvlTriggering {
    let mut plugin = plugin();
    assert_eq!(step(&mut plugin, 0.0, &[]), [(1, true, false)]);
    assert_eq!(step(&mut plugin, 1.0, &[]), []);
    assert_eq!(step(&mut plugin, 2.0, &[Event::DvlTrigger(true)]), [(1, true, true)]);
    plugin
}

#[test]
fn it_asks_triggers_when_it_may_and_repeats_until_it_is_done() {
    let mut plugin = triggering();
    let mut said = Vec::new();
    for tenth in 21..=700 {
        let seconds = f64::from(tenth) / 10.0;
        said.extend(step(&mut plugin, seconds, &[]).into_iter().map(|said| (seconds, said)));
    }
    let (last, repeated) = said.split_last().unwrap();
    assert_eq!(*last, (62.0, (1, false, false)));
    assert_eq!(repeated.len(), 29);
    assert!(
        repeated.iter().all(|(_, said)| *said == (1, true, true)),
        "{repeated:?}"
    );
    assert!(
        repeated.windows(2).all(|pair| pair[1].0 - pair[0].0 <= 2.11),
        "{repeated:?}"
    );
}

#[test]
fn it_stops_at_once_when_the_vehicle_says_so_and_goes_on_later() {
    let mut plugin = triggering();
    assert_eq!(step(&mut plugin, 10.0, &[Event::DvlTrigger(false)]), [(1, true, false)]);
    assert_eq!(step(&mut plugin, 20.0, &[]), []);
    assert_eq!(step(&mut plugin, 30.0, &[Event::DvlTrigger(true)]), [(1, true, true)]);
    assert_eq!(plugin.state.stops, 1);
    // 8 s of 60 are over.
    assert_eq!(step(&mut plugin, 81.9, &[]), [(1, true, true)]);
    assert_eq!(step(&mut plugin, 82.0, &[]), [(1, false, false)]);
}

#[test]
fn it_gives_the_dvl_back_if_nothing_is_measured() {
    let mut plugin = triggering();
    step(&mut plugin, 3.0, &[]);
    let mut said = Vec::new();
    for tenth in 31..=70 {
        said.extend(silent_step(&mut plugin, f64::from(tenth) / 10.0, &[]));
    }
    assert_eq!(said.last(), Some(&(1, false, false)));
    assert_eq!(step(&mut plugin, 8.0, &[]), []);
    assert_eq!(step(&mut plugin, 20.0, &[]), [(2, true, false)]);
}

#[test]
fn it_begins_again_after_a_handshake_that_ended() {
    let mut plugin = triggering();
    let over = Event::Outcome(Outcome {
        tag: 1,
        state: Fate::Ended(Ended::new(EndKind::Control, "the vehicle has control")),
    });
    assert_eq!(step(&mut plugin, 5.0, &[over]), []);
    assert_eq!(step(&mut plugin, 16.0, &[]), [(2, true, false)]);
    // What is said of the old handshake does not matter any more.
    let late = Event::Outcome(Outcome {
        tag: 1,
        state: Fate::TimedOut,
    });
    assert_eq!(step(&mut plugin, 17.0, &[late]), []);
    assert_eq!(plugin.state.phase, Phase::Asked);
}

#[test]
fn a_new_instance_begins_again() {
    let first = triggering();
    let mut second = plugin();
    second.restore(&first.snapshot()).unwrap();
    assert_eq!(second.state, first.state);
    let restored = Event::Restored(backseat_sdk::Restored {
        lost_steps: 3,
        open: vec![],
    });
    assert_eq!(step(&mut second, 5.0, &[restored]), []);
    assert_eq!(step(&mut second, 15.0, &[]), [(2, true, false)]);
    assert!(second.restore(&[255; 3]).is_err());
}

#[test]
fn invalid_settings_are_refused() {
    let config = Config {
        trigger_s: f64::NAN,
        silence_max_s: 3.0,
        retry_s: 10.0,
    };
    assert!(DvlTriggering::new(config).unwrap_err().starts_with("trigger_s"));
}
