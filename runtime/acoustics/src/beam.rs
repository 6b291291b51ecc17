use backseat_units::math::exp;

/// A Gaussian beam falls to half of its power at half of its width: exp(-4 ln 2 (angle / width)²). Transmitting and
/// receiving with it squares that.
const TWO_WAY: f64 = 8.0 * core::f64::consts::LN_2;
/// The width of the rectangle that has the area of a Gaussian beam squared, over the beam's width: √(π / (8 ln 2)).
pub(crate) const EQUIVALENT: f64 = 0.752_691_8;

/// The power of a Gaussian beam, transmitting and receiving, at an angle from its axis. Both in the same unit.
///
/// A Gaussian is the usual stand-in for the main lobe of an array (within 0.3 dB of a sinc down to its half-power
/// points). It has no side lobes.
pub(crate) fn two_way(angle: f64, width: f64) -> f64 {
    let ratio = angle / width;
    exp(-TWO_WAY * ratio * ratio)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_beam_has_its_width_and_its_area() {
        assert_eq!(two_way(0.0, 2.0), 1.0);
        // Half of the power each way at half of the width.
        assert!((two_way(1.0, 2.0) - 0.25).abs() < 1e-12);
        let area: f64 = (-4000..=4000)
            .map(|step| two_way(f64::from(step) * 1e-3, 1.0) * 1e-3)
            .sum();
        assert!((area - EQUIVALENT).abs() < 1e-6, "{area}");
    }
}
