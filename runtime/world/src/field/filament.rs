use backseat_units::math::{TAU, exp, sin, sin_cos};
use backseat_units::{EastNorth, Timestamp};
use serde::Deserialize;

use super::{Adds, zero};
use crate::error::{WorldError, check};
use crate::span::Span;
use crate::stream::Stream;

/// One `[[field.filaments]]`: a permanent source whose water drifts away as a meandering filament of puffs. It is the
/// same at all depths unless it has a depth.
///
/// The model is the filament plume of Farrell, Murlis, Long, Li and Cardé (*Filament-based atmospheric dispersion model
/// to achieve short time-scale structure of odor plumes*, Environmental Fluid Mechanics 2, 2002), in closed form:
///
/// - Across its centreline it is a Gaussian. The variance grows with the distance x from the source as σ² = σ₀² +
///   2Kx/U, and the strength falls as σ₀/σ (Fickian spread in one direction: Csanady, *Turbulent Diffusion in the
///   Environment*, 1973, chapter 1).
/// - The centreline is a sum of sines that the flow carries along unchanged. Its width grows with the distance
///   (Gifford's fluctuating plume, Advances in Geophysics 6, 1959).
/// - Along the centreline there are puffs, which the flow carries along too. Their mean over time is the plume without
///   puffs, and they fade into it as (σ₀/σ)².
///
/// It does not follow the `[current]`: it has its own direction and speed.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FilamentConfig {
    /// Position of its source, metres east of the origin.
    pub east_m: Span,
    /// Position of its source, metres north of the origin.
    pub north_m: Span,
    /// The depth of the source, metres; without it, the filament is the same at all depths.
    #[serde(default)]
    pub depth_m: Option<Span>,
    /// Its vertical standard deviation, metres, 0.5 or more, if it has a depth; 5 m unless given.
    #[serde(default)]
    pub sigma_depth_m: Option<f64>,
    /// The direction in which it drifts, degrees clockwise from the frame's north.
    pub towards_deg: Span,
    /// Its drift speed, metres a second, 0.01 to 5.
    pub speed_mps: Span,
    /// Its standard deviation across the drift at the source, metres, 0.1 to 1000.
    pub sigma_m: Span,
    /// Its diffusivity, square metres a second, 0 to 100; 0.02 unless given. (Okubo, Deep-Sea Research 18, 1971, finds
    /// 0.01 to 0.1 at scales of 10 to 100 m.)
    #[serde(default = "diffusivity")]
    pub diffusivity_m2_per_s: f64,
    /// Its length, metres from the source, 1 to 50000; 2000 unless given. It fades over the last tenth.
    #[serde(default = "length")]
    pub length_m: f64,
    /// The greatest distance of its centreline from the axis, metres, 0 to 1000; 0 unless given.
    #[serde(default = "zero")]
    pub meander_m: Span,
    /// Wavelength of its widest meander, metres, 5 to 20000; 150 unless given.
    #[serde(default = "wavelength")]
    pub meander_wavelength_m: Span,
    /// Distance between two puffs, metres, 0.5 to 1000; 10 unless given.
    #[serde(default = "spacing")]
    pub puff_spacing_m: f64,
    /// The part of it that is in puffs at the source, 0 to 1; 0.8 unless given.
    #[serde(default = "intermittency")]
    pub intermittency: f64,
    /// What it adds to the temperature at the source on average, degrees Celsius, within ±400. A puff adds up to about
    /// four times that.
    #[serde(default = "zero")]
    pub temperature_c: Span,
    /// What it adds to the conductivity at the source on average, microsiemens a centimetre, within ±100000.
    #[serde(default = "zero")]
    pub conductivity_us_per_cm: Span,
    /// What it adds to the tracer at the source on average, in the unit that the mission uses for it, 0 to 1e6.
    #[serde(default = "zero")]
    pub tracer: Span,
}

const fn diffusivity() -> f64 {
    0.02
}

const fn length() -> f64 {
    2000.0
}

const fn wavelength() -> Span {
    Span::fixed(150.0)
}

const fn spacing() -> f64 {
    10.0
}

const fn intermittency() -> f64 {
    0.8
}

/// Number of puffs after which the sequence repeats.
const PUFFS: usize = 32;
/// Standard deviation of a puff along the filament, in spacings. At 1.25 spacings almost nothing is left of a puff, so
/// three neighbours are enough.
const PUFF_SIGMA: f64 = 0.18;
/// The mean of puffs of strength 1 along the filament: their standard deviation times the square root of 2π.
const PUFF_MEAN: f64 = PUFF_SIGMA * 2.506_628_274_631_000_7;
/// Wavelength and part of the width of each meander. The ratio of the wavelengths is the golden ratio, so that their
/// sum does not repeat.
const MEANDERS: [(f64, f64); 3] = [(1.0, 0.6), (0.618_034, 0.3), (0.381_966, 0.1)];

#[derive(Clone, Copy, Debug, PartialEq)]
struct Puff {
    /// Position of its centre in its own spacing, 0 to 1.
    place: f64,
    strength: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Meander {
    amplitude_m: f64,
    rad_per_m: f64,
    phase_rad: f64,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Filament {
    source: EastNorth,
    /// Direction of the drift: a vector of one metre.
    along: EastNorth,
    speed_mps: f64,
    /// Variance at the source, square metres; `growth_m` is its growth per metre of distance.
    variance_m2: f64,
    growth_m: f64,
    length_m: f64,
    /// The greatest distance of the centreline from the axis; at `meander_reach_m` from the source the meanders have
    /// half of it.
    meander_m: f64,
    meander_reach_m: f64,
    meanders: [Meander; 3],
    per_spacing: f64,
    puffs: [Puff; PUFFS],
    intermittency: f64,
    depth_m: f64,
    /// One over the vertical variance; zero means the same at all depths.
    vertical_tightness: f64,
    pub(super) adds: Adds,
}

/// Draws the filaments from their own stream.
pub(super) fn draw(configs: &[FilamentConfig], seed: u64) -> Result<Vec<Filament>, WorldError> {
    let count = configs.len();
    check(count <= 8, "field.filaments", count as f64, "at most 8 filaments")?;
    let mut stream = Stream::new(seed, "filaments");
    let mut filaments = Vec::with_capacity(count);
    for config in configs {
        config.validate()?;
        filaments.push(Filament::draw(config, &mut stream));
    }
    Ok(filaments)
}

impl Filament {
    fn draw(config: &FilamentConfig, stream: &mut Stream) -> Self {
        let source = EastNorth::new(config.east_m.draw(stream), config.north_m.draw(stream));
        let (east, north) = sin_cos(config.towards_deg.draw(stream).to_radians());
        let speed_mps = config.speed_mps.draw(stream);
        let sigma_m = config.sigma_m.draw(stream);
        let meander_m = config.meander_m.draw(stream);
        let wavelength_m = config.meander_wavelength_m.draw(stream);
        let adds = Adds {
            temperature_c: config.temperature_c.draw(stream),
            conductivity_us_per_cm: config.conductivity_us_per_cm.draw(stream),
            tracer: config.tracer.draw(stream),
        };
        let (depth_m, vertical_tightness) = config.depth_m.map_or((0.0, 0.0), |depth| {
            let sigma_m = config.sigma_depth_m.unwrap_or(5.0);
            (depth.draw(stream), 1.0 / (sigma_m * sigma_m))
        });
        let meanders = MEANDERS.map(|(length, part)| Meander {
            amplitude_m: meander_m * part,
            rad_per_m: TAU / (wavelength_m * length),
            phase_rad: stream.uniform_in(0.0, TAU),
        });
        let mut puffs = [Puff {
            place: 0.5,
            strength: 1.0,
        }; PUFFS];
        for puff in &mut puffs {
            puff.place = stream.uniform_in(0.25, 0.75);
            puff.strength = stream.uniform_in(0.25, 1.75);
        }
        // Whatever was drawn, the mean over time must be the plume without puffs.
        let mean = puffs.iter().map(|puff| puff.strength).sum::<f64>() / PUFFS as f64;
        for puff in &mut puffs {
            puff.strength /= mean * PUFF_MEAN;
        }
        Self {
            source,
            along: EastNorth::new(east, north),
            speed_mps,
            variance_m2: sigma_m * sigma_m,
            growth_m: 2.0 * config.diffusivity_m2_per_s / speed_mps,
            length_m: config.length_m,
            meander_m,
            meander_reach_m: wavelength_m,
            meanders,
            per_spacing: 1.0 / config.puff_spacing_m,
            puffs,
            intermittency: config.intermittency,
            depth_m,
            vertical_tightness,
            adds,
        }
    }

    pub(super) const fn source(&self) -> EastNorth {
        self.source
    }

    /// Its strength at a place, as a multiple of the mean at the source.
    pub(super) fn share(&self, at: EastNorth, depth_m: f64, time: Timestamp) -> f64 {
        let from = at - self.source;
        let along_m = from.east_m * self.along.east_m + from.north_m * self.along.north_m;
        if along_m >= self.length_m {
            return 0.0;
        }
        let right_m = from.east_m * self.along.north_m - from.north_m * self.along.east_m;
        // Upstream of the source it falls off with the same standard deviation as across.
        let (way_m, before_m) = (along_m.max(0.0), along_m.min(0.0));
        let variance_m2 = self.variance_m2 + self.growth_m * way_m;
        let nearest_m = (right_m.abs() - self.meander_m).max(0.0);
        let below = depth_m - self.depth_m;
        let vertical = below * below * self.vertical_tightness;
        if nearest_m * nearest_m + before_m * before_m > (100.0 - vertical) * variance_m2 {
            return 0.0;
        }
        let drifted_m = along_m - self.speed_mps * time.as_secs_f64();
        let off_m = right_m - self.centreline_m(way_m, drifted_m);
        let square = (off_m * off_m + before_m * before_m) / variance_m2 + vertical;
        let left = self.variance_m2 / variance_m2;
        let fade = (10.0 * (1.0 - way_m / self.length_m)).min(1.0);
        let puffs = 1.0 + self.intermittency * left * (self.puffs_at(drifted_m) - 1.0);
        exp(-0.5 * square) * left.sqrt() * fade * puffs
    }

    /// How far the centreline is to the right of the axis, metres.
    fn centreline_m(&self, way_m: f64, drifted_m: f64) -> f64 {
        if self.meander_m == 0.0 {
            return 0.0;
        }
        let grown = way_m / (way_m + self.meander_reach_m);
        let sum = self.meanders.iter().fold(0.0, |sum, meander| {
            sum + meander.amplitude_m * sin(meander.rad_per_m * drifted_m + meander.phase_rad)
        });
        grown * sum
    }

    /// The pattern of the puffs, with mean 1, at a place that drifts with them.
    fn puffs_at(&self, drifted_m: f64) -> f64 {
        let spacings = drifted_m * self.per_spacing;
        let cell = spacings.floor();
        let within = spacings - cell;
        let index = cell as i64;
        [-1i64, 0, 1].into_iter().fold(0.0, |sum, neighbour| {
            let number = index.wrapping_add(neighbour).rem_euclid(PUFFS as i64) as usize;
            let puff = &self.puffs[number];
            let off = (within - neighbour as f64 - puff.place) * (1.0 / PUFF_SIGMA);
            sum + puff.strength * exp(-0.5 * off * off)
        })
    }
}

impl FilamentConfig {
    fn validate(&self) -> Result<(), WorldError> {
        let near = "within 50 km of the origin";
        self.east_m
            .within(-50_000.0, 50_000.0, "field.filaments.east_m", near)?;
        self.north_m
            .within(-50_000.0, 50_000.0, "field.filaments.north_m", near)?;
        let degrees = "-360 to 720 degrees";
        self.towards_deg
            .within(-360.0, 720.0, "field.filaments.towards_deg", degrees)?;
        self.speed_mps
            .within(0.01, 5.0, "field.filaments.speed_mps", "0.01 to 5 m/s")?;
        self.sigma_m
            .within(0.1, 1000.0, "field.filaments.sigma_m", "0.1 to 1000 m")?;
        self.meander_m
            .within(0.0, 1000.0, "field.filaments.meander_m", "0 to 1000 m")?;
        let key = "field.filaments.meander_wavelength_m";
        self.meander_wavelength_m.within(5.0, 20_000.0, key, "5 to 20000 m")?;
        let key = "field.filaments.temperature_c";
        self.temperature_c
            .within(-400.0, 400.0, key, "-400 to 400 degrees Celsius")?;
        let key = "field.filaments.conductivity_us_per_cm";
        self.conductivity_us_per_cm
            .within(-100_000.0, 100_000.0, key, "-100000 to 100000 uS/cm")?;
        self.tracer.within(0.0, 1e6, "field.filaments.tracer", "0 to 1000000")?;
        if let Some(depth) = self.depth_m {
            depth.within(0.0, 12_000.0, "field.filaments.depth_m", "0 to 12000 m")?;
        }
        let sigma = self.sigma_depth_m.unwrap_or(1.0);
        for (value, range, key, expected) in [
            (sigma, 0.5..=12_000.0, "field.filaments.sigma_depth_m", "0.5 to 12000 m"),
            (
                self.diffusivity_m2_per_s,
                0.0..=100.0,
                "field.filaments.diffusivity_m2_per_s",
                "0 to 100 m2/s",
            ),
            (
                self.length_m,
                1.0..=50_000.0,
                "field.filaments.length_m",
                "1 to 50000 m",
            ),
            (
                self.puff_spacing_m,
                0.5..=1000.0,
                "field.filaments.puff_spacing_m",
                "0.5 to 1000 m",
            ),
            (self.intermittency, 0.0..=1.0, "field.filaments.intermittency", "0 to 1"),
        ] {
            check(range.contains(&value), key, value, expected)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const TEXT: &str = "east_m = 50\nnorth_m = -20\ntowards_deg = 90\nspeed_mps = 0.2\nsigma_m = 3\ntracer = 10\n";

    fn one(more: &str, seed: u64) -> Filament {
        let config: FilamentConfig = toml::from_str(&format!("{TEXT}{more}")).unwrap();
        draw(&[config], seed).unwrap().remove(0)
    }

    /// The share at a place east and north of the source.
    fn at(filament: &Filament, east_m: f64, north_m: f64, seconds: f64) -> f64 {
        let time = Timestamp::from_nanos((seconds * 1e9) as u64);
        filament.share(filament.source() + EastNorth::new(east_m, north_m), 7.0, time)
    }

    #[test]
    fn without_puffs_a_filament_is_a_gaussian_plume_of_constant_mass() {
        let filament = one("intermittency = 0\ndiffusivity_m2_per_s = 0.05", 1);
        assert!((at(&filament, 0.0, 0.0, 0.0) - 1.0).abs() < 1e-12);
        for way_m in [10.0, 100.0, 1000.0] {
            let sigma_m = f64::sqrt(9.0 + 2.0 * 0.05 * way_m / 0.2);
            let expected = 3.0 / sigma_m * exp(-0.5);
            assert!((at(&filament, way_m, sigma_m, 99.0) - expected).abs() < 1e-12);
            // The integral across is the same at each distance: σ₀ times the square root of 2π.
            let across: f64 = (-4000..=4000)
                .map(|step| at(&filament, way_m, 0.1 * f64::from(step), 0.0) * 0.1)
                .sum();
            assert!((across - 3.0 * TAU.sqrt()).abs() < 1e-6, "{across}");
        }
        // Upstream of the source it is round, and nothing is left at its end.
        assert!((at(&filament, -3.0, 0.0, 0.0) - exp(-0.5)).abs() < 1e-12);
        assert!((at(&filament, 1900.0, 0.0, 0.0) / at(&filament, 1799.0, 0.0, 0.0) - 0.5).abs() < 0.02);
        assert_eq!(at(&filament, 2000.0, 0.0, 0.0), 0.0);
    }

    #[test]
    fn puffs_drift_and_their_mean_is_the_plume() {
        let filament = one("intermittency = 1\ndiffusivity_m2_per_s = 0\npuff_spacing_m = 4", 5);
        // The sequence of puffs is 32 spacings long, which is 640 s.
        let seen: Vec<f64> = (0..6400)
            .map(|step| at(&filament, 33.0, 0.0, 0.1 * f64::from(step)))
            .collect();
        let mean = seen.iter().sum::<f64>() / 6400.0;
        assert!((mean - 1.0).abs() < 1e-9, "{mean}");
        let most = seen.iter().copied().fold(0.0, f64::max);
        let least = seen.iter().copied().fold(f64::MAX, f64::min);
        assert!(most > 2.0 && most < 6.0 && least < 0.1, "{least} {most}");
        // The value here and now is found 100 m downstream 500 s later.
        for seconds in [0.0, 7.7, 300.0] {
            let (here, there) = (
                at(&filament, 20.0, 1.0, seconds),
                at(&filament, 120.0, 1.0, seconds + 500.0),
            );
            assert!((here - there).abs() < 1e-9, "{here} {there}");
        }
    }

    #[test]
    fn meanders_stay_within_their_width_and_differ_by_seed() {
        let more = "intermittency = 0\nmeander_m = 30\nmeander_wavelength_m = 80\ndiffusivity_m2_per_s = 0";
        let (one_seed, other_seed) = (one(more, 1), one(more, 2));
        let mut differ = false;
        let mut widest_m: f64 = 0.0;
        for step in 0..400 {
            let way_m = 4.0 * f64::from(step);
            let middle = |filament: &Filament| {
                (-360..=360)
                    .map(|tenth| 0.1 * f64::from(tenth))
                    .max_by(|a, b| at(filament, way_m, *a, 60.0).total_cmp(&at(filament, way_m, *b, 60.0)))
                    .unwrap()
            };
            let (one_m, other_m) = (middle(&one_seed), middle(&other_seed));
            differ |= (one_m - other_m).abs() > 5.0;
            widest_m = widest_m.max(one_m.abs());
        }
        assert!(differ && widest_m > 10.0 && widest_m <= 30.1, "{widest_m}");
    }

    #[test]
    fn a_filament_at_a_depth_has_no_effect_far_from_it() {
        let filament = one("depth_m = 30\nsigma_depth_m = 2\nintermittency = 0", 1);
        let share = |depth_m| filament.share(filament.source(), depth_m, Timestamp::ZERO);
        assert!((share(30.0) - 1.0).abs() < 1e-12 && (share(32.0) - exp(-0.5)).abs() < 1e-12);
        assert_eq!(share(5.0), 0.0);
    }

    #[test]
    fn ranges_are_checked_by_their_key() {
        let config: FilamentConfig = toml::from_str(&TEXT.replace("speed_mps = 0.2", "speed_mps = 0")).unwrap();
        let error = draw(&[config], 1).unwrap_err();
        assert_eq!(
            error.to_string(),
            "field.filaments.speed_mps is 0, expected 0.01 to 5 m/s"
        );
        let config: FilamentConfig = toml::from_str(&format!("{TEXT}intermittency = 2")).unwrap();
        let error = draw(&[config], 1).unwrap_err();
        assert_eq!(error.to_string(), "field.filaments.intermittency is 2, expected 0 to 1");
    }

    proptest! {
        #[test]
        fn a_filament_has_no_steps(
            seed in any::<u64>(), east in -50.0..2050.0f64, north in -60.0..60.0f64, seconds in 0.0..1e5f64,
        ) {
            let filament = one("meander_m = 20\nintermittency = 1", seed);
            let here = at(&filament, east, north, seconds);
            prop_assert!((0.0..6.0).contains(&here));
            for (east_m, north_m) in [(1e-5, 0.0), (0.0, 1e-5)] {
                let beside = at(&filament, east + east_m, north + north_m, seconds);
                // The share is at most six, and its shortest scale is about a metre.
                prop_assert!((here - beside).abs() < 1e-4, "{here} {beside}");
            }
        }
    }
}
