//! How high the sonar is above the seabed.

use std::collections::VecDeque;

use super::Sides;
use crate::track::Pose;

/// Where the altitude comes from, which the correction to ground range needs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AltitudeFrom {
    /// From navigation where it is valid, else from the first bottom return.
    #[default]
    Auto,
    /// From navigation only (record 3100).
    Navigation,
    /// From the first bottom return only.
    Bottom,
}

/// Gives each ping its altitude, in the order of the recording.
#[derive(Debug)]
pub(crate) struct Altimeter {
    from: AltitudeFrom,
    recent: VecDeque<f64>,
    sums: Vec<f64>,
}

/// The bottom is the median of so many detections.
const DETECTIONS: usize = 5;
/// Echoes nearer than this are the sonar's own pulse, metres.
const BLANKED_M: f64 = 1.0;
/// How far before and behind the bottom echoes are compared, metres.
const WINDOW_M: f64 = 0.5;
/// How much stronger they are behind it, at least.
const CONTRAST: f64 = 3.0;

impl Altimeter {
    pub(crate) const fn new(from: AltitudeFrom) -> Self {
        Self {
            from,
            recent: VecDeque::new(),
            sums: Vec::new(),
        }
    }

    /// The altitude of the next ping, metres.
    pub(crate) fn altitude_m(&mut self, sides: &Sides, pose: &Pose) -> Option<f64> {
        match self.from {
            AltitudeFrom::Navigation => pose.altitude_m,
            AltitudeFrom::Auto if pose.altitude_m.is_some() => pose.altitude_m,
            AltitudeFrom::Auto | AltitudeFrom::Bottom => self.bottom_m(sides),
        }
    }

    fn bottom_m(&mut self, sides: &Sides) -> Option<f64> {
        if let Some(detected) = detect(sides, &mut self.sums) {
            self.recent.push_back(detected);
            if self.recent.len() > DETECTIONS {
                self.recent.pop_front();
            }
        }
        let mut sorted: Vec<f64> = self.recent.iter().copied().collect();
        sorted.sort_by(f64::total_cmp);
        sorted.get(sorted.len() / 2).copied()
    }
}

/// The range at which both sides together rise most steeply from the quiet of the water to the echo of the seabed.
fn detect(sides: &Sides, sums: &mut Vec<f64>) -> Option<f64> {
    let [port, starboard] = sides;
    let side = if port.amplitudes.is_empty() { starboard } else { port };
    if side.ground || side.amplitudes.is_empty() {
        return None;
    }
    sums.clear();
    sums.push(0.0);
    let mut sum = 0.0;
    for (index, amplitude) in side.amplitudes.iter().enumerate() {
        let other = starboard.amplitudes.get(index).copied().unwrap_or(0.0);
        sum += f64::from(*amplitude) + f64::from(other);
        sums.push(sum);
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "small and positive"
    )]
    let samples = |metres: f64| (metres / side.step_m).ceil().clamp(0.0, 1e9) as usize;
    let window = samples(WINDOW_M).max(3);
    let blanked = samples((BLANKED_M - side.first_m).max(0.0));
    let count = side.amplitudes.len();
    let mut best = (CONTRAST, None);
    for at in blanked + window..count.saturating_sub(window) {
        let before = sums[at] - sums[at - window];
        let behind = sums[at + window] - sums[at];
        // One step of the converter a sample keeps silence from being infinitely quiet.
        #[expect(clippy::cast_precision_loss, reason = "a small number of samples")]
        let contrast = behind / (before + window as f64);
        if contrast > best.0 {
            best = (contrast, Some(at));
        }
    }
    #[expect(clippy::cast_precision_loss, reason = "below 2^32 samples")]
    best.1.map(|at| side.first_m + at as f64 * side.step_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sidescan::Side;

    fn sides(bottom: usize, water: f32, seabed: f32) -> Sides {
        let amplitudes: Vec<f32> = (0..400)
            .map(|index| {
                if index < bottom {
                    water + (index % 7) as f32
                } else {
                    seabed
                }
            })
            .collect();
        let side = Side {
            amplitudes,
            first_m: 0.0,
            step_m: 0.05,
            ground: false,
        };
        [side.clone(), side]
    }

    #[test]
    fn the_first_bottom_return_is_found_and_outliers_are_not_believed() {
        let mut altimeter = Altimeter::new(AltitudeFrom::Auto);
        for _ in 0..3 {
            assert_eq!(
                altimeter.altitude_m(&sides(160, 20.0, 3000.0), &Pose::default()),
                Some(8.0)
            );
        }
        assert_eq!(
            altimeter.altitude_m(&sides(300, 20.0, 3000.0), &Pose::default()),
            Some(8.0)
        );
        // No bottom to be seen: the last ones serve.
        assert_eq!(
            altimeter.altitude_m(&sides(160, 20.0, 30.0), &Pose::default()),
            Some(8.0)
        );
    }

    #[test]
    fn navigation_is_preferred_where_it_is_valid() {
        let pose = Pose {
            altitude_m: Some(9.0),
            ..Pose::default()
        };
        let ping = sides(160, 20.0, 3000.0);
        assert_eq!(Altimeter::new(AltitudeFrom::Auto).altitude_m(&ping, &pose), Some(9.0));
        assert_eq!(Altimeter::new(AltitudeFrom::Bottom).altitude_m(&ping, &pose), Some(8.0));
        assert_eq!(
            Altimeter::new(AltitudeFrom::Navigation).altitude_m(&ping, &Pose::default()),
            None
        );
        assert_eq!(
            Altimeter::new(AltitudeFrom::Bottom).altitude_m(&sides(0, 20.0, 20.0), &pose),
            None
        );
    }
}
