#![expect(clippy::disallowed_methods, reason = "a benchmark reads the clock")]

use std::time::Instant;

/// Rounds of a row; ours and the floor take turns, and the best of each counts.
const ROUNDS: usize = 15;

/// The first two lines of a table of [`row`]s.
pub const HEADER: &str = "| work | ours | floor | ratio | aim |\n|---|---|---|---|---|";

/// Nanoseconds of one call, the best of some batches, for two in turn.
pub fn in_turn(calls: u32, mut ours: impl FnMut(), mut floor: impl FnMut()) -> (f64, f64) {
    let (mut best_ours, mut best_floor) = (f64::MAX, f64::MAX);
    for _ in 0..ROUNDS {
        best_ours = best_ours.min(batch(calls, &mut ours));
        best_floor = best_floor.min(batch(calls, &mut floor));
    }
    (best_ours, best_floor)
}

fn batch(calls: u32, work: &mut impl FnMut()) -> f64 {
    let start = Instant::now();
    for _ in 0..calls {
        work();
    }
    start.elapsed().as_nanos() as f64 / f64::from(calls)
}

/// Prints one row: nanoseconds of ours and of the floor, what the floor is, and what is aimed at.
pub fn row(work: &str, (ours, floor): (f64, f64), floor_is: &str, aim: &str) {
    println!(
        "| {work} | {ours:.0} ns | {floor:.0} ns ({floor_is}) | {:.2} | {aim} |",
        ours / floor
    );
}
