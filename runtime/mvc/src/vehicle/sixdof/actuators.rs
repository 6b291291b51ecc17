use backseat_units::math::exp;

use super::AT_REST;
use super::coefficients::{FIN_LAG_S, FIN_MAX_DEG, FIN_RATE_MAX_DPS, PROPELLER_LAG_S, PROPELLER_MAX_RPM};

/// The orders to the tail, or its state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Actuators {
    /// Degrees, positive turns the vehicle to starboard; within ±15.
    pub(crate) rudder_deg: f64,
    /// Degrees, positive pitches the nose down; within ±15. The elevator of SPI has the opposite sign.
    pub(crate) stern_plane_deg: f64,
    /// Turns a minute, within ±1525; negative brakes.
    pub(crate) propeller_rpm: f64,
}

impl Actuators {
    /// The elevator with SPI's sign, degrees, positive pitches the nose up (SPI 6.12).
    #[must_use]
    pub(crate) fn elevator_deg(&self) -> f64 {
        -self.stern_plane_deg
    }

    /// Clamps to what the tail can do; NaN becomes zero.
    #[must_use]
    pub(crate) fn limited(self) -> Self {
        Self {
            rudder_deg: limited(self.rudder_deg, FIN_MAX_DEG),
            stern_plane_deg: limited(self.stern_plane_deg, FIN_MAX_DEG),
            propeller_rpm: limited(self.propeller_rpm, PROPELLER_MAX_RPM),
        }
    }
}

fn limited(value: f64, most: f64) -> f64 {
    if value.is_nan() { 0.0 } else { value.clamp(-most, most) }
}

/// Fins and propeller. Each follows its order with a first-order lag, and a fin turns no faster than its servo.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tail {
    pub(super) now: Actuators,
    /// The shares of the remaining difference that a step of `step_s` removes. They are stored because all steps have
    /// the same length.
    step_s: f64,
    fin_share: f64,
    propeller_share: f64,
}

impl Tail {
    pub(super) const fn now(&self) -> Actuators {
        self.now
    }

    /// Moves by a step. Returns the mean over the step.
    pub(super) fn step(&mut self, order: Actuators, dt_s: f64) -> Actuators {
        if dt_s.to_bits() != self.step_s.to_bits() {
            self.step_s = dt_s;
            self.fin_share = 1.0 - exp(-dt_s / FIN_LAG_S);
            self.propeller_share = 1.0 - exp(-dt_s / PROPELLER_LAG_S);
        }
        let order = order.limited();
        let before = self.now;
        let fin = |now: f64, order: f64| {
            let most = FIN_RATE_MAX_DPS * dt_s;
            now + ((order - now) * self.fin_share).clamp(-most, most)
        };
        self.now = Actuators {
            rudder_deg: fin(before.rudder_deg, order.rudder_deg),
            stern_plane_deg: fin(before.stern_plane_deg, order.stern_plane_deg),
            propeller_rpm: before.propeller_rpm + (order.propeller_rpm - before.propeller_rpm) * self.propeller_share,
        };
        for value in [
            &mut self.now.rudder_deg,
            &mut self.now.stern_plane_deg,
            &mut self.now.propeller_rpm,
        ] {
            if value.abs() < AT_REST {
                *value = 0.0;
            }
        }
        Actuators {
            rudder_deg: 0.5 * (before.rudder_deg + self.now.rudder_deg),
            stern_plane_deg: 0.5 * (before.stern_plane_deg + self.now.stern_plane_deg),
            propeller_rpm: 0.5 * (before.propeller_rpm + self.now.propeller_rpm),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_beyond_the_limits_are_clamped_and_lag() {
        let mut tail = Tail::default();
        let order = Actuators {
            rudder_deg: 90.0,
            stern_plane_deg: f64::NAN,
            propeller_rpm: f64::INFINITY,
        };
        tail.step(order, 0.02);
        assert!(tail.now().rudder_deg <= FIN_RATE_MAX_DPS * 0.02 + 1e-12);
        for _ in 0..49 {
            tail.step(order, 0.02);
        }
        // One second is one time constant of the propeller and ten of the fins.
        assert!((tail.now().propeller_rpm - 1525.0 * (1.0 - exp(-1.0))).abs() < 1e-6);
        assert!((tail.now().rudder_deg - 15.0).abs() < 0.01);
        assert_eq!(tail.now().stern_plane_deg, 0.0);
    }
}
