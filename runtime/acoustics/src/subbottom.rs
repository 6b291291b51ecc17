use backseat_units::EastNorth;
use backseat_units::math::{self, PI, TAU, atan2, hypot, sin_cos};
use backseat_world::World;

use crate::absorption::Water;
use crate::beam::two_way;
use crate::level::{decibels, noise_db, power_of};
use crate::pose::Pose;
use crate::settings::SubBottomSettings;
use crate::speckle::Speckle;

/// Level of the source at full power, decibels relative to 1 µPa at 1 m.
const SOURCE_DB: f64 = 200.0;
/// How much louder the vehicle is than the sea, decibels. A figure of ours: without it a quiet sea would be silent.
const VEHICLE_DB: f64 = 25.0;
/// The level, after the gain, that is a sample of 1: decibels relative to 1 µPa.
const COUNT_DB: f64 = 105.0;
/// Width of the beam, radians: 45 degrees.
const BEAM_RAD: f64 = 0.785;
/// What the sediment scatters back within the length of a compressed pulse, decibels relative to a mirror. A figure of
/// ours.
const SEDIMENT_DB: f64 = -48.0;
/// Attenuation in the sediment below the lowest layer, decibels a metre and kilohertz.
const DEEP_ATTENUATION: f64 = 0.1;
/// Spreading is counted from this distance on, metres.
const NEAREST_M: f64 = 0.1;
/// Targets further away than this part of the altitude are outside the beam.
const TARGET_REACH: f64 = 0.6;

/// A sub-bottom profiler on a vehicle: a wide beam straight down at a low frequency, which enters the sediment.
///
/// A sample is the complex envelope at the middle of the pulse's frequencies, after the pulse has been compressed: the
/// phase of an echo turns with twice its distance over the wavelength.
#[derive(Clone, Debug)]
pub struct SubBottom {
    speckle: Speckle,
    water: Water,
    layers: Vec<Layer>,
    echoes: Vec<Echo>,
    /// For each sample, the mean square of noise and of what the sediment scatters.
    power: Vec<f32>,
    heard: Vec<[f32; 2]>,
}

/// A layer at the place of a ping.
#[derive(Clone, Copy, Debug)]
struct Layer {
    depth_m: f64,
    /// The part of the power that it reflects.
    reflected: f64,
    /// Attenuation above it, decibels a metre and kilohertz.
    attenuation: f64,
}

/// The echo of a mirror or a point.
#[derive(Clone, Copy, Debug)]
struct Echo {
    slant_m: f64,
    amplitude: f64,
}

impl SubBottom {
    /// A profiler in a world. The seed and the name determine its noise: give each profiler its own name.
    #[must_use]
    pub fn new(world: &World, seed: u64, name: &str) -> Self {
        Self {
            speckle: Speckle::new(seed, format!("subbottom {name}")),
            water: Water::of(world),
            layers: Vec::new(),
            echoes: Vec::new(),
            power: Vec::new(),
            heard: Vec::new(),
        }
    }

    /// Pings once: fills `out` with `settings.samples` pairs of in-phase and quadrature.
    ///
    /// `world` must be the one that the profiler was made for. The result depends only on that world, the pose, the
    /// settings, the seed, the name and the number of the ping, and not on pings before it.
    ///
    /// If [`Pose::check`] or [`SubBottomSettings::check`] refuses its part, `out` is left empty.
    pub fn ping(
        &mut self,
        world: &World,
        pose: &Pose,
        settings: &SubBottomSettings,
        ping: u32,
        out: &mut Vec<[i16; 2]>,
    ) {
        out.clear();
        if pose.check().is_err() || settings.check().is_err() {
            return;
        }
        let samples = settings.samples as usize;
        let length = 1.0 / (settings.bandwidth_hz() * settings.sample_interval_s);
        let length = length.round().clamp(1.0, f64::from(settings.samples)) as usize;
        self.speckle.draw(ping, samples, length);
        let noise_db = noise_db(settings.centre_hz()) + VEHICLE_DB + decibels(settings.bandwidth_hz());
        self.power.clear();
        self.power
            .resize(samples, power_of(noise_db + settings.gain_db - COUNT_DB) as f32);
        self.echoes.clear();
        if pose.is_in_water() && settings.power > 0.0 {
            self.look(world, pose, settings);
        }
        let norm = 1.0 / self.speckle.norm();
        let quadratures = self.speckle.quadratures.iter().zip(&self.power);
        self.heard.clear();
        self.heard.extend(quadratures.map(|([i, q], power)| {
            let amplitude = (power * norm).sqrt();
            [*i as f32 * amplitude, *q as f32 * amplitude]
        }));
        for echo in &self.echoes {
            echo.add(settings, &mut self.heard);
        }
        // The cast rounds towards zero.
        let whole = |x: f32| (x.clamp(-32_767.0, 32_767.0) + 0.5f32.copysign(x)) as i16;
        out.extend(self.heard.iter().map(|[i, q]| [whole(*i), whole(*q)]));
    }

    /// Finds the echoes of the bed, the layers and the targets, and what the sediment scatters.
    fn look(&mut self, world: &World, pose: &Pose, settings: &SubBottomSettings) {
        let gradient = world.gradient(pose.at);
        // The nearest point of a sloping bed is beside the vehicle, and so are those of layers along with it.
        let upright = 1.0 / hypot(hypot(gradient.east_m, gradient.north_m), 1.0);
        let bed_m = (pose.altitude_m * upright).max(NEAREST_M);
        let (sin, cos) = sin_cos(pose.heading_deg.to_radians());
        let slope_ahead = gradient.east_m * sin + gradient.north_m * cos;
        let slope_starboard = gradient.east_m * cos - gradient.north_m * sin;
        let off_rad = hypot(
            pose.pitch_deg.to_radians() + slope_ahead,
            pose.roll_deg.to_radians() - slope_starboard,
        );
        let absorption = self.water.absorption_db_per_m(settings.centre_hz());
        let compression = settings.bandwidth_hz() * settings.pulse_s;
        let source = settings.power * compression * power_of(SOURCE_DB + settings.gain_db - COUNT_DB);
        // The power that a mirror at this distance sends back on the axis of the beam.
        let mirror = |slant_m: f64| source * power_of(-2.0 * absorption * slant_m) / (4.0 * slant_m * slant_m);
        let beam = two_way(off_rad, BEAM_RAD);

        let texture = world.bottom().at(pose.at);
        let reflected = power_of(texture.class.reflectivity_db());
        self.echoes.push(Echo {
            slant_m: bed_m,
            amplitude: (beam * reflected * mirror(bed_m)).sqrt(),
        });
        self.layers.clear();
        self.layers.extend(world.sediment_layers().iter().map(|layer| Layer {
            depth_m: layer.depth_at_m(pose.at) * upright,
            reflected: power_of(layer.reflectivity_db),
            attenuation: layer.attenuation_db_per_m_khz,
        }));
        self.layers.retain(|layer| layer.depth_m > 0.0);
        self.layers.sort_by(|one, other| one.depth_m.total_cmp(&other.depth_m));
        let khz = settings.centre_hz() / 1000.0;
        // What is left of the power after the boundaries above, both ways, and after the sediment above.
        let mut left = beam * (1.0 - reflected) * (1.0 - reflected);
        let mut above_m = 0.0;
        for layer in &self.layers {
            let lost_db_per_m = 2.0 * layer.attenuation * khz;
            let (top_m, foot_m) = (bed_m + above_m, bed_m + layer.depth_m);
            scatter(&mut self.power, settings, (top_m, foot_m), lost_db_per_m, |slant_m| {
                left * mirror(slant_m)
            });
            left *= power_of(-lost_db_per_m * (layer.depth_m - above_m));
            self.echoes.push(Echo {
                slant_m: foot_m,
                amplitude: (left * layer.reflected * mirror(foot_m)).sqrt(),
            });
            left *= (1.0 - layer.reflected) * (1.0 - layer.reflected);
            above_m = layer.depth_m;
        }
        let deep = self.layers.last().map_or(DEEP_ATTENUATION, |layer| layer.attenuation);
        let lost_db_per_m = 2.0 * deep * khz;
        scatter(
            &mut self.power,
            settings,
            (bed_m + above_m, f64::MAX),
            lost_db_per_m,
            |slant_m| left * mirror(slant_m),
        );

        let reach_m = TARGET_REACH * pose.altitude_m;
        for target in world.targets_near(pose.at, reach_m) {
            let from: EastNorth = target.at - pose.at;
            let bed_m = pose.altitude_m + from.east_m * gradient.east_m + from.north_m * gradient.north_m;
            let (out_m, below_m) = (
                hypot(from.east_m, from.north_m),
                (bed_m - target.height_m).max(NEAREST_M),
            );
            let slant_m = hypot(out_m, below_m);
            let strength = power_of(target.strength_db) * two_way(atan2(out_m, below_m), BEAM_RAD);
            self.echoes.push(Echo {
                slant_m,
                amplitude: (4.0 * strength * mirror(slant_m)).sqrt() / slant_m,
            });
        }
    }
}

/// Adds what the sediment between two slant ranges scatters. It decays by `lost_db_per_m`, on top of what `above` says.
fn scatter(
    power: &mut [f32],
    settings: &SubBottomSettings,
    (from_m, to_m): (f64, f64),
    lost_db_per_m: f64,
    above: impl Fn(f64) -> f64,
) {
    let sample_m = 0.5 * settings.sound_speed_mps * settings.sample_interval_s;
    let index = |slant_m: f64| ((slant_m / sample_m).ceil().max(0.0) as usize).min(power.len());
    let (first, end) = (index(from_m), index(to_m));
    if first >= end {
        return;
    }
    let first_m = first as f64 * sample_m;
    // Spreading goes with the square of the range; the absorption of the water below the bed is taken as that at its top.
    let mut here = power_of(SEDIMENT_DB - lost_db_per_m * (first_m - from_m)) * above(from_m) * from_m * from_m;
    let each = power_of(-lost_db_per_m * sample_m);
    for (number, power) in power[first..end].iter_mut().enumerate() {
        let slant_m = first_m + number as f64 * sample_m;
        *power += (here / (slant_m * slant_m)) as f32;
        here *= each;
    }
}

impl Echo {
    /// Adds the compressed pulse: cos² (π B t / 4) to 2 / B on both sides of its middle, the main lobe of a sweep of the
    /// bandwidth B that is weighted with Hann's window.
    fn add(&self, settings: &SubBottomSettings, heard: &mut [[f32; 2]]) {
        let interval_s = settings.sample_interval_s;
        let middle_s = 2.0 * self.slant_m / settings.sound_speed_mps;
        let half_s = 2.0 / settings.bandwidth_hz();
        let first = ((middle_s - half_s) / interval_s).ceil().max(0.0) as usize;
        let (sin, cos) = sin_cos(-TAU * (settings.centre_hz() * middle_s).fract());
        for (number, [i, q]) in heard.iter_mut().enumerate().skip(first) {
            let from_s = number as f64 * interval_s - middle_s;
            if from_s > half_s {
                break;
            }
            let shape = math::cos(0.5 * PI * from_s / half_s);
            let amplitude = self.amplitude * shape * shape;
            *i += (amplitude * cos) as f32;
            *q += (amplitude * sin) as f32;
        }
    }
}
