use backseat_core::plugin::Request;
use backseat_core::{Operator, Start};

use crate::course::{good_line, modify};
use crate::trial::{Seen, Setup, Trial, shorts};

#[test]
fn sr_015_a_hold_ends_the_lease_cancels_our_inserts_and_beats_every_plugin_until_it_is_released() {
    let mut trial = Trial::steering();
    trial.ask(0, [good_line(2)]);
    trial.ask(1, [good_line(3)]);
    trial.run_for(0.5);
    let now = trial.now;
    trial.vehicle.begin(now, None, Some(1));
    trial.run_for(0.2);
    trial.ask(0, [Request::Modify(modify(4))]);
    trial.run_for(0.5);
    let held = trial.now;
    trial.operator(Operator::Hold);
    assert_eq!(trial.sent_since("EMB", held), [held]);
    assert_eq!(
        trial.commands("RCN").len(),
        1,
        "the one that has begun cannot be cancelled"
    );
    trial.script(1, |_| {
        (
            std::time::Duration::from_millis(1),
            Ok(vec![Request::Modify(modify(5)), good_line(6)]),
        )
    });
    trial.run_for(20.0);
    assert!(!trial.core.has_control());
    assert!(trial.sent_since("RMB", held).is_empty() && trial.sent_since("RTK", held).is_empty());
    trial.operator(Operator::Release);
    trial.run_for(1.0);
    assert!(trial.core.is_steering());
}

#[test]
fn sr_015_a_hold_from_before_stands_after_a_restart() {
    let setup = Setup::default();
    let start = Start {
        held: true,
        ..setup.start
    };
    let mut trial = Trial::with(Setup { start, ..setup });
    trial.run_for(5.0);
    assert!(!trial.core.has_control());
    trial.operator(Operator::Release);
    assert!(trial.core.has_control());
}

#[test]
fn sr_015_a_hold_while_the_link_is_lost_cancels_our_inserts_when_it_is_back() {
    let mut trial = Trial::under_way();
    trial.ask(0, [good_line(1)]);
    trial.run_for(0.5);
    trial.cut();
    trial.operator(Operator::Hold);
    trial.run_for(5.0);
    assert_eq!(trial.commands("RCN").len(), 1);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "cancelled"]);
}

#[test]
fn a_stop_ends_the_lease_and_closes_the_logs() {
    let mut trial = Trial::steering();
    let stopped = trial.now;
    trial.operator(Operator::Stop);
    assert_eq!(trial.sent_since("EMB", stopped), [stopped]);
    assert!(trial.seen.iter().any(|(_, seen)| *seen == Seen::Finish));
    trial.run_for(3.0);
    assert!(trial.sent_since("RMB", stopped).is_empty());
}
