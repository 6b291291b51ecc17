//! Missions without faults: the safety monitor must not find navigation untrue that is within its normal accuracy
//! (safety requirement 024).

use backseat_core::IntegrityLimits;
use backseat_units::Timestamp;

use crate::dice::Dice;
use crate::flight::Flight;
use crate::plan::Plan;
use crate::scenario::Scenario;

/// GPS is received down to this depth, metres. A jump reported in shallower water is due to a GPS fix.
const SURFACED_M: f64 = 3.0;
/// A jump is reported within this time, seconds.
const TOLD_WITHIN_S: f64 = 5.0;

/// A report that navigation is untrue, although it is not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Alarm {
    /// The time.
    pub at: Timestamp,
    /// The monitor's message.
    pub text: String,
}

impl Plan {
    /// A mission without faults and with a drawn accuracy of navigation: the mock's own errors or three times as much,
    /// GPS that is up to 200 m away from dead reckoning, bottom lock that is often lost or never there, 1 to 10 steps a
    /// second, any class, a fifth of the torpedoes as a body with six degrees of freedom. The limits of the integrity
    /// checks are `times` the default ones. A value below 1 shows how close to the limits a healthy vehicle comes.
    #[must_use]
    pub fn draw_clean(seed: u64, times: f64) -> Self {
        let mut scenario = Scenario::draw(seed);
        let mut dice = Dice::new(seed, "clean");
        let sixdof = !scenario.hovering && dice.chance(0.2);
        let hz = dice.one(&[1, 2, 4, 5, 10]);
        scenario.world = scenario
            .world
            .replacen("[mission]\n", &format!("{}[mission]\n", sensors(&mut dice)), 1);
        scenario.world = per_line(&scenario.world, |line| match line.split_once(" = ") {
            Some(("tick_hz", _)) if sixdof => Some(format!("tick_hz = {hz}\nmodel = \"6-dof\"")),
            Some(("tick_hz", _)) => Some(format!("tick_hz = {hz}")),
            // A command that is answered within 2 s needs steps of less than a second.
            Some(("pending_s", _)) => Some("pending_s = [0.05, 0.9]".to_owned()),
            _ => None,
        });
        scenario.world += "\n[silence]\nsettle_s = 0.5\n";
        // One solution a second must not count as stale here.
        scenario.mission = per_line(&scenario.mission, |line| {
            line.starts_with("navigation_age_max_s")
                .then(|| "navigation_age_max_s = 2.5".to_owned())
        });
        if (times - 1.0).abs() > f64::EPSILON {
            scenario.mission += &integrity(times);
        }
        Self {
            seed,
            scenario,
            faults: Vec::new(),
            until: None,
        }
    }
}

impl Flight {
    /// The reports of untrue navigation in a flight of [`Plan::draw_clean`], without jumps at the surface, which are
    /// due to GPS.
    pub fn alarms(&self) -> impl Iterator<Item = Alarm> + '_ {
        self.navigation
            .iter()
            .filter(|(at, text)| !(text.contains("jumped") && self.surfaced_at(*at)))
            .map(|(at, text)| Alarm {
                at: *at,
                text: text.clone(),
            })
    }

    fn surfaced_at(&self, at: Timestamp) -> bool {
        self.depths_m.iter().any(|(sampled, depth_m)| {
            (sampled.as_secs_f64() - at.as_secs_f64()).abs() <= TOLD_WITHIN_S && *depth_m <= SURFACED_M
        })
    }
}

/// The table `[sensors]`, with the mock's own errors of navigation or three times as much.
fn sensors(dice: &mut Dice) -> String {
    let times = dice.one(&[1.0, 3.0]);
    let mut text = String::from("[sensors]\n");
    for (key, own) in [
        ("position_noise_m", 0.03),
        ("position_drift_m_per_sqrt_h", 3.5),
        ("depth_noise_m", 0.01),
        ("heading_noise_deg", 0.05),
        ("attitude_noise_deg", 0.05),
        ("velocity_noise_mps", 0.005),
        ("altitude_noise_m", 0.05),
    ] {
        text += &format!("{key} = {:?}\n", times * own);
    }
    text += &format!("altitude_dropouts_per_h = {:?}\n", dice.one(&[4.0, 4.0, 60.0, 300.0]));
    text += &format!("altitude_dropout_s = {:?}\n", dice.one(&[0.8, 5.0, 40.0]));
    text += &format!("altitude_range_m = {:?}\n", dice.one(&[200.0, 200.0, 45.0, 10.0]));
    let without_lock = dice.one(&["inertial", "water"]);
    text += &format!("\n[sensors.ins]\nwithout_lock = \"{without_lock}\"\n");
    for (key, own) in [("heading_bias_deg", 0.03), ("velocity_walk_mps_per_sqrt_s", 0.003)] {
        text += &format!("{key} = {:?}\n", times * own);
    }
    text += "\n[sensors.dvl]\n";
    for (key, own) in [
        ("scale_error", 0.0005),
        ("misalignment_deg", 0.03),
        ("velocity_noise_mps", 0.003),
        ("range_noise_m", 0.05),
        ("beam_loss", 0.001),
    ] {
        text += &format!("{key} = {:?}\n", times * own);
    }
    // Nearly all of a normal distribution is within three standard deviations.
    let error_m = dice.one(&[0.7, 0.7 * times, 5.0, 20.0, 66.0]);
    text + &format!(
        "\n[sensors.gps]\nerror_m = {error_m:?}\nacquisition_s = {:?}\nperiod_s = {:?}\n\n",
        dice.figure(1.0, 20.0),
        dice.one(&[0.2, 1.0, 1.0, 5.0])
    )
}

/// The limits of differences between navigation's values, as multiples of the default ones.
fn integrity(times: f64) -> String {
    let own = IntegrityLimits::default();
    let mut text = String::from("\n[limits.integrity]\n");
    for (key, value) in [
        ("position_step_m", own.position_step_m),
        ("position_drift_mps", own.position_drift_mps),
        ("depth_rate_max_mps", own.depth_rate_max_mps),
        ("depth_step_m", own.depth_step_m),
        ("depth_drift_mps", own.depth_drift_mps),
        ("heading_step_deg", own.heading_step_deg),
        ("heading_drift_dps", own.heading_drift_dps),
        ("frozen_s", own.frozen_s),
        ("velocity_gap_s", own.velocity_gap_s),
        ("seabed_step_m", own.seabed_step_m),
    ] {
        text += &format!("{key} = {:?}\n", times * value);
    }
    text
}

/// A text with some of its lines replaced.
fn per_line(text: &str, with: impl Fn(&str) -> Option<String>) -> String {
    let lines = text
        .lines()
        .map(|line| with(line).unwrap_or_else(|| line.to_owned()) + "\n");
    lines.collect()
}

#[cfg(test)]
mod tests {
    use backseat_mvc::WorldFile;

    use super::*;

    #[test]
    fn every_clean_seed_draws_a_world_that_can_be() {
        let mut bodies = 0;
        for seed in 0..300 {
            let scenario = Plan::draw_clean(seed, 0.5).scenario;
            let world = WorldFile::from_toml(&scenario.world);
            assert!(world.is_ok(), "seed {seed}: {}\n{}", world.unwrap_err(), scenario.world);
            assert!(
                scenario.mission.contains("navigation_age_max_s = 2.5") && scenario.world.contains("[sensors.gps]")
            );
            bodies += u32::from(scenario.world.contains("6-dof"));
        }
        assert!((30..80).contains(&bodies), "{bodies}");
    }
}
