//! Planned and flown tracks, inserts and refused requests.

use backseat_units::math::hypot;

use crate::canvas::{Canvas, Pixel, circle, number, path, polyline};
use crate::labels::Labels;
use crate::picture::{Picture, Rejected, Shape, Steer, TrackPoint};
use crate::simplify::simplify;
use crate::view::View;
use crate::{ink, is_finite};

/// Tracks are simplified within this tolerance, metres, or within a third of a pixel if that is more.
const TOLERANCE_M: f64 = 0.5;
/// The distance between direction arrows along the track, pixels.
const ARROW_SPACING: f64 = 130.0;
/// The most refused requests that are drawn. More would hide the map, and they are alike.
const MOST_REJECTED: usize = 400;

pub(crate) fn draw_planned(canvas: &mut Canvas, view: &View, planned: &[backseat_units::EastNorth]) {
    let points = view.pixels(planned);
    if points.len() < 2 {
        return;
    }
    let mut data = String::new();
    polyline(&mut data, &points, false);
    canvas.map(path(
        &data,
        &[
            ("class", &"planned"),
            ("fill", &"none"),
            ("stroke", &ink::PLANNED),
            ("stroke-width", &"1.3"),
            ("stroke-dasharray", &"7 5"),
        ],
    ));
}

pub(crate) fn draw_inserts(canvas: &mut Canvas, view: &View, inserts: &[Shape]) {
    let data: String = inserts.iter().map(|shape| outline(view, shape)).collect();
    if data.is_empty() {
        return;
    }
    canvas.map(path(
        &data,
        &[
            ("class", &"inserts"),
            ("fill", &"none"),
            ("stroke", &ink::INSERT),
            ("stroke-width", &"1.2"),
            ("stroke-opacity", &"0.75"),
            ("stroke-dasharray", &"2 3"),
        ],
    ));
}

/// Draws where a replay parts from its run.
pub(crate) fn draw_asked(canvas: &mut Canvas, view: &View, picture: &Picture) {
    for (class, asked, colour) in [
        ("asked-then", &picture.asked_then, ink::MODIFY),
        ("asked-now", &picture.asked_now, ink::NOW),
    ] {
        let data: String = asked.iter().map(|shape| outline(view, shape)).collect();
        if !data.is_empty() {
            canvas.map(stroked(class, &data, colour, "1.5", "0.9"));
        }
    }
}

pub(crate) fn draw_rejected(canvas: &mut Canvas, view: &View, rejected: &[Rejected]) {
    let mut data = String::new();
    let mut crosses = String::new();
    // Chosen evenly, so that a flood of requests is not shown by its beginning alone.
    let every = rejected.len().div_ceil(MOST_REJECTED).max(1);
    for rejected in rejected.iter().step_by(every) {
        data += &outline(view, &rejected.shape);
        if let Some((x, y)) = anchor(view, &rejected.shape) {
            crosses += &format!("M{} {}l7 7m-7 0l7 -7", number(x - 3.5), number(y - 3.5));
        }
    }
    if crosses.is_empty() {
        return;
    }
    let style = |class: &'static str, width: &'static str, opacity: &'static str| {
        [
            ("class", class),
            ("fill", "none"),
            ("stroke", ink::REJECTED),
            ("stroke-width", width),
            ("stroke-opacity", opacity),
        ]
    };
    for (data, style) in [
        (data, style("rejected", "1.1", "0.6")),
        (crosses, style("refusal", "1.8", "1")),
    ] {
        let style: Vec<(&str, &dyn ToString)> = style
            .iter()
            .map(|(key, value)| (*key, value as &dyn ToString))
            .collect();
        canvas.map(path(&data, &style));
    }
}

/// The point for a refused request's cross and label: the end of a line, because it would have led there.
pub(crate) fn anchor(view: &View, shape: &Shape) -> Option<Pixel> {
    let at = match *shape {
        Shape::Point(at) | Shape::Line(_, at) | Shape::Circle { centre: at, .. } => at,
    };
    is_finite(&at).then(|| view.pixel(at))
}

fn outline(view: &View, shape: &Shape) -> String {
    let mut data = String::new();
    match *shape {
        Shape::Point(_) => {}
        Shape::Line(from, to) => {
            let points = view.pixels(&[from, to]);
            if points.len() == 2 {
                polyline(&mut data, &points, false);
            }
        }
        Shape::Circle { centre, radius_m } => {
            let radius = radius_m * view.scale;
            if is_finite(&centre) && radius > 0.0 && radius.is_finite() {
                let (x, y) = view.pixel(centre);
                let (r, d) = (number(radius), number(2.0 * radius));
                data = format!(
                    "M{} {}a{r} {r} 0 1 0 {d} 0a{r} {r} 0 1 0 -{d} 0",
                    number(x - radius),
                    number(y)
                );
            }
        }
    }
    data
}

/// Draws the flown track with arrows, its beginning and end, and the beginnings and ends of leases.
pub(crate) fn draw_flown(canvas: &mut Canvas, view: &View, picture: &Picture, labels: &mut Labels) {
    let tolerance = (TOLERANCE_M * view.scale).max(0.3);
    let runs: Vec<(Steer, Vec<Pixel>)> = runs(&picture.flown)
        .into_iter()
        .map(|(steer, points)| (steer, simplify(&view.pixels(&points), tolerance)))
        .collect();
    let mut halo = String::new();
    let mut lines = [
        (Steer::FrontSeat, "front-seat", String::new(), String::new()),
        (Steer::Modify, "modify", String::new(), String::new()),
        (Steer::Insert, "insert", String::new(), String::new()),
    ];
    let mut to_arrow = ARROW_SPACING / 2.0;
    for (steer, points) in &runs {
        polyline(&mut halo, points, false);
        labels.avoid(points, 1.0);
        for (of, _, line, arrows) in &mut lines {
            if of == steer {
                polyline(line, points, false);
                to_arrow = add_arrows(arrows, points, to_arrow);
            }
        }
    }
    if halo.is_empty() {
        return;
    }
    canvas.map(stroked("halo", &halo, "#ffffff", "5", "0.75"));
    for (steer, class, line, _) in &lines {
        if !line.is_empty() {
            canvas.map(stroked(class, line, ink::steer(*steer), "2.4", "1"));
        }
    }
    for (steer, _, _, arrows) in &lines {
        if !arrows.is_empty() {
            let style = [
                ("class", &"arrows" as &dyn ToString),
                ("fill", &ink::steer(*steer)),
                ("stroke", &"#ffffff"),
                ("stroke-width", &"0.8"),
            ];
            canvas.map(path(arrows, &style));
        }
    }
    for (class, points, fill) in [
        ("lease-begin", &picture.lease_begins, ink::MODIFY),
        ("lease-end", &picture.lease_ends, "#ffffff"),
    ] {
        for at in view.pixels(points) {
            let style = [
                ("class", &class as &dyn ToString),
                ("fill", &fill),
                ("stroke", if fill == ink::MODIFY { &"#ffffff" } else { &ink::MODIFY }),
                ("stroke-width", &"1.6"),
            ];
            canvas.map(circle(at, 4.5, &style));
        }
    }
    if let Some(at) = runs.first().and_then(|(_, points)| points.first()) {
        let style = [
            ("class", &"start" as &dyn ToString),
            ("fill", &"#ffffff"),
            ("stroke", &ink::TEXT),
            ("stroke-width", &"2.5"),
        ];
        canvas.map(circle(*at, 6.5, &style));
        labels.important(*at, "start", ink::TEXT);
    }
    if let Some(at) = runs.last().and_then(|(_, points)| points.last()) {
        let style = [
            ("class", &"end" as &dyn ToString),
            ("fill", &ink::TEXT),
            ("stroke", &"#ffffff"),
            ("stroke-width", &"1.5"),
        ];
        canvas.map(circle(*at, 6.5, &style));
        labels.important(*at, "end", ink::TEXT);
    }
}

fn stroked(class: &str, data: &str, colour: &str, width: &str, opacity: &str) -> svg::node::element::Element {
    path(
        data,
        &[
            ("class", &class),
            ("fill", &"none"),
            ("stroke", &colour),
            ("stroke-width", &width),
            ("stroke-opacity", &opacity),
            ("stroke-linejoin", &"round"),
            ("stroke-linecap", &"round"),
        ],
    )
}

/// Splits the track where another one begins to steer; each piece extends to the first point of the next.
fn runs(flown: &[TrackPoint]) -> Vec<(Steer, Vec<backseat_units::EastNorth>)> {
    let mut runs: Vec<(Steer, Vec<_>)> = Vec::new();
    for point in flown.iter().filter(|point| is_finite(&point.at)) {
        match runs.last_mut() {
            Some((steer, points)) if *steer == point.steer => points.push(point.at),
            last => {
                if let Some((_, points)) = last {
                    points.push(point.at);
                }
                runs.push((point.steer, vec![point.at]));
            }
        }
    }
    runs
}

/// Adds arrowheads along a line. Returns the remaining distance to the next arrow.
fn add_arrows(arrows: &mut String, points: &[Pixel], mut to_arrow: f64) -> f64 {
    for pair in points.windows(2) {
        let (dx, dy) = (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
        let length = hypot(dx, dy);
        if length <= 0.0 {
            continue;
        }
        let (ux, uy) = (dx / length, dy / length);
        while to_arrow <= length {
            let (x, y) = (pair[0].0 + ux * to_arrow, pair[0].1 + uy * to_arrow);
            let corners = [
                (x + 7.0 * ux, y + 7.0 * uy),
                (x - 4.0 * ux + 4.6 * uy, y - 4.0 * uy - 4.6 * ux),
                (x - 4.0 * ux - 4.6 * uy, y - 4.0 * uy + 4.6 * ux),
            ];
            polyline(arrows, &corners, true);
            to_arrow += ARROW_SPACING;
        }
        to_arrow -= length;
    }
    to_arrow
}
