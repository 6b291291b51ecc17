//! The raster: filled bands in soft colours, and contour lines.

use backseat_units::EastNorth;

use crate::canvas::{Canvas, Pixel, path, polyline};
use crate::contour::{self, Line};
use crate::ink;
use crate::picture::{Palette, Raster};
use crate::simplify::simplify;
use crate::view::{View, nice_step, ticks};

/// Smaller outlines are noise, square pixels.
const LEAST_AREA: f64 = 6.0;

/// The bands, for labels and legend.
pub(crate) struct Bands {
    /// The values between the bands, rising; there is one band more than these.
    pub(crate) levels: Vec<f64>,
    pub(crate) step: f64,
    pub(crate) palette: Palette,
    /// Contour lines in pixels with their values, longest first in each level.
    pub(crate) lines: Vec<(f64, Vec<Vec<Pixel>>)>,
}

impl Bands {
    /// The colour of a band, 0 the lowest.
    pub(crate) fn colour(&self, band: usize) -> String {
        colour(self.palette, band as f64 / self.levels.len().max(1) as f64)
    }
}

pub(crate) fn draw(canvas: &mut Canvas, view: &View, raster: &Raster) -> Option<Bands> {
    let finite = || raster.values.iter().copied().filter(|value| value.is_finite());
    let (least, greatest) = (finite().reduce(f64::min)?, finite().reduce(f64::max)?);
    let step = nice_step((greatest - least) / 9.0);
    let mut levels = ticks(least, greatest, step);
    levels.retain(|level| *level > least && *level < greatest);
    let mut bands = Bands {
        levels,
        step,
        palette: raster.palette,
        lines: Vec::new(),
    };
    let edges: Vec<f64> = std::iter::once(least).chain(bands.levels.iter().copied()).collect();
    for (band, level) in edges.iter().enumerate() {
        let mut data = String::new();
        for line in contour::outlines(raster, *level) {
            let points = simplify(&placed(view, raster, &line), 0.35);
            if area(&points).abs() >= LEAST_AREA {
                polyline(&mut data, &points, true);
            }
        }
        let fill = bands.colour(band);
        canvas.map(path(
            &data,
            &[("class", &"band"), ("fill", &fill), ("fill-rule", &"evenodd")],
        ));
    }
    for level in bands.levels.clone() {
        let lines = draw_lines(canvas, view, raster, level, ("contour", "#27556b", "0.8", "0.5"));
        bands.lines.push((level, lines));
    }
    if let Some(value) = raster.highlight.filter(|value| value.is_finite()) {
        let lines = draw_lines(
            canvas,
            view,
            raster,
            value,
            ("highlight", ink::HIGHLIGHT, "2.4", "0.85"),
        );
        bands.lines.retain(|(level, _)| *level != value);
        bands.lines.insert(0, (value, lines));
    }
    Some(bands)
}

fn draw_lines(
    canvas: &mut Canvas,
    view: &View,
    raster: &Raster,
    value: f64,
    (class, stroke, width, opacity): (&str, &str, &str, &str),
) -> Vec<Vec<Pixel>> {
    let mut data = String::new();
    let mut drawn = Vec::new();
    for line in contour::lines(raster, value) {
        let points = simplify(&placed(view, raster, &line), 0.35);
        if line.closed && area(&points).abs() < LEAST_AREA {
            continue;
        }
        polyline(&mut data, &points, line.closed);
        drawn.push(points);
    }
    drawn.sort_by(|a, b| length(b).total_cmp(&length(a)));
    canvas.map(path(
        &data,
        &[
            ("class", &class),
            ("fill", &"none"),
            ("stroke", &stroke),
            ("stroke-width", &width),
            ("stroke-opacity", &opacity),
            ("stroke-linejoin", &"round"),
        ],
    ));
    drawn
}

fn placed(view: &View, raster: &Raster, line: &Line) -> Vec<Pixel> {
    let extent = raster.extent;
    let east = (extent.east_m - extent.west_m) / (raster.width - 1) as f64;
    let north = (extent.north_m - extent.south_m) / (raster.height - 1) as f64;
    let place = |(x, y): &(f64, f64)| EastNorth::new(extent.west_m + x * east, extent.south_m + y * north);
    view.pixels(&line.points.iter().map(place).collect::<Vec<_>>())
}

fn area(points: &[Pixel]) -> f64 {
    let pairs = points.iter().zip(points.iter().cycle().skip(1));
    pairs.map(|(a, b)| a.0 * b.1 - b.0 * a.1).sum::<f64>() / 2.0
}

fn length(points: &[Pixel]) -> f64 {
    points
        .windows(2)
        .map(|pair| backseat_units::math::hypot(pair[1].0 - pair[0].0, pair[1].1 - pair[0].1))
        .sum()
}

/// The colour for a value from the least (0) to the greatest (1). All colours are light, so that lines stand out.
fn colour(palette: Palette, at: f64) -> String {
    const DEPTH: [[f64; 3]; 4] = [
        [240.0, 247.0, 250.0],
        [205.0, 227.0, 238.0],
        [160.0, 199.0, 221.0],
        [112.0, 164.0, 199.0],
    ];
    // Viridis (van der Walt and Smith, 2015) from its yellow end, lightened by half.
    const FIELD: [[f64; 3]; 4] = [
        [252.0, 250.0, 222.0],
        [208.0, 234.0, 176.0],
        [148.0, 207.0, 178.0],
        [122.0, 170.0, 190.0],
    ];
    let stops = match palette {
        Palette::Depth => DEPTH,
        Palette::Field => FIELD,
    };
    let at = at.clamp(0.0, 1.0) * (stops.len() - 1) as f64;
    let index = (at as usize).min(stops.len() - 2);
    let along = at - index as f64;
    let part = |part: usize| {
        let (a, b) = (stops[index][part], stops[index + 1][part]);
        (a + along * (b - a)).round() as u8
    };
    format!("#{:02x}{:02x}{:02x}", part(0), part(1), part(2))
}
