use backseat_units::math::{atan2, sin_cos};

/// From the body's axes to north, east, down, as a unit quaternion: its scalar part, then its vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Attitude(pub(super) [f64; 4]);

impl Attitude {
    pub(super) fn level(heading_rad: f64) -> Self {
        let (sin, cos) = sin_cos(0.5 * heading_rad);
        Self([cos, 0.0, 0.0, sin])
    }

    pub(super) fn normalize(&mut self) {
        let length = self.0.iter().map(|part| part * part).sum::<f64>().sqrt();
        for part in &mut self.0 {
            *part /= length;
        }
    }

    /// The world's down in the body's axes.
    pub(super) fn down(&self) -> [f64; 3] {
        let [w, x, y, z] = self.0;
        [
            2.0 * (x * z - w * y),
            2.0 * (y * z + w * x),
            1.0 - 2.0 * (x * x + y * y),
        ]
    }

    pub(super) fn heading_rad(&self) -> f64 {
        let [w, x, y, z] = self.0;
        atan2(2.0 * (x * y + w * z), 1.0 - 2.0 * (y * y + z * z))
    }

    /// A vector in the body's axes as north, east, down.
    pub(super) fn to_world(self, vector: [f64; 3]) -> [f64; 3] {
        rotated(self.0, vector)
    }

    /// A vector given as north, east, down in the body's axes.
    pub(super) fn to_body(self, vector: [f64; 3]) -> [f64; 3] {
        let [w, x, y, z] = self.0;
        rotated([w, -x, -y, -z], vector)
    }

    /// The change of the quaternion in a second at these rates of roll, pitch and yaw in the body's axes, radians a
    /// second (Fossen 2021, section 2.2.2).
    pub(super) fn rate(&self, [p, q, r]: [f64; 3]) -> [f64; 4] {
        let [w, x, y, z] = self.0;
        [
            -0.5 * (x * p + y * q + z * r),
            0.5 * (w * p + y * r - z * q),
            0.5 * (w * q + z * p - x * r),
            0.5 * (w * r + x * q - y * p),
        ]
    }
}

/// The vector turned by the quaternion: v + 2 e x (e x v + w v), e its vector part.
fn rotated([w, x, y, z]: [f64; 4], [a, b, c]: [f64; 3]) -> [f64; 3] {
    let (i, j, k) = (y * c - z * b + w * a, z * a - x * c + w * b, x * b - y * a + w * c);
    [
        a + 2.0 * (y * k - z * j),
        b + 2.0 * (z * i - x * k),
        c + 2.0 * (x * j - y * i),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_north_east_down() {
        let east = Attitude::level(90_f64.to_radians());
        let [north_m, east_m, down_m] = east.to_world([1.0, 0.0, 2.0]);
        assert!(north_m.abs() < 1e-15 && (east_m - 1.0).abs() < 1e-15 && (down_m - 2.0).abs() < 1e-15);
        let back = east.to_body([north_m, east_m, down_m]);
        assert!((back[0] - 1.0).abs() < 1e-15 && back[1].abs() < 1e-15 && (back[2] - 2.0).abs() < 1e-15);
        assert!((east.heading_rad().to_degrees() - 90.0).abs() < 1e-12);
        assert_eq!(east.down(), [0.0, 0.0, 1.0]);
    }

    #[test]
    fn turns_right_through_a_loop_without_a_singularity() {
        // A whole loop at 90 degrees a second, through both verticals.
        let mut attitude = Attitude::level(0.5);
        for _ in 0..4000 {
            let rate = attitude.rate([0.0, 90_f64.to_radians(), 0.0]);
            for (part, rate) in attitude.0.iter_mut().zip(rate) {
                *part += rate * 1e-3;
            }
            attitude.normalize();
        }
        assert!((attitude.heading_rad() - 0.5).abs() < 1e-4);
        assert!(attitude.down()[0].abs() < 1e-4 && attitude.down()[2] > 0.999);
    }
}
