//! How long a look at the world takes: `cargo run --release -p backseat-world --example look_speed`.

use std::hint::black_box;
use std::time::Instant;

use backseat_units::{EastNorth, Timestamp};
use backseat_world::{Grid, World, WorldConfig, WorldError};

const STEPS: u32 = 8192;
const ROUNDS: u32 = 200;

const ORIGIN: &str = "[origin]\nlatitude_deg = 42.3\nlongitude_deg = -70.9\n";
const TIDE: &str = "[[current.tides]]\nspeed_mps = 0.3\ntowards_deg = 45\nperiod_h = 12.42\nellipticity = 0.2\n";
const LAYERS: &str = "[[current.layers]]\ndepth_m = 5\n[[current.layers]]\ndepth_m = 40\nfactor = 0.4\nturn_deg = 30\n";
const PLUME: &str = "[[field.plumes]]\neast_m = 0\nnorth_m = 0\nsigma_m = 300\ntemperature_c = 2\n";
const FILAMENT: &str = "[[field.filaments]]\neast_m = -600\nnorth_m = 0\ntowards_deg = 90\nspeed_mps = 0.1\n\
                        sigma_m = 100\nmeander_m = 20\ntemperature_c = 2\n";
const FRONT: &str = "[[field.fronts]]\neast_m = 0\nnorth_m = 0\ntowards_deg = 90\nwidth_m = 500\ntemperature_c = 1\n";
const THERMOCLINE: &str = "[field.thermocline]\ndepth_m = 20\nthickness_m = 8\ndrop_c = 6\n";

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let config = |text: &str| toml::from_str::<WorldConfig>(&format!("{ORIGIN}{text}"));
    let drawn = |text: &str| -> Result<World, Box<dyn std::error::Error>> { Ok(World::new(&config(text)?, 1)?) };
    let plain = drawn("")?;
    let banks = drawn("[seabed]\nbanks = 2\n")?;
    let local = World::with_grid(
        &config("[seabed]\ngrid = \"a.asc\"\n")?,
        1,
        Some(grid(-2000.0, -2000.0, 4.0)?),
    )?;
    let geographic = World::with_grid(
        &config("[seabed]\ngrid = \"a.asc\"\ngrid_frame = \"geographic\"\n")?,
        1,
        Some(grid(-70.95, 42.25, 1e-4)?),
    )?;
    let tides = drawn(&format!("[current]\nspeed_mps = 0.1\n{TIDE}{TIDE}{LAYERS}"))?;
    let boundary = drawn(&format!(
        "[current]\nspeed_mps = 0.1\nbottom_boundary_m = 100\n{TIDE}{TIDE}{LAYERS}"
    ))?;
    let plume = drawn(PLUME)?;
    let all = drawn(&format!("{THERMOCLINE}{PLUME}{FILAMENT}{FRONT}"))?;

    let depth = |world: &World, at, _, _| world.seabed().depth_and_gradient(at).0;
    let current = |world: &World, at, depth_m, time| world.current_at(at, depth_m, time).0;
    let temperature = |world: &World, at, depth_m, time| world.temperature_c(at, depth_m, time);
    let sound = |world: &World, at, depth_m, time| world.sound_speed_mps(at, depth_m, time);
    measure("depth and gradient: shelf, 4 meanders", &plain, depth);
    measure("depth and gradient: shelf, 4 meanders, 2 banks", &banks, depth);
    measure("depth and gradient: grid, local", &local, depth);
    measure("depth and gradient: grid, geographic", &geographic, depth);
    measure("current: mean", &plain, current);
    measure("current: mean, 2 tides, layers", &tides, current);
    measure("current: mean, 2 tides, layers, boundary", &boundary, current);
    measure("temperature: plain", &plain, temperature);
    measure("temperature: plume", &plume, temperature);
    measure("temperature: thermocline, plume, filament, front", &all, temperature);
    measure("sound speed: the same", &all, sound);
    Ok(())
}

/// A million cells.
fn grid(west: f64, south: f64, cell: f64) -> Result<Grid, WorldError> {
    let mut text = format!("ncols 1000 nrows 1000 xllcorner {west} yllcorner {south} cellsize {cell}\n");
    for number in 0..1_000_000u32 {
        text.push_str(if number % 7 == 0 { "31 " } else { "30.5 " });
    }
    #[expect(clippy::disallowed_methods, reason = "an example that measures")]
    let start = Instant::now();
    let grid = Grid::from_esri_ascii(&text);
    println!(
        "{:6.1} ns a cell  reading an ESRI ASCII grid",
        start.elapsed().as_secs_f64() * 1e9 / 1e6
    );
    grid
}

/// The best of many rounds: other work on the machine only ever adds to one.
fn measure(name: &str, world: &World, look: impl Fn(&World, EastNorth, f64, Timestamp) -> f64) {
    // A vehicle's way: 0.15 m and 100 ms a step, up and down, within 500 m of the origin.
    let way: Vec<(EastNorth, f64, Timestamp)> = (0..STEPS)
        .map(|step| {
            let x = f64::from(step);
            let at = EastNorth::new(0.15 * x % 1000.0 - 500.0, 0.1 * x % 300.0 - 150.0);
            (at, 0.01 * x % 40.0, Timestamp::from_millis(u64::from(step) * 100))
        })
        .collect();
    let mut best = f64::MAX;
    for _ in 0..ROUNDS {
        #[expect(clippy::disallowed_methods, reason = "an example that measures")]
        let start = Instant::now();
        for (at, depth_m, time) in black_box(&way) {
            black_box(look(world, *at, *depth_m, *time));
        }
        best = best.min(start.elapsed().as_secs_f64());
    }
    println!("{:6.1} ns  {name}", best * 1e9 / f64::from(STEPS));
}
