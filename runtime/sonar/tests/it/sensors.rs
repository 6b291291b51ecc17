//! Settings of sensors: one outcome each.

use backseat_s7k::SensorIndex;
use backseat_s7k::plc::{CommandId, Generic};
use backseat_sonar::{Event, ORDERS_MAX, Order, Outcome};

use crate::controller::Answer;
use crate::trial::Trial;

fn set(sensor: i32, setting: Generic) -> Order {
    Order::Set {
        sensor: SensorIndex(sensor),
        setting,
    }
}

const ACCEPTED: Outcome = Outcome::Accepted { details: None };

#[test]
fn each_setting_is_said_as_table_19_has_it() {
    let mut trial = Trial::ready();
    let settings = [
        Generic::Range { range_m: 75.0 },
        Generic::Pulse {
            name: Box::from("FM 4-24 kHz 10 ms"),
        },
        Generic::Ping { on: true },
        Generic::TxPower { percent: 80.0 },
        Generic::RxGain { gain: 12 },
        Generic::Duration { period_ms: 200.0 },
        Generic::DefaultState {},
    ];
    let tickets: Vec<_> = settings
        .into_iter()
        .map(|setting| trial.order(set(1, setting)))
        .collect();
    trial.run_s(1.0);
    assert_eq!(
        trial.controller.heard,
        [
            r#"0 1 "Range = 75.00""#,
            r#"0 1 "Pulse = FM 4-24 kHz 10 ms""#,
            r#"0 1 "Ping = 1""#,
            r#"0 1 "TxPower = 80.00""#,
            r#"0 1 "RxGain = 12""#,
            r#"0 1 "Duration = 200.00""#,
            r#"0 1 "DefaultState""#,
        ]
    );
    for ticket in tickets {
        assert_eq!(trial.outcome(ticket), ACCEPTED);
    }
}

#[test]
fn the_names_of_pulses_are_asked_for() {
    let mut trial = Trial::ready();
    let ticket = trial.order(set(1, Generic::PulseFiles {}));
    trial.run_s(1.0);
    assert_eq!(trial.outcome(ticket), ACCEPTED);
    assert!(trial.has("2 pulses; CW; FM 4-24"));
}

#[test]
fn every_end_of_a_setting_is_told_once() {
    let mut trial = Trial::ready();
    trial.controller.answer(
        CommandId::Generic,
        [
            Answer::Rejected,
            Answer::Unknown,
            Answer::Nothing,
            Answer::Nothing,
            Answer::Nothing,
        ],
    );
    let range = |range_m: f64| set(0, Generic::Range { range_m });
    let rejected = trial.order(range(10.0));
    let unknown = trial.order(range(20.0));
    let unanswered = trial.order(range(30.0));
    trial.run_s(15.0);
    assert_eq!(trial.outcome(rejected), Outcome::Rejected);
    assert_eq!(trial.outcome(unknown), Outcome::Unknown);
    assert_eq!(trial.outcome(unanswered), Outcome::TimedOut { sent: true });
    assert_eq!(
        trial.disconnects.len(),
        1,
        "a controller that does not answer has stalled"
    );

    trial.controller.answer(CommandId::Generic, [Answer::Nothing]);
    let lost = trial.order(range(40.0));
    trial.run_s(1.0);
    trial.cut();
    assert_eq!(trial.outcome(lost), Outcome::Lost);
    trial.run_s(30.0);
    assert_eq!(trial.outcomes(lost).len(), 1);
    assert_eq!(
        trial
            .controller
            .heard
            .iter()
            .filter(|line| line.contains("40.00"))
            .count(),
        1
    );
}

#[test]
fn an_order_waits_for_a_connection_for_ten_seconds() {
    let mut trial = Trial::new();
    trial.reachable = false;
    trial.cut();
    let late = trial.order(set(0, Generic::Ping { on: false }));
    trial.run_s(9.9);
    assert!(trial.outcomes(late).is_empty());
    let sent = trial.order(set(0, Generic::Ping { on: true }));
    trial.reachable = true;
    trial.run_s(0.2);
    assert_eq!(trial.outcome(late), Outcome::TimedOut { sent: false });
    trial.run_s(9.0);
    assert_eq!(trial.outcome(sent), ACCEPTED);
    assert!(!trial.controller.heard.iter().any(|line| line.contains("Ping = 0")));
}

#[test]
fn what_cannot_be_ordered_is_refused() {
    let mut trial = Trial::ready();
    let refused = |trial: &mut Trial, order: Order, why: &str| {
        let ticket = trial.order(order);
        assert_eq!(trial.outcome(ticket), Outcome::Refused { why: Box::from(why) });
    };
    refused(
        &mut trial,
        set(7, Generic::Ping { on: true }),
        "the sensor is not configured",
    );
    refused(
        &mut trial,
        set(-1, Generic::Ping { on: true }),
        "the sensor is not configured",
    );
    refused(
        &mut trial,
        set(0, Generic::Range { range_m: f64::NAN }),
        "the range must be over 0 m",
    );
    refused(
        &mut trial,
        set(0, Generic::Range { range_m: -1.0 }),
        "the range must be over 0 m",
    );
    refused(
        &mut trial,
        set(0, Generic::TxPower { percent: 100.5 }),
        "the power must be within 0 to 100 %",
    );
    refused(
        &mut trial,
        set(0, Generic::Duration { period_ms: 0.0 }),
        "the period must be over 0 ms",
    );
    let pulse = |name: &str| set(0, Generic::Pulse { name: Box::from(name) });
    let why = "the name of a pulse has no control characters, and no spaces at its ends";
    refused(&mut trial, pulse("FM\n1"), why);
    refused(&mut trial, pulse(""), why);
    trial.run_s(1.0);
    assert!(trial.controller.heard.is_empty());
}

#[test]
fn no_more_orders_wait_than_there_is_room_for() {
    let mut trial = Trial::new();
    let tickets: Vec<_> = (0..ORDERS_MAX + 3)
        .map(|_| trial.order(set(0, Generic::Ping { on: true })))
        .collect();
    let refused = trial.events.iter().filter(|(_, event)| {
        matches!(
            event,
            Event::Outcome {
                outcome: Outcome::Refused { .. },
                ..
            }
        )
    });
    assert_eq!(refused.count(), 3);
    trial.run_s(5.0);
    for ticket in tickets {
        assert_eq!(trial.outcomes(ticket).len(), 1);
    }
}
