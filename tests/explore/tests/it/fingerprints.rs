//! What a fingerprint tells apart, and what not.

use std::time::Duration;

use backseat_explore::{Kind, Prepared, RULES, World};

fn after(state: Prepared, sequence: &[Kind]) -> World {
    let mut world = state.world();
    for kind in sequence {
        assert_eq!(world.step(*kind), Ok(()));
    }
    world
}

/// The words of a fingerprint that come of the fields below this one.
fn part<'a>(words: &'a [String], below: &str) -> Vec<&'a String> {
    words.iter().filter(|word| word.starts_with(below)).collect()
}

#[test]
fn the_same_state_at_another_time_is_the_same() {
    for state in Prepared::all() {
        let [now, later] = [0, 20].map(|later_s| state.world_after(Duration::from_secs(later_s)));
        let differ = now
            .anatomy()
            .1
            .into_iter()
            .zip(later.anatomy().1)
            .filter(|(now, later)| now != later);
        assert_eq!(differ.collect::<Vec<_>>(), [], "{}", state.name());
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
