//! What a fingerprint tells apart, and what not.

use std::collections::BTreeMap;
use std::time::Duration;

use backseat_explore::{Kind, Prepared, RULES, World};

/// Every so many kinds are tried.
const STRIDE: usize = 10;

fn after(state: Prepared, sequence: &[Kind]) -> World {
    let mut world = state.world();
    for kind in sequence {
        assert_eq!(world.step(*kind), Ok(()));
    }
    world
}

/// The words of two fingerprints that are not the same, some of them.
fn differ(one: &World, other: &World) -> Vec<(String, String)> {
    let pairs = one.anatomy().1.into_iter().zip(other.anatomy().1);
    pairs.filter(|(one, other)| one != other).take(4).collect()
}

/// The words of a fingerprint that come of the fields below this one.
fn part<'a>(words: &'a [String], below: &str) -> Vec<&'a String> {
    words.iter().filter(|word| word.starts_with(below)).collect()
}

#[test]
fn the_same_state_at_another_time_is_the_same() {
    for state in Prepared::all() {
        let [now, later] = [0, 20].map(|later_s| state.world_after(Duration::from_secs(later_s)));
        assert_eq!(differ(&now, &later), [], "{}", state.name());
        assert_eq!(now.fingerprint(), later.fingerprint(), "{}", state.name());
    }
}

#[test]
fn another_way_to_the_same_state_leads_to_the_same() {
    use Kind as K;
    let ways: [(Prepared, &[Kind], &[Kind]); 4] = [
        (
            Prepared::Held,
            &[K::Wait, K::Hold, K::Wait],
            &[K::Wait, K::Wait, K::Wait],
        ),
        // A request that was refused has left numbers behind, and no more.
        (
            Prepared::Held,
            &[K::AsksOutside, K::Wait, K::Wait],
            &[K::Wait, K::Wait, K::Wait],
        ),
        (Prepared::InsertSent, &[K::AnswersGood, K::Wait], &[K::Wait, K::Wait]),
        (
            Prepared::InsertFlown,
            &[K::AsksOutside, K::ControlGiven, K::Release],
            &[K::MissionRuns, K::Wait, K::Wait],
        ),
    ];
    for (state, one, other) in ways {
        let [one, other] = [one, other].map(|way| after(state, way));
        assert_eq!(one.anatomy().1, other.anatomy().1, "{}", state.name());
        assert_eq!(one.fingerprint(), other.fingerprint());
    }
}

#[test]
fn each_part_that_safety_hangs_on_makes_another_state() {
    use Kind as K;
    let parts: [(&str, Prepared, &[Kind], &[Kind]); 12] = [
        (
            "core.capabilities.modify.lease",
            Prepared::Lease,
            &[K::AsksEnd],
            &[K::Wait],
        ),
        (
            "core.capabilities.station.keeping",
            Prepared::Hovering,
            &[K::Hold],
            &[K::Wait],
        ),
        ("core.cx.control.held", Prepared::InsertFlown, &[K::Hold], &[K::Wait]),
        (
            "core.cx.control.handed_over",
            Prepared::InsertFlown,
            &[K::ControlTaken],
            &[K::Wait],
        ),
        (
            "core.cx.ledger.open",
            Prepared::InsertFlown,
            &[K::AsksInsert],
            &[K::Wait],
        ),
        (
            "core.cx.ledger.open",
            Prepared::InsertSent,
            &[K::AnswersMissing],
            &[K::LinkDown],
        ),
        (
            "core.cx.vehicle.plan",
            Prepared::InsertFlown,
            &[K::OtherDive],
            &[K::Wait],
        ),
        (
            "core.cx.vehicle.navigation.clock",
            Prepared::Lease,
            &[K::AnswersMissing, K::Wait, K::Wait],
            &[K::Wait; 3],
        ),
        (
            "core.cx.vehicle.navigation.jumped_at",
            Prepared::Lease,
            &[K::NavigationJumps],
            &[K::Wait],
        ),
        (
            "core.cx.link",
            Prepared::Lease,
            &[K::AnswersMissing, K::Wait],
            &[K::Wait, K::Wait],
        ),
        // The same lease, asked for a second later.
        (
            "core.cx.timers",
            Prepared::InsertFlown,
            &[K::AsksModify, K::Wait, K::Wait],
            &[K::Wait, K::AsksModify, K::Wait],
        ),
        ("front.answers", Prepared::Held, &[K::AnswersBad], &[K::Wait]),
    ];
    for (below, state, one, other) in parts {
        let [one, other] = [one, other].map(|way| after(state, way));
        assert_ne!(
            part(&one.anatomy().1, below),
            part(&other.anatomy().1, below),
            "{below}"
        );
        assert_ne!(one.fingerprint(), other.fingerprint(), "{below}");
    }
}

#[test]
fn each_rule_is_about_something() {
    let mut met = vec![false; RULES.len()];
    for state in Prepared::all() {
        let start = state.world();
        let mut sequences: Vec<_> = Kind::all(start.hovers()).into_iter().map(|kind| vec![kind]).collect();
        sequences.push(vec![Kind::AnswersMissing, Kind::AsksInterrupt]);
        sequences.push(vec![Kind::NavigationOutside, Kind::WaitTen]);
        for sequence in sequences {
            let world = after(*state, &sequence);
            for (known, new) in met.iter_mut().zip(world.anatomy().0) {
                *known |= new;
            }
        }
    }
    let unmet: Vec<_> = RULES.iter().zip(&met).filter(|(_, met)| !**met).collect();
    let unmet: Vec<_> = unmet.iter().map(|(rule, _)| (rule.of, rule.field)).collect();
    assert!(unmet.is_empty(), "{unmet:?}");
}

#[test]
fn the_rules_of_a_type_stand_together_and_say_why() {
    let mut types: Vec<&str> = RULES.iter().map(|rule| rule.of).collect();
    types.dedup();
    let mut once = types.clone();
    once.sort_unstable();
    once.dedup();
    assert_eq!(once.len(), types.len(), "{types:?}");
    assert!(RULES.iter().all(|rule| !rule.why.is_empty()));
}

/// What a fingerprint leaves out must not matter: two states that it takes for the same go on the same, whatever happens.
#[test]
fn what_counts_as_the_same_goes_on_the_same() {
    let (mut pairs, mut apart) = (0, Vec::new());
    for state in Prepared::all() {
        let start = state.world();
        let kinds = Kind::all(start.hovers());
        let mut known = BTreeMap::from([(start.fingerprint(), start.clone())]);
        for first in &kinds {
            let one = after(*state, &[*first]);
            for second in &kinds {
                let mut two = one.clone();
                assert_eq!(two.step(*second), Ok(()));
                let Some(same) = known.get(&two.fingerprint()) else {
                    known.insert(two.fingerprint(), two);
                    continue;
                };
                pairs += 1;
                // Other kinds from each: together they are all tried often.
                for kind in kinds.iter().skip(pairs % STRIDE).step_by(STRIDE) {
                    let [one, other] = [same, &two].map(|world| {
                        let mut world = world.clone();
                        let stepped = world.step(*kind);
                        (stepped, world)
                    });
                    let of = format!("{}: {first:?}, {second:?}, {kind:?}", state.name());
                    assert_eq!(one.0, other.0, "{of}");
                    if one.1.fingerprint() != other.1.fingerprint() {
                        apart.push((of, differ(&one.1, &other.1)));
                    }
                }
            }
        }
    }
    assert!(pairs > 1000, "{pairs}");
    assert!(
        apart.is_empty(),
        "{} of {pairs}: {:#?}",
        apart.len(),
        &apart[..apart.len().min(20)]
    );
}
