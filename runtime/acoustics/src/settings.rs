use crate::error::{AcousticsError, within};

/// The most samples of a ping, for each side of a sidescan sonar and for a sub-bottom profiler: EdgeTech's headers count
/// them in 16 bits.
pub const SAMPLES_MAX: u32 = 65_535;

/// What a sidescan sonar is set to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SideScanSettings {
    /// Its frequency, hertz, 10 kHz to 2 MHz. The width of the beam along track follows from it.
    pub frequency_hz: f64,
    /// How far it looks to each side along the slant, metres, 1 to 2000.
    pub range_m: f64,
    /// Length of the pulse, seconds, 1 µs to 0.1 s. For a frequency sweep it is the length after compression.
    pub pulse_s: f64,
    /// Transmitted power over the greatest, 0 to 1. At 0 the sonar hears noise alone.
    pub power: f64,
    /// Gain of the receiver, decibels, -120 to 120, on top of the gain that grows with time: see
    /// [`SideScan::tvg_db`](crate::SideScan::tvg_db).
    pub gain_db: f64,
    /// Number of samples for each side, 1 to 65535. They divide the range evenly; a sample has the slant range of its
    /// middle.
    pub samples: u32,
    /// Speed of sound, metres a second, 1300 to 1700.
    pub sound_speed_mps: f64,
}

impl SideScanSettings {
    /// Checks the ranges of all fields.
    ///
    /// # Errors
    /// [`AcousticsError`] with the first field that is out of its range.
    pub fn check(&self) -> Result<(), AcousticsError> {
        within(
            self.frequency_hz,
            1e4,
            2e6,
            "sidescan.frequency_hz",
            "10000 to 2000000 Hz",
        )?;
        within(self.range_m, 1.0, 2000.0, "sidescan.range_m", "1 to 2000 m")?;
        within(self.pulse_s, 1e-6, 0.1, "sidescan.pulse_s", "0.000001 to 0.1 s")?;
        within(self.power, 0.0, 1.0, "sidescan.power", "0 to 1")?;
        within(self.gain_db, -120.0, 120.0, "sidescan.gain_db", "-120 to 120 dB")?;
        samples(self.samples, "sidescan.samples")?;
        sound_speed(self.sound_speed_mps, "sidescan.sound_speed_mps")
    }

    /// Slant range of a sample, metres: that of its middle.
    #[must_use]
    pub fn slant_m(&self, sample: u32) -> f64 {
        (f64::from(sample) + 0.5) * self.sample_m()
    }

    /// The part of the slant range that belongs to one sample, metres.
    #[must_use]
    pub fn sample_m(&self) -> f64 {
        self.range_m / f64::from(self.samples)
    }
}

/// What a sub-bottom profiler is set to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SubBottomSettings {
    /// Where the frequency of the pulse starts, hertz, 100 Hz to 200 kHz.
    pub start_hz: f64,
    /// Where it ends, hertz, at least 100 Hz above the start and at most 200 kHz.
    pub end_hz: f64,
    /// Length of the pulse before compression, seconds, 0.1 ms to 1 s.
    pub pulse_s: f64,
    /// Transmitted power over the greatest, 0 to 1. At 0 the profiler hears noise alone.
    pub power: f64,
    /// Gain of the receiver, decibels, -120 to 120. No gain grows with time.
    pub gain_db: f64,
    /// Number of samples, 1 to 65535. The first is that of the ping's time.
    pub samples: u32,
    /// Time from one sample to the next, seconds, 1 µs to 10 ms.
    pub sample_interval_s: f64,
    /// Speed of sound in the water and in the sediment, metres a second, 1300 to 1700.
    pub sound_speed_mps: f64,
}

impl SubBottomSettings {
    /// Checks the ranges of all fields.
    ///
    /// # Errors
    /// [`AcousticsError`] with the first field that is out of its range.
    pub fn check(&self) -> Result<(), AcousticsError> {
        let band = "100 to 200000 Hz";
        within(self.start_hz, 100.0, 2e5, "subbottom.start_hz", band)?;
        let above = "at least 100 Hz above start_hz, at most 200000 Hz";
        within(self.end_hz, self.start_hz + 100.0, 2e5, "subbottom.end_hz", above)?;
        within(self.pulse_s, 1e-4, 1.0, "subbottom.pulse_s", "0.0001 to 1 s")?;
        within(self.power, 0.0, 1.0, "subbottom.power", "0 to 1")?;
        within(self.gain_db, -120.0, 120.0, "subbottom.gain_db", "-120 to 120 dB")?;
        samples(self.samples, "subbottom.samples")?;
        let interval = "0.000001 to 0.01 s";
        within(
            self.sample_interval_s,
            1e-6,
            1e-2,
            "subbottom.sample_interval_s",
            interval,
        )?;
        sound_speed(self.sound_speed_mps, "subbottom.sound_speed_mps")
    }

    /// The sweep of the pulse, hertz.
    #[must_use]
    pub fn bandwidth_hz(&self) -> f64 {
        self.end_hz - self.start_hz
    }

    /// The middle of the pulse's frequencies, hertz.
    #[must_use]
    pub fn centre_hz(&self) -> f64 {
        0.5 * (self.start_hz + self.end_hz)
    }
}

fn samples(samples: u32, key: &'static str) -> Result<(), AcousticsError> {
    within(f64::from(samples), 1.0, f64::from(SAMPLES_MAX), key, "1 to 65535")
}

fn sound_speed(speed_mps: f64, key: &'static str) -> Result<(), AcousticsError> {
    within(speed_mps, 1300.0, 1700.0, key, "1300 to 1700 m/s")
}
