//! A vehicle that flies straight over a simulated seabed, and what its sidescan hears.

use backseat_acoustics::{Pose as SonarPose, SideScan, SideScanSettings};
use backseat_sdk::sonar::{Contact, Detector, DetectorSettings, Look, Pose, Side, Strip};
use backseat_sdk::units::math::{sin, sin_cos};
use backseat_sdk::units::{EastNorth, LocalFrame, Position};
use backseat_world::{Stream, World};

/// 1.5 m/s at 8 pings a second.
pub(crate) const STEP_M: f64 = 0.1875;
pub(crate) const RANGE_M: f64 = 60.0;
/// A sidescan of 410 kHz with the compressed pulse of a sweep of 40 kHz.
pub(crate) const SETTINGS: SideScanSettings = SideScanSettings {
    frequency_hz: 410e3,
    range_m: RANGE_M,
    pulse_s: 25e-6,
    power: 1.0,
    gain_db: 0.0,
    samples: 2000,
    sound_speed_mps: 1500.0,
};
/// Samples of a channel after decimation, each the mean of two.
const SAMPLES: usize = 1000;

/// A level seabed 40 m deep of a class, with the given text after it.
pub(crate) fn level(bottom: &str, text: &str, seed: u64) -> World {
    world(
        &format!("[seabed]\ndepth_m = 40\nslope = 0\nmeanders = 0\nbottom = \"{bottom}\"\n{text}"),
        seed,
    )
}

pub(crate) fn world(text: &str, seed: u64) -> World {
    let text = format!("[origin]\nlatitude_deg = 42.3\nlongitude_deg = -70.9\n{text}");
    World::new(&toml::from_str(&text).expect("it is a world"), seed).expect("it can be drawn")
}

/// A line of pings.
pub(crate) struct Line<'a> {
    pub(crate) world: &'a World,
    pub(crate) from: EastNorth,
    pub(crate) heading_deg: f64,
    pub(crate) pings: u32,
    pub(crate) altitude_m: f64,
    /// The seabed's own pattern: a factor on amplitudes by place over the ground. The sea has no small relief, so ripples
    /// are put on here.
    pub(crate) pattern: fn(EastNorth) -> f64,
    pub(crate) seed: u64,
}

/// Ripples: the amplitude swings by a factor of 1.6 up and down over 1.8 m, with crests that wander.
pub(crate) fn ripples(at: EastNorth) -> f64 {
    let across = at.east_m * 0.9 + at.north_m * 0.44;
    let along = at.north_m * 0.9 - at.east_m * 0.44;
    let phase = across * (core::f64::consts::TAU / 1.8) + 1.5 * sin(along / 7.0) + sin(across / 23.0);
    1.0 + 0.45 * sin(phase)
}

pub(crate) fn even(_: EastNorth) -> f64 {
    1.0
}

impl Line<'_> {
    /// Flies it, with a heading, a roll and an altitude that sway, and shows each ping.
    pub(crate) fn fly(&self, mut show: impl FnMut(&Look<'_>)) {
        let mut sonar = SideScan::new(self.world, self.seed, "high");
        let frame = LocalFrame::new(Position::from_deg(42.3, -70.9).expect("a position"));
        let mut noise = Stream::new(self.seed, "navigation of the test");
        let (mut port, mut starboard) = (Vec::new(), Vec::new());
        let has_pattern = (self.pattern)(EastNorth::new(0.3, 0.2)) != 1.0;
        for ping in 0..self.pings {
            let way_m = STEP_M * f64::from(ping);
            let at = self.from.offset(self.heading_deg, way_m);
            let altitude_m = self.altitude_m + 0.5 * sin(way_m / 40.0);
            let heading_deg = self.heading_deg + 0.7 * sin(way_m / 9.0);
            let pose = SonarPose {
                at,
                depth_m: self.world.water_depth_m(at) - altitude_m,
                altitude_m,
                heading_deg,
                pitch_deg: 0.8 * sin(way_m / 11.0),
                roll_deg: 2.0 * sin(way_m / 6.0),
            };
            sonar.ping(self.world, &pose, &SETTINGS, ping, &mut port, &mut starboard);
            let position = frame.to_position(at);
            let seen = Pose {
                at,
                latitude_deg: position.latitude.as_deg(),
                longitude_deg: position.longitude.as_deg(),
                heading_deg: heading_deg + 0.1 * noise.gaussian(),
                altitude_m: Some(altitude_m + 0.05 * noise.gaussian()),
            };
            let sides = [(&port, Side::Port), (&starboard, Side::Starboard)].map(|(samples, side)| {
                let sign = side.abeam_deg() / 90.0;
                let (sin_heading, cos_heading) = sin_cos(heading_deg.to_radians());
                let abeam = EastNorth::new(sign * cos_heading, -sign * sin_heading);
                let each = samples.len() / SAMPLES;
                (0..SAMPLES)
                    .map(|bin| {
                        let bin_of = &samples[bin * each..(bin + 1) * each];
                        let sum: f64 = bin_of.iter().map(|sample| f64::from(*sample)).sum();
                        let factor = if has_pattern {
                            let slant_m = (bin as f64 + 0.5) * RANGE_M / SAMPLES as f64;
                            let ground_m = (slant_m * slant_m - altitude_m * altitude_m).max(0.0).sqrt();
                            (self.pattern)(at + abeam * ground_m)
                        } else {
                            1.0
                        };
                        (factor * sum / each as f64) as f32
                    })
                    .collect::<Vec<f32>>()
            });
            show(&Look {
                pose: seen,
                port: Some(Strip::along_slant(&sides[0], RANGE_M)),
                starboard: Some(Strip::along_slant(&sides[1], RANGE_M)),
            });
        }
    }

    /// The contacts that a detector makes of it.
    pub(crate) fn contacts(&self, settings: DetectorSettings) -> Vec<Contact> {
        let mut detector = Detector::new(settings).expect("valid settings");
        let mut contacts = Vec::new();
        self.fly(|look| contacts.extend(detector.look(look)));
        contacts.extend(detector.end());
        contacts
    }
}
