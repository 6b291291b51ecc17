use std::sync::LazyLock;

use backseat_units::math::{exp, ln};
use backseat_world::Stream;

/// The noise of one source, as a function of the reading's number.
///
/// The noise of a reading depends only on seed, source and number. So a reading that nobody needs costs nothing, and
/// leaving it out changes no other reading. The key is drawn from the source's [`Stream`], and SplitMix64 makes the
/// numbers from the key (Steele, Lea and Flood, "Fast Splittable Pseudorandom Number Generators", 2014).
#[derive(Clone, Copy, Debug)]
pub(super) struct Noise {
    key: u64,
}

impl Noise {
    pub(super) fn new(seed: u64, source: &str) -> Self {
        Self {
            key: Stream::new(seed, source).next_u64(),
        }
    }

    /// The random numbers of one reading. Always draw them in the same order.
    pub(super) fn reading(self, number: u64) -> Draws {
        Draws {
            state: mix(self.key ^ number.wrapping_mul(0xD1B5_4A32_D192_ED03)),
            ziggurat: &ZIGGURAT,
        }
    }
}

/// The random numbers of one reading.
#[derive(Clone, Debug)]
pub(super) struct Draws {
    state: u64,
    ziggurat: &'static Ziggurat,
}

impl Draws {
    fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        mix(self.state)
    }

    /// Uniform in [0, 1), in steps of 2^-53.
    pub(super) fn uniform(&mut self) -> f64 {
        (self.bits() >> 11).cast_signed() as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Normal, mean 0 and standard deviation 1.
    pub(super) fn gaussian(&mut self) -> f64 {
        loop {
            let bits = self.bits();
            let layer = (bits & (LAYERS as u64 - 1)) as usize;
            // In [-1, 1), from the 53 high bits. The layer uses seven of the low bits.
            let side = (bits.cast_signed() >> 11) as f64 * (1.0 / (1u64 << 52) as f64);
            let [outer, inner] = [self.ziggurat.edges[layer], self.ziggurat.edges[layer + 1]];
            let x = side * outer;
            if x.abs() < inner {
                return x;
            }
            if layer == 0 {
                return self.tail(side < 0.0);
            }
            let below = exp(-0.5 * (outer * outer - x * x));
            let above = exp(-0.5 * (inner * inner - x * x));
            if above + self.uniform() * (below - above) < 1.0 {
                return x;
            }
        }
    }

    /// A normal number with this standard deviation.
    pub(super) fn normal(&mut self, deviation: f64) -> f64 {
        deviation * self.gaussian()
    }

    /// A number beyond the edge of the lowest layer (Marsaglia, "Generating a Variable from the Tail of the Normal
    /// Distribution", 1964).
    fn tail(&mut self, left: bool) -> f64 {
        loop {
            let x = -ln(1.0 - self.uniform()) / EDGE;
            let y = -ln(1.0 - self.uniform());
            if 2.0 * y >= x * x {
                return if left { -(EDGE + x) } else { EDGE + x };
            }
        }
    }
}

const fn mix(bits: u64) -> u64 {
    let bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    bits ^ (bits >> 31)
}

const LAYERS: usize = 128;
/// Where the tail begins; [`AREA`] is the area of each layer (Marsaglia and Tsang, "The Ziggurat Method for Generating
/// Random Variables", 2000; the algorithm is that of Doornik, "An Improved Ziggurat Method", 2005).
const EDGE: f64 = 3.442_619_855_899;
const AREA: f64 = 9.912_563_035_262_17e-3;

#[derive(Debug)]
struct Ziggurat {
    /// The edge of each layer, from the lowest to the top, which is 0.
    edges: [f64; LAYERS + 1],
}

static ZIGGURAT: LazyLock<Ziggurat> = LazyLock::new(|| {
    let mut edges = [0.0; LAYERS + 1];
    let mut height = exp(-0.5 * EDGE * EDGE);
    edges[0] = AREA / height;
    edges[1] = EDGE;
    for layer in 2..LAYERS {
        edges[layer] = (-2.0 * ln(AREA / edges[layer - 1] + height)).sqrt();
        height = exp(-0.5 * edges[layer] * edges[layer]);
    }
    Ziggurat { edges }
});

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reading_is_a_function_of_seed_source_and_number() {
        let first = |seed, source, number| Noise::new(seed, source).reading(number).gaussian();
        assert_eq!(first(1, "depth", 7), first(1, "depth", 7));
        assert_ne!(first(1, "depth", 7), first(1, "depth", 8));
        assert_ne!(first(1, "depth", 7), first(2, "depth", 7));
        assert_ne!(first(1, "depth", 7), first(1, "compass", 7));
    }

    #[test]
    fn the_numbers_never_change() {
        // An independent SplitMix64 and ziggurat give the same numbers, except for the last digit of another `exp`.
        // Recorded runs depend on them.
        let mut draws = Noise { key: 0 }.reading(0);
        assert_eq!(
            draws.bits(),
            0xE220_A839_7B1D_CDAF,
            "the first number of SplitMix64 for seed 0"
        );
        let mut draws = Noise { key: 1 }.reading(1);
        let drawn: Vec<f64> = (0..3).map(|_| draws.gaussian()).collect();
        assert_eq!(drawn, GOLDEN);
    }

    const GOLDEN: [f64; 3] = [
        0.055_502_279_997_599_58,
        0.866_864_718_042_559_9,
        -1.388_499_392_744_721_3,
    ];

    #[test]
    fn normal_numbers_have_the_right_moments_and_tails() {
        let noise = Noise::new(3, "moments");
        let count = 400_000_u32;
        // A few numbers of each reading, as the sensors draw them.
        let drawn: Vec<f64> = (0..u64::from(count) / 4)
            .flat_map(|number| {
                let mut draws = noise.reading(number);
                [(); 4].map(|()| draws.gaussian())
            })
            .collect();
        let mean_of = |of: fn(f64) -> f64| drawn.iter().map(|x| of(*x)).sum::<f64>() / f64::from(count);
        assert!(mean_of(|x| x).abs() < 0.005 && (mean_of(|x| x * x) - 1.0).abs() < 0.008);
        assert!(mean_of(|x| x * x * x).abs() < 0.02 && (mean_of(|x| x * x * x * x) - 3.0).abs() < 0.06);
        for (beyond, share) in [(0.5, 0.617_075), (1.959_964, 0.05), (3.0, 0.002_700), (3.5, 0.000_465)] {
            let found = drawn.iter().filter(|x| x.abs() > beyond).count() as f64 / f64::from(count);
            let spread = (share / f64::from(count)).sqrt();
            assert!((found - share).abs() < 4.5 * spread, "{beyond} {found} {share}");
        }
        // Neighbours are not correlated, neither within a reading nor from one to the next.
        for lag in [1, 2, 4] {
            let product: f64 = drawn.windows(lag + 1).map(|pair| pair[0] * pair[lag]).sum();
            assert!((product / f64::from(count)).abs() < 0.008, "{lag}");
        }
    }
}
