use std::time::Duration;

use backseat_world::Stream;

/// Random numbers of a seed, from a stream with a name of its own.
pub(crate) struct Dice(Stream);

impl Dice {
    pub(crate) fn new(seed: u64, name: &str) -> Self {
        Self(Stream::new(seed, name))
    }

    pub(crate) fn seed(&mut self) -> u64 {
        // TOML's integers are signed.
        self.0.next_u64() >> 1
    }

    pub(crate) fn chance(&mut self, chance: f64) -> bool {
        self.0.uniform() < chance
    }

    pub(crate) fn between(&mut self, least: f64, most: f64) -> f64 {
        self.0.uniform_in(least, most)
    }

    /// A number in whole thousandths, so that it is the same after being written and read.
    pub(crate) fn figure(&mut self, least: f64, most: f64) -> f64 {
        (self.between(least, most) * 1000.0).round() / 1000.0
    }

    pub(crate) fn millis(&mut self, least_s: f64, most_s: f64) -> Duration {
        Duration::from_millis((self.between(least_s, most_s) * 1000.0).round().max(0.0) as u64)
    }

    pub(crate) fn below(&mut self, count: usize) -> usize {
        ((self.0.uniform() * count as f64) as usize).min(count.saturating_sub(1))
    }

    pub(crate) fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())]
    }
}
