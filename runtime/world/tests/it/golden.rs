//! Older configurations draw the same bits as before, because recorded runs depend on them.

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

/// A configuration with all sections that came later.
const LATER: &str = "
    [origin]
    latitude_deg = 42.3
    longitude_deg = -70.9
    [tide]
    amplitude_m = [0.5, 1.5]
    phase_deg = [0, 360]
    [current]
    speed_mps = 0.1
    bottom_boundary_m = 20
    [[current.tides]]
    speed_mps = [0.2, 0.4]
    towards_deg = [0, 360]
    period_h = 12.42
    phase_deg = [0, 360]
    ellipticity = [-0.5, 0.5]
    [[current.layers]]
    depth_m = 10
    [[current.layers]]
    depth_m = 30
    factor = 0.5
    turn_deg = 40
    [field.thermocline]
    depth_m = [10, 20]
    thickness_m = 5
    drop_c = 5
    [[field.filaments]]
    east_m = -300
    north_m = [-100, 100]
    towards_deg = 90
    speed_mps = [0.1, 0.2]
    sigma_m = 80
    meander_m = 30
    temperature_c = 1
    conductivity_us_per_cm = 100
    [[field.fronts]]
    east_m = [-200, 200]
    north_m = 0
    towards_deg = [0, 360]
    speed_mps = 0.02
    width_m = 50
    temperature_c = -1
    [[targets]]
    count = 5
    east_m = [-500, 500]
    north_m = [-500, 500]
    length_m = [1, 20]
";

#[test]
fn configurations_without_the_newer_sections_draw_the_same_as_before() {
    assert_eq!(
        digest(TEXT),
        "e5d4e893ab8fabcae54a8d22fee463a1654d5dbd07058d46a4a0fbdac4fbe07c"
    );
}

#[test]
fn the_newer_sections_draw_the_same_everywhere() {
    assert_eq!(
        digest(LATER),
        "53187211ce530a72179f8dc7225ab195e2c559b26b9cccdf795e60faccc20272"
    );
}

/// What sonars see has streams of its own: it moves nothing else, and draws the same everywhere.
#[test]
fn bottom_and_layers_change_no_other_draw() {
    let sonar = "
        [[seabed.patches]]
        count = 9
        bottom = \"gravel\"
        east_m = [-500, 500]
        north_m = [-500, 500]
        length_m = [20, 200]
        [[seabed.layers]]
        depth_m = [1, 4]
    ";
    assert_eq!(digest(TEXT), digest(&format!("{TEXT}{sonar}")));
    let config: WorldConfig = toml::from_str(&format!("{TEXT}{sonar}")).unwrap();
    let mut digest = Sha256::new();
    for seed in 0..20 {
        let world = World::new(&config, seed).unwrap();
        for patch in world.bottom().patches() {
            digest.update(patch.at.east_m.to_bits().to_le_bytes());
            digest.update(patch.length_m.to_bits().to_le_bytes());
        }
        let depth_m = world.sediment_layers()[0].depth_at_m(EastNorth::new(70.0, -30.0));
        digest.update(depth_m.to_bits().to_le_bytes());
    }
    let text: String = digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(text, "bd8b6d788224063ec9002a57f1ce0eae44273f0f957b496f8b689db90fdf1b80");
}

/// A digest of what twenty seeds draw along a path through time and space.
fn digest(text: &str) -> String {
    let config: WorldConfig = toml::from_str(text).unwrap();
    let mut digest = Sha256::new();
    let mut add = |value: f64| digest.update(value.to_bits().to_le_bytes());
    for seed in 0..20 {
        let world = World::new(&config, seed).unwrap();
        for step in 0..200u32 {
            let x = f64::from(step);
            let at = EastNorth::new(11.0 * x - 1000.0, 900.0 - 7.0 * x);
            let (depth_m, time) = (0.2 * x, Timestamp::from_secs(u64::from(step) * 300));
            let (east, north) = world.current_at(at, depth_m, time);
            let gradient = world.gradient(at);
            add(world.water_depth_m(at));
            add(gradient.east_m);
            add(gradient.north_m);
            add(east);
            add(north);
            add(world.temperature_c(at, depth_m, time));
            add(world.conductivity_us_per_cm(at, depth_m, time));
            if text == LATER {
                add(world.water_depth_at_m(at, time));
                add(world.sound_speed_mps(at, depth_m, time));
            }
        }
        for maximum in world
            .field_maximum()
            .into_iter()
            .chain(world.targets().iter().map(|target| target.at))
        {
            add(maximum.east_m);
            add(maximum.north_m);
        }
        for target in world.targets() {
            add(target.length_m);
        }
    }
    digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}
