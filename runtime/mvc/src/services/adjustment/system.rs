use backseat_world::Stream;

use super::AdjustmentKind;
use crate::file::AdjustmentConfig;

/// The trim and buoyancy systems: how far the vehicle is from level trim and neutral buoyancy, and how far the systems
/// have moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct System {
    pub(super) pitch_deg: f64,
    pub(super) roll_deg: f64,
    /// Positive up.
    pub(super) buoyancy_n: f64,
    /// How far each system has moved from its position at the start.
    pitch_moved_deg: f64,
    roll_moved_deg: f64,
    buoyancy_moved_n: f64,
}

impl System {
    pub(super) fn new(config: &AdjustmentConfig, seed: u64) -> Self {
        let mut stream = Stream::new(seed, "trim and buoyancy");
        Self {
            pitch_deg: config.trim_pitch_deg.draw(&mut stream),
            roll_deg: config.trim_roll_deg.draw(&mut stream),
            buoyancy_n: config.buoyancy_n.draw(&mut stream),
            pitch_moved_deg: 0.0,
            roll_moved_deg: 0.0,
            buoyancy_moved_n: 0.0,
        }
    }

    /// Whether nothing is left to adjust.
    pub(super) fn is_done(&self, config: &AdjustmentConfig, kind: AdjustmentKind) -> bool {
        match kind {
            AdjustmentKind::Trim => {
                self.pitch_deg.abs() <= config.trim_tolerance_deg && self.roll_deg.abs() <= config.trim_tolerance_deg
            }
            AdjustmentKind::Buoyancy => self.buoyancy_n.abs() <= config.buoyancy_tolerance_n,
        }
    }

    /// Works for a number of seconds. Returns false if the systems cannot move any further.
    pub(super) fn work(&mut self, config: &AdjustmentConfig, kind: AdjustmentKind, seconds: f64) -> bool {
        match kind {
            AdjustmentKind::Trim => {
                let (most, range) = (config.trim_rate_dps * seconds, config.trim_range_deg);
                let pitch = towards_zero(&mut self.pitch_deg, &mut self.pitch_moved_deg, most, range);
                let roll = towards_zero(&mut self.roll_deg, &mut self.roll_moved_deg, most, range);
                pitch != 0.0 || roll != 0.0
            }
            AdjustmentKind::Buoyancy => {
                let (most, range) = (config.buoyancy_rate_n_per_s * seconds, config.buoyancy_range_n);
                let moved = towards_zero(&mut self.buoyancy_n, &mut self.buoyancy_moved_n, most, range);
                self.pitch_deg += moved * config.buoyancy_pitch_deg_per_n;
                moved != 0.0
            }
        }
    }
}

/// Moves a value towards zero as far as rate and range allow. Returns how far it moved.
fn towards_zero(value: &mut f64, moved: &mut f64, most: f64, range: f64) -> f64 {
    let wanted = (-*value).clamp(-most, most);
    let step = (*moved + wanted).clamp(-range, range) - *moved;
    *value += step;
    *moved += step;
    step
}
