//! Who a record is from, and which sensor a command is for.

use serde::Serialize;

use crate::wire::Wire;

/// The device that a record is from (DRF, "device identifier").
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(transparent)]
pub struct DeviceId(pub u32);

impl DeviceId {
    /// Not stated.
    pub const UNSPECIFIED: Self = Self(0);
    /// The logger of a 7k system.
    pub const LOGGER: Self = Self(7004);
    /// The sub-bottom profiler.
    pub const SUB_BOTTOM: Self = Self(11_000);
    /// The sidescan's low frequency.
    pub const SIDESCAN_LOW: Self = Self(11_001);
    /// The sidescan's high frequency.
    pub const SIDESCAN_HIGH: Self = Self(11_002);
    /// Data from a Bluefin vehicle.
    pub const BLUEFIN: Self = Self(11_100);
    /// In a network frame: the field is not used.
    pub const UNUSED: Self = Self(u32::MAX);

    /// What the device is, for the identifiers that are known.
    #[must_use]
    pub const fn title(self) -> Option<&'static str> {
        Some(match self {
            Self::UNSPECIFIED => "unspecified",
            Self::LOGGER => "logger",
            Self::SUB_BOTTOM => "sub-bottom profiler",
            Self::SIDESCAN_LOW => "sidescan, low frequency",
            Self::SIDESCAN_HIGH => "sidescan, high frequency",
            Self::BLUEFIN => "Bluefin vehicle data",
            Self::UNUSED => "unused",
            Self(_) => return None,
        })
    }
}

impl core::fmt::Display for DeviceId {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}", self.0)
    }
}

impl Wire for DeviceId {
    const SIZE: usize = 4;
    const TYPE: &'static str = "u32";

    fn get(bytes: &[u8]) -> Self {
        Self(Wire::get(bytes))
    }

    fn put(&self, out: &mut Vec<u8>) {
        self.0.put(out);
    }

    fn number(&self) -> Option<f64> {
        self.0.number()
    }
}

/// A sensor's index in the run list of the payload controller, or the controller itself.
///
/// Tables 16 to 18 call it "sensor id" as often as "sensor index"; it is one number. Record 11000 types it as unsigned
/// and 11001 as signed; both hold -1 for the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(transparent)]
pub struct SensorIndex(pub i32);

impl SensorIndex {
    /// The payload controller itself.
    pub const PLC: Self = Self(-1);
}

impl core::fmt::Display for SensorIndex {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}", self.0)
    }
}

impl Wire for SensorIndex {
    const SIZE: usize = 4;
    const TYPE: &'static str = "i32";

    fn get(bytes: &[u8]) -> Self {
        Self(Wire::get(bytes))
    }

    fn put(&self, out: &mut Vec<u8>) {
        self.0.put(out);
    }

    fn number(&self) -> Option<f64> {
        Some(f64::from(self.0))
    }
}
