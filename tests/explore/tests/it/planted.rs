//! Faults that are planted around core: that nothing is found says something only where these are.

use backseat_explore::{Kind, Planted, Prepared};

use crate::bounded::explored;

fn found(state: Prepared, fault: Planted) -> Vec<(&'static str, Vec<Kind>)> {
    let mut world = state.world();
    world.plant(fault);
    let searched = explored(&world, &Kind::all(world.hovers()), 2, 2);
    let found = searched.found.into_values();
    found.map(|found| (found.broken.rule, found.sequence)).collect()
}

#[test]
fn a_core_that_is_not_told_of_lost_control_keeps_its_lease() {
    let found = found(Prepared::Lease, Planted::ControlUntold);
    assert!(
        found.contains(&("SR-014 lease without control", vec![Kind::ControlTaken])),
        "{found:?}"
    );
}

#[test]
fn a_core_that_is_not_told_of_the_hold_keeps_its_station() {
    let found = found(Prepared::Hovering, Planted::HoldUntold);
    assert!(
        found.contains(&("SR-014 station without control", vec![Kind::Hold])),
        "{found:?}"
    );
}

#[test]
fn a_core_that_is_not_told_of_the_hold_begins_a_lease_under_it() {
    let found = found(Prepared::InsertFlown, Planted::HoldUntold);
    assert!(
        found.contains(&("SR-001 control", vec![Kind::Hold, Kind::AsksModify])),
        "{found:?}"
    );
}

/// What a sequence is told as: each input, and every sentence both ways with its time.
#[test]
fn a_sequence_is_told_sentence_by_sentence() {
    let mut world = Prepared::Lease.world();
    world.watch();
    assert_eq!(world.step(Kind::ControlTaken), Ok(()));
    let told = world.trace().join("\n");
    let order = ["-- control-taken", "< $BFCTL,", "> $BPEMB,", "# no control"];
    let places: Vec<_> = order.iter().map(|part| told.find(part)).collect();
    assert!(places.iter().all(Option::is_some) && places[..3].is_sorted(), "{told}");
}
