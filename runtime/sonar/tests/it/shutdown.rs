//! The vehicle is about to cut the power: logging stops, the controller shuts down, all within ten seconds.

use std::time::Duration;

use backseat_s7k::SensorIndex;
use backseat_s7k::plc::{CommandId, Generic};
use backseat_sonar::{FileDetails, Order, Outcome, ShutdownKind, SonarConfig, Ticket};
use backseat_units::Timestamp;

use crate::controller::Answer;
use crate::trial::{Trial, config};

const TEN_SECONDS: Duration = Duration::from_secs(10);

fn shut_down(trial: &mut Trial) -> (Ticket, Timestamp) {
    let at = trial.now;
    (trial.order(Order::Shutdown), at)
}

fn ends_in_time(trial: &Trial, at: Timestamp) {
    let finished = trial.finished.expect("the client ends");
    assert!(finished.since(at) < TEN_SECONDS, "{}", finished.since(at).as_secs_f64());
}

fn log_on(trial: &mut Trial) {
    trial.order(Order::Logging { on: true, file: None });
    trial.run_s(1.0);
    assert!(trial.controller.logging);
    trial.controller.heard.clear();
    trial.events.clear();
}

#[test]
fn logging_stops_first_and_then_the_controller() {
    let mut trial = Trial::ready();
    log_on(&mut trial);
    let (ticket, at) = shut_down(&mut trial);
    trial.run_s(60.0);
    assert_eq!(
        trial.controller.heard,
        [r#"1 -1 "0""#, r#"18 -1 """#, r#"13 -1 "0""#],
        "and the operating system stays"
    );
    let details = FileDetails {
        on: false,
        file: Box::from("D:\\log\\auto.s7k"),
        size_mb: 1.5,
    };
    assert_eq!(trial.outcome(ticket), Outcome::Accepted { details: Some(details) });
    assert_eq!(
        trial.log(),
        [
            "logging is off",
            "the payload controller is shutting down",
            "order 2: accepted: logging is off",
        ]
    );
    assert!(trial.finished.unwrap().since(at) < Duration::from_millis(100));
    assert_eq!(trial.connects.len(), 1, "nobody connects again");
}

#[test]
fn the_operating_system_shuts_down_too_if_it_is_set() {
    let settings = SonarConfig {
        shutdown: ShutdownKind::System,
        ..config()
    };
    let mut trial = Trial::with(settings, Vec::new()).until_ready();
    shut_down(&mut trial);
    trial.run_s(1.0);
    assert_eq!(trial.controller.heard.last().unwrap(), r#"13 -1 "1""#);
}

#[test]
fn a_controller_that_answers_nothing_is_told_everything_in_time() {
    let mut trial = Trial::ready();
    for id in [1, 13, 18] {
        trial.controller.always.insert(id, Answer::Nothing);
    }
    let (ticket, at) = shut_down(&mut trial);
    trial.run_s(20.0);
    let twice = [
        r#"1 -1 "0""#,
        r#"1 -1 "0""#,
        r#"18 -1 """#,
        r#"13 -1 "0""#,
        r#"13 -1 "0""#,
    ];
    assert_eq!(trial.controller.heard, twice);
    assert_eq!(trial.outcome(ticket), Outcome::TimedOut { sent: true });
    ends_in_time(&trial, at);
}

#[test]
fn a_controller_that_rejects_is_not_asked_again() {
    let mut trial = Trial::ready();
    trial.controller.answer(CommandId::Logging, [Answer::Rejected]);
    trial.controller.answer(CommandId::Shutdown, [Answer::Rejected]);
    let (ticket, at) = shut_down(&mut trial);
    trial.run_s(20.0);
    assert_eq!(trial.outcome(ticket), Outcome::Rejected);
    assert!(trial.has("command Logging rejected"));
    ends_in_time(&trial, at);
}

#[test]
fn a_controller_that_is_gone_with_the_acknowledgement_has_shut_down() {
    let mut trial = Trial::ready();
    trial.controller.tells_shutdown = false;
    let (ticket, _) = shut_down(&mut trial);
    trial.run_s(0.5);
    trial.cut();
    assert_eq!(
        trial.outcome(ticket),
        Outcome::Accepted {
            details: trial_details()
        }
    );
    assert!(trial.finished.is_some());

    // Without the connection's end, the client waits for the status twice as long as for any other.
    let mut trial = Trial::ready();
    trial.controller.tells_shutdown = false;
    let (ticket, at) = shut_down(&mut trial);
    trial.run_s(20.0);
    assert!(matches!(trial.outcome(ticket), Outcome::Accepted { .. }));
    ends_in_time(&trial, at);

    let mut trial = Trial::ready();
    trial
        .controller
        .always
        .insert(CommandId::Shutdown.code(), Answer::Nothing);
    let (ticket, _) = shut_down(&mut trial);
    trial.run_s(0.5);
    trial.cut();
    assert_eq!(trial.outcome(ticket), Outcome::Lost);
}

fn trial_details() -> Option<FileDetails> {
    Some(FileDetails {
        on: false,
        file: Box::from("D:\\log\\auto.s7k"),
        size_mb: 1.5,
    })
}

#[test]
fn without_a_connection_the_client_makes_one() {
    let mut trial = Trial::ready();
    log_on(&mut trial);
    // Two attempts fail, so that the next one is some seconds away.
    trial.reachable = false;
    trial.cut();
    trial.run_s(4.0);
    trial.reachable = true;
    trial.controller.heard.clear();
    let (ticket, at) = shut_down(&mut trial);
    trial.run_s(20.0);
    assert_eq!(
        trial.controller.heard,
        [r#"11 -1 "1""#, r#"1 -1 "0""#, r#"18 -1 """#, r#"13 -1 "0""#]
    );
    assert!(matches!(trial.outcome(ticket), Outcome::Accepted { .. }));
    ends_in_time(&trial, at);
}

#[test]
fn a_controller_that_cannot_be_reached_holds_nothing_up() {
    let mut trial = Trial::ready();
    trial.reachable = false;
    trial.cut();
    let (ticket, at) = shut_down(&mut trial);
    trial.run_s(60.0);
    assert_eq!(trial.outcome(ticket), Outcome::TimedOut { sent: false });
    ends_in_time(&trial, at);
    let attempts = trial.connects.iter().filter(|connect| **connect >= at).count();
    assert!((8..=10).contains(&attempts), "one a second: {attempts}");
}

#[test]
fn a_shutdown_comes_at_any_moment() {
    for millis in 0..400 {
        let mut trial = Trial::new();
        trial.run_s(f64::from(millis) / 1000.0);
        let order = trial.order(Order::Set {
            sensor: SensorIndex(0),
            setting: Generic::Ping { on: true },
        });
        let (ticket, at) = shut_down(&mut trial);
        trial.run_s(20.0);
        assert!(
            matches!(trial.outcome(ticket), Outcome::Accepted { .. }),
            "{millis}: {:?}",
            trial.log()
        );
        assert_eq!(trial.outcomes(order).len(), 1, "{millis}");
        assert!(trial.controller.shut_down && !trial.controller.logging, "{millis}");
        ends_in_time(&trial, at);
    }
}

#[test]
fn a_connection_that_breaks_before_the_command_is_made_again() {
    let mut trial = Trial::ready();
    trial
        .controller
        .always
        .insert(CommandId::Logging.code(), Answer::Nothing);
    let (ticket, at) = shut_down(&mut trial);
    trial.run_s(0.5);
    trial.controller.always.clear();
    trial.cut();
    trial.run_s(20.0);
    assert!(matches!(trial.outcome(ticket), Outcome::Accepted { .. }));
    assert!(trial.controller.shut_down);
    ends_in_time(&trial, at);
}

#[test]
fn nothing_else_is_ordered_during_a_shutdown_and_after_it() {
    let mut trial = Trial::ready();
    trial
        .controller
        .always
        .insert(CommandId::Logging.code(), Answer::Nothing);
    shut_down(&mut trial);
    let ping = || Order::Set {
        sensor: SensorIndex(0),
        setting: Generic::Ping { on: true },
    };
    for order in [ping(), Order::Shutdown] {
        let ticket = trial.order(order);
        let why = Box::from("the controller is being shut down");
        assert_eq!(trial.outcome(ticket), Outcome::Refused { why });
    }
    trial.run_s(20.0);
    assert!(trial.finished.is_some());
    assert_eq!(trial.sonar.poll_timeout(), None);
    trial.finished = None;
    let ticket = trial.order(ping());
    assert!(matches!(trial.outcome(ticket), Outcome::Refused { .. }));
    assert_eq!(trial.sonar.status_text(), "sonar shut down; logging off");
}
