//! Orders that the operator gave in advance.

use backseat_core::plugin::{FaultKind, Request};
use backseat_core::{Condition, FailAction, Note, Operator, Order, PluginSetup, Policy, RequestKind, Start};
use backseat_units::Timestamp;

use super::{abort, kill, order, rejection, say_command, wire, with_policies};
use crate::course::{modify, plugin};
use crate::trial::{Setup, Trial};

#[test]
fn sr_015_policies_can_hold_and_release_and_core_reports_this_as_the_operators_acts() {
    let policies = vec![
        Policy {
            when: Condition::MissionCommand("payload hold".to_owned()),
            order: Order::Hold,
        },
        Policy {
            when: Condition::MissionCommand("payload release".to_owned()),
            order: Order::Release,
        },
    ];
    let mut trial = Trial::with_under_way(with_policies(policies));
    trial.ask(0, [Request::Modify(modify(11))]);
    trial.run_for(0.5);
    say_command(&mut trial, "payload hold ");
    assert!(!trial.core.is_steering() && !trial.core.has_control());
    // Drivers keep the hold across restarts because of this note.
    assert!(
        trial
            .notes()
            .iter()
            .any(|(_, note)| *note == Note::Operator { act: Operator::Hold })
    );
    say_command(&mut trial, "payload holder");
    say_command(&mut trial, "payload release");
    assert!(trial.core.has_control());
}

#[test]
fn sr_012_policies_act_in_the_order_of_the_file_on_the_exact_text() {
    let command = || Condition::MissionCommand("payload abort".to_owned());
    let policies = vec![
        Policy {
            when: command(),
            order: Order::CancelAll,
        },
        Policy {
            when: Condition::MissionCommand("payload kill".to_owned()),
            order: kill(),
        },
        Policy {
            when: command(),
            order: abort(),
        },
    ];
    let mut trial = Trial::with_under_way(with_policies(policies.clone()));
    let at = trial.now;
    for text in ["Payload abort", "payload abort now", "payload", ""] {
        say_command(&mut trial, text);
    }
    let names_since = |trial: &Trial| -> Vec<&str> {
        let names = trial.names_since(at);
        names.into_iter().filter(|name| *name != "STS").collect()
    };
    assert!(names_since(&trial).is_empty(), "{:?}", names_since(&trial));
    say_command(&mut trial, "payload abort");
    let names = names_since(&trial);
    assert_eq!(names[..2], ["RCA", "ABT"], "{names:?}");
    assert!(trial.commands("KIL").is_empty());

    // If the runtime is not armed, the order is rejected and the log says so.
    let setup = with_policies(policies);
    let start = Start {
        armed: false,
        ..setup.start
    };
    let mut trial = Trial::with(Setup { start, ..setup });
    trial.run_for(2.0);
    say_command(&mut trial, "payload abort");
    assert_eq!(
        rejection(&trial, RequestKind::Abort),
        "control: the runtime is not armed"
    );
    assert!(trial.commands("ABT").is_empty());
}

fn stale_policy(seconds: f64, order: Order) -> Policy {
    Policy {
        when: Condition::NavigationStaleForS(seconds),
        order,
    }
}

#[test]
fn a_policy_on_stale_navigation_acts_once_in_each_stale_period() {
    let policies = vec![stale_policy(20.0, abort()), stale_policy(5.0, Order::Hold)];
    let mut trial = Trial::with_under_way(with_policies(policies));
    let holds = |trial: &Trial| -> Vec<Timestamp> {
        let notes = trial.notes().into_iter();
        notes
            .filter(|(_, note)| *note == Note::Operator { act: Operator::Hold })
            .map(|(at, _)| at)
            .collect()
    };
    let stopped = trial.now;
    trial.vehicle.navigates = false;
    trial.run_for(15.0);
    let [held] = holds(&trial)[..] else {
        panic!("{:?}", holds(&trial))
    };
    // Navigation is stale one second after the last sample, and the policy acts five seconds later.
    let after = held.since(stopped).as_secs_f64();
    assert!((5.8..6.2).contains(&after), "{after}");
    assert!(trial.commands("ABT").is_empty());
    trial.vehicle.navigates = true;
    trial.run_for(5.0);
    trial.operator(Operator::Release);
    trial.vehicle.navigates = false;
    trial.run_for(60.0);
    assert_eq!(holds(&trial).len(), 2);
    assert_eq!(trial.commands("ABT").len(), 1);
}

#[test]
fn a_policy_on_stale_navigation_waits_for_the_first_connection_and_ignores_invalid_times() {
    let policies = vec![stale_policy(5.0, Order::Hold)];
    let mut trial = Trial::with(with_policies(policies));
    trial.unreachable = true;
    trial.run_for(60.0);
    let held = |trial: &Trial| {
        trial
            .notes()
            .iter()
            .any(|(_, note)| matches!(note, Note::Operator { .. }))
    };
    assert!(!held(&trial));
    trial.unreachable = false;
    trial.vehicle.navigates = false;
    trial.run_for(20.0);
    assert!(held(&trial), "connected, and no navigation");

    let nonsense = [f64::NAN, f64::INFINITY, -1.0, 1e300];
    let policies = nonsense.map(|seconds| stale_policy(seconds, Order::Hold)).to_vec();
    let mut trial = Trial::with_under_way(with_policies(policies));
    trial.vehicle.navigates = false;
    trial.run_for(60.0);
    assert!(!held(&trial));
}

#[test]
fn a_policy_on_quarantine_and_a_plugins_fail_action_act_once() {
    let failing = PluginSetup {
        on_failure: FailAction::Abort,
        ..plugin("first")
    };
    let mut trial = Trial::with_under_way(Setup {
        plugins: vec![failing, plugin("second")],
        ..Setup::default()
    });
    trial.ask(1, [Request::Modify(modify(11))]);
    trial.run_for(0.5);
    trial.fail(0, FaultKind::Trap);
    trial.run_for(0.5);
    assert_eq!(trial.commands("ABT").len(), 1);
    assert_eq!(wire(&trial.commands("ABT")[0].1), "$BPABT,a plugin failed,1");
    assert!(!trial.core.is_steering());

    // While the vehicle wraps up, neither another failure nor a policy aborts that; the operator's own order does.
    let now = trial.now;
    trial.vehicle.set_status(now, "Aborting");
    trial.run_for(5.0);
    trial.fail(0, FaultKind::Trap);
    trial.run_for(0.5);
    assert_eq!(rejection(&trial, RequestKind::Abort), "state: a mission is ending");
    assert_eq!(trial.commands("ABT").len(), 1);
    order(&mut trial, abort());
    trial.run_for(0.5);
    assert_eq!(trial.commands("ABT").len(), 2);

    let policies = vec![Policy {
        when: Condition::PluginQuarantined,
        order: kill(),
    }];
    let mut trial = Trial::with_under_way(with_policies(policies));
    trial.restart_fails = Some(FaultKind::Start);
    trial.fail(0, FaultKind::Trap);
    trial.run_for(120.0);
    assert_eq!(trial.commands("KIL").len(), 1);
}
