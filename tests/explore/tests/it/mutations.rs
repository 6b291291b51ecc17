//! Checks of core that are left out, in a build for that alone: each must be found by a short sequence.
//!
//! `cargo nextest run -p backseat-explore --features mutations`: leaving out is the whole process's.

use backseat_core::mutations::{Check, leave_none_out, leave_out};
use backseat_explore::{Kind, Prepared};

use crate::bounded::explored;

/// The check, where it shows, the rule, and a shortest sequence that breaks it.
fn planted() -> Vec<(Check, Prepared, &'static str, &'static [Kind])> {
    use Kind as K;
    use Prepared as P;
    vec![
        (
            Check::ControlLossEndsLease,
            P::Lease,
            "SR-014 lease without control",
            &[K::ControlTaken],
        ),
        (
            Check::OperatorHold,
            P::InsertFlown,
            "SR-001 control",
            &[K::Hold, K::AsksModify],
        ),
        (
            Check::MissionRuns,
            P::Lease,
            "SR-014 lease without control",
            &[K::MissionAborts],
        ),
        (Check::LateWake, P::Lease, "SR-003 late wake", &[K::WakesLate]),
        (
            Check::NavigationFresh,
            P::Lease,
            "SR-008 stale navigation",
            &[K::NavigationMissing, K::Wait],
        ),
        (Check::InsertFence, P::Lease, "SR-002 insert outside", &[K::AsksOutside]),
        (
            Check::IdentifiersReserved,
            P::Lease,
            "SR-009 reserved",
            &[K::AsksInsert],
        ),
        (
            Check::InterruptOfInterrupt,
            P::Interrupting,
            "SR-010 interrupt of an interrupt",
            &[K::AsksInterrupt],
        ),
        (
            Check::InsertsOpen,
            P::InsertSent,
            "SR-019 open inserts",
            &[K::AsksInsert, K::AsksInsert],
        ),
        (Check::StationEndSaid, P::Hovering, "SR-005 one helm", &[K::AsksModify]),
        (
            Check::DiveIdentity,
            P::Lease,
            "SR-025 plan",
            &[K::OtherDive, K::AsksModify],
        ),
    ]
}

#[test]
fn each_check_that_is_left_out_is_found() {
    for (check, state, rule, sequence) in planted() {
        leave_out(check);
        let world = state.world();
        let searched = explored(&world, &Kind::all(world.hovers()), sequence.len(), 2);
        leave_none_out();
        let found = searched.found.get(rule).map(|found| &found.sequence);
        assert_eq!(
            found.map(Vec::as_slice),
            Some(sequence),
            "{check:?}: {:#?}",
            searched.found
        );
    }
}
