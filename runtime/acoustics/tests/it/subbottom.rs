//! What a sub-bottom profiler sees.

use backseat_acoustics::{SubBottom, SubBottomSettings};
use backseat_units::{EastNorth, math};
use backseat_world::World;

use crate::scene::{LEVEL, decibels, pose, world};

pub(crate) const PROFILER: SubBottomSettings = SubBottomSettings {
    start_hz: 4e3,
    end_hz: 16e3,
    pulse_s: 20e-3,
    power: 1.0,
    gain_db: 0.0,
    samples: 2000,
    sample_interval_s: 20e-6,
    sound_speed_mps: 1500.0,
};

/// Mud with layers 4 m and 9 m down.
const LAYERS: &str = "[seabed]\ndepth_m = 40\nslope = 0\nmeanders = 0\nbottom = \"mud\"\n[[seabed.layers]]\ndepth_m = 4\n\
                      undulation_m = 0\nreflectivity_db = -18\nattenuation_db_per_m_khz = 0.05\n[[seabed.layers]]\n\
                      depth_m = 9\nundulation_m = 0\nreflectivity_db = -10\nattenuation_db_per_m_khz = 0.2\n";

/// The mean square of each sample over many pings.
fn mean_squares(world: &World, altitude_m: f64, settings: &SubBottomSettings) -> Vec<f64> {
    let mut profiler = SubBottom::new(world, 1, "test");
    let pose = pose(world, EastNorth::default(), altitude_m);
    let mut sums = vec![0.0; settings.samples as usize];
    let mut out = Vec::new();
    for ping in 0..50 {
        profiler.ping(world, &pose, settings, ping, &mut out);
        assert_eq!(out.len(), sums.len());
        for (sum, [i, q]) in sums.iter_mut().zip(&out) {
            *sum += (f64::from(*i) * f64::from(*i) + f64::from(*q) * f64::from(*q)) / 50.0;
        }
    }
    sums
}

/// Time of the greatest level within 1 m of a distance, seconds, and that level in decibels.
fn peak(levels: &[f64], distance_m: f64) -> (f64, f64) {
    let sample_m = 0.5 * PROFILER.sound_speed_mps * PROFILER.sample_interval_s;
    let (first, last) = (
        ((distance_m - 1.0) / sample_m) as usize,
        ((distance_m + 1.0) / sample_m) as usize,
    );
    let peak = (first..last)
        .max_by(|one, other| levels[*one].total_cmp(&levels[*other]))
        .expect("there are samples");
    (peak as f64 * PROFILER.sample_interval_s, decibels(levels[peak]))
}

#[test]
fn bed_and_layers_are_at_their_two_way_times() {
    let world = world(LAYERS, 1);
    let levels = mean_squares(&world, 8.0, &PROFILER);
    for distance_m in [8.0, 12.0, 17.0] {
        let (found_s, _) = peak(&levels, distance_m);
        let expected_s = 2.0 * distance_m / 1500.0;
        assert!(
            (found_s - expected_s).abs() <= PROFILER.sample_interval_s,
            "{distance_m}: {found_s} {expected_s}"
        );
    }
    let before = levels[..480].iter().copied().fold(0.0, f64::max);
    assert!(peak(&levels, 8.0).1 > decibels(before) + 30.0, "the water is dark");
}

#[test]
fn echoes_fade_with_distance_attenuation_and_what_boundaries_let_through() {
    let world = world(LAYERS, 1);
    let levels = mean_squares(&world, 8.0, &PROFILER);
    let level = |distance_m| peak(&levels, distance_m).1;
    // Spreading from 16 m to 24 m there and back; attenuation over 8 m at 10 kHz; the bed reflects 16 dB, and lets the
    // rest through twice.
    let through_bed = 2.0 * decibels(1.0 - math::pow(10.0, -1.6));
    let expected = 2.0 * decibels(12.0 / 8.0) + 0.05 * 10.0 * 8.0 + (18.0 - 16.0) - through_bed;
    assert!(
        (level(8.0) - level(12.0) - expected).abs() < 0.3,
        "{} {expected}",
        level(8.0) - level(12.0)
    );
    let through_layer = 2.0 * decibels(1.0 - math::pow(10.0, -1.8));
    let expected = 2.0 * decibels(17.0 / 12.0) + 0.2 * 10.0 * 10.0 + (10.0 - 18.0) - through_layer;
    assert!(
        (level(12.0) - level(17.0) - expected).abs() < 0.5,
        "{} {expected}",
        level(12.0) - level(17.0)
    );
}

#[test]
fn a_layer_is_one_line_from_ping_to_ping() {
    let world = world(LAYERS, 1);
    let mut profiler = SubBottom::new(&world, 1, "test");
    let (mut one, mut other) = (Vec::new(), Vec::new());
    profiler.ping(&world, &pose(&world, EastNorth::default(), 8.0), &PROFILER, 1, &mut one);
    profiler.ping(
        &world,
        &pose(&world, EastNorth::new(0.0, 0.3), 8.0),
        &PROFILER,
        2,
        &mut other,
    );
    // On a level layer both phases are the same, though noise differs.
    let sample = 800;
    let product = |[a, b]: [i16; 2], [c, d]: [i16; 2]| {
        let [a, b, c, d] = [a, b, c, d].map(f64::from);
        ((a * c + b * d) / (math::hypot(a, b) * math::hypot(c, d)), b * c - a * d)
    };
    assert!(
        product(one[sample], other[sample]).0 > 0.99,
        "{:?} {:?}",
        one[sample],
        other[sample]
    );
    // 3.75 cm lower is half of a wavelength there and back: a quarter of the way, the phase has turned by 90 degrees.
    profiler.ping(
        &world,
        &pose(&world, EastNorth::default(), 8.0 + 0.01875),
        &PROFILER,
        3,
        &mut other,
    );
    let (cos, sin) = product(one[sample], other[sample]);
    assert!(cos.abs() < 0.2 && sin.abs() > 0.0, "{cos} {sin}");
    assert_ne!(one, other);
}

#[test]
fn layers_undulate_and_end_where_they_meet_the_bed() {
    let world = world(
        &format!(
            "{LEVEL}bottom = \"mud\"\n[[seabed.layers]]\ndepth_m = 2\nundulation_m = 4\nundulation_wavelength_m = 200\nreflectivity_db = -6\n"
        ),
        3,
    );
    let mut profiler = SubBottom::new(&world, 1, "test");
    let mut out = Vec::new();
    let (mut seen, mut ended) = (0, 0);
    for step in 0..80u32 {
        let at = EastNorth::new(10.0 * f64::from(step), 0.0);
        profiler.ping(&world, &pose(&world, at, 8.0), &PROFILER, step, &mut out);
        let level = |distance_m: f64| {
            let sample = (distance_m / 0.015).round() as usize;
            math::hypot(f64::from(out[sample][0]), f64::from(out[sample][1]))
        };
        let depth_m = world.sediment_layers()[0].depth_at_m(at);
        if depth_m > 0.5 {
            seen += 1;
            assert!(level(8.0 + depth_m) > 5.0 * level(8.0 + depth_m + 0.4), "{step}");
        } else if depth_m < -0.5 {
            ended += 1;
            assert!(level(8.0 - depth_m) < 0.1 * level(8.0), "{step}");
            assert!(level(8.0 + depth_m) < 0.1 * level(8.0), "{step}");
        }
    }
    assert!(seen > 20 && ended > 5, "{seen} {ended}");
}

#[test]
fn a_target_is_a_hyperbola() {
    let world = world(
        &format!(
            "{LEVEL}bottom = \"mud\"\n[[targets]]\nkind = \"point\"\neast_m = 0\nnorth_m = 0\nheight_m = 3\nstrength_db = 10\n"
        ),
        1,
    );
    let mut profiler = SubBottom::new(&world, 1, "test");
    let mut out = Vec::new();
    for north_m in [-3.0f64, 0.0, 2.0] {
        profiler.ping(
            &world,
            &pose(&world, EastNorth::new(0.0, north_m), 12.0),
            &PROFILER,
            1,
            &mut out,
        );
        // Its top is 9 m below the vehicle. Nothing else is nearer than the bed.
        let slant_m = math::hypot(north_m, 9.0);
        let sample = (0..750)
            .max_by_key(|sample: &usize| {
                let [i, q] = out[*sample].map(i64::from);
                i * i + q * q
            })
            .unwrap();
        assert!((0.015 * sample as f64 - slant_m).abs() <= 0.03, "{north_m}: {sample}");
    }
}
