use core::time::Duration;

use serde::Deserialize;

use crate::error::{MvcError, check};

/// The vehicle sends BFSHT this long before the payload's power goes off (SPI 5.2: at least 1 minute).
pub(crate) const SHUTDOWN_NOTICE: Duration = Duration::from_secs(60);

/// The `[power]` section: the batteries (SPI 6.8), and when the payload's power goes off because of them (SPI 5.2).
///
/// The defaults are those of a survey torpedo by public data sheets: three packs of 1.5 kWh at a nominal 30 V, a few
/// hours at 3 knots.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PowerConfig {
    /// The energy of all batteries together when they are full, watt-hours, 1 to 1e6.
    pub capacity_wh: f64,
    /// The state of charge at the start, percent, 0 to 100.
    pub initial_percent: f64,
    /// How many batteries there are, 1 to 32. With more than one, BFRBS also reports all of them together, as battery
    /// 0.
    pub batteries: u32,
    /// How many cells in series a battery has, 1 to 200.
    pub cells: u32,
    /// The inner resistance of all batteries in parallel, ohms, 0 to 10.
    pub resistance_ohm: f64,
    /// What everything but the thruster draws, watts, 0 to 10000.
    pub hotel_w: f64,
    /// What the thruster draws at 1 m/s through the water, watts, 0 to 10000. At other speeds it draws as the cube of
    /// the speed.
    pub propulsion_w_at_1_mps: f64,
    /// How much warmer than the water the hottest cell is, degrees Celsius for each 100 W that is drawn, 0 to 50.
    pub warming_c_per_100w: f64,
    /// The state of charge at which the vehicle sends BFSHT, percent, 0 to 100. The payload's power goes off one minute
    /// later. With `None` it stays on.
    pub shutdown_below_percent: Option<f64>,
    /// The time from one series of BFRBS to the next, seconds, 0.1 to 3600.
    pub status_period_s: f64,
}

impl Default for PowerConfig {
    fn default() -> Self {
        Self {
            capacity_wh: 4500.0,
            initial_percent: 100.0,
            batteries: 3,
            cells: 8,
            resistance_ohm: 0.05,
            hotel_w: 80.0,
            propulsion_w_at_1_mps: 30.0,
            warming_c_per_100w: 2.0,
            shutdown_below_percent: None,
            status_period_s: 10.0,
        }
    }
}

impl PowerConfig {
    pub(crate) fn validate(&self) -> Result<(), MvcError> {
        for (key, value, least, most, expected) in [
            ("power.capacity_wh", self.capacity_wh, 1.0, 1e6, "1 to 1e6 Wh"),
            ("power.initial_percent", self.initial_percent, 0.0, 100.0, "0 to 100 %"),
            ("power.batteries", f64::from(self.batteries), 1.0, 32.0, "1 to 32"),
            ("power.cells", f64::from(self.cells), 1.0, 200.0, "1 to 200"),
            ("power.resistance_ohm", self.resistance_ohm, 0.0, 10.0, "0 to 10 ohm"),
            ("power.hotel_w", self.hotel_w, 0.0, 1e4, "0 to 10000 W"),
            (
                "power.propulsion_w_at_1_mps",
                self.propulsion_w_at_1_mps,
                0.0,
                1e4,
                "0 to 10000 W",
            ),
            (
                "power.warming_c_per_100w",
                self.warming_c_per_100w,
                0.0,
                50.0,
                "0 to 50",
            ),
            (
                "power.status_period_s",
                self.status_period_s,
                0.1,
                3600.0,
                "0.1 to 3600 s",
            ),
        ] {
            check((least..=most).contains(&value), key, value, expected)?;
        }
        let threshold = self.shutdown_below_percent.unwrap_or(0.0);
        check(
            (0.0..=100.0).contains(&threshold),
            "power.shutdown_below_percent",
            threshold,
            "0 to 100 %",
        )
    }
}
