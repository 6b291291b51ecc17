use backseat_sdk::survey::{Estimate, GaussianProcess, Kernel, Line, Rectangle};
use backseat_sdk::units::EastNorth;
use backseat_sdk::units::math::exp;

/// The most points of the map: the fuel of a fit grows with the cube of their number.
const POINTS_MAX: usize = 260;
/// The least distance between two points of the map, as a part of the field's scale.
const APART: f64 = 0.3;
/// How far apart the places are for which a map is delivered, as a part of the field's scale.
const GRID: f64 = 0.4;
/// The most of these places.
const PLACES_MAX: f64 = 1000.0;

/// What is surveyed, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The area.
    pub area: Rectangle,
    /// How the field varies.
    pub kernel: Kernel,
    /// Places that are warmer than this are of interest, degrees Celsius.
    pub warm_c: f64,
    /// How far the lines of the first search are apart, metres.
    pub search_m: f64,
    /// The length of a planned line, metres.
    pub line_m: f64,
    /// How long the way of the survey may be, metres.
    pub way_m: f64,
    /// If false, a lawnmower of the same way is flown.
    pub adaptive: bool,
}

impl Settings {
    /// An empty Gaussian process for the field.
    ///
    /// # Errors
    /// One line, if the kernel cannot be used.
    pub fn process(&self) -> Result<GaussianProcess, String> {
        GaussianProcess::new(self.kernel, POINTS_MAX, 0.0)
    }

    /// How far the points of the map are apart along the track, metres: so far that the whole way has room.
    #[must_use]
    pub fn apart_m(&self) -> f64 {
        (APART * self.kernel.length_m).max(1.1 * self.way_m / POINTS_MAX as f64)
    }

    /// The places for which the map is delivered: a grid over the area, row by row.
    #[must_use]
    pub fn places(&self) -> Vec<EastNorth> {
        let (length_m, width_m) = (self.area.length_m(), self.area.width_m());
        let mut apart_m = GRID * self.kernel.length_m;
        let count = |apart_m: f64| ((length_m / apart_m).ceil(), (width_m / apart_m).ceil());
        while count(apart_m).0 * count(apart_m).1 > PLACES_MAX {
            apart_m *= 1.05;
        }
        let (rows, columns) = count(apart_m);
        let middle = |index: u32, of: f64| (f64::from(index) + 0.5) / of - 0.5;
        let row = |row: u32| {
            let along_m = middle(row, rows) * length_m;
            (0..columns as u32).map(move |column| self.area.point(along_m, middle(column, columns) * width_m))
        };
        (0..rows as u32).flat_map(row).collect()
    }

    /// The lines that are flown whatever is measured: those of the search, or all lines of a lawnmower whose way comes
    /// nearest to `way_m`.
    #[must_use]
    pub fn first_lines(&self, from: EastNorth) -> Vec<Line> {
        if self.adaptive {
            return self.area.lawnmower(self.search_m, from);
        }
        let way_m = |count: u32| {
            let lines = f64::from(count);
            lines * self.area.length_m() + (lines - 1.0) / lines * self.area.width_m()
        };
        let mut count = 1;
        while count < 1000 && (way_m(count + 1) - self.way_m).abs() < (way_m(count) - self.way_m).abs() {
            count += 1;
        }
        self.area.lawnmower(self.area.width_m() / f64::from(count), from)
    }

    /// How much the variance of a place counts: the probability that it is warmer than `warm_c`, by a logistic curve that
    /// comes within 0.01 of the normal distribution.
    #[must_use]
    pub fn weight(&self, known: &Estimate) -> f64 {
        let above = (known.mean - self.warm_c) / known.deviation.max(self.kernel.noise);
        1.0 / (1.0 + exp(-1.702 * above.clamp(-50.0, 50.0)))
    }

    /// The places of a line that count as measured when it is flown, at most `most` of them.
    #[must_use]
    pub fn along(&self, line: &Line, most: u32) -> Vec<EastNorth> {
        let count = ((line.length_m() / self.apart_m()).round() as u32).clamp(1, most);
        let way = line.end - line.start;
        let points = (0..count).map(|index| line.start + way * ((f64::from(index) + 0.5) / f64::from(count)));
        points.collect()
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn settings() -> Settings {
        Settings {
            area: Rectangle::new(EastNorth::default(), 600.0, 400.0, 90.0),
            kernel: Kernel {
                length_m: 100.0,
                deviation: 0.5,
                noise: 0.02,
            },
            warm_c: 12.5,
            search_m: 200.0,
            line_m: 150.0,
            way_m: 2500.0,
            adaptive: true,
        }
    }

    #[test]
    fn the_places_cover_the_area_and_are_not_too_many() {
        let mut settings = settings();
        let places = settings.places();
        assert_eq!(places.len(), 15 * 10);
        assert!(places.iter().all(|place| settings.area.contains(*place, -19.0)));
        settings.kernel.length_m = 10.0;
        assert!((700..=1000).contains(&settings.places().len()));
    }

    #[test]
    fn a_lawnmower_has_the_way_that_is_allowed() {
        let mut settings = settings();
        assert_eq!(settings.first_lines(EastNorth::default()).len(), 2);
        settings.adaptive = false;
        // Four lines are 2400 m and three times 100 m between them.
        settings.way_m = 2700.0;
        assert_eq!(settings.first_lines(EastNorth::default()).len(), 4);
        settings.way_m = 10.0;
        assert_eq!(settings.first_lines(EastNorth::default()).len(), 1);
    }

    #[test]
    fn the_points_of_a_line_lie_on_it() {
        let settings = settings();
        let line = Line {
            start: EastNorth::default(),
            end: EastNorth::new(90.0, 0.0),
        };
        let points = settings.along(&line, 20);
        assert_eq!(points.len(), 3);
        assert!((points[0].east_m - 15.0).abs() < 1e-9 && (points[2].east_m - 75.0).abs() < 1e-9);
        assert_eq!(settings.along(&line, 2).len(), 2);
    }
}
