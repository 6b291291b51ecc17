//! How long a ping takes: `cargo run --release -p backseat-acoustics --example ping_speed [-- ROUNDS
//! [WORDS]]`. Only rows that contain the words are measured.

use std::hint::black_box;
use std::time::Instant;

use backseat_acoustics::{Pose, SideScan, SideScanSettings, SubBottom, SubBottomSettings};
use backseat_units::EastNorth;
use backseat_world::World;

const PINGS: u32 = 2000;

const WORLD: &str = "
    [origin]
    latitude_deg = 42.3
    longitude_deg = -70.9
    [[targets]]
    count = 300
    kind = \"rock\"
    east_m = [-1000, 1000]
    north_m = [-1000, 1000]
    length_m = [0.3, 2.0]
    heading_deg = [0, 360]
";
const MORE: &str = "
    [[targets]]
    count = 19000
    kind = \"rock\"
    east_m = [-1000, 1000]
    north_m = [-1000, 1000]
    [[seabed.patches]]
    count = 60
    bottom = \"gravel\"
    east_m = [-1000, 1000]
    north_m = [-1000, 1000]
    [[seabed.layers]]
    depth_m = 3
    [[seabed.layers]]
    depth_m = 8
";

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let rounds: u32 = std::env::args().nth(1).map_or(Ok(10), |text| text.parse())?;
    let plain = World::new(&toml::from_str(WORLD)?, 1)?;
    let banks = World::new(&toml::from_str(&format!("{WORLD}[seabed]\nbanks = 2\n"))?, 1)?;
    let full = World::new(&toml::from_str(&format!("{WORLD}{MORE}"))?, 1)?;
    for (samples, pulse_s) in [(455, 100e-6), (2048, 100e-6), (8192, 100e-6)] {
        for (name, world) in [
            ("shelf, 300 targets", &plain),
            ("with 2 banks", &banks),
            ("with 19300 targets, 60 patches", &full),
        ] {
            let settings = SideScanSettings {
                frequency_hz: 410e3,
                range_m: 75.0,
                pulse_s,
                power: 1.0,
                gain_db: 0.0,
                samples,
                sound_speed_mps: 1500.0,
            };
            let mut sonar = SideScan::new(world, 1, "high");
            let (mut port, mut starboard) = (Vec::new(), Vec::new());
            measure(
                &format!("sidescan, {samples} a side, {name}"),
                2 * samples,
                rounds,
                world,
                |pose, ping| {
                    sonar.ping(world, pose, &settings, ping, &mut port, &mut starboard);
                    black_box((&port, &starboard));
                },
            );
        }
    }
    let settings = SubBottomSettings {
        start_hz: 4e3,
        end_hz: 16e3,
        pulse_s: 20e-3,
        power: 1.0,
        gain_db: 0.0,
        samples: 2000,
        sample_interval_s: 20e-6,
        sound_speed_mps: 1500.0,
    };
    let mut profiler = SubBottom::new(&full, 1, "profiler");
    let mut out = Vec::new();
    measure(
        "sub-bottom, 2000 samples, 2 layers",
        settings.samples,
        rounds,
        &full,
        |pose, ping| {
            profiler.ping(&full, pose, &settings, ping, &mut out);
            black_box(&out);
        },
    );
    Ok(())
}

/// The best of many rounds: other work on the machine only ever adds to one.
fn measure(name: &str, samples: u32, rounds: u32, world: &World, mut ping: impl FnMut(&Pose, u32)) {
    if std::env::args().nth(2).is_some_and(|words| !name.contains(&words)) {
        return;
    }
    // A survey line at 1.5 m/s and five pings a second, 10 m above the seabed.
    let poses: Vec<Pose> = (0..PINGS)
        .map(|number| {
            let along_m = 0.3 * f64::from(number) - 300.0;
            let at = EastNorth::new(0.6 * along_m, 0.8 * along_m);
            Pose {
                at,
                depth_m: world.water_depth_m(at) - 10.0,
                altitude_m: 10.0,
                heading_deg: 37.0,
                pitch_deg: 0.5,
                roll_deg: -1.0,
            }
        })
        .collect();
    let mut best = f64::MAX;
    for _ in 0..rounds {
        #[expect(clippy::disallowed_methods, reason = "an example that measures")]
        let start = Instant::now();
        for (number, pose) in (0..).zip(black_box(&poses)) {
            ping(pose, number);
        }
        best = best.min(start.elapsed().as_secs_f64());
    }
    let each = best / f64::from(PINGS);
    println!(
        "{:7.2} us a ping, {:5.1} ns a sample  {name}",
        each * 1e6,
        each * 1e9 / f64::from(samples)
    );
}
