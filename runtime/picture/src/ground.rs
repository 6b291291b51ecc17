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
    // Cold is blue and warm is red, through a pale middle, so that a colour-blind reader sees both ends.
    const FIELD: [[f64; 3]; 5] = [
        [128.0, 172.0, 214.0],
        [190.0, 214.0, 234.0],
        [248.0, 243.0, 232.0],
        [246.0, 203.0, 180.0],
        [233.0, 146.0, 132.0],
    ];
    let stops: &[[f64; 3]] = match palette {
        Palette::Depth => &DEPTH,
        Palette::Field => &FIELD,
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Red, green and blue.
    fn parts(palette: Palette, at: f64) -> [u8; 3] {
        let text = colour(palette, at);
        [1, 3, 5].map(|from| u8::from_str_radix(&text[from..from + 2], 16).unwrap())
    }

    #[test]
    fn warm_is_red_and_cold_is_blue_and_depth_stays_blue() {
        let ([red, _, blue], [warm_red, _, warm_blue]) = (parts(Palette::Field, 0.0), parts(Palette::Field, 1.0));
        assert!(blue > red + 50 && warm_red > warm_blue + 50);
        let balance = |at: u32| {
            let [red, _, blue] = parts(Palette::Field, f64::from(at) / 20.0);
            i16::from(red) - i16::from(blue)
        };
        for at in 0..20 {
            assert!(balance(at) <= balance(at + 1), "warmer is never bluer: {at}");
            let [red, _, blue] = parts(Palette::Depth, f64::from(at) / 20.0);
            assert!(blue > red, "depth is blue: {at}");
        }
    }
}
