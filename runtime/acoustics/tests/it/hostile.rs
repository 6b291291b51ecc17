//! Poses and settings that no sonar can work with.

use backseat_acoustics::{Pose, SideScan, SideScanSettings, SubBottom, SubBottomSettings};
use backseat_units::EastNorth;
use proptest::prelude::*;

use crate::scene::{LEVEL, SETTINGS, between, mean_squares, pose, world};
use crate::subbottom::PROFILER;

#[test]
fn settings_out_of_range_are_refused_by_name() {
    let message = |settings: SideScanSettings| settings.check().unwrap_err().to_string();
    SETTINGS.check().unwrap();
    assert_eq!(
        message(SideScanSettings {
            samples: 65_536,
            ..SETTINGS
        }),
        "sidescan.samples is 65536, expected 1 to 65535"
    );
    assert_eq!(
        message(SideScanSettings {
            range_m: f64::NAN,
            ..SETTINGS
        }),
        "sidescan.range_m is NaN, expected 1 to 2000 m"
    );
    for wrong in [
        SideScanSettings {
            frequency_hz: 9e3,
            ..SETTINGS
        },
        SideScanSettings {
            range_m: 0.0,
            ..SETTINGS
        },
        SideScanSettings {
            pulse_s: 0.0,
            ..SETTINGS
        },
        SideScanSettings { power: 1.1, ..SETTINGS },
        SideScanSettings {
            gain_db: f64::INFINITY,
            ..SETTINGS
        },
        SideScanSettings { samples: 0, ..SETTINGS },
        SideScanSettings {
            sound_speed_mps: 340.0,
            ..SETTINGS
        },
    ] {
        assert!(wrong.check().is_err(), "{wrong:?}");
    }
    PROFILER.check().unwrap();
    for wrong in [
        SubBottomSettings {
            start_hz: 1.0,
            ..PROFILER
        },
        SubBottomSettings {
            end_hz: PROFILER.start_hz,
            ..PROFILER
        },
        SubBottomSettings {
            pulse_s: f64::NAN,
            ..PROFILER
        },
        SubBottomSettings {
            power: -0.1,
            ..PROFILER
        },
        SubBottomSettings { samples: 0, ..PROFILER },
        SubBottomSettings {
            sample_interval_s: 0.0,
            ..PROFILER
        },
        SubBottomSettings {
            sound_speed_mps: f64::NAN,
            ..PROFILER
        },
    ] {
        assert!(wrong.check().is_err(), "{wrong:?}");
    }
}

#[test]
fn what_is_refused_leaves_no_samples() {
    let world = world(LEVEL, 1);
    let here = pose(&world, EastNorth::default(), 10.0);
    let mut sonar = SideScan::new(&world, 1, "test");
    let mut profiler = SubBottom::new(&world, 1, "test");
    let nan = f64::NAN;
    for pose in [
        Pose {
            at: EastNorth::new(nan, 0.0),
            ..here
        },
        Pose {
            at: EastNorth::new(0.0, 1e9),
            ..here
        },
        Pose { depth_m: nan, ..here },
        Pose {
            altitude_m: f64::INFINITY,
            ..here
        },
        Pose {
            heading_deg: nan,
            ..here
        },
        Pose {
            pitch_deg: 181.0,
            ..here
        },
        Pose { roll_deg: nan, ..here },
    ] {
        assert!(pose.check().is_err(), "{pose:?}");
        let (mut port, mut starboard, mut out) = (vec![1], vec![1], vec![[1, 1]]);
        sonar.ping(&world, &pose, &SETTINGS, 1, &mut port, &mut starboard);
        profiler.ping(&world, &pose, &PROFILER, 1, &mut out);
        assert!(port.is_empty() && starboard.is_empty() && out.is_empty());
    }
    let (mut port, mut starboard, mut out) = (vec![1], vec![1], vec![[1, 1]]);
    sonar.ping(
        &world,
        &here,
        &SideScanSettings { samples: 0, ..SETTINGS },
        1,
        &mut port,
        &mut starboard,
    );
    profiler.ping(
        &world,
        &here,
        &SubBottomSettings { samples: 0, ..PROFILER },
        1,
        &mut out,
    );
    assert!(port.is_empty() && starboard.is_empty() && out.is_empty());
}

#[test]
fn out_of_the_water_there_is_noise_alone() {
    let world = world(LEVEL, 1);
    let here = pose(&world, EastNorth::default(), 10.0);
    let mut sonar = SideScan::new(&world, 1, "test");
    let silent = SideScanSettings { power: 0.0, ..SETTINGS };
    let noise = mean_squares(&mut sonar, &world, &here, &silent, 5);
    for pose in [
        Pose {
            depth_m: -0.5,
            altitude_m: 40.5,
            ..here
        },
        Pose {
            depth_m: 41.0,
            altitude_m: -1.0,
            ..here
        },
        Pose {
            altitude_m: 0.0,
            ..here
        },
    ] {
        assert_eq!(mean_squares(&mut sonar, &world, &pose, &SETTINGS, 5), noise);
    }
    let heard = mean_squares(&mut sonar, &world, &here, &SETTINGS, 5);
    assert!(between(&heard[0], &SETTINGS, 15.0, 20.0) > 100.0 * between(&noise[0], &SETTINGS, 15.0, 20.0));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]
    #[test]
    fn nothing_panics(
        seed in 0..4u64, east in -3e3..3e3f64, north in -1e6..1e6f64, depth in -10.0..12e3f64, altitude in -1.0..300.0f64,
        heading in -3600.0..3600.0f64, pitch in -180.0..180.0f64, roll in -180.0..180.0f64,
        frequency in 1e4..2e6f64, range in 1.0..2000.0f64, pulse in 1e-6..0.1f64, power in 0.0..=1.0f64,
        gain in -120.0..120.0f64, samples in 1..=1024u32, near_bed in any::<bool>(),
    ) {
        let text = "[seabed]\nslope = [0, 0.5]\nmeander_slope = 0.5\nmeander_wavelength_m = 50\nbanks = 4\nbank_height_m = 80\n\
                    bank_radius_m = 20\n[[seabed.patches]]\ncount = 30\nbottom = \"rock\"\neast_m = [-3000, 3000]\n\
                    north_m = [-3000, 3000]\nlength_m = [1, 4000]\n[[seabed.layers]]\ndepth_m = 2\nundulation_m = 5\n\
                    [[targets]]\ncount = 300\nkind = \"wreck\"\neast_m = [-3000, 3000]\nnorth_m = [-3000, 3000]\n\
                    length_m = [0.01, 1000]\nwidth_m = [0.01, 400]\nheight_m = [0, 100]\nheading_deg = [0, 360]\n";
        let world = world(text, seed);
        let pose = Pose {
            at: EastNorth::new(east, if near_bed { north / 400.0 } else { north }),
            depth_m: depth,
            altitude_m: if near_bed { altitude / 100.0 } else { altitude },
            heading_deg: heading,
            pitch_deg: if near_bed { pitch / 20.0 } else { pitch },
            roll_deg: if near_bed { roll / 20.0 } else { roll },
        };
        let settings = SideScanSettings {
            frequency_hz: frequency, range_m: range, pulse_s: pulse, power, gain_db: gain, samples, sound_speed_mps: 1480.0,
        };
        let mut sonar = SideScan::new(&world, seed, "test").with_surface(-20.0);
        let (mut port, mut starboard) = (Vec::new(), Vec::new());
        sonar.ping(&world, &pose, &settings, samples, &mut port, &mut starboard);
        prop_assert_eq!((port.len(), starboard.len()), (samples as usize, samples as usize));
        let settings = SubBottomSettings {
            start_hz: frequency / 10.0, end_hz: frequency / 10.0 + 200.0, pulse_s: 0.02, power, gain_db: gain, samples,
            sample_interval_s: pulse.clamp(1e-6, 1e-2), sound_speed_mps: 1480.0,
        };
        let mut out = Vec::new();
        SubBottom::new(&world, seed, "test").ping(&world, &pose, &settings, samples, &mut out);
        if settings.check().is_ok() {
            prop_assert_eq!(out.len(), samples as usize);
        }
    }
}
