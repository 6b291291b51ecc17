//! Follows the vehicle's course as its behaviors begin and end, and as navigation comes.

use backseat_spi::BehaviorId;
use backseat_units::EastNorth;
use backseat_units::math::hypot;

use crate::context::Context;
use crate::vehicle::course::{Begin, Flown, is_on};
use crate::vehicle::navigation::Jump;

/// A behavior has begun here.
pub(super) fn began(cx: &mut Context, number: Option<u32>, identifier: Option<BehaviorId>) {
    let planned = number.map(Flown::Planned);
    let Some(flown) = identifier.map(Flown::Inserted).or(planned) else {
        return;
    };
    // Where an insert begins that is not ours does not matter, because nothing of ours steers while it is flown.
    let ours = identifier.is_none_or(|identifier| cx.ledger.by_identifier(identifier).is_some());
    if ours && cx.vehicle.courses.may_have_begun_unheard(flown) {
        cx.vehicle.courses.resumed(flown);
    } else {
        let here = cx.outlook().begins_here();
        cx.vehicle.courses.began(cx.now, flown, here);
    }
    if identifier.is_some_and(|identifier| may_interrupt(cx, identifier)) {
        cx.vehicle.courses.leave_plan();
    }
}

/// An insert that this process does not know may have interrupted too.
fn may_interrupt(cx: &Context, identifier: BehaviorId) -> bool {
    let insert = |request| cx.ledger.get(request)?.insert;
    let known = cx.ledger.by_identifier(identifier).and_then(insert);
    known.is_none_or(|insert| insert.interrupt)
}

/// A message or the link was lost. An insert that interrupts may have begun and ended meanwhile.
pub(super) fn lost(cx: &mut Context) {
    if cx.ledger.interrupts() {
        cx.vehicle.courses.leave_plan();
    }
    cx.vehicle.courses.invalidate_after_loss();
}

/// Navigation has come, perhaps with a jump. If it jumped close to a begin, the vehicle may have believed then that it
/// was at either place.
pub(super) fn navigated(cx: &mut Context, jump: Option<Jump>) {
    let Some(mut here) = cx.outlook().begins_here() else {
        return;
    };
    let solution = cx.vehicle.navigation.newest().map(|newest| newest.solution);
    let before = jump.map(|jump| Begin {
        at: jump.from,
        within_m: cx.monitor.limits().speed_max_mps * jump.elapsed_s,
    });
    here.within_m += before.map_or(0.0, |before| before.within_m);
    cx.vehicle.courses.navigated(before, here, solution);
}

/// A behavior has ended, finally or because another one interrupts it. Core does not know what is flown until another
/// begins.
pub(super) fn ended(cx: &mut Context, number: Option<u32>, identifier: Option<BehaviorId>) {
    let ended = identifier.map(Flown::Inserted).or(number.map(Flown::Planned));
    let current = cx.vehicle.courses.current();
    // If core has only seen what is flown, any end means that something else is flown now.
    if ended.is_some() && (current.is_none() || ended == current) {
        cx.vehicle.courses.unknown();
    }
    let Some(identifier) = identifier else { return };
    if may_interrupt(cx, identifier) {
        // Nobody may have heard it begin.
        cx.vehicle.courses.leave_plan();
    }
    let entry = cx.ledger.by_identifier(identifier);
    if !entry.is_some_and(|request| cx.ledger.get(request).is_some_and(|entry| entry.interrupted)) {
        cx.vehicle.courses.ended(identifier);
    }
}

/// Notes whether the vehicle is on its line while no request of ours steers. From then on, it is no longer on the way
/// to that line.
pub(super) fn watch(cx: &mut Context) {
    if cx.arbiter.is_steering() {
        return cx.vehicle.courses.led_away();
    }
    let Some(navigation) = cx.vehicle.navigation.newest().copied() else {
        return;
    };
    cx.vehicle
        .courses
        .flies_at(hypot(navigation.east_mps, navigation.north_mps));
    let vertical = [navigation.depth.as_m(), navigation.down_mps];
    let after_another = !cx.vehicle.previous_run.is_none();
    // With `modify_needs_plan = false`, core does without the plan where nobody heard what is flown.
    let courses = &mut cx.vehicle.courses;
    let does_without = !cx.monitor.limits().modify_needs_plan && courses.current().is_none();
    let of_plan = courses.flies_plan() || (does_without && courses.placed().is_empty());
    courses.levels(cx.now, vertical, of_plan, after_another);
    let velocity = EastNorth::new(navigation.east_mps, navigation.north_mps);
    let within_m = cx.monitor.limits().tracking_error_m;
    let is_on = |line| is_on(line, navigation.local, velocity, within_m);
    match cx.vehicle.courses.current() {
        None => {
            let mut paths: Vec<Flown> = Vec::new();
            let outlook = cx.outlook();
            let lines = match cx.vehicle.courses.resumes() {
                // The way to its line may run along the line of another.
                Some(flown) => outlook
                    .first_line_of(flown)
                    .map(|line| (flown, line))
                    .into_iter()
                    .collect(),
                None => outlook.lines_that_may_be_flown(),
            };
            for (flown, line) in lines {
                if is_on(line) && !paths.contains(&flown) {
                    paths.push(flown);
                }
            }
            if cx.vehicle.courses.placed().is_empty() && cx.vehicle.courses.keeps_to(cx.now, &paths) {
                cx.vehicle.plan.seen_at(cx.vehicle.courses.placed());
            }
        }
        Some(current) if cx.vehicle.courses.is_placed_on(current) => {}
        Some(current) => {
            let on_line = cx.outlook().first_line_of(current).is_some_and(is_on);
            cx.vehicle.courses.is_on_line(cx.now, current, on_line);
        }
    }
}
