//! What every change is held against: all short sequences.

use backseat_explore::{Bounds, Kind, Prepared, Searched, World, search};

/// All sequences of so many inputs from a state.
pub(crate) fn explored(world: &World, kinds: &[Kind], depth: usize, workers: usize) -> Searched {
    let bounds = Bounds {
        depth,
        states: usize::MAX,
        workers,
        is_over: &|| false,
        tell: &|_| {},
    };
    search(world, kinds, &bounds)
}

#[test]
fn no_sequence_of_three_inputs_breaks_a_requirement() {
    for state in Prepared::all() {
        let world = state.world();
        let searched = explored(&world, &Kind::all(world.hovers()), 3, 2);
        let found: Vec<_> = searched.found.values().collect();
        assert!(found.is_empty(), "{}: {found:#?}", state.name());
        assert_eq!(searched.depth(), 3);
        assert!(searched.states() > 2000, "{}: {}", state.name(), searched.states());
        // Nothing is shown by sequences in which core says nothing. Over a lost link the first lease takes longer.
        let modified = searched.said[0] > 0 || *state == Prepared::InsertUnknown;
        assert!(modified, "{}: {:?}", state.name(), searched.said);
        assert!(searched.cut() > 2000, "{}: {}", state.name(), searched.cut());
    }
}

#[test]
fn more_workers_find_the_same() {
    let world = Prepared::InsertSent.world();
    let kinds = [
        Kind::Wait,
        Kind::Hold,
        Kind::AsksModify,
        Kind::LinkDown,
        Kind::ControlTaken,
    ];
    let [alone, together] = [1, 3].map(|workers| explored(&world, &kinds, 4, workers));
    assert_eq!(together.levels, alone.levels);
}

/// Where nothing happens nothing new comes, once all that was under way is over. Only a runtime that cannot connect tries
/// again at times of its own.
#[test]
fn where_nothing_happens_a_state_comes_back() {
    for state in Prepared::all()
        .iter()
        .filter(|state| **state != Prepared::InsertUnknown)
    {
        let searched = explored(&state.world(), &[Kind::WaitTen], 12, 1);
        let last = searched.levels.last().map(|level| level.states);
        assert_eq!(last, Some(0), "{}: {:?}", state.name(), searched.levels);
    }
}
