//! Requirement 015: the operator's hold beats everything.

use backseat_oracle::Activity;

use crate::scenario::{END, MODIFY, Scenario};

const TRACKLINE: &str = "BPRTK,{t},7,4200.300,N,07000.900,W,4200.300,N,07000.700,W,0,10,1.5,0,0";
const GPS_HIT: &str = "BPRGP,{t},7,4200.300,N,07000.900,W,,,0";

#[test]
fn requirement_015_nothing_dynamic_leaves_under_a_hold() {
    for body in [TRACKLINE, MODIFY, GPS_HIT, "BPSUS,{t}"] {
        let held = Scenario::with_control().operator(3000, true);
        let after = if body == MODIFY { END } else { "BPRES,{t}" };
        held.clone()
            .ours(3150, body)
            .ours(3150, after)
            .finds(&["operator-hold"]);
        held.operator(3100, false)
            .ours(3200, body)
            .ours(3210, after)
            .finds_nothing();
    }
    Scenario::with_control()
        .operator(3000, true)
        .ours(4000, "BPRMP,{t}")
        .ours(4000, "BPMSG,{t},held")
        .finds_nothing();
}

#[test]
fn requirement_015_a_lease_ends_within_100_ms() {
    let held = || {
        Scenario::with_control()
            .lease(3000, 5000)
            .operator(5500, true)
            .activity(5800, Activity::Plan)
    };
    held().ours(5600, END).finds_nothing();
    held().ours(5610, END).finds(&["operator-hold"]);
    let hovers = || Scenario::with_control().ours(3000, "BPSUS,{t}").operator(3500, true);
    hovers().ours(3600, "BPRES,{t}").finds_nothing();
    hovers().ours(3610, "BPRES,{t}").finds(&["operator-hold"]);
    // A lease that begins just then must end too.
    Scenario::with_control()
        .operator(3000, true)
        .ours(3050, MODIFY)
        .finds(&["operator-hold"]);
}

#[test]
fn requirement_015_a_stopped_runtime_obeys_when_it_goes_on() {
    let stopped = || Scenario::with_control().stopped(3000).operator(3500, true);
    stopped()
        .continued(6000)
        .ours(6050, MODIFY)
        .ours(6100, END)
        .finds_nothing();
    stopped()
        .continued(6000)
        .ours(6150, TRACKLINE)
        .finds(&["operator-hold"]);
}

#[test]
fn requirement_015_a_hold_survives_a_restart() {
    Scenario::with_control()
        .operator(3000, true)
        .stopped(3500)
        .link(3500, false)
        .started(5000)
        .reconnects(5000, 5100)
        .ours(7000, TRACKLINE)
        .finds(&["operator-hold"]);
}

#[test]
fn requirement_015_a_new_process_cancels_an_insert_once_the_vehicle_has_named_it() {
    let held = || {
        Scenario::with_control()
            .ours(2000, TRACKLINE)
            .vehicle(2100, "BFACK,{t},RTK,000000.000,7,2,0,text")
            .stopped(2300)
            .link(2300, false)
            .started(3000)
            .reconnects(3000, 3100)
            .operator(3500, true)
    };
    let named = |ms| held().vehicle(ms, "BFPLN,{t},,7,0,0,4200.300,N,07000.900,W,,,");
    // It cannot know of it before, however long the hold lasts.
    held().finds_nothing();
    // Named more than a second after the hold, and cancelled at once: the hunt found this, seed 7067143.
    named(4502).ours(4502, "BPRCN,{t},7").finds_nothing();
    named(4600).ours(4600, "BPRCN,{t},7").finds_nothing();
    named(4600).ours(5500, "BPRCN,{t},7").finds_nothing();
    named(4600).finds(&["hold-cancel-missing"]);
    named(4600).operator(5000, false).finds_nothing();
    named(3300).ours(3550, "BPRCN,{t},7").finds_nothing();
    named(3300).finds(&["hold-cancel-missing"]);
    // Named while the runtime was stopped, which cancels when it continues: the hunt found this, seed 12009175.
    let stopped = || {
        held()
            .stopped(4000)
            .vehicle(4600, "BFPLN,{t},,7,0,0,4200.300,N,07000.900,W,,,")
            .continued(6000)
    };
    stopped().ours(6900, "BPRCN,{t},7").finds_nothing();
    stopped().finds(&["hold-cancel-missing"]);
    stopped().operator(6500, false).finds_nothing();
    stopped().link(6500, false).finds_nothing();
}

#[test]
fn requirement_015_a_hold_cancels_the_waiting_inserts() {
    let waits = |body: &str| {
        Scenario::with_control()
            .ours(2000, body)
            .vehicle(2100, "BFACK,{t},RTK,000000.000,7,2,0,text")
            .operator(3000, true)
    };
    waits(TRACKLINE).finds(&["hold-cancel-missing"]);
    waits(TRACKLINE).ours(3050, "BPRCN,{t},7").finds_nothing();
    waits(TRACKLINE).operator(3500, false).finds_nothing();
    waits(TRACKLINE).link(3500, false).finds_nothing();
    // Not an insert that has begun, nor one that was not answered, nor a GPS hit, which cannot be cancelled.
    waits(TRACKLINE)
        .vehicle(2500, "BFMBS,{t},,,7,trackline")
        .finds_nothing();
    Scenario::with_control()
        .ours(2000, TRACKLINE)
        .operator(3000, true)
        .finds_nothing();
    waits(GPS_HIT).finds_nothing();
}
