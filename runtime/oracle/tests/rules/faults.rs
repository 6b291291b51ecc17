//! How faults of the link change the judgement: the runtime is not blamed for what they hide from it, but it is blamed
//! for what it should have seen.

use backseat_oracle::Activity;

use crate::scenario::{END, MODIFY, Scenario, sentence};

const TRACKLINE: &str = "BPRTK,{t},7,4200.300,N,07000.900,W,4200.300,N,07000.700,W,0,10,1.5,0,0";

/// The message that takes control away.
fn taken() -> Vec<u8> {
    sentence("BFCTL,000004.000,0").into_bytes()
}

#[test]
fn a_stall_delivers_the_messages_at_its_end() {
    // The vehicle has sent this by 5 s. It arrives at 8 s with everything that waited.
    let run = Scenario::with_control()
        .vehicle_bytes(8000, &sentence("BFMBS,000005.000,a.dive,3,,trackline").into_bytes())
        .vehicle_bytes(8000, &taken());
    run.clone().ours(7900, TRACKLINE).finds_nothing();
    run.ours(8300, TRACKLINE).finds(&["no-control"]);
}

#[test]
fn a_delay_makes_navigation_old() {
    // This link allows an age of 1.3 s, and then there are 100 ms to end the lease.
    let delayed = |delay_ms: u64| {
        Scenario::with_control()
            .lease(3000, 6000)
            .navigation(4450, false)
            .navigation(4450 + delay_ms, true)
            .navigation_delay(4450 + delay_ms, delay_ms)
            .ours(6500, END)
            .activity(6600, Activity::Plan)
    };
    delayed(1200).finds_nothing();
    delayed(1600).finds(&["stale-navigation"]);
}

#[test]
fn a_half_open_link_lets_navigation_grow_old() {
    let silent = || {
        Scenario::with_control()
            .lease(3000, 4000)
            .navigation(4050, false)
            .activity(5600, Activity::Plan)
    };
    silent().ours(5300, END).finds_nothing();
    silent().ours(5500, END).finds(&["stale-navigation"]);
}

#[test]
fn a_dropped_message_does_not_count_and_the_next_one_does() {
    let run = Scenario::with_control();
    run.clone().ours(5000, TRACKLINE).finds_nothing();
    run.vehicle(4000, "BFMIS,{t},a.dive,Aborting,leak")
        .ours(5000, TRACKLINE)
        .finds(&["no-control"]);
}

#[test]
fn a_corrupt_message_does_not_count() {
    let mut corrupt = taken();
    corrupt[10] ^= 4;
    let run = Scenario::with_control().vehicle_bytes(4000, &corrupt);
    run.clone().ours(5000, TRACKLINE).finds_nothing();
    run.vehicle_bytes(4500, &taken())
        .ours(5000, TRACKLINE)
        .finds(&["no-control"]);
    // The end of one line is damaged, but the message behind it is not.
    let joined = [b"$BFVER,000004.000,1.12*4F\r\x0b".as_slice(), &taken()].concat();
    Scenario::with_control()
        .vehicle_bytes(4000, &joined)
        .ours(5000, TRACKLINE)
        .finds(&["no-control"]);
}

#[test]
fn a_repeated_message_counts_once() {
    let run = Scenario::with_control()
        .vehicle(3000, "BFCTL,{t},1")
        .limits(|limits| limits.inserts_open_max = 1)
        .ours(3500, TRACKLINE)
        .vehicle(3600, "BFACK,{t},RTK,000000.000,7,2,0,text")
        .vehicle(3600, "BFACK,{t},RTK,000000.000,7,2,0,text")
        .vehicle_bytes(6000, &[taken(), taken()].concat());
    let statistics = run.clone().finds_nothing().statistics;
    assert_eq!((statistics.inserts_accepted, statistics.control_spans), (1, 1));
    run.ours(7000, MODIFY).finds(&["no-control"]);
}

#[test]
fn a_message_in_pieces_counts_from_the_last_of_them() {
    let word = taken();
    let mut run = Scenario::with_control();
    for (index, byte) in word.iter().enumerate() {
        run = run.vehicle_bytes(4000 + index as u64 * 100, &[*byte]);
    }
    let whole = 4000 + (word.len() as u64 - 1) * 100;
    // Between the pieces nothing else may come.
    let run = run
        .navigation(3950, false)
        .navigation(whole + 1, true)
        .beats_until(3950);
    let answer = |ms| format!("BFACK,{{t}},MSG,{},0,2,0,ok", super::scenario::stamp(ms));
    run.clone()
        .ours(whole + 150, "BPMSG,{t},are you there")
        .vehicle(whole + 150, &answer(whole + 150))
        .ours(whole + 200, TRACKLINE)
        .finds_nothing();
    run.ours(whole + 300, TRACKLINE).finds(&["no-control"]);
}

#[test]
fn sentences_that_never_arrive_have_no_effect() {
    // From 5 s on nothing of ours arrives; the vehicle should have forgotten the modify at 10.1 s.
    let lost = |until: u64| {
        Scenario::with_control()
            .lease(3000, 9000)
            .arrives(3000, 3010, MODIFY)
            .arrives(4000, 4010, MODIFY)
            .arrives(5000, 5000, MODIFY)
            .ours(9500, END)
            .activity(until, Activity::Plan)
    };
    lost(10_100).finds_nothing();
    lost(10_300).finds(&["modify-outlives"]);
}

#[test]
fn a_stopped_runtime_receives_messages_when_it_goes_on() {
    let run = Scenario::with_control()
        .stopped(3000)
        .vehicle_bytes(4000, &taken())
        .continued(8000);
    run.clone().ours(8200, TRACKLINE).finds_nothing();
    run.ours(8300, TRACKLINE).finds(&["no-control"]);
}
