use serde::{Deserialize, Serialize};

/// A measurement, as small as an acoustic link needs it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Report {
    /// Counts from 1 and begins again after 65535.
    pub number: u16,
    /// Tenths of a metre below the surface.
    pub depth_dm: u16,
    /// Hundredths of a degree Celsius.
    pub temperature_cc: i16,
}

impl Report {
    /// The bytes of a report.
    pub const BYTES: usize = 6;

    /// From a depth in metres and a temperature in degrees Celsius. What is beyond the range of the format becomes its
    /// least or greatest value, and NaN becomes 0.
    #[must_use]
    pub fn of(number: u16, depth_m: f64, temperature_c: f64) -> Self {
        Self {
            number,
            depth_dm: (depth_m * 10.0).round() as u16,
            temperature_cc: (temperature_c * 100.0).round() as i16,
        }
    }

    /// Its bytes, the highest of each number first.
    #[must_use]
    pub fn to_bytes(&self) -> [u8; Self::BYTES] {
        let ([a, b], [c, d], [e, f]) = (
            self.number.to_be_bytes(),
            self.depth_dm.to_be_bytes(),
            self.temperature_cc.to_be_bytes(),
        );
        [a, b, c, d, e, f]
    }
}
