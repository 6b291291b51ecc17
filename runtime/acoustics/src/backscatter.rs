//! How much sound a piece of seabed scatters back.

use backseat_units::math::exp;
use backseat_world::Texture;

use crate::level::power_of;

/// Slope of the facets that reflect straight back, root mean square along each axis: 8 degrees.
const FACET_SLOPE: f64 = 0.14;
const FACET_SQUARE: f64 = FACET_SLOPE * FACET_SLOPE;
/// Beyond this many of their mean squares no facet is steep enough.
const STEEPEST: f64 = 40.0 * FACET_SQUARE;

/// The two coefficients of a texture, as ratios of powers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Coefficients {
    /// Lambert's.
    pub(crate) lambert: f64,
    /// The reflected part of the power of a wave that meets the bed straight on.
    pub(crate) reflected: f64,
}

impl Coefficients {
    pub(crate) fn of(texture: Texture) -> Self {
        Self {
            lambert: power_of(texture.backscatter_db),
            reflected: power_of(texture.class.reflectivity_db()),
        }
    }
}

/// Lambert's law: the power that a unit of area scatters back goes with the square of the sine of the grazing angle, and
/// the coefficient is that of the texture. Urick, *Principles of Underwater Sound* (McGraw-Hill 1983).
pub(crate) fn lambert(sin_grazing: f64) -> f64 {
    sin_grazing * sin_grazing
}

/// Reflection from facets near the vertical, over the reflected part of the power: sec⁴ θ exp(-tan² θ / (2 s²)) / (8 π
/// s²) at the angle of incidence θ with facets of the root mean square slope s. That is the high-frequency limit of the
/// Kirchhoff approximation: Jackson and Richardson, *High-Frequency Seafloor Acoustics* (Springer 2007). With
/// Lambert's law for the rest it is the simplest form of the APL-UW model (TR 9407, 1994).
pub(crate) fn facets(sin_grazing: f64) -> f64 {
    let square = sin_grazing * sin_grazing;
    let tan_square = (1.0 - square) / square;
    if tan_square < STEEPEST {
        exp(-0.5 * tan_square / FACET_SQUARE) / (8.0 * core::f64::consts::PI * FACET_SQUARE * square * square)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use backseat_units::math::{cos, sin};

    use super::*;

    #[test]
    fn facets_matter_near_the_vertical_only() {
        assert!((facets(1.0) - 1.0 / (8.0 * core::f64::consts::PI * FACET_SQUARE)).abs() < 1e-12);
        // One mean slope off the vertical.
        let off = cos(FACET_SLOPE);
        assert!((facets(off) / facets(1.0) - 0.61).abs() < 0.03);
        assert_eq!((facets(sin(0.7)), facets(0.0)), (0.0, 0.0));
    }
}
