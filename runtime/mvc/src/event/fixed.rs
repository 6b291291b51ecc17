use core::fmt;

/// A number with `DECIMALS` decimals, at most 9. It prints as with `{:.DECIMALS$}`, except for a value exactly between
/// two results. The standard library computes the exact decimal value, which costs ten times as much, and a log has
/// thousands of these numbers.
pub(crate) struct Fixed<const DECIMALS: usize>(pub(crate) f64);

impl<const DECIMALS: usize> Fixed<DECIMALS> {
    const SCALE: u64 = 10u64.pow(DECIMALS as u32);
}

impl<const DECIMALS: usize> fmt::Display for Fixed<DECIMALS> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Above this value the product below is too coarse to be rounded.
        const SCALED_MAX: f64 = 1e9;
        let scaled = (self.0.abs() * Self::SCALE as f64).round();
        if scaled.is_nan() || scaled >= SCALED_MAX {
            return write!(f, "{:.DECIMALS$}", self.0);
        }
        let scaled = scaled as u64;
        let sign = if self.0.is_sign_negative() { "-" } else { "" };
        let whole = scaled / Self::SCALE;
        if DECIMALS == 0 {
            return write!(f, "{sign}{whole}");
        }
        let decimals = scaled % Self::SCALE;
        write!(f, "{sign}{whole}.{decimals:0DECIMALS$}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_writes_what_the_standard_library_writes() {
        let mut value = 1.234_567e-9;
        while value < 1e20 {
            for value in [value, -value] {
                assert_eq!(Fixed::<0>(value).to_string(), format!("{value:.0}"));
                assert_eq!(Fixed::<1>(value).to_string(), format!("{value:.1}"));
                assert_eq!(Fixed::<3>(value).to_string(), format!("{value:.3}"));
            }
            value *= 1.618_033;
        }
        for value in [
            0.0,
            -0.0,
            9.96,
            0.05,
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::MAX,
        ] {
            assert_eq!(Fixed::<2>(value).to_string(), format!("{value:.2}"));
        }
    }
}
