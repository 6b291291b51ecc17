//! Follows the vehicle's course as its behaviors begin and end, and as navigation comes.

use std::time::Duration;

use backseat_spi::BehaviorId;
use backseat_units::math::hypot;
use backseat_units::{EastNorth, Timestamp};

use crate::context::Context;
use crate::plugin::NavigationSample;
use crate::timer::Timer;
use crate::vehicle::course::{Begin, Flown, Sighting, is_on};
use crate::vehicle::navigation::Jump;

/// The vehicle forgets a modify that is not refreshed (SPI 7.12).
const MODIFY_LAPSES: Duration = Duration::from_secs(5);

/// If a message is lost while inserts wait, core asks for the plan after this time.
const WAITING_ASKED: Duration = Duration::from_secs(30);

/// A behavior has begun here.
pub(super) fn began(cx: &mut Context, number: Option<u32>, identifier: Option<BehaviorId>) {
    let planned = number.map(Flown::Planned);
    let Some(flown) = identifier.map(Flown::Inserted).or(planned) else {
        return;
    };
    // Where an insert begins that is not ours does not matter, because nothing of ours steers while it is flown.
    let ours = identifier.is_none_or(|identifier| cx.ledger.by_identifier(identifier).is_some());
    if let Some(identifier) = identifier {
        let known = cx.ledger.sent(identifier).is_some();
        let interrupts = may_interrupt(cx, identifier);
        cx.vehicle.courses.inserts(identifier, known, interrupts);
    }
    if let Some(over) = cx.ledger.begins(identifier) {
        cx.vehicle.courses.ended(over);
    }
    if ours && cx.vehicle.courses.may_have_begun_unheard(flown) {
        cx.vehicle.courses.resumed(flown);
    } else {
        let here = cx.outlook().begins_here();
        cx.vehicle.courses.began(cx.now, flown, here);
    }
    if let Some(identifier) = identifier {
        inserted(cx, identifier);
    }
}

/// An insert may have begun or ended, and its place in the order of behaviors is not known.
pub(super) fn may_have_begun(cx: &mut Context, identifier: BehaviorId) {
    if cx.ledger.sent(identifier).is_none() {
        cx.vehicle.courses.leave_foreign();
    }
    inserted(cx, identifier);
}

/// The vehicle begins or ends an insert. Nobody may have heard it begin.
fn inserted(cx: &mut Context, identifier: BehaviorId) {
    named(cx, identifier);
    if may_interrupt(cx, identifier) {
        cx.vehicle.courses.leave_plan();
    }
}

/// The vehicle names an insert, in its plan or as it begins or ends. It may be another payload's.
pub(super) fn named(cx: &mut Context, identifier: BehaviorId) {
    if !cx.identifiers.is_ours(identifier) && !cx.vehicle.previous_run.includes(identifier) {
        cx.vehicle.courses.is_shared();
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
    // Another payload's insert may have begun, and interrupted what we heard end.
    let waits = cx.ledger.lost_begin(cx.now, cx.vehicle.courses.shared());
    let others = cx.outlook().others().next().is_some() || cx.vehicle.previous_run.has_left();
    if (waits || others) && cx.link.is_up() {
        // The plan shows which inserts still wait.
        cx.timers.set_unless_set(Timer::Plan, cx.now + WAITING_ASKED);
    }
    if cx.ledger.interrupts() || cx.vehicle.courses.shared() || cx.outlook().previous_run_may_fly() {
        cx.vehicle.courses.leave_plan();
    }
    cx.vehicle.courses.invalidate_after_loss();
}

/// The link is lost, or was lost in a previous run. If a modify that was sent at this time at the latest leads the vehicle, it may do
/// so until the vehicle forgets it.
pub(super) fn may_be_led(cx: &mut Context, sent: Timestamp) {
    let delay = Duration::from_secs_f64(cx.monitor.limits().link_delay_max_s);
    cx.vehicle.courses.may_be_led_until(sent + MODIFY_LAPSES + delay);
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
    if let Some(identifier) = identifier {
        inserted(cx, identifier);
    }
}

/// Notes whether the vehicle is on its line while no request of ours steers. From then on, it is no longer on the way
/// to that line.
pub(super) fn watch(cx: &mut Context) {
    if cx.arbiter.is_steering() || cx.vehicle.courses.may_be_led(cx.now) {
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
        None if cx.vehicle.courses.placed().is_empty() => look(cx, &navigation, is_on),
        None => {}
        Some(current) if cx.vehicle.courses.is_placed_on(current) => {}
        Some(current) => {
            let on_line = cx.outlook().first_line_of(current).is_some_and(is_on);
            cx.vehicle.courses.is_on_line(cx.now, current, on_line);
        }
    }
}

/// Nobody has heard what is flown: looks for the planned behaviors along whose lines the vehicle moves.
fn look(cx: &mut Context, navigation: &NavigationSample, is_on: impl Fn((EastNorth, EastNorth)) -> bool) {
    let outlook = cx.outlook();
    let lines = match cx.vehicle.courses.resumes() {
        // The way to its line may run along the line of another.
        Some(number) => outlook
            .first_line_of(Flown::Planned(number))
            .map(|line| (number, line))
            .into_iter()
            .collect(),
        None => outlook.lines_that_may_be_flown(),
    };
    let velocity = EastNorth::new(navigation.east_mps, navigation.north_mps);
    let ahead = outlook.ahead(navigation.local, velocity);
    let mut along: Vec<u32> = Vec::new();
    for (number, line) in lines {
        if is_on(line) && !along.contains(&number) {
            along.push(number);
        }
    }
    if !cx.vehicle.courses.keeps_to(cx.now, &along, ahead) {
        return;
    }
    let sighted = match cx.vehicle.courses.resumes() {
        Some(number) => vec![Sighting {
            number,
            on_first_line: true,
            comes_from: None,
        }],
        None => cx.outlook().sighted(&along, navigation, is_on),
    };
    cx.vehicle.courses.seen_on(&sighted);
    cx.vehicle.plan.seen_at(cx.vehicle.courses.placed());
}
