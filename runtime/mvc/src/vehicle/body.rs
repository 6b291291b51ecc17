use super::{Demand, Drive, Tail, Throttle, Turn, Vehicle};
use crate::plan::Vertical;
use crate::sixdof::{Helm, Orders, Steering, Surroundings, Trim};

impl Throttle {
    /// Whether the thruster turns ahead at all.
    pub(crate) fn is_on(self) -> bool {
        match self {
            Self::Speed(amount) | Self::Rpm(amount) => amount > 0.0,
        }
    }
}

/// The body with six degrees of freedom under the vehicle. It is called only where there is one.
impl Vehicle {
    pub(super) fn pilot(&mut self, drive: Drive, dt_s: f64) {
        let Some(piloted) = &mut self.piloted else { return };
        let helm = match drive {
            Drive::Held => Helm::Held,
            Drive::Under(demand) => Helm::Under(orders(&demand)),
            // Only what hovers is asked to, and that has no such body.
            Drive::Adrift | Drive::Hover(_) => Helm::Adrift,
        };
        let around = Surroundings {
            water_depth_m: self.water_depth_m,
            gradient: self.gradient,
            current: (self.current.0, self.current.1, 0.0),
        };
        piloted.float_at(self.rise_share);
        piloted.drive(&helm, &around, dt_s);
        let motion = piloted.motion();
        self.at = motion.at;
        self.depth_m = motion.depth_m;
        self.heading_deg = motion.heading_deg;
        (self.surge_mps, self.sway_mps) = (motion.surge_mps, motion.sway_mps);
        self.heave_mps = motion.heave_mps;
        self.yaw_rate_dps = motion.yaw_rate_dps;
        (self.pitch_deg, self.pitch_rate_dps) = (motion.pitch_deg, motion.pitch_rate_dps);
        (self.roll_deg, self.roll_rate_dps) = (motion.roll_deg, motion.roll_rate_dps);
        self.ground = motion.ground;
        self.tail = Some(Tail {
            now: motion.tail,
            ordered: motion.ordered,
        });
    }

    /// Puts it on the seabed where it is below that.
    pub(super) fn ground(&mut self) {
        let Some(piloted) = &mut self.piloted else { return };
        (self.grounded, self.depth_m) = piloted.ground_at(self.water_depth_m);
        if self.grounded {
            self.heave_mps = self.heave_mps.min(0.0);
        }
    }
}

fn orders(demand: &Demand) -> Orders {
    Orders {
        steering: match demand.turn {
            Turn::Heading(heading_deg) => Steering::Heading(heading_deg),
            Turn::Rudder(rudder_deg) => Steering::Rudder(rudder_deg),
        },
        trim: match demand.vertical {
            Vertical::Depth(depth_m) => Trim::Depth(depth_m),
            Vertical::Altitude(altitude_m) => Trim::Altitude(altitude_m),
            Vertical::Pitch(pitch_deg) => Trim::Pitch(pitch_deg),
            Vertical::Elevator(elevator_deg) => Trim::Elevator(elevator_deg),
        },
        throttle: demand.throttle,
    }
}
