//! The payload controller of `[plc]`, and what its sonars hear of the world.

use backseat_plc::{Pose, Reported, SensorKind, Stored};
use backseat_s7k::plc::Generic;
use backseat_scenario::true_pose;
use backseat_units::{EastNorth, Position, Timestamp};

use crate::dive::{Dive, Heard, LEVEL, levels, scenario};

/// Slant range from sample to sample of the sidescan's high frequency, m: 20 us at 1500 m/s.
const HIGH_M: f64 = 0.015;
/// The same of the other two: 40 us.
const LOW_M: f64 = 0.03;

fn world(rest: &str) -> String {
    format!("{LEVEL}[plc]\n{rest}")
}

/// The greatest and the mean level between two slant ranges.
fn between(levels: &[f64], sample_m: f64, from_m: f64, to_m: f64) -> (f64, f64) {
    let inside = &levels[(from_m / sample_m) as usize..(to_m / sample_m) as usize];
    let greatest = inside.iter().copied().fold(0.0, f64::max);
    (greatest, inside.iter().sum::<f64>() / inside.len() as f64)
}

#[test]
fn a_target_is_a_highlight_with_a_shadow_in_the_bytes_of_the_link() {
    // A box 2 m high, 20 m along the track, 30 m to starboard.
    let target = "[[targets]]\nkind = \"box\"\neast_m = 30\nnorth_m = 0\nlength_m = 20\nwidth_m = 1\nheight_m = 2\n\
                  strength_db = 10\n";
    for (kind, sample_m) in [(SensorKind::SidescanHigh, HIGH_M), (SensorKind::SidescanLow, LOW_M)] {
        let mut dive = Dive::new(&world(target), 1);
        dive.at(EastNorth::default(), 10.0);
        let pings = dive.listen(kind, 6.0);
        assert!(pings.len() >= 39, "{}", pings.len());
        let [port, starboard] = [0, 1].map(|channel| levels(&pings, channel));
        // From the near edge of the top to that of the foot; then until the ray over the far edge meets the bed again.
        let (near_m, far_m) = ((29.5 * 29.5 + 64.0_f64).sqrt(), (30.5 * 30.5 + 64.0_f64).sqrt());
        let (_, bed) = between(&starboard, sample_m, near_m - 6.0, near_m - 1.0);
        let (bright, _) = between(&starboard, sample_m, near_m - 0.2, far_m + 0.5);
        let (_, dark) = between(&starboard, sample_m, far_m + 0.5, far_m * 1.25 - 0.5);
        let (_, behind) = between(&starboard, sample_m, far_m * 1.25 + 0.5, far_m * 1.25 + 5.0);
        assert!(bright > 5.0 * bed, "{kind}: {bright} over {bed}");
        assert!(dark < 0.25 * bed, "{kind}: {dark} under {bed}");
        assert!((0.5..2.0).contains(&(behind / bed)), "{kind}: {behind} behind {bed}");
        let (port_greatest, port_bed) = between(&port, sample_m, near_m - 6.0, far_m * 1.25 + 5.0);
        assert!(port_greatest < 2.0 * port_bed, "{kind}: {port_greatest} to port");
    }
}

#[test]
fn the_profiler_hears_the_bed_at_the_altitude_and_a_layer_below_it() {
    let layer = "[[seabed.layers]]\ndepth_m = 3\nundulation_m = 0\nreflectivity_db = -10\n";
    let mut dive = Dive::new(&world(layer), 1);
    dive.at(EastNorth::default(), 12.0);
    let pings = dive.listen(SensorKind::SubBottom, 6.0);
    let profile = levels(&pings, 0);
    let brightest = |from_m: f64, to_m: f64| {
        let (greatest, _) = between(&profile, LOW_M, from_m, to_m);
        profile.iter().position(|level| *level == greatest).unwrap() as f64 * LOW_M
    };
    assert!((brightest(1.0, 60.0) - 12.0).abs() < 0.1, "{}", brightest(1.0, 60.0));
    assert!((brightest(13.0, 60.0) - 15.0).abs() < 0.1, "{}", brightest(13.0, 60.0));
    let (_, water) = between(&profile, LOW_M, 4.0, 10.0);
    let (layer, _) = between(&profile, LOW_M, 14.5, 15.5);
    assert!(layer > 10.0 * water, "{layer} over {water}");
}

#[test]
fn the_default_settings_neither_saturate_nor_are_flat() {
    for bottom in ["mud", "silt", "sand", "gravel", "rock"] {
        for altitude_m in [5.0, 10.0, 30.0] {
            let mut dive = Dive::new(&world("").replace("\"sand\"", &format!("{bottom:?}")), 1);
            for kind in [SensorKind::SubBottom, SensorKind::SidescanLow, SensorKind::SidescanHigh] {
                dive.at(EastNorth::default(), altitude_m);
                let pings = dive.listen(kind, 2.0);
                let place = format!("{kind} over {bottom}, {altitude_m} m");
                let (sample_m, full) = match kind {
                    SensorKind::SidescanHigh => (HIGH_M, 65_535.0),
                    SensorKind::SidescanLow => (LOW_M, 65_535.0),
                    SensorKind::SubBottom | SensorKind::Bluefin => (LOW_M, 32_767.0),
                };
                let samples = pings.iter().flat_map(|ping| ping.channels.iter().flatten());
                assert!(samples.clone().all(|sample| *sample < full), "{place}");
                let profile = levels(&pings, 0);
                let (bed, near) = between(&profile, sample_m, altitude_m - 0.5, 2.0 * altitude_m);
                let (_, far) = between(&profile, sample_m, 65.0, 74.0);
                let (_, water) = between(&profile, sample_m, 0.5, altitude_m - 0.6);
                if kind == SensorKind::SubBottom {
                    assert!(
                        bed > 500.0 && near > 2.0 * water && water > 0.5,
                        "{place}: {bed} {near} {water}"
                    );
                } else {
                    assert!(
                        near > 200.0 && far > 25.0 && water < 10.0,
                        "{place}: {near} {far} {water}"
                    );
                }
            }
        }
    }
}

#[test]
fn gain_raises_everything_and_power_the_echoes_alone() {
    let level = |power_percent: f64, gain_steps: i32, kind: SensorKind| {
        let mut dive = Dive::new(&world(""), 1);
        dive.at(EastNorth::default(), 10.0);
        dive.set(kind, &Generic::TxPower { percent: power_percent });
        dive.set(kind, &Generic::RxGain { gain: gain_steps });
        let profile = levels(&dive.listen(kind, 4.0), 0);
        let (_, bed) = between(&profile, LOW_M, 9.5, 12.0);
        let (_, noise) = between(&profile, LOW_M, 2.0, 9.0);
        (bed, noise)
    };
    let near = |ratio: f64, expected: f64| (ratio / expected - 1.0).abs() < 0.1;
    for kind in [SensorKind::SidescanLow, SensorKind::SubBottom] {
        let full = level(100.0, 0, kind);
        let quarter = level(25.0, 0, kind);
        assert!(near(full.0 / quarter.0, 2.0), "{kind}: {full:?} {quarter:?}");
        let twice = level(25.0, 6, kind);
        assert!(near(twice.0 / quarter.0, 1.995), "{kind}: {twice:?} {quarter:?}");
        // At so many steps the noise is well above one step of the converter.
        let (loud, louder) = (level(25.0, 34, kind), level(25.0, 40, kind));
        assert!(near(louder.1 / loud.1, 1.995), "{kind}: {loud:?} {louder:?}");
        assert!(near(level(100.0, 40, kind).1 / louder.1, 1.0), "{kind}");
        let (bed, noise) = level(0.0, 40, kind);
        assert!(bed < 3.0 * noise, "{kind}: {bed} {noise}");
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_seed_another_noise() {
    let bytes = |seed: u64| {
        let mut dive = Dive::new(
            &world("[[targets]]\ncount = 50\neast_m = [-60, 60]\nnorth_m = [-60, 60]\n"),
            seed,
        );
        for kind in [SensorKind::SidescanHigh, SensorKind::SidescanLow, SensorKind::SubBottom] {
            dive.at(EastNorth::new(3.0, 4.0), 8.0);
            assert!(!dive.listen(kind, 1.0).is_empty());
        }
        dive.bytes
    };
    let first = bytes(7);
    assert!(first.len() > 100_000);
    assert!(first == bytes(7));
    assert!(first != bytes(8));
}

#[test]
fn each_sensor_has_its_own_noise() {
    let heard = |kind: SensorKind| {
        // Both sidescans with the same pulse, range and samples: nothing but the noise can differ.
        let pulse = "pulses = [{ name = \"one\", start_khz = 110, end_khz = 130, length_ms = 8 }]\nrange_m = 75\n\
                     sample_interval_us = 40\nperiod_ms = 200\n";
        let mut dive = Dive::new(
            &world(&format!("[plc.sidescan_low]\n{pulse}[plc.sidescan_high]\n{pulse}")),
            1,
        );
        dive.at(EastNorth::default(), 10.0);
        dive.listen(kind, 1.0)
    };
    let (low, high) = (heard(SensorKind::SidescanLow), heard(SensorKind::SidescanHigh));
    assert_eq!(low[0].channels[0].len(), high[0].channels[0].len());
    assert_ne!(low[0], high[0]);
    assert_ne!(low[0], low[1], "and each ping");
}

#[test]
fn a_ping_that_the_acoustics_refuse_is_silence() {
    let silent = |pings: &[Heard]| {
        assert!(!pings.is_empty());
        let samples = pings.iter().flat_map(|ping| ping.channels.iter().flatten());
        samples.clone().count() > 1000 && samples.clone().all(|sample| *sample == 0.0)
    };
    let tone = |khz: f64| {
        format!(
            "[plc.sub_bottom]\npulses = [{{ name = \"tone\", start_khz = {khz}, end_khz = {khz}, length_ms = 5 }}]\n"
        )
    };
    // A profiler's pulse needs a bandwidth, and a vehicle needs a place.
    let mut dive = Dive::new(&world(&tone(4.0)), 1);
    dive.at(EastNorth::default(), 10.0);
    assert!(silent(&dive.listen(SensorKind::SubBottom, 1.0)));
    dive.at(EastNorth::new(f64::NAN, 0.0), 10.0);
    assert!(silent(&dive.listen(SensorKind::SidescanLow, 1.0)));
    dive.pose(Pose {
        depth_m: 30.0,
        pitch_deg: f64::INFINITY,
        ..Pose::default()
    });
    assert!(silent(&dive.listen(SensorKind::SidescanHigh, 1.0)));
    // The greatest range of the defaults is heard.
    let mut dive = Dive::new(&world(""), 1);
    dive.at(EastNorth::default(), 30.0);
    dive.set(SensorKind::SidescanLow, &Generic::Range { range_m: 500.0 });
    let pings = dive.listen(SensorKind::SidescanLow, 2.0);
    assert!(pings[0].channels[0].len() > 16_384 && !silent(&pings));
}

#[test]
fn a_mission_without_the_table_has_no_controller() {
    let scenario = scenario(LEVEL).unwrap();
    assert!(scenario.plc.is_none());
    let utc = scenario.world.start.utc;
    assert!(scenario.controller(1, utc, &Stored::default()).unwrap().is_none());
}

#[test]
fn what_is_wrong_with_the_table_is_one_line_with_its_place() {
    let fault = |rest: &str| {
        let error = scenario(&world(rest)).unwrap_err().to_string();
        assert!(!error.contains('\n') && error.contains("world.toml: "), "{error}");
        error
    };
    let line = world("").lines().count() + 1;
    let unknown = fault("clients = 3\n");
    assert!(
        unknown.contains(&format!("line {line}, column 1: unknown field `clients`")),
        "{unknown}"
    );
    let typed = fault("[plc.disk]\ncapacity_mb = \"big\"\n");
    assert!(
        typed.contains(&format!("line {}, column 15: invalid type", line + 1)),
        "{typed}"
    );
    let value = fault("clients_max = 65\n");
    assert!(value.ends_with("plc.clients_max is 65, expected 1 to 64"), "{value}");
    let planned = fault("[[plc.fault]]\nat_s = 1\nfor_s = 2\nkind = \"sensor_dies\"\n");
    assert!(
        planned.ends_with("plc fault 1: sensor_dies needs `sensor`"),
        "{planned}"
    );
}

#[test]
fn what_the_controller_stored_and_cannot_be_read_is_named() {
    let scenario = scenario(&world("")).unwrap();
    let stored = Stored {
        run_list: Some("nonsense".to_owned()),
        settings: None,
    };
    let error = scenario.controller(1, scenario.world.start.utc, &stored).unwrap_err();
    assert!(error.to_string().starts_with("6046.sav, line 1: "), "{error}");
}

#[test]
fn a_vehicle_is_where_clients_say_and_else_at_the_start() {
    let text = LEVEL.replace(
        "[origin]",
        "east_m = 100\nnorth_m = -200\ndepth_m = 6\nheading_deg = 45\n[origin]",
    );
    let scenario = scenario(&text).unwrap();
    let start = scenario.reported_pose(None);
    assert_eq!((start.at, start.depth_m), (EastNorth::new(100.0, -200.0), 6.0));
    assert!((start.heading_deg - 45.0).abs() < 0.01 && start.north_mps == 0.0);
    let frame = scenario.world.world_config().frame().unwrap();
    let at = EastNorth::new(20_000.0, 3000.0);
    let mut said = Reported {
        received: Timestamp::ZERO,
        position: Some(frame.to_position(at)),
        depth_m: Some(12.5),
        heading_deg: Some(350.0),
        pitch_deg: Some(-3.0),
        roll_deg: None,
        north_mps: Some(1.0),
        east_mps: Some(-0.5),
        down_mps: Some(0.1),
    };
    let pose = scenario.reported_pose(Some(&said));
    assert!(pose.at.distance_m(at) < 0.01, "{pose:?}");
    // 20 km east of the origin, true north and the frame's north differ by 0.16 degrees.
    let convergence_deg = frame.convergence_deg(frame.to_position(at));
    assert!(convergence_deg.abs() > 0.1);
    assert!((pose.heading_deg - (350.0 - convergence_deg)).abs() < 1e-9, "{pose:?}");
    assert_eq!((pose.depth_m, pose.pitch_deg, pose.roll_deg), (12.5, -3.0, 0.0));
    assert_eq!((pose.north_mps, pose.east_mps, pose.down_mps), (1.0, -0.5, 0.1));
    said.position = Some(Position::from_deg(-42.0, 10.0).unwrap());
    assert_eq!(scenario.reported_pose(Some(&said)).at, start.at, "off the world");
}

#[test]
fn the_truth_of_the_mock_vehicle_is_the_controllers() {
    let scenario = scenario(LEVEL).unwrap();
    let mut vehicle = scenario.vehicle(1).unwrap();
    while let Some(due) = vehicle.poll_timeout().filter(|due| due.as_secs_f64() < 20.0) {
        vehicle.handle_timeout(due);
        while vehicle.poll_event().is_some() {}
    }
    let (truth, pose) = (vehicle.truth(), true_pose(&vehicle));
    assert_eq!((pose.at, pose.depth_m), (truth.local, truth.depth_m));
    assert!(
        pose.north_mps > 0.5 && pose.down_mps > 0.05 && pose.pitch_deg < -1.0,
        "it dives to its line: {pose:?}"
    );
}
