use backseat_units::EastNorth;
use backseat_units::math::exp;
use serde::Deserialize;

use crate::error::{WorldError, check};
use crate::span::Span;
use crate::stream::Stream;

/// The `[field]` section: what the water holds before plumes, and the plumes in it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FieldConfig {
    /// Temperature at the surface, degrees Celsius, -2 to 40.
    pub temperature_c: f64,
    /// How much colder it gets a metre down, degrees Celsius a metre, within ±1.
    pub cooling_c_per_m: f64,
    /// Conductivity, microsiemens a centimetre, 0 to 100000 (sea water: about 40000).
    pub conductivity_us_per_cm: f64,
    /// The plumes, at most 16.
    pub plumes: Vec<PlumeConfig>,
}

impl Default for FieldConfig {
    fn default() -> Self {
        Self {
            temperature_c: 12.0,
            cooling_c_per_m: 0.0,
            conductivity_us_per_cm: 40_000.0,
            plumes: Vec::new(),
        }
    }
}

/// One `[[field.plumes]]`: a Gaussian, the same at all depths unless it is given a depth.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlumeConfig {
    /// Where its centre lies, metres east of the origin.
    pub east_m: Span,
    /// Where its centre lies, metres north of the origin.
    pub north_m: Span,
    /// Its radius (one standard deviation), metres, 1 to 20000.
    pub sigma_m: Span,
    /// What it adds to the temperature at its centre, degrees Celsius, within ±400.
    #[serde(default = "zero")]
    pub temperature_c: Span,
    /// What it adds to the conductivity at its centre, microsiemens a centimetre, within ±100000.
    #[serde(default = "zero")]
    pub conductivity_us_per_cm: Span,
    /// The depth of its centre, metres; none is the same at all depths.
    #[serde(default)]
    pub depth_m: Option<Span>,
    /// Its vertical standard deviation, metres, 0.5 or more, where it has a depth; 10 m unless given.
    #[serde(default)]
    pub sigma_depth_m: Option<f64>,
}

const fn zero() -> Span {
    Span::fixed(0.0)
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Plume {
    centre: EastNorth,
    /// One over the radius squared.
    tightness: f64,
    temperature_c: f64,
    conductivity_us_per_cm: f64,
    /// Depth of the centre, and one over the vertical radius squared; zero is the same at all depths.
    depth_m: f64,
    vertical_tightness: f64,
}

impl Plume {
    fn share(&self, at: EastNorth, depth_m: f64) -> f64 {
        let from = at - self.centre;
        let below = depth_m - self.depth_m;
        let square = (from.east_m * from.east_m + from.north_m * from.north_m) * self.tightness
            + below * below * self.vertical_tightness;
        if square > 100.0 { 0.0 } else { exp(-0.5 * square) }
    }
}

/// The scalar fields that a seed has drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    temperature_c: f64,
    cooling_c_per_m: f64,
    conductivity_us_per_cm: f64,
    plumes: Vec<Plume>,
    maximum: Option<EastNorth>,
}

impl Field {
    /// Draws the fields.
    ///
    /// # Errors
    /// [`WorldError`] where the configuration leaves its ranges.
    pub fn new(config: &FieldConfig, seed: u64) -> Result<Self, WorldError> {
        validate(config)?;
        let mut stream = Stream::new(seed, "field");
        let plumes: Vec<Plume> = config
            .plumes
            .iter()
            .map(|plume| {
                let centre = EastNorth::new(plume.east_m.draw(&mut stream), plume.north_m.draw(&mut stream));
                let sigma_m = plume.sigma_m.draw(&mut stream);
                let temperature_c = plume.temperature_c.draw(&mut stream);
                let conductivity_us_per_cm = plume.conductivity_us_per_cm.draw(&mut stream);
                let (depth_m, vertical_tightness) = plume.depth_m.map_or((0.0, 0.0), |depth| {
                    let sigma_m = plume.sigma_depth_m.unwrap_or(10.0);
                    (depth.draw(&mut stream), 1.0 / (sigma_m * sigma_m))
                });
                let tightness = 1.0 / (sigma_m * sigma_m);
                Plume {
                    centre,
                    tightness,
                    temperature_c,
                    conductivity_us_per_cm,
                    depth_m,
                    vertical_tightness,
                }
            })
            .collect();
        let maximum = maximum(&plumes);
        Ok(Self {
            temperature_c: config.temperature_c,
            cooling_c_per_m: config.cooling_c_per_m,
            conductivity_us_per_cm: config.conductivity_us_per_cm,
            plumes,
            maximum,
        })
    }

    /// Temperature, degrees Celsius.
    #[must_use]
    pub fn temperature_c(&self, at: EastNorth, depth_m: f64) -> f64 {
        let background = self.temperature_c - self.cooling_c_per_m * depth_m;
        self.plumes.iter().fold(background, |sum, plume| {
            sum + plume.temperature_c * plume.share(at, depth_m)
        })
    }

    /// Conductivity, microsiemens a centimetre, never below 0.
    #[must_use]
    pub fn conductivity_us_per_cm(&self, at: EastNorth, depth_m: f64) -> f64 {
        let sum = self.plumes.iter().fold(self.conductivity_us_per_cm, |sum, plume| {
            sum + plume.conductivity_us_per_cm * plume.share(at, depth_m)
        });
        sum.max(0.0)
    }

    /// Where the plumes add most: to the temperature where any plume warms, else to the conductivity. Each plume is
    /// taken at its own depth, so that this is the maximum of the field seen from above. None without such a plume.
    #[must_use]
    pub fn maximum(&self) -> Option<EastNorth> {
        self.maximum
    }
}

/// The highest point of a sum of Gaussians, by mean shift from every centre: at a maximum, the point is the mean of
/// the centres weighted by what each adds to the curvature there (Fukunaga and Hostetler, 1975).
fn maximum(plumes: &[Plume]) -> Option<EastNorth> {
    let warm = plumes.iter().any(|plume| plume.temperature_c > 0.0);
    let amplitude = |plume: &Plume| {
        if warm {
            plume.temperature_c
        } else {
            plume.conductivity_us_per_cm
        }
    };
    let value = |at| {
        plumes.iter().fold(0.0, |sum, plume| {
            sum + amplitude(plume) * plume.share(at, plume.depth_m)
        })
    };
    let mut best: Option<(f64, EastNorth)> = None;
    for start in plumes.iter().filter(|plume| amplitude(plume) > 0.0) {
        let mut at = start.centre;
        for _ in 0..200 {
            let mut sum = EastNorth::default();
            let mut weights = 0.0;
            for plume in plumes {
                let weight = amplitude(plume) * plume.tightness * plume.share(at, plume.depth_m);
                sum = sum + plume.centre * weight;
                weights += weight;
            }
            if weights <= 0.0 {
                break;
            }
            at = sum * (1.0 / weights);
        }
        let height = value(at);
        if best.is_none_or(|(highest, _)| height > highest) {
            best = Some((height, at));
        }
    }
    best.map(|(_, at)| at)
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
        "within 1 a metre",
    )?;
    let conductivity = config.conductivity_us_per_cm;
    let conductivity_ok = (0.0..=100_000.0).contains(&conductivity);
    check(
        conductivity_ok,
        "field.conductivity_us_per_cm",
        conductivity,
        "0 to 100000 uS/cm",
    )?;
    let count = config.plumes.len();
    check(count <= 16, "field.plumes", count as f64, "at most 16 plumes")?;
    for plume in &config.plumes {
        plume
            .east_m
            .within(-50_000.0, 50_000.0, "field.plumes.east_m", "within 50 km of the origin")?;
        plume.north_m.within(
            -50_000.0,
            50_000.0,
            "field.plumes.north_m",
            "within 50 km of the origin",
        )?;
        plume
            .sigma_m
            .within(1.0, 20_000.0, "field.plumes.sigma_m", "1 to 20000 m")?;
        plume.temperature_c.within(
            -400.0,
            400.0,
            "field.plumes.temperature_c",
            "within 400 degrees Celsius",
        )?;
        let key = "field.plumes.conductivity_us_per_cm";
        plume
            .conductivity_us_per_cm
            .within(-100_000.0, 100_000.0, key, "within 100000 uS/cm")?;
        if let Some(depth) = plume.depth_m {
            depth.within(0.0, 12_000.0, "field.plumes.depth_m", "0 to 12000 m")?;
        }
        if let Some(sigma) = plume.sigma_depth_m {
            check(
                (0.5..=12_000.0).contains(&sigma),
                "field.plumes.sigma_depth_m",
                sigma,
                "0.5 to 12000 m",
            )?;
        }
    }
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
                let value = field.temperature_c(at, 10.0);
                if value > best.0 {
                    best = (value, at);
                }
            }
        }
        assert!(found.distance_m(best.1) < 1.5, "{found:?} {best:?}");
        assert!(field.temperature_c(found, 10.0) >= best.0);
    }

    #[test]
    fn a_plume_at_a_depth_is_felt_only_near_it() {
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
        assert!((field.temperature_c(origin, 30.0) - (12.0 - 3.0 + 4.0)).abs() < 1e-9);
        assert!((field.temperature_c(origin, 0.0) - 12.0).abs() < 1e-3);
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
