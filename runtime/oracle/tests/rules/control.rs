//! Requirements 001, 012, 014 and 021: what may be sent with and without control.

use backseat_oracle::{Activity, ControlHook};

use crate::scenario::{END, MODIFY, Scenario};

const TRACKLINE: &str = "BPRTK,{t},7,4200.300,N,07000.900,W,4200.300,N,07000.700,W,0,10,1.5,0,0";

#[test]
fn requirement_001_no_dynamic_request_before_control() {
    Scenario::without_control().ours(2000, MODIFY).finds(&["no-control"]);
    Scenario::without_control().ours(2000, TRACKLINE).finds(&["no-control"]);
    Scenario::without_control()
        .vehicle(100, "BFCTL,{t},1")
        .ours(2000, TRACKLINE)
        .finds(&["no-control"]);
    Scenario::without_control()
        .vehicle(100, "BFMIS,{t},a.dive,Running,")
        .ours(2000, TRACKLINE)
        .finds(&["no-control"]);
}

#[test]
fn requirement_001_a_message_that_is_on_its_way_does_not_count_yet() {
    // 200 ms of delay and 50 ms more.
    let lost = Scenario::with_control().vehicle(5000, "BFCTL,{t},0");
    lost.clone().ours(5240, TRACKLINE).finds_nothing();
    lost.ours(5260, TRACKLINE).finds(&["no-control"]);
    let stopped = Scenario::with_control().vehicle(5000, "BFMIS,{t},a.dive,Aborting,why");
    stopped.clone().ours(5240, TRACKLINE).finds_nothing();
    stopped.ours(5260, TRACKLINE).finds(&["no-control"]);
}

#[test]
fn requirement_001_on_a_new_connection_control_is_unknown() {
    Scenario::with_control()
        .link(5000, false)
        .link(6000, true)
        .ours(8000, TRACKLINE)
        .finds(&["no-control"]);
    Scenario::with_control()
        .link(5000, false)
        .ours(6000, TRACKLINE)
        .finds(&["no-control"]);
    Scenario::with_control()
        .link(5000, false)
        .link(6000, true)
        .vehicle(7000, "BFMIS,{t},a.dive,Running,")
        .vehicle(7000, "BFCTL,{t},1")
        .vehicle(7000, "BFMBS,{t},,1,,trackline")
        .ours(8000, TRACKLINE)
        .finds_nothing();
}

#[test]
fn requirement_014_without_control_only_harmless_sentences_may_leave() {
    let lost = || Scenario::with_control().lease(3000, 5000).vehicle(5000, "BFCTL,{t},0");
    let quiet = lost()
        .ours(5250, END)
        .activity(5400, Activity::Plan)
        .ours(6000, "BPVER,{t},1.12")
        .ours(6001, "BPSTS,{t},1,all ok")
        .ours(6002, "BPMSG,{t},no control")
        .ours(6003, "BPRMP,{t}")
        .ours(6005, "BPLOG,NVG,ON");
    quiet.clone().finds_nothing();
    quiet.clone().ours(7000, END).finds(&["end-surplus"]);
    quiet.ours(7000, "BPSIL,{t},1").finds(&["not-allowed-without-control"]);
    lost().activity(10_000, Activity::Plan).finds(&["end-missing"]);
    // 100 ms after the message has arrived, and 50 ms more.
    lost()
        .ours(5350, END)
        .activity(5400, Activity::Plan)
        .finds(&["end-missing"]);
}

#[test]
fn requirement_014_only_our_own_inserts_may_be_cancelled() {
    let lost = Scenario::with_control()
        .ours(2000, TRACKLINE)
        .vehicle(5000, "BFCTL,{t},0");
    lost.clone().ours(6000, "BPRCN,{t},7").finds_nothing();
    lost.ours(6000, "BPRCN,{t},8").finds(&["cancel-foreign"]);
}

#[test]
fn requirement_014_a_lease_that_begins_as_control_is_lost_must_end_too() {
    let late = || Scenario::with_control().vehicle(5000, "BFCTL,{t},0").ours(5100, MODIFY);
    late().ours(5250, END).finds_nothing();
    late().finds(&["end-missing"]);
}

#[test]
fn requirement_014_a_lost_link_needs_no_end() {
    Scenario::with_control()
        .lease(3000, 5000)
        .link(5500, false)
        .activity(10_000, Activity::Plan)
        .finds_nothing();
}

#[test]
fn requirement_012_only_the_operator_may_abort_or_cancel_widely() {
    for body in [
        "BPABT,{t},why,1",
        "BPKIL,{t},why",
        "BPRCA,{t}",
        "BPRCB,{t},",
        "BPRCE,{t},",
    ] {
        let run = Scenario::with_control().ours(5000, body);
        run.clone().finds(&["operator-only"]);
        run.limits(|limits| limits.operator_commands = true).finds_nothing();
    }
}

#[test]
fn requirement_021_we_must_not_move_the_vehicles_position() {
    for body in [
        "BPNPU,{t},4200.3,N,07000.9,W,5,10,0,{t}",
        "BPRNS,{t},1,2,3",
        "BPRBO,{t},3",
        "BPSEM,{t},1,0",
    ] {
        Scenario::with_control().ours(5000, body).finds(&["moves-truth"]);
    }
}

#[test]
fn other_control_hooks_give_control_too() {
    Scenario::without_control()
        .limits(|limits| limits.control = ControlHook::MissionRunning)
        .vehicle(100, "BFMIS,{t},a.dive,Running,")
        .vehicle(100, "BFMBS,{t},,1,,trackline")
        .ours(2000, TRACKLINE)
        .finds_nothing();
    let hook = ControlHook::MissionCommand {
        grant: "go".to_owned(),
        revoke: "stop".to_owned(),
    };
    let run = Scenario::with_control().limits(|limits| limits.control = hook);
    run.clone().ours(2000, TRACKLINE).finds(&["no-control"]);
    let run = run.vehicle(1000, "BFMSC,{t},go");
    run.clone().ours(2000, TRACKLINE).finds_nothing();
    run.vehicle(1100, "BFMSC,{t},stop")
        .ours(2000, TRACKLINE)
        .finds(&["no-control"]);
}
