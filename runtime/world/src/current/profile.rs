use backseat_units::math::{exp, pow, sin_cos};
use serde::Deserialize;

use crate::error::{WorldError, agree, check};

/// One `[[current.layers]]`: how the current changes at a depth. Between two layers, the east and north parts change
/// linearly from one to the other. Above the first layer and below the last one, they are those of that layer.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LayerConfig {
    /// Depth, metres, 0 to 12000. Each layer is deeper than the one before.
    pub depth_m: f64,
    /// Factor on the speed, 0 to 5; 1 unless given.
    #[serde(default = "one")]
    pub factor: f64,
    /// Clockwise turn of the direction, degrees, -360 to 360; 0 unless given.
    #[serde(default)]
    pub turn_deg: f64,
}

const fn one() -> f64 {
    1.0
}

/// How the current changes with depth.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Profile {
    Uniform,
    /// Exponential decay: one over the depth at which the current has fallen to 1/e.
    Decay(f64),
    Layers(Vec<Layer>),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Layer {
    depth_m: f64,
    /// Factor times cosine of the turn; `right` is factor times sine.
    along: f64,
    right: f64,
}

impl Profile {
    pub(super) fn new(decay_depth_m: Option<f64>, layers: &[LayerConfig]) -> Result<Self, WorldError> {
        let count = layers.len();
        check(count <= 16, "current.layers", count as f64, "at most 16 layers")?;
        if let Some(decay) = decay_depth_m {
            let key = "current.decay_depth_m";
            check((1.0..=1e6).contains(&decay), key, decay, "1 m or more")?;
            agree(layers.is_empty(), key, "this key or `current.layers`, not both")?;
            return Ok(Self::Decay(1.0 / decay));
        }
        let mut above_m = -1.0;
        let mut drawn = Vec::with_capacity(count);
        for layer in layers {
            let LayerConfig {
                depth_m,
                factor,
                turn_deg,
            } = *layer;
            let ok = depth_m > above_m && (0.0..=12_000.0).contains(&depth_m);
            check(
                ok,
                "current.layers.depth_m",
                depth_m,
                "0 to 12000 m, deeper than the layer before",
            )?;
            check((0.0..=5.0).contains(&factor), "current.layers.factor", factor, "0 to 5")?;
            let ok = turn_deg.abs() <= 360.0;
            check(ok, "current.layers.turn_deg", turn_deg, "-360 to 360 degrees")?;
            let (sin, cos) = sin_cos(turn_deg.to_radians());
            drawn.push(Layer {
                depth_m,
                along: factor * cos,
                right: factor * sin,
            });
            above_m = depth_m;
        }
        Ok(if drawn.is_empty() {
            Self::Uniform
        } else {
            Self::Layers(drawn)
        })
    }

    pub(super) fn apply(&self, (east, north): (f64, f64), depth_m: f64) -> (f64, f64) {
        match self {
            Self::Uniform => (east, north),
            Self::Decay(per_m) => {
                let factor = exp(-depth_m.max(0.0) * per_m);
                (east * factor, north * factor)
            }
            Self::Layers(layers) => {
                let (along, right) = between(layers, depth_m);
                (east * along + north * right, north * along - east * right)
            }
        }
    }
}

fn between(layers: &[Layer], depth_m: f64) -> (f64, f64) {
    let below = layers.partition_point(|layer| layer.depth_m <= depth_m);
    match (
        below.checked_sub(1).and_then(|above| layers.get(above)),
        layers.get(below),
    ) {
        (Some(above), Some(below)) => {
            let share = (depth_m - above.depth_m) / (below.depth_m - above.depth_m);
            (
                above.along + (below.along - above.along) * share,
                above.right + (below.right - above.right) * share,
            )
        }
        (Some(only), None) | (None, Some(only)) => (only.along, only.right),
        (None, None) => (1.0, 0.0),
    }
}

/// The seventh root of a share, clamped to 0 to 1.
pub(super) fn power_law(share: f64) -> f64 {
    if share >= 1.0 {
        1.0
    } else if share > 0.0 {
        pow(share, 1.0 / 7.0)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_are_linear_between_and_constant_beyond() {
        let layers = [
            LayerConfig {
                depth_m: 10.0,
                factor: 1.0,
                turn_deg: 0.0,
            },
            LayerConfig {
                depth_m: 30.0,
                factor: 0.5,
                turn_deg: 90.0,
            },
        ];
        let profile = Profile::new(None, &layers).unwrap();
        let at = |depth_m| profile.apply((0.0, 0.4), depth_m);
        assert_eq!((at(-1.0), at(0.0), at(10.0)), ((0.0, 0.4), (0.0, 0.4), (0.0, 0.4)));
        // North turned right by 90 degrees is east.
        for depth_m in [30.0, 500.0] {
            let (east, north) = at(depth_m);
            assert!((east - 0.2).abs() < 1e-12 && north.abs() < 1e-12);
        }
        let (east, north) = at(20.0);
        assert!((east - 0.1).abs() < 1e-12 && (north - 0.2).abs() < 1e-12);
    }

    #[test]
    fn layers_must_deepen_and_exclude_a_decay_depth() {
        let layer = LayerConfig {
            depth_m: 10.0,
            factor: 1.0,
            turn_deg: 0.0,
        };
        let error = Profile::new(None, &[layer, layer]).unwrap_err();
        assert_eq!(
            error.to_string(),
            "current.layers.depth_m is 10, expected 0 to 12000 m, deeper than the layer before"
        );
        let error = Profile::new(Some(20.0), &[layer]).unwrap_err();
        assert_eq!(
            error.to_string(),
            "current.decay_depth_m: expected this key or `current.layers`, not both"
        );
    }
}
