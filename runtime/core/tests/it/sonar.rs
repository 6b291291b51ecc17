//! The sonars: requests to their payload controller, its pings and reports, and what it is told of the vehicle.

use std::time::Duration;

use backseat_core::plugin::{
    Decimation, EndCause, Event, Failure, PINGS_MAX, PingTime, PluginId, Request, RequestState, SonarEvent,
    SonarLogRequest, SonarPing, SonarSetRequest, SonarSetting, Topic,
};
use backseat_core::{
    FromSonar, Grant, Input, Note, Operator, Settings, SonarOrder, SonarOutcome, SonarSetup, StatusCondition, ToSonar,
};
use backseat_spi::{FromVehicle, LoggingBegin, LoggingEnd, Shutdown, SoundVelocity, Text, ToVehicle};
use backseat_units::Timestamp;

use crate::trial::{Seen, Setup, Trial, granted, settings, shorts};

/// The first plugin has the grant and listens to the topics; the second has and does neither.
fn setup(topics: &[Topic]) -> Setup {
    let mut setup = granted(&[Grant::Sonar], topics);
    setup.plugins[1].description.topics.clear();
    Setup {
        settings: with_sonar(settings()),
        ..setup
    }
}

fn with_sonar(settings: Settings) -> Settings {
    Settings {
        sonar: Some(SonarSetup {
            sensors: vec![1, 3],
            log_with_vehicle: true,
        }),
        ..settings
    }
}

fn ready(setup: Setup) -> Trial {
    let mut trial = Trial::with_under_way(setup);
    trial.feed(Input::Sonar(FromSonar::Event(SonarEvent::Ready(true))));
    trial
}

const fn set(tag: u64, sensor: i32, setting: SonarSetting) -> Request {
    Request::SonarSet(SonarSetRequest { tag, sensor, setting })
}

const fn range(tag: u64) -> Request {
    set(tag, 1, SonarSetting::RangeM(75.0))
}

fn log(tag: u64, on: bool) -> Request {
    Request::SonarLog(SonarLogRequest { tag, on, file: None })
}

fn told(trial: &Trial) -> Vec<(Timestamp, ToSonar)> {
    let of = |seen: &Seen| match seen {
        Seen::Sonar(order) => Some(order.clone()),
        _ => None,
    };
    trial
        .seen
        .iter()
        .filter_map(|(at, seen)| Some((*at, of(seen)?)))
        .collect()
}

fn orders(trial: &Trial) -> Vec<(u64, SonarOrder)> {
    let of = |order: ToSonar| match order {
        ToSonar::Order { request, order } => Some((request, order)),
        ToSonar::VehicleLogs(_) | ToSonar::Shutdown | ToSonar::Navigation(..) | ToSonar::SoundSpeed { .. } => None,
    };
    told(trial).into_iter().filter_map(|(_, order)| of(order)).collect()
}

fn outcome(trial: &mut Trial, request: u64, outcome: SonarOutcome) {
    trial.feed(Input::Sonar(FromSonar::Outcome { request, outcome }));
}

const fn ping(number: u32, sub_bottom: bool) -> SonarPing {
    SonarPing {
        sub_bottom,
        sensor: 1,
        number,
        time: Timestamp::ZERO,
        time_source: PingTime::Measured,
        decimation: Decimation::Maximum,
        channels: Vec::new(),
        navigation: None,
    }
}

#[test]
fn each_request_goes_to_the_client_and_has_the_outcome_that_it_reports() {
    let outcomes = [
        (SonarOutcome::Accepted, vec!["sent", "accepted", "ended"]),
        (SonarOutcome::Unconfirmed, vec!["sent", "ended"]),
        (SonarOutcome::Failed("rejected".to_owned()), vec!["sent", "failed"]),
        (SonarOutcome::TimedOut, vec!["sent", "timed out"]),
        (SonarOutcome::Lost, vec!["sent", "ended"]),
    ];
    for (reported, states) in outcomes {
        let mut trial = ready(setup(&[]));
        trial.ask(0, [range(1)]);
        trial.run_for(1.2);
        let [(request, order)] = &orders(&trial)[..] else {
            panic!("{:?}", orders(&trial));
        };
        let expected = SonarOrder::Set {
            sensor: 1,
            setting: SonarSetting::RangeM(75.0),
        };
        assert_eq!(order, &expected);
        outcome(&mut trial, *request, reported.clone());
        // A second outcome changes nothing.
        outcome(&mut trial, *request, SonarOutcome::TimedOut);
        trial.run_for(70.0);
        assert_eq!(shorts(&trial.states(1)), states, "{reported:?}");
        assert_eq!(trial.core.open_requests(), 0);
    }
}

#[test]
fn the_words_of_the_controller_come_with_the_failure() {
    let mut trial = ready(setup(&[]));
    trial.ask(0, [log(1, true)]);
    trial.run_for(1.2);
    let request = orders(&trial)[0].0;
    outcome(&mut trial, request, SonarOutcome::Failed("no disk".to_owned()));
    trial.run_for(1.2);
    let failed = RequestState::Failed(Failure::Sonar("no disk".to_owned()));
    assert_eq!(trial.states(1).last(), Some(&failed));
}

#[test]
fn without_an_outcome_a_request_times_out_after_a_minute() {
    let mut trial = ready(setup(&[]));
    trial.ask(0, [range(1)]);
    trial.run_for(2.0);
    trial.ask(0, [log(2, true)]);
    trial.run_for(57.0);
    assert_eq!(shorts(&trial.states(1)), ["sent"]);
    trial.run_for(2.5);
    assert_eq!(shorts(&trial.states(1)), ["sent", "timed out"]);
    assert_eq!(shorts(&trial.states(2)), ["sent"]);
    trial.run_for(3.0);
    assert_eq!(shorts(&trial.states(2)), ["sent", "timed out"]);
}

#[test]
fn requests_need_the_grant_the_table_a_sensor_and_a_client_that_is_ready() {
    let mut no_grant = setup(&[]);
    no_grant.plugins[0].grants.retain(|grant| *grant != Grant::Sonar);
    let no_table = Setup {
        settings: settings(),
        ..setup(&[])
    };
    for (mut trial, request, text) in [
        (ready(no_grant), range(1), "does not grant `sonar`"),
        (ready(no_table), range(1), "the mission has no [sonar]"),
        (
            Trial::with_under_way(setup(&[])),
            range(1),
            "the payload controller is not connected",
        ),
        (
            ready(setup(&[])),
            set(1, 2, SonarSetting::Ping(true)),
            "no [[sonar.sensor]] of this index",
        ),
        (
            ready(setup(&[])),
            set(1, 3, SonarSetting::PowerPercent(100.1)),
            "power of a sonar is 100.1; expected 0 to 100 %",
        ),
        (
            ready(setup(&[])),
            set(1, 3, SonarSetting::RangeM(f64::NAN)),
            "range of a sonar",
        ),
        (
            ready(setup(&[])),
            set(1, 3, SonarSetting::PeriodMs(0.0)),
            "period of a sonar",
        ),
    ] {
        trial.ask(0, [request]);
        trial.run_for(1.2);
        assert!(trial.rejection(1).contains(text), "{}", trial.rejection(1));
        assert!(orders(&trial).is_empty());
    }
}

#[test]
fn a_runtime_that_is_not_armed_changes_nothing_at_the_sonars() {
    let mut unarmed = setup(&[]);
    unarmed.start.armed = false;
    let mut trial = ready(unarmed);
    trial.ask(0, [range(1)]);
    let created = trial.vehicle.clock(trial.now);
    trial.hear_now([FromVehicle::from(LoggingBegin {
        created,
        text: Text::cleaned("line 1"),
    })]);
    trial.run_for(1.2);
    assert!(trial.rejection(1).contains("not armed"), "{}", trial.rejection(1));
    assert!(
        !told(&trial)
            .iter()
            .any(|(_, order)| matches!(order, ToSonar::Order { .. } | ToSonar::VehicleLogs(_)))
    );
}

#[test]
fn the_sonars_need_no_control_and_outlive_the_link_to_the_vehicle() {
    let mut trial = ready(setup(&[]));
    trial.operator(Operator::Hold);
    trial.ask(0, [range(1)]);
    trial.run_for(1.2);
    let request = orders(&trial)[0].0;
    trial.unreachable = true;
    trial.cut();
    trial.run_for(5.0);
    assert_eq!(shorts(&trial.states(1)), ["sent"]);
    outcome(&mut trial, request, SonarOutcome::Accepted);
    trial.run_for(1.0);
    assert_eq!(
        trial.states(1).last(),
        Some(&RequestState::Ended(EndCause::Done.into()))
    );
}

#[test]
fn at_most_32_requests_wait_for_their_outcome() {
    let mut trial = ready(setup(&[]));
    for tag in 0..40 {
        trial.ask(0, [range(tag)]);
        trial.run_for(1.0);
    }
    assert_eq!(orders(&trial).len(), 32);
    assert!(trial.rejection(32).contains("too many requests"));
}

#[test]
fn pings_reach_the_plugin_that_they_are_for_if_it_asked_for_their_topic() {
    let mut trial = ready(setup(&[Topic::Sidescan]));
    trial.feed(Input::Sonar(FromSonar::Ping(PluginId(0), ping(1, false))));
    trial.feed(Input::Sonar(FromSonar::Ping(PluginId(0), ping(2, true))));
    trial.feed(Input::Sonar(FromSonar::Ping(PluginId(1), ping(3, false))));
    trial.feed(Input::Sonar(FromSonar::Ping(PluginId(7), ping(4, false))));
    trial.run_for(1.2);
    let pings = |trial: &Trial, plugin| -> Vec<Event> {
        let events = trial.events(plugin);
        let is_ping = |event: &Event| matches!(event, Event::Sidescan(_) | Event::SubBottom(_));
        events.into_iter().filter(is_ping).collect()
    };
    assert_eq!(pings(&trial, 0), [Event::Sidescan(ping(1, false))]);
    assert_eq!(pings(&trial, 1), []);
}

#[test]
fn a_plugin_that_is_slower_than_its_pings_gets_the_newest_and_does_not_fail() {
    let mut trial = ready(setup(&[Topic::Sidescan, Topic::SubBottom]));
    trial.script(0, |_| (Duration::from_secs(4), Ok(Vec::new())));
    trial.run_for(1.5);
    for number in 0..1000 {
        trial.feed(Input::Sonar(FromSonar::Ping(
            PluginId(0),
            ping(number, number % 2 == 1),
        )));
    }
    trial.run_for(6.0);
    let numbers: Vec<u32> = trial
        .events(0)
        .iter()
        .filter_map(|event| match event {
            Event::Sidescan(ping) | Event::SubBottom(ping) => Some(ping.number),
            _ => None,
        })
        .collect();
    let newest: Vec<u32> = (1000 - PINGS_MAX as u32..1000).collect();
    assert_eq!(numbers, newest);
    let failed = |(_, note): &(Timestamp, Note)| matches!(note, Note::PluginFailed { .. });
    assert!(!trial.notes().iter().any(failed));
}

#[test]
fn reports_reach_the_plugins_that_asked_for_them_and_lines_the_log() {
    let mut trial = ready(setup(&[Topic::Sonar]));
    trial.feed(Input::Sonar(FromSonar::Event(SonarEvent::ControllerShutdown)));
    trial.feed(Input::Sonar(FromSonar::Line("alarm: disk full".to_owned())));
    trial.run_for(1.2);
    assert!(trial.events(0).contains(&Event::Sonar(SonarEvent::ControllerShutdown)));
    assert!(!trial.events(1).iter().any(|event| matches!(event, Event::Sonar(_))));
    let line = trial.notes().into_iter().find_map(|(_, note)| match note {
        Note::Sonar { .. } => Some(note.to_string()),
        _ => None,
    });
    assert_eq!(line.as_deref(), Some("sonar: alarm: disk full"));
}

fn last_status(trial: &Trial) -> (bool, String) {
    match trial.commands("STS").pop() {
        Some((_, ToVehicle::PayloadStatus(status))) => (status.ok, status.text.as_str().to_owned()),
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_payloads_status_says_how_the_sonars_are_and_fails_if_the_mission_says_so() {
    let mut setup = setup(&[]);
    setup.settings.status_failed_when = vec![StatusCondition::SonarAlarm, StatusCondition::SonarNotReady];
    let mut trial = Trial::with_under_way(setup);
    trial.run_for(1.5);
    assert_eq!(last_status(&trial), (false, "has control; sonar not ready".to_owned()));
    trial.feed(Input::Sonar(FromSonar::Event(SonarEvent::Ready(true))));
    for (conditions, ok) in [
        (vec![], true),
        (vec![StatusCondition::SonarAlarm], false),
        (vec![StatusCondition::SonarUnhealthy], true),
    ] {
        trial.feed(Input::Sonar(FromSonar::Status {
            text: "sonar ready; logging on".to_owned(),
            conditions,
        }));
        trial.run_for(1.5);
        assert_eq!(
            last_status(&trial),
            (ok, "has control; sonar ready; logging on".to_owned())
        );
    }
    // A text of any length and language stays a short one.
    trial.feed(Input::Sonar(FromSonar::Status {
        text: "ü".repeat(500),
        conditions: vec![],
    }));
    trial.run_for(1.5);
    assert!(last_status(&trial).1.len() <= 100, "{:?}", last_status(&trial));
}

#[test]
fn without_sonars_the_payloads_status_does_not_name_them_and_nothing_is_told() {
    let mut trial = Trial::under_way();
    trial.run_for(3.0);
    assert_eq!(last_status(&trial), (true, "has control".to_owned()));
    assert!(told(&trial).is_empty());
}

#[test]
fn the_vehicle_switches_logging_unless_the_mission_says_otherwise() {
    for follows in [true, false] {
        let mut setup = setup(&[]);
        setup.settings.sonar = Some(SonarSetup {
            sensors: vec![1],
            log_with_vehicle: follows,
        });
        let mut trial = ready(setup);
        let text = Text::cleaned("line 1");
        let created = trial.vehicle.clock(trial.now);
        trial.hear_now([FromVehicle::from(LoggingBegin {
            created,
            text: text.clone(),
        })]);
        trial.run_for(1.0);
        let created = trial.vehicle.clock(trial.now);
        trial.hear_now([FromVehicle::from(LoggingEnd { created, text })]);
        let switched: Vec<bool> = told(&trial)
            .into_iter()
            .filter_map(|(_, order)| match order {
                ToSonar::VehicleLogs(on) => Some(on),
                _ => None,
            })
            .collect();
        assert_eq!(switched, if follows { vec![true, false] } else { vec![] });
    }
}

#[test]
fn sr_011_the_payload_controller_is_shut_down_before_the_power_goes() {
    let mut trial = ready(setup(&[]));
    let created = trial.vehicle.clock(trial.now);
    let heard = trial.now;
    trial.hear_now([FromVehicle::from(Shutdown { created })]);
    trial.hear_now([FromVehicle::from(Shutdown { created })]);
    let shutdowns: Vec<Timestamp> = told(&trial)
        .into_iter()
        .filter(|(_, order)| *order == ToSonar::Shutdown)
        .map(|(at, _)| at)
        .collect();
    assert_eq!(shutdowns, [heard]);
    trial.ask(0, [range(1)]);
    trial.run_for(1.2);
    assert!(trial.rejection(1).contains("power"), "{}", trial.rejection(1));
}

#[test]
fn each_solution_of_the_vehicle_goes_to_the_controller_once() {
    let mut trial = ready(setup(&[]));
    trial.seen.clear();
    trial.run_for(10.0);
    let solutions: Vec<(Timestamp, bool)> = told(&trial)
        .into_iter()
        .filter_map(|(_, order)| match order {
            ToSonar::Navigation(sample, rates) => Some((sample.solution, rates.is_some())),
            _ => None,
        })
        .collect();
    let heard = trial.steps(0).len();
    assert!(solutions.len() >= 10 && heard > 0, "{}", solutions.len());
    assert!(
        solutions.windows(2).all(|pair| pair[0].0 < pair[1].0),
        "each once, in order"
    );
    assert!(solutions.iter().all(|(_, rates)| *rates));

    // Without its BFNVR, a BFNVG goes when the next one comes.
    trial.seen.clear();
    trial.way = Some(Box::new(|bytes| {
        let text = String::from_utf8(bytes).unwrap();
        let kept: Vec<&str> = text
            .split_inclusive('\n')
            .filter(|line| !line.starts_with("$BFNVR"))
            .collect();
        kept.concat().into_bytes()
    }));
    trial.run_for(5.0);
    let bare = told(&trial)
        .into_iter()
        .filter(|(_, order)| matches!(order, ToSonar::Navigation(_, None)))
        .count();
    assert!(bare >= 3, "{bare}");
}

#[test]
fn the_vehicles_speed_of_sound_is_subscribed_and_goes_to_the_controller() {
    let mut trial = ready(setup(&[]));
    assert!(
        trial.vehicle.subscribed.contains("SVS"),
        "{:?}",
        trial.vehicle.subscribed
    );
    for velocity in [1487.5, 0.0] {
        let created = trial.vehicle.clock(trial.now);
        trial.hear_now([FromVehicle::from(SoundVelocity {
            created,
            sound_velocity_mps: velocity,
        })]);
    }
    let speeds: Vec<f64> = told(&trial)
        .into_iter()
        .filter_map(|(_, order)| match order {
            ToSonar::SoundSpeed { sound_speed_mps, .. } => Some(sound_speed_mps),
            _ => None,
        })
        .collect();
    assert_eq!(speeds, [1487.5]);
}
