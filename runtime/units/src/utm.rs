use crate::math::{atan, sin, tan, wrap_180};
use crate::position::Position;

/// Angle from true north to the grid north of the position's UTM zone, degrees, positive clockwise.
///
/// BFNVG's heading counts from grid north, so this angle is already subtracted from it (SPI 6.1). At 42 N and 3 degrees
/// off the central meridian it is 2 degrees. The zones are those of the UTM grid, with the wider ones of Norway and
/// Svalbard. Source: Snyder (1987), pages 51 and 57 to 63.
#[must_use]
pub fn utm_convergence_deg(position: Position) -> f64 {
    let longitude = wrap_180(position.longitude.as_deg() - central_meridian_deg(position)).to_radians();
    atan(tan(longitude) * sin(position.latitude.as_deg().to_radians())).to_degrees()
}

fn central_meridian_deg(position: Position) -> f64 {
    let latitude = position.latitude.as_deg();
    let longitude = position.longitude.as_deg();
    if (56.0..64.0).contains(&latitude) && (3.0..12.0).contains(&longitude) {
        return 9.0;
    }
    if (72.0..84.0).contains(&latitude) && (0.0..42.0).contains(&longitude) {
        return match longitude {
            l if l < 9.0 => 3.0,
            l if l < 21.0 => 15.0,
            l if l < 33.0 => 27.0,
            _ => 39.0,
        };
    }
    let zone = ((longitude + 180.0) / 6.0).floor().min(59.0);
    zone * 6.0 - 177.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::LocalFrame;

    /// The convergence of [`LocalFrame`] has the same formula, with another meridian.
    fn by_frame(position: Position, meridian_deg: f64) -> f64 {
        let origin = Position::from_deg(position.latitude.as_deg(), meridian_deg).unwrap();
        LocalFrame::new(origin).convergence_deg(position)
    }

    #[test]
    fn convergence_is_two_degrees_at_42_north_and_three_off_the_central_meridian() {
        let position = Position::from_deg(42.0, -66.0 - 1e-9).unwrap();
        assert!((utm_convergence_deg(position) - 2.008).abs() < 0.001);
        assert!((utm_convergence_deg(position) - by_frame(position, -69.0)).abs() < 1e-6);
    }

    #[test]
    fn zones_of_norway_and_the_last_one() {
        assert_eq!(central_meridian_deg(Position::from_deg(60.0, 5.0).unwrap()), 9.0);
        assert_eq!(central_meridian_deg(Position::from_deg(78.0, 15.0).unwrap()), 15.0);
        assert_eq!(central_meridian_deg(Position::from_deg(0.0, 180.0).unwrap()), 177.0);
    }
}
