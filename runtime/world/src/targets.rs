//! Objects on the seabed, for simulated sonars.

use backseat_units::EastNorth;
use backseat_units::math::wrap_360;
use serde::Deserialize;

use crate::error::{WorldError, check};
use crate::span::Span;
use crate::stream::Stream;

/// The most targets that a world can have.
const TARGETS_MAX: u64 = 20_000;

/// The kind of a target, for a simulated sonar.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TargetKind {
    /// A point: it scatters sound and casts no shadow.
    Point,
    /// A rock: an ellipsoid half sunk into the bed.
    #[default]
    Rock,
    /// A cylinder that lies along its heading: a pipe, a drum, a mine.
    Cylinder,
    /// A box along its heading: a container, a block.
    Box,
    /// A wreck: a rough hull along its heading.
    Wreck,
}

/// One `[[targets]]`: one object on the seabed, or `count` objects that the seed scatters over the box of `east_m` and
/// `north_m`, each with its own draws.
///
/// ```
/// # #[derive(serde::Deserialize)] struct File { targets: Vec<backseat_world::TargetConfig> }
/// let file: File = toml::from_str(r#"
/// [[targets]]
/// kind = "wreck"
/// east_m = [-200, 200]
/// north_m = 150
/// length_m = 40
/// width_m = 8
/// height_m = 5
/// heading_deg = [0, 360]
/// strength_db = 10
///
/// [[targets]]
/// count = 300
/// kind = "rock"
/// east_m = [-1000, 1000]
/// north_m = [-1000, 1000]
/// length_m = [0.3, 2.0]
/// heading_deg = [0, 360]
/// "#)?;
/// assert_eq!((file.targets[0].count, file.targets[1].count), (1, 300));
/// # Ok::<(), toml::de::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TargetConfig {
    /// Number of such targets; 1 unless given. All entries together may have at most 20000.
    #[serde(default = "single")]
    pub count: u32,
    /// Its kind; a rock unless given.
    #[serde(default)]
    pub kind: TargetKind,
    /// Position of its middle, metres east of the origin.
    pub east_m: Span,
    /// Position of its middle, metres north of the origin.
    pub north_m: Span,
    /// Its length, along its heading, metres, 0.01 to 1000; 1 unless given.
    #[serde(default = "one")]
    pub length_m: Span,
    /// Its width, metres, 0.01 to 1000; 1 unless given.
    #[serde(default = "one")]
    pub width_m: Span,
    /// Its height over the bed, metres, 0 to 100; 0.5 unless given.
    #[serde(default = "half")]
    pub height_m: Span,
    /// Its heading, degrees clockwise from the frame's north; 0 unless given.
    #[serde(default = "zero")]
    pub heading_deg: Span,
    /// Its target strength, decibels relative to 1 m² at 1 m, -80 to 40; -20 unless given.
    #[serde(default = "strength")]
    pub strength_db: Span,
}

/// An object on the seabed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Its kind.
    pub kind: TargetKind,
    /// Its middle, in the world's frame.
    pub at: EastNorth,
    /// Its length along its heading, metres.
    pub length_m: f64,
    /// Its width across its heading, metres.
    pub width_m: f64,
    /// Its height over the bed, metres.
    pub height_m: f64,
    /// Its heading, degrees clockwise from the frame's north, in [0, 360).
    pub heading_deg: f64,
    /// Target strength, decibels relative to 1 m² at 1 m.
    pub strength_db: f64,
}

const fn single() -> u32 {
    1
}

const fn zero() -> Span {
    Span::fixed(0.0)
}

const fn half() -> Span {
    Span::fixed(0.5)
}

const fn one() -> Span {
    Span::fixed(1.0)
}

const fn strength() -> Span {
    Span::fixed(-20.0)
}

/// The targets of a world, sorted from west to east.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Targets(Vec<Target>);

impl Targets {
    /// Draws the targets from their own stream.
    pub(crate) fn new(configs: &[TargetConfig], seed: u64) -> Result<Self, WorldError> {
        let count: u64 = configs.iter().map(|config| u64::from(config.count)).sum();
        check(
            count <= TARGETS_MAX,
            "targets.count",
            count as f64,
            "at most 20000 in all",
        )?;
        let mut stream = Stream::new(seed, "targets");
        let mut targets = Vec::with_capacity(count as usize);
        for config in configs {
            config.validate()?;
            targets.extend((0..config.count).map(|_| config.draw(&mut stream)));
        }
        targets.sort_by(|one, other| one.at.east_m.total_cmp(&other.at.east_m));
        Ok(Self(targets))
    }

    pub(crate) fn all(&self) -> &[Target] {
        &self.0
    }

    pub(crate) fn near(&self, at: EastNorth, radius_m: f64) -> impl Iterator<Item = &Target> {
        let first = self.0.partition_point(|target| target.at.east_m < at.east_m - radius_m);
        let from_west = self.0.get(first..).unwrap_or_default().iter();
        from_west
            .take_while(move |target| target.at.east_m <= at.east_m + radius_m)
            .filter(move |target| target.at.distance_m(at) <= radius_m)
    }
}

impl TargetConfig {
    fn validate(&self) -> Result<(), WorldError> {
        let near = "within 50 km of the origin";
        self.east_m.within(-50_000.0, 50_000.0, "targets.east_m", near)?;
        self.north_m.within(-50_000.0, 50_000.0, "targets.north_m", near)?;
        self.length_m
            .within(0.01, 1000.0, "targets.length_m", "0.01 to 1000 m")?;
        self.width_m.within(0.01, 1000.0, "targets.width_m", "0.01 to 1000 m")?;
        self.height_m.within(0.0, 100.0, "targets.height_m", "0 to 100 m")?;
        self.heading_deg
            .within(-360.0, 720.0, "targets.heading_deg", "-360 to 720 degrees")?;
        self.strength_db
            .within(-80.0, 40.0, "targets.strength_db", "-80 to 40 dB")
    }

    fn draw(&self, stream: &mut Stream) -> Target {
        Target {
            kind: self.kind,
            at: EastNorth::new(self.east_m.draw(stream), self.north_m.draw(stream)),
            length_m: self.length_m.draw(stream),
            width_m: self.width_m.draw(stream),
            height_m: self.height_m.draw(stream),
            heading_deg: wrap_360(self.heading_deg.draw(stream)),
            strength_db: self.strength_db.draw(stream),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn targets(text: &str, seed: u64) -> Result<Targets, WorldError> {
        #[derive(Deserialize)]
        struct File {
            targets: Vec<TargetConfig>,
        }
        Targets::new(&toml::from_str::<File>(text).unwrap().targets, seed)
    }

    const TEXT: &str = "
        [[targets]]
        kind = \"cylinder\"
        east_m = 30
        north_m = -40
        heading_deg = -90
        [[targets]]
        count = 500
        east_m = [-100, 100]
        north_m = [-200, 200]
        length_m = [0.5, 3]
    ";

    #[test]
    fn the_seed_scatters_targets_within_their_box() {
        let strewn = targets(TEXT, 3).unwrap();
        assert_eq!(strewn, targets(TEXT, 3).unwrap());
        assert_ne!(strewn, targets(TEXT, 4).unwrap());
        assert_eq!(strewn.all().len(), 501);
        let cylinder = strewn
            .all()
            .iter()
            .find(|target| target.kind == TargetKind::Cylinder)
            .unwrap();
        assert_eq!(
            (cylinder.at, cylinder.heading_deg),
            (EastNorth::new(30.0, -40.0), 270.0)
        );
        assert!(
            strewn
                .all()
                .iter()
                .all(|target| target.at.east_m.abs() <= 100.0 && target.at.north_m.abs() <= 200.0)
        );
        assert!((0.5..=3.0).contains(&strewn.all()[17].length_m) || strewn.all()[17].kind == TargetKind::Cylinder);
        let north = strewn.all().iter().filter(|target| target.at.north_m > 0.0).count();
        assert!((200..300).contains(&north));
    }

    #[test]
    fn targets_near_a_place_are_complete() {
        let strewn = targets(TEXT, 9).unwrap();
        for (east, north, radius_m) in [
            (0.0, 0.0, 30.0),
            (-100.0, 50.0, 60.0),
            (30.0, -40.0, 0.0),
            (500.0, 0.0, 10.0),
        ] {
            let at = EastNorth::new(east, north);
            let near: Vec<&Target> = strewn.near(at, radius_m).collect();
            let scanned: Vec<&Target> = strewn
                .all()
                .iter()
                .filter(|target| target.at.distance_m(at) <= radius_m)
                .collect();
            assert_eq!(near, scanned);
        }
        assert_eq!(strewn.near(EastNorth::new(30.0, -40.0), 0.0).count(), 1);
        assert_eq!(strewn.near(EastNorth::default(), f64::NAN).count(), 0);
    }

    #[test]
    fn ranges_are_checked_by_their_key() {
        let message = |from: &str, to: &str| targets(&TEXT.replace(from, to), 1).unwrap_err().to_string();
        assert_eq!(
            message("count = 500", "count = 20000"),
            "targets.count is 20001, expected at most 20000 in all"
        );
        assert_eq!(
            message("[0.5, 3]", "[0, 3]"),
            "targets.length_m is 0, expected 0.01 to 1000 m"
        );
    }
}
