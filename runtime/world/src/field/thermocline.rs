use serde::Deserialize;

use super::{FieldConfig, smooth_step};
use crate::error::{WorldError, check};
use crate::seawater;
use crate::span::Span;
use crate::stream::Stream;

/// `[field.thermocline]`: temperature and conductivity drop with depth, in the shape of a hyperbolic tangent.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ThermoclineConfig {
    /// Depth of its middle, metres, 0 to 12000.
    pub depth_m: Span,
    /// Its thickness, metres, 0.1 to 2000: 76 % of the drop lies within it.
    pub thickness_m: Span,
    /// How much colder the water is far below, degrees Celsius, within ±40; with a negative drop it is warmer.
    pub drop_c: Span,
    /// How much lower the conductivity is far below, microsiemens a centimetre, within ±100000. Unless given, it is the
    /// drop that keeps the salinity the same (at the pressure of the surface).
    #[serde(default)]
    pub conductivity_drop_us_per_cm: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Thermocline {
    depth_m: f64,
    per_half_thickness: f64,
    pub(super) drop_c: f64,
    pub(super) conductivity_drop_us_per_cm: f64,
}

impl ThermoclineConfig {
    /// Draws it from its own stream.
    pub(super) fn draw(&self, field: &FieldConfig, seed: u64) -> Result<Thermocline, WorldError> {
        self.depth_m
            .within(0.0, 12_000.0, "field.thermocline.depth_m", "0 to 12000 m")?;
        let key = "field.thermocline.thickness_m";
        self.thickness_m.within(0.1, 2000.0, key, "0.1 to 2000 m")?;
        let key = "field.thermocline.drop_c";
        self.drop_c.within(-40.0, 40.0, key, "-40 to 40 degrees Celsius")?;
        if let Some(drop) = self.conductivity_drop_us_per_cm {
            let key = "field.thermocline.conductivity_drop_us_per_cm";
            check(drop.abs() <= 100_000.0, key, drop, "-100000 to 100000 uS/cm")?;
        }
        let mut stream = Stream::new(seed, "thermocline");
        let depth_m = self.depth_m.draw(&mut stream);
        let per_half_thickness = 2.0 / self.thickness_m.draw(&mut stream);
        let drop_c = self.drop_c.draw(&mut stream);
        let conductivity_drop_us_per_cm = self.conductivity_drop_us_per_cm.unwrap_or_else(|| {
            let above = field.conductivity_us_per_cm;
            let salinity = seawater::salinity(above, field.temperature_c, 0.0);
            above - seawater::conductivity_us_per_cm(salinity, field.temperature_c - drop_c)
        });
        Ok(Thermocline {
            depth_m,
            per_half_thickness,
            drop_c,
            conductivity_drop_us_per_cm,
        })
    }
}

impl Thermocline {
    /// The part of the drop that lies above a depth, 0 to 1.
    pub(super) fn share(&self, depth_m: f64) -> f64 {
        smooth_step((depth_m - self.depth_m) * self.per_half_thickness)
    }
}

#[cfg(test)]
mod tests {
    use backseat_units::math::tanh;
    use backseat_units::{EastNorth, Timestamp};

    use super::*;
    use crate::field::Field;

    const TEXT: &str = "
        temperature_c = 18
        conductivity_us_per_cm = 45000
        [thermocline]
        depth_m = 20
        thickness_m = 6
        drop_c = 8
    ";

    #[test]
    fn a_thermocline_is_a_hyperbolic_tangent_around_its_depth() {
        let field = Field::new(&toml::from_str(TEXT).unwrap(), 1).unwrap();
        let at = |depth_m| field.temperature_c(EastNorth::default(), depth_m, Timestamp::ZERO);
        assert!((at(20.0) - 14.0).abs() < 1e-12);
        assert!((at(23.0) - (14.0 - 4.0 * tanh(1.0))).abs() < 1e-12);
        assert!((at(0.0) - 18.0).abs() < 1e-4 && (at(200.0) - 10.0).abs() < 1e-12);
    }

    #[test]
    fn the_salinity_is_the_same_above_and_below() {
        let field = Field::new(&toml::from_str(TEXT).unwrap(), 1).unwrap();
        let salinity = |depth_m| {
            let (at, now) = (EastNorth::default(), Timestamp::ZERO);
            seawater::salinity(
                field.conductivity_us_per_cm(at, depth_m, now),
                field.temperature_c(at, depth_m, now),
                0.0,
            )
        };
        assert!(
            (salinity(0.0) - salinity(100.0)).abs() < 1e-3,
            "{} {}",
            salinity(0.0),
            salinity(100.0)
        );
        assert!((salinity(0.0) - 34.0).abs() < 1.0);
        let given = TEXT.replace("drop_c = 8", "drop_c = 8\nconductivity_drop_us_per_cm = 500");
        let field = Field::new(&toml::from_str(&given).unwrap(), 1).unwrap();
        let below = field.conductivity_us_per_cm(EastNorth::default(), 300.0, Timestamp::ZERO);
        assert!((below - 44_500.0).abs() < 1e-9);
    }
}
