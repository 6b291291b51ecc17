//! Begins, ends and cancels that come again, late or not at all, and what core asks for then.

use std::time::Duration;

use backseat_core::plugin::Request;
use backseat_spi::AckStatus;
use backseat_units::EastNorth;

use crate::course::{good_line, line, modify};
use crate::scene::{accepted, at_once, begin_of, begins, end_of, ends, hands_over, with_plan};
use crate::trial::{Trial, shorts};
use crate::unheard::damage;
use crate::vehicle::Reply;
use crate::ways::{fate, put, refused};

const SECOND: i64 = 1_000_000_000;

/// The leg begins again and again, and an insert that interrupts is asked for each time, until it is accepted: what became of the
/// last.
fn asks_to_interrupt(trial: &mut Trial) -> String {
    let mut last = String::new();
    for tag in 10..20 {
        begins(trial, Some(1), None);
        trial.run_for(60.0);
        last = fate(trial, at_once(line(tag, (300.0, 300.0), (500.0, 300.0))), tag);
        if last.contains("Accepted") {
            break;
        }
    }
    last
}

fn state(trial: &Trial) -> String {
    let notes: Vec<_> = trial.notes().into_iter().rev().take(14).collect();
    format!(
        "{:?}\n{:?}\n{notes:#?}",
        trial.core.uncontrolled(),
        trial.core.open_request_states()
    )
}

/// An insert that was not answered is named by the plan; then its cancel succeeds. The plan must not go on naming it.
#[test]
fn a_doubtful_insert_whose_cancel_succeeds_is_forgotten() {
    let flown = |named: bool| {
        let mut trial = Trial::under_way();
        trial.vehicle.replies.insert("RTK", Reply::Silent);
        trial.vehicle.replies.insert("RCN", Reply::Silent);
        trial.ask(0, [good_line(1)]);
        trial.run_for(1.0);
        if named {
            trial.vehicle.inserted.insert(1);
        }
        trial.run_for(9.0);
        trial.vehicle.replies.remove("RTK");
        trial.vehicle.replies.remove("RCN");
        trial.vehicle.inserted.remove(&1);
        trial.run_for(20.0);
        asks_to_interrupt(&mut trial)
    };
    assert!(flown(false).contains("Accepted"));
    assert!(flown(true).contains("Accepted"));
}

/// The insert comes before the last waypoint of the behavior.
#[test]
fn sr_002_the_way_on_from_an_insert_to_the_last_point_of_the_same_behavior_is_judged() {
    const LEGS: &[(u32, &[(f64, f64)])] = &[
        (2, &[(-900.0, 0.0), (-300.0, 0.0), (900.0, -1000.0)]),
        (3, &[(-900.0, 600.0)]),
    ];
    let mut trial = with_plan(LEGS, (-900.0, 0.0));
    begins(&mut trial, Some(2), None);
    trial.run_for(5.0);
    let after = line(1, (-300.0, -700.0), (-600.0, -1000.0));
    refused("last waypoint", &fate(&mut trial, Request::Trackline(after), 1));
}

/// The begin of another dive comes just after a younger begin of an adjustment. BFMIS was lost.
#[test]
fn sr_025_a_begin_out_of_order_that_names_another_dive_takes_the_plan_away() {
    let flown = |late: bool| {
        let mut trial = Trial::under_way();
        let first = begin_of(&trial, "a", Some(1), None, "trackline");
        trial.hear_now([first]);
        trial.run_for(3.0);
        trial.vehicle.replies.insert("RMP", Reply::Silent);
        let other = begin_of(&trial, "c", Some(1), None, "trackline");
        if late {
            trial.run_for(0.2);
            let adjusts = begin_of(&trial, "", None, None, "trackline");
            trial.hear_now([adjusts]);
        }
        trial.hear_now([other]);
        put(&mut trial, 90.0, -500.0, 0.0);
        trial.run_for(25.0);
        fate(&mut trial, Request::Modify(modify(9)), 9)
    };
    refused("in order", &flown(false));
    refused("out of order", &flown(true));
}

/// The same with the clock set back between.
#[test]
fn sr_025_a_begin_of_another_dive_after_the_clock_was_set_back() {
    let mut trial = Trial::under_way();
    let first = begin_of(&trial, "a", Some(1), None, "trackline");
    trial.hear_now([first]);
    trial.run_for(3.0);
    trial.vehicle.replies.insert("RMP", Reply::Silent);
    trial.vehicle.clock_nanos -= 42 * SECOND;
    let other = begin_of(&trial, "c", Some(1), None, "trackline");
    trial.hear_now([other]);
    put(&mut trial, 90.0, -500.0, 0.0);
    trial.run_for(35.0);
    refused("clock", &fate(&mut trial, Request::Modify(modify(9)), 9));
}

fn steers_after_begins(mut trial: Trial) -> Vec<bool> {
    let mut steered = Vec::new();
    for turn in 0..20_u32 {
        let number = 1 + turn % 2;
        let next = begin_of(&trial, "", Some(number), None, "trackline");
        trial.hear_now([next]);
        trial.run_for(25.0);
        let tag = u64::from(100 + turn);
        trial.ask(0, [good_line(tag)]);
        trial.run_for(1.0);
        steered.push(shorts(&trial.states(tag)).contains(&"sent"));
        trial.ask(0, [Request::Cancel(tag)]);
        trial.run_for(14.0);
        trial.vehicle.inserted.clear();
    }
    steered
}

/// The clock is set forward as a behavior begins. The next ones begin every 40 s.
#[test]
fn begins_count_again_a_while_after_the_clock_was_set_forward() {
    let mut trial = Trial::under_way();
    trial.run_for(3.0);
    trial.vehicle.clock_nanos += 3600 * SECOND;
    let next = begin_of(&trial, "", Some(1), None, "trackline");
    trial.hear_now([next]);
    trial.run_for(40.0);
    let steered = steers_after_begins(trial);
    assert!(steered[3..].iter().any(|it| *it), "{steered:?}");
}

/// The clock is set during an outage; the vehicle tells a new subscriber what it flies.
#[test]
fn begins_count_after_the_clock_was_set_during_an_outage() {
    for by in [3600, -3600] {
        let mut trial = Trial::under_way();
        trial.run_for(3.0);
        trial.cut();
        trial.vehicle.clock_nanos += by * SECOND;
        trial.run_for(40.0);
        let steered = steers_after_begins(trial);
        assert!(steered[3..].iter().any(|it| *it), "{by}: {steered:?}");
    }
}

/// An insert of a previous run, or of another payload, ends while the plan that names it is being sent.
#[test]
fn an_insert_of_a_previous_run_that_ends_during_the_plan_is_over() {
    let mut trial = Trial::with(crate::trial::Setup::default().after(3, 0));
    trial.vehicle.replies.insert("RMP", Reply::Silent);
    trial.vehicle.replays = false;
    trial.run_for(1.0);
    hands_over(&mut trial);
    trial.run_for(0.2);
    let Some((_, command)) = trial.commands("RMP").pop() else {
        panic!("no BPRMP")
    };
    let created = command.created().unwrap();
    let now = trial.now;
    trial
        .vehicle
        .acknowledge(now, ("RMP", created, None, AckStatus::Pending));
    trial.run_for(0.3);
    let now = trial.now;
    trial.vehicle.say_element(now, None, Some(3), 0, (0.0, 500.0));
    trial.vehicle.say_element(now, Some(1), None, 0, (-600.0, 0.0));
    trial.vehicle.say_element(now, Some(1), None, 1, (600.0, 0.0));
    trial.vehicle.say_element(now, Some(2), None, 0, (600.0, 300.0));
    trial.run_for(0.2);
    let end = end_of(&trial, None, Some(3), "trackline");
    trial.hear_now([end]);
    let now = trial.now;
    trial
        .vehicle
        .acknowledge(now, ("RMP", created, None, AckStatus::Succeeded));
    trial.run_for(0.5);
    trial.vehicle.replies.remove("RMP");
    let mut last = String::new();
    let at = trial.now;
    for tag in 10..20 {
        begins(&mut trial, Some(1), None);
        trial.run_for(60.0);
        last = fate(&mut trial, at_once(line(tag, (300.0, 300.0), (500.0, 300.0))), tag);
        if last.contains("Accepted") {
            break;
        }
    }
    assert!(
        last.contains("Accepted"),
        "{last}; RMP {}; {}",
        trial.sent_since("RMP", at).len(),
        state(&trial)
    );
}

/// The begin of the leg comes again after the begin of the insert was damaged.
#[test]
fn sr_009_a_begin_that_comes_again_does_not_end_an_insert_that_began_unheard() {
    let mut trial = Trial::under_way();
    let leg = begin_of(&trial, "", Some(1), None, "trackline");
    trial.hear_now([leg.clone()]);
    trial.run_for(1.0);
    accepted(&mut trial, good_line(2), 2);
    trial.way = Some(Box::new(damage("BFMB", "")));
    ends(&mut trial, Some(1), None);
    begins(&mut trial, None, Some(1));
    trial.way = None;
    trial.vehicle.inserted.remove(&1);
    trial.run_for(35.0);
    trial.hear_now([leg]);
    trial.run_for(0.5);
    assert_eq!(trial.core.open_requests(), 1, "{:?}", trial.states(2));
}

/// An insert of ours has begun unheard; the vehicle refuses its cancel (7.8), and its plan names what it flies.
#[test]
fn a_refused_cancel_causes_no_flood() {
    let mut trial = Trial::new();
    trial.vehicle.moved = Some((3, EastNorth::new(-900.0, -1300.0)));
    trial.run_for(2.0);
    accepted(
        &mut trial,
        Request::Trackline(line(1, (900.0, -800.0), (900.0, -1000.0))),
        1,
    );
    trial.vehicle.replies.insert("RCN", Reply::Refuse);
    trial.way = Some(Box::new(damage("BFMB", "")));
    ends(&mut trial, Some(1), None);
    begins(&mut trial, None, Some(1));
    trial.way = None;
    trial.run_for(35.0);
    let at = trial.now;
    trial.run_for(600.0);
    let (plans, cancels) = (trial.sent_since("RMP", at).len(), trial.sent_since("RCN", at).len());
    assert!(
        plans <= 30 && cancels <= 10,
        "BPRMP {plans}, BPRCN {cancels} in 10 min {}",
        state(&trial)
    );
}

/// The clock is set forward; a revocation is damaged; a grant from before it comes late.
#[test]
fn an_older_grant_after_a_damaged_revocation_and_a_clock_step() {
    let control = |trial: &Trial, granted| backseat_spi::BackseatControl {
        created: trial.vehicle.clock(trial.now),
        granted,
    };
    let mut trial = Trial::under_way();
    trial.vehicle.replays = false;
    trial.run_for(0.5);
    trial.vehicle.clock_nanos += 3600 * SECOND;
    let granted = control(&trial, true);
    trial.run_for(0.05);
    trial.hear_bytes(b"$BFCTL,081025.987,0*00\r\n");
    trial.run_for(0.05);
    assert!(!trial.core.has_control());
    trial.hear_now([granted.into()]);
    trial.run_for(1.9);
    assert!(!trial.core.has_control(), "{}", state(&trial));
}

/// The link is lost; the plan names the insert that was not answered; then its cancel, which was pending, succeeds.
#[test]
fn a_doubtful_insert_whose_pending_cancel_succeeds_after_the_plan_is_over() {
    let flown = |pending: bool| {
        let mut trial = Trial::under_way();
        trial.vehicle.replies.insert("RTK", Reply::Silent);
        trial.vehicle.replies.insert("RCN", Reply::Silent);
        trial.ask(0, [good_line(1)]);
        trial.run_for(2.5);
        trial.vehicle.inserted.insert(1);
        if pending {
            trial
                .vehicle
                .replies
                .insert("RCN", Reply::Pending(Duration::from_secs(2), AckStatus::Succeeded));
        } else {
            trial.vehicle.replies.remove("RCN");
        }
        trial.vehicle.replies.remove("RTK");
        trial.cut();
        trial.run_for(4.0);
        trial.vehicle.inserted.remove(&1);
        trial.run_for(20.0);
        asks_to_interrupt(&mut trial)
    };
    let (at_once, pending) = (flown(false), flown(true));
    assert!(at_once.contains("Accepted") && pending.contains("Accepted"));
}

/// The same; a modify is judged for the leg while the insert is flown.
#[test]
fn sr_002_a_begin_that_comes_again_does_not_show_what_is_flown() {
    let mut trial = Trial::under_way();
    let leg = begin_of(&trial, "", Some(1), None, "trackline");
    trial.hear_now([leg.clone()]);
    trial.run_for(1.0);
    accepted(
        &mut trial,
        Request::Trackline(line(2, (900.0, -1500.0), (-900.0, -1500.0))),
        2,
    );
    trial.way = Some(Box::new(damage("BFMB", "")));
    ends(&mut trial, Some(1), None);
    begins(&mut trial, None, Some(1));
    trial.way = None;
    trial.vehicle.inserted.remove(&1);
    trial.run_for(35.0);
    trial.hear_now([leg]);
    put(&mut trial, 270.0, 300.0, -700.0);
    refused("again", &fate(&mut trial, Request::Modify(modify(9)), 9));
}

/// The same, and the plan lacks the insert; or the cancels are not answered.
#[test]
fn an_unanswered_cancel_causes_no_flood() {
    let mut trial = Trial::new();
    trial.vehicle.moved = Some((3, EastNorth::new(-900.0, -1300.0)));
    trial.run_for(2.0);
    accepted(
        &mut trial,
        Request::Trackline(line(1, (900.0, -800.0), (900.0, -1000.0))),
        1,
    );
    trial.vehicle.replies.insert("RCN", Reply::Silent);
    trial.way = Some(Box::new(damage("BFMB", "")));
    ends(&mut trial, Some(1), None);
    begins(&mut trial, None, Some(1));
    trial.way = None;
    trial.run_for(35.0);
    let at = trial.now;
    trial.run_for(600.0);
    let (plans, cancels) = (trial.sent_since("RMP", at).len(), trial.sent_since("RCN", at).len());
    assert!(plans <= 30 && cancels <= 10, "BPRMP {plans}, BPRCN {cancels} in 10 min");
}

/// A waiting insert that the vehicle will not give up, before it has begun. Nothing was lost.
#[test]
fn a_refused_cancel_of_a_waiting_insert_causes_no_flood() {
    let mut trial = Trial::under_way();
    accepted(&mut trial, good_line(1), 1);
    trial.vehicle.replies.insert("RCN", Reply::Refuse);
    begins(&mut trial, None, Some(40));
    begins(&mut trial, None, Some(41));
    let at = trial.now;
    trial.run_for(600.0);
    let (plans, cancels) = (trial.sent_since("RMP", at).len(), trial.sent_since("RCN", at).len());
    assert!(plans <= 30 && cancels <= 10, "BPRMP {plans}, BPRCN {cancels} in 10 min");
}

/// Damaged lines while an insert waits.
#[test]
fn noise_while_an_insert_waits_causes_few_requests_for_the_plan() {
    let mut trial = Trial::under_way();
    accepted(&mut trial, good_line(1), 1);
    let at = trial.now;
    for _ in 0..300 {
        trial.hear_bytes(b"$BFNVG,081025.987,0*00\r\n");
        trial.run_for(2.0);
    }
    let plans = trial.sent_since("RMP", at).len();
    assert!(plans <= 60, "BPRMP {plans}");
}

/// An insert of ours is flown unheard, heard to end late and out of order; the next legs free it.
#[test]
fn an_insert_that_ends_out_of_order_is_over() {
    let mut trial = Trial::under_way();
    accepted(&mut trial, good_line(1), 1);
    trial.vehicle.inserted.remove(&1);
    let begun = begin_of(&trial, "", None, Some(1), "trackline");
    trial.run_for(0.2);
    let end = end_of(&trial, None, Some(1), "trackline");
    trial.run_for(0.2);
    let leg = begin_of(&trial, "", Some(2), None, "trackline");
    trial.hear_now([leg]);
    trial.run_for(0.2);
    trial.hear_now([end]);
    trial.hear_now([begun]);
    for number in [3, 1] {
        trial.run_for(90.0);
        begins(&mut trial, Some(number), None);
    }
    assert_eq!(trial.core.open_requests(), 0, "{:?}", trial.states(1));
    trial.run_for(15.0);
    let last = fate(&mut trial, good_line(5), 5);
    assert!(last.contains("Accepted"), "{last}");
}

/// Another payload's insert ends while the plan that names it is sent.
#[test]
fn another_payloads_insert_that_ends_during_the_plan_is_over() {
    let flown = |during: bool| {
        let mut trial = Trial::under_way();
        trial.vehicle.others = vec![(40, (0.0, -1900.0))];
        trial
            .vehicle
            .replies
            .insert("RMP", Reply::Pending(Duration::from_secs(2), AckStatus::Succeeded));
        begins(&mut trial, None, Some(40));
        if !during {
            trial.run_for(3.0);
        }
        trial.run_for(0.5);
        trial.vehicle.others.clear();
        ends(&mut trial, None, Some(40));
        trial.vehicle.replies.remove("RMP");
        trial.run_for(3.0);
        let mut last = String::new();
        for tag in 10..20 {
            begins(&mut trial, Some(1), None);
            put(&mut trial, 90.0, -500.0, 0.0);
            trial.run_for(48.0);
            put(&mut trial, 90.0, -500.0, 0.0);
            last = fate(&mut trial, Request::Modify(modify(tag)), tag);
            if last.contains("Accepted") {
                break;
            }
        }
        last
    };
    assert!(flown(false).contains("Accepted"));
    assert!(flown(true).contains("Accepted"));
}

/// The end of an insert of a previous run is damaged.
#[test]
fn an_insert_of_a_previous_run_whose_end_was_damaged_is_over() {
    let flown = |lose: bool| {
        let mut trial = Trial::with(crate::trial::Setup::default().after(3, 0));
        trial.vehicle.others = vec![(3, (300.0, 100.0))];
        trial.run_for(3.0);
        begins(&mut trial, None, Some(3));
        trial.run_for(5.0);
        if lose {
            trial.way = Some(Box::new(damage("BFMBE", "")));
        }
        ends(&mut trial, None, Some(3));
        trial.way = None;
        trial.vehicle.others.clear();
        asks_to_interrupt(&mut trial)
    };
    assert!(flown(false).contains("Accepted"));
    assert!(flown(true).contains("Accepted"));
}

/// An insert that was not answered waits in the plan, and is flown unheard.
#[test]
fn an_unanswered_insert_that_is_flown_unheard_is_over() {
    let flown = |lose: bool| {
        let mut trial = Trial::under_way();
        trial.vehicle.replies.insert("RTK", Reply::Silent);
        trial.vehicle.replies.insert("RCN", Reply::Refuse);
        trial.ask(0, [at_once(line(1, (300.0, 300.0), (500.0, 300.0)))]);
        trial.run_for(1.0);
        trial.vehicle.inserted.insert(1);
        trial.run_for(60.0);
        if lose {
            trial.way = Some(Box::new(damage("BFMB", "")));
        }
        begins(&mut trial, None, Some(1));
        trial.run_for(5.0);
        trial.vehicle.inserted.clear();
        ends(&mut trial, None, Some(1));
        trial.way = None;
        trial.vehicle.replies.clear();
        asks_to_interrupt(&mut trial)
    };
    assert!(flown(false).contains("Accepted"));
    assert!(flown(true).contains("Accepted"));
}

/// The revocation comes again after the grant, and then another grant.
#[test]
fn a_revocation_that_is_repeated_late_costs_nothing() {
    let control = |trial: &Trial, granted| backseat_spi::BackseatControl {
        created: trial.vehicle.clock(trial.now),
        granted,
    };
    let mut trial = Trial::under_way();
    let revoked = control(&trial, false);
    trial.hear_now([revoked.clone().into()]);
    trial.run_for(2.0);
    let granted = control(&trial, true);
    trial.hear_now([granted.into()]);
    trial.run_for(2.0);
    assert!(trial.core.has_control());
    trial.hear_now([revoked.into()]);
    trial.run_for(2.0);
    let granted = control(&trial, true);
    trial.hear_now([granted.into()]);
    trial.run_for(2.0);
    assert!(trial.core.has_control(), "{}", state(&trial));
}

/// The begin of our insert is damaged; the operator cancels all. BPRCA does not end what has begun.
#[test]
fn sr_002_an_insert_that_may_have_begun_unheard_is_not_over_by_a_cancel_of_all() {
    let mut trial = Trial::under_way();
    accepted(&mut trial, Request::Trackline(line(1, (-500.0, 0.0), (1500.0, 0.0))), 1);
    trial.way = Some(Box::new(damage("BFMB", "")));
    ends(&mut trial, Some(1), None);
    begins(&mut trial, None, Some(1));
    trial.way = None;
    trial.vehicle.inserted.remove(&1);
    trial.operator(backseat_core::Operator::Order(backseat_core::Order::CancelAll));
    trial.run_for(1.0);
    assert_eq!(trial.sent("RCA").len(), 1);
    put(&mut trial, 90.0, 0.0, 0.0);
    trial.run_for(20.0);
    refused("begun", &fate(&mut trial, Request::Modify(modify(9)), 9));
}

/// Two waypoints; the insert comes between them.
#[test]
fn sr_002_the_way_on_from_an_insert_to_the_second_of_two_waypoints_is_judged() {
    const LEGS: &[(u32, &[(f64, f64)])] = &[(2, &[(-300.0, 0.0), (900.0, -1000.0)]), (3, &[(-900.0, 600.0)])];
    let mut trial = with_plan(LEGS, (-900.0, 0.0));
    begins(&mut trial, Some(2), None);
    trial.run_for(5.0);
    let after = line(1, (-300.0, -700.0), (-600.0, -1000.0));
    refused("second waypoint", &fate(&mut trial, Request::Trackline(after), 1));
}

/// The end of another payload's insert is damaged, or comes while the plan that names it is sent.
#[test]
fn another_payloads_insert_whose_end_was_damaged_is_over() {
    let flown = |lose: bool, during: bool| {
        let mut trial = Trial::under_way();
        trial.vehicle.others = vec![(40, (300.0, -1900.0))];
        if during {
            trial
                .vehicle
                .replies
                .insert("RMP", Reply::Pending(Duration::from_secs(2), AckStatus::Succeeded));
        }
        begins(&mut trial, None, Some(40));
        trial.run_for(if during { 0.4 } else { 5.0 });
        trial.vehicle.others.clear();
        if lose {
            trial.way = Some(Box::new(damage("BFMBE", "")));
        }
        ends(&mut trial, None, Some(40));
        trial.way = None;
        trial.vehicle.replies.remove("RMP");
        let mut last = String::new();
        for tag in 10..20 {
            begins(&mut trial, Some(1), None);
            trial.run_for(48.0);
            put(&mut trial, 90.0, -300.0, 0.0);
            last = fate(&mut trial, Request::Modify(modify(tag)), tag);
            if last.contains("Accepted") {
                break;
            }
        }
        last.contains("Accepted")
    };
    let fates = [flown(false, false), flown(true, false), flown(false, true)];
    assert_eq!(fates, [true, true, true], "heard, damaged, during the plan");
}
