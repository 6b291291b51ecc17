//! What the seabed is made of, for simulated sonars: one class everywhere, and patches of others that the seed scatters.

use backseat_units::EastNorth;
use backseat_units::math::{sin_cos, wrap_360};
use serde::Deserialize;

use crate::error::{WorldError, check};
use crate::seabed::SeabedConfig;
use crate::span::Span;
use crate::stream::Stream;

/// The most patches that a world can have.
const PATCHES_MAX: u64 = 1000;
const BACKSCATTER_RANGE: &str = "-60 to 0 dB";

/// What a piece of seabed is made of.
///
/// The figures of a class are typical ones, and describe no particular site: measure yours, and write `backscatter_db`.
/// The backscatter of sand is Mackenzie's (*Bottom reverberation for 530 and 1030 cps sound in deep water*, Journal of
/// the Acoustical Society of America 33, 1961), who found the same -27 dB over many bottoms. The other classes are set
/// around it by us, in the order that measurements agree on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum BottomClass {
    /// Clay and soft mud.
    Mud,
    /// Silt.
    Silt,
    /// Sand.
    #[default]
    Sand,
    /// Gravel and shells.
    Gravel,
    /// Rock.
    Rock,
}

impl BottomClass {
    /// Its backscatter: ten times the logarithm of Lambert's coefficient, decibels.
    #[must_use]
    pub const fn backscatter_db(self) -> f64 {
        match self {
            Self::Mud => -37.0,
            Self::Silt => -32.0,
            Self::Sand => -27.0,
            Self::Gravel => -20.0,
            Self::Rock => -14.0,
        }
    }

    /// How much of the pressure of a wave that meets it straight on is reflected: twenty times the logarithm, decibels.
    ///
    /// It is (z - 1) / (z + 1) for an impedance of z times that of water: 1.4, 1.75, 2.3, 2.7 and 5.5 from mud to rock,
    /// as the densities and speeds of Hamilton and Bachman make it (*Sound velocity and related properties of marine
    /// sediments*, Journal of the Acoustical Society of America 72, 1982), rounded.
    #[must_use]
    pub const fn reflectivity_db(self) -> f64 {
        match self {
            Self::Mud => -16.0,
            Self::Silt => -11.0,
            Self::Sand => -8.0,
            Self::Gravel => -7.0,
            Self::Rock => -3.0,
        }
    }
}

/// One `[[seabed.patches]]`: one elliptic patch of seabed of another class, or `count` patches that the seed scatters
/// over the box of `east_m` and `north_m`, each with its own draws. A later patch lies over an earlier one.
///
/// ```
/// let config: backseat_world::SeabedConfig = toml::from_str(r#"
/// bottom = "sand"
///
/// [[patches]]
/// count = 6
/// bottom = "gravel"
/// east_m = [-800, 800]
/// north_m = [-800, 800]
/// length_m = [80, 300]
/// width_m = [40, 120]
/// heading_deg = [0, 180]
///
/// [[patches]]
/// bottom = "rock"
/// east_m = 100
/// north_m = 40
/// backscatter_db = -12
/// "#)?;
/// assert_eq!(config.patches.len(), 2);
/// # Ok::<(), toml::de::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PatchConfig {
    /// Number of such patches; 1 unless given. All entries together may have at most 1000.
    #[serde(default = "single")]
    pub count: u32,
    /// What they are made of.
    pub bottom: BottomClass,
    /// Position of its middle, metres east of the origin.
    pub east_m: Span,
    /// Position of its middle, metres north of the origin.
    pub north_m: Span,
    /// Its diameter along its heading, metres, 1 to 20000; 200 unless given.
    #[serde(default = "long")]
    pub length_m: Span,
    /// Its diameter across its heading, metres, 1 to 20000; 100 unless given.
    #[serde(default = "wide")]
    pub width_m: Span,
    /// Its heading, degrees clockwise from the frame's north; 0 unless given.
    #[serde(default = "zero")]
    pub heading_deg: Span,
    /// Its backscatter, decibels, -60 to 0; that of its class unless given, see [`BottomClass::backscatter_db`].
    pub backscatter_db: Option<Span>,
}

const fn single() -> u32 {
    1
}

const fn long() -> Span {
    Span::fixed(200.0)
}

const fn wide() -> Span {
    Span::fixed(100.0)
}

const fn zero() -> Span {
    Span::fixed(0.0)
}

/// What a piece of seabed sends back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texture {
    /// What it is made of.
    pub class: BottomClass,
    /// Its backscatter: ten times the logarithm of Lambert's coefficient, decibels.
    pub backscatter_db: f64,
}

/// An elliptic patch of seabed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// What it sends back.
    pub texture: Texture,
    /// Its middle, in the world's frame.
    pub at: EastNorth,
    /// Its diameter along its heading, metres.
    pub length_m: f64,
    /// Its diameter across its heading, metres.
    pub width_m: f64,
    /// Its heading, degrees clockwise from the frame's north, in [0, 360).
    pub heading_deg: f64,
    /// Along its heading and across it, each over half of its diameter: a vector from the middle is inside if these
    /// make at most 1.
    along: EastNorth,
    across: EastNorth,
}

impl Patch {
    fn new(texture: Texture, at: EastNorth, length_m: f64, width_m: f64, heading_deg: f64) -> Self {
        let (sin, cos) = sin_cos(heading_deg.to_radians());
        Self {
            texture,
            at,
            length_m,
            width_m,
            heading_deg: wrap_360(heading_deg),
            along: EastNorth::new(sin, cos) * (2.0 / length_m),
            across: EastNorth::new(cos, -sin) * (2.0 / width_m),
        }
    }

    /// A vector of the frame in units of the patch: along its heading and across it, 1 at its edge.
    fn scaled(&self, vector: EastNorth) -> (f64, f64) {
        (
            self.along.east_m * vector.east_m + self.along.north_m * vector.north_m,
            self.across.east_m * vector.east_m + self.across.north_m * vector.north_m,
        )
    }

    /// Whether a place is on it.
    #[must_use]
    pub fn contains(&self, at: EastNorth) -> bool {
        let (x, y) = self.scaled(at - self.at);
        x * x + y * y <= 1.0
    }

    /// Where the line through `from` along the vector `direction` crosses the patch: the multiples of `direction` at
    /// which it enters and leaves. `None` if it does not cross it, or only touches it.
    #[must_use]
    pub fn crossing(&self, from: EastNorth, direction: EastNorth) -> Option<(f64, f64)> {
        let (x, y) = self.scaled(from - self.at);
        let (dx, dy) = self.scaled(direction);
        let (a, half_b, c) = (dx * dx + dy * dy, x * dx + y * dy, x * x + y * y - 1.0);
        let square = half_b * half_b - a * c;
        if square > 0.0 && a > 0.0 {
            let root = square.sqrt();
            Some(((-half_b - root) / a, (-half_b + root) / a))
        } else {
            None
        }
    }
}

/// What the seabed is made of, everywhere.
#[derive(Clone, Debug, PartialEq)]
pub struct Bottom {
    base: Texture,
    patches: Vec<Patch>,
}

impl Bottom {
    /// Draws the patches from their own stream.
    pub(crate) fn new(config: &SeabedConfig, seed: u64) -> Result<Self, WorldError> {
        validate(config)?;
        let mut stream = Stream::new(seed, "bottom");
        let texture = |class: BottomClass, backscatter: Option<Span>, stream: &mut Stream| Texture {
            class,
            backscatter_db: backscatter.unwrap_or(Span::fixed(class.backscatter_db())).draw(stream),
        };
        let base = texture(config.bottom, config.backscatter_db, &mut stream);
        let mut patches = Vec::new();
        for patch in &config.patches {
            patches.extend((0..patch.count).map(|_| {
                let at = EastNorth::new(patch.east_m.draw(&mut stream), patch.north_m.draw(&mut stream));
                let length_m = patch.length_m.draw(&mut stream);
                let width_m = patch.width_m.draw(&mut stream);
                let heading_deg = patch.heading_deg.draw(&mut stream);
                let texture = texture(patch.bottom, patch.backscatter_db, &mut stream);
                Patch::new(texture, at, length_m, width_m, heading_deg)
            }));
        }
        Ok(Self { base, patches })
    }

    /// The seabed where no patch lies.
    #[must_use]
    pub const fn base(&self) -> Texture {
        self.base
    }

    /// The patches. A later one lies over an earlier one.
    #[must_use]
    pub fn patches(&self) -> &[Patch] {
        &self.patches
    }

    /// The seabed at a place.
    #[must_use]
    pub fn at(&self, at: EastNorth) -> Texture {
        let uppermost = self.patches.iter().rev().find(|patch| patch.contains(at));
        uppermost.map_or(self.base, |patch| patch.texture)
    }
}

/// Checks the ranges of all keys.
pub(crate) fn validate(config: &SeabedConfig) -> Result<(), WorldError> {
    if let Some(backscatter) = config.backscatter_db {
        backscatter.within(-60.0, 0.0, "seabed.backscatter_db", BACKSCATTER_RANGE)?;
    }
    let count: u64 = config.patches.iter().map(|patch| u64::from(patch.count)).sum();
    let expected = "at most 1000 in all";
    check(count <= PATCHES_MAX, "seabed.patches.count", count as f64, expected)?;
    for patch in &config.patches {
        let near = "within 50 km of the origin";
        patch
            .east_m
            .within(-50_000.0, 50_000.0, "seabed.patches.east_m", near)?;
        patch
            .north_m
            .within(-50_000.0, 50_000.0, "seabed.patches.north_m", near)?;
        let size = "1 to 20000 m";
        patch.length_m.within(1.0, 20_000.0, "seabed.patches.length_m", size)?;
        patch.width_m.within(1.0, 20_000.0, "seabed.patches.width_m", size)?;
        let turn = "-360 to 720 degrees";
        patch
            .heading_deg
            .within(-360.0, 720.0, "seabed.patches.heading_deg", turn)?;
        if let Some(backscatter) = patch.backscatter_db {
            backscatter.within(-60.0, 0.0, "seabed.patches.backscatter_db", BACKSCATTER_RANGE)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "
        bottom = \"silt\"
        [[patches]]
        count = 40
        bottom = \"gravel\"
        east_m = [-500, 500]
        north_m = [-500, 500]
        length_m = [50, 200]
        heading_deg = [0, 180]
        [[patches]]
        bottom = \"rock\"
        east_m = 10
        north_m = 20
        length_m = 60
        width_m = 20
        heading_deg = 90
        backscatter_db = -11
    ";

    fn bottom(text: &str, seed: u64) -> Result<Bottom, WorldError> {
        Bottom::new(&toml::from_str(text).unwrap(), seed)
    }

    #[test]
    fn the_seed_scatters_patches_and_later_ones_lie_on_top() {
        let one = bottom(TEXT, 5).unwrap();
        assert_eq!(one, bottom(TEXT, 5).unwrap());
        assert_ne!(one, bottom(TEXT, 6).unwrap());
        assert_eq!(one.patches().len(), 41);
        let rock = one.at(EastNorth::new(39.9, 20.0));
        assert_eq!((rock.class, rock.backscatter_db), (BottomClass::Rock, -11.0));
        assert_ne!(one.at(EastNorth::new(10.0, 30.1)).class, BottomClass::Rock);
        let far = one.at(EastNorth::new(5000.0, 0.0));
        assert_eq!((far.class, far.backscatter_db), (BottomClass::Silt, -32.0));
    }

    #[test]
    fn a_line_crosses_a_patch_where_it_says() {
        let one = bottom(TEXT, 5).unwrap();
        let from = EastNorth::new(-120.0, 35.0);
        let mut crossed = 0;
        for patch in one.patches() {
            for bearing_deg in [0.0, 33.0, 90.0, 250.0] {
                let direction = EastNorth::default().offset(bearing_deg, 1.0);
                let Some((enter, leave)) = patch.crossing(from, direction) else {
                    continue;
                };
                crossed += 1;
                assert!(enter < leave);
                for (along, inside) in [
                    (enter - 0.01, false),
                    (enter + 0.01, true),
                    (leave - 0.01, true),
                    (leave + 0.01, false),
                ] {
                    // A line that only grazes the patch is inside for less than the two centimetres between these.
                    if leave - enter > 0.1 {
                        assert_eq!(patch.contains(from + direction * along), inside);
                    }
                }
            }
        }
        assert!(crossed > 10, "{crossed}");
        assert_eq!(
            one.patches()[40].crossing(EastNorth::new(0.0, 31.0), EastNorth::new(1.0, 0.0)),
            None
        );
        assert_eq!(
            one.patches()[40].crossing(EastNorth::default(), EastNorth::default()),
            None
        );
    }

    #[test]
    fn ranges_are_checked_by_their_key() {
        let message = |from: &str, to: &str| bottom(&TEXT.replace(from, to), 1).unwrap_err().to_string();
        assert_eq!(
            message("count = 40", "count = 1000"),
            "seabed.patches.count is 1001, expected at most 1000 in all"
        );
        assert_eq!(
            message("[50, 200]", "[0, 200]"),
            "seabed.patches.length_m is 0, expected 1 to 20000 m"
        );
        assert_eq!(
            message("= -11", "= 3"),
            "seabed.patches.backscatter_db is 3, expected -60 to 0 dB"
        );
        assert!(toml::from_str::<SeabedConfig>(&TEXT.replace("width_m", "breadth_m")).is_err());
    }
}
