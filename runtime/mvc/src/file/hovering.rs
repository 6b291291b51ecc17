use backseat_units::{EastNorth, LocalFrame};
use serde::Deserialize;

use super::{StartConfig, VehicleConfig};
use crate::error::{MvcError, check};
use crate::vehicle::ship::Ship;

/// The `[hovering]` section: what only a vehicle of the class `hovering` has, and the ship that it inspects.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct HoveringConfig {
    /// The ship. Without one, the vehicle sends no BFRNV, and every BPGHP fails.
    pub hull: Option<ShipConfig>,
    /// The least distance from the ship that the vehicle keeps, whatever is asked, metres, 0.1 to 10.
    pub safety_m: f64,
    /// The vehicle's speed limit at the start, until BPSPD changes it, metres a second, 0.05 to 5. SPI gives 1.5 (8.4).
    pub speed_limit_mps: f64,
    /// How many BFRNV and BFCNV the vehicle sends in a second, 0.1 to 100, at most one of each in a step. SPI gives no
    /// figure.
    pub relative_hz: f64,
    /// How many BFPIT the vehicle sends in a second, 0.1 to 100, at most one in a step. SPI gives no figure.
    pub servo_hz: f64,
    /// How far the relative position drifts: the standard deviation of a random walk after an hour, in each direction,
    /// metres.
    pub drift_m_per_sqrt_h: f64,
    /// How far the inertial bearing drifts: the standard deviation of a random walk after an hour, degrees.
    pub bearing_drift_deg_per_sqrt_h: f64,
    /// The noise of one relative position, in each direction, metres.
    pub position_noise_m: f64,
    /// The noise of one measured distance from the ship, metres.
    pub range_noise_m: f64,
    /// The greatest distance from the ship that is measured, metres, 1 to 100. Beyond it, the vehicle computes the
    /// distance from its own motion.
    pub range_max_m: f64,
    /// The least angle to which the sonar turns, degrees, -180 to the greatest angle.
    pub sonar_min_deg: f64,
    /// The greatest angle to which the sonar turns, degrees, -180 to 180.
    pub sonar_max_deg: f64,
    /// How fast the sonar and the DVL turn, degrees a second, 0.1 to 360.
    pub servo_rate_dps: f64,
    /// Whether the vehicle has a camera that pans, tilts and zooms (SPI 8.10).
    pub camera: bool,
    /// Whether the vehicle has a strobe light (SPI 8.11).
    pub light: bool,
}

/// The `[hovering.hull]` section: a ship at rest, a box that reaches from its draft up through the surface.
///
/// Positions on the hull count from the middle of the inspected side, at the waterline.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShipConfig {
    /// Where the middle of the ship is, metres east of the origin.
    pub east_m: f64,
    /// Where the middle of the ship is, metres north of the origin.
    pub north_m: f64,
    /// Where the bow points to, degrees from true north.
    pub heading_deg: f64,
    /// Length, metres, 1 to 500.
    pub length_m: f64,
    /// Beam, metres, 1 to 100.
    pub beam_m: f64,
    /// Draft, metres, 0.5 to 40.
    pub draft_m: f64,
    /// Which side is inspected.
    #[serde(default)]
    pub side: ShipSide,
}

/// A side of a ship.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ShipSide {
    /// Right, looking towards the bow.
    #[default]
    Starboard,
    /// Left, looking towards the bow.
    Port,
}

impl Default for HoveringConfig {
    fn default() -> Self {
        Self {
            hull: None,
            safety_m: 0.5,
            speed_limit_mps: 1.5,
            relative_hz: 5.0,
            servo_hz: 5.0,
            drift_m_per_sqrt_h: 1.0,
            bearing_drift_deg_per_sqrt_h: 1.0,
            position_noise_m: 0.01,
            range_noise_m: 0.02,
            range_max_m: 20.0,
            sonar_min_deg: -90.0,
            sonar_max_deg: 90.0,
            servo_rate_dps: 30.0,
            camera: true,
            light: true,
        }
    }
}

impl HoveringConfig {
    pub(crate) fn validate(
        &self,
        vehicle: &VehicleConfig,
        start: &StartConfig,
        frame: &LocalFrame,
    ) -> Result<(), MvcError> {
        for (key, value, least, most, expected) in [
            ("hovering.safety_m", self.safety_m, 0.1, 10.0, "0.1 to 10 m"),
            (
                "hovering.speed_limit_mps",
                self.speed_limit_mps,
                0.05,
                5.0,
                "0.05 to 5 m/s",
            ),
            ("hovering.relative_hz", self.relative_hz, 0.1, 100.0, "0.1 to 100"),
            ("hovering.servo_hz", self.servo_hz, 0.1, 100.0, "0.1 to 100"),
            (
                "hovering.drift_m_per_sqrt_h",
                self.drift_m_per_sqrt_h,
                0.0,
                1000.0,
                "0 to 1000",
            ),
            (
                "hovering.bearing_drift_deg_per_sqrt_h",
                self.bearing_drift_deg_per_sqrt_h,
                0.0,
                90.0,
                "0 to 90",
            ),
            ("hovering.position_noise_m", self.position_noise_m, 0.0, 10.0, "0 to 10"),
            ("hovering.range_noise_m", self.range_noise_m, 0.0, 10.0, "0 to 10"),
            ("hovering.range_max_m", self.range_max_m, 1.0, 100.0, "1 to 100 m"),
            (
                "hovering.sonar_max_deg",
                self.sonar_max_deg,
                -180.0,
                180.0,
                "-180 to 180",
            ),
            (
                "hovering.sonar_min_deg",
                self.sonar_min_deg,
                -180.0,
                self.sonar_max_deg,
                "-180 to sonar_max_deg",
            ),
            ("hovering.servo_rate_dps", self.servo_rate_dps, 0.1, 360.0, "0.1 to 360"),
        ] {
            check((least..=most).contains(&value), key, value, expected)?;
        }
        let Some(hull) = &self.hull else { return Ok(()) };
        if !vehicle.performance().hovers {
            return Err(MvcError::Value {
                key: "vehicle.class",
                value: format!("\"{}\"", vehicle.class.name()),
                expected: "\"hovering\" with a [hovering.hull]",
            });
        }
        for (key, value, least, most, expected) in [
            (
                "hovering.hull.east_m",
                hull.east_m,
                -50_000.0,
                50_000.0,
                "within 50 km of the origin",
            ),
            (
                "hovering.hull.north_m",
                hull.north_m,
                -50_000.0,
                50_000.0,
                "within 50 km of the origin",
            ),
            (
                "hovering.hull.heading_deg",
                hull.heading_deg,
                -360.0,
                360.0,
                "within 360 degrees",
            ),
            ("hovering.hull.length_m", hull.length_m, 1.0, 500.0, "1 to 500 m"),
            ("hovering.hull.beam_m", hull.beam_m, 1.0, 100.0, "1 to 100 m"),
            ("hovering.hull.draft_m", hull.draft_m, 0.5, 40.0, "0.5 to 40 m"),
        ] {
            check((least..=most).contains(&value), key, value, expected)?;
        }
        let at = EastNorth::new(start.east_m, start.north_m);
        let (clearance_m, _) = Ship::new(hull, frame).clearance(at, start.depth_m);
        check(
            clearance_m >= self.safety_m,
            "start: the distance from hovering.hull in metres",
            clearance_m,
            "hovering.safety_m or more",
        )
    }
}
