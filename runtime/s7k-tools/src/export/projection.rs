//! From positions to the coordinates of a map.

use backseat_units::math::{sin, sin_cos};
use backseat_units::{LocalFrame, Position};
use nalgebra::{Matrix2, Vector2};

/// The coordinates of a mosaic.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Crs {
    /// Metres of the UTM zone of the first position, on WGS84.
    #[default]
    Utm,
    /// Degrees of longitude and latitude, WGS84.
    Wgs84,
}

/// A projection for one survey.
#[derive(Clone, Copy, Debug)]
pub(super) enum Projection {
    Utm { zone: u16, south: bool, frame: LocalFrame },
    Wgs84,
}

/// Scale on the central meridian of a UTM zone, and its false origin (Snyder, page 57).
const SCALE: f64 = 0.9996;
const FALSE_EASTING_M: f64 = 500_000.0;
const FALSE_NORTHING_M: f64 = 10_000_000.0;
/// WGS84: semi-major axis, and first eccentricity squared (NIMA TR8350.2, table 3.1).
const SEMI_MAJOR_AXIS_M: f64 = 6_378_137.0;
const E2: f64 = 0.006_694_379_990_141_316;

impl Projection {
    /// The projection for a survey that begins here. UTM's zones are those of six degrees, without the exceptions of
    /// Norway and Svalbard.
    pub(super) fn new(crs: Crs, first: Position) -> Self {
        match crs {
            Crs::Wgs84 => Self::Wgs84,
            Crs::Utm => {
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 59")]
                let index = ((first.longitude.as_deg() + 180.0) / 6.0).floor().clamp(0.0, 59.0) as u16;
                let meridian = f64::from(index) * 6.0 - 177.0;
                // A meridian is within its range.
                let origin = Position::from_deg(0.0, meridian).unwrap_or(first);
                Self::Utm {
                    zone: index + 1,
                    south: first.latitude.as_deg() < 0.0,
                    frame: LocalFrame::new(origin),
                }
            }
        }
    }

    /// The map's coordinates of a position: east, north.
    pub(super) fn project(&self, position: Position) -> Vector2<f64> {
        match self {
            Self::Wgs84 => Vector2::new(position.longitude.as_deg(), position.latitude.as_deg()),
            Self::Utm { south, frame, .. } => {
                let point = frame.to_local(position);
                let north = if *south { FALSE_NORTHING_M } else { 0.0 };
                Vector2::new(point.east_m * SCALE + FALSE_EASTING_M, point.north_m * SCALE + north)
            }
        }
    }

    /// What a step of a metre to the true east and north around a position is on the map.
    pub(super) fn per_metre(&self, position: Position) -> Matrix2<f64> {
        let latitude = position.latitude.as_deg().to_radians();
        match self {
            Self::Wgs84 => {
                let (sin, cos) = sin_cos(latitude);
                let w = 1.0 - E2 * sin * sin;
                let across = SEMI_MAJOR_AXIS_M / w.sqrt();
                let along = across * (1.0 - E2) / w;
                let degrees = Vector2::new((1.0 / (across * cos)).to_degrees(), (1.0 / along).to_degrees());
                Matrix2::from_diagonal(&degrees)
            }
            Self::Utm { frame, .. } => {
                let (sin_c, cos_c) = sin_cos(frame.convergence_deg(position).to_radians());
                let x = frame.to_local(position).east_m;
                let radius = SEMI_MAJOR_AXIS_M * (1.0 - E2).sqrt() / (1.0 - E2 * sin(latitude) * sin(latitude));
                let scale = SCALE * (1.0 + x * x / (2.0 * radius * radius));
                // True north lies counter-clockwise of grid north by the convergence.
                Matrix2::new(cos_c, -sin_c, sin_c, cos_c) * scale
            }
        }
    }

    /// The number of the coordinate system in the EPSG register.
    pub(super) const fn epsg(&self) -> u16 {
        match self {
            Self::Wgs84 => 4326,
            Self::Utm { zone, south: false, .. } => 32_600 + *zone,
            Self::Utm { zone, south: true, .. } => 32_700 + *zone,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn position(latitude: f64, longitude: f64) -> Position {
        Position::from_deg(latitude, longitude).unwrap()
    }

    #[test]
    fn utm_agrees_with_proj() {
        // 40 30 N, 73 30 W in zone 18, and 40 30 S, 73 30 E in zone 43, as PROJ 9.7 computes them.
        let north = position(40.5, -73.5);
        let projection = Projection::new(Crs::Utm, north);
        assert_eq!(projection.epsg(), 32_618);
        let expected = Vector2::new(627_103.087_3, 4_484_335.401_7);
        assert!((projection.project(north) - expected).norm() < 1e-3);
        let south = position(-40.5, 73.5);
        let projection = Projection::new(Crs::Utm, south);
        assert_eq!(projection.epsg(), 32_743);
        let expected = Vector2::new(372_896.912_7, 10e6 - 4_484_335.401_7);
        assert!(
            (projection.project(south) - expected).norm() < 1e-3,
            "{}",
            projection.project(south)
        );
    }

    #[test]
    fn a_metre_on_the_map_is_the_step_between_two_positions() {
        for crs in [Crs::Utm, Crs::Wgs84] {
            for (latitude, longitude) in [(42.3, -70.9), (-33.0, 151.9), (60.1, 5.2)] {
                let here = position(latitude, longitude);
                let projection = Projection::new(crs, here);
                let frame = LocalFrame::new(here);
                for (east, north) in [(100.0, 0.0), (0.0, 100.0), (-70.0, 30.0)] {
                    let there = frame.to_position(backseat_units::EastNorth::new(east, north));
                    let step = projection.project(there) - projection.project(here);
                    let by_matrix = projection.per_metre(here) * Vector2::new(east, north);
                    let error = (step - by_matrix).norm() / step.norm();
                    assert!(error < 2e-5, "{crs:?} {latitude} {east} {north}: {error}");
                }
            }
        }
    }
}
