use crate::vehicle::performance::Performance;

/// Time constant of the rates of pitch and roll, seconds.
const ATTITUDE_TAU_S: f64 = 0.5;
/// Time constant of the roll, seconds.
const ROLL_TAU_S: f64 = 1.0;
/// How fast the vehicle comes to the surface or the bed for each metre that is left, per second: half a metre a second is
/// stopped within a metre, at a quarter of a metre a second squared at most.
const STOP_GAIN_PER_S: f64 = 0.5;
/// With less than this many steps to stop in, it would come to a stop beyond.
const STOP_GAIN_PER_STEP: f64 = 0.34;

/// What the time constants come to in a step, kept because every step is as long.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lags {
    pub(super) dt_s: f64,
    /// The part of the way that a first-order lag goes in a step: of the speed, the turn, the depth rate, the rates of pitch
    /// and roll.
    pub(super) surge: f64,
    pub(super) yaw: f64,
    pub(super) heave: f64,
    pub(super) attitude: f64,
    /// Rate asked for a degree of pitch, or of roll, per second.
    pub(super) pitch_per_s: f64,
    pub(super) roll_per_s: f64,
    /// Steps until a pitch is there.
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
