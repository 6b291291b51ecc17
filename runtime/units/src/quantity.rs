use serde::{Deserialize, Serialize};

use crate::math::{wrap_180, wrap_360};

/// A value that its quantity does not allow.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{quantity} {value} {unit} is not within {min} to {max}")]
pub struct OutOfRange {
    /// The quantity, in lower case: `depth`.
    pub quantity: &'static str,
    /// The value.
    pub value: f64,
    /// Its unit.
    pub unit: &'static str,
    /// The least allowed value.
    pub min: f64,
    /// The greatest allowed value.
    pub max: f64,
}

macro_rules! quantity {
    ($(#[$doc:meta])* $name:ident, $lower:literal, $unit:literal, $from:ident, $as:ident, $min:literal ..= $max:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize, Deserialize)]
        #[serde(try_from = "f64", into = "f64")]
        pub struct $name(f64);

        impl $name {
            #[doc = concat!("From a value in ", $unit, ", which must be within ", stringify!($min), " to ", stringify!($max), ".")]
            ///
            /// # Errors
            /// [`OutOfRange`] for other values and for NaN.
            pub fn $from(value: f64) -> Result<Self, OutOfRange> {
                if ($min..=$max).contains(&value) {
                    Ok(Self(value))
                } else {
                    Err(OutOfRange { quantity: $lower, value, unit: $unit, min: $min, max: $max })
                }
            }

            #[doc = concat!("The value in ", $unit, ".")]
            #[must_use]
            pub const fn $as(self) -> f64 {
                self.0
            }
        }

        impl TryFrom<f64> for $name {
            type Error = OutOfRange;
            fn try_from(value: f64) -> Result<Self, OutOfRange> {
                Self::$from(value)
            }
        }

        impl From<$name> for f64 {
            fn from(value: $name) -> f64 {
                value.0
            }
        }
    };
}

quantity! {
    /// Depth below the surface, metres, positive down. Slightly negative values are allowed, because of waves.
    Depth, "depth", "m", from_m, as_m, -100.0..=12000.0
}
quantity! {
    /// Height above the seabed, metres, positive up.
    Altitude, "altitude", "m", from_m, as_m, 0.0..=12000.0
}
quantity! {
    /// Speed through the water, metres per second, never negative.
    Speed, "speed", "m/s", from_mps, as_mps, 0.0..=50.0
}

/// Heading from true north, degrees clockwise, in [0, 360).
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize, Deserialize)]
#[serde(try_from = "f64", into = "f64")]
pub struct Heading(f64);

/// Heading from the north of a UTM grid, degrees clockwise, in [0, 360). BFNVG reports this heading (SPI 6.1).
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize, Deserialize)]
#[serde(try_from = "f64", into = "f64")]
pub struct GridHeading(f64);

macro_rules! heading {
    ($name:ident, $lower:literal) => {
        impl $name {
            /// From degrees, wrapped into [0, 360).
            ///
            /// # Errors
            /// [`OutOfRange`] if the value is not finite or is beyond ±1e6 degrees.
            pub fn from_deg(deg: f64) -> Result<Self, OutOfRange> {
                if deg.abs() <= 1e6 {
                    Ok(Self(wrap_360(deg)))
                } else {
                    Err(OutOfRange {
                        quantity: $lower,
                        value: deg,
                        unit: "deg",
                        min: -1e6,
                        max: 1e6,
                    })
                }
            }

            /// Degrees clockwise, in [0, 360).
            #[must_use]
            pub const fn as_deg(self) -> f64 {
                self.0
            }
        }

        impl TryFrom<f64> for $name {
            type Error = OutOfRange;
            fn try_from(value: f64) -> Result<Self, OutOfRange> {
                Self::from_deg(value)
            }
        }

        impl From<$name> for f64 {
            fn from(value: $name) -> f64 {
                value.0
            }
        }
    };
}

heading!(Heading, "heading");
heading!(GridHeading, "grid heading");

impl Heading {
    /// The smallest turn from this heading to another, degrees, positive clockwise, in [-180, 180).
    #[must_use]
    pub fn turn_to_deg(self, other: Self) -> f64 {
        wrap_180(other.0 - self.0)
    }

    /// The same direction, counted from a grid north that lies `convergence_deg` clockwise of true north.
    #[must_use]
    pub fn to_grid(self, convergence_deg: f64) -> GridHeading {
        GridHeading(wrap_360(self.0 - convergence_deg))
    }
}

impl GridHeading {
    /// The same direction, counted from true north. Grid north lies `convergence_deg` clockwise of it.
    #[must_use]
    pub fn to_true(self, convergence_deg: f64) -> Heading {
        Heading(wrap_360(self.0 + convergence_deg))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constructors_reject_out_of_range_values_and_nan() {
        assert!(Depth::from_m(20.0).is_ok());
        for bad in [f64::NAN, f64::INFINITY, -101.0, 12001.0] {
            assert!(Depth::from_m(bad).is_err(), "{bad}");
        }
        assert!(Altitude::from_m(-0.1).is_err());
        assert!(Heading::from_deg(f64::NAN).is_err());
        assert_eq!(
            Speed::from_mps(-1.0).unwrap_err().to_string(),
            "speed -1 m/s is not within 0 to 50"
        );
    }

    #[test]
    fn turns_take_the_short_way() {
        let heading = |deg| Heading::from_deg(deg).unwrap();
        assert_eq!(heading(350.0).turn_to_deg(heading(10.0)), 20.0);
        assert_eq!(heading(10.0).turn_to_deg(heading(350.0)), -20.0);
    }

    #[test]
    fn to_grid_and_to_true_are_inverse() {
        let heading = Heading::from_deg(1.0).unwrap();
        let grid = heading.to_grid(2.0);
        assert_eq!(grid.as_deg(), 359.0);
        assert_eq!(grid.to_true(2.0), heading);
    }
}
