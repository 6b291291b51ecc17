//! The text for the payload's status, and the conditions that an operator may count as faults.

use backseat_s7k::SensorIndex;
use backseat_s7k::plc::Alarm;
use backseat_s7k::record::AlarmMode;
use backseat_sonar::{Condition, Order, STATUS_CHARS};

use crate::controller::alarm;
use crate::trial::Trial;

#[test]
fn the_status_follows_the_connection() {
    let mut trial = Trial::new();
    assert_eq!(trial.sonar.status_text(), "sonar connecting");
    trial.run_s(0.015);
    assert_eq!(trial.sonar.status_text(), "sonar starting");
    assert_eq!(trial.sonar.conditions().collect::<Vec<_>>(), [Condition::NotReady]);
    trial.run_s(2.0);
    assert_eq!(trial.sonar.status_text(), "sonar ready; logging off");
    assert_eq!(trial.sonar.conditions().count(), 0);
    trial.cut();
    assert_eq!(trial.sonar.status_text(), "sonar not connected; logging off");
}

#[test]
fn missing_logging_and_unhealthy_sensors_are_conditions() {
    let mut trial = Trial::ready();
    trial.controller.health = "Sensors: 2, 0, 1, 1, 0".to_owned();
    trial.run_s(10.0);
    assert_eq!(
        trial.sonar.status_text(),
        "sonar ready; logging off; sensor 1 unhealthy"
    );
    trial
        .controller
        .script
        .entry(1)
        .or_default()
        .push_back(crate::controller::Answer::Rejected);
    trial.order(Order::Logging { on: true, file: None });
    trial.run_s(1.0);
    assert_eq!(
        trial.sonar.conditions().collect::<Vec<_>>(),
        [Condition::Unhealthy, Condition::NotLogging]
    );
    assert_eq!(
        trial.sonar.status_text(),
        "sonar ready; logging missing; sensor 1 unhealthy"
    );
}

#[test]
fn the_status_is_short_and_has_no_words_of_the_controllers() {
    let mut trial = Trial::ready();
    trial.controller.health = format!(
        "Sensors: 200{}",
        (0..200).map(|index| format!(", {index}, 0")).collect::<String>()
    );
    for sensor in 0..40 {
        let description = Box::from("$BFCTL,081025.987,0*4E");
        let sensor = SensorIndex(sensor);
        trial.send(alarm(
            AlarmMode::Active,
            &Alarm::SensorDataFailed { sensor, description },
        ));
    }
    trial.run_s(11.0);
    let text = trial.sonar.status_text();
    assert!(text.len() <= STATUS_CHARS, "{text}");
    assert!(
        text.starts_with("sonar ready; logging off; alarm: sensor 0 failed to load data and 39 more"),
        "{text}"
    );
    assert!(
        text.bytes()
            .all(|byte| matches!(byte, b' '..=b'~') && !b",*$".contains(&byte)),
        "{text}"
    );
}
