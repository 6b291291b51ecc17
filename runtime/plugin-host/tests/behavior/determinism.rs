use std::sync::Arc;
use std::time::Duration;

use backseat_core::plugin::{Behavior, CtdSample, Event, Request, RequestState, Returned, StepInput};
use backseat_core::plugin::{EndCause, Failure};
use backseat_core::refusal::ZoneRule;
use backseat_plugin_host::{Budget, Host};

use crate::fixture::{Latitude, breach, brief, components, faulty, input, template};

/// One input with an event of every kind.
fn eventful(second: u64) -> StepInput {
    let now = input(second).now;
    let behavior = Behavior {
        kind: "trackline".into(),
        tag: Some(3),
    };
    let states = [
        RequestState::Rejected(breach(ZoneRule::KeepIn, 12.0)),
        RequestState::Sent,
        RequestState::Pending,
        RequestState::Accepted,
        RequestState::Failed(Failure::Vehicle("no".into())),
        RequestState::TimedOut,
        RequestState::Unknown,
        RequestState::Started,
        RequestState::Ended(EndCause::TermOver.into()),
        RequestState::Cancelled,
    ];
    let mut events = vec![
        Event::Control(true),
        Event::Ctd(CtdSample {
            measured: now - Duration::from_millis(40),
            conductivity_us_per_cm: 42_000.0,
            temperature_c: 11.5,
            pressure_kpa: 201.0,
        }),
        Event::MissionCommand("go on".into()),
        Event::BehaviorBegan(behavior.clone()),
        Event::BehaviorEnded(behavior),
        Event::Timer(7),
        Event::Restored {
            lost_steps: 4,
            open: vec![1, 2],
        },
        Event::Shutdown,
    ];
    events.extend(states.into_iter().map(|state| Event::Outcome { tag: second, state }));
    StepInput {
        events,
        ..input(second)
    }
}

fn run(component: &backseat_plugin_host::Component) -> Vec<Returned> {
    let config = r#"{"heading_deg": 90.0, "depth_m": 10.0, "speed_mps": 1.5}"#;
    let mut started = component
        .start(Budget::default(), &brief(config), Arc::new(Latitude))
        .unwrap();
    (0..50)
        .map(|second| {
            started.plugin.step(&if second % 3 == 0 {
                eventful(second)
            } else {
                input(second)
            })
        })
        .collect()
}

#[test]
fn two_runs_return_the_same_with_the_same_fuel() {
    let first = run(&components().template);
    let other_host = Host::new().unwrap();
    let second = run(&other_host.load("template", &components().template_bytes).unwrap());
    assert_eq!(first, second);
    assert!(first.iter().all(|returned| returned.fuel > 0));
    // What the guest received: it logs the two outcomes that it was told to log.
    let lines: Vec<&str> = first[3].log.iter().map(|line| &*line.text).collect();
    assert_eq!(
        lines,
        [
            "request 3: keep-in: outside keep-in zone 'box' with its margin of 5 m by 12.0 m at polygon 3 hole 2 edge 1 \
             (latitude 42.500000 longitude -70.250000)",
            "request 3: no"
        ]
    );
}

#[test]
fn a_call_does_not_depend_on_earlier_calls_of_other_plugins() {
    let mut alone = faulty("none", 0, Budget::default());
    let expected: Vec<_> = (0..5).map(|second| alone.step(&input(second))).collect();
    let mut noisy = faulty("log_flood", 0, Budget::default());
    let mut beside = faulty("none", 0, Budget::default());
    let got: Vec<_> = (0..5)
        .map(|second| {
            noisy.step(&input(second));
            beside.step(&input(second))
        })
        .collect();
    assert_eq!(got, expected);
}

#[test]
fn navigation_disappears_and_comes_back() {
    let mut plugin = template();
    let without = StepInput {
        navigation: None,
        control: false,
        ..input(1)
    };
    assert_eq!(plugin.step(&without).result, Ok(vec![]));
    assert!(matches!(
        plugin.step(&input(2)).result.as_deref(),
        Ok([Request::Modify(_)])
    ));
}
