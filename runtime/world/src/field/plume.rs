use backseat_units::EastNorth;
use backseat_units::math::exp;
use serde::Deserialize;

use super::{Adds, zero};
use crate::error::{WorldError, check};
use crate::span::Span;
use crate::stream::Stream;

/// One `[[field.plumes]]`: a Gaussian, the same at all depths unless it has a depth.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlumeConfig {
    /// Position of its centre, metres east of the origin.
    pub east_m: Span,
    /// Position of its centre, metres north of the origin.
    pub north_m: Span,
    /// Its radius (one standard deviation), metres, 1 to 20000.
    pub sigma_m: Span,
    /// What it adds to the temperature at its centre, degrees Celsius, within ±400.
    #[serde(default = "zero")]
    pub temperature_c: Span,
    /// What it adds to the conductivity at its centre, microsiemens a centimetre, within ±100000.
    #[serde(default = "zero")]
    pub conductivity_us_per_cm: Span,
    /// What it adds to the tracer at its centre, in the unit that the mission uses for it, 0 to 1e6.
    #[serde(default)]
    pub tracer: f64,
    /// The depth of its centre, metres; without it, the plume is the same at all depths.
    #[serde(default)]
    pub depth_m: Option<Span>,
    /// Its vertical standard deviation, metres, 0.5 or more, if it has a depth; 10 m unless given.
    #[serde(default)]
    pub sigma_depth_m: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plume {
    centre: EastNorth,
    /// One over the radius squared.
    tightness: f64,
    /// What it adds at its centre.
    pub(super) adds: Adds,
    /// Depth of the centre. `vertical_tightness` is one over the vertical radius squared; zero means the same at all
    /// depths.
    depth_m: f64,
    vertical_tightness: f64,
}

impl Plume {
    pub(super) fn share(&self, at: EastNorth, depth_m: f64) -> f64 {
        let from = at - self.centre;
        let below = depth_m - self.depth_m;
        let square = (from.east_m * from.east_m + from.north_m * from.north_m) * self.tightness
            + below * below * self.vertical_tightness;
        if square > 100.0 { 0.0 } else { exp(-0.5 * square) }
    }
}

/// Draws the plumes.
pub(super) fn draw(configs: &[PlumeConfig], seed: u64) -> Result<Vec<Plume>, WorldError> {
    validate(configs)?;
    let mut stream = Stream::new(seed, "field");
    Ok(configs
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
                adds: Adds {
                    temperature_c,
                    conductivity_us_per_cm,
                    tracer: plume.tracer,
                },
                depth_m,
                vertical_tightness,
            }
        })
        .collect())
}

/// The highest point of a sum of Gaussians, found by mean shift from each centre that adds: at a maximum, the point is
/// the mean of all centres, weighted by what each adds to the curvature there (Fukunaga and Hostetler, 1975).
pub(super) fn maximum(plumes: &[Plume]) -> Option<EastNorth> {
    let warm = plumes.iter().any(|plume| plume.adds.temperature_c > 0.0);
    let amplitude = |plume: &Plume| {
        if warm {
            plume.adds.temperature_c
        } else {
            plume.adds.conductivity_us_per_cm
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

fn validate(configs: &[PlumeConfig]) -> Result<(), WorldError> {
    let count = configs.len();
    check(count <= 16, "field.plumes", count as f64, "at most 16 plumes")?;
    for plume in configs {
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
            "-400 to 400 degrees Celsius",
        )?;
        let key = "field.plumes.conductivity_us_per_cm";
        plume
            .conductivity_us_per_cm
            .within(-100_000.0, 100_000.0, key, "-100000 to 100000 uS/cm")?;
        let tracer_ok = (0.0..=1e6).contains(&plume.tracer);
        check(tracer_ok, "field.plumes.tracer", plume.tracer, "0 to 1000000")?;
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
