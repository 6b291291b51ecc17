use super::{Demand, Drive, Tail, Turn, Vehicle, Vertical};
use crate::vehicle::sixdof::{Helm, Orders, Steering, Surroundings, Trim};

/// The connection to the body with six degrees of freedom. These functions do nothing if the vehicle has none.
impl Vehicle {
    pub(super) fn pilot(&mut self, drive: Drive, dt_s: f64) {
        let Some(piloted) = &mut self.piloted else { return };
        let helm = match drive {
            Drive::Held => Helm::Held,
            Drive::Under(demand) => Helm::Under(orders(&demand)),
            // Only hovering vehicles are told to hover, and they never have this body.
            Drive::Adrift | Drive::Hover(_) => Helm::Adrift,
        };
        let around = Surroundings {
            water_depth_m: self.motion.water_depth_m,
            gradient: self.motion.gradient,
            current: (self.motion.current.0, self.motion.current.1, 0.0),
        };
        piloted.float_at(self.rise_share);
        piloted.drive(&helm, &around, dt_s);
        let motion = piloted.motion();
        self.motion.at = motion.at;
        self.motion.depth_m = motion.depth_m;
        self.motion.heading_deg = motion.heading_deg;
        (self.motion.surge_mps, self.motion.sway_mps) = (motion.surge_mps, motion.sway_mps);
        self.motion.heave_mps = motion.heave_mps;
        self.motion.yaw_rate_dps = motion.yaw_rate_dps;
        (self.motion.pitch_deg, self.motion.pitch_rate_dps) = (motion.pitch_deg, motion.pitch_rate_dps);
        (self.motion.roll_deg, self.motion.roll_rate_dps) = (motion.roll_deg, motion.roll_rate_dps);
        self.motion.ground = motion.ground;
        let tail = Tail {
            now: motion.tail,
            ordered: motion.ordered,
        };
        self.motion.tail = Some(tail.standing(matches!(helm, Helm::Under(_))));
    }

    /// Puts the vehicle on the seabed if it is below it.
    pub(super) fn ground(&mut self) {
        let Some(piloted) = &mut self.piloted else { return };
        (self.motion.grounded, self.motion.depth_m) = piloted.ground_at(self.motion.water_depth_m);
        if self.motion.grounded {
            self.motion.heave_mps = self.motion.heave_mps.min(0.0);
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
