//! Writes fences, legs and our verdicts into a folder, for `geos.py` beside this crate to judge with GEOS.
//!
//! ```sh
//! cargo run --release -p backseat-bench --example fences -- FOLDER
//! python tests/bench/geos.py FOLDER
//! ```
//!
//! For each fence `NAME.json` (its zones as WKT in the metres of its own plane, and how long a leg took us) and
//! `NAME.csv`: each leg's ends, its radius, and the metres that it has to spare, `nan` where it is rejected.
#![expect(clippy::disallowed_methods, reason = "a benchmark reads the clock")]

use std::error::Error;
use std::fmt::Write as _;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::Instant;

use backseat_fence::{Fence, Kind, Shape, Sweep, VerticalExtent, Zone};
use backseat_units::math::{exp, ln};
use backseat_units::{EastNorth, LocalFrame, Position};
use backseat_world::Stream;
use serde_json::{Value, json};

const LEGS: usize = 20_000;
const EXTENT: VerticalExtent = VerticalExtent {
    depth_min_m: 10.0,
    depth_max_m: 20.0,
    altitude_min_m: 5.0,
};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("expected the folder to write to")?);
    std::fs::create_dir_all(&folder)?;
    let mut random = Stream::new(1, "fences");
    for (name, zones) in fences(&mut random) {
        let text = json!({ "type": "FeatureCollection", "features": zones }).to_string();
        write(&folder, name, &Fence::from_geojson(&text)?, &mut random)?;
    }
    Ok(())
}

fn fences(random: &mut Stream) -> Vec<(&'static str, Vec<Value>)> {
    let whole = |random: &mut Stream, vertices, roughness| jagged(random, (0.0, 0.0), 3000.0, vertices, roughness);
    let mut fences = vec![
        ("star-100", vec![keep_in(10.0, &[star(100)])]),
        ("star-10000", vec![keep_in(10.0, &[star(10_000)])]),
        ("jagged-100", vec![keep_in(10.0, &[whole(random, 100, 0.5)])]),
        ("jagged-10000", vec![keep_in(10.0, &[whole(random, 10_000, 0.1)])]),
    ];
    let small = |random: &mut Stream| -> Vec<Ring> {
        let cells = (-3..=3).flat_map(|east| (-3..=3).map(move |north| (east, north)));
        cells
            .map(|(east, north)| {
                let middle = (f64::from(east) * 560.0, f64::from(north) * 560.0);
                jagged(random, middle, 200.0, 60, 0.6)
            })
            .collect()
    };
    let mut holes = vec![whole(random, 2000, 0.05)];
    holes.extend(small(random));
    fences.push(("holes", vec![keep_in(5.0, &holes)]));
    let mut islands = vec![keep_in(20.0, &[whole(random, 1000, 0.2)])];
    islands.extend(
        small(random)
            .iter()
            .zip(0..)
            .map(|(ring, index)| keep_out(index, core::slice::from_ref(ring))),
    );
    fences.push(("keep-out zones", islands));
    // Two bays that overlap, and a reef with a lagoon: a leg may be in either bay, or in the lagoon.
    let reef = jagged(random, (-1000.0, 0.0), 800.0, 300, 0.3);
    let lagoon = scaled(&reef, (-1000.0, 0.0), 0.5);
    let bays = vec![
        keep_in(0.0, &[jagged(random, (-1200.0, 0.0), 2500.0, 500, 0.2)]),
        keep_in(30.0, &[jagged(random, (1200.0, 300.0), 2500.0, 500, 0.4)]),
        keep_out(0, &[reef, lagoon]),
    ];
    fences.push(("bays", bays));
    fences
}

type Ring = Vec<EastNorth>;

/// The star of the speed table.
fn star(vertices: usize) -> Ring {
    (0..vertices)
        .map(|vertex| {
            let bearing = 360.0 * vertex as f64 / vertices as f64;
            let radius = 3000.0 + if vertex % 2 == 0 { 0.0 } else { 2.0e3 / vertices as f64 };
            EastNorth::default().offset(bearing, radius)
        })
        .collect()
}

/// A ring that every ray from its middle crosses once, at a random fraction of its radius.
fn jagged(random: &mut Stream, middle: (f64, f64), radius: f64, vertices: usize, roughness: f64) -> Ring {
    (0..vertices)
        .map(|vertex| {
            let bearing = 360.0 * (vertex as f64 + random.uniform_in(0.0, 0.8)) / vertices as f64;
            let radius = radius * random.uniform_in(1.0 - roughness, 1.0);
            EastNorth::new(middle.0, middle.1).offset(bearing, radius)
        })
        .collect()
}

fn scaled(ring: &[EastNorth], middle: (f64, f64), scale: f64) -> Ring {
    let middle = EastNorth::new(middle.0, middle.1);
    ring.iter().map(|point| middle + (*point - middle) * scale).collect()
}

fn keep_in(margin_m: f64, rings: &[Ring]) -> Value {
    let name = format!("keep-in with {margin_m} m");
    let properties = json!({
        "name": name, "kind": "keep-in", "margin_m": margin_m, "depth_max_m": 50, "altitude_min_m": 3
    });
    feature(&properties, rings)
}

fn keep_out(index: u32, rings: &[Ring]) -> Value {
    let properties = json!({
        "name": format!("keep-out {index}"), "kind": "keep-out", "margin_m": f64::from(index % 5) * 7.0
    });
    feature(&properties, rings)
}

fn feature(properties: &Value, rings: &[Ring]) -> Value {
    let frame = LocalFrame::new(Position::from_deg(42.0, -70.0).expect("a position"));
    let degrees = |point: &EastNorth| {
        let position = frame.to_position(*point);
        [position.longitude.as_deg(), position.latitude.as_deg()]
    };
    let coordinates: Vec<Vec<[f64; 2]>> = rings
        .iter()
        .map(|ring| ring.iter().chain(ring.first()).map(degrees).collect())
        .collect();
    json!({
        "type": "Feature", "properties": properties,
        "geometry": { "type": "Polygon", "coordinates": coordinates }
    })
}

fn write(folder: &Path, name: &str, fence: &Fence, random: &mut Stream) -> Result<(), Box<dyn Error>> {
    let legs = legs(fence, random);
    let mut text = String::from("from_east_m,from_north_m,to_east_m,to_north_m,radius_m,spare_m\n");
    for (from, to, radius_m) in &legs {
        let spare_m = match fence.check(&Sweep::new(Shape::leg(*from, *to), *radius_m), &EXTENT) {
            Ok(clearance) => clearance.metres,
            Err(_) => f64::NAN,
        };
        let (e, n, to_e, to_n) = (from.east_m, from.north_m, to.east_m, to.north_m);
        writeln!(text, "{e:?},{n:?},{to_e:?},{to_n:?},{radius_m:?},{spare_m:?}")?;
    }
    std::fs::write(folder.join(format!("{name}.csv")), text)?;
    let zones: Vec<Value> = fence.zones().map(zone).collect();
    let vertices: usize = fence
        .zones()
        .flat_map(Zone::rings)
        .map(|ring| ring.points.len() - 1)
        .sum();
    let ours_ns = time(fence, &legs);
    let fence = json!({ "vertices": vertices, "zones": zones, "ours_ns": ours_ns });
    std::fs::write(folder.join(format!("{name}.json")), fence.to_string())?;
    println!(
        "{name}: {vertices} vertices, {} legs, {ours_ns:.0} ns a leg",
        legs.len()
    );
    Ok(())
}

/// As in the fence itself: in metres, with its long edges divided.
fn zone(zone: &Zone) -> Value {
    let mut wkt = String::from("POLYGON (");
    for ring in zone.rings() {
        wkt.push_str(if ring.hole.is_some() { ", (" } else { "(" });
        for (index, point) in ring.points.iter().enumerate() {
            let comma = if index > 0 { ", " } else { "" };
            // Rust writes numbers so that they are read back exactly.
            write!(wkt, "{comma}{} {}", point.east_m, point.north_m).expect("a string takes everything");
        }
        wkt.push(')');
    }
    wkt.push(')');
    json!({
        "keep_in": matches!(zone.kind(), Kind::KeepIn { .. }),
        "margin_m": zone.margin_m(),
        "wkt": wkt,
    })
}

/// Half of them anywhere, half of them from a point between a micrometre and 300 m from a vertex.
fn legs(fence: &Fence, random: &mut Stream) -> Vec<(EastNorth, EastNorth, f64)> {
    let vertices: Vec<EastNorth> = fence
        .zones()
        .flat_map(Zone::rings)
        .flat_map(|ring| ring.points.to_vec())
        .collect();
    let between = |random: &mut Stream, least: f64, most: f64| exp(random.uniform_in(ln(least), ln(most)));
    (0..LEGS)
        .map(|leg| {
            let bearing = random.uniform_in(0.0, 360.0);
            let from = if leg % 2 == 0 {
                EastNorth::default().offset(bearing, random.uniform_in(0.0, 3200.0))
            } else {
                let vertex = vertices[random.next_u64() as usize % vertices.len()];
                vertex.offset(bearing, between(random, 1e-6, 300.0))
            };
            let bearing = random.uniform_in(0.0, 360.0);
            let to = match leg % 10 {
                // A point instead of a leg.
                0 => from,
                _ => from.offset(bearing, between(random, 0.1, 2000.0)),
            };
            let radius_m = match leg % 7 {
                0 => 0.0,
                _ => between(random, 0.01, 60.0),
            };
            (from, to, radius_m)
        })
        .collect()
}

/// Nanoseconds of a leg: the best of several rounds of a few legs each, so that other activity of the machine does not
/// count.
fn time(fence: &Fence, legs: &[(EastNorth, EastNorth, f64)]) -> f64 {
    let round = |few: &[(EastNorth, EastNorth, f64)]| {
        let start = Instant::now();
        for (from, to, radius_m) in few {
            black_box(
                fence
                    .check(&Sweep::new(Shape::leg(*from, *to), *radius_m), &EXTENT)
                    .is_ok(),
            );
        }
        start.elapsed().as_nanos() as f64
    };
    let best = |few| (0..9).map(|_| round(few)).fold(f64::MAX, f64::min);
    legs.chunks(100).map(best).sum::<f64>() / legs.len() as f64
}
