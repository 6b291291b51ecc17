use backseat_units::EastNorth;

/// A sensor that can fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Sensor {
    /// The Doppler log: no bottom lock, no BFDVL and no BFDV2.
    Dvl,
    /// The altitude: BFNVG has none. The Doppler log goes on.
    Altimeter,
    /// GPS: no fixes at the surface.
    Gps,
    /// The compasses: no BFRCM.
    Compass,
    /// The pressure sensor: no BFRDP, and the depth stays at its last value.
    Depth,
    /// Gyroscopes and accelerometers: no BFIMU.
    Imu,
    /// The CTD: no BFCTD, and no estimate of the speed of sound from it.
    Ctd,
    /// The sensor for the speed of sound: BFSVS is an estimate.
    SoundVelocity,
    /// The sensors of thruster, rudder and elevator: no BFRVL and no BFERC.
    Tailcone,
    /// The state of the links to the topside: no BFTEL.
    Telemetry,
}

impl Sensor {
    /// All sensors.
    pub const ALL: [Self; 10] = [
        Self::Dvl,
        Self::Altimeter,
        Self::Gps,
        Self::Compass,
        Self::Depth,
        Self::Imu,
        Self::Ctd,
        Self::SoundVelocity,
        Self::Tailcone,
        Self::Telemetry,
    ];
}

/// How sensors and navigation fail. A failure lasts until the driver ends it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SensorFailure {
    /// BFNVG and BFNVR repeat their values, including the time of the solution (true), or report the solution again
    /// (false). The vehicle itself steers by the right solution.
    Frozen(bool),
    /// BFNVG and BFNVR are not sent (true), or are sent again (false).
    Silent(bool),
    /// The solution jumps by this much, metres, and stays wrong until a fix. The vehicle steers by it.
    Jump(EastNorth),
    /// A sensor gives no data (true), or works again (false).
    Dropout(Sensor, bool),
}
