//! What only the operator may order, directly or by a policy: cancels, abort and kill, an empty mission.

use backseat_core::plugin::RequestState;
use backseat_core::{Note, Operator, Order, Owner, Policy, RequestKind, Settings, Start};
use backseat_spi::{MissionCommand, Text, ToVehicle};

use crate::trial::{Setup, Trial};

mod cancels;
mod empty;
mod endings;
mod policies;

fn abort() -> Order {
    Order::Abort {
        text: "leak, in BAY 2 RMB".to_owned(),
        errors: true,
    }
}

fn kill() -> Order {
    Order::Kill {
        text: "nets".to_owned(),
    }
}

fn order(trial: &mut Trial, order: Order) {
    trial.operator(Operator::Order(order));
}

/// The states of the orders of a kind, in one list.
fn states(trial: &Trial, kind: RequestKind) -> Vec<RequestState> {
    let notes = trial.notes().into_iter();
    notes
        .filter_map(|(_, note)| match note {
            Note::Request(transition) if transition.kind == kind => {
                assert_eq!(transition.owner, Owner::Operator);
                Some(transition.state)
            }
            _ => None,
        })
        .collect()
}

fn rejection(trial: &Trial, kind: RequestKind) -> String {
    match states(trial, kind).pop() {
        Some(RequestState::Rejected(refusal)) => refusal.to_string(),
        other => panic!("{kind:?} was not rejected: {other:?}"),
    }
}

fn wire(command: &ToVehicle) -> String {
    let mut bytes = Vec::new();
    command.encode(&mut bytes).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    let body = text.strip_suffix("\r\n").unwrap();
    let (body, sum) = body.split_once('*').unwrap();
    let xor = body[1..].bytes().fold(0, |sum, byte| sum ^ byte);
    assert_eq!(sum, format!("{xor:02X}"));
    let mut fields: Vec<&str> = body.split(',').collect();
    assert_eq!(fields.remove(1).len(), "hhmmss.sss".len(), "{text}");
    fields.join(",")
}

fn unarmed() -> Setup {
    let setup = Setup::default();
    let start = Start {
        armed: false,
        ..setup.start
    };
    Setup { start, ..setup }
}

fn with_policies(policies: Vec<Policy>) -> Setup {
    Setup {
        settings: Settings {
            policies,
            ..Settings::default()
        },
        ..Setup::default()
    }
}

fn say_command(trial: &mut Trial, text: &str) {
    let now = trial.now;
    let message = MissionCommand {
        created: trial.vehicle.clock(now),
        text: Text::cleaned(text),
    };
    trial.vehicle.say(now, message);
    trial.run_for(0.1);
}

#[test]
fn orders_have_tags_of_their_own() {
    let mut trial = Trial::under_way();
    order(&mut trial, Order::CancelElement);
    order(&mut trial, Order::CancelElement);
    trial.run_for(1.0);
    let mut tags: Vec<u64> = trial
        .notes()
        .into_iter()
        .filter_map(|(_, note)| match note {
            Note::Request(transition) if transition.owner == Owner::Operator => Some(transition.tag),
            _ => None,
        })
        .collect();
    tags.sort_unstable();
    tags.dedup();
    assert_eq!(tags, [1, 2]);
}
