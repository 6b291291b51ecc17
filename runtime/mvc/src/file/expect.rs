use backseat_world::TargetKind;
use serde::Deserialize;

use crate::error::{MvcError, check};

/// The `[expect]` section: what a run must achieve. The mock only carries it and does not judge the run.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Expectations {
    /// How many violations the run may have; `None` allows none.
    pub max_violations: Option<u32>,
    /// How many requests the vehicle must have accepted at least.
    pub min_accepted: Option<u32>,
    /// Whether the mission must have been completed (true) or must not (false); `None` allows both.
    pub mission_completed: Option<bool>,
    /// A depth contour that a plugin must follow.
    pub contour: Option<ContourExpectation>,
    /// A maximum that a plugin must find.
    pub maximum: Option<MaximumExpectation>,
    /// An area that a sidescan must see.
    pub coverage: Option<CoverageExpectation>,
    /// Targets on the seabed that a plugin must find.
    pub contacts: Option<ContactsExpectation>,
    /// Bounds of measures.
    pub measure: Vec<MeasureExpectation>,
}

/// One `[[expect.measure]]` table: bounds of a measure of the run's report.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeasureExpectation {
    /// `PLUGIN.NAME` of what a plugin published, or what another expectation measured.
    pub name: String,
    /// The least value, in the measure's own unit.
    pub at_least: Option<f64>,
    /// The greatest value.
    pub at_most: Option<f64>,
}

impl MeasureExpectation {
    /// Checks that the bounds are finite and leave room.
    pub(super) fn check(&self) -> Result<(), MvcError> {
        let (least, most) = (self.at_least, self.at_most);
        for (key, bound) in [("expect.measure.at_least", least), ("expect.measure.at_most", most)] {
            let bound = bound.unwrap_or(0.0);
            check(bound.is_finite(), key, bound, "a finite number")?;
        }
        let room = least.unwrap_or(f64::NEG_INFINITY) <= most.unwrap_or(f64::INFINITY);
        check(room, "expect.measure.at_most", most.unwrap_or(0.0), "at_least or more")
    }
}

/// The `[expect.contour]` section: how near the vehicle's true track is to the true contour, horizontally, while a
/// plugin modifies what the vehicle flies.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContourExpectation {
    /// The depth of the water along the contour, metres.
    pub water_depth_m: f64,
    /// Once the distance is less than this, the contour counts as acquired, metres.
    pub acquired_m: f64,
    /// How long that may take, counted from the first modify, seconds.
    pub acquired_within_s: f64,
    /// The greatest root mean square of the distance from then on, metres.
    pub rms_m: f64,
    /// How long the vehicle must follow the contour in all, seconds.
    pub followed_for_s: f64,
}

/// The `[expect.maximum]` section: how near the centre of the last trackcircle is to the field's true maximum.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaximumExpectation {
    /// The greatest distance, metres.
    pub within_m: f64,
}

/// The `[expect.coverage]` section: which part of a rectangle a sidescan has truly seen, and by how long a way.
///
/// A place was seen if it was abeam of the vehicle's true track at a ping, within the sonar's range along the slant, and
/// outside the gap below the vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CoverageExpectation {
    /// The sonar.
    #[serde(default)]
    pub sensor: SidescanName,
    /// The rectangle's centre, metres east of the origin.
    pub east_m: f64,
    /// The rectangle's centre, metres north of the origin.
    pub north_m: f64,
    /// The rectangle's length along `bearing_deg`, metres.
    pub length_m: f64,
    /// The rectangle's width across it, metres.
    pub width_m: f64,
    /// The direction of the length, degrees clockwise from the frame's north.
    #[serde(default)]
    pub bearing_deg: f64,
    /// The side of the square cells whose middles are judged, metres.
    #[serde(default = "default_cell_m")]
    pub cell_m: f64,
    /// Half of the angle straight below the vehicle in which nothing counts as seen, degrees.
    #[serde(default = "default_nadir_deg")]
    pub nadir_deg: f64,
    /// While the vehicle turns faster than this, nothing counts as seen, degrees a second.
    #[serde(default = "default_turn_max_dps")]
    pub turn_max_dps: f64,
    /// How much of the rectangle must be seen at least, percent.
    #[serde(default)]
    pub seen_min_percent: f64,
    /// The longest way from the first to the last moment in the rectangle, metres.
    pub way_max_m: Option<f64>,
    /// How much of the rectangle must be seen at least for each kilometre of this way, percent.
    pub per_km_min_percent: Option<f64>,
}

/// The `[expect.contacts]` section: around which targets trackcircles were sent, and around what else.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContactsExpectation {
    /// The kinds of targets that count.
    pub kinds: TargetKinds,
    /// Only targets at least this high count, metres.
    #[serde(default)]
    pub height_min_m: f64,
    /// A trackcircle belongs to a target if its centre is this near to the target's middle, metres.
    pub within_m: f64,
    /// The least part of the targets that must have a trackcircle, 0 to 1.
    #[serde(default)]
    pub found_min: f64,
    /// The most trackcircles without such a target.
    pub false_max: Option<u32>,
    /// From how many of eight sectors half of the targets must have been seen at least, by the true track.
    pub aspects_min: Option<f64>,
}

/// A set of kinds of targets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(from = "Vec<TargetKind>")]
pub struct TargetKinds(u8);

impl TargetKinds {
    /// Whether the set has a kind.
    #[must_use]
    pub const fn contains(self, kind: TargetKind) -> bool {
        self.0 & (1 << kind as u8) != 0
    }
}

impl From<Vec<TargetKind>> for TargetKinds {
    fn from(kinds: Vec<TargetKind>) -> Self {
        Self(kinds.into_iter().fold(0, |set, kind| set | 1 << kind as u8))
    }
}

impl ContactsExpectation {
    /// Checks the ranges of all values.
    pub(super) fn check(&self) -> Result<(), MvcError> {
        let kinds = f64::from(self.kinds.0.count_ones());
        check(kinds >= 1.0, "expect.contacts.kinds", kinds, "at least one kind")?;
        for (key, value, least, most, expected) in [
            (
                "expect.contacts.height_min_m",
                self.height_min_m,
                0.0,
                100.0,
                "0 to 100 m",
            ),
            ("expect.contacts.within_m", self.within_m, 0.1, 1000.0, "0.1 to 1000 m"),
            ("expect.contacts.found_min", self.found_min, 0.0, 1.0, "0 to 1"),
            (
                "expect.contacts.aspects_min",
                self.aspects_min.unwrap_or(0.0),
                0.0,
                8.0,
                "0 to 8",
            ),
        ] {
            check((least..=most).contains(&value), key, value, expected)?;
        }
        Ok(())
    }
}

/// A sidescan of the mock payload controller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SidescanName {
    /// The low frequency.
    SidescanLow,
    /// The high frequency.
    #[default]
    SidescanHigh,
}

const fn default_cell_m() -> f64 {
    4.0
}

/// The lower edge of a beam that is 55 degrees wide and points 30 degrees down.
const fn default_nadir_deg() -> f64 {
    32.5
}

const fn default_turn_max_dps() -> f64 {
    1.5
}

impl CoverageExpectation {
    /// Checks the ranges of all values.
    pub(super) fn check(&self) -> Result<(), MvcError> {
        let far = "within 50000 m";
        for (key, value, least, most, expected) in [
            ("expect.coverage.east_m", self.east_m, -50_000.0, 50_000.0, far),
            ("expect.coverage.north_m", self.north_m, -50_000.0, 50_000.0, far),
            (
                "expect.coverage.length_m",
                self.length_m,
                10.0,
                20_000.0,
                "10 to 20000 m",
            ),
            ("expect.coverage.width_m", self.width_m, 10.0, 20_000.0, "10 to 20000 m"),
            (
                "expect.coverage.bearing_deg",
                self.bearing_deg,
                -360.0,
                360.0,
                "-360 to 360 degrees",
            ),
            ("expect.coverage.cell_m", self.cell_m, 1.0, 100.0, "1 to 100 m"),
            (
                "expect.coverage.nadir_deg",
                self.nadir_deg,
                0.0,
                80.0,
                "0 to 80 degrees",
            ),
            (
                "expect.coverage.turn_max_dps",
                self.turn_max_dps,
                0.01,
                90.0,
                "0.01 to 90 degrees a second",
            ),
            (
                "expect.coverage.seen_min_percent",
                self.seen_min_percent,
                0.0,
                100.0,
                "0 to 100 percent",
            ),
            (
                "expect.coverage.way_max_m",
                self.way_max_m.unwrap_or(1.0),
                1.0,
                1e6,
                "1 to 1000000 m",
            ),
            (
                "expect.coverage.per_km_min_percent",
                self.per_km_min_percent.unwrap_or(0.0),
                0.0,
                100.0,
                "0 to 100 percent",
            ),
        ] {
            check((least..=most).contains(&value), key, value, expected)?;
        }
        let cells = (self.length_m / self.cell_m).ceil() * (self.width_m / self.cell_m).ceil();
        check(
            cells <= 1e6,
            "expect.coverage.cell_m",
            self.cell_m,
            "at most a million cells in the rectangle",
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_contacts_expectation_names_kinds_and_has_ranges() {
        let read = |more: &str| {
            let text = format!("[contacts]\nwithin_m = 8\n{more}");
            toml::from_str::<Expectations>(&text).map(|expect| expect.contacts.unwrap())
        };
        let contacts = read("kinds = [\"box\", \"wreck\"]").unwrap();
        assert!(contacts.kinds.contains(TargetKind::Box) && contacts.kinds.contains(TargetKind::Wreck));
        assert!(!contacts.kinds.contains(TargetKind::Rock) && !contacts.kinds.contains(TargetKind::Point));
        assert!(contacts.check().is_ok());
        let refused = |more: &str| read(more).unwrap().check().unwrap_err().to_string();
        assert_eq!(
            refused("kinds = []"),
            "expect.contacts.kinds is 0, expected at least one kind"
        );
        assert!(refused("kinds = [\"box\"]\nfound_min = 2").starts_with("expect.contacts.found_min is 2"));
        assert!(
            read("kinds = [\"boat\"]")
                .unwrap_err()
                .to_string()
                .contains("unknown variant `boat`")
        );
    }

    #[test]
    fn a_coverage_expectation_has_defaults_and_ranges() {
        let read = |more: &str| {
            let text = format!("[coverage]\neast_m = 0\nnorth_m = 0\nlength_m = 800\nwidth_m = 600\n{more}");
            toml::from_str::<Expectations>(&text).unwrap().coverage.unwrap()
        };
        let coverage = read("");
        assert_eq!((coverage.sensor, coverage.cell_m), (SidescanName::SidescanHigh, 4.0));
        assert!(coverage.check().is_ok());
        let refused = |more: &str| read(more).check().unwrap_err().to_string();
        assert_eq!(
            refused("seen_min_percent = 101"),
            "expect.coverage.seen_min_percent is 101, expected 0 to 100 percent"
        );
        assert!(refused("cell_m = nan").starts_with("expect.coverage.cell_m is NaN"));
        let large = CoverageExpectation {
            length_m: 20_000.0,
            width_m: 2000.0,
            ..coverage
        };
        assert!(
            large
                .check()
                .unwrap_err()
                .to_string()
                .contains("at most a million cells")
        );
    }
}
