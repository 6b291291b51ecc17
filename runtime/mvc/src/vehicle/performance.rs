use backseat_plan::{VehicleClass, VehicleLimits};

/// What a vehicle can do, as a first-order model.
///
/// The figures are typical of vehicles of these sizes, from public data sheets and common sense. They do not come from
/// the manufacturer, and nobody has compared them with a vehicle. They are good enough for timing and room to turn, but
/// not for trim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Performance {
    /// The least speed at which it steers and holds its depth, metres a second; 0 for a hovering vehicle.
    pub speed_min_mps: f64,
    /// The greatest speed through the water, metres a second.
    pub speed_max_mps: f64,
    /// The greatest depth, metres.
    pub depth_max_m: f64,
    /// Time constant of the speed, seconds.
    pub surge_tau_s: f64,
    /// The greatest change of speed, metres a second squared.
    pub surge_accel_mps2: f64,
    /// The fastest turn, degrees a second. At a low speed, [`Performance::turn_radius_m`] makes the turn slower.
    pub yaw_rate_max_dps: f64,
    /// The smallest radius of a turn through the water, metres: two to three lengths of the vehicle. It does not depend
    /// on the speed, because the force of the rudder and the resistance of the water fall in the same way. 0 for a
    /// vehicle that turns on the spot.
    pub turn_radius_m: f64,
    /// Time constant of the turn, seconds.
    pub yaw_tau_s: f64,
    /// Demanded rate of turn per degree of heading error, per second.
    pub yaw_gain_per_s: f64,
    /// The steepest climb and dive, degrees; a hovering vehicle does not pitch.
    pub pitch_max_deg: f64,
    /// The fastest change of pitch, degrees a second.
    pub pitch_rate_max_dps: f64,
    /// The fastest climb and dive, metres a second.
    pub depth_rate_max_mps: f64,
    /// Time constant of the depth rate, seconds. For a vehicle that does not hover, it is the time constant of the
    /// pitch that causes the depth rate.
    pub heave_tau_s: f64,
    /// Demanded depth rate per metre of depth error, per second.
    pub depth_gain_per_s: f64,
    /// How fast it floats up if nothing holds it down, metres a second.
    pub buoyant_rise_mps: f64,
    /// Turns of the thruster a minute for each metre a second. It converts commands in rpm.
    pub rpm_per_mps: f64,
    /// The greatest angle of rudder and elevator to either side, degrees. It has no meaning for a hovering vehicle.
    pub fin_max_deg: f64,
    /// Whether it turns and holds its depth without speed.
    pub hovers: bool,
}

const LIMITS_NINE_INCH: VehicleLimits = VehicleClass::NineInch.limits();
const NINE_INCH: Performance = Performance {
    speed_min_mps: LIMITS_NINE_INCH.speed_min_mps,
    speed_max_mps: LIMITS_NINE_INCH.speed_max_mps,
    depth_max_m: LIMITS_NINE_INCH.depth_max_m,
    surge_tau_s: 3.0,
    surge_accel_mps2: 0.3,
    yaw_rate_max_dps: LIMITS_NINE_INCH.yaw_rate_max_dps,
    turn_radius_m: 5.0,
    yaw_tau_s: 0.6,
    yaw_gain_per_s: 0.5,
    pitch_max_deg: 30.0,
    pitch_rate_max_dps: 12.0,
    depth_rate_max_mps: 0.8,
    heave_tau_s: 1.5,
    depth_gain_per_s: 0.25,
    buoyant_rise_mps: 0.1,
    rpm_per_mps: 600.0,
    fin_max_deg: FIN_MAX_DEG,
    hovers: false,
};

const LIMITS_TWELVE_INCH: VehicleLimits = VehicleClass::TwelveInch.limits();
const TWELVE_INCH: Performance = Performance {
    speed_min_mps: LIMITS_TWELVE_INCH.speed_min_mps,
    speed_max_mps: LIMITS_TWELVE_INCH.speed_max_mps,
    depth_max_m: LIMITS_TWELVE_INCH.depth_max_m,
    surge_tau_s: 5.0,
    surge_accel_mps2: 0.2,
    yaw_rate_max_dps: LIMITS_TWELVE_INCH.yaw_rate_max_dps,
    turn_radius_m: 7.0,
    yaw_tau_s: 1.0,
    yaw_gain_per_s: 0.35,
    pitch_max_deg: 25.0,
    pitch_rate_max_dps: 10.0,
    depth_rate_max_mps: 0.6,
    heave_tau_s: 2.0,
    depth_gain_per_s: 0.2,
    buoyant_rise_mps: 0.1,
    rpm_per_mps: 300.0,
    fin_max_deg: FIN_MAX_DEG,
    hovers: false,
};

const LIMITS_TWENTY_ONE_INCH: VehicleLimits = VehicleClass::TwentyOneInch.limits();
const TWENTY_ONE_INCH: Performance = Performance {
    speed_min_mps: LIMITS_TWENTY_ONE_INCH.speed_min_mps,
    speed_max_mps: LIMITS_TWENTY_ONE_INCH.speed_max_mps,
    depth_max_m: LIMITS_TWENTY_ONE_INCH.depth_max_m,
    surge_tau_s: 8.0,
    surge_accel_mps2: 0.12,
    yaw_rate_max_dps: LIMITS_TWENTY_ONE_INCH.yaw_rate_max_dps,
    turn_radius_m: 12.0,
    yaw_tau_s: 1.6,
    yaw_gain_per_s: 0.22,
    pitch_max_deg: 25.0,
    pitch_rate_max_dps: 6.0,
    depth_rate_max_mps: 0.6,
    heave_tau_s: 3.0,
    depth_gain_per_s: 0.12,
    buoyant_rise_mps: 0.1,
    rpm_per_mps: 180.0,
    fin_max_deg: FIN_MAX_DEG,
    hovers: false,
};

const LIMITS_HOVERING: VehicleLimits = VehicleClass::Hovering.limits();
const HOVERING: Performance = Performance {
    speed_min_mps: LIMITS_HOVERING.speed_min_mps,
    speed_max_mps: LIMITS_HOVERING.speed_max_mps,
    depth_max_m: LIMITS_HOVERING.depth_max_m,
    surge_tau_s: 1.5,
    surge_accel_mps2: 0.2,
    yaw_rate_max_dps: LIMITS_HOVERING.yaw_rate_max_dps,
    turn_radius_m: 0.0,
    yaw_tau_s: 0.5,
    yaw_gain_per_s: 0.6,
    pitch_max_deg: 0.0,
    pitch_rate_max_dps: 0.0,
    depth_rate_max_mps: 0.3,
    heave_tau_s: 1.0,
    depth_gain_per_s: 0.4,
    buoyant_rise_mps: 0.05,
    rpm_per_mps: 1200.0,
    fin_max_deg: FIN_MAX_DEG,
    hovers: true,
};

/// Typical of fins of this size.
const FIN_MAX_DEG: f64 = 20.0;

impl Performance {
    /// The data of a class.
    #[must_use]
    pub const fn of(class: VehicleClass) -> &'static Self {
        match class {
            VehicleClass::NineInch => &NINE_INCH,
            VehicleClass::TwelveInch => &TWELVE_INCH,
            VehicleClass::TwentyOneInch => &TWENTY_ONE_INCH,
            VehicleClass::Hovering => &HOVERING,
        }
    }

    /// The speed that the thruster makes at so many turns a minute, metres a second.
    pub(crate) fn speed_mps(&self, rpm: f64) -> f64 {
        rpm / self.rpm_per_mps
    }

    /// The fastest turn at a speed through the water, degrees a second.
    pub(crate) fn turn_max_dps(&self, speed_mps: f64) -> f64 {
        if self.hovers {
            return self.yaw_rate_max_dps;
        }
        (speed_mps.max(0.0) / self.turn_radius_m)
            .to_degrees()
            .min(self.yaw_rate_max_dps)
    }

    /// The rate of turn at full speed for a rudder angle, degrees a second. It is proportional to the angle, and the
    /// greatest angle gives the fastest turn.
    pub(crate) fn rudder_dps(&self, rudder_deg: f64) -> f64 {
        (rudder_deg / self.fin_max_deg).clamp(-1.0, 1.0) * self.yaw_rate_max_dps
    }

    /// The pitch for an elevator angle, degrees. It is proportional to the angle, and the greatest angle gives the
    /// steepest pitch.
    pub(crate) fn elevator_pitch_deg(&self, elevator_deg: f64) -> f64 {
        (elevator_deg / self.fin_max_deg).clamp(-1.0, 1.0) * self.pitch_max_deg
    }
}
