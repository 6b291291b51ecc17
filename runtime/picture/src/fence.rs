//! The fence's zones. A margin is drawn as the half of a thick line on the side where the vehicle may be.

use crate::canvas::{Canvas, element, number, path, polyline, rectangle};
use crate::ink;
use crate::picture::{Zone, ZoneKind};
use crate::view::View;

pub(crate) fn draw(canvas: &mut Canvas, view: &View, zones: &[Zone]) {
    if zones.is_empty() {
        return;
    }
    let page = {
        let mut data = String::new();
        let (left, top) = (view.map_left, view.map_top);
        let (right, bottom) = (left + view.map_width, top + view.map_height);
        polyline(
            &mut data,
            &[(left, top), (right, top), (right, bottom), (left, bottom)],
            true,
        );
        data
    };
    let keep_ins: String = zones
        .iter()
        .filter(|zone| zone.kind == ZoneKind::KeepIn)
        .map(|zone| outline(view, zone))
        .collect();
    if !keep_ins.is_empty() {
        let veil = [
            ("class", &"outside" as &dyn ToString),
            ("fill", &"#ffffff"),
            ("fill-opacity", &"0.5"),
        ];
        let mut veil = path(&(page.clone() + &keep_ins), &veil);
        veil.get_attributes_mut().insert("fill-rule".into(), "evenodd".into());
        canvas.map(veil);
    }
    if zones.iter().any(|zone| zone.kind == ZoneKind::KeepOut) {
        define_hatch(canvas);
    }
    for (index, zone) in zones.iter().enumerate() {
        let data = outline(view, zone);
        if data.is_empty() {
            continue;
        }
        let (colour, fill, side) = match zone.kind {
            ZoneKind::KeepIn => (ink::KEEP_IN, "none", data.clone()),
            ZoneKind::KeepOut => (ink::KEEP_OUT, "url(#hatch)", page.clone() + &data),
        };
        if zone.margin_m > 0.0 && zone.margin_m.is_finite() {
            let name = format!("side{index}");
            let mut clip = element("clipPath", &[("id", &name)]);
            clip.get_children_mut()
                .push(Box::new(path(&side, &[("clip-rule", &"evenodd")])));
            canvas.define(clip);
            canvas.map(path(
                &data,
                &[
                    ("class", &"margin"),
                    ("clip-path", &format!("url(#{name})")),
                    ("fill", &"none"),
                    ("stroke", &colour),
                    ("stroke-opacity", &"0.16"),
                    ("stroke-width", &number(2.0 * zone.margin_m * view.scale)),
                    ("stroke-linejoin", &"round"),
                ],
            ));
        }
        let class = match zone.kind {
            ZoneKind::KeepIn => "keep-in",
            ZoneKind::KeepOut => "keep-out",
        };
        canvas.map(path(
            &data,
            &[
                ("class", &class),
                ("fill", &fill),
                ("fill-rule", &"evenodd"),
                ("stroke", &colour),
                ("stroke-width", &"2"),
                ("stroke-linejoin", &"round"),
            ],
        ));
    }
}

fn define_hatch(canvas: &mut Canvas) {
    let mut hatch = element(
        "pattern",
        &[
            ("id", &"hatch"),
            ("width", &"8"),
            ("height", &"8"),
            ("patternUnits", &"userSpaceOnUse"),
        ],
    );
    let ground = rectangle(
        0.0,
        0.0,
        8.0,
        8.0,
        &[("fill", &ink::KEEP_OUT), ("fill-opacity", &"0.1")],
    );
    let line = [("stroke", &ink::KEEP_OUT as &dyn ToString), ("stroke-opacity", &"0.55")];
    hatch.get_children_mut().push(Box::new(ground));
    hatch
        .get_children_mut()
        .push(Box::new(path("M-1 1L1 -1M0 8L8 0M7 9L9 7", &line)));
    canvas.define(hatch);
}

fn outline(view: &View, zone: &Zone) -> String {
    let mut data = String::new();
    for ring in &zone.rings {
        let pixels = view.pixels(ring);
        if pixels.len() >= 3 {
            polyline(&mut data, &pixels, true);
        }
    }
    data
}
