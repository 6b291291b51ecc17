use serde::{Deserialize, Serialize};

use crate::quantity::OutOfRange;

macro_rules! angle {
    ($(#[$doc:meta])* $name:ident, $lower:literal, $limit:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize, Deserialize)]
        #[serde(try_from = "f64", into = "f64")]
        pub struct $name(f64);

        impl $name {
            #[doc = concat!("From degrees within ±", stringify!($limit), ".")]
            ///
            /// # Errors
            /// [`OutOfRange`] where it is not, or is not a number.
            pub fn from_deg(deg: f64) -> Result<Self, OutOfRange> {
                if deg.abs() <= $limit {
                    Ok(Self(deg))
                } else {
                    Err(OutOfRange { quantity: $lower, value: deg, unit: "deg", min: -$limit, max: $limit })
                }
            }

            /// Degrees.
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

angle! {
    /// WGS84 latitude, degrees, north positive, within ±90.
    Latitude, "latitude", 90.0
}
angle! {
    /// WGS84 longitude, degrees, east positive, within ±180.
    Longitude, "longitude", 180.0
}

/// A horizontal position on WGS84.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Position {
    /// North positive.
    pub latitude: Latitude,
    /// East positive.
    pub longitude: Longitude,
}

impl Position {
    /// From degrees, north and east positive.
    ///
    /// # Errors
    /// [`OutOfRange`] where latitude is beyond ±90 or longitude beyond ±180.
    pub fn from_deg(latitude_deg: f64, longitude_deg: f64) -> Result<Self, OutOfRange> {
        Ok(Self {
            latitude: Latitude::from_deg(latitude_deg)?,
            longitude: Longitude::from_deg(longitude_deg)?,
        })
    }
}
