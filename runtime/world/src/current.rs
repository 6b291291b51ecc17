//! The current: a mean flow and tidal streams, and how both change with depth and near the bed.

mod profile;
mod tide;

use backseat_units::math::{TAU, sin_cos};
use backseat_units::{EastNorth, Timestamp};
use serde::Deserialize;

pub use profile::LayerConfig;
use profile::Profile;
use tide::Ellipse;
pub use tide::TideConfig;

use crate::error::{WorldError, check};
use crate::span::Span;
use crate::stream::Stream;

/// The `[current]` section: a flow that is the same everywhere and turns slowly, plus tidal streams. If the
/// configuration says so, both become weaker or turn with depth, and fall to zero at the bed.
///
/// ```
/// let config: backseat_world::CurrentConfig = toml::from_str(r#"
/// speed_mps = [0.0, 0.1]
/// bottom_boundary_m = 5
///
/// [[tides]]                # M2, an ellipse with its major axis to the north-east
/// speed_mps = 0.3
/// towards_deg = 45
/// period_h = 12.4206
/// phase_deg = [0, 360]
/// ellipticity = 0.2
///
/// [[layers]]               # unchanged down to 10 m; half as fast and turned right from 30 m down
/// depth_m = 10
/// [[layers]]
/// depth_m = 30
/// factor = 0.5
/// turn_deg = 40
/// "#)?;
/// assert_eq!((config.tides.len(), config.layers.len()), (1, 2));
/// # Ok::<(), toml::de::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CurrentConfig {
    /// Speed at the surface, metres a second, 0 to 5.
    pub speed_mps: Span,
    /// The direction in which it flows at the start, degrees clockwise from the frame's north.
    pub towards_deg: Span,
    /// Time of one full clockwise turn, hours, 0.1 or more; without it, the flow does not turn. A semidiurnal tide has
    /// 12.42.
    pub rotation_h: Option<Span>,
    /// Depth at which the whole current has fallen to 1/e, metres, 1 or more; without it, the current does not fall.
    pub decay_depth_m: Option<f64>,
    /// Tidal streams, at most 8.
    pub tides: Vec<TideConfig>,
    /// How the whole current changes with depth: at most 16 layers, from the shallowest down; not together with
    /// `decay_depth_m`.
    pub layers: Vec<LayerConfig>,
    /// Height of the layer over the bed in which the current falls to zero, metres, 0.1 to 100; without it, there is no
    /// such layer. With it, [`World::current_at`](crate::World::current_at) looks up the water depth at each call.
    pub bottom_boundary_m: Option<f64>,
}

impl Default for CurrentConfig {
    fn default() -> Self {
        Self {
            speed_mps: Span::fixed(0.0),
            towards_deg: Span::between(0.0, 360.0),
            rotation_h: None,
            decay_depth_m: None,
            tides: Vec::new(),
            layers: Vec::new(),
            bottom_boundary_m: None,
        }
    }
}

/// The current, drawn by a seed.
#[derive(Clone, Debug, PartialEq)]
pub struct Current {
    speed_mps: f64,
    towards_rad: f64,
    rotation_rad_per_s: f64,
    /// East and north at the start, and always if the flow does not turn.
    at_start: (f64, f64),
    tides: Vec<Ellipse>,
    profile: Profile,
    bottom_boundary_m: Option<f64>,
}

impl Current {
    /// Draws a current.
    ///
    /// # Errors
    /// [`WorldError`] if a value of the configuration is out of range.
    pub fn new(config: &CurrentConfig, seed: u64) -> Result<Self, WorldError> {
        config.speed_mps.within(0.0, 5.0, "current.speed_mps", "0 to 5 m/s")?;
        config
            .towards_deg
            .within(-360.0, 720.0, "current.towards_deg", "-360 to 720 degrees")?;
        if let Some(rotation) = config.rotation_h {
            rotation.within(0.1, 1e6, "current.rotation_h", "0.1 h or more")?;
        }
        if let Some(height) = config.bottom_boundary_m {
            let ok = (0.1..=100.0).contains(&height);
            check(ok, "current.bottom_boundary_m", height, "0.1 to 100 m")?;
        }
        let tides = tide::draw(&config.tides, seed)?;
        let profile = Profile::new(config.decay_depth_m, &config.layers)?;
        let mut stream = Stream::new(seed, "current");
        let speed_mps = config.speed_mps.draw(&mut stream);
        let towards_rad = config.towards_deg.draw(&mut stream).to_radians();
        let rotation_rad_per_s = config
            .rotation_h
            .map_or(0.0, |hours| TAU / (3600.0 * hours.draw(&mut stream)));
        let (sin, cos) = sin_cos(towards_rad);
        Ok(Self {
            speed_mps,
            towards_rad,
            rotation_rad_per_s,
            at_start: (speed_mps * sin, speed_mps * cos),
            tides,
            profile,
            bottom_boundary_m: config.bottom_boundary_m,
        })
    }

    /// Velocity of the water far from the bed, metres a second east and north.
    #[must_use]
    pub fn at(&self, _place: EastNorth, depth_m: f64, time: Timestamp) -> (f64, f64) {
        let (mut east, mut north) = self.at_start;
        if self.rotation_rad_per_s != 0.0 {
            let (sin, cos) = sin_cos(self.towards_rad + self.rotation_rad_per_s * time.as_secs_f64());
            (east, north) = (self.speed_mps * sin, self.speed_mps * cos);
        }
        for tide in &self.tides {
            let (tide_east, tide_north) = tide.at(time);
            (east, north) = (east + tide_east, north + tide_north);
        }
        self.profile.apply((east, north), depth_m)
    }

    /// Whether the bed slows this current down. If not, [`Current::near_bed`] is 1 everywhere.
    #[must_use]
    pub const fn feels_the_bed(&self) -> bool {
        self.bottom_boundary_m.is_some()
    }

    /// The part of the current that is left at a height over the bed, 0 to 1. Within `bottom_boundary_m` it follows the
    /// one-seventh power law.
    ///
    /// Source: Soulsby, *Dynamics of Marine Sands* (1997), section 3.3.
    #[must_use]
    pub fn near_bed(&self, height_m: f64) -> f64 {
        self.bottom_boundary_m
            .map_or(1.0, |layer_m| profile::power_law(height_m / layer_m))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_current_turns_and_decays() {
        let config = CurrentConfig {
            speed_mps: Span::fixed(0.4),
            towards_deg: Span::fixed(90.0),
            rotation_h: Some(Span::fixed(4.0)),
            decay_depth_m: Some(50.0),
            ..CurrentConfig::default()
        };
        let current = Current::new(&config, 1).unwrap();
        let at = |depth_m, hours: u64| current.at(EastNorth::default(), depth_m, Timestamp::from_secs(hours * 3600));
        assert!((at(0.0, 0).0 - 0.4).abs() < 1e-12 && at(0.0, 0).1.abs() < 1e-12);
        // A quarter of a turn later it flows south.
        assert!(at(0.0, 1).0.abs() < 1e-12 && (at(0.0, 1).1 + 0.4).abs() < 1e-12);
        assert!((at(50.0, 0).0 - 0.4 / core::f64::consts::E).abs() < 1e-12);
    }

    #[test]
    fn draws_stay_within_their_span() {
        let config = CurrentConfig {
            speed_mps: Span::between(0.1, 0.3),
            ..CurrentConfig::default()
        };
        for seed in 0..200 {
            let (east, north) = Current::new(&config, seed)
                .unwrap()
                .at(EastNorth::default(), 0.0, Timestamp::ZERO);
            let speed = (east * east + north * north).sqrt();
            assert!((0.1 - 1e-9..=0.3 + 1e-9).contains(&speed));
        }
    }

    #[test]
    fn layers_change_the_sum_of_mean_flow_and_tides() {
        let text = "
            speed_mps = 0.2
            towards_deg = 0
            [[tides]]
            speed_mps = 0.5
            towards_deg = 90
            period_h = 12
            [[layers]]
            depth_m = 10
            factor = 0.5
        ";
        let current = Current::new(&toml::from_str(text).unwrap(), 1).unwrap();
        let (east, north) = current.at(EastNorth::default(), 40.0, Timestamp::ZERO);
        assert!((east - 0.25).abs() < 1e-12 && (north - 0.1).abs() < 1e-12);
        assert_eq!(current.near_bed(0.0), 1.0);
    }

    #[test]
    fn near_the_bed_the_current_follows_the_seventh_root() {
        let config: CurrentConfig = toml::from_str("speed_mps = 0.3\nbottom_boundary_m = 4").unwrap();
        let current = Current::new(&config, 1).unwrap();
        for (height_m, part) in [(-1.0, 0.0), (0.0, 0.0), (4.0 / 128.0, 0.5), (4.0, 1.0), (9.0, 1.0)] {
            assert!((current.near_bed(height_m) - part).abs() < 1e-12, "{height_m}");
        }
    }
}
