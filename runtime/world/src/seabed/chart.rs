use backseat_units::math::{hypot, sin_cos, wrap_180};
use backseat_units::{EastNorth, LocalFrame, Position};

use super::SeabedConfig;
use crate::error::{WorldError, agree, check};
use crate::grid::{Grid, GridFrame, GridPositive, Layout};

/// WGS84: equatorial radius in metres and first eccentricity squared (NIMA TR8350.2, 2000, tables 3.1 and 3.3).
const SEMI_MAJOR_AXIS_M: f64 = 6_378_137.0;
const E2: f64 = 6.694_379_990_14e-3;
/// Second eccentricity squared.
const EP2: f64 = E2 / (1.0 - E2);

/// A grid, placed in a world's frame.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Chart {
    grid: Grid,
    place: Place,
    /// 1 if the grid holds depths, -1 if it holds elevations.
    sign: f64,
    /// The value of a cell without data, with the sign of the grid's values.
    no_data: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    Local,
    Geographic {
        frame: LocalFrame,
        /// Longitude of the grid's middle. Longitudes are counted from there, so a grid can cross 180 degrees.
        middle_deg: f64,
    },
}

impl Chart {
    pub(super) fn new(config: &SeabedConfig, frame: &LocalFrame, grid: Grid) -> Result<Self, WorldError> {
        let layout = grid.layout();
        let kind = config.grid_frame.unwrap_or_default();
        let as_declared = layout.declared.is_none_or(|declared| declared == kind);
        agree(as_declared, "seabed.grid_frame", "what GTModelType in the GeoTIFF says")?;
        let (place, distance_m) = match kind {
            GridFrame::Local => (Place::Local, local_distance_m(layout)),
            GridFrame::Geographic => geographic(layout, frame)?,
        };
        let expected = "at most 50000 (is grid_frame right?)";
        check(
            distance_m <= LocalFrame::RADIUS_M,
            "the grid's distance from the origin, metres,",
            distance_m.round(),
            expected,
        )?;
        let sign = match config.grid_positive.unwrap_or_default() {
            GridPositive::Down => 1.0,
            GridPositive::Up => -1.0,
        };
        if config.grid_nodata_depth_m.is_none()
            && let Some((row, column)) = grid.first_without_data()
        {
            return Err(WorldError::GridNoData {
                row: row + 1,
                column: column + 1,
            });
        }
        Ok(Self {
            grid,
            place,
            sign,
            no_data: sign * config.grid_nodata_depth_m.unwrap_or(0.0),
        })
    }

    /// Whether a place lies on the grid, including the outer halves of the cells at its edge.
    pub(super) fn covers(&self, at: EastNorth) -> bool {
        let (west, east, south, north) = edges(self.grid.layout());
        let (x, y) = match &self.place {
            Place::Local => (at.east_m, at.north_m),
            Place::Geographic { frame, middle_deg } => {
                let position = frame.to_position(at);
                let longitude_deg = position.longitude.as_deg();
                (
                    middle_deg + wrap_180(longitude_deg - middle_deg),
                    position.latitude.as_deg(),
                )
            }
        };
        (west..=east).contains(&x) && (south..=north).contains(&y)
    }

    /// Depth in metres and its gradient, before `depth_min_m` and `depth_max_m` are applied.
    pub(super) fn depth_and_gradient(&self, at: EastNorth) -> (f64, EastNorth) {
        match &self.place {
            Place::Local => {
                let sample = self.grid.sample(at.east_m, at.north_m, self.no_data);
                let gradient = EastNorth::new(sample.slope_east, sample.slope_north) * self.sign;
                (self.sign * sample.value, gradient)
            }
            Place::Geographic { frame, middle_deg } => {
                let position = frame.to_position(at);
                let (latitude_deg, longitude_deg) = (position.latitude.as_deg(), position.longitude.as_deg());
                let x = middle_deg + wrap_180(longitude_deg - middle_deg);
                let sample = self.grid.sample(x, latitude_deg, self.no_data);
                let (east_deg, north_deg) = degrees_per_metre(position, at.east_m);
                // These slopes are along true east and north. The frame's axes are turned from those by the
                // convergence.
                let (east, north) = (sample.slope_east * east_deg, sample.slope_north * north_deg);
                let (sin, cos) = sin_cos(frame.convergence_deg(position).to_radians());
                let gradient = EastNorth::new(east * cos - north * sin, east * sin + north * cos);
                (self.sign * sample.value, gradient * self.sign)
            }
        }
    }
}

/// How many degrees of longitude a metre to the east is, and of latitude a metre to the north, from the radii of
/// curvature and the frame's scale (Snyder, USGS Professional Paper 1395, 1987, equations 4-18, 4-20 and 8-16).
fn degrees_per_metre(position: Position, east_m: f64) -> (f64, f64) {
    let (sin, cos) = sin_cos(position.latitude.as_deg().to_radians());
    let w = 1.0 - E2 * sin * sin;
    let across_m = SEMI_MAJOR_AXIS_M / w.sqrt();
    let along_m = across_m * (1.0 - E2) / w;
    let from_axis = east_m / across_m;
    let scale = 1.0 + 0.5 * (1.0 + EP2 * cos * cos) * from_axis * from_axis;
    (
        (1.0 / (across_m * cos * scale)).to_degrees(),
        (1.0 / (along_m * scale)).to_degrees(),
    )
}

/// West, east, south and north of the cells' outer edges.
fn edges(layout: &Layout) -> (f64, f64, f64, f64) {
    let west = layout.west - 0.5 * layout.cell_east;
    let north = layout.north + 0.5 * layout.cell_north;
    let east = west + layout.columns as f64 * layout.cell_east;
    let south = north - layout.rows as f64 * layout.cell_north;
    (west, east, south, north)
}

/// Distance from the origin to the nearest point of the grid, metres.
fn local_distance_m(layout: &Layout) -> f64 {
    let (west, east, south, north) = edges(layout);
    hypot(0f64.clamp(west, east), 0f64.clamp(south, north))
}

fn geographic(layout: &Layout, frame: &LocalFrame) -> Result<(Place, f64), WorldError> {
    let (west, east, south, north) = edges(layout);
    let key = "the grid's edge, degrees,";
    // Half a cell of tolerance, because the outermost centres of a global grid may lie on the poles.
    let pole = 90.0 + 0.5 * layout.cell_north;
    check(
        south >= -pole,
        key,
        south,
        "a latitude, because grid_frame is geographic",
    )?;
    check(
        north <= pole,
        key,
        north,
        "a latitude, because grid_frame is geographic",
    )?;
    check(
        west >= -360.0,
        key,
        west,
        "a longitude, because grid_frame is geographic",
    )?;
    check(
        east <= 540.0,
        key,
        east,
        "a longitude, because grid_frame is geographic",
    )?;
    let middle_deg = 0.5 * (west + east);
    let origin = frame.origin();
    let from_middle_deg = wrap_180(origin.longitude.as_deg() - middle_deg);
    let half = 0.5 * (east - west);
    let nearest_longitude = middle_deg + from_middle_deg.clamp(-half, half);
    let nearest_latitude = origin.latitude.as_deg().clamp(south, north);
    let place = Place::Geographic {
        frame: *frame,
        middle_deg,
    };
    let nearest = [nearest_latitude, nearest_longitude];
    Ok((
        place,
        chord_m([origin.latitude.as_deg(), origin.longitude.as_deg()], nearest),
    ))
}

/// Length of the straight line through a spherical earth between two latitudes and longitudes. It is exact enough for a
/// bound, and works for any two points.
fn chord_m(one_deg: [f64; 2], other_deg: [f64; 2]) -> f64 {
    let point = |[latitude_deg, longitude_deg]: [f64; 2]| {
        let ((sin_lat, cos_lat), (sin_lon, cos_lon)) =
            (sin_cos(latitude_deg.to_radians()), sin_cos(longitude_deg.to_radians()));
        (cos_lat * cos_lon, cos_lat * sin_lon, sin_lat)
    };
    let ((x1, y1, z1), (x2, y2, z2)) = (point(one_deg), point(other_deg));
    SEMI_MAJOR_AXIS_M * hypot(hypot(x1 - x2, y1 - y2), z1 - z2)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn frame(latitude_deg: f64, longitude_deg: f64) -> LocalFrame {
        LocalFrame::new(Position::from_deg(latitude_deg, longitude_deg).unwrap())
    }

    fn config(text: &str) -> SeabedConfig {
        toml::from_str(&format!("grid = \"a.asc\"\n{text}")).unwrap()
    }

    /// Four by three cells of 100 m about the origin.
    const LOCAL: &str = "ncols 4 nrows 3 xllcorner -200 yllcorner -150 cellsize 100\n\
                         10 12 14 16\n20 23 26 29\n30 34 38 -9999";

    #[test]
    fn a_local_grid_is_bilinear_with_its_own_gradient() {
        let grid = Grid::from_esri_ascii(&LOCAL.replace("-9999", "42")).unwrap();
        let chart = Chart::new(&config(""), &frame(42.0, -70.0), grid).unwrap();
        // At the centre of a cell, and in the middle between four.
        assert_eq!(chart.depth_and_gradient(EastNorth::new(-150.0, 0.0)).0, 20.0);
        let (depth_m, gradient) = chart.depth_and_gradient(EastNorth::new(0.0, 50.0));
        assert_eq!(depth_m, (12.0 + 14.0 + 23.0 + 26.0) / 4.0);
        assert!((gradient.east_m - 2.5 / 100.0).abs() < 1e-12);
        assert!((gradient.north_m + 11.5 / 100.0).abs() < 1e-12);
        // Beyond the edge the depth is that of the nearest cell, and the bed is level.
        let (depth_m, gradient) = chart.depth_and_gradient(EastNorth::new(9000.0, 9000.0));
        assert_eq!((depth_m, gradient), (16.0, EastNorth::default()));
    }

    #[test]
    fn elevations_and_no_data() {
        let grid = Grid::from_esri_ascii(LOCAL).unwrap();
        let here = frame(42.0, -70.0);
        let error = Chart::new(&config(""), &here, grid.clone()).unwrap_err();
        assert_eq!(
            error.to_string(),
            "grid, row 3, column 4: no data, expected a value there or seabed.grid_nodata_depth_m"
        );
        let text = "grid_nodata_depth_m = 7\ngrid_positive = \"up\"";
        let chart = Chart::new(&config(text), &here, grid).unwrap();
        assert_eq!(chart.depth_and_gradient(EastNorth::new(150.0, -100.0)).0, 7.0);
        let (depth_m, gradient) = chart.depth_and_gradient(EastNorth::new(-150.0, 50.0));
        assert_eq!(depth_m, -15.0);
        assert!((gradient.north_m - 0.1).abs() < 1e-12);
    }

    #[test]
    fn a_grid_far_from_the_origin_is_refused() {
        let here = frame(42.0, -70.0);
        let message = |header: &str, text: &str| {
            let grid = Grid::from_esri_ascii(&format!("ncols 2 nrows 2 {header}\n1 2 3 4")).unwrap();
            Chart::new(&config(text), &here, grid).unwrap_err().to_string()
        };
        assert_eq!(
            message("xllcorner 330000 yllcorner 0 cellsize 10", ""),
            "the grid's distance from the origin, metres, is 330000, expected at most 50000 (is grid_frame right?)"
        );
        let geographic = "grid_frame = \"geographic\"";
        let message = message("xllcorner -71 yllcorner 4650000 cellsize 10", geographic);
        assert!(
            message.ends_with("expected a latitude, because grid_frame is geographic"),
            "{message}"
        );
        let far = Grid::from_esri_ascii("ncols 2 nrows 2 xllcorner 109 yllcorner -42 cellsize 1\n1 2 3 4").unwrap();
        assert!(Chart::new(&config(geographic), &here, far).is_err());
    }

    /// A tilted plane in longitude and latitude, which bilinear cells represent exactly.
    fn plane(west: f64, south: f64, cell: f64) -> Grid {
        let mut text = format!("ncols 9 nrows 9 xllcenter {west} yllcenter {south} cellsize {cell}\n");
        for row in (0..9).rev() {
            for column in 0..9 {
                text.push_str(&format!("{} ", 100 + 8 * column - 4 * row));
            }
        }
        Grid::from_esri_ascii(&text).unwrap()
    }

    #[test]
    fn a_geographic_grid_is_read_where_its_longitude_and_latitude_are() {
        for (west, origin_longitude) in [(-70.4, -70.0), (179.6, -179.9), (-180.4, 179.9), (289.6, -70.0)] {
            let here = frame(42.0, origin_longitude);
            let chart = Chart::new(&config("grid_frame = \"geographic\""), &here, plane(west, 41.6, 0.1)).unwrap();
            for (cells_east, cells_north) in [(1.0, 2.0), (4.5, 4.25), (6.0, 5.5)] {
                let longitude = wrap_180(west + 0.1 * cells_east);
                let at = here.to_local(Position::from_deg(41.6 + 0.1 * cells_north, longitude).unwrap());
                let expected = 100.0 + 8.0 * cells_east - 4.0 * cells_north;
                let (depth_m, _) = chart.depth_and_gradient(at);
                assert!((depth_m - expected).abs() < 1e-6, "{depth_m} {expected}");
            }
        }
    }

    proptest! {
        #[test]
        fn the_gradient_of_a_geographic_grid_is_the_derivative_of_its_depth(
            latitude in -80.0..80.0f64, east in -45_000.0..45_000.0f64, north in -45_000.0..45_000.0f64,
        ) {
            let here = frame(latitude, 10.0);
            let grid = plane(6.0, latitude - 4.0, 1.0);
            let chart = Chart::new(&config("grid_frame = \"geographic\""), &here, grid).unwrap();
            let depth = |east_m: f64, north_m: f64| chart.depth_and_gradient(EastNorth::new(east_m, north_m)).0;
            let by_difference = EastNorth::new(
                (depth(east + 5.0, north) - depth(east - 5.0, north)) / 10.0,
                (depth(east, north + 5.0) - depth(east, north - 5.0)) / 10.0,
            );
            let (_, gradient) = chart.depth_and_gradient(EastNorth::new(east, north));
            let steepness = hypot(gradient.east_m, gradient.north_m);
            prop_assert!(gradient.distance_m(by_difference) < 1e-5 * steepness + 1e-11, "{gradient:?} {by_difference:?}");
        }
    }
}
