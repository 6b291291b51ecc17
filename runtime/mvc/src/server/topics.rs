/// The names of the status messages in BPLOG, in the order of [`Topic`]. A client can switch on a message for which
/// this vehicle has no sensor; the message is never sent, as on a vehicle without the sensor.
const TOPICS: [&str; 27] = [
    "NVG", "NVR", "MBS", "MBE", "MIS", "CTL", "ACK", "CTD", "PLN", "TEL", "SVS", "RCM", "RDP", "RVL", "RBS", "ERC",
    "DVL", "DV2", "IMU", "RNV", "PIT", "CNV", "TRM", "BOY", "CMA", "CPS", "CPR",
];

/// The command messages (SPI 5), which are always on.
const ALWAYS_ON: [&str; 7] = ["MSC", "SHT", "BDL", "SDL", "TOP", "DVT", "VER"];

/// A status message that a payload can switch on (SPI 6, 9). Each has one bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Topic {
    Navigation,
    Velocity,
    BehaviorBegin,
    BehaviorEnd,
    Mission,
    Control,
    Acknowledgement,
    Ctd,
    #[expect(
        dead_code,
        reason = "this release of SPI does not send BFPLN when a behavior begins (6.20)"
    )]
    Plan,
    Telemetry,
    SoundVelocity,
    Compass,
    DepthSensor,
    VehicleSpeed,
    Battery,
    ElevatorRudder,
    Dvl,
    DvlExtended,
    Imu,
    RelativeNavigation,
    PitchServo,
    CartesianNavigation,
    Trim,
    Buoyancy,
    MediumAccess,
    PacketSent,
    PacketReceived,
}

impl Topic {
    pub(crate) const fn bit(self) -> u32 {
        1 << self as u32
    }
}

const ALL: u32 = ((1 << TOPICS.len()) - 1) & !Topic::Acknowledgement.bit();

/// What a recorded vehicle sent after `BPLOG,ALL,ON`, besides BFVER, which is always on.
const NAVIGATION: u32 = Topic::Navigation.bit() | Topic::Velocity.bit() | Topic::Acknowledgement.bit();

/// What the first field of BPLOG names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Named {
    Topics(u32),
    AlwaysOn,
    Unknown,
}

/// `all_is_navigation`: which messages `ALL` is.
pub(crate) fn named(message: &str, all_is_navigation: bool) -> Named {
    if message == "ALL" {
        return Named::Topics(if all_is_navigation { NAVIGATION } else { ALL });
    }
    match TOPICS.iter().position(|name| *name == message) {
        Some(bit) => Named::Topics(1 << bit),
        None if ALWAYS_ON.contains(&message) => Named::AlwaysOn,
        None => Named::Unknown,
    }
}
