//! The random part of every echo: complex Gaussian numbers, correlated over the length of a pulse.
//!
//! An echo from many scatterers is the sum of many waves of random phase, so its two quadratures are Gaussian and its
//! envelope is Rayleigh (Goodman, *Some fundamental properties of speckle*, Journal of the Optical Society of America
//! 66, 1976). Two samples less than a pulse apart share scatterers. Here a sample is the sum of the last `length` of a
//! series of independent numbers, so its correlation falls in a straight line to zero over `length` samples: that of a
//! rectangular pulse.

use backseat_units::math::{ln, sin_cos};
use backseat_world::Stream;

/// Number of complex numbers in the table. It is a power of two: a draw is an index.
const TABLE: usize = 4096;
/// Standard deviation of each quadrature in the table.
const SIGMA: f64 = 4096.0;
/// The golden angle over a turn: the points of the table are spread evenly around the circle.
const GOLDEN: f64 = 0.381_966_011_250_105_1;

/// A source of speckle.
#[derive(Clone, Debug)]
pub(crate) struct Speckle {
    /// Complex Gaussian numbers with one even share of the probability each: the radii are the quantiles of the Rayleigh
    /// distribution. Whole numbers make running sums exact.
    table: Box<[[i16; 2]; TABLE]>,
    draws: Vec<u16>,
    /// The last ping's speckle, in units of [`Self::norm`].
    pub(crate) quadratures: Vec<[i32; 2]>,
    /// Mean square of the envelope of `quadratures`.
    norm: f32,
    name: String,
    seed: u64,
}

/// The generator of one ping: SplitMix64 (Steele, Lea and Flood, *Fast splittable pseudorandom number generators*,
/// OOPSLA 2014). It is started by a number from the ping's own ChaCha8 stream.
struct SplitMix(u64);

impl SplitMix {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }
}

impl Speckle {
    pub(crate) fn new(seed: u64, name: String) -> Self {
        let mut table = Box::new([[0; 2]; TABLE]);
        for (number, entry) in table.iter_mut().enumerate() {
            // The middle of each share of the probability.
            let share = (number as f64 + 0.5) / TABLE as f64;
            let radius = SIGMA * (-2.0 * ln(share)).sqrt();
            let (sin, cos) = sin_cos(core::f64::consts::TAU * (number as f64 * GOLDEN).fract());
            *entry = [(radius * cos).round() as i16, (radius * sin).round() as i16];
        }
        Self {
            table,
            draws: Vec::new(),
            quadratures: Vec::new(),
            norm: 1.0,
            name,
            seed,
        }
    }

    /// Draws the speckle of a ping: `count` samples, correlated over `length` of them. It depends on nothing but the
    /// seed, the name and the number of the ping.
    pub(crate) fn draw(&mut self, ping: u32, count: usize, length: usize) {
        let length = length.max(1);
        let mut generator = SplitMix(Stream::new(self.seed, &format!("{} ping {ping}", self.name)).next_u64());
        let needed = count + length - 1;
        self.draws.clear();
        self.draws.reserve(needed + 4);
        while self.draws.len() < needed {
            let bits = generator.next();
            let index = |shift: u32| (bits >> shift) as u16 & (TABLE as u16 - 1);
            self.draws
                .extend_from_slice(&[index(0), index(16), index(32), index(48)]);
        }
        self.norm = (2.0 * SIGMA * SIGMA * length as f64) as f32;
        self.quadratures.clear();
        let (table, draws) = (&self.table, &self.draws);
        let number = |draw: &u16| {
            let [i, q] = table[usize::from(*draw) & (TABLE - 1)];
            [i32::from(i), i32::from(q)]
        };
        if length == 1 {
            self.quadratures.extend(draws.iter().take(count).map(number));
            return;
        }
        let mut sum = [0; 2];
        for draw in &draws[..length - 1] {
            let [i, q] = number(draw);
            sum = [sum[0] + i, sum[1] + q];
        }
        let pairs = draws[length - 1..].iter().zip(draws).take(count);
        self.quadratures.extend(pairs.map(|(newest, oldest)| {
            let [i, q] = number(newest);
            let [old_i, old_q] = number(oldest);
            let here = [sum[0] + i, sum[1] + q];
            sum = [here[0] - old_i, here[1] - old_q];
            here
        }));
    }

    /// What makes the mean square of the envelope of the quadratures 1.
    pub(crate) fn norm(&self) -> f32 {
        self.norm
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Envelopes with a mean square of 1.
    fn envelopes(ping: u32, count: usize, length: usize) -> Vec<f64> {
        let mut speckle = Speckle::new(5, "test".to_owned());
        speckle.draw(ping, count, length);
        assert_eq!(speckle.quadratures.len(), count);
        let norm = f64::from(speckle.norm());
        let square = |&[i, q]: &[i32; 2]| (f64::from(i) * f64::from(i) + f64::from(q) * f64::from(q)) / norm;
        speckle.quadratures.iter().map(|one| square(one).sqrt()).collect()
    }

    fn mean(values: &[f64]) -> f64 {
        values.iter().sum::<f64>() / values.len() as f64
    }

    #[test]
    fn the_envelope_is_rayleigh() {
        for length in [1, 2, 9] {
            let count = 200_000;
            let envelope = envelopes(1, count, length);
            let mean_square = mean(&envelope.iter().map(|x| x * x).collect::<Vec<_>>());
            assert!((mean_square - 1.0).abs() < 0.02, "{length}: {mean_square}");
            let centre = mean(&envelope);
            let deviation = (mean_square - centre * centre).sqrt();
            // sqrt(pi / (4 - pi)).
            assert!(
                (centre / deviation - 1.913).abs() < 0.02,
                "{length}: {}",
                centre / deviation
            );
            // The share beyond twice the root mean square is e^-4.
            let beyond = envelope.iter().filter(|x| **x > 2.0).count() as f64 / count as f64;
            assert!((beyond / 0.018_316 - 1.0).abs() < 0.1, "{length}: {beyond}");
        }
    }

    #[test]
    fn samples_within_a_pulse_are_correlated_and_others_are_not() {
        let mut speckle = Speckle::new(5, "test".to_owned());
        let length = 8;
        speckle.draw(3, 100_000, length);
        let at = |lag: usize| -> f64 {
            let pairs = speckle.quadratures.iter().zip(&speckle.quadratures[lag..]);
            let sum: f64 = pairs.map(|(one, other)| f64::from(one[0]) * f64::from(other[0])).sum();
            sum / (100_000 - lag) as f64 / (0.5 * f64::from(speckle.norm()))
        };
        for (lag, expected) in [(0, 1.0), (2, 0.75), (4, 0.5), (8, 0.0), (20, 0.0)] {
            assert!((at(lag) - expected).abs() < 0.03, "{lag}: {}", at(lag));
        }
    }

    #[test]
    fn a_ping_depends_on_its_number_alone() {
        assert_eq!(envelopes(7, 100, 3), envelopes(7, 100, 3));
        assert_ne!(envelopes(7, 100, 3), envelopes(8, 100, 3));
        let mut one = Speckle::new(5, "test".to_owned());
        one.draw(1, 5000, 17);
        one.draw(7, 100, 3);
        let mut other = Speckle::new(5, "test".to_owned());
        other.draw(7, 100, 3);
        assert_eq!(one.quadratures, other.quadratures);
        let mut named = Speckle::new(5, "another".to_owned());
        named.draw(7, 100, 3);
        assert_ne!(named.quadratures, other.quadratures);
    }
}
