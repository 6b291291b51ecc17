//! A controller that is told not to acknowledge.

use backseat_s7k::SensorIndex;
use backseat_s7k::plc::{CommandId, Generic};
use backseat_sonar::{Order, Outcome, SonarConfig};

use crate::controller::Answer;
use crate::trial::{Trial, config};

fn quiet() -> Trial {
    let settings = SonarConfig {
        verbose: false,
        ..config()
    };
    Trial::with(settings, Vec::new()).until_ready()
}

#[test]
fn the_client_becomes_ready_by_statuses_alone() {
    let trial = quiet();
    assert!(!trial.controller.verbose);
    assert_eq!(trial.connects.len(), 1);
}

#[test]
fn a_command_without_an_answer_is_not_confirmed_and_one_with_an_answer_is() {
    let mut trial = quiet();
    let set = trial.order(Order::Set {
        sensor: SensorIndex(0),
        setting: Generic::Range { range_m: 50.0 },
    });
    assert_eq!(trial.outcome(set), Outcome::Unconfirmed);
    let log = trial.order(Order::Logging { on: true, file: None });
    trial.run_s(1.0);
    assert!(matches!(trial.outcome(log), Outcome::Accepted { details: Some(_) }));
    trial
        .controller
        .always
        .insert(CommandId::Logging.code(), Answer::Nothing);
    let log = trial.order(Order::Logging { on: false, file: None });
    trial.run_s(1.0);
    assert!(matches!(trial.outcome(log), Outcome::Incomplete { details: Some(_) }));
}

#[test]
fn a_stalled_controller_is_noticed_by_its_health() {
    let mut trial = quiet();
    trial
        .controller
        .always
        .insert(CommandId::Health.code(), Answer::Nothing);
    trial.run_s(20.0);
    assert_eq!(trial.disconnects.len(), 1);
}

#[test]
fn a_shutdown_ends_with_the_status_or_without_a_word() {
    let mut trial = quiet();
    let ticket = trial.order(Order::Shutdown);
    trial.run_s(10.0);
    assert!(matches!(trial.outcome(ticket), Outcome::Accepted { .. }));

    let mut trial = quiet();
    trial.controller.tells_shutdown = false;
    let ticket = trial.order(Order::Shutdown);
    trial.run_s(10.0);
    assert_eq!(trial.outcome(ticket), Outcome::Unconfirmed);
}
