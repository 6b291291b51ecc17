use backseat_units::math::{atan2, sin_cos};
use nalgebra::{Quaternion, Vector3};

/// The rotation from the body's axes to north, east, down, as a unit quaternion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Attitude(pub(super) Quaternion<f64>);

impl Attitude {
    pub(super) fn level(heading_rad: f64) -> Self {
        let (sin, cos) = sin_cos(0.5 * heading_rad);
        Self(Quaternion::new(cos, 0.0, 0.0, sin))
    }

    /// The sum is written out, because its order determines the bits of the result.
    pub(super) fn normalize(&mut self) {
        let Quaternion { coords } = self.0;
        let length = (coords.w * coords.w + coords.x * coords.x + coords.y * coords.y + coords.z * coords.z).sqrt();
        self.0 /= length;
    }

    /// The direction down, in the body's axes.
    pub(super) fn down(&self) -> Vector3<f64> {
        let [x, y, z, w]: [f64; 4] = self.0.coords.into();
        Vector3::new(
            2.0 * (x * z - w * y),
            2.0 * (y * z + w * x),
            1.0 - 2.0 * (x * x + y * y),
        )
    }

    pub(super) fn heading_rad(&self) -> f64 {
        let [x, y, z, w]: [f64; 4] = self.0.coords.into();
        atan2(2.0 * (x * y + w * z), 1.0 - 2.0 * (y * y + z * z))
    }

    /// Converts a vector in the body's axes to north, east, down.
    pub(super) fn to_world(self, vector: Vector3<f64>) -> Vector3<f64> {
        rotated(&self.0, vector)
    }

    /// Converts a vector of north, east, down to the body's axes.
    pub(super) fn to_body(self, vector: Vector3<f64>) -> Vector3<f64> {
        rotated(&self.0.conjugate(), vector)
    }

    /// The change of the quaternion per second at these rates of roll, pitch and yaw in the body's axes, radians a
    /// second (Fossen 2021, section 2.2.2).
    pub(super) fn rate(&self, turn: Vector3<f64>) -> Quaternion<f64> {
        let [x, y, z, w]: [f64; 4] = self.0.coords.into();
        let [p, q, r]: [f64; 3] = turn.into();
        Quaternion::new(
            -0.5 * (x * p + y * q + z * r),
            0.5 * (w * p + y * r - z * q),
            0.5 * (w * q + z * p - x * r),
            0.5 * (w * r + x * q - y * p),
        )
    }
}

/// The vector, rotated by the quaternion: v + 2 e x (e x v + w v), where e is the quaternion's vector part.
fn rotated(quaternion: &Quaternion<f64>, vector: Vector3<f64>) -> Vector3<f64> {
    let axis = quaternion.imag();
    let half = axis.cross(&vector) + vector * quaternion.w;
    vector + axis.cross(&half) * 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_north_east_down() {
        let east = Attitude::level(90_f64.to_radians());
        let world = east.to_world(Vector3::new(1.0, 0.0, 2.0));
        let [north_m, east_m, down_m]: [f64; 3] = world.into();
        assert!(north_m.abs() < 1e-15 && (east_m - 1.0).abs() < 1e-15 && (down_m - 2.0).abs() < 1e-15);
        let back = east.to_body(world);
        assert!((back[0] - 1.0).abs() < 1e-15 && back[1].abs() < 1e-15 && (back[2] - 2.0).abs() < 1e-15);
        assert!((east.heading_rad().to_degrees() - 90.0).abs() < 1e-12);
        assert_eq!(east.down(), Vector3::z());
    }

    #[test]
    fn turns_through_a_whole_loop_without_a_singularity() {
        // A whole loop at 90 degrees a second, through both verticals.
        let mut attitude = Attitude::level(0.5);
        for _ in 0..4000 {
            let rate = attitude.rate(Vector3::new(0.0, 90_f64.to_radians(), 0.0));
            attitude.0 += rate * 1e-3;
            attitude.normalize();
        }
        assert!((attitude.heading_rad() - 0.5).abs() < 1e-4);
        assert!(attitude.down().x.abs() < 1e-4 && attitude.down().z > 0.999);
    }
}
