use super::lags::Lags;
use super::motion::Tail;
use super::sixdof::Actuators;
use super::{Demand, Throttle, Turn, Vehicle, Vertical};
use backseat_units::math::{sin, wrap_180};

/// A propeller of the body with six degrees of freedom that turns more slowly than this without its thruster stands
/// still, turns a minute. Friction holds it, which the body's own lag does not have.
const STANDS_RPM: f64 = 20.0;
/// Time constant of a propeller whose thruster is on, seconds.
const THRUSTER_TAU_S: f64 = 0.5;
/// The least fastest turn, degrees a second, in the computation of the rudder. It avoids a division by zero for a
/// vehicle without speed.
const TURN_LEAST_DPS: f64 = 0.5;

/// How the propeller of the first-order model comes to a stop.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpinDown {
    /// How long it turns on after its thruster is off, seconds, from any speed.
    lasts_s: f64,
    /// How long its thruster has been off, and how fast it turned before.
    off_s: f64,
    off_rpm: f64,
}

impl SpinDown {
    pub(super) const fn new() -> Self {
        Self {
            lasts_s: 0.0,
            off_s: 0.0,
            off_rpm: 0.0,
        }
    }

    fn rpm(&mut self, before_rpm: f64, ordered_rpm: f64, dt_s: f64) -> f64 {
        if ordered_rpm > 0.0 {
            self.off_s = 0.0;
            self.off_rpm = before_rpm + (ordered_rpm - before_rpm) * dt_s / (THRUSTER_TAU_S + dt_s);
            return self.off_rpm;
        }
        self.off_s += dt_s;
        // The steps add up to a little more or less than the time.
        if self.off_s >= self.lasts_s - 1e-9 {
            return 0.0;
        }
        self.off_rpm * (1.0 - self.off_s / self.lasts_s)
    }
}

impl Tail {
    /// A propeller without its thruster stands still when it is slow enough.
    pub(super) fn standing(mut self, driven: bool) -> Self {
        if !driven && self.now.propeller_rpm.abs() < STANDS_RPM {
            self.now.propeller_rpm = 0.0;
        }
        self
    }
}

/// The tailcone of a vehicle that does not hover: its propeller, rudder and elevator. The first-order model moves by
/// the demands themselves; its tailcone shows what a vehicle would do that moves so.
impl Vehicle {
    /// Sets how long the propeller turns on after its thruster is off, seconds.
    pub(crate) const fn spin_down_within(&mut self, lasts_s: f64) {
        self.spin_down.lasts_s = lasts_s;
    }

    /// Whether its propeller turns (SPI 7.22). A vehicle without a tailcone has none.
    pub(crate) fn is_spinning(&self) -> bool {
        self.motion.tail.is_some_and(|tail| tail.now.propeller_rpm != 0.0)
    }

    /// One step with these orders. Fins follow theirs as slowly as the turn and the pitch that they cause.
    pub(super) fn turn_tail(&mut self, ordered: Actuators, lags: &Lags) {
        let Some(tail) = &mut self.motion.tail else { return };
        tail.ordered = ordered;
        tail.now.rudder_deg += (ordered.rudder_deg - tail.now.rudder_deg) * lags.yaw;
        tail.now.stern_plane_deg += (ordered.stern_plane_deg - tail.now.stern_plane_deg) * lags.heave;
        let before_rpm = tail.now.propeller_rpm;
        tail.now.propeller_rpm = self.spin_down.rpm(before_rpm, ordered.propeller_rpm, lags.dt_s);
    }

    /// What the tailcone is ordered to for a demand. The thruster is ordered to `speed_mps`, and the vehicle pitches to
    /// `pitch_deg` to change its depth by `heave_mps`.
    pub(super) fn orders(&self, demand: &Demand, speed_mps: f64, heave_mps: f64, pitch_deg: f64) -> Actuators {
        let performance = &self.performance;
        let most_deg = performance.fin_max_deg;
        let rudder_deg = match demand.turn {
            Turn::Rudder(deg) => deg,
            Turn::Heading(heading_deg) => {
                let error_deg = wrap_180(heading_deg - self.motion.heading_deg);
                let fastest_dps = performance.turn_max_dps(self.motion.surge_mps).max(TURN_LEAST_DPS);
                most_deg * performance.yaw_gain_per_s * error_deg / fastest_dps
            }
        };
        let elevator_deg = match demand.vertical {
            Vertical::Elevator(deg) if self.climbs_freely(deg, heave_mps) => deg,
            Vertical::Depth(_) | Vertical::Altitude(_) | Vertical::Pitch(_) | Vertical::Elevator(_) => {
                most_deg * pitch_deg / performance.pitch_max_deg
            }
        };
        Actuators {
            rudder_deg: rudder_deg.clamp(-most_deg, most_deg),
            stern_plane_deg: -elevator_deg.clamp(-most_deg, most_deg),
            propeller_rpm: match demand.throttle {
                Throttle::Speed(_) => speed_mps * performance.rpm_per_mps,
                Throttle::Rpm(rpm) => rpm.clamp(0.0, performance.speed_max_mps * performance.rpm_per_mps),
            },
        }
    }

    /// Whether the vehicle follows an elevator angle. Near the surface, the seabed and its greatest depth it steers by
    /// itself.
    fn climbs_freely(&self, elevator_deg: f64, heave_mps: f64) -> bool {
        let pitch_deg = self.performance.elevator_pitch_deg(elevator_deg);
        let most_mps = self.depth_rate_max_mps();
        let free_mps = (-self.motion.surge_mps * sin(pitch_deg.to_radians())).clamp(-most_mps, most_mps);
        (free_mps - heave_mps).abs() < 1e-9
    }
}
