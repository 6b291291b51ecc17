//! Connects, says everything in its order, and connects again.

use std::time::Duration;

use backseat_s7k::SensorIndex;
use backseat_s7k::plc::{CommandId, Generic};
use backseat_sonar::{Event, LoggingSetup, Order, SensorConfig, SonarConfig, Ticket};
use backseat_units::Timestamp;

use crate::controller::Answer;
use crate::trial::{Trial, config};

/// Every command of a new connection: number, target, text.
const SEQUENCE: [&str; 13] = [
    r#"11 -1 "1""#,
    r#"20 -1 "2026/11/23, 14:05:07.03000""#,
    r#"28 -1 "1""#,
    r#"4 -1 """#,
    r#"14 -1 """#,
    r#"15 -1 """#,
    r#"7 -1 "0, 3000""#,
    r#"7 -1 "1, 3001""#,
    r#"26 -1 """#,
    r#"18 -1 """#,
    r#"25 -1 """#,
    r#"21 -1 """#,
    // Ten seconds later.
    r#"21 -1 """#,
];

#[test]
fn a_new_connection_is_said_everything_in_order() {
    let mut trial = Trial::new();
    trial.run_s(11.0);

    let heard: Vec<String> = trial
        .controller
        .heard
        .iter()
        .map(|line| line.replace(",14:", ", 14:"))
        .collect();
    assert_eq!(heard, SEQUENCE);
    assert_eq!(
        trial.log(),
        [
            "connected to the payload controller",
            "the payload controller's clock is +0.000 s from ours (within 0.010 s)",
            "the payload controller has version 1.02.03",
            "1 sensor modules; EdgeTech.dll 1.01.00",
            "2 sensors; 0 LF sidescan; 1 SBP",
            "log files of 100 MB with 10 records of overlap in D:\\log",
            "logging is off",
            "health; sensor 0 healthy; sensor 1 healthy",
            "the payload controller is ready",
        ]
    );
}

#[test]
fn the_settings_of_a_sensor_are_said_before_it_pings() {
    let mut settings = config();
    settings.sensor[0] = SensorConfig {
        range_m: Some(75.0),
        pulse: Some("FM 4-24 kHz 10 ms".to_owned()),
        power_percent: Some(80.0),
        gain: Some(-3),
        period_ms: Some(200.0),
        ping: Some(true),
        ..settings.sensor[0].clone()
    };
    let mut trial = Trial::with(settings, Vec::new());
    trial.run_s(5.0);
    let set: Vec<&str> = trial
        .controller
        .heard
        .iter()
        .map(String::as_str)
        .filter(|line| line.starts_with("0 "))
        .collect();
    assert_eq!(
        set,
        [
            r#"0 0 "Range = 75.00""#,
            r#"0 0 "Pulse = FM 4-24 kHz 10 ms""#,
            r#"0 0 "TxPower = 80.00""#,
            r#"0 0 "RxGain = -3""#,
            r#"0 0 "Duration = 200.00""#,
            r#"0 0 "Ping = 1""#,
        ]
    );
}

#[test]
fn a_setting_that_is_rejected_is_said_again_with_each_health_check_until_an_order_changes_it() {
    let mut settings = config();
    settings.sensor[0].range_m = Some(75.0);
    settings.sensor[0].ping = Some(true);
    let mut trial = Trial::with(settings, Vec::new());
    trial.controller.answer(CommandId::Generic, [Answer::Rejected; 6]);
    trial.run_s(25.0);
    let count = |trial: &Trial, text: &str| trial.controller.heard.iter().filter(|line| line.contains(text)).count();
    assert_eq!((count(&trial, "Range = 75"), count(&trial, "Ping = 1")), (3, 3));
    // While it may be starting, that is said once; a value that it rejects for longer is named.
    let told = trial.log();
    let told = told
        .iter()
        .filter(|line| line.contains("sensor 0 is starting") || line.contains("setting"));
    assert_eq!(
        told.collect::<Vec<_>>(),
        [
            "sensor 0 is starting; its settings are sent again every 10 s",
            "setting \"Range = 75.00\" for sensor 0 rejected; it is sent again with each health check; look at the value",
            "setting \"Ping = 1\" for sensor 0 rejected; it is sent again with each health check; look at the value",
        ]
    );
    trial.handle(backseat_sonar::Input::Order(
        Ticket(7),
        Order::Set {
            sensor: SensorIndex(0),
            setting: Generic::Range { range_m: 50.0 },
        },
    ));
    trial.run_s(30.0);
    assert_eq!(count(&trial, "Range = 75"), 3);
    assert_eq!(count(&trial, "Range = 50"), 1);
    assert_eq!(count(&trial, "Ping = 1"), 4);
}

#[test]
fn settings_change_what_is_said() {
    let settings = SonarConfig {
        time_sync: false,
        time_messages: false,
        route_to: Some(1),
        logging: Some(LoggingSetup {
            file_size: 200,
            overlap: 5,
        }),
        sensor: Vec::new(),
        ..config()
    };
    let mut trial = Trial::with(settings, Vec::new());
    trial.run_s(2.0);

    let heard = &trial.controller.heard;
    assert_eq!(heard[..2], [r#"11 -1 "1""#, r#"28 -1 "0""#]);
    let behind = [r#"15 -1 """#, r#"24 -1 "1""#, r#"26 -1 "200, 5""#, r#"26 -1 """#];
    assert!(heard.windows(4).any(|window| window == behind), "{heard:?}");
}

#[test]
fn a_configured_sensor_that_is_not_loaded_is_reported() {
    let mut settings = config();
    settings.sensor[1].index = 4;
    let mut trial = Trial::with(settings, Vec::new());
    trial.run_s(2.0);
    assert!(trial.has("sensor 4 is configured and not loaded"));
}

#[test]
fn pauses_between_attempts_double_up_to_a_minute() {
    let mut trial = Trial::new();
    trial.reachable = false;
    // The first attempt was under way when the test began.
    trial.cut();
    trial.run_s(300.0);

    let pauses: Vec<f64> = trial
        .connects
        .windows(2)
        .map(|pair| pair[1].since(pair[0]).as_secs_f64().round())
        .collect();
    assert_eq!(pauses, [1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 60.0, 60.0, 60.0]);
    trial.reachable = true;
    trial.run_s(70.0);
    assert!(trial.sonar.is_ready());
    // A connection that became ready begins the pauses anew.
    trial.cut();
    let before = trial.connects.len();
    trial.run_s(1.5);
    assert_eq!(trial.connects.len(), before + 1);
}

#[test]
fn a_connection_lost_in_the_middle_of_any_command_begins_anew() {
    for (number, command) in SEQUENCE[..12].iter().enumerate() {
        let mut trial = Trial::new();
        while trial.controller.heard.len() <= number {
            trial.run_s(0.005);
        }
        trial.cut();
        trial.controller.heard.clear();
        trial.run_s(4.0);

        assert!(trial.sonar.is_ready(), "after {command}");
        assert_eq!(
            trial.controller.heard.len(),
            12,
            "after {command}: {:?}",
            trial.controller.heard
        );
        assert_eq!(trial.controller.heard[0], SEQUENCE[0]);
        assert_eq!(trial.connects.len(), 2);
        let ready = trial.events.iter().filter(|(_, event)| *event == Event::Ready).count();
        assert_eq!(ready, 1);
    }
}

#[test]
fn a_connection_that_breaks_before_it_is_ready_does_not_begin_the_pauses_anew() {
    let mut trial = Trial::new();
    let mut pauses = Vec::new();
    for _ in 0..4 {
        trial.run_s(0.03);
        let cut = trial.now;
        trial.cut();
        while trial.connects.last().is_none_or(|at| *at < cut) {
            trial.run_s(0.1);
        }
        pauses.push(trial.connects.last().unwrap().since(cut).as_secs_f64());
    }
    assert_eq!(pauses, [1.0, 2.0, 4.0, 8.0]);
}

#[test]
fn a_controller_that_stops_answering_is_reset() {
    let mut trial = Trial::ready();
    trial
        .controller
        .always
        .insert(CommandId::Health.code(), Answer::Nothing);
    trial.run_s(18.0);

    // Asked after 10 s, three times within 3 s each.
    assert_eq!(trial.disconnects.len(), 1);
    let asked = trial
        .controller
        .heard
        .iter()
        .filter(|line| line.starts_with("21"))
        .count();
    assert_eq!(asked, 3);
    assert!(
        trial.has(
            "no connection to the payload controller at 127.0.0.1:7000: it does not answer; next attempt in 1.0 s"
        )
    );
    // The new connection cannot become ready, so the pause grows.
    trial.run_s(20.0);
    assert!(trial.has("next attempt in 2.0 s"));
}

#[test]
fn a_controller_that_says_that_it_shuts_down_is_left_alone_for_a_minute() {
    use backseat_s7k::record::{AlarmMode, MessageType};
    let mut trial = Trial::ready();
    let status = crate::controller::message(
        backseat_s7k::Time7k::NONE,
        MessageType::Status,
        AlarmMode::Unspecified,
        7,
        "",
    );
    trial.send(status.clone());
    trial.send(status);
    trial.run_s(0.1);
    trial.cut();
    trial.reachable = false;
    let connects = trial.connects.len();
    trial.run_s(59.0);
    assert_eq!(trial.connects.len(), connects);
    trial.run_s(2.0);
    assert_eq!(trial.connects.len(), connects + 1);
    let told = trial
        .events
        .iter()
        .filter(|(_, event)| *event == Event::ControllerShutdown)
        .count();
    assert_eq!(told, 1);
    assert!(trial.has("it has shut down; next attempt in 60.0 s"));
}

#[test]
fn the_controllers_clock_is_measured_from_acknowledgements_and_time_messages() {
    let settings = SonarConfig {
        time_sync: false,
        ..config()
    };
    let mut trial = Trial::with(settings, Vec::new());
    trial.controller.offset_nanos = -3_600_500_000_000;
    trial.run_s(2.0);
    assert!(trial.has("the payload controller's clock is -3600.500 s from ours (within 0.010 s)"));
    // Its clock is set: a time message shows it at once.
    trial.events.clear();
    trial.controller.offset_nanos = 2_000_000_000;
    let time = trial.controller.time(crate::trial::utc(trial.now));
    let header = backseat_s7k::FrameHeader::new(7400, backseat_s7k::DeviceId::UNSPECIFIED).at(time);
    trial.send(crate::controller::framed(header, &[0; 16]));
    trial.run_s(0.1);
    assert!(
        trial.has("the payload controller's clock is +1.990 s from ours at least"),
        "{:?}",
        trial.log()
    );
    // The next acknowledgement is better.
    trial.run_s(10.0);
    trial.controller.offset_nanos = 4_000_000_000;
    trial.run_s(10.0);
    assert!(trial.has("the payload controller's clock is +4.000 s from ours (within 0.010 s)"));
}

#[test]
fn the_time_is_set_again_if_our_clock_is_set() {
    let mut trial = Trial::ready();
    trial.handle(backseat_sonar::Input::UtcSet(3_600_000_000_000));
    trial.run_s(1.0);
    assert_eq!(trial.controller.heard.len(), 1);
    assert!(
        trial.controller.heard[0].contains("15:05:09"),
        "{:?}",
        trial.controller.heard
    );
}

#[test]
fn a_driver_that_confuses_connections_is_counted_and_survived() {
    let mut trial = Trial::ready();
    trial.handle(backseat_sonar::Input::Connected);
    assert_eq!(trial.sonar.counts().unexpected_inputs, 1);
    trial.cut();
    trial.handle(backseat_sonar::Input::Lost);
    trial.handle(backseat_sonar::Input::Received(b"late bytes"));
    assert_eq!(trial.sonar.counts().unexpected_inputs, 2);
    trial.run_s(3.0);
    assert!(trial.sonar.is_ready());
}

#[test]
fn a_client_at_the_end_of_time_does_not_spin() {
    let mut trial = Trial::ready();
    trial.sonar.handle(Timestamp::MAX, backseat_sonar::Input::Timeout);
    while trial.sonar.poll_output().is_some() {}
    assert_eq!(trial.sonar.poll_timeout(), None);
    trial
        .sonar
        .handle(Timestamp::MAX - Duration::from_secs(1), backseat_sonar::Input::Timeout);
}
