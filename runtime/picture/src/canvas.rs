use std::fmt::Write as _;

use svg::node::Text;
use svg::node::element::Element;
use svg::node::{Node, Value};

use crate::ink;
use crate::view::View;

/// A point of the picture, pixels; y points down.
pub(crate) type Pixel = (f64, f64);

/// The viewer's own sans-serif font.
const FONT: &str = "system-ui, 'Segoe UI', 'DejaVu Sans', sans-serif";

/// The document being drawn: elements clipped to the map, and elements over and around it.
pub(crate) struct Canvas {
    definitions: Element,
    map: Element,
    around: Element,
    width: f64,
    height: f64,
}

impl Canvas {
    pub(crate) fn new(view: &View) -> Self {
        let mut definitions = Element::new("defs");
        let mut clip = element("clipPath", &[("id", &"map")]);
        clip.append(rectangle(
            view.map_left,
            view.map_top,
            view.map_width,
            view.map_height,
            &[],
        ));
        definitions.append(clip);
        Self {
            definitions,
            map: element("g", &[("clip-path", &"url(#map)")]),
            around: element("g", &[]),
            width: view.width,
            height: view.height,
        }
    }

    /// Adds a clip path, pattern or the like.
    pub(crate) fn define(&mut self, definition: Element) {
        self.definitions.append(definition);
    }

    /// Draws inside the map.
    pub(crate) fn map(&mut self, drawn: Element) {
        self.map.append(drawn);
    }

    /// Draws over and around the map.
    pub(crate) fn around(&mut self, drawn: Element) {
        self.around.append(drawn);
    }

    pub(crate) fn finish(self) -> String {
        let (width, height) = (number(self.width), number(self.height));
        let mut root = element(
            "svg",
            &[
                ("xmlns", &"http://www.w3.org/2000/svg"),
                ("width", &width),
                ("height", &height),
                ("viewBox", &format!("0 0 {width} {height}")),
                ("font-family", &FONT),
                ("font-size", &"12"),
                ("fill", &ink::TEXT),
            ],
        );
        root.append(self.definitions);
        root.append(rectangle(0.0, 0.0, self.width, self.height, &[("fill", &"#ffffff")]));
        root.append(self.map);
        root.append(self.around);
        format!("{root}\n")
    }
}

/// An element with attributes.
pub(crate) fn element(name: &str, attributes: &[(&str, &dyn ToString)]) -> Element {
    let mut element = Element::new(name);
    for (name, value) in attributes {
        element.assign(*name, Value::from(value.to_string()));
    }
    element
}

pub(crate) fn rectangle(x: f64, y: f64, width: f64, height: f64, style: &[(&str, &dyn ToString)]) -> Element {
    let mut rectangle = element("rect", style);
    for (name, value) in [("x", x), ("y", y), ("width", width), ("height", height)] {
        rectangle.assign(name, number(value));
    }
    rectangle
}

pub(crate) fn circle(centre: Pixel, radius: f64, style: &[(&str, &dyn ToString)]) -> Element {
    let mut circle = element("circle", style);
    for (name, value) in [("cx", centre.0), ("cy", centre.1), ("r", radius)] {
        circle.assign(name, number(value));
    }
    circle
}

pub(crate) fn path(data: &str, style: &[(&str, &dyn ToString)]) -> Element {
    let mut path = element("path", style);
    path.assign("d", data);
    path
}

pub(crate) fn text(at: Pixel, content: &str, style: &[(&str, &dyn ToString)]) -> Element {
    let mut text = element("text", style);
    text.assign("x", number(at.0));
    text.assign("y", number(at.1));
    text.append(Text::new(content));
    text
}

/// Appends path data for lines through points, closed if requested.
pub(crate) fn polyline(data: &mut String, points: &[Pixel], closed: bool) {
    let mut last = String::new();
    for (index, (x, y)) in points.iter().enumerate() {
        let point = format!("{} {}", number(*x), number(*y));
        if point == last {
            continue;
        }
        let command = if index == 0 { 'M' } else { 'L' };
        write!(data, "{command}{point}").expect("a String takes everything");
        last = point;
    }
    if closed {
        data.push('Z');
    }
}

/// A number rounded to a tenth, without trailing zeros.
pub(crate) fn number(value: f64) -> String {
    let mut text = format!("{value:.1}");
    if text.ends_with(".0") {
        text.truncate(text.len() - 2);
    }
    if text == "-0" { "0".to_owned() } else { text }
}

/// A value with as many decimals as its step needs, and with a typographic minus sign.
pub(crate) fn figure(value: f64, step: f64) -> String {
    let mut decimals = 0;
    let mut unit = step.abs();
    while decimals < 6 && (unit - unit.round()).abs() > 1e-6 {
        unit *= 10.0;
        decimals += 1;
    }
    let text = format!("{:.decimals$}", value.abs());
    if value < 0.0 && text.bytes().any(|byte| byte.is_ascii_digit() && byte != b'0') {
        format!("\u{2212}{text}")
    } else {
        text
    }
}

/// The width of a text, pixels: a generous estimate, because no font is available.
pub(crate) fn text_width(content: &str, size: f64) -> f64 {
    content.chars().count() as f64 * size * 0.6
}
