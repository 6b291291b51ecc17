use crate::vehicle::performance::Performance;

/// Time constant of the rates of pitch and roll, seconds.
const ATTITUDE_TAU_S: f64 = 0.5;
/// Time constant of the roll, seconds.
const ROLL_TAU_S: f64 = 1.0;
/// The greatest speed towards the surface or the bed for each metre that is left, per second. It stops half a metre a
/// second within a metre, with at most a quarter of a metre a second squared.
const STOP_GAIN_PER_S: f64 = 0.5;
/// The greatest stopping gain per step. With a greater one, the vehicle would overshoot.
const STOP_GAIN_PER_STEP: f64 = 0.34;

/// The time constants as shares of one step. They are stored because all steps have the same length.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lags {
    pub(super) dt_s: f64,
    /// The share of the remaining difference that a first-order lag removes in a step, for the speed, the turn, the
    /// depth rate, and the rates of pitch and roll.
    pub(super) surge: f64,
    pub(super) yaw: f64,
    pub(super) heave: f64,
    pub(super) attitude: f64,
    /// Demanded rate per degree of error in pitch or in roll, per second.
    pub(super) pitch_per_s: f64,
    pub(super) roll_per_s: f64,
    /// Number of steps until a pitch is reached.
    pub(super) pitch_steps: f64,
    pub(super) stop_per_s: f64,
}

impl Lags {
    pub(super) fn of(performance: &Performance, dt_s: f64) -> Self {
        let share = |tau_s: f64| dt_s / (tau_s + dt_s);
        Self {
            dt_s,
            surge: share(performance.surge_tau_s),
            yaw: share(performance.yaw_tau_s),
            heave: share(performance.heave_tau_s),
            attitude: share(ATTITUDE_TAU_S),
            pitch_per_s: 1.0 / (performance.heave_tau_s + dt_s),
            roll_per_s: 1.0 / (ROLL_TAU_S + dt_s),
            pitch_steps: (performance.heave_tau_s + ATTITUDE_TAU_S) / dt_s,
            stop_per_s: STOP_GAIN_PER_S.min(STOP_GAIN_PER_STEP / dt_s),
        }
    }
}
