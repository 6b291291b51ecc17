//! What older configurations draw stays bit for bit: recorded runs depend on it.

use backseat_units::{EastNorth, Timestamp};
use backseat_world::{World, WorldConfig};
use sha2::{Digest as _, Sha256};

const TEXT: &str = "
    [origin]
    latitude_deg = 42.3
    longitude_deg = -70.9
    [seabed]
    depth_m = [40, 60]
    banks = 3
    [current]
    speed_mps = [0.1, 0.4]
    rotation_h = [11.0, 13.0]
    decay_depth_m = 60
    [field]
    cooling_c_per_m = 0.05
    [[field.plumes]]
    east_m = [-300, 300]
    north_m = [-300, 300]
    sigma_m = [50, 150]
    temperature_c = [1.0, 3.0]
    conductivity_us_per_cm = 500
    [[field.plumes]]
    east_m = [-300, 300]
    north_m = 100
    sigma_m = 80
    temperature_c = 2
    depth_m = [5, 30]
";

#[test]
fn configurations_without_the_newer_sections_draw_what_they_always_drew() {
    let config: WorldConfig = toml::from_str(TEXT).unwrap();
    let mut digest = Sha256::new();
    for seed in 0..20 {
        let world = World::new(&config, seed).unwrap();
        for step in 0..200u32 {
            let x = f64::from(step);
            let at = EastNorth::new(11.0 * x - 1000.0, 900.0 - 7.0 * x);
            let (depth_m, time) = (0.2 * x, Timestamp::from_secs(u64::from(step) * 300));
            let (east, north) = world.current_at(at, depth_m, time);
            let gradient = world.gradient(at);
            for value in [
                world.water_depth_m(at),
                gradient.east_m,
                gradient.north_m,
                east,
                north,
                world.temperature_c(at, depth_m, time),
                world.conductivity_us_per_cm(at, depth_m, time),
            ] {
                digest.update(value.to_bits().to_le_bytes());
            }
        }
        let maximum = world.field_maximum().unwrap();
        digest.update(maximum.east_m.to_bits().to_le_bytes());
        digest.update(maximum.north_m.to_bits().to_le_bytes());
    }
    let hex: String = digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(hex, "e5d4e893ab8fabcae54a8d22fee463a1654d5dbd07058d46a4a0fbdac4fbe07c");
}
