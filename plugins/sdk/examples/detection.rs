//! How well the detector of sonar contacts works on simulated imagery: `cargo run --release -p backseat-sdk --example
//! detection` prints the tables of `runtime/docs/reinspect.md`.

use std::fmt::Write as _;

use backseat_sdk::sonar::DetectorSettings;
use backseat_sdk::units::EastNorth;
use backseat_world::World;

#[path = "../tests/sea/mod.rs"]
mod sea;

use sea::{Line, STEP_M, even, level, ripples};

/// 8 a second.
const PINGS_PER_HOUR: f64 = 8.0 * 3600.0;

const HEIGHTS_M: [f64; 6] = [0.2, 0.35, 0.5, 0.8, 1.2, 2.0];
const STRENGTHS_DB: [f64; 5] = [-30.0, -25.0, -20.0, -15.0, -10.0];
const RANGES_M: [f64; 5] = [10.0, 20.0, 30.0, 40.0, 50.0];
/// Objects of a height and range, and the way along the track for each.
const EACH: usize = 40;
const APART_M: f64 = 14.0;
const ALTITUDE_M: f64 = 9.0;

fn main() {
    head("height");
    for (number, height_m) in HEIGHTS_M.into_iter().enumerate() {
        detection(&format!("{height_m} m"), height_m, -10.0, 21 + number as u64);
    }
    println!();
    head("strength");
    for (number, strength_db) in STRENGTHS_DB.into_iter().enumerate() {
        detection(&format!("{strength_db} dB"), 1.2, strength_db, 31 + number as u64);
    }
    println!();
    println!("| seabed without objects | contacts an hour | of 0.4 m or more | of 0.7 m or more |\n|---|---|---|---|");
    for (name, world, pattern) in [
        ("plain sand", level("sand", "", 11), even as fn(EastNorth) -> f64),
        ("plain silt", level("silt", "", 12), even),
        ("rippled sand", level("sand", "", 13), ripples),
        ("patches", patches(14), even),
        ("rocky sand", rocky(15), even),
    ] {
        false_alarms(name, &world, pattern);
    }
}

/// The head of a table of detection.
fn head(first: &str) {
    print!("| {first} |");
    for range_m in RANGES_M {
        print!(" {range_m} m |");
    }
    println!(" height found | place off by |\n|---|---|---|---|---|---|---|---|");
}

/// Boxes 1.5 m long and 1 m wide at any heading, in five ranges to both sides: the part that is found, and the median
/// of the height and of the error of the place, with 5 % and 95 %.
fn detection(name: &str, height_m: f64, strength_db: f64, seed: u64) {
    let mut text = String::new();
    let mut places = Vec::new();
    for index in 0..EACH * RANGES_M.len() {
        let range = index % RANGES_M.len();
        let side = if (index / RANGES_M.len()).is_multiple_of(2) {
            1.0
        } else {
            -1.0
        };
        let (east_m, north_m) = (side * RANGES_M[range], 120.0 + APART_M * index as f64);
        places.push((range, EastNorth::new(east_m, north_m)));
        let _ = write!(
            text,
            "[[targets]]\nkind = \"box\"\neast_m = {east_m}\nnorth_m = {north_m}\nlength_m = 1.5\nwidth_m = 1\nheight_m = \
                 {height_m}\nheading_deg = [0, 360]\nstrength_db = {strength_db}\n"
        );
    }
    let world = level("sand", &text, seed);
    let line = Line {
        world: &world,
        from: EastNorth::default(),
        heading_deg: 0.0,
        pings: ((160.0 + APART_M * places.len() as f64) / STEP_M) as u32,
        altitude_m: ALTITUDE_M,
        pattern: even,
        seed: 5,
    };
    let contacts = line.contacts(DetectorSettings::default());
    let (mut found, mut heights, mut off) = ([0; 5], Vec::new(), Vec::new());
    for (range, place) in &places {
        let nearest = contacts
            .iter()
            .map(|contact| (contact.at.distance_m(*place), contact))
            .min_by(|one, other| one.0.total_cmp(&other.0));
        if let Some((off_m, contact)) = nearest.filter(|(off_m, _)| *off_m < 3.0) {
            found[*range] += 1;
            heights.push(contact.height_m);
            off.push(off_m);
        }
    }
    print!("| {name} |");
    for found in found {
        print!(" {:.2} |", f64::from(found) / EACH as f64);
    }
    println!(" {} m | {} m |", spread(&mut heights), spread(&mut off));
}

fn spread(values: &mut [f64]) -> String {
    values.sort_by(f64::total_cmp);
    let at = |part: f64| {
        values
            .get((part * values.len() as f64) as usize)
            .copied()
            .unwrap_or(f64::NAN)
    };
    format!("{:.2} ({:.2} to {:.2})", at(0.5), at(0.05), at(0.95))
}

/// Patches of other textures, a tenth of the seabed or more.
fn patches(seed: u64) -> World {
    level(
        "sand",
        "[[seabed.patches]]\ncount = 400\nbottom = \"gravel\"\neast_m = [-70, 70]\nnorth_m = [0, 6000]\nlength_m = [5, 40]\nwidth_m \
         = [3, 20]\nheading_deg = [0, 180]\n[[seabed.patches]]\ncount = 400\nbottom = \"mud\"\neast_m = [-70, 70]\nnorth_m = [0, \
         6000]\nlength_m = [5, 40]\nwidth_m = [3, 20]\nheading_deg = [0, 180]\n",
        seed,
    )
}

/// Rocks, 1 in 40 square metres, most of them small.
fn rocky(seed: u64) -> World {
    level(
        "sand",
        "[[targets]]\ncount = 18000\nkind = \"rock\"\neast_m = [-65, 65]\nnorth_m = [0, 5500]\nlength_m = [0.2, 1.2]\nwidth_m = \
         [0.2, 1.0]\nheight_m = [0.05, 0.4]\nheading_deg = [0, 180]\nstrength_db = [-35, -20]\n",
        seed,
    )
}

/// An hour without an object.
fn false_alarms(name: &str, world: &World, pattern: fn(EastNorth) -> f64) {
    let line = Line {
        world,
        from: EastNorth::default(),
        heading_deg: 0.0,
        pings: PINGS_PER_HOUR as u32,
        altitude_m: ALTITUDE_M,
        pattern,
        seed: 6,
    };
    let contacts = line.contacts(DetectorSettings::default());
    let hours = f64::from(line.pings) / PINGS_PER_HOUR;
    let over = |height_m: f64| contacts.iter().filter(|contact| contact.height_m >= height_m).count() as f64 / hours;
    println!("| {name} | {:.1} | {:.1} | {:.1} |", over(0.0), over(0.4), over(0.7));
}
