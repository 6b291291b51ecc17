//! Alarms: active, clear, known, unknown, malformed, and too many.

use backseat_s7k::plc::{Alarm, CommandId, FailureCause};
use backseat_s7k::record::{AlarmMode, MessageType};
use backseat_s7k::{SensorIndex, Time7k};
use backseat_sonar::{ALARMS_MAX, AlarmState, Condition, Event};

use crate::controller::{Answer, alarm, message};
use crate::trial::{Trial, config};

fn alarms(trial: &Trial) -> Vec<AlarmState> {
    let alarm = |event: &Event| match event {
        Event::Alarm { alarm } => Some(alarm.clone()),
        _ => None,
    };
    trial.events.iter().filter_map(|(_, event)| alarm(event)).collect()
}

fn unhealthy(sensor: i32) -> Alarm {
    Alarm::SensorUnhealthy {
        sensor: SensorIndex(sensor),
        description: Box::from("health check failed"),
    }
}

#[test]
fn an_alarm_is_typed_and_has_its_state() {
    let mut trial = Trial::ready();
    let failure = Alarm::SensorFailure {
        sensor: SensorIndex(1),
        cause: FailureCause::Temperature,
        code: -1,
        description: Box::from("transceiver at 61 degrees"),
    };
    trial.send(alarm(AlarmMode::Active, &failure));
    trial.send(alarm(AlarmMode::Active, &failure));
    trial.run_s(0.1);
    let active = AlarmState {
        id: 4,
        mode: AlarmMode::Active,
        sensor: Some(SensorIndex(1)),
        alarm: Some(failure.clone()),
        text: Box::from("1, 3, -1, transceiver at 61 degrees"),
    };
    assert_eq!(alarms(&trial), [active], "an alarm that is repeated is no news");
    assert_eq!(trial.sonar.conditions().collect::<Vec<_>>(), [Condition::Alarm]);
    assert_eq!(
        trial.sonar.status_text(),
        "sonar ready; logging off; alarm: sensor 1 reported a failure"
    );

    trial.send(alarm(AlarmMode::Clear, &failure));
    trial.run_s(0.1);
    assert_eq!(alarms(&trial).len(), 2);
    assert_eq!(alarms(&trial)[1].mode, AlarmMode::Clear);
    assert_eq!(trial.sonar.conditions().count(), 0);
}

#[test]
fn a_sensor_that_is_starting_raises_no_alarm_for_its_settings() {
    let mut settings = config();
    settings.sensor[0].range_m = Some(75.0);
    let mut trial = Trial::with(settings, Vec::new());
    trial.controller.answer(CommandId::Generic, [Answer::Rejected; 2]);
    let failed = |sensor| Alarm::SensorCommandFailed {
        sensor: SensorIndex(sensor),
        client: 0,
        description: Box::from("Range = 75.00: the sensor has not started"),
    };
    trial.run_s(5.0);
    trial.send(alarm(AlarmMode::Unspecified, &failed(0)));
    trial.send(alarm(AlarmMode::Unspecified, &failed(1)));
    trial.run_s(1.0);
    let of: Vec<_> = alarms(&trial).iter().map(|alarm| alarm.sensor).collect();
    assert_eq!(of, [Some(SensorIndex(1))], "sensor 1 has no setting that waits");
    trial.run_s(5.0);
    trial.send(alarm(AlarmMode::Unspecified, &failed(0)));
    trial.run_s(1.0);
    assert_eq!(alarms(&trial).len(), 2, "a sensor does not start for so long");
}

#[test]
fn all_clear_ends_every_alarm() {
    let mut trial = Trial::ready();
    for sensor in 0..3 {
        trial.send(alarm(AlarmMode::Active, &unhealthy(sensor)));
    }
    trial.send(alarm(AlarmMode::Unspecified, &Alarm::AllClear {}));
    trial.send(alarm(AlarmMode::Unspecified, &Alarm::AllClear {}));
    trial.run_s(0.1);
    assert_eq!((alarms(&trial).len(), trial.sonar.conditions().count()), (3, 0));
    let clear = trial.events.iter().filter(|(_, event)| *event == Event::AlarmsClear);
    assert_eq!(clear.count(), 1);
}

#[test]
fn active_alarms_are_asked_for_on_each_connection() {
    let mut trial = Trial::new();
    trial.controller.alarms = vec![(1, "8 % of D: left".to_owned()), (5, "0, hot".to_owned())];
    trial.run_s(2.0);
    assert_eq!(alarms(&trial).len(), 2);
    // One of them ended while there was no connection.
    trial.cut();
    trial.controller.alarms.truncate(1);
    trial.events.clear();
    trial.run_s(3.0);
    assert_eq!(alarms(&trial).len(), 1);
    assert_eq!(
        trial.sonar.status_text(),
        "sonar ready; logging off; alarm: disk space critical"
    );
}

#[test]
fn alarms_that_cannot_be_read_are_passed_on_as_they_are() {
    let mut trial = Trial::ready();
    let raw = |id: i32, mode, text: &str| message(Time7k::NONE, MessageType::Alarm, mode, id, text);
    trial.send(raw(10_007, AlarmMode::Active, "quality of sensor 0"));
    trial.send(raw(5, AlarmMode::Active, "no sensor here"));
    trial.send(raw(3, AlarmMode::Other(9), "0, 200, -1"));
    trial.run_s(0.1);
    let told = alarms(&trial);
    assert_eq!(told.len(), 3);
    assert_eq!((told[0].alarm.as_ref(), &*told[0].text), (None, "quality of sensor 0"));
    assert_eq!((told[1].alarm.as_ref(), told[1].sensor), (None, None));
    assert_eq!(told[2].alarm.as_ref().map(Alarm::name), Some("PingDropped"));
    assert_eq!(trial.sonar.counts().unknown_messages, 1);
    assert_eq!(trial.sonar.counts().malformed, 1);
    assert!(trial.has("SensorUnhealthy parameter sensor: expected a whole number"));
}

#[test]
fn an_endless_text_is_cut() {
    let mut trial = Trial::ready();
    let text = format!("1, {}", "hot ".repeat(500_000));
    trial.send(message(Time7k::NONE, MessageType::Alarm, AlarmMode::Active, 5, &text));
    trial.run_s(0.1);
    let told = &alarms(&trial)[0];
    assert_eq!((told.text.len(), told.sensor), (200, Some(SensorIndex(1))));
}

#[test]
fn a_flood_of_alarms_fills_neither_the_table_nor_the_log() {
    let mut trial = Trial::ready();
    for round in 0..20 {
        for sensor in 0..100 {
            let mode = if round % 2 == 0 {
                AlarmMode::Active
            } else {
                AlarmMode::Clear
            };
            trial.send(alarm(mode, &unhealthy(sensor)));
        }
        trial.run_s(0.1);
    }
    trial.send(alarm(AlarmMode::Active, &unhealthy(7)));
    trial.run_s(0.1);
    assert!(alarms(&trial).len() <= 64, "{}", alarms(&trial).len());
    trial.run_s(10.0);
    // What was not reported one by one is reported as it is in the end.
    let active = trial.events.iter().rev().find_map(|(_, event)| match event {
        Event::ActiveAlarms { alarms } => Some(alarms.len()),
        _ => None,
    });
    assert_eq!(active, Some(1));
    assert!(trial.sonar.counts().dropped_events > 1000);
    assert!(trial.has("events dropped"));

    for sensor in 0..1000 {
        trial.send(alarm(AlarmMode::Active, &unhealthy(sensor)));
    }
    trial.run_s(0.1);
    assert!(
        trial
            .sonar
            .status_text()
            .contains(&format!("and {} more", ALARMS_MAX - 1))
    );
}
