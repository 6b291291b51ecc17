//! Labels of the map, placed without overlaps.

use std::collections::BTreeMap;

use backseat_units::math::{atan2, hypot};

use crate::canvas::{Canvas, Pixel, element, figure, number, path, text, text_width};
use crate::ground::Bands;
use crate::ink;
use crate::picture::{Picture, Shape, ZoneKind};
use crate::tracks::anchor;
use crate::view::View;

/// The most labels of refused requests.
const MOST_REASONS: usize = 12;
/// The length at which a reason is cut, characters.
const REASON_LENGTH: usize = 44;

#[derive(Clone, Copy)]
struct Box2 {
    left: f64,
    top: f64,
    right: f64,
    bottom: f64,
}

impl Box2 {
    fn around((x, y): Pixel, width: f64, height: f64) -> Self {
        Self {
            left: x - width / 2.0,
            top: y - height / 2.0,
            right: x + width / 2.0,
            bottom: y + height / 2.0,
        }
    }

    fn meets(&self, other: &Self) -> bool {
        self.left < other.right && other.left < self.right && self.top < other.bottom && other.top < self.bottom
    }

    fn holds(&self, (x, y): Pixel) -> bool {
        x > self.left && x < self.right && y > self.top && y < self.bottom
    }
}

struct Important {
    at: Pixel,
    content: String,
    colour: &'static str,
}

/// The occupied areas, and the labels that are yet to be placed.
pub(crate) struct Labels {
    map: Box2,
    taken: Vec<Box2>,
    /// Points of lines to avoid where possible, with their weights.
    lines: Vec<(Pixel, f64)>,
    important: Vec<Important>,
}

impl Labels {
    pub(crate) fn new(view: &View) -> Self {
        Self {
            map: Box2 {
                left: view.map_left + 4.0,
                top: view.map_top + 4.0,
                right: view.map_left + view.map_width - 4.0,
                bottom: view.map_top + view.map_height - 4.0,
            },
            taken: Vec::new(),
            lines: Vec::new(),
            important: Vec::new(),
        }
    }

    /// Keeps labels off a line where there is room elsewhere. A track has the weight 1.
    pub(crate) fn avoid(&mut self, line: &[Pixel], weight: f64) {
        for pair in line.windows(2) {
            let length = hypot(pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
            let count = (length / 6.0).ceil().clamp(1.0, 400.0) as usize;
            for index in 0..count {
                let along = index as f64 / count as f64;
                let place = |a: f64, b: f64| a + along * (b - a);
                let point = (place(pair[0].0, pair[1].0), place(pair[0].1, pair[1].1));
                self.lines.push((point, weight));
            }
        }
    }

    /// Adds a label that is placed before all others.
    pub(crate) fn important(&mut self, at: Pixel, content: &str, colour: &'static str) {
        self.taken.push(Box2::around(at, 16.0, 16.0));
        // Start and end of a closed track are at the same point.
        let near = self
            .important
            .iter_mut()
            .find(|other| hypot(other.at.0 - at.0, other.at.1 - at.1) < 10.0);
        match near {
            Some(other) => other.content = format!("{}, {content}", other.content),
            None => self.important.push(Important {
                at,
                content: content.to_owned(),
                colour,
            }),
        }
    }

    /// Occupies the best free area beside a point. Returns its middle, or `None` if nothing is free.
    fn place(&mut self, at: Pixel, width: f64, height: f64) -> Option<Pixel> {
        const AROUND: [(f64, f64); 8] = [
            (1.0, 0.0),
            (1.0, -1.0),
            (-1.0, 0.0),
            (0.0, -1.0),
            (0.0, 1.0),
            (1.0, 1.0),
            (-1.0, -1.0),
            (-1.0, 1.0),
        ];
        let mut best: Option<(f64, Pixel, Box2)> = None;
        for (ring, gap) in [9.0, 22.0, 42.0, 70.0, 104.0].into_iter().enumerate() {
            for (turn, (dx, dy)) in AROUND.into_iter().enumerate() {
                let middle = (at.0 + dx * (width / 2.0 + gap), at.1 + dy * (height / 2.0 + gap));
                let Some((taken, hits)) = self.free(middle, width, height) else {
                    continue;
                };
                let cost = 6.0 * ring as f64 + 0.3 * turn as f64 + 3.0 * hits;
                if best.as_ref().is_none_or(|(least, ..)| cost < *least) {
                    best = Some((cost, middle, taken));
                }
            }
        }
        let (_, middle, taken) = best?;
        self.taken.push(taken);
        Some(middle)
    }

    /// Whether a label fits: the area that it would occupy, and how much of the lines it would hide.
    fn free(&self, middle: Pixel, width: f64, height: f64) -> Option<(Box2, f64)> {
        let taken = Box2::around(middle, width + 6.0, height + 8.0);
        let inside = taken.left >= self.map.left
            && taken.right <= self.map.right
            && taken.top >= self.map.top
            && taken.bottom <= self.map.bottom;
        if !inside || self.taken.iter().any(|other| other.meets(&taken)) {
            return None;
        }
        let hit = self.lines.iter().filter(|(point, _)| taken.holds(*point));
        let hits = hit.map(|(_, weight)| weight).sum();
        Some((taken, hits))
    }
}

pub(crate) fn draw(canvas: &mut Canvas, labels: &mut Labels, view: &View, picture: &Picture, bands: Option<&Bands>) {
    avoid_all(labels, view, picture);
    for Important { at, content, colour } in std::mem::take(&mut labels.important) {
        put(canvas, labels, at, &content, ("label", colour, 13.0, "600"));
    }
    for (at, content) in reasons(view, picture) {
        put(canvas, labels, at, &content, ("reason", ink::REJECTED, 12.0, "500"));
    }
    for zone in &picture.zones {
        let colour = match zone.kind {
            ZoneKind::KeepIn => ink::KEEP_IN,
            ZoneKind::KeepOut => ink::KEEP_OUT,
        };
        // Beside the northernmost corner in view.
        let corners = zone.rings.first().map(|ring| view.pixels(ring)).unwrap_or_default();
        let corners = corners.into_iter().filter(|corner| view.is_in_map(*corner));
        let top = corners.reduce(|a, b| if b.1 < a.1 { b } else { a });
        if let Some(top) = top.filter(|_| !zone.name.is_empty()) {
            put(canvas, labels, top, &zone.name, ("zone", colour, 12.0, "600"));
        }
    }
    let Some(bands) = bands else { return };
    let highlight = picture.ground.as_ref().and_then(|raster| raster.highlight);
    let unit = picture
        .ground
        .as_ref()
        .map(|raster| raster.unit.as_str())
        .unwrap_or_default();
    for (value, lines) in &bands.lines {
        let strong = highlight == Some(*value);
        let content = if strong && !unit.is_empty() {
            format!("{} {unit}", figure(*value, *value))
        } else {
            figure(*value, bands.step)
        };
        for line in lines.iter().take(if strong { 2 } else { 1 }) {
            put_along(canvas, labels, line, &content, strong);
        }
    }
}

/// Keeps labels off everything else that is drawn; the flown track is avoided already.
fn avoid_all(labels: &mut Labels, view: &View, picture: &Picture) {
    labels.avoid(&view.pixels(&picture.planned), 0.5);
    for ring in picture.zones.iter().flat_map(|zone| &zone.rings) {
        let mut ring = view.pixels(ring);
        ring.extend(ring.first().copied());
        labels.avoid(&ring, 0.7);
    }
    let refused = picture.rejected.iter().map(|rejected| &rejected.shape);
    for (shape, weight) in refused
        .map(|shape| (shape, 0.4))
        .chain(picture.inserts.iter().map(|shape| (shape, 0.5)))
        .take(300)
    {
        match *shape {
            Shape::Point(at) => labels.avoid(&view.pixels(&[at, at]), weight),
            Shape::Line(from, to) => labels.avoid(&view.pixels(&[from, to]), weight),
            Shape::Circle { centre, radius_m } => {
                let rim: Vec<_> = (0..=24)
                    .map(|turn| centre.offset(15.0 * f64::from(turn), radius_m))
                    .collect();
                labels.avoid(&view.pixels(&rim), weight);
            }
        }
    }
}

/// Refused requests grouped by reason, the most frequent first: the point of the first of each, and the label.
fn reasons(view: &View, picture: &Picture) -> Vec<(Pixel, String)> {
    let mut reasons: BTreeMap<&str, (usize, usize, Pixel)> = BTreeMap::new();
    for (index, rejected) in picture.rejected.iter().enumerate() {
        let Some(at) = anchor(view, &rejected.shape) else {
            continue;
        };
        let entry = reasons.entry(rejected.reason.as_str()).or_insert((0, index, at));
        entry.0 += 1;
        if !view.is_in_map(entry.2) {
            entry.2 = at;
        }
    }
    let mut reasons: Vec<_> = reasons
        .into_iter()
        .filter(|(_, (.., at))| view.is_in_map(*at))
        .collect();
    reasons.sort_by_key(|(_, (count, index, _))| (std::cmp::Reverse(*count), *index));
    reasons.truncate(MOST_REASONS);
    let write = |(reason, (count, _, at)): (&str, (usize, usize, Pixel))| {
        let mut content: String = reason.chars().take(REASON_LENGTH).collect();
        if content.len() < reason.len() {
            content.push('\u{2026}');
        }
        if count > 1 {
            content += &format!(" (\u{d7}{count})");
        }
        (at, content)
    };
    reasons.into_iter().map(write).collect()
}

/// Places a label beside a point, with a line to the point if it is far away. Draws nothing if there is no room.
fn put(
    canvas: &mut Canvas,
    labels: &mut Labels,
    at: Pixel,
    content: &str,
    (class, colour, size, weight): (&str, &str, f64, &str),
) {
    if content.is_empty() {
        return;
    }
    let width = text_width(content, size);
    let Some((x, y)) = labels.place(at, width, size) else {
        return;
    };
    let near = (
        at.0.clamp(x - width / 2.0, x + width / 2.0),
        at.1.clamp(y - size / 2.0, y + size / 2.0),
    );
    if hypot(near.0 - at.0, near.1 - at.1) > 16.0 {
        let data = format!(
            "M{} {}L{} {}",
            number(at.0),
            number(at.1),
            number(near.0),
            number(near.1)
        );
        let style = [
            ("stroke", &colour as &dyn ToString),
            ("stroke-width", &"0.8"),
            ("stroke-opacity", &"0.7"),
        ];
        canvas.around(path(&data, &style));
    }
    let mut group = element("g", &[("class", &class), ("text-anchor", &"middle")]);
    halo(&mut group, (x, y + 0.36 * size), content, (colour, size, weight), None);
    canvas.around(group);
}

/// Places a contour's value along the line, where the line is straightest and nothing is in the way.
fn put_along(canvas: &mut Canvas, labels: &mut Labels, line: &[Pixel], content: &str, strong: bool) {
    let size = if strong { 12.0 } else { 10.5 };
    let width = text_width(content, size);
    let resampled = resampled(line, 6.0);
    let span = ((width / 6.0).ceil() as usize + 2).max(3);
    let mut best: Option<(f64, Pixel, f64, Box2)> = None;
    for window in resampled.windows(span) {
        let (from, to) = (window[0], window[window.len() - 1]);
        let middle = ((from.0 + to.0) / 2.0, (from.1 + to.1) / 2.0);
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let chord = hypot(dx, dy);
        if chord < width {
            continue;
        }
        let (along, across) = ((dx / chord).abs(), (dy / chord).abs());
        let (box_width, box_height) = (width * along + size * across, width * across + size * along);
        let Some((taken, hits)) = labels.free(middle, box_width, box_height) else {
            continue;
        };
        let bend = 6.0 * (window.len() - 1) as f64 - chord;
        let cost = bend + 4.0 * hits + 6.0 * across;
        if best.as_ref().is_none_or(|(least, ..)| cost < *least) {
            let turn = atan2(dy, dx).to_degrees();
            let upright = if turn > 90.0 {
                turn - 180.0
            } else if turn < -90.0 {
                turn + 180.0
            } else {
                turn
            };
            best = Some((cost, middle, upright, taken));
        }
    }
    let Some((_, middle, turn, taken)) = best else { return };
    labels.taken.push(taken);
    let style = if strong {
        (ink::HIGHLIGHT, size, "700")
    } else {
        ("#27556b", size, "400")
    };
    let mut group = element("g", &[("class", &"contour-label"), ("text-anchor", &"middle")]);
    halo(
        &mut group,
        (middle.0, middle.1 + 0.36 * size),
        content,
        style,
        Some((turn, middle)),
    );
    canvas.map(group);
}

/// Draws a text with a white outline, so that it can be read on any background.
fn halo(
    group: &mut svg::node::element::Element,
    at: Pixel,
    content: &str,
    (colour, size, weight): (&str, f64, &str),
    turned: Option<(f64, Pixel)>,
) {
    for outline in [true, false] {
        let mut text = text(
            at,
            content,
            &[
                ("font-size", &number(size)),
                ("font-weight", &weight),
                ("fill", &if outline { "#ffffff" } else { colour }),
            ],
        );
        let attributes = text.get_attributes_mut();
        if outline {
            for (name, value) in [
                ("stroke", "#ffffff"),
                ("stroke-width", "3.5"),
                ("stroke-linejoin", "round"),
                ("stroke-opacity", "0.85"),
            ] {
                attributes.insert(name.into(), value.into());
            }
        }
        if let Some((turn, (x, y))) = turned {
            let turn = format!("rotate({} {} {})", number(turn), number(x), number(y));
            attributes.insert("transform".into(), turn.into());
        }
        group.get_children_mut().push(Box::new(text));
    }
}

/// Points of a line at equal distances along it.
fn resampled(line: &[Pixel], spacing: f64) -> Vec<Pixel> {
    let mut points = Vec::new();
    let mut next = 0.0;
    for pair in line.windows(2) {
        let (dx, dy) = (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
        let length = hypot(dx, dy);
        while next < length && points.len() < 10_000 {
            let along = next / length;
            points.push((pair[0].0 + along * dx, pair[0].1 + along * dy));
            next += spacing;
        }
        next -= length;
    }
    points
}
