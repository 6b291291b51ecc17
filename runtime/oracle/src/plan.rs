use crate::plane::{Plane, Point, to_segment_m};

/// The vehicle's own legs, as BFPLN reported them (SPI 6.20), without inserts of ours.
#[derive(Clone, Debug, Default)]
pub(crate) struct Plan {
    points: Vec<Point>,
    asked_anew: bool,
}

impl Plan {
    const POINTS_MAX: usize = 10_000;

    /// We asked for the plan: the next element begins a new series.
    pub(crate) const fn asked(&mut self) {
        self.asked_anew = true;
    }

    /// The vehicle reported an element.
    pub(crate) fn told(&mut self, point: Option<Point>) {
        if core::mem::take(&mut self.asked_anew) {
            self.points.clear();
        }
        if let Some(point) = point
            && self.points.len() < Self::POINTS_MAX
        {
            self.points.push(point);
        }
    }

    /// Whether a planned leg passes within a distance of a point.
    pub(crate) fn passes(&self, point: Point, distance_m: f64) -> bool {
        let plane = Plane::at(point);
        self.points
            .array_windows::<2>()
            .any(|leg| to_segment_m([0.0, 0.0], leg.map(|end| plane.vector(end))) <= distance_m)
    }
}
