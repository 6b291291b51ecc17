//! Draws what simulated sonars see on a straight line: `cargo run --release -p backseat-acoustics --example waterfall --
//! [FOLDER]` writes `sidescan.png` and `subbottom.png`. Each row is a ping; time runs down.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use backseat_acoustics::{Pose, SideScan, SideScanSettings, SubBottom, SubBottomSettings};
use backseat_units::{EastNorth, math};
use backseat_world::{World, WorldConfig};

const PINGS: u32 = 900;
/// 1.5 m/s at five pings a second.
const STEP_M: f64 = 0.3;

const WORLD: &str = "
    [origin]
    latitude_deg = 42.3
    longitude_deg = -70.9
    [seabed]
    depth_m = 40
    slope = 0.02
    downslope_deg = 70
    bottom = \"silt\"
    [[seabed.patches]]
    count = 6
    bottom = \"gravel\"
    east_m = [-70, 70]
    north_m = [0, 270]
    length_m = [20, 60]
    width_m = [10, 30]
    heading_deg = [0, 180]
    [[seabed.layers]]
    depth_m = 2.5
    undulation_m = 1.0
    [[seabed.layers]]
    depth_m = 7
    undulation_m = 2.5
    reflectivity_db = -14
    [[targets]]
    kind = \"wreck\"
    east_m = 38
    north_m = 70
    length_m = 24
    width_m = 6
    height_m = 3
    heading_deg = 30
    strength_db = 15
    [[targets]]
    kind = \"cylinder\"
    east_m = -30
    north_m = 150
    length_m = 12
    width_m = 1
    height_m = 1
    heading_deg = 20
    strength_db = 0
    [[targets]]
    kind = \"box\"
    east_m = 30
    north_m = 190
    length_m = 6
    width_m = 2.5
    height_m = 2.5
    heading_deg = 75
    strength_db = 5
    [[targets]]
    count = 60
    kind = \"rock\"
    east_m = [-75, 75]
    north_m = [0, 270]
    length_m = [0.5, 2.5]
    width_m = [0.5, 2.5]
    height_m = [0.2, 1.2]
    heading_deg = [0, 180]
    strength_db = [-20, -5]
";

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| ".".to_owned());
    let folder = Path::new(&folder);
    let config: WorldConfig = toml::from_str(WORLD)?;
    let world = World::new(&config, 3)?;
    let settings = SideScanSettings {
        frequency_hz: 410e3,
        range_m: 75.0,
        pulse_s: 100e-6,
        power: 1.0,
        gain_db: 0.0,
        samples: 455,
        sound_speed_mps: 1500.0,
    };
    let profiler_settings = SubBottomSettings {
        start_hz: 4e3,
        end_hz: 16e3,
        pulse_s: 20e-3,
        power: 1.0,
        gain_db: 0.0,
        samples: 800,
        sample_interval_s: 40e-6,
        sound_speed_mps: 1500.0,
    };
    let (mut sonar, mut profiler) = (SideScan::new(&world, 3, "high"), SubBottom::new(&world, 3, "profiler"));
    let (mut port, mut starboard, mut profile) = (Vec::new(), Vec::new(), Vec::new());
    let (mut swath, mut section) = (Vec::new(), Vec::new());
    for ping in 0..PINGS {
        let north_m = STEP_M * f64::from(ping);
        let at = EastNorth::new(0.0, north_m);
        let altitude_m = 10.0 + 1.5 * math::sin(north_m / 40.0);
        let pose = Pose {
            at,
            depth_m: world.water_depth_m(at) - altitude_m,
            altitude_m,
            heading_deg: 0.0,
            pitch_deg: 0.0,
            roll_deg: 2.0 * math::sin(north_m / 15.0),
        };
        sonar.ping(&world, &pose, &settings, ping, &mut port, &mut starboard);
        swath.extend(
            port.iter()
                .rev()
                .chain(&starboard)
                .map(|sample| grey(f64::from(*sample), 20.0, 90.0)),
        );
        profiler.ping(&world, &pose, &profiler_settings, ping, &mut profile);
        section.push(
            profile
                .iter()
                .map(|[i, q]| grey(math::hypot(f64::from(*i), f64::from(*q)), 5.0, 75.0))
                .collect::<Vec<u8>>(),
        );
    }
    write(&folder.join("sidescan.png"), 2 * settings.samples, PINGS, &swath)?;
    // The section is drawn as it lies: time to the right, and depth down.
    let across =
        (0..profiler_settings.samples as usize).flat_map(|sample| section.iter().map(move |ping| ping[sample]));
    write(
        &folder.join("subbottom.png"),
        PINGS,
        profiler_settings.samples,
        &across.collect::<Vec<u8>>(),
    )?;
    Ok(())
}

/// A level in decibels, from black to white.
fn grey(sample: f64, black_db: f64, white_db: f64) -> u8 {
    let db = 20.0 / std::f64::consts::LN_10 * math::ln(sample.max(0.1));
    (255.0 * ((db - black_db) / (white_db - black_db)).clamp(0.0, 1.0)) as u8
}

fn write(path: &Path, width: u32, height: u32, pixels: &[u8]) -> Result<(), Box<dyn std::error::Error>> {
    let mut encoder = png::Encoder::new(BufWriter::new(File::create(path)?), width, height);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.write_header()?.write_image_data(pixels)?;
    Ok(())
}
