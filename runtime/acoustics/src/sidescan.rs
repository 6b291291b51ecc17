mod bed;
mod objects;
mod ranging;
mod swath;

use backseat_units::math::{atan2, hypot};
use backseat_world::World;

use crate::absorption::Water;
use crate::backscatter::{Coefficients, lambert};
use crate::level::power_of;
use crate::pose::Pose;
use crate::settings::SideScanSettings;
use crate::speckle::Speckle;

use bed::{Bed, Fan};
use objects::{Candidate, Objects};
use ranging::{Ranging, VERTICAL_RAD, tvg_db};
use swath::{Crossing, Node, Shadow};

/// The axis of each beam points this far down from the horizontal, radians: 30 degrees.
const TILT_RAD: f64 = core::f64::consts::FRAC_PI_6;
/// What the arrays hear in every direction, as a ratio of powers, transmitting and receiving: their side lobes.
const SIDE_LOBES: f64 = 1e-5;

/// A number added to this one has its whole part in the lowest bits: the last bit of a `f32` of this size stands for 1.
/// It rounds to the nearest, and several samples at a time, which a cast does not.
const UNITS: f32 = 8_388_608.0;

/// A sidescan sonar on a vehicle: two beams, narrow along track and wide across, to port and to starboard.
///
/// ```
/// use backseat_acoustics::{Pose, SideScan, SideScanSettings};
/// use backseat_units::EastNorth;
/// use backseat_world::World;
///
/// let config = toml::from_str("
///     [origin]
///     latitude_deg = 42.3
///     longitude_deg = -70.9
///     [[targets]]
///     count = 100
///     east_m = [-500, 500]
///     north_m = [-500, 500]
/// ")?;
/// let world = World::new(&config, 1)?;
/// let mut sonar = SideScan::new(&world, 1, "high");
/// let at = EastNorth::default();
/// let depth_m = world.water_depth_m(at);
/// let pose = Pose { at, depth_m: depth_m - 10.0, altitude_m: 10.0, heading_deg: 90.0, pitch_deg: 0.0, roll_deg: 0.0 };
/// let settings = SideScanSettings {
///     frequency_hz: 410e3,
///     range_m: 75.0,
///     pulse_s: 100e-6,
///     power: 1.0,
///     gain_db: 0.0,
///     samples: 455,
///     sound_speed_mps: 1500.0,
/// };
/// let (mut port, mut starboard) = (Vec::new(), Vec::new());
/// sonar.ping(&world, &pose, &settings, 1, &mut port, &mut starboard);
/// assert_eq!((port.len(), starboard.len()), (455, 455));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct SideScan {
    speckle: Speckle,
    water: Water,
    objects: Objects,
    /// The world's texture without patches, and those of its patches.
    base: Coefficients,
    patches: Vec<Coefficients>,
    /// Lambert's coefficient of the surface, if the sonar sees the surface.
    surface: Option<f64>,
    ranging: Option<Ranging>,
    scratch: Scratch,
}

/// What a ping needs while it is computed, kept so that a ping allocates nothing.
#[derive(Clone, Debug, Default)]
struct Scratch {
    bed: Bed,
    nodes: Vec<Node>,
    candidates: Vec<Candidate>,
    crossings: Vec<Crossing>,
    edges: Vec<f64>,
    shadows: Vec<Shadow>,
    /// For each sample, the mean square of what the sonar hears there.
    power: Vec<f32>,
}

impl SideScan {
    /// A sonar in a world. The seed and the name determine its speckle and its noise: give each sonar its own name.
    #[must_use]
    pub fn new(world: &World, seed: u64, name: &str) -> Self {
        Self {
            speckle: Speckle::new(seed, format!("sidescan {name}")),
            water: Water::of(world),
            objects: Objects::new(world),
            base: Coefficients::of(world.bottom().base()),
            patches: world
                .bottom()
                .patches()
                .iter()
                .map(|patch| Coefficients::of(patch.texture))
                .collect(),
            surface: None,
            ranging: None,
            scratch: Scratch::default(),
        }
    }

    /// The sonar also sees the surface from below, as a rough plane that follows Lambert's law with this coefficient in
    /// decibels. Without it the sonar does not see the surface.
    #[must_use]
    pub fn with_surface(mut self, lambert_db: f64) -> Self {
        self.surface = Some(power_of(lambert_db));
        self
    }

    /// The gain that grows with time, decibels, at a slant range in metres: 30 log r for the spreading of an echo of the
    /// seabed, and what the water absorbs both ways; from 1 m on and at most 120 dB.
    #[must_use]
    pub fn tvg_db(&self, settings: &SideScanSettings, slant_m: f64) -> f64 {
        tvg_db(self.water.absorption_db_per_m(settings.frequency_hz), slant_m)
    }

    /// Pings once: fills each side with `settings.samples` samples of the envelope, in order of slant range.
    ///
    /// `world` must be the one that the sonar was made for. The result depends only on that world, the pose, the
    /// settings, the seed, the name and the number of the ping, and not on pings before it.
    ///
    /// If [`Pose::check`] or [`SideScanSettings::check`] refuses its part, both sides are left empty.
    pub fn ping(
        &mut self,
        world: &World,
        pose: &Pose,
        settings: &SideScanSettings,
        ping: u32,
        port: &mut Vec<u16>,
        starboard: &mut Vec<u16>,
    ) {
        port.clear();
        starboard.clear();
        if pose.check().is_err() || settings.check().is_err() {
            return;
        }
        let ranging = match self.ranging.take() {
            Some(ranging) if ranging.settings == *settings => ranging,
            Some(_) | None => Ranging::new(settings, &self.water),
        };
        let samples = settings.samples as usize;
        self.speckle.draw(ping, 2 * samples, ranging.pulse_samples);
        let hears_echoes = pose.is_in_water() && settings.power > 0.0;
        let fan = hears_echoes.then(|| Fan::new(world, pose));
        if let Some(fan) = &fan {
            let candidates = &mut self.scratch.candidates;
            self.objects.near(fan, settings.range_m, ranging.along_rad, candidates);
            self.cross_patches(world, fan, settings.range_m);
        }
        for (side, first, out) in [(-1.0, 0, port), (1.0, samples, starboard)] {
            self.scratch.power.clear();
            self.scratch.power.resize(samples, 0.0);
            if let Some(fan) = &fan {
                self.hear(world, pose, fan, side, &ranging);
            }
            let quadratures = self.speckle.quadratures[first..].iter();
            let heard = self.scratch.power.iter().zip(&ranging.noise).zip(quadratures);
            let norm = 1.0 / self.speckle.norm();
            out.extend(heard.map(|((power, noise), [i, q])| {
                let (i, q) = (*i as f32, *q as f32);
                // What is more than a sample can hold stands as 65535.
                let envelope = ((power + noise) * norm * (i * i + q * q)).sqrt().min(65_535.0);
                (envelope + UNITS).to_bits() as u16
            }));
        }
        self.ranging = Some(ranging);
    }

    /// Finds where the fan crosses patches of other textures.
    fn cross_patches(&mut self, world: &World, fan: &Fan, range_m: f64) {
        self.scratch.crossings.clear();
        for (patch, coefficients) in world.bottom().patches().iter().zip(&self.patches) {
            let from = patch.at - fan.origin;
            let ahead_m = from.east_m * fan.ahead.east_m + from.north_m * fan.ahead.north_m;
            if ahead_m.abs() > 0.5 * patch.length_m.max(patch.width_m) {
                continue;
            }
            if let Some((enter_m, leave_m)) = patch.crossing(fan.origin, fan.starboard)
                && leave_m > -range_m
                && enter_m < range_m
            {
                self.scratch.crossings.push(Crossing {
                    enter_m,
                    leave_m,
                    coefficients: *coefficients,
                });
            }
        }
    }

    /// Adds up what one side hears, without noise.
    fn hear(&mut self, world: &World, pose: &Pose, fan: &Fan, side: f64, ranging: &Ranging) {
        let range_m = ranging.settings.range_m;
        let scratch = &mut self.scratch;
        scratch.bed.look(world, fan, side, range_m);
        swath::edges(&scratch.crossings, side, range_m, &mut scratch.edges);
        let axis_rad = TILT_RAD + side * pose.roll_deg.to_radians();
        swath::walk(&scratch.bed, ranging, &scratch.edges, &mut scratch.nodes);
        for node in &mut scratch.nodes {
            node.look(ranging, axis_rad);
        }
        swath::add(
            &scratch.nodes,
            &scratch.crossings,
            side,
            self.base,
            ranging,
            &mut scratch.power,
        );
        scratch.shadows.clear();
        for candidate in &scratch.candidates {
            if let Some(met) = candidate.meet(fan, &scratch.bed, side, ranging.along_rad)
                && swath::is_lit(&scratch.nodes, met.apex)
            {
                scratch
                    .shadows
                    .push(Shadow::of(met, &scratch.bed, &scratch.nodes, ranging));
            }
        }
        for shadow in &scratch.shadows {
            let samples = ranging.samples(shadow.from_m, shadow.to_m);
            for power in &mut scratch.power[samples] {
                *power *= shadow.left as f32;
            }
        }
        for (number, shadow) in scratch.shadows.iter().enumerate() {
            let met = &shadow.met;
            let mut strength = met.strength_m2 * met.insonified(ranging.along_rad, ranging.equivalent_rad);
            for (other, nearer) in scratch.shadows.iter().enumerate() {
                if other != number && nearer.hides(met) {
                    strength *= nearer.left;
                }
            }
            strength *= pattern(atan2(met.apex.below_m, met.apex.out_m) - axis_rad);
            // The echo of a point is as long as the pulse; that of a longer target has the same energy.
            let (least_m, most_m) = met.slants_m;
            let length_m = most_m - least_m + ranging.pulse_m;
            let each = (strength * ranging.pulse_m / length_m) as f32;
            let samples = ranging.samples(least_m - 0.5 * ranging.pulse_m, most_m + 0.5 * ranging.pulse_m);
            let echo = scratch.power[samples.clone()].iter_mut().zip(&ranging.scale[samples]);
            for (power, scale) in echo {
                *power += scale * each;
            }
        }
        if let Some(coefficient) = self.surface {
            self.hear_surface(pose.depth_m, coefficient, axis_rad, ranging);
        }
    }

    /// Adds what comes from the surface: a level plane above the sonar.
    fn hear_surface(&mut self, depth_m: f64, coefficient: f64, axis_rad: f64, ranging: &Ranging) {
        let settings = &ranging.settings;
        let least = ranging.samples(depth_m, settings.range_m);
        for sample in least {
            let slant_m = settings.slant_m(sample as u32);
            let sin = (depth_m / slant_m).min(1.0);
            let out_m = (slant_m * slant_m - depth_m * depth_m).max(0.0).sqrt();
            let area_m2 = swath::area_m2(slant_m, out_m / slant_m, ranging);
            let strength = coefficient * lambert(sin) * area_m2 * pattern(-atan2(depth_m, out_m) - axis_rad);
            self.scratch.power[sample] += ranging.scale[sample] * strength as f32;
        }
    }
}

/// The beam in the vertical, transmitting and receiving, at an angle from its axis in radians.
fn pattern(angle_rad: f64) -> f64 {
    crate::beam::two_way(angle_rad, VERTICAL_RAD).max(SIDE_LOBES)
}

impl Node {
    /// Computes what it scatters back, but for its texture.
    fn look(&mut self, ranging: &Ranging, axis_rad: f64) {
        if !self.is_lit || self.slant_m > ranging.settings.range_m + self.reach_m {
            return;
        }
        let (below_m, out_m, slant_m) = (self.below_m, self.out_m, self.slant_m.max(1e-6));
        // The angle between the ray and the seabed, whose normal has the slopes.
        let steepness = hypot(hypot(self.outwards, self.ahead), 1.0);
        let sin_grazing = (below_m - self.outwards * out_m) / (slant_m * steepness);
        if sin_grazing <= 0.0 {
            return;
        }
        let sin_grazing = sin_grazing.min(1.0);
        // How fast the slant range grows along the seabed.
        let growth = (out_m + below_m * self.outwards).abs() / (slant_m * hypot(self.outwards, 1.0));
        let area_m2 = swath::area_m2(slant_m, growth, ranging);
        let seen = area_m2 * pattern(atan2(below_m, out_m) - axis_rad);
        self.lambert = seen * lambert(sin_grazing);
        self.facets = seen * crate::backscatter::facets(sin_grazing);
    }
}
