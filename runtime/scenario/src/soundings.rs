use core::borrow::Borrow;

use backseat_acoustics::{Pose, SideScan, SideScanSettings, SubBottom, SubBottomSettings};
use backseat_plc::{Ping, SensorKind, Sonar};
use backseat_world::World;

/// Gain of the sidescan's receiver at gain step 0, decibels on top of the gain that grows with time. It puts the seabed,
/// from mud to rock, at some hundred to some ten thousand of the 65535 steps of the converter.
const SIDE_SCAN_GAIN_DB: f64 = 8.0;
/// Gain of the sub-bottom profiler's receiver at gain step 0, decibels. It puts the echo of a bed of sand at 25000 of the
/// 32767 steps of the converter 3 m above it, and at 2600 30 m above it; the noise is at 1 to 2 steps.
const SUB_BOTTOM_GAIN_DB: f64 = -6.0;
/// What one gain step adds, decibels.
const STEP_DB: f64 = 1.0;
/// The greatest gain that the acoustics take, decibels. A step beyond it changes nothing.
const GAIN_MAX_DB: f64 = 120.0;

/// What the payload controller's sonars hear in a world.
///
/// The world may be owned, shared or borrowed. Each sensor has its own noise, from the seed and the sensor's name. A ping
/// is a function of the world, the seed, the sensor and the [`Ping`], so a ping that is left out changes no other. A ping
/// that the acoustics refuse, such as one without a place, is silence.
///
/// | setting of the ping | what it does |
/// |---|---|
/// | range, speed of sound, samples | a sample stands for what arrives from its time until that of the next |
/// | pulse | the middle of its sweep is the frequency; its length after compression is one over its bandwidth, and its own length if that is less |
/// | power | the source level falls by 10 log of the part of full power; at 0 there is noise alone |
/// | gain | 1 dB a step for echoes and noise alike, up to what the converter holds |
///
/// The altitude is that above the seabed at the time of the ping, with the tide.
#[derive(Clone, Debug)]
pub struct Soundings<W> {
    world: W,
    low: SideScan,
    high: SideScan,
    profiler: SubBottom,
}

impl<W: Borrow<World>> Soundings<W> {
    /// The sonars in this world, whose noise the seed draws.
    #[must_use]
    pub fn new(world: W, seed: u64) -> Self {
        let sea = world.borrow();
        Self {
            low: SideScan::new(sea, seed, "plc low"),
            high: SideScan::new(sea, seed, "plc high"),
            profiler: SubBottom::new(sea, seed, "plc"),
            world,
        }
    }

    fn pose(&self, ping: &Ping) -> Pose {
        let pose = &ping.pose;
        Pose {
            at: pose.at,
            depth_m: pose.depth_m,
            altitude_m: self.world.borrow().water_depth_at_m(pose.at, ping.time) - pose.depth_m,
            heading_deg: pose.heading_deg,
            pitch_deg: pose.pitch_deg,
            roll_deg: pose.roll_deg,
        }
    }
}

impl<W: Borrow<World>> Sonar for Soundings<W> {
    fn side_scan(&mut self, sensor: SensorKind, ping: &Ping, port: &mut Vec<u16>, starboard: &mut Vec<u16>) {
        let pose = self.pose(ping);
        let sonar = match sensor {
            SensorKind::SidescanLow => &mut self.low,
            SensorKind::SidescanHigh => &mut self.high,
            SensorKind::SubBottom | SensorKind::Bluefin => return,
        };
        let settings = SideScanSettings {
            frequency_hz: 0.5 * (ping.pulse.start_hz + ping.pulse.end_hz),
            range_m: 0.5 * ping.sound_speed_mps * interval_s(ping) * ping.samples as f64,
            pulse_s: compressed_s(ping),
            power: ping.power_percent * 0.01,
            gain_db: gain_db(SIDE_SCAN_GAIN_DB, ping),
            samples: samples(ping),
            sound_speed_mps: ping.sound_speed_mps,
        };
        sonar.ping(self.world.borrow(), &pose, &settings, ping.number, port, starboard);
    }

    fn sub_bottom(&mut self, ping: &Ping, out: &mut Vec<[i16; 2]>) {
        let pose = self.pose(ping);
        let (start_hz, end_hz) = (ping.pulse.start_hz, ping.pulse.end_hz);
        let settings = SubBottomSettings {
            // A sweep that falls is heard like one that rises.
            start_hz: start_hz.min(end_hz),
            end_hz: start_hz.max(end_hz),
            pulse_s: ping.pulse.length_s,
            power: ping.power_percent * 0.01,
            gain_db: gain_db(SUB_BOTTOM_GAIN_DB, ping),
            samples: samples(ping),
            sample_interval_s: interval_s(ping),
            sound_speed_mps: ping.sound_speed_mps,
        };
        self.profiler
            .ping(self.world.borrow(), &pose, &settings, ping.number, out);
    }
}

fn interval_s(ping: &Ping) -> f64 {
    f64::from(ping.sample_interval_us) * 1e-6
}

/// More samples than a number holds are refused by the acoustics.
fn samples(ping: &Ping) -> u32 {
    u32::try_from(ping.samples).unwrap_or(u32::MAX)
}

/// The length of the pulse after compression: one over its bandwidth. A pulse without a sweep stays as long as it is.
fn compressed_s(ping: &Ping) -> f64 {
    let bandwidth_hz = (ping.pulse.end_hz - ping.pulse.start_hz).abs();
    if bandwidth_hz * ping.pulse.length_s > 1.0 {
        1.0 / bandwidth_hz
    } else {
        ping.pulse.length_s
    }
}

fn gain_db(base_db: f64, ping: &Ping) -> f64 {
    (base_db + STEP_DB * f64::from(ping.gain_steps)).min(GAIN_MAX_DB)
}
