//! Logging by orders, with its file, and restored after a loss of the connection.

use backseat_s7k::plc::CommandId;
use backseat_sonar::{FileDetails, Order, Outcome};

use crate::controller::Answer;
use crate::trial::Trial;

fn logging(on: bool, file: Option<&str>) -> Order {
    Order::Logging {
        on,
        file: file.map(Box::from),
    }
}

fn details(on: bool, file: &str) -> Option<FileDetails> {
    Some(FileDetails {
        on,
        file: Box::from(file),
        size_mb: 1.5,
    })
}

#[test]
fn logging_goes_on_with_its_file_and_off_again() {
    let mut trial = Trial::ready();
    let on = trial.order(logging(true, Some("line 3.s7k")));
    trial.run_s(1.0);
    assert_eq!(
        trial.controller.heard,
        [r#"1 -1 "1""#, r#"2 -1 "line 3.s7k""#, r#"18 -1 """#]
    );
    assert_eq!(
        trial.outcome(on),
        Outcome::Accepted {
            details: details(true, "D:\\log\\line 3.s7k")
        }
    );
    let off = trial.order(logging(false, None));
    trial.run_s(1.0);
    assert_eq!(
        trial.outcome(off),
        Outcome::Accepted {
            details: details(false, "D:\\log\\line 3.s7k")
        }
    );
    assert!(trial.has("logging to D:\\log\\line 3.s7k (1.500 MB)"));
    assert!(trial.log().last().unwrap().contains("accepted: logging is off"));
}

#[test]
fn the_file_changes_on_order_once() {
    let mut trial = Trial::ready();
    // The acknowledgement comes so late that another command would have been sent again.
    trial.controller.answer(CommandId::Switch, [Answer::After(5000)]);
    let ticket = trial.order(Order::SwitchFile {
        file: Box::from("Auto"),
    });
    trial.run_s(6.0);
    assert!(matches!(trial.outcome(ticket), Outcome::Accepted { details: Some(_) }));
    let switches = trial.controller.heard.iter().filter(|line| line.starts_with("2 "));
    assert_eq!(switches.count(), 1);
}

#[test]
fn every_end_of_an_order_to_log_is_told() {
    let cases: [(CommandId, Answer, Outcome); 5] = [
        (CommandId::Logging, Answer::Rejected, Outcome::Rejected),
        (CommandId::Logging, Answer::Unknown, Outcome::Unknown),
        (CommandId::Logging, Answer::Nothing, Outcome::TimedOut { sent: true }),
        (
            CommandId::Switch,
            Answer::Rejected,
            Outcome::Incomplete {
                details: details(true, "D:\\log\\auto.s7k"),
            },
        ),
        (
            CommandId::ReportLogging,
            Answer::Rejected,
            Outcome::Accepted { details: None },
        ),
    ];
    for (command, answer, outcome) in cases {
        let mut trial = Trial::ready();
        trial.controller.always.insert(command.code(), answer);
        let ticket = trial.order(logging(true, Some("line.s7k")));
        trial.run_s(9.5);
        assert_eq!(trial.outcome(ticket), outcome, "{command:?} {answer:?}");
    }
}

#[test]
fn an_accepted_order_that_the_controller_does_not_do_is_incomplete() {
    let mut trial = Trial::ready();
    trial.controller.answer(CommandId::Logging, [Answer::Normal]);
    let ticket = trial.order(logging(true, None));
    // Between the acknowledgement and the report something stops it.
    trial.run_s(0.015);
    trial.controller.logging = false;
    trial.run_s(1.0);
    assert_eq!(
        trial.outcome(ticket),
        Outcome::Incomplete {
            details: details(false, "D:\\log\\auto.s7k")
        }
    );
    assert!(trial.has("logging is off, although it was ordered on"));
}

#[test]
fn logging_is_restored_on_a_new_connection() {
    let mut trial = Trial::ready();
    let on = trial.order(logging(true, Some("line.s7k")));
    trial.run_s(1.0);
    assert_eq!(trial.outcomes(on).len(), 1);
    // The controller has begun anew meanwhile, and does not log.
    trial.cut();
    trial.controller.logging = false;
    trial.controller.heard.clear();
    trial.run_s(3.0);
    assert!(trial.controller.logging);
    assert_eq!(
        trial.controller.heard[12..],
        [r#"1 -1 "1""#, r#"18 -1 """#],
        "under another name"
    );
    assert_eq!(trial.outcomes(on).len(), 1);
    // If it still logs, nothing is said.
    trial.cut();
    trial.controller.heard.clear();
    trial.run_s(4.0);
    assert_eq!(trial.controller.heard.len(), 12);
}

#[test]
fn logging_that_was_ordered_without_a_connection_begins_with_the_next_one() {
    let mut trial = Trial::new();
    trial.reachable = false;
    trial.cut();
    let ticket = trial.order(logging(true, Some("line.s7k")));
    trial.run_s(11.0);
    assert_eq!(trial.outcome(ticket), Outcome::TimedOut { sent: false });
    trial.reachable = true;
    trial.run_s(20.0);
    assert!(trial.controller.logging);
}

#[test]
fn logging_is_left_as_it_is_without_an_order() {
    let mut trial = Trial::new();
    trial.controller.logging = true;
    trial.run_s(5.0);
    assert!(trial.controller.logging);
    assert!(!trial.controller.heard.iter().any(|line| line.starts_with("1 ")));
}

#[test]
fn a_connection_lost_between_the_parts_of_an_order_keeps_what_is_known() {
    let mut trial = Trial::ready();
    trial
        .controller
        .always
        .insert(CommandId::ReportLogging.code(), Answer::Nothing);
    let ticket = trial.order(logging(true, None));
    trial.run_s(1.0);
    trial.cut();
    assert_eq!(trial.outcome(ticket), Outcome::Accepted { details: None });
}

#[test]
fn a_file_name_cannot_lead_elsewhere() {
    let mut trial = Trial::ready();
    for file in [
        "", " a", "..", "../x", "a/b", "C:\\x", "a:b", "a,b", "a*b", "a\n", "é", ".hidden",
    ] {
        let ticket = trial.order(logging(true, Some(file)));
        assert!(matches!(trial.outcome(ticket), Outcome::Refused { .. }), "{file:?}");
        let ticket = trial.order(Order::SwitchFile { file: Box::from(file) });
        assert!(matches!(trial.outcome(ticket), Outcome::Refused { .. }), "{file:?}");
    }
    let long = "x".repeat(65);
    let ticket = trial.order(logging(true, Some(&long)));
    assert!(matches!(trial.outcome(ticket), Outcome::Refused { .. }));
    let ticket = trial.order(logging(false, Some("x")));
    assert!(matches!(trial.outcome(ticket), Outcome::Refused { .. }));
    trial.run_s(1.0);
    assert!(trial.controller.heard.is_empty());
}
