//! Conversions between the WIT types and [`crate::units`], and default inputs for unit tests.

use backseat_units as units;

use crate::{Briefing, Budget, Cartesian, Limits, Navigation, PlannedPoint, Position, Relative, StepInput};

impl From<units::Position> for Position {
    fn from(position: units::Position) -> Self {
        Self {
            latitude: position.latitude.as_deg(),
            longitude: position.longitude.as_deg(),
        }
    }
}

impl TryFrom<Position> for units::Position {
    type Error = units::OutOfRange;
    fn try_from(position: Position) -> Result<Self, units::OutOfRange> {
        Self::from_deg(position.latitude, position.longitude)
    }
}

impl Navigation {
    /// The vehicle's position in the mission's local frame.
    #[must_use]
    pub fn local(&self) -> units::EastNorth {
        units::EastNorth::new(self.east, self.north)
    }

    /// Converts a point of the mission's local frame to latitude and longitude.
    ///
    /// The conversion starts from the vehicle's own position, and is accurate to a few centimetres within a kilometre
    /// of it. Near the poles, where the frame is not defined, it returns the vehicle's own position.
    #[must_use]
    pub fn position_of(&self, point: units::EastNorth) -> Position {
        match units::Position::try_from(self.position) {
            Ok(here) => units::LocalFrame::new(here).to_position(point - self.local()).into(),
            Err(_) => self.position,
        }
    }
}

impl Briefing {
    /// The mission's local frame, in which navigation and the fence's zones count metres east and north.
    ///
    /// # Errors
    /// One line, if the origin is no position on the earth.
    pub fn frame(&self) -> Result<units::LocalFrame, String> {
        let origin = units::Position::try_from(self.origin).map_err(|error| format!("origin: {error}"))?;
        Ok(units::LocalFrame::new(origin))
    }
}

impl PlannedPoint {
    /// Its position in the mission's local frame.
    #[must_use]
    pub fn local(&self) -> units::EastNorth {
        units::EastNorth::new(self.east, self.north)
    }
}

/// For unit tests: at rest at the surface at 0 N 0 E, heading north, without bottom lock.
impl Default for Navigation {
    fn default() -> Self {
        Self {
            age_ns: 0,
            position: Position {
                latitude: 0.0,
                longitude: 0.0,
            },
            east: 0.0,
            north: 0.0,
            depth: 0.0,
            altitude: None,
            heading: 0.0,
            roll: 0.0,
            pitch: 0.0,
            velocity_east: 0.0,
            velocity_north: 0.0,
            velocity_down: 0.0,
            yaw_rate: 0.0,
            gps: false,
        }
    }
}

/// For unit tests: at the target, facing it.
impl Default for Relative {
    fn default() -> Self {
        Self {
            age_ns: 0,
            horizontal: 0.0,
            vertical: 0.0,
            distance: 0.0,
            heading: 0.0,
            depth: 0.0,
            absolute_heading: 0.0,
            roll: 0.0,
            pitch: 0.0,
        }
    }
}

/// For unit tests: at the inertial frame's origin, facing the target.
impl Default for Cartesian {
    fn default() -> Self {
        Self {
            age_ns: 0,
            x: 0.0,
            y: 0.0,
            z: 0.0,
            heading: 0.0,
        }
    }
}

/// For unit tests: the start of a run, without navigation, control or events.
impl Default for StepInput {
    fn default() -> Self {
        Self {
            now_ns: 0,
            utc_ns: 0,
            navigation: None,
            relative: None,
            cartesian: None,
            control: false,
            events: Vec::new(),
        }
    }
}

/// For unit tests: no configuration, no grants, no fence around 0 N 0 E, the limits and the budget of a mission that
/// states as little as it may.
impl Default for Briefing {
    fn default() -> Self {
        Self {
            config: "{}".to_owned(),
            grants: Vec::new(),
            origin: Position {
                latitude: 0.0,
                longitude: 0.0,
            },
            zones: Vec::new(),
            limits: Limits::default(),
            budget: Budget::default(),
        }
    }
}

/// For unit tests: speeds from 1 to 2 m/s, turns of 8 degrees a second, a current of up to 0.3 m/s, and the defaults of
/// `mission.toml`.
impl Default for Limits {
    fn default() -> Self {
        Self {
            speed_min: 1.0,
            speed_max: 2.0,
            turn_rate: 8.0,
            current_max: 0.3,
            water_depth_min: None,
            water_depth_max: None,
            seabed_slope_max: 0.15,
            navigation_error: 5.0,
            tracking_error: 5.0,
            vertical_error: 1.0,
            lead_max: 50.0,
            modify_duration_max_ns: 60_000_000_000,
            inserts_open_max: 4,
            inserts_total_max: 100,
            inserts_duration_max_ns: 3_600_000_000_000,
            requests_per_second: 20,
            gps_hits_total_max: 10,
            topside_per_minute: 6,
            packets_per_minute: 12,
        }
    }
}

/// For unit tests: the defaults of `mission.toml`.
impl Default for Budget {
    fn default() -> Self {
        Self {
            fuel_per_step: 10_000_000,
            fuel_init: 1_000_000_000,
            fuel_snapshot: 10_000_000,
            memory: 64 << 20,
            snapshot_every_steps: 10,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_of_the_local_frame_has_a_position() {
        let origin = units::Position::from_deg(42.0, -70.0).unwrap();
        let frame = units::LocalFrame::new(origin);
        let here = units::EastNorth::new(3000.0, -2000.0);
        let navigation = Navigation {
            position: frame.to_position(here).into(),
            east: 3000.0,
            north: -2000.0,
            ..Default::default()
        };
        let there = units::EastNorth::new(3100.0, -1200.0);
        let position = units::Position::try_from(navigation.position_of(there)).unwrap();
        let error_m = frame.to_local(position).distance_m(there);
        assert!(error_m < 0.5, "{error_m} m");
    }
}
