//! A picture shows the values that it is given, whatever they are, and is the same each time.

use backseat_picture::{
    Extent, Palette, Payload, Picture, Raster, Rejected, Shape, Steer, TrackPoint, Zone, ZoneKind, render,
};
use backseat_units::EastNorth;
use backseat_units::math::{exp, sin};

fn at(east_m: f64, north_m: f64) -> EastNorth {
    EastNorth::new(east_m, north_m)
}

fn ring(points: &[(f64, f64)]) -> Vec<EastNorth> {
    points.iter().map(|(east_m, north_m)| at(*east_m, *north_m)).collect()
}

fn seabed(east_m: f64, north_m: f64) -> f64 {
    let bank = 14.0 * exp(-((east_m - 300.0) * (east_m - 300.0) + (north_m + 100.0) * (north_m + 100.0)) / 180_000.0);
    30.0 + north_m * 0.016 + 2.5 * sin(east_m / 170.0) - bank
}

fn raster(width: usize, height: usize) -> Raster {
    let extent = Extent {
        west_m: -1100.0,
        south_m: -800.0,
        east_m: 1100.0,
        north_m: 800.0,
    };
    let node = |index: usize, count: usize, from: f64, to: f64| from + (to - from) * index as f64 / (count - 1) as f64;
    let values = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let values = values.map(|(x, y)| seabed(node(x, width, -1100.0, 1100.0), node(y, height, -800.0, 800.0)));
    Raster {
        extent,
        width,
        height,
        values: values.collect(),
        label: "Seabed depth".into(),
        unit: "m".into(),
        palette: Palette::Depth,
        highlight: Some(25.0),
    }
}

/// A survey that leaves the plan, follows an isobath under a lease, flies an insert and returns.
fn survey() -> Picture {
    let mut flown = Vec::new();
    for tick in 0..4000 {
        flown.push(TrackPoint {
            at: at(
                -850.0 + 0.15 * f64::from(tick),
                480.0 + 2.0 * sin(f64::from(tick) / 90.0),
            ),
            steer: Steer::FrontSeat,
        });
    }
    let (mut east_m, mut north_m) = (-250.0, 480.0);
    for tick in 0..9000 {
        let here = seabed(east_m, north_m);
        let error = (here - 25.0).clamp(-4.0, 4.0);
        let (gx, gy) = (
            seabed(east_m + 1.0, north_m) - here,
            seabed(east_m, north_m + 1.0) - here,
        );
        let norm = (gx * gx + gy * gy).sqrt().max(1e-6);
        let (ux, uy) = (gx / norm, gy / norm);
        let (vx, vy) = (uy - 0.4 * error * ux, -ux - 0.4 * error * uy);
        let speed = 0.15 / (vx * vx + vy * vy).sqrt();
        east_m += speed * vx;
        north_m += speed * vy;
        if tick % 2 == 0 {
            flown.push(TrackPoint {
                at: at(east_m, north_m),
                steer: Steer::Modify,
            });
        }
        if !(-850.0..850.0).contains(&east_m) || north_m < -550.0 {
            break;
        }
    }
    let lease_end = at(east_m, north_m);
    let (from, to) = (at(-100.0, -420.0), at(500.0, -420.0));
    for (a, b, steer) in [
        (lease_end, from, Steer::FrontSeat),
        (from, to, Steer::Insert),
        (to, at(830.0, -480.0), Steer::FrontSeat),
    ] {
        for step in 0..200 {
            let along = f64::from(step) / 200.0;
            flown.push(TrackPoint {
                at: a + (b - a) * along,
                steer,
            });
        }
    }
    let rejected = |from: EastNorth, to: EastNorth, reason: &str| Rejected {
        shape: Shape::Line(from, to),
        reason: reason.into(),
    };
    let mut refused: Vec<_> = (0..9)
        .map(|n| {
            rejected(
                at(700.0, 100.0 + 20.0 * f64::from(n)),
                at(1010.0, 180.0 + 30.0 * f64::from(n)),
                "keep-in: 110 m outside",
            )
        })
        .collect();
    refused.push(rejected(at(-300.0, 0.0), at(-560.0, -130.0), "keep-out wreck: 12 m"));
    refused.push(rejected(at(-300.0, 0.0), at(-580.0, -160.0), "keep-out wreck: 12 m"));
    refused.push(Rejected {
        shape: Shape::Circle {
            centre: at(100.0, 500.0),
            radius_m: 60.0,
        },
        reason: "depth 41.0 m over 40.0 m".into(),
    });
    Picture {
        title: "Isobath: follow the 25 m contour".into(),
        subtitle: "seed 7 \u{b7} 2026-05-28 12:00 UTC \u{b7} 48 min simulated in 0.14 s".into(),
        caption: "proposed 153 \u{b7} rejected 12 \u{b7} sent 141 \u{b7} accepted 141 \u{b7} failed 0 \u{b7} violations 0 \u{b7} \
                  cross-track error rms 0.42 m \u{b7} 3.1 km flown under lease \u{b7} least distance to the fence 38 m \u{b7} digest 9f2c51d0"
            .into(),
        extent: None,
        ground: Some(raster(221, 161)),
        zones: vec![
            Zone {
                name: "survey area".into(),
                kind: ZoneKind::KeepIn,
                rings: vec![ring(&[(-920.0, -600.0), (900.0, -640.0), (930.0, 560.0), (200.0, 640.0), (-940.0, 590.0)])],
                margin_m: 30.0,
            },
            Zone {
                name: "wreck".into(),
                kind: ZoneKind::KeepOut,
                rings: vec![ring(&[(-650.0, -220.0), (-500.0, -240.0), (-470.0, -100.0), (-600.0, -60.0)])],
                margin_m: 40.0,
            },
        ],
        planned: ring(&[(-850.0, 480.0), (830.0, 480.0), (830.0, 0.0), (-850.0, 0.0), (-850.0, -480.0), (830.0, -480.0)]),
        flown,
        inserts: vec![
            Shape::Line(from, to),
            Shape::Circle {
                centre: at(600.0, -250.0),
                radius_m: 80.0,
            },
        ],
        rejected: refused,
        lease_begins: vec![at(-250.0, 480.0)],
        lease_ends: vec![lease_end],
        payload: Payload::Plugin,
    }
}

fn count(svg: &str, what: &str) -> usize {
    svg.matches(what).count()
}

#[test]
fn all_layers_are_drawn_and_the_file_is_small() {
    let svg = render(&survey());
    if let Ok(path) = std::env::var("BACKSEAT_PICTURE") {
        std::fs::write(path, &svg).unwrap();
    }
    assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
    for class in [
        "band",
        "contour",
        "highlight",
        "contour-label",
        "keep-in",
        "keep-out",
        "margin",
        "outside",
        "planned",
        "inserts",
        "rejected",
        "refusal",
        "reason",
        "front-seat",
        "modify",
        "insert",
        "arrows",
        "start",
        "lease-begin",
        "lease-end",
        "graticule",
        "scale",
        "legend",
        "caption",
    ] {
        assert!(svg.contains(&format!("class=\"{class}\"")), "no {class}");
    }
    assert!(svg.contains("Isobath: follow the 25 m contour"));
    assert!(
        svg.contains("25 m</text>") || svg.contains("25 m\n"),
        "the isobath has its label"
    );
    assert!(svg.len() < 400_000, "{} bytes", svg.len());
    for embedded in ["<script", "@font-face", "<image", "href"] {
        assert!(!svg.contains(embedded), "{embedded}");
    }
    assert_eq!(svg, render(&survey()), "the same bytes each time");
}

#[test]
fn equal_reasons_share_a_label_and_there_are_few() {
    let svg = render(&survey());
    assert!(svg.contains("keep-in: 110 m outside (\u{d7}9)"));
    assert_eq!(count(&svg, "class=\"reason\""), 3);
    let mut flood = survey();
    flood.rejected = (0..5000)
        .map(|n| Rejected {
            shape: Shape::Point(at(f64::from(n % 70) * 20.0 - 700.0, f64::from(n / 70) * 10.0 - 350.0)),
            reason: format!("reason {}", n % 100),
        })
        .collect();
    let svg = render(&flood);
    assert!(count(&svg, "class=\"reason\"") <= 12);
    assert!(svg.len() < 400_000, "{} bytes", svg.len());
}

#[test]
fn nothing_and_nonsense_make_a_picture_too() {
    let empty = render(&Picture::default());
    assert!(empty.ends_with("</svg>\n") && !empty.contains("class=\"legend\""));
    let mut holed = raster(40, 30);
    for (index, value) in holed.values.iter_mut().enumerate() {
        if index % 7 == 0 {
            *value = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY][index % 3];
        }
    }
    let nonsense = Picture {
        title: "<b>&amp;</b>".into(),
        extent: Some(Extent {
            west_m: f64::NAN,
            south_m: 0.0,
            east_m: 1.0,
            north_m: f64::INFINITY,
        }),
        ground: Some(holed),
        zones: vec![Zone {
            name: String::new(),
            kind: ZoneKind::KeepOut,
            rings: vec![vec![], ring(&[(f64::NAN, 0.0), (1.0, 1.0)])],
            margin_m: f64::INFINITY,
        }],
        planned: vec![at(f64::NAN, 1.0)],
        flown: vec![TrackPoint {
            at: at(f64::INFINITY, f64::NAN),
            steer: Steer::Modify,
        }],
        inserts: vec![Shape::Circle {
            centre: at(0.0, 0.0),
            radius_m: f64::NAN,
        }],
        rejected: vec![Rejected {
            shape: Shape::Line(at(0.0, 0.0), at(f64::NAN, f64::NEG_INFINITY)),
            reason: "heading NaN".into(),
        }],
        ..Picture::default()
    };
    let svg = render(&nonsense);
    assert!(svg.contains("&lt;b&gt;"), "text is escaped");
    for line in svg.lines().filter(|line| line.contains(" d=\"")) {
        assert!(!line.contains("NaN") && !line.contains("inf"), "{line}");
    }
    let flat = Raster {
        values: vec![5.0; 221 * 161],
        ..raster(221, 161)
    };
    let all_holes = Raster {
        values: vec![f64::NAN; 221 * 161],
        ..raster(221, 161)
    };
    for ground in [
        flat,
        all_holes,
        Raster {
            width: 7,
            ..raster(221, 161)
        },
    ] {
        let svg = render(&Picture {
            ground: Some(ground),
            ..Picture::default()
        });
        assert!(svg.ends_with("</svg>\n"));
    }
}
