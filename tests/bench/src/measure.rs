#![expect(clippy::disallowed_methods, reason = "a benchmark reads the clock")]

use std::time::Instant;

/// Rounds of a row; our code and the floor take turns.
const ROUNDS: usize = 15;
/// Parts of a round. The best part counts: a part is short enough to run often without interruption.
const PARTS: u32 = 16;

/// The first two lines of a table of [`row`]s.
pub const HEADER: &str = "| work | ours | floor | ratio | aim |\n|---|---|---|---|---|";

/// Nanoseconds of one call, for two functions in turn. One measurement is a sixteenth of the calls; work that differs
/// from call to call should go through all its kinds in that.
pub fn in_turn(calls: u32, mut ours: impl FnMut(), mut floor: impl FnMut()) -> (f64, f64) {
    let (mut best_ours, mut best_floor) = (f64::MAX, f64::MAX);
    for _ in 0..ROUNDS {
        best_ours = best_ours.min(round(calls, &mut ours));
        best_floor = best_floor.min(round(calls, &mut floor));
    }
    (best_ours, best_floor)
}

fn round(calls: u32, work: &mut impl FnMut()) -> f64 {
    let part = calls.div_ceil(PARTS);
    (0..calls.div_ceil(part))
        .map(|_| batch(part, work))
        .fold(f64::MAX, f64::min)
}

fn batch(calls: u32, work: &mut impl FnMut()) -> f64 {
    let start = Instant::now();
    for _ in 0..calls {
        work();
    }
    start.elapsed().as_nanos() as f64 / f64::from(calls)
}

/// Prints one row: nanoseconds of our code and of the floor, a description of the floor, and the aim.
pub fn row(work: &str, (ours, floor): (f64, f64), floor_is: &str, aim: &str) {
    println!(
        "| {work} | {ours:.0} ns | {floor:.0} ns ({floor_is}) | {:.2} | {aim} |",
        ours / floor
    );
}

/// Seconds for work that is repeated exactly: the best repetition of each of its stages, summed.
#[must_use]
pub fn best_stages(repetitions: &[Vec<f64>]) -> f64 {
    let stages = repetitions.iter().map(Vec::len).min().unwrap_or(0);
    let best = |stage: usize| repetitions.iter().map(|times| times[stage]).fold(f64::MAX, f64::min);
    (0..stages).map(best).sum()
}

/// Measures one stage after another.
#[derive(Debug)]
pub struct Stages {
    start: Instant,
    seconds: Vec<f64>,
}

impl Stages {
    /// The first stage begins.
    #[must_use]
    pub fn start() -> Self {
        Self {
            start: Instant::now(),
            seconds: Vec::new(),
        }
    }

    /// A stage ends, and the next one begins.
    pub fn end(&mut self) {
        let now = Instant::now();
        self.seconds.push((now - self.start).as_secs_f64());
        self.start = now;
    }

    /// The seconds of each stage that has ended.
    #[must_use]
    pub fn seconds(self) -> Vec<f64> {
        self.seconds
    }
}
