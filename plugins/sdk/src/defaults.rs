//! Conversions between the WIT types and [`crate::units`], and default inputs for unit tests.

use backseat_units as units;

use crate::{Cartesian, Navigation, PlannedPoint, Position, Relative, StepInput};

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
