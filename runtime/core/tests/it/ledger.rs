use std::time::Duration;

use backseat_core::plugin::Request;
use backseat_spi::AckStatus;

use crate::course::{PLAN, good_line, modify, turn};
use crate::trial::{Trial, shorts};
use crate::vehicle::Reply;

#[test]
fn sr_009_every_request_has_one_end_and_is_counted_once() {
    let mut trial = Trial::under_way();
    trial.ask(0, [Request::Modify(modify(1)), good_line(2), turn(3, f64::NAN)]);
    trial.run_for(0.5);
    trial.vehicle.replies.insert("RTK", Reply::Refuse);
    trial.ask(0, [good_line(4), Request::Cancel(2)]);
    trial.run_for(0.5);
    trial.vehicle.replies.insert("RTK", Reply::Silent);
    trial.ask(0, [good_line(5), Request::EndModify]);
    trial.run_for(5.0);
    let ends: Vec<_> = (1..=5).map(|tag| shorts(&trial.states(tag)).pop().unwrap()).collect();
    assert_eq!(ends, ["ended", "cancelled", "rejected", "failed", "timed out"]);
    let counts = trial.core.request_counts();
    assert_eq!((counts.proposed, counts.rejected), (6, 1));
    assert_eq!((counts.sent, counts.accepted), (5, 3));
    assert_eq!((counts.failed, counts.unanswered), (1, 1));
    assert!(counts.add_up() && counts.waiting + counts.undecided == 0, "{counts:?}");
    assert_eq!(trial.core.open_requests(), 0);
}

/// Checks that an insert was refused because the plan is unknown, and that one is accepted once the vehicle has sent
/// the plan again.
fn known_once_it_has_come_anew(trial: &mut Trial) {
    assert!(trial.rejection(1).contains("plan unknown"), "{:?}", trial.states(1));
    trial.vehicle.replies.clear();
    let now = trial.now;
    trial.vehicle.begin(now, Some(1), None);
    trial.run_for(20.0);
    trial.ask(0, [good_line(2)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(2)), ["sent", "accepted"]);
}

#[test]
fn sr_002_a_plan_series_that_the_missions_start_interrupts_does_not_count_as_complete() {
    let mut trial = Trial::new();
    trial.vehicle.status = "Ready";
    trial.run_for(2.0);
    // Core asks for the plan again; the mission starts in the middle of the old series.
    trial.vehicle.replies.insert("RMP", Reply::Silent);
    trial.cut();
    trial.run_for(2.0);
    let first = trial.commands("RMP").pop().unwrap().1;
    let now = trial.now;
    let echoed = first.created().unwrap();
    trial
        .vehicle
        .acknowledge(now, ("RMP", echoed, None, AckStatus::Pending));
    for (number, points) in &PLAN[..2] {
        for (index, point) in points.iter().enumerate() {
            trial.vehicle.say_element(now, Some(*number), None, index, *point);
        }
    }
    trial.vehicle.set_status(now, "Running");
    let later = now + Duration::from_millis(20);
    trial.vehicle.say_element(later, Some(3), None, 0, PLAN[2].1[0]);
    trial
        .vehicle
        .acknowledge(later, ("RMP", echoed, None, AckStatus::Succeeded));
    trial.run_for(1.0);
    trial.ask(0, [good_line(1)]);
    trial.run_for(0.5);
    known_once_it_has_come_anew(&mut trial);
}

#[test]
fn core_asks_again_for_a_plan_that_the_vehicle_does_not_follow() {
    let mut trial = Trial::under_way();
    let asked = trial.commands("RMP").len();
    let now = trial.now;
    trial.vehicle.begin(now, Some(77), None);
    trial.run_for(1.0);
    assert_eq!(trial.commands("RMP").len(), asked + 1);
}

#[test]
fn sr_002_a_plan_series_that_ends_in_a_refusal_does_not_count_as_complete() {
    let mut trial = Trial::new();
    trial.vehicle.replies.insert("RMP", Reply::Silent);
    trial.run_for(1.0);
    let asked = trial.commands("RMP").pop().unwrap().1.created().unwrap();
    let now = trial.now;
    trial.vehicle.acknowledge(now, ("RMP", asked, None, AckStatus::Pending));
    trial.vehicle.say_plan(now);
    trial.vehicle.acknowledge(now, ("RMP", asked, None, AckStatus::Failed));
    trial.run_for(0.5);
    trial.ask(0, [good_line(1)]);
    trial.run_for(0.5);
    assert!(trial.rejection(1).contains("plan unknown"));
}

#[test]
fn sr_002_a_plan_series_with_a_lost_sentence_does_not_count_as_complete() {
    let told = |between: &[u8]| {
        let mut trial = Trial::new();
        trial.vehicle.replies.insert("RMP", Reply::Silent);
        trial.run_for(1.0);
        let asked = trial.commands("RMP").pop().unwrap().1.created().unwrap();
        let now = trial.now;
        trial.vehicle.acknowledge(now, ("RMP", asked, None, AckStatus::Pending));
        trial.run_for(0.01);
        trial.hear_bytes(between);
        let now = trial.now;
        trial.vehicle.say_plan(now);
        trial
            .vehicle
            .acknowledge(now, ("RMP", asked, None, AckStatus::Succeeded));
        trial.run_for(0.5);
        trial.ask(0, [good_line(1)]);
        trial.run_for(0.5);
        trial
    };
    let good = told(b"$BFXYZ,1*42\r\n");
    assert_eq!(shorts(&good.states(1)), ["sent", "accepted"], "{:?}", good.states(1));
    for lost in [
        &b"$BFPLN,120000.000,,14,0,0,4200.000000,N,07000.000000,W,,,*00\r\n"[..],
        b"%BFPLN,120000.000,,14,0,0,4200.000000,N,07000.000000,W,,,*00\r\n",
        b"$BFPLN,x,,14*07\r\n",
    ] {
        let mut trial = told(lost);
        known_once_it_has_come_anew(&mut trial);
    }
}
