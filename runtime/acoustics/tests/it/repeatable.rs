//! The same seed gives the same bytes, in whatever order pings come.

use backseat_acoustics::{Pose, SideScan, SideScanSettings, SubBottom, SubBottomSettings};
use backseat_units::EastNorth;
use backseat_world::World;
use sha2::{Digest as _, Sha256};

use crate::scene::{SETTINGS, pose, world};
use crate::subbottom::PROFILER;

const TEXT: &str = "[seabed]\nbanks = 2\n[[seabed.patches]]\ncount = 8\nbottom = \"rock\"\neast_m = [-100, 100]\n\
                    north_m = [-100, 100]\n[[seabed.layers]]\ndepth_m = 3\n[[targets]]\ncount = 200\nkind = \"rock\"\n\
                    east_m = [-100, 100]\nnorth_m = [-100, 100]\nlength_m = [0.5, 4]\nheading_deg = [0, 360]\n[[targets]]\nkind = \"wreck\"\neast_m = 20\nnorth_m = 10\nlength_m = 30\n\
                    width_m = 6\nheight_m = 3\nheading_deg = 40\n[[targets]]\ncount = 9\nkind = \"cylinder\"\neast_m = [-50, 50]\n\
                    north_m = [-50, 50]\nlength_m = 8\n[[targets]]\ncount = 9\nkind = \"box\"\neast_m = [-50, 50]\n\
                    north_m = [-50, 50]\nlength_m = 8\nheading_deg = [0, 90]\n[[targets]]\ncount = 9\nkind = \"point\"\n\
                    east_m = [-50, 50]\nnorth_m = [-50, 50]\n";

fn pose_of(world: &World, ping: u32) -> Pose {
    let step = f64::from(ping);
    Pose {
        heading_deg: 7.0 * step,
        pitch_deg: 3.0 - 0.3 * step,
        roll_deg: 0.4 * step - 4.0,
        ..pose(world, EastNorth::new(3.0 * step - 30.0, 20.0 - 2.0 * step), 8.0)
    }
}

fn hear(world: &World, sonar: &mut SideScan, settings: &SideScanSettings, ping: u32) -> [Vec<u16>; 2] {
    let (mut port, mut starboard) = (vec![9; 3], Vec::new());
    sonar.ping(world, &pose_of(world, ping), settings, ping, &mut port, &mut starboard);
    [port, starboard]
}

#[test]
fn a_ping_does_not_depend_on_those_before_it() {
    let world = world(TEXT, 4);
    let other_settings = SideScanSettings {
        range_m: 30.0,
        samples: 64,
        ..SETTINGS
    };
    let mut forwards = SideScan::new(&world, 4, "high");
    let all: Vec<_> = (0..20)
        .map(|ping| hear(&world, &mut forwards, &SETTINGS, ping))
        .collect();
    let mut backwards = SideScan::new(&world, 4, "high");
    for ping in (0..20).rev().step_by(3) {
        assert_eq!(hear(&world, &mut backwards, &SETTINGS, ping), all[ping as usize]);
        hear(&world, &mut backwards, &other_settings, ping);
    }
    assert_ne!(all[0], all[1]);
    let mut named = SideScan::new(&world, 4, "low");
    assert_ne!(hear(&world, &mut named, &SETTINGS, 3), all[3]);
    let mut seeded = SideScan::new(&world, 5, "high");
    assert_ne!(hear(&world, &mut seeded, &SETTINGS, 3), all[3]);
}

#[test]
fn a_profile_does_not_depend_on_those_before_it() {
    let world = world(TEXT, 4);
    let hear = |sonar: &mut SubBottom, settings: &SubBottomSettings, ping: u32| {
        let mut out = vec![[1, 2]];
        sonar.ping(&world, &pose_of(&world, ping), settings, ping, &mut out);
        out
    };
    let mut forwards = SubBottom::new(&world, 4, "sbp");
    let all: Vec<_> = (0..10).map(|ping| hear(&mut forwards, &PROFILER, ping)).collect();
    let mut backwards = SubBottom::new(&world, 4, "sbp");
    for ping in (0..10).rev().step_by(2) {
        assert_eq!(hear(&mut backwards, &PROFILER, ping), all[ping as usize]);
        hear(&mut backwards, &SubBottomSettings { samples: 9, ..PROFILER }, ping);
    }
    assert_ne!(all[0], all[1]);
}

/// Recorded runs depend on these.
#[test]
fn the_samples_never_change() {
    let world = world(TEXT, 4);
    let mut digest = Sha256::new();
    let (mut sonar, mut profiler) = (SideScan::new(&world, 4, "high"), SubBottom::new(&world, 4, "sbp"));
    for ping in 0..20 {
        for side in hear(&world, &mut sonar, &SETTINGS, ping) {
            side.iter().for_each(|sample| digest.update(sample.to_le_bytes()));
        }
        let mut out = Vec::new();
        profiler.ping(&world, &pose_of(&world, ping), &PROFILER, ping, &mut out);
        out.iter()
            .flatten()
            .for_each(|sample| digest.update(sample.to_le_bytes()));
    }
    let text: String = digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(text, "2deb46c80c29eb06b86015d80759dbff11c5249436ed967bc7c95e08d65edc9d");
}
