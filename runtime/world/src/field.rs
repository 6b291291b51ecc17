//! Scalar fields: temperature, conductivity and tracer of the water. They change with depth, and plumes, filaments and
//! fronts add to them.

mod filament;
mod front;
mod plume;
mod thermocline;

use backseat_units::math::tanh;
use backseat_units::{EastNorth, Timestamp};
use serde::Deserialize;

use filament::Filament;
pub use filament::FilamentConfig;
use front::Front;
pub use front::FrontConfig;
use plume::Plume;
pub use plume::PlumeConfig;
use thermocline::Thermocline;
pub use thermocline::ThermoclineConfig;

use crate::error::{WorldError, check};
use crate::span::Span;

/// The `[field]` section: temperature and conductivity of the water, and the plumes, filaments and fronts in it.
///
/// ```
/// let config: backseat_world::FieldConfig = toml::from_str(r#"
/// temperature_c = 14
///
/// [thermocline]              # 6 degrees colder below 20 m, at the same salinity
/// depth_m = [18, 22]
/// thickness_m = 6
/// drop_c = 6
///
/// [[plumes]]                 # a warm outfall
/// east_m = [-300, 300]
/// north_m = 0
/// sigma_m = 100
/// temperature_c = 2
/// tracer = 1
///
/// [[filaments]]              # a seep, whose water drifts north-east in puffs
/// east_m = [-100, 100]
/// north_m = [-100, 100]
/// towards_deg = 45
/// speed_mps = 0.1
/// sigma_m = 2
/// meander_m = 15
/// tracer = 100
///
/// [[fronts]]                 # colder, saltier water moving in from the east
/// east_m = 800
/// north_m = 0
/// towards_deg = 270
/// speed_mps = 0.05
/// width_m = 40
/// temperature_c = -1.5
/// conductivity_us_per_cm = 900
/// "#)?;
/// assert_eq!((config.plumes.len(), config.filaments.len(), config.fronts.len()), (1, 1, 1));
/// # Ok::<(), toml::de::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FieldConfig {
    /// Temperature at the surface, degrees Celsius, -2 to 40.
    pub temperature_c: f64,
    /// How much colder the water gets with depth, degrees Celsius per metre, within ±1.
    pub cooling_c_per_m: f64,
    /// Conductivity, microsiemens a centimetre, 0 to 100000 (sea water: about 40000).
    pub conductivity_us_per_cm: f64,
    /// Where the temperature drops with depth.
    pub thermocline: Option<ThermoclineConfig>,
    /// The plumes, at most 16.
    pub plumes: Vec<PlumeConfig>,
    /// The filaments, at most 8.
    pub filaments: Vec<FilamentConfig>,
    /// The fronts, at most 8.
    pub fronts: Vec<FrontConfig>,
}

impl Default for FieldConfig {
    fn default() -> Self {
        Self {
            temperature_c: 12.0,
            cooling_c_per_m: 0.0,
            conductivity_us_per_cm: 40_000.0,
            thermocline: None,
            plumes: Vec::new(),
            filaments: Vec::new(),
            fronts: Vec::new(),
        }
    }
}

const fn zero() -> Span {
    Span::fixed(0.0)
}

/// What a feature adds to each field where its share is 1.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Adds {
    temperature_c: f64,
    conductivity_us_per_cm: f64,
    tracer: f64,
}

/// The scalar fields, drawn by a seed.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    temperature_c: f64,
    cooling_c_per_m: f64,
    conductivity_us_per_cm: f64,
    thermocline: Option<Thermocline>,
    plumes: Vec<Plume>,
    filaments: Vec<Filament>,
    fronts: Vec<Front>,
    maximum: Option<EastNorth>,
}

impl Field {
    /// Draws the fields.
    ///
    /// # Errors
    /// [`WorldError`] if a value of the configuration is out of range.
    pub fn new(config: &FieldConfig, seed: u64) -> Result<Self, WorldError> {
        validate(config)?;
        let thermocline = match &config.thermocline {
            Some(thermocline) => Some(thermocline.draw(config, seed)?),
            None => None,
        };
        let plumes = plume::draw(&config.plumes, seed)?;
        let maximum = plume::maximum(&plumes);
        Ok(Self {
            temperature_c: config.temperature_c,
            cooling_c_per_m: config.cooling_c_per_m,
            conductivity_us_per_cm: config.conductivity_us_per_cm,
            thermocline,
            plumes,
            filaments: filament::draw(&config.filaments, seed)?,
            fronts: front::draw(&config.fronts, seed)?,
            maximum,
        })
    }

    /// Temperature, degrees Celsius.
    #[must_use]
    pub fn temperature_c(&self, at: EastNorth, depth_m: f64, time: Timestamp) -> f64 {
        let mut background = self.temperature_c - self.cooling_c_per_m * depth_m;
        if let Some(thermocline) = &self.thermocline {
            background -= thermocline.drop_c * thermocline.share(depth_m);
        }
        self.add_to(background, |adds| adds.temperature_c, at, depth_m, time)
    }

    /// Conductivity in situ, microsiemens a centimetre, never below 0.
    #[must_use]
    pub fn conductivity_us_per_cm(&self, at: EastNorth, depth_m: f64, time: Timestamp) -> f64 {
        let mut background = self.conductivity_us_per_cm;
        if let Some(thermocline) = &self.thermocline {
            background -= thermocline.conductivity_drop_us_per_cm * thermocline.share(depth_m);
        }
        self.add_to(background, |adds| adds.conductivity_us_per_cm, at, depth_m, time)
            .max(0.0)
    }

    /// Concentration of the tracer that plumes and filaments carry, in the unit of the configuration; 0 elsewhere.
    #[must_use]
    pub fn concentration(&self, at: EastNorth, depth_m: f64, time: Timestamp) -> f64 {
        self.add_to(0.0, |adds| adds.tracer, at, depth_m, time)
    }

    fn add_to(&self, background: f64, of: impl Fn(&Adds) -> f64, at: EastNorth, depth_m: f64, time: Timestamp) -> f64 {
        let mut sum = background;
        for plume in &self.plumes {
            sum += of(&plume.adds) * plume.share(at, depth_m);
        }
        for filament in &self.filaments {
            let full = of(&filament.adds);
            // The share of a filament is the most expensive to compute, and most filaments add to one field only.
            if full != 0.0 {
                sum += full * filament.share(at, depth_m, time);
            }
        }
        for front in &self.fronts {
            sum += of(&front.adds) * front.share(at, time);
        }
        sum
    }

    /// The place where the plumes add most: to the temperature if any plume warms the water, otherwise to the
    /// conductivity. Each plume counts with its value at its own depth, so this is the maximum of the field seen from
    /// above. Filaments and fronts do not count, because they move. `None` if there is no such plume.
    #[must_use]
    pub fn maximum(&self) -> Option<EastNorth> {
        self.maximum
    }

    /// The sources of the filaments, in the order of the configuration.
    pub fn sources(&self) -> impl Iterator<Item = EastNorth> {
        self.filaments.iter().map(Filament::source)
    }
}

/// A step from 0 (far below `x` = 0) to 1 (far above), in the shape of a hyperbolic tangent.
fn smooth_step(x: f64) -> f64 {
    // The hyperbolic tangent of 20 is 1 to the last digit.
    if x > 20.0 {
        1.0
    } else if x < -20.0 {
        0.0
    } else {
        0.5 * (1.0 + tanh(x))
    }
}

fn validate(config: &FieldConfig) -> Result<(), WorldError> {
    let temperature = config.temperature_c;
    check(
        (-2.0..=40.0).contains(&temperature),
        "field.temperature_c",
        temperature,
        "-2 to 40 degrees Celsius",
    )?;
    check(
        config.cooling_c_per_m.abs() <= 1.0,
        "field.cooling_c_per_m",
        config.cooling_c_per_m,
        "-1 to 1 degrees Celsius per metre",
    )?;
    let conductivity = config.conductivity_us_per_cm;
    let conductivity_ok = (0.0..=100_000.0).contains(&conductivity);
    check(
        conductivity_ok,
        "field.conductivity_us_per_cm",
        conductivity,
        "0 to 100000 uS/cm",
    )?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plume(east_m: f64, north_m: f64, sigma_m: f64, temperature_c: f64) -> PlumeConfig {
        PlumeConfig {
            east_m: Span::fixed(east_m),
            north_m: Span::fixed(north_m),
            sigma_m: Span::fixed(sigma_m),
            temperature_c: Span::fixed(temperature_c),
            conductivity_us_per_cm: zero(),
            tracer: 0.0,
            depth_m: None,
            sigma_depth_m: None,
        }
    }

    #[test]
    fn the_maximum_of_two_plumes_that_overlap_is_found() {
        let plumes = vec![
            plume(0.0, 0.0, 100.0, 3.0),
            plume(120.0, 40.0, 80.0, 2.0),
            plume(900.0, 0.0, 50.0, -5.0),
        ];
        let field = Field::new(
            &FieldConfig {
                plumes,
                ..FieldConfig::default()
            },
            1,
        )
        .unwrap();
        let found = field.maximum().unwrap();
        let mut best = (f64::MIN, EastNorth::default());
        for east in -200..=300 {
            for north in -200..=200 {
                let at = EastNorth::new(f64::from(east), f64::from(north));
                let value = field.temperature_c(at, 10.0, Timestamp::ZERO);
                if value > best.0 {
                    best = (value, at);
                }
            }
        }
        assert!(found.distance_m(best.1) < 1.5, "{found:?} {best:?}");
        assert!(field.temperature_c(found, 10.0, Timestamp::ZERO) >= best.0);
    }

    #[test]
    fn a_plume_at_a_depth_has_no_effect_far_from_it() {
        let plumes = vec![PlumeConfig {
            depth_m: Some(Span::fixed(30.0)),
            sigma_depth_m: Some(5.0),
            ..plume(0.0, 0.0, 100.0, 4.0)
        }];
        let config = FieldConfig {
            plumes,
            cooling_c_per_m: 0.1,
            ..FieldConfig::default()
        };
        let field = Field::new(&config, 1).unwrap();
        let origin = EastNorth::default();
        assert!((field.temperature_c(origin, 30.0, Timestamp::ZERO) - (12.0 - 3.0 + 4.0)).abs() < 1e-9);
        assert!((field.temperature_c(origin, 0.0, Timestamp::ZERO) - 12.0).abs() < 1e-3);
        assert_eq!(field.maximum(), Some(origin));
    }

    #[test]
    fn centres_are_drawn_within_their_box() {
        let mut centres = Vec::new();
        for seed in 0..100 {
            let plumes = vec![PlumeConfig {
                east_m: Span::between(-50.0, 50.0),
                ..plume(0.0, 7.0, 100.0, 1.0)
            }];
            let field = Field::new(
                &FieldConfig {
                    plumes,
                    ..FieldConfig::default()
                },
                seed,
            )
            .unwrap();
            centres.push(field.maximum().unwrap());
        }
        assert!(centres.iter().all(|at| at.east_m.abs() <= 50.0 && at.north_m == 7.0));
        assert!(centres.iter().any(|at| at.east_m < -25.0) && centres.iter().any(|at| at.east_m > 25.0));
    }
}
