//! The panel beside the map: north arrow, scale, colours and signs.

use svg::node::element::Element;

use crate::canvas::{Canvas, Pixel, circle, figure, number, path, rectangle, text};
use crate::ground::Bands;
use crate::ink;
use crate::picture::{Payload, Picture, Raster, Steer, ZoneKind};
use crate::view::{View, nice_step};

/// The distance between the map and the panel, pixels.
const GAP: f64 = 28.0;
const ROW: f64 = 25.0;
/// The width of a sign, pixels.
const SIGN: f64 = 34.0;

pub(crate) fn draw(canvas: &mut Canvas, view: &View, picture: &Picture, bands: Option<&Bands>) {
    let left = view.map_left + view.map_width + GAP;
    draw_north(canvas, (left + 12.0, view.map_top));
    draw_scale(canvas, view, (left + 54.0, view.map_top + 22.0));
    let mut y = view.map_top + 78.0;
    for (name, sign) in signs(picture) {
        for part in sign((left, y)) {
            canvas.around(part);
        }
        canvas.around(text(
            (left + SIGN + 12.0, y + 4.0),
            name,
            &[("class", &"legend"), ("font-size", &"13")],
        ));
        y += ROW;
    }
    if let (Some(raster), Some(bands)) = (&picture.ground, bands) {
        let room = view.map_top + view.map_height - y - 40.0;
        draw_bands(canvas, raster, bands, (left, y + 14.0), room);
    }
}

fn draw_north(canvas: &mut Canvas, (x, y): Pixel) {
    let (x, top) = (number(x), number(y + 14.0));
    let half = |side: &str| format!("M{x} {top}l{side}10 28l{} -7z", if side == "-" { "10" } else { "-10" });
    let style = [
        ("stroke", &ink::TEXT as &dyn ToString),
        ("stroke-width", &"1"),
        ("stroke-linejoin", &"round"),
    ];
    canvas.around(path(&half("-"), &[style[0], style[1], style[2], ("fill", &ink::TEXT)]));
    canvas.around(path(&half(""), &[style[0], style[1], style[2], ("fill", &"#ffffff")]));
    let style = [
        ("text-anchor", &"middle" as &dyn ToString),
        ("font-size", &"13"),
        ("font-weight", &"600"),
    ];
    let mut north = text((0.0, y + 9.0), "N", &style);
    north.get_attributes_mut().insert("x".into(), x.into());
    canvas.around(north);
}

fn draw_scale(canvas: &mut Canvas, view: &View, (x, y): Pixel) {
    // Steps are at most 2.5 times apart, so this is 44 to 110 pixels long.
    let length_m = nice_step(44.0 / view.scale);
    let length = length_m * view.scale;
    let half = length / 2.0;
    let style = [("stroke", &ink::TEXT as &dyn ToString), ("stroke-width", &"1")];
    canvas.around(rectangle(x, y, half, 6.0, &[style[0], style[1], ("fill", &ink::TEXT)]));
    canvas.around(rectangle(
        x + half,
        y,
        half,
        6.0,
        &[style[0], style[1], ("fill", &"#ffffff")],
    ));
    let (written, unit) = if length_m >= 1000.0 {
        (length_m / 1000.0, "km")
    } else {
        (length_m, "m")
    };
    let content = format!("{} {unit}", figure(written, written));
    canvas.around(text(
        (x + length + 8.0, y + 7.5),
        &content,
        &[("class", &"scale"), ("font-size", &"12")],
    ));
}

type Sign = Box<dyn Fn(Pixel) -> Vec<Element>>;

/// The signs that the picture contains.
fn signs(picture: &Picture) -> Vec<(&'static str, Sign)> {
    let mut signs: Vec<(&'static str, Sign)> = Vec::new();
    let (modifies, inserts) = match picture.payload {
        Payload::Plugin => ("flown: plugin steers", "flown: plugin's insert"),
        Payload::Client => ("flown: client steers", "flown: client's insert"),
    };
    for (steer, name) in [
        (Steer::FrontSeat, "flown: front seat steers"),
        (Steer::Modify, modifies),
        (Steer::Insert, inserts),
    ] {
        if picture.flown.iter().any(|point| point.steer == steer) {
            signs.push((name, Box::new(move |at| vec![line(at, ink::steer(steer), "2.6", "")])));
        }
    }
    if !picture.planned.is_empty() {
        signs.push(("planned", Box::new(|at| vec![line(at, ink::PLANNED, "1.4", "7 5")])));
    }
    if picture.ground.as_ref().is_some_and(|raster| raster.highlight.is_some()) {
        signs.push((
            "contour sought",
            Box::new(|at| vec![line(at, ink::HIGHLIGHT, "2.4", "")]),
        ));
    }
    if !picture.inserts.is_empty() {
        signs.push((
            "insert as asked",
            Box::new(|at| vec![line(at, ink::INSERT, "1.4", "2 3")]),
        ));
    }
    if !picture.rejected.is_empty() {
        let sign = |(x, y): Pixel| {
            let cross = format!("M{} {}l7 7m-7 0l7 -7", number(x + SIGN - 7.0), number(y - 3.5));
            let style = [
                ("stroke", &ink::REJECTED as &dyn ToString),
                ("stroke-width", &"1.8"),
                ("fill", &"none"),
            ];
            vec![line((x, y), ink::REJECTED, "1.1", ""), path(&cross, &style)]
        };
        signs.push(("rejected request", Box::new(sign)));
    }
    if !picture.lease_begins.is_empty() {
        signs.push(("lease begins", Box::new(|at| vec![dot(at, ink::MODIFY, "#ffffff")])));
    }
    if !picture.lease_ends.is_empty() {
        signs.push(("lease ends", Box::new(|at| vec![dot(at, "#ffffff", ink::MODIFY)])));
    }
    for (kind, name, margin_name, colour, fill) in [
        (ZoneKind::KeepIn, "stay inside", "its margin", ink::KEEP_IN, "#ffffff"),
        (
            ZoneKind::KeepOut,
            "keep out",
            "its margin",
            ink::KEEP_OUT,
            "url(#hatch)",
        ),
    ] {
        let mut zones = picture.zones.iter().filter(|zone| zone.kind == kind).peekable();
        if zones.peek().is_none() {
            continue;
        }
        signs.push((name, Box::new(move |at| vec![swatch(at, fill, "1", colour)])));
        if zones.any(|zone| zone.margin_m > 0.0) {
            signs.push((
                margin_name,
                Box::new(move |at| vec![swatch(at, colour, "0.16", "none")]),
            ));
        }
    }
    signs
}

fn line((x, y): Pixel, colour: &str, width: &str, dashes: &str) -> Element {
    let data = format!("M{} {}h{SIGN}", number(x), number(y));
    let mut line = path(
        &data,
        &[("fill", &"none"), ("stroke", &colour), ("stroke-width", &width)],
    );
    if !dashes.is_empty() {
        line.get_attributes_mut()
            .insert("stroke-dasharray".into(), dashes.into());
    }
    line
}

fn dot((x, y): Pixel, fill: &str, stroke: &str) -> Element {
    circle(
        (x + SIGN / 2.0, y),
        4.5,
        &[("fill", &fill), ("stroke", &stroke), ("stroke-width", &"1.6")],
    )
}

fn swatch((x, y): Pixel, fill: &str, opacity: &str, stroke: &str) -> Element {
    let style = [
        ("fill", &fill as &dyn ToString),
        ("fill-opacity", &opacity),
        ("stroke", &stroke),
        ("stroke-width", &"2"),
    ];
    rectangle(x + 1.0, y - 7.0, SIGN - 2.0, 14.0, &style)
}

/// Draws the bands' colours with the values between them: depth increases downwards, anything else upwards.
fn draw_bands(canvas: &mut Canvas, raster: &Raster, bands: &Bands, (x, y): Pixel, room: f64) {
    let name = if raster.unit.is_empty() {
        raster.label.clone()
    } else {
        format!("{} ({})", raster.label, raster.unit)
    };
    canvas.around(text(
        (x, y),
        &name,
        &[("class", &"legend"), ("font-size", &"13"), ("font-weight", &"600")],
    ));
    let count = bands.levels.len() + 1;
    let height = (room / count as f64).clamp(8.0, 19.0);
    let top = y + 12.0;
    // Values that would touch each other are left out.
    let every = (13.0 / height).ceil().max(1.0) as usize;
    for band in 0..count {
        let row = match raster.palette {
            crate::picture::Palette::Depth => band,
            crate::picture::Palette::Field => count - 1 - band,
        };
        let at = top + row as f64 * height;
        canvas.around(rectangle(x, at, SIGN - 8.0, height, &[("fill", &bands.colour(band))]));
        // The value between this band and the next lower one.
        let Some(level) = band.checked_sub(1).filter(|below| below % every == 0) else {
            continue;
        };
        let edge = match raster.palette {
            crate::picture::Palette::Depth => at,
            crate::picture::Palette::Field => at + height,
        };
        let value = figure(bands.levels[level], bands.step);
        let style = [
            ("class", &"legend" as &dyn ToString),
            ("font-size", &"11"),
            ("fill", &ink::FAINT),
        ];
        canvas.around(text((x + SIGN, edge + 4.0), &value, &style));
    }
    let frame = [
        ("fill", &"none" as &dyn ToString),
        ("stroke", &ink::FRAME),
        ("stroke-width", &"0.8"),
    ];
    canvas.around(rectangle(x, top, SIGN - 8.0, height * count as f64, &frame));
}
