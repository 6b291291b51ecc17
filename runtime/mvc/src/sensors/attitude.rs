use backseat_units::math::sin_cos;

use crate::vehicle::Vehicle;

/// The vehicle's axes (forward, starboard, down), each as a vector of the frame's north, east and down (Fossen,
/// *Handbook of Marine Craft Hydrodynamics and Motion Control*, 2011, equation 2.18).
#[derive(Clone, Copy, Debug)]
pub(super) struct Attitude {
    axes: [[f64; 3]; 3],
}

impl Attitude {
    pub(super) fn of(vehicle: &Vehicle) -> Self {
        let (sin_yaw, cos_yaw) = sin_cos(vehicle.motion().heading_deg.to_radians());
        let (sin_pitch, cos_pitch) = sin_cos(vehicle.motion().pitch_deg.to_radians());
        let (sin_roll, cos_roll) = sin_cos(vehicle.motion().roll_deg.to_radians());
        Self {
            axes: [
                [cos_pitch * cos_yaw, cos_pitch * sin_yaw, -sin_pitch],
                [
                    cos_yaw * sin_pitch * sin_roll - sin_yaw * cos_roll,
                    sin_yaw * sin_pitch * sin_roll + cos_yaw * cos_roll,
                    cos_pitch * sin_roll,
                ],
                [
                    cos_yaw * sin_pitch * cos_roll + sin_yaw * sin_roll,
                    sin_yaw * sin_pitch * cos_roll - cos_yaw * sin_roll,
                    cos_pitch * cos_roll,
                ],
            ],
        }
    }

    /// Converts a vector of north, east and down to the vehicle's axes.
    pub(super) fn to_body(self, north_east_down: [f64; 3]) -> [f64; 3] {
        self.axes.map(|axis| dot(axis, north_east_down))
    }

    /// Converts a vector along the vehicle's axes to north, east and down.
    pub(super) fn to_frame(self, body: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = self.axes;
        [0, 1, 2].map(|axis: usize| body[0] * x[axis] + body[1] * y[axis] + body[2] * z[axis])
    }
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
