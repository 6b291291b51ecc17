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
            /// [`OutOfRange`] for other values and for NaN.
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

/// A horizontal position on WGS84. Serialised as `latitude_deg` and `longitude_deg`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Position {
    /// North positive.
    #[serde(rename = "latitude_deg")]
    pub latitude: Latitude,
    /// East positive.
    #[serde(rename = "longitude_deg")]
    pub longitude: Longitude,
}

impl Position {
    /// From degrees, north and east positive.
    ///
    /// # Errors
    /// [`OutOfRange`] if the latitude is beyond ±90 or the longitude is beyond ±180.
    pub fn from_deg(latitude_deg: f64, longitude_deg: f64) -> Result<Self, OutOfRange> {
        Ok(Self {
            latitude: Latitude::from_deg(latitude_deg)?,
            longitude: Longitude::from_deg(longitude_deg)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_position_is_serialised_with_its_units_and_checked_when_read() {
        let position = Position::from_deg(42.25, -70.5).unwrap();
        let text = r#"{"latitude_deg":42.25,"longitude_deg":-70.5}"#;
        assert_eq!(serde_json::to_string(&position).unwrap(), text);
        assert_eq!(serde_json::from_str::<Position>(text).unwrap(), position);
        for bad in [
            r#"{"latitude_deg":90.1,"longitude_deg":0}"#,
            r#"{"latitude_deg":1,"longitude_deg":180.1}"#,
            r#"{"latitude_deg":1}"#,
            r#"{"latitude_deg":1,"longitude_deg":1,"depth_m":3}"#,
        ] {
            assert!(serde_json::from_str::<Position>(bad).is_err(), "{bad}");
        }
    }
}
