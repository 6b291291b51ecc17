use crate::area::{Area, Surroundings};
use crate::plane::{Plane, Point, length_m};

/// The surroundings of a place that moves. They are surveyed again only if the place may have crossed an edge since.
#[derive(Clone, Debug, Default)]
pub(crate) struct Survey {
    surroundings: Surroundings,
    /// Where the surroundings were surveyed last.
    surveyed: Option<(Point, Plane)>,
    /// The least distance from the newest place to the nearest edge, metres.
    spare_m: f64,
}

impl Survey {
    pub(crate) fn surroundings(&self) -> &Surroundings {
        &self.surroundings
    }

    /// The least distance from the newest place to the nearest edge of any zone, metres.
    pub(crate) const fn spare_m(&self) -> f64 {
        self.spare_m
    }

    /// Moves to a place.
    pub(crate) fn at(&mut self, point: Point, area: &Area) {
        if let Some((_, plane)) = self.surveyed {
            // A metre and a part of the way allow for the error of the plane.
            let moved_m = length_m(plane.vector(point));
            let used_m = moved_m * 1.01 + 1.0;
            if moved_m < 10_000.0 && used_m < self.surroundings.edge_m {
                self.spare_m = self.surroundings.edge_m - used_m;
                return;
            }
        }
        self.anew(point, area);
    }

    /// Moves to a place and surveys its surroundings in any case.
    pub(crate) fn anew(&mut self, point: Point, area: &Area) {
        area.survey(point, &mut self.surroundings);
        self.surveyed = Some((point, Plane::at(point)));
        self.spare_m = self.surroundings.edge_m;
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const FENCE: &str = r#"{ "type": "FeatureCollection", "features": [
        { "type": "Feature", "properties": { "name": "a", "kind": "keep-in" },
          "geometry": { "type": "Polygon", "coordinates": [
            [[5.0, 60.0], [5.02, 60.0], [5.03, 60.01], [5.01, 60.005], [5.0, 60.02], [5.0, 60.0]],
            [[5.004, 60.002], [5.006, 60.002], [5.005, 60.004], [5.004, 60.002]]] } },
        { "type": "Feature", "properties": { "name": "b", "kind": "keep-out" },
          "geometry": { "type": "Polygon", "coordinates": [
            [[5.008, 60.002], [5.012, 60.003], [5.01, 60.0], [5.008, 60.002]] ] } } ] }"#;

    proptest! {
        /// Remembered surroundings are those that a survey on the spot would find.
        #[test]
        fn a_remembered_survey_stays_valid(
            start in (-0.01..0.04f64, -0.01..0.03f64),
            steps in proptest::collection::vec((-1.0..1.0f64, -1.0..1.0f64, 0..4u8), 1..80),
        ) {
            let area = Area::read(FENCE).unwrap();
            let mut survey = Survey::default();
            let mut fresh = Surroundings::default();
            let mut point = Point { x: start.0, y: 60.0 + start.1 };
            for (x, y, size) in steps {
                let step = [1e-6, 1e-5, 1e-4, 1e-3][usize::from(size)];
                point = Point { x: point.x + x * step, y: point.y + y * step };
                survey.at(point, &area);
                area.survey(point, &mut fresh);
                prop_assert_eq!(&survey.surroundings().zones, &fresh.zones, "{:?}", point);
                prop_assert!(survey.spare_m() <= fresh.edge_m + 0.1);
            }
        }
    }
}
