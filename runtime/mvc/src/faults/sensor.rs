use backseat_units::EastNorth;

/// A sensor that can fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Sensor {
    /// The Doppler log: no bottom lock, no BFDVL and BFDV2.
    Dvl,
    /// The altitude: BFNVG gives none. The Doppler log goes on.
    Altimeter,
    /// GPS: no fixes on the surface.
    Gps,
    /// The compasses: no BFRCM.
    Compass,
    /// The pressure sensor: no BFRDP, and the depth stays at its last value.
    Depth,
    /// Gyroscopes and accelerometers: no BFIMU.
    Imu,
    /// The CTD: no BFCTD, and no estimate of the speed of sound by it.
    Ctd,
    /// The sensor for the speed of sound: BFSVS is estimated.
    SoundVelocity,
    /// The tailcone's: no BFRVL and BFERC.
    Tailcone,
    /// The state of the links: no BFTEL.
    Telemetry,
}

impl Sensor {
    /// All of them.
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

/// How sensors and navigation fail. Each stands until it is taken back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SensorFailure {
    /// What navigation tells stands still, its values and the time of its solution (true), or goes on (false). The
    /// vehicle itself steers on.
    Frozen(bool),
    /// BFNVG and BFNVR are not sent (true), or again (false).
    Silent(bool),
    /// The solution jumps so far, metres, and stays wrong until a fix: the vehicle steers by it.
    Jump(EastNorth),
    /// A sensor gives nothing (true), or works again (false).
    Dropout(Sensor, bool),
}
