use std::time::Duration;

use backseat_core::plugin::{
    Event, FaultKind, PluginFault, Request, RequestState, TrackcircleRequest, TracklineRequest,
};
use backseat_core::plugin::{ModifyRequest, PositionRequest};
use backseat_core::{FailAction, Grant, Note, PluginSetup, Settings, StatusCondition};
use backseat_spi::{Ctd, ToVehicle};
use backseat_units::Timestamp;

use crate::course::{circle, good_line, line, modify, modify_for, plugin, turn};
use crate::trial::{Seen, Setup, Trial, shorts};

fn setup(change: impl Fn(&mut PluginSetup)) -> Setup {
    let mut first = plugin("first");
    change(&mut first);
    Setup {
        plugins: vec![first, plugin("second")],
        ..Setup::default()
    }
}

fn failures(trial: &Trial) -> usize {
    trial
        .notes()
        .iter()
        .filter(|(_, note)| matches!(note, Note::PluginFailed { .. }))
        .count()
}

fn pauses(times: &[Timestamp]) -> Vec<f64> {
    times
        .windows(2)
        .map(|pair| pair[1].since(pair[0]).as_secs_f64())
        .collect()
}

#[test]
fn steps_come_with_navigation_at_the_plugins_period() {
    let mut trial = Trial::with_under_way(setup(|setup| {
        setup.description.step_period = Duration::from_millis(500)
    }));
    let from = trial.now;
    trial.run_for(10.0);
    let count = |plugin| trial.steps(plugin).iter().filter(|(at, _)| *at >= from).count();
    assert_eq!((count(0), count(1)), (20, 100));
    for (at, input) in trial.steps(1).into_iter().filter(|(at, _)| *at >= from) {
        let age = at.since(input.navigation.expect("fresh navigation").solution);
        assert!(
            age < Duration::from_millis(15),
            "the newest navigation of that moment, not {age:?} old"
        );
    }
}

#[test]
fn without_navigation_the_steps_continue_and_contain_none() {
    let mut trial = Trial::under_way();
    trial.vehicle.navigates = false;
    trial.run_for(1.5);
    let from = trial.now;
    trial.run_for(2.0);
    let steps: Vec<_> = trial.steps(0).into_iter().filter(|(at, _)| *at >= from).collect();
    assert!((10..=20).contains(&steps.len()), "{}", steps.len());
    assert!(
        steps
            .iter()
            .all(|(_, input)| input.navigation.is_none() && !input.control)
    );
}

#[test]
fn sr_006_only_one_step_is_in_flight_and_the_next_has_the_newest_navigation_and_all_events_in_order() {
    let mut trial = Trial::under_way();
    trial.script(0, |_| (Duration::from_millis(730), Ok(Vec::new())));
    trial.run_for(1.0);
    let from = trial.now;
    for number in 0..20 {
        let created = trial.vehicle.clock(trial.now);
        let sample = Ctd {
            created,
            conductivity_us_per_cm: f64::from(number),
            temperature_c: 4.0,
            pressure_kpa: 300.0,
            measured: created,
        };
        trial.hear_now([sample.into()]);
        trial.run_for(0.1);
    }
    trial.run_for(2.0);
    // The trial refuses a second step in flight.
    let values: Vec<f64> = trial
        .steps(0)
        .into_iter()
        .filter(|(at, _)| *at >= from)
        .flat_map(|(_, input)| input.events)
        .filter_map(|event| match event {
            Event::Ctd(sample) => Some(sample.conductivity_us_per_cm),
            _ => None,
        })
        .collect();
    assert_eq!(values, (0..20).map(f64::from).collect::<Vec<_>>());
    let (at, input) = trial.steps(0).pop().unwrap();
    assert!(at.since(input.navigation.unwrap().solution) <= Duration::from_millis(110));
}

#[test]
fn sr_006_a_slow_plugin_leaves_its_siblings_cadence_and_lease_untouched() {
    let mut trial = Trial::under_way();
    trial.script(0, |_| (Duration::from_secs(7), Ok(Vec::new())));
    trial.ask(1, [modify_for(1, Duration::from_secs(60))]);
    trial.run_for(1.0);
    let from = trial.now;
    trial.run_for(30.0);
    assert!(trial.lease_ends().is_empty(), "{:?}", trial.lease_ends());
    let refreshes = trial.sent_since("RMB", from);
    assert!(pauses(&refreshes).iter().all(|pause| *pause <= 1.0), "{refreshes:?}");
    let steps: Vec<Timestamp> = trial
        .steps(1)
        .iter()
        .map(|(at, _)| *at)
        .filter(|at| *at >= from)
        .collect();
    assert!(pauses(&steps).iter().all(|pause| *pause < 0.13));
}

#[test]
fn sr_006_a_failing_plugin_leaves_its_siblings_cadence_and_lease_untouched() {
    for kind in [
        FaultKind::Trap,
        FaultKind::OutOfFuel,
        FaultKind::Memory,
        FaultKind::Error,
        FaultKind::TooMuch,
    ] {
        let mut trial = Trial::under_way();
        trial.ask(1, [modify_for(1, Duration::from_secs(60))]);
        trial.run_for(1.0);
        let from = trial.now;
        trial.script(0, move |_| {
            (
                Duration::from_millis(50),
                Err(PluginFault {
                    kind,
                    text: "always".to_owned(),
                }),
            )
        });
        trial.run_for(50.0);
        assert!(trial.lease_ends().is_empty(), "{kind:?}: {:?}", trial.lease_ends());
        assert_eq!(trial.core.late_count(), 0, "{kind:?}: nobody was late");
        assert!(
            pauses(&trial.sent_since("RMB", from)).iter().all(|pause| *pause <= 1.0),
            "{kind:?}"
        );
        assert_eq!(failures(&trial), 6, "{kind:?}: then it is quarantined");
        let quarantined = trial.now;
        trial.run_for(5.0);
        assert!(trial.steps(0).iter().all(|(at, _)| *at < quarantined), "{kind:?}");
    }
}

#[test]
fn sr_006_a_timer_that_expires_during_a_long_step_is_not_a_late_wake_up() {
    let mut trial = Trial::with_under_way(setup(|setup| setup.description.step_period = Duration::from_secs(5)));
    let timer = |id, after| Request::Timer { id, after };
    let mut first = true;
    trial.script(0, move |_| {
        let requests = if first {
            vec![
                timer(1, Duration::from_millis(100)),
                timer(2, Duration::from_millis(300)),
            ]
        } else {
            Vec::new()
        };
        let after = if first {
            Duration::from_millis(1)
        } else {
            Duration::from_secs(2)
        };
        first = false;
        (after, Ok(requests))
    });
    trial.ask(1, [modify_for(1, Duration::from_secs(60))]);
    trial.run_for(20.0);
    assert!(trial.lease_ends().is_empty(), "{:?}", trial.lease_ends());
    assert_eq!(trial.core.late_count(), 0);
    let timers: Vec<Event> = trial
        .events(0)
        .into_iter()
        .filter(|event| matches!(event, Event::Timer(_)))
        .collect();
    assert_eq!(timers, [Event::Timer(1), Event::Timer(2)]);
}

#[test]
fn sr_006_timers_of_zero_length_do_not_make_a_plugin_run_all_the_time() {
    let mut trial = Trial::under_way();
    trial.script(0, |_| {
        (
            Duration::ZERO,
            Ok(vec![Request::Timer {
                id: 1,
                after: Duration::ZERO,
            }]),
        )
    });
    let from = trial.now;
    trial.run_for(1.0);
    let steps = trial.steps(0).iter().filter(|(at, _)| *at >= from).count();
    assert!(steps <= 60, "{steps} steps in a second");
}

#[test]
fn timers_wake_a_plugin_on_time() {
    let mut trial = Trial::with_under_way(setup(|setup| setup.description.step_period = Duration::from_secs(60)));
    trial.run_for(60.0);
    let mut asked = false;
    trial.script(0, move |_| {
        let requests = if asked {
            Vec::new()
        } else {
            vec![Request::Timer {
                id: 7,
                after: Duration::from_secs(3),
            }]
        };
        asked = true;
        (Duration::from_millis(1), Ok(requests))
    });
    trial.run_for(70.0);
    let steps = trial.steps(0);
    let woken = steps
        .iter()
        .position(|(_, input)| input.events.contains(&Event::Timer(7)))
        .expect("the timer");
    let pause = steps[woken].0.since(steps[woken - 1].0);
    assert!((2.9..3.1).contains(&pause.as_secs_f64()), "{pause:?}");
}

#[test]
fn sr_006_an_overflow_of_its_event_queue_is_a_failure_of_the_plugin() {
    let mut trial = Trial::under_way();
    trial.script(0, |_| (Duration::from_secs(3), Ok(vec![Request::Modify(modify(1))])));
    trial.run_for(0.5);
    for number in 0..300 {
        let created = trial.vehicle.clock(trial.now);
        let sample = Ctd {
            created,
            conductivity_us_per_cm: f64::from(number),
            temperature_c: 4.0,
            pressure_kpa: 300.0,
            measured: created,
        };
        trial.hear_now([sample.into()]);
        trial.run_for(0.001);
    }
    let faults: Vec<FaultKind> = trial
        .notes()
        .into_iter()
        .filter_map(|(_, note)| match note {
            Note::PluginFailed { fault, .. } => Some(fault.kind),
            _ => None,
        })
        .collect();
    assert_eq!(faults, [FaultKind::Overflow]);
    trial.run_for(1.5);
    assert!(trial.sent("RMB").is_empty(), "core ignores what it returns after that");
    assert!(trial.events(1).len() > 300, "its sibling receives them all");
}

#[test]
fn sr_003_a_plugin_that_fails_loses_its_lease_and_restarts_with_its_open_requests() {
    let mut trial = Trial::steering();
    trial.ask(0, [good_line(2)]);
    trial.run_for(0.5);
    let failed = trial.now;
    trial.fail(0, FaultKind::Trap);
    trial.run_for(5.0);
    assert_eq!(trial.sent_since("EMB", failed).len(), 1);
    let restart = trial
        .seen
        .iter()
        .find(|(_, seen)| *seen == Seen::Restart(0))
        .expect("a restart")
        .0;
    assert!(restart.since(failed) >= Duration::from_secs(1), "after a back-off");
    let restored = trial.steps(0).into_iter().find(|(at, _)| *at >= restart).unwrap().1;
    assert_eq!(
        restored.events[0],
        Event::Restored {
            lost_steps: 3,
            open: vec![2]
        }
    );
    assert_eq!(restored.events[1], Event::Control(true));
    assert!(trial.commands("RCN").is_empty(), "its inserts go on");
    trial.ask(0, [Request::Modify(modify(3))]);
    trial.run_for(0.5);
    assert!(trial.core.is_steering());
}

#[test]
fn a_plugins_inserts_are_cancelled_when_it_fails_if_its_fail_action_says_so() {
    let mut trial = Trial::with_under_way(setup(|setup| setup.on_failure = FailAction::Cancel));
    trial.ask(0, [good_line(1), good_line(2)]);
    trial.ask(1, [good_line(1)]);
    trial.run_for(0.5);
    trial.fail(0, FaultKind::Trap);
    trial.run_for(1.0);
    assert_eq!(trial.commands("RCN").len(), 2, "only its own inserts");
    assert_eq!(shorts(&trial.states(2)).last(), Some(&"cancelled"));
}

#[test]
fn a_plugin_that_cannot_be_restarted_is_retried_with_growing_pauses_and_then_quarantined() {
    for kind in [FaultKind::Start, FaultKind::Error, FaultKind::Trap] {
        let settings = Settings {
            status_failed_when: vec![StatusCondition::PluginQuarantined],
            ..Settings::default()
        };
        let mut trial = Trial::with_under_way(Setup {
            settings,
            ..Setup::default()
        });
        trial.restart_fails = Some(kind);
        trial.fail(0, FaultKind::Trap);
        trial.run_for(120.0);
        let tries: Vec<Timestamp> = trial
            .seen
            .iter()
            .filter(|(_, seen)| *seen == Seen::Restart(0))
            .map(|(at, _)| *at)
            .collect();
        assert_eq!(tries.len(), 5, "{kind:?}");
        assert!(
            pauses(&tries).windows(2).all(|pair| pair[1] > 1.5 * pair[0]),
            "{kind:?}: {tries:?}"
        );
        let Some((_, ToVehicle::PayloadStatus(status))) = trial.commands("STS").pop() else {
            panic!("no BPSTS")
        };
        assert!(!status.ok, "the operator listed it");
    }
}

#[test]
fn sr_013_invalid_figures_are_rejected_one_by_one() {
    let mut trial = Trial::under_way();
    let place = |latitude_deg, longitude_deg| PositionRequest {
        latitude_deg,
        longitude_deg,
    };
    let good = line(0, (0.0, 500.0), (300.0, 500.0));
    let round = circle(0, (0.0, 600.0), 50.0);
    let bad = [
        Request::Trackline(TracklineRequest {
            tag: 1,
            start: place(91.0, -70.0),
            ..good
        }),
        Request::Trackline(TracklineRequest {
            tag: 2,
            end: place(42.0, f64::NAN),
            ..good
        }),
        Request::Trackline(TracklineRequest {
            tag: 3,
            end: good.start,
            ..good
        }),
        Request::Trackline(TracklineRequest {
            tag: 4,
            speed_mps: -1.0,
            ..good
        }),
        Request::Trackcircle(TrackcircleRequest {
            tag: 5,
            radius_m: -1.0,
            ..round
        }),
        Request::Trackcircle(TrackcircleRequest {
            tag: 6,
            radius_m: f64::INFINITY,
            ..round
        }),
        Request::Trackcircle(TrackcircleRequest {
            tag: 7,
            orbits: f64::NAN,
            ..round
        }),
        Request::Trackcircle(TrackcircleRequest {
            tag: 8,
            entry_angle_deg: Some(f64::NAN),
            ..round
        }),
        Request::Trackcircle(TrackcircleRequest {
            tag: 9,
            centre: place(f64::INFINITY, 0.0),
            ..round
        }),
        Request::Trackcircle(TrackcircleRequest {
            tag: 10,
            orbits: 1e300,
            ..round
        }),
        Request::Modify(ModifyRequest {
            tag: 11,
            heading_deg: f64::NEG_INFINITY,
            ..modify(11)
        }),
        Request::Modify(ModifyRequest {
            tag: 12,
            duration: Duration::MAX,
            ..modify(12)
        }),
    ];
    trial.ask(0, bad);
    trial.run_for(0.5);
    for tag in 1..=12 {
        assert_eq!(shorts(&trial.states(tag)), ["rejected"], "{tag}");
    }
    assert!(trial.names_since(trial.now).is_empty() && trial.core.open_requests() == 0);
    assert_eq!(failures(&trial), 0);
}

#[test]
fn sr_019_each_plugins_requests_have_their_own_rate_limit() {
    let mut trial = Trial::under_way();
    trial.ask(0, (0..100).map(|number| turn(number, number as f64)));
    trial.ask(1, [good_line(500)]);
    trial.run_for(0.5);
    // The log has only a count of these; the plugin learns each one.
    let over = |event: &&Event| match event {
        Event::Outcome {
            state: RequestState::Rejected(refusal),
            ..
        } => refusal.cause() == "requests" && refusal.most() == Some(20.0),
        _ => false,
    };
    let rejected = trial.events(0).iter().filter(over).count();
    assert!((79..=81).contains(&rejected), "{rejected}");
    assert_eq!(shorts(&trial.states(500)), ["sent", "accepted"]);
    trial.run_for(1.0);
    trial.ask(0, [turn(200, 1.0)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(200)), ["sent", "accepted"]);
}

#[test]
fn sr_006_ten_thousand_requests_in_a_step_hurt_nobody_else() {
    let mut trial = Trial::under_way();
    trial.ask(1, [modify_for(1, Duration::from_secs(60))]);
    trial.run_for(1.0);
    let from = trial.now;
    let nonsense = |tag| {
        Request::Trackcircle(TrackcircleRequest {
            tag,
            ..circle(tag, (0.0, 600.0), -1.0)
        })
    };
    trial.ask(0, (1000..11_000).map(nonsense));
    // The last request is a good one, but a plugin that has failed by then no longer steers.
    trial.ask(0, [turn(20_000, 45.0)]);
    trial.run_for(5.0);
    assert!(trial.lease_ends().is_empty(), "{:?}", trial.lease_ends());
    assert!(pauses(&trial.sent_since("RMB", from)).iter().all(|pause| *pause <= 1.0));
    assert!(trial.states(20_000).is_empty() || shorts(&trial.states(20_000)) == ["rejected"]);
    assert!(failures(&trial) <= 1, "one flood is one failure");
    assert_eq!(trial.core.open_requests(), 1);
}

#[test]
fn sr_006_a_flood_from_the_steering_plugin_counts_as_one_failure() {
    let mut trial = Trial::steering();
    let nonsense = |tag| {
        Request::Trackcircle(TrackcircleRequest {
            tag,
            ..circle(tag, (0.0, 600.0), -1.0)
        })
    };
    trial.ask(0, (1000..2000).map(nonsense));
    trial.run_for(0.5);
    assert_eq!(failures(&trial), 1);
    assert_eq!((trial.lease_ends().len(), trial.commands("EMB").len()), (1, 1));
}

#[test]
fn requests_without_a_grant_are_rejected() {
    let mut trial = Trial::with_under_way(setup(|setup| setup.grants = vec![Grant::Insert]));
    trial.ask(
        0,
        [
            Request::Modify(modify(1)),
            good_line(2),
            Request::Message("hello".to_owned()),
        ],
    );
    trial.run_for(0.5);
    assert!(trial.rejection(1).contains("does not grant"));
    assert_eq!(shorts(&trial.states(2)), ["sent", "accepted"]);
    assert!(trial.commands("MSG").is_empty());
    let mut trial = Trial::with_under_way(setup(|setup| setup.grants = vec![Grant::Modify]));
    trial.ask(0, [good_line(1), Request::Cancel(1)]);
    trial.run_for(0.5);
    assert!(matches!(trial.states(1)[..], [RequestState::Rejected(_)]));
    assert!(matches!(trial.cancel_states(1)[..], [RequestState::Rejected(_)]));
}

#[test]
fn messages_are_cleaned_written_in_lower_case_and_limited_to_one_a_second() {
    let mut trial = Trial::under_way();
    trial.ask(0, [Request::Message("$BPRMB,1*2\r\n é end".to_owned())]);
    trial.run_for(0.5);
    let Some((_, ToVehicle::LogMessage(sent))) = trial.commands("MSG").pop() else {
        panic!("no BPMSG")
    };
    assert_eq!(sent.text.as_str(), " bprmb 1 2     end");
    trial.ask(0, [Request::Message("x".repeat(100_000))]);
    trial.run_for(1.0);
    trial.script(0, |_| {
        (
            Duration::from_millis(1),
            Ok(vec![Request::Message("again".to_owned()), Request::Modify(modify(1))]),
        )
    });
    let from = trial.now;
    trial.run_for(5.0);
    assert!(
        trial.sent_since("MSG", from).len() <= 6,
        "{}",
        trial.sent_since("MSG", from).len()
    );
}

#[test]
fn a_message_does_not_prevent_a_modify_in_the_same_step() {
    let mut trial = Trial::under_way();
    trial.ask(0, [Request::Message("turning".to_owned()), Request::Modify(modify(1))]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"], "{:?}", trial.states(1));
}

/// Once a second at most, like the lines that leave.
#[test]
fn a_line_for_the_vehicles_log_without_the_grant_is_dropped_and_the_plugins_log_says_so() {
    let mut trial = Trial::with_under_way(setup(|setup| setup.grants.retain(|grant| *grant != Grant::Message)));
    trial.script(0, |_| {
        (Duration::from_millis(1), Ok(vec![Request::Message("hello".to_owned())]))
    });
    trial.run_for(5.0);
    assert!(trial.commands("MSG").is_empty());
    let told = |(_, note): &(Timestamp, Note)| match note {
        Note::PluginLog { line, .. } => line.text.ends_with("the mission does not grant `message`"),
        _ => false,
    };
    let told = trial.notes().iter().filter(|note| told(note)).count();
    assert!((4..=6).contains(&told), "{told} in 5 s");
}
