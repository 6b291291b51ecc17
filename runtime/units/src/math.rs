//! The elementary functions, from `libm`, with the same bits on every platform.
//!
//! The functions of the standard library come from the platform's C library, and their last digit differs between
//! systems.

pub use core::f64::consts::{PI, SQRT_2, TAU};

/// Sine of an angle in radians.
#[must_use]
pub fn sin(x_rad: f64) -> f64 {
    libm::sin(x_rad)
}

/// Cosine of an angle in radians.
#[must_use]
pub fn cos(x_rad: f64) -> f64 {
    libm::cos(x_rad)
}

/// Sine and cosine of an angle in radians.
#[must_use]
pub fn sin_cos(x_rad: f64) -> (f64, f64) {
    libm::sincos(x_rad)
}

/// Tangent of an angle in radians.
#[must_use]
pub fn tan(x_rad: f64) -> f64 {
    libm::tan(x_rad)
}

/// Inverse sine, in radians.
#[must_use]
pub fn asin(x: f64) -> f64 {
    libm::asin(x)
}

/// Inverse cosine, in radians.
#[must_use]
pub fn acos(x: f64) -> f64 {
    libm::acos(x)
}

/// Inverse tangent, in radians.
#[must_use]
pub fn atan(x: f64) -> f64 {
    libm::atan(x)
}

/// Angle of the vector (x, y) from the x axis, in radians within ±π.
#[must_use]
pub fn atan2(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

/// Length of the vector (x, y). Plain arithmetic is enough: no length in this project overflows or underflows when it
/// is squared.
#[must_use]
pub fn hypot(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

/// e to the power of x.
#[must_use]
pub fn exp(x: f64) -> f64 {
    libm::exp(x)
}

/// Natural logarithm.
#[must_use]
pub fn ln(x: f64) -> f64 {
    libm::log(x)
}

/// x to the power of y.
#[must_use]
pub fn pow(x: f64, y: f64) -> f64 {
    libm::pow(x, y)
}

/// Hyperbolic tangent.
#[must_use]
pub fn tanh(x: f64) -> f64 {
    libm::tanh(x)
}

/// An angle in degrees, wrapped into [0, 360).
#[must_use]
pub fn wrap_360(deg: f64) -> f64 {
    if (0.0..360.0).contains(&deg) {
        return deg;
    }
    let wrapped = deg % 360.0;
    let wrapped = if wrapped < 0.0 { wrapped + 360.0 } else { wrapped };
    // For a tiny negative angle, the sum above rounds to 360.
    if wrapped >= 360.0 { 0.0 } else { wrapped }
}

/// An angle in degrees, wrapped into [-180, 180).
#[must_use]
pub fn wrap_180(deg: f64) -> f64 {
    let wrapped = wrap_360(deg);
    if wrapped >= 180.0 { wrapped - 360.0 } else { wrapped }
}

#[cfg(test)]
mod tests {
    use super::{wrap_180, wrap_360};

    #[test]
    fn angles_wrap_into_their_half_open_ranges() {
        for (deg, full, half) in [
            (0.0, 0.0, 0.0),
            (360.0, 0.0, 0.0),
            (-90.0, 270.0, -90.0),
            (180.0, 180.0, -180.0),
            (539.0, 179.0, 179.0),
            (-1e-18, 0.0, 0.0),
        ] {
            assert_eq!(wrap_360(deg), full, "{deg}");
            assert_eq!(wrap_180(deg), half, "{deg}");
        }
    }
}
