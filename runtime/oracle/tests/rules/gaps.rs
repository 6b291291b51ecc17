//! If the record of a run has a gap, the oracle claims nothing that depends on the missing part.

use crate::scenario::{END, MODIFY, Scenario};

const TRACKLINE: &str = "BPRTK,{t},7,4200.300,N,07000.900,W,4200.300,N,07000.700,W,0,10,1.5,0,0";

/// The vehicle last said that it has control, and then records are missing from 4 to 5 s.
fn denied() -> Scenario {
    Scenario::with_control().vehicle(3000, "BFCTL,{t},0").gap(4000, 5000)
}

#[test]
fn after_a_gap_control_is_unknown_until_the_vehicle_says_it_again() {
    denied().ours(5500, MODIFY).ours(6000, END).finds_nothing();
    denied().ours(5500, TRACKLINE).finds_nothing();
    denied()
        .vehicle(6000, "BFCTL,{t},0")
        .ours(6300, TRACKLINE)
        .finds(&["no-control"]);
    // One half of control leaves the other unknown, but either half alone can deny control.
    denied()
        .vehicle(6000, "BFCTL,{t},1")
        .ours(6300, TRACKLINE)
        .finds_nothing();
    denied()
        .vehicle(6000, "BFMIS,{t},a.dive,Stopped,")
        .ours(6300, TRACKLINE)
        .finds(&["no-control"]);
    // A new connection is a new beginning.
    denied()
        .link(6000, false)
        .link(6100, true)
        .ours(6800, "BPTOP,{t},0,words,0")
        .finds(&["not-allowed-without-control"]);
}

#[test]
fn a_lease_may_have_ended_or_begun_in_the_gap() {
    // A lease that is never ended: its end may be in the gap.
    Scenario::with_control()
        .ours(3000, MODIFY)
        .ours(4000, MODIFY)
        .gap(4500, 8000)
        .finds_nothing();
    Scenario::with_control()
        .vehicle(3000, "BFCTL,{t},0")
        .gap(4000, 5000)
        .vehicle(5100, "BFCTL,{t},0")
        .ours(6000, END)
        .finds_nothing();
    Scenario::with_control()
        .gap(4000, 5000)
        .ours(5500, "BPCON,{t}")
        .ours(6000, "BPRES,{t}")
        .finds_nothing();
    // A lease that begins after the gap is judged as always.
    Scenario::with_control()
        .gap(2000, 3000)
        .ours(4000, MODIFY)
        .vehicle(4500, "BFMBS,{t},a.dive,2,,trackline")
        .finds(&["lease-outlives"]);
}

#[test]
fn an_operators_hold_may_have_been_released() {
    let held = || Scenario::with_control().operator(3000, true).gap(4000, 5000);
    held().ours(5500, TRACKLINE).finds_nothing();
    held()
        .operator(6000, true)
        .ours(6500, TRACKLINE)
        .finds(&["operator-hold"]);
}

#[test]
fn what_was_recorded_on_both_sides_of_a_gap_still_counts() {
    let twice = || Scenario::with_control().ours(3000, TRACKLINE).gap(4000, 5000);
    twice().ours(6000, TRACKLINE).finds(&["identifier-repeated"]);
    // An insert that was sent in the gap may be cancelled.
    twice().ours(6000, "BPRCN,{t},99").finds_nothing();
}

#[test]
fn silence_after_a_gap_is_judged_from_its_end() {
    let silent = || {
        Scenario::with_control()
            .without_answers()
            .beats_until(1000)
            .navigation(1500, false)
            .gap(2000, 5000)
    };
    silent().ours(5900, MODIFY).ours(6000, END).finds_nothing();
    silent().ours(6800, MODIFY).ours(6900, END).finds(&["stale-navigation"]);
    silent()
        .navigation(5500, true)
        .ours(7990, MODIFY)
        .ours(8200, END)
        .finds_nothing();
    silent()
        .navigation(5500, true)
        .ours(8000, MODIFY)
        .ours(8200, END)
        .finds(&["unheard"]);
}

#[test]
fn the_end_of_a_sentence_that_began_in_the_gap_is_ignored() {
    Scenario::with_control()
        .gap(4000, 5000)
        .bytes(5020, b"0,1.5,1,0*54\r\n")
        .ours(5600, "BPMSG,{t},whole")
        .finds_nothing();
}
