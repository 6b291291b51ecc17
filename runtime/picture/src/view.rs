//! The layout of the page, and the frame around the map.

use backseat_units::EastNorth;

use crate::canvas::{Canvas, Pixel, figure, number, path, rectangle, text, text_width};
use crate::picture::{Extent, Picture, Shape};
use crate::{ink, is_finite};

const WIDTH: f64 = 1200.0;
const MAP_LEFT: f64 = 76.0;
const MAP_TOP: f64 = 84.0;
const MAP_WIDTH: f64 = 860.0;
/// Captions wrap at this width, pixels.
const CAPTION_WIDTH: f64 = WIDTH - MAP_LEFT - 28.0;
const CAPTION_LINE: f64 = 18.0;
const CAPTION_SIZE: f64 = 13.0;

/// The page: which part of the frame is in view, and where.
pub(crate) struct View {
    pub(crate) width: f64,
    pub(crate) height: f64,
    pub(crate) map_left: f64,
    pub(crate) map_top: f64,
    pub(crate) map_width: f64,
    pub(crate) map_height: f64,
    pub(crate) extent: Extent,
    /// Pixels for a metre.
    pub(crate) scale: f64,
    caption: Vec<String>,
}

impl View {
    pub(crate) fn new(picture: &Picture) -> Self {
        let extent = page_extent(seen(picture));
        let scale = MAP_WIDTH / (extent.east_m - extent.west_m);
        let map_height = (extent.north_m - extent.south_m) * scale;
        let caption = wrapped(&picture.caption);
        Self {
            width: WIDTH,
            height: MAP_TOP + map_height + 58.0 + CAPTION_LINE * caption.len() as f64,
            map_left: MAP_LEFT,
            map_top: MAP_TOP,
            map_width: MAP_WIDTH,
            map_height,
            extent,
            scale,
            caption,
        }
    }

    pub(crate) fn pixel(&self, point: EastNorth) -> Pixel {
        (
            self.map_left + (point.east_m - self.extent.west_m) * self.scale,
            self.map_top + (self.extent.north_m - point.north_m) * self.scale,
        )
    }

    /// The pixels of a line's finite points.
    pub(crate) fn pixels(&self, points: &[EastNorth]) -> Vec<Pixel> {
        let finite = points.iter().filter(|point| is_finite(point));
        finite.map(|point| self.pixel(*point)).collect()
    }

    pub(crate) fn is_in_map(&self, (x, y): Pixel) -> bool {
        (self.map_left..=self.map_left + self.map_width).contains(&x)
            && (self.map_top..=self.map_top + self.map_height).contains(&y)
    }

    fn bottom(&self) -> f64 {
        self.map_top + self.map_height
    }

    fn step(&self) -> f64 {
        nice_step((self.extent.east_m - self.extent.west_m) / 7.0)
    }

    /// Thin lines through the ticks.
    pub(crate) fn draw_graticule(&self, canvas: &mut Canvas) {
        let mut data = String::new();
        let step = self.step();
        for east_m in ticks(self.extent.west_m, self.extent.east_m, step) {
            let x = number(self.pixel(EastNorth::new(east_m, 0.0)).0);
            data += &format!("M{x} {}V{}", number(self.map_top), number(self.bottom()));
        }
        for north_m in ticks(self.extent.south_m, self.extent.north_m, step) {
            let y = number(self.pixel(EastNorth::new(0.0, north_m)).1);
            data += &format!(
                "M{} {y}H{}",
                number(self.map_left),
                number(self.map_left + self.map_width)
            );
        }
        canvas.map(path(
            &data,
            &[
                ("class", &"graticule"),
                ("stroke", &"#1f2a30"),
                ("stroke-opacity", &"0.09"),
                ("fill", &"none"),
            ],
        ));
    }

    /// Draws the frame, ticks, title and caption.
    pub(crate) fn draw_frame(&self, canvas: &mut Canvas, picture: &Picture) {
        let frame = [("fill", &"none" as &dyn ToString), ("stroke", &ink::FRAME)];
        canvas.around(rectangle(
            self.map_left,
            self.map_top,
            self.map_width,
            self.map_height,
            &frame,
        ));
        let step = self.step();
        let style = [("fill", &ink::FAINT as &dyn ToString), ("font-size", &"11")];
        let middle = [style[0], style[1], ("text-anchor", &"middle")];
        let end = [style[0], style[1], ("text-anchor", &"end")];
        let mut marks = String::new();
        for east_m in ticks(self.extent.west_m, self.extent.east_m, step) {
            let x = self.pixel(EastNorth::new(east_m, 0.0)).0;
            marks += &format!("M{} {}v5", number(x), number(self.bottom()));
            // The axis' name is in the corner.
            if x < self.map_left + self.map_width - 60.0 {
                canvas.around(text((x, self.bottom() + 18.0), &figure(east_m, step), &middle));
            }
        }
        for north_m in ticks(self.extent.south_m, self.extent.north_m, step) {
            let y = self.pixel(EastNorth::new(0.0, north_m)).1;
            marks += &format!("M{} {}h-5", number(self.map_left), number(y));
            if y > self.map_top + 18.0 {
                canvas.around(text((self.map_left - 9.0, y + 4.0), &figure(north_m, step), &end));
            }
        }
        canvas.around(path(&marks, &[("stroke", &ink::FRAME), ("fill", &"none")]));
        let corner = (self.map_left + self.map_width, self.bottom() + 18.0);
        canvas.around(text(corner, "m east", &end));
        canvas.around(text((self.map_left - 9.0, self.map_top + 10.0), "m north", &end));

        let title = [("font-size", &"22" as &dyn ToString), ("font-weight", &"600")];
        canvas.around(text((self.map_left, 40.0), &fitted(&picture.title, 22.0), &title));
        let subtitle = [("font-size", &"14" as &dyn ToString), ("fill", &ink::FAINT)];
        canvas.around(text((self.map_left, 64.0), &fitted(&picture.subtitle, 14.0), &subtitle));
        for (index, line) in self.caption.iter().enumerate() {
            let y = self.bottom() + 46.0 + CAPTION_LINE * index as f64;
            canvas.around(text(
                (self.map_left, y),
                line,
                &[("class", &"caption"), ("font-size", &CAPTION_SIZE)],
            ));
        }
    }
}

/// The area that must be in view, or `None` if there is nothing to draw.
fn seen(picture: &Picture) -> Option<Extent> {
    let mut seen = Seen(picture.extent.filter(is_sound));
    let zones = picture.zones.iter().flat_map(|zone| zone.rings.iter().flatten());
    let leases = picture.lease_begins.iter().chain(&picture.lease_ends);
    for point in zones.chain(&picture.planned).chain(leases) {
        seen.point(*point);
    }
    for point in &picture.flown {
        seen.point(point.at);
    }
    for shape in &picture.inserts {
        seen.shape(shape);
    }
    // A refused request may lead very far away, and must not shrink everything else.
    if seen.0.is_none() {
        for rejected in &picture.rejected {
            seen.shape(&rejected.shape);
        }
    }
    let ground = picture.ground.as_ref().map(|raster| raster.extent).filter(is_sound);
    seen.0.or(ground)
}

fn is_sound(extent: &Extent) -> bool {
    extent.west_m < extent.east_m
        && extent.south_m < extent.north_m
        && [extent.west_m, extent.east_m, extent.south_m, extent.north_m]
            .iter()
            .all(|side| side.is_finite())
}

struct Seen(Option<Extent>);

impl Seen {
    fn point(&mut self, point: EastNorth) {
        if !is_finite(&point) {
            return;
        }
        let extent = self.0.get_or_insert(Extent {
            west_m: point.east_m,
            south_m: point.north_m,
            east_m: point.east_m,
            north_m: point.north_m,
        });
        extent.west_m = extent.west_m.min(point.east_m);
        extent.south_m = extent.south_m.min(point.north_m);
        extent.east_m = extent.east_m.max(point.east_m);
        extent.north_m = extent.north_m.max(point.north_m);
    }

    fn shape(&mut self, shape: &Shape) {
        match *shape {
            Shape::Point(at) => self.point(at),
            Shape::Line(from, to) => {
                self.point(from);
                self.point(to);
            }
            Shape::Circle { centre, radius_m } => {
                self.point(centre - EastNorth::new(radius_m, radius_m));
                self.point(centre + EastNorth::new(radius_m, radius_m));
            }
        }
    }
}

/// The area that the map shows: with a border, and not too wide or too high.
fn page_extent(seen: Option<Extent>) -> Extent {
    let seen = seen.unwrap_or(Extent {
        west_m: -100.0,
        south_m: -75.0,
        east_m: 100.0,
        north_m: 75.0,
    });
    let (width, height) = (seen.east_m - seen.west_m, seen.north_m - seen.south_m);
    let room = 0.05 * width.max(height).max(20.0);
    let (width, height) = (width + 2.0 * room, height + 2.0 * room);
    let (width, height) = (width.max(height / 1.05), height.max(width * 0.62));
    let (east_m, north_m) = ((seen.west_m + seen.east_m) / 2.0, (seen.south_m + seen.north_m) / 2.0);
    Extent {
        west_m: east_m - width / 2.0,
        south_m: north_m - height / 2.0,
        east_m: east_m + width / 2.0,
        north_m: north_m + height / 2.0,
    }
}

/// The least of 1, 2 and 5 times a power of ten that is at least `least`.
pub(crate) fn nice_step(least: f64) -> f64 {
    if !(least > 0.0 && least.is_finite()) {
        return 1.0;
    }
    let mut power = 1.0;
    while power * 10.0 <= least {
        power *= 10.0;
    }
    while power > least {
        power /= 10.0;
    }
    let fits = [1.0, 2.0, 5.0]
        .into_iter()
        .find(|step| step * power >= least * (1.0 - 1e-9));
    power * fits.unwrap_or(10.0)
}

/// The multiples of a step within a range, at most a hundred.
pub(crate) fn ticks(from: f64, to: f64, step: f64) -> Vec<f64> {
    let first = (from / step).ceil();
    let count = ((to / step).floor() - first + 1.0).clamp(0.0, 100.0) as usize;
    (0..count).map(|index| (first + index as f64) * step).collect()
}

/// A text cut to the width of the page.
fn fitted(content: &str, size: f64) -> String {
    if text_width(content, size) <= CAPTION_WIDTH {
        return content.to_owned();
    }
    let count = (CAPTION_WIDTH / (size * 0.6)) as usize;
    let mut cut: String = content.chars().take(count.saturating_sub(1)).collect();
    cut.push('\u{2026}');
    cut
}

/// The lines of a caption. They break between measures, so that a measure's name, its value and its unit stay together.
fn wrapped(content: &str) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for part in measures(content).iter().flat_map(|measure| parts(measure)) {
        match lines.last_mut() {
            Some(line) if fits(&format!("{line} {part}")) => {
                line.push(' ');
                line.push_str(&part);
            }
            Some(_) | None => lines.push(fitted(&part, CAPTION_SIZE)),
        }
    }
    lines
}

/// The measures of a caption with the dots and commas that end them.
fn measures(content: &str) -> Vec<String> {
    let mut measures: Vec<String> = Vec::new();
    let mut begins = true;
    for word in content.split_whitespace() {
        let is_dot = word == "\u{b7}";
        match measures.last_mut() {
            Some(measure) if !begins || is_dot => {
                measure.push(' ');
                measure.push_str(word);
            }
            Some(_) | None => measures.push(word.to_owned()),
        }
        begins = is_dot || word.ends_with(',');
    }
    measures
}

/// A measure, in pieces if it is longer than a line. Even then a figure stays with its unit.
fn parts(measure: &str) -> Vec<String> {
    if fits(measure) {
        return vec![measure.to_owned()];
    }
    let mut words: Vec<String> = Vec::new();
    for word in measure.split(' ') {
        match words.last_mut() {
            Some(figure) if figure.parse::<f64>().is_ok() => {
                figure.push(' ');
                figure.push_str(word);
            }
            Some(_) | None => words.push(word.to_owned()),
        }
    }
    words
}

fn fits(line: &str) -> bool {
    text_width(line, CAPTION_SIZE) <= CAPTION_WIDTH
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_caption_breaks_at_measures_only() {
        for end in [" \u{b7} ", ", "] {
            let caption = [
                "contour followed 1521.0 s",
                "contour rms 1.8 m",
                "violations: 0",
                "plume way 6267.1 m",
            ];
            let caption = caption.join(end).repeat(9).replace("mc", &format!("m{end}c"));
            let lines = wrapped(&caption);
            assert!(lines.len() > 2, "{lines:?}");
            for line in &lines {
                let begins = ["contour followed ", "contour rms ", "violations: ", "plume way "];
                assert!(begins.iter().any(|name| line.starts_with(name)), "{lines:?}");
            }
            assert_eq!(lines.join(" "), caption, "no word is lost");
        }
    }

    #[test]
    fn a_measure_that_is_longer_than_a_line_still_keeps_figures_with_their_units() {
        let lines = wrapped(&"and then 1521.0 s of it ".repeat(30));
        assert!(lines.len() > 2, "{lines:?}");
        assert!(
            lines
                .iter()
                .all(|line| !line.starts_with("s ") && !line.ends_with(".0")),
            "{lines:?}"
        );
    }

    #[test]
    fn steps_are_nice() {
        for (least, step) in [
            (0.9, 1.0),
            (1.0, 1.0),
            (1.1, 2.0),
            (23.0, 50.0),
            (0.013, 0.02),
            (600.0, 1000.0),
        ] {
            assert!(
                (nice_step(least) - step).abs() < 1e-9 * step,
                "{least} {}",
                nice_step(least)
            );
        }
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(nice_step(bad), 1.0);
        }
        assert_eq!(ticks(-2.5, 2.5, 1.0), [-2.0, -1.0, 0.0, 1.0, 2.0]);
    }
}
