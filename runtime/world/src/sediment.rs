//! Layers below the seabed, for a simulated sub-bottom profiler.

use backseat_units::EastNorth;
use backseat_units::math::{TAU, sin, sin_cos};
use serde::Deserialize;

use crate::error::{WorldError, check};
use crate::seabed::SeabedConfig;
use crate::span::Span;
use crate::stream::Stream;

/// The most layers that a world can have.
const LAYERS_MAX: usize = 16;
/// How the undulation of a layer is shared among its waves.
const SHARES: [f64; 3] = [0.5, 0.3, 0.2];

/// One `[[seabed.layers]]`: a boundary below the seabed that reflects sound.
///
/// The boundary lies `depth_m` below the seabed and undulates about that by at most `undulation_m`, in three waves whose
/// lengths, directions and phases the seed draws. Where it would be above the seabed there is no layer.
///
/// ```
/// let config: backseat_world::SeabedConfig = toml::from_str(r#"
/// [[layers]]
/// depth_m = [2, 4]
/// undulation_m = 0.8
///
/// [[layers]]
/// depth_m = 9
/// reflectivity_db = -12
/// attenuation_db_per_m_khz = 0.3
/// "#)?;
/// assert_eq!(config.layers.len(), 2);
/// # Ok::<(), toml::de::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SedimentLayerConfig {
    /// Mean depth below the seabed, metres, 0.05 to 500.
    pub depth_m: Span,
    /// How much of the pressure is reflected: twenty times the logarithm, decibels, -80 to 0; -20 unless given.
    #[serde(default = "reflectivity")]
    pub reflectivity_db: Span,
    /// Attenuation in the sediment above it, up to the next boundary, decibels a metre and kilohertz, 0 to 2; 0.1
    /// unless given. Mud has less, sand more: Hamilton, *Compressional-wave attenuation in marine sediments*, Geophysics
    /// 37 (1972).
    #[serde(default = "attenuation")]
    pub attenuation_db_per_m_khz: Span,
    /// How far it is from its mean depth at most, metres, 0 to 50; 0.5 unless given.
    #[serde(default = "undulation")]
    pub undulation_m: Span,
    /// Wavelength of its waves, metres, 10 to 20000; 80 to 400 unless given.
    #[serde(default = "wavelength")]
    pub undulation_wavelength_m: Span,
}

const fn reflectivity() -> Span {
    Span::fixed(-20.0)
}

const fn attenuation() -> Span {
    Span::fixed(0.1)
}

const fn undulation() -> Span {
    Span::fixed(0.5)
}

const fn wavelength() -> Span {
    Span::between(80.0, 400.0)
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Wave {
    amplitude_m: f64,
    /// Wave vector, radians per metre.
    wave: EastNorth,
    phase_rad: f64,
}

/// A boundary below the seabed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SedimentLayer {
    /// Its mean depth below the seabed, metres.
    pub depth_m: f64,
    /// How much of the pressure is reflected: twenty times the logarithm, decibels.
    pub reflectivity_db: f64,
    /// Attenuation in the sediment above it, up to the next boundary, decibels a metre and kilohertz.
    pub attenuation_db_per_m_khz: f64,
    waves: [Wave; 3],
}

impl SedimentLayer {
    fn draw(config: &SedimentLayerConfig, stream: &mut Stream) -> Self {
        let depth_m = config.depth_m.draw(stream);
        let reflectivity_db = config.reflectivity_db.draw(stream);
        let attenuation_db_per_m_khz = config.attenuation_db_per_m_khz.draw(stream);
        let undulation_m = config.undulation_m.draw(stream);
        let waves = SHARES.map(|share| {
            let number = TAU / config.undulation_wavelength_m.draw(stream);
            let (east, north) = sin_cos(stream.uniform_in(0.0, TAU));
            Wave {
                amplitude_m: share * undulation_m,
                wave: EastNorth::new(east, north) * number,
                phase_rad: stream.uniform_in(0.0, TAU),
            }
        });
        Self {
            depth_m,
            reflectivity_db,
            attenuation_db_per_m_khz,
            waves,
        }
    }

    /// Its depth below the seabed at a place, metres. Zero or less means that there is no layer.
    #[must_use]
    pub fn depth_at_m(&self, at: EastNorth) -> f64 {
        let swing = |wave: &Wave| {
            let phase = wave.wave.east_m * at.east_m + wave.wave.north_m * at.north_m + wave.phase_rad;
            wave.amplitude_m * sin(phase)
        };
        self.depth_m + self.waves.iter().map(swing).sum::<f64>()
    }
}

/// Draws the layers from their own stream, sorted by their mean depths.
pub(crate) fn draw(config: &SeabedConfig, seed: u64) -> Result<Vec<SedimentLayer>, WorldError> {
    validate(config)?;
    let mut stream = Stream::new(seed, "sediment");
    let mut layers: Vec<SedimentLayer> = config
        .layers
        .iter()
        .map(|layer| SedimentLayer::draw(layer, &mut stream))
        .collect();
    layers.sort_by(|one, other| one.depth_m.total_cmp(&other.depth_m));
    Ok(layers)
}

/// Checks the ranges of all keys.
pub(crate) fn validate(config: &SeabedConfig) -> Result<(), WorldError> {
    let count = config.layers.len();
    check(count <= LAYERS_MAX, "seabed.layers", count as f64, "at most 16")?;
    for layer in &config.layers {
        layer
            .depth_m
            .within(0.05, 500.0, "seabed.layers.depth_m", "0.05 to 500 m")?;
        layer
            .reflectivity_db
            .within(-80.0, 0.0, "seabed.layers.reflectivity_db", "-80 to 0 dB")?;
        let key = "seabed.layers.attenuation_db_per_m_khz";
        layer
            .attenuation_db_per_m_khz
            .within(0.0, 2.0, key, "0 to 2 dB a metre and kilohertz")?;
        layer
            .undulation_m
            .within(0.0, 50.0, "seabed.layers.undulation_m", "0 to 50 m")?;
        let key = "seabed.layers.undulation_wavelength_m";
        layer
            .undulation_wavelength_m
            .within(10.0, 20_000.0, key, "10 to 20000 m")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "
        [[layers]]
        depth_m = [8, 12]
        [[layers]]
        depth_m = 3
        undulation_m = 0.8
        undulation_wavelength_m = 100
    ";

    fn layers(text: &str, seed: u64) -> Result<Vec<SedimentLayer>, WorldError> {
        draw(&toml::from_str(text).unwrap(), seed)
    }

    #[test]
    fn layers_undulate_about_their_depth_and_are_sorted() {
        let drawn = layers(TEXT, 2).unwrap();
        assert_eq!(drawn, layers(TEXT, 2).unwrap());
        assert_ne!(drawn, layers(TEXT, 3).unwrap());
        assert_eq!(drawn[0].depth_m, 3.0);
        assert!((8.0..=12.0).contains(&drawn[1].depth_m));
        let depths: Vec<f64> = (0..1000)
            .map(|step| drawn[0].depth_at_m(EastNorth::new(0.7 * f64::from(step), 0.3 * f64::from(step))))
            .collect();
        let least = depths.iter().copied().fold(f64::MAX, f64::min);
        let most = depths.iter().copied().fold(f64::MIN, f64::max);
        assert!(
            (2.2..2.8).contains(&least) && (3.2..=3.8).contains(&most),
            "{least} {most}"
        );
    }

    #[test]
    fn ranges_are_checked_by_their_key() {
        let message = |from: &str, to: &str| layers(&TEXT.replace(from, to), 1).unwrap_err().to_string();
        assert_eq!(
            message("[8, 12]", "[0, 12]"),
            "seabed.layers.depth_m is 0, expected 0.05 to 500 m"
        );
        let many = "[[layers]]\ndepth_m = 1\n".repeat(17);
        assert_eq!(
            layers(&many, 1).unwrap_err().to_string(),
            "seabed.layers is 17, expected at most 16"
        );
        assert!(toml::from_str::<SeabedConfig>(&TEXT.replace("undulation_m", "wave_m")).is_err());
    }
}
