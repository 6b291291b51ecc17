//! The state of a run.

use backseat_oracle::{Activity, State};

use crate::scenario::{END, Scenario};

const TRACKLINE: &str = "BPRTK,{t},7,4200.300,N,07000.900,W,4200.300,N,07000.700,W,0,10,1.5,0,0";

#[test]
fn an_insert_goes_through_its_states() {
    let run = Scenario::without_control()
        .link(500, false)
        .link(1000, true)
        .vehicle(1500, "BFMIS,{t},a.dive,Running /logs/1,")
        .vehicle(1500, "BFCTL,{t},1")
        .vehicle(1500, "BFMBS,{t},,1,,trackline")
        .ours(2000, TRACKLINE)
        .vehicle(2300, "BFACK,{t},RTK,000000.000,7,3,0,text")
        .vehicle(2500, "BFACK,{t},RTK,000000.000,7,2,0,text")
        .vehicle(3000, "BFMBS,{t},,,7,trackline")
        .vehicle(5000, "BFMBE,{t},,,7,trackline")
        .vehicle(6000, "BFCTL,{t},0");
    assert_eq!(
        run.finds_nothing().states,
        [
            State::NoControl,
            State::Down,
            State::NoControl,
            State::Idle,
            State::Asked,
            State::Queued,
            State::Insert,
            State::Idle,
            State::NoControl,
        ]
    );
}

#[test]
fn a_lease_takes_precedence_over_an_insert_and_station_keeping_over_both() {
    let run = Scenario::with_control()
        .lease(3000, 4000)
        .ours(4200, TRACKLINE)
        .ours(4800, END)
        .activity(4900, Activity::Plan)
        .ours(5200, "BPSUS,{t}")
        .ours(5700, "BPRES,{t}")
        .vehicle(6000, "BFACK,{t},RTK,000000.000,7,1,0,text");
    assert_eq!(
        run.finds_nothing().states,
        [
            State::NoControl,
            State::Idle,
            State::Lease,
            State::LeaseInsert,
            State::Asked,
            State::Station,
            State::Asked,
            State::Idle,
        ]
    );
}

#[test]
fn an_insert_that_is_missing_from_the_plan_is_not_open() {
    let run = |elements: &str| {
        Scenario::with_control()
            .ours(2000, TRACKLINE)
            .vehicle(2300, "BFACK,{t},RTK,000000.000,7,2,0,text")
            .ours(3000, "BPRMP,{t}")
            .vehicle(3100, elements)
            .vehicle(3200, "BFACK,{t},RMP,000002.000,,2,0,text")
            .finds_nothing()
            .states
    };
    let open = [State::NoControl, State::Idle, State::Asked, State::Queued];
    assert_eq!(run("BFPLN,{t},,7,0,1,4200.300,N,07000.900,W,,,"), open);
    let mut over = open.to_vec();
    over.push(State::Idle);
    assert_eq!(run("BFPLN,{t},1,,0,1,4200.300,N,07000.900,W,,,"), over);
}

#[test]
fn state_names_are_unique() {
    let mut names: Vec<_> = State::ALL.iter().map(|state| state.name()).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), State::ALL.len());
    assert_eq!(State::LeaseInsert.to_string(), "lease-insert");
}
