use backseat_sdk::survey::{Line, Rectangle};
use backseat_sdk::units::{EastNorth, LocalFrame, Position};

/// The rectangle to survey, with its longer side as its length. Points are in metres east and north of its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area {
    frame: LocalFrame,
    rectangle: Rectangle,
}

impl Area {
    /// A rectangle around a centre, with a width (east) and a height (north) before it is turned clockwise by
    /// `orientation_deg`.
    #[must_use]
    pub fn new(centre: Position, size: EastNorth, orientation_deg: f64) -> Self {
        let (length_m, width_m, bearing_deg) = if size.east_m >= size.north_m {
            (size.east_m, size.north_m, orientation_deg + 90.0)
        } else {
            (size.north_m, size.east_m, orientation_deg)
        };
        Self {
            frame: LocalFrame::new(centre),
            rectangle: Rectangle::new(EastNorth::default(), length_m, width_m, bearing_deg),
        }
    }

    /// The local frame around its centre.
    #[must_use]
    pub const fn frame(&self) -> &LocalFrame {
        &self.frame
    }

    /// The rectangle in that frame.
    #[must_use]
    pub const fn rectangle(&self) -> &Rectangle {
        &self.rectangle
    }

    /// A lawnmower of at least two lines, so that a cross has something to improve.
    #[must_use]
    pub fn lawnmower(&self, spacing_m: f64, from: EastNorth) -> Vec<Line> {
        let half_m = self.rectangle.width_m() / 2.0;
        self.rectangle.lawnmower(spacing_m.min(half_m), from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn its_length_is_its_longer_side() {
        let centre = Position::from_deg(42.0, -70.0).unwrap();
        for (east_m, north_m, end) in [
            (600.0, 500.0, EastNorth::new(300.0, 0.0)),
            (500.0, 600.0, EastNorth::new(0.0, 300.0)),
        ] {
            let area = Area::new(centre, EastNorth::new(east_m, north_m), 0.0);
            let rectangle = area.rectangle();
            assert_eq!((rectangle.length_m(), rectangle.width_m()), (600.0, 500.0));
            assert!(rectangle.point(300.0, 0.0).distance_m(end) < 1e-9);
            assert_eq!(area.lawnmower(1000.0, EastNorth::default()).len(), 2);
            assert_eq!(area.lawnmower(100.0, EastNorth::default()).len(), 5);
        }
    }
}
