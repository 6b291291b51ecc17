//! Acknowledgements that are lost, late, out of order, or say no.

use backseat_s7k::SensorIndex;
use backseat_s7k::plc::{CommandId, Generic};
use backseat_s7k::record::CommandStatus;
use backseat_sonar::{Order, Outcome};

use crate::controller::{Answer, acknowledgement};
use crate::trial::Trial;

fn range(range_m: f64) -> Order {
    Order::Set {
        sensor: SensorIndex(0),
        setting: Generic::Range { range_m },
    }
}

fn sent(trial: &Trial, id: u32) -> usize {
    let prefix = format!("{id} ");
    trial
        .controller
        .heard
        .iter()
        .filter(|line| line.starts_with(&prefix))
        .count()
}

#[test]
fn statuses_and_acknowledgements_come_in_any_order() {
    let mut trial = Trial::new();
    for id in [4, 14, 15, 26, 18, 21] {
        trial.controller.always.insert(id, Answer::StatusFirst);
    }
    trial.run_s(2.0);
    assert!(trial.sonar.is_ready());
    assert_eq!(trial.controller.heard.len(), 12);
    assert_eq!(trial.sonar.counts().late_acknowledgements, 0);
}

#[test]
fn a_lost_acknowledgement_is_made_up_for_by_the_status() {
    let mut trial = Trial::new();
    trial.controller.answer(CommandId::Version, [Answer::StatusOnly]);
    trial.run_s(2.9);
    assert!(!trial.sonar.is_ready());
    trial.run_s(1.0);
    assert!(trial.sonar.is_ready());
    assert_eq!(sent(&trial, 4), 1, "the status proves that the command arrived");
}

#[test]
fn an_unanswered_command_is_sent_again_and_then_the_connection_is_reset() {
    let mut trial = Trial::new();
    trial
        .controller
        .answer(CommandId::Subscribe, [Answer::Nothing, Answer::Nothing]);
    trial.run_s(7.0);
    assert!(trial.sonar.is_ready());
    assert_eq!((sent(&trial, 7), trial.disconnects.len()), (4, 0));

    let mut trial = Trial::new();
    trial.controller.answer(CommandId::Subscribe, [Answer::Nothing; 3]);
    trial.run_s(12.0);
    assert_eq!(trial.disconnects.len(), 1);
    assert!(trial.has("command Subscribe for sensor 0 not answered"));
    assert!(trial.sonar.is_ready(), "the second connection works");
}

#[test]
fn an_acknowledgement_without_its_status_is_asked_for_again_and_resets_nothing() {
    let mut trial = Trial::new();
    trial
        .controller
        .always
        .insert(CommandId::Modules.code(), Answer::AcknowledgementOnly);
    trial.run_s(11.0);
    assert!(trial.sonar.is_ready());
    assert_eq!((sent(&trial, 14), trial.disconnects.len()), (3, 0));
    assert!(trial.has("command Modules acknowledged without an answer"));
}

#[test]
fn a_no_stops_nothing_else() {
    let mut trial = Trial::new();
    trial.controller.answer(CommandId::Subscribe, [Answer::Rejected]);
    trial.controller.answer(CommandId::TimeMessages, [Answer::Unknown]);
    trial.run_s(2.0);
    assert!(trial.sonar.is_ready());
    assert!(trial.has("command TimeMessages unknown to the controller"));
    assert!(trial.has("command Subscribe for sensor 0 rejected"));
    assert_eq!(sent(&trial, 7), 2, "a no is not asked for again");
}

#[test]
fn the_second_acknowledgement_of_a_repeated_command_does_not_count_for_the_next_one() {
    let mut trial = Trial::ready();
    // The first range is acknowledged after 4 s; it was sent again after 3 s, and that is acknowledged after 7.
    trial.controller.answer(
        CommandId::Generic,
        [Answer::After(4000), Answer::After(4000), Answer::Rejected],
    );
    let first = trial.order(range(50.0));
    trial.run_s(5.0);
    assert_eq!(trial.outcome(first), Outcome::Accepted { details: None });
    // The acknowledgement that is owed comes before that of the second range, and must not accept it.
    let second = trial.order(range(75.0));
    trial.run_s(1.0);
    assert!(trial.outcomes(second).is_empty(), "{:?}", trial.outcomes(second));
    trial.run_s(8.0);
    let late = trial.sonar.counts().late_acknowledgements;
    assert!(late >= 1);
    assert_eq!(trial.outcomes(second).len(), 1);
    assert_eq!(trial.disconnects.len(), 0);
}

#[test]
fn an_acknowledgement_that_is_owed_and_never_comes_costs_one_sending() {
    let mut trial = Trial::ready();
    trial
        .controller
        .answer(CommandId::Generic, [Answer::Nothing, Answer::Normal]);
    let first = trial.order(range(50.0));
    trial.run_s(4.0);
    assert_eq!(trial.outcome(first), Outcome::Accepted { details: None });
    trial.controller.heard.clear();
    let second = trial.order(range(75.0));
    trial.run_s(4.0);
    assert_eq!(trial.outcome(second), Outcome::Accepted { details: None });
    assert_eq!(sent(&trial, 0), 2);
    // After ten seconds nothing is owed.
    trial.run_s(20.0);
    trial.controller.heard.clear();
    let third = trial.order(range(80.0));
    trial.run_s(1.0);
    assert_eq!(trial.outcome(third), Outcome::Accepted { details: None });
    assert_eq!(sent(&trial, 0), 1);
}

#[test]
fn acknowledgements_of_commands_that_were_not_sent_are_counted() {
    let mut trial = Trial::ready();
    let ticket = {
        trial.controller.always.insert(0, Answer::Nothing);
        trial.order(range(50.0))
    };
    let foreign =
        |command, sensor, status| acknowledgement(backseat_s7k::Time7k::NONE, command, SensorIndex(sensor), status);
    // Another sensor, another command, a command that does not exist, a status that does not exist.
    trial.send(foreign(CommandId::Generic, 1, CommandStatus::Accepted));
    trial.send(foreign(CommandId::Logging, 0, CommandStatus::Accepted));
    trial.send(foreign(CommandId::Other(99), 0, CommandStatus::Accepted));
    trial.send(foreign(CommandId::Generic, 0, CommandStatus::Other(7)));
    trial.run_s(0.1);
    assert_eq!(trial.sonar.counts().late_acknowledgements, 4);
    assert!(trial.outcomes(ticket).is_empty());
    trial.send(foreign(CommandId::Generic, 0, CommandStatus::Unknown));
    trial.run_s(0.1);
    assert_eq!(trial.outcome(ticket), Outcome::Unknown);
}

#[test]
fn a_controller_may_name_the_sensor_of_a_subscription_in_its_acknowledgement() {
    let mut trial = Trial::new();
    trial
        .controller
        .always
        .insert(CommandId::Subscribe.code(), Answer::Nothing);
    for _ in 0..400 {
        trial.run_s(0.005);
        if let Some(line) = trial.controller.heard.last().filter(|line| line.starts_with("7 ")) {
            let sensor = if line.contains("\"0") { 0 } else { 1 };
            trial.send(acknowledgement(
                backseat_s7k::Time7k::NONE,
                CommandId::Subscribe,
                SensorIndex(sensor),
                CommandStatus::Accepted,
            ));
        }
    }
    assert!(trial.sonar.is_ready());
    assert_eq!(sent(&trial, 7), 2);
}

#[test]
fn an_answer_at_the_last_instant_is_in_time_and_rushes_nothing() {
    let mut trial = Trial::new();
    // With the link's delays it comes back exactly three seconds after the command.
    trial.controller.answer(CommandId::Subscribe, [Answer::After(2980)]);
    trial.run_s(4.0);
    assert!(trial.sonar.is_ready());
    assert_eq!(sent(&trial, 7), 2, "{:?}", trial.controller.heard);
    assert_eq!(trial.sonar.counts().late_acknowledgements, 0);
}
