use backseat_units::{EastNorth, Position, Timestamp};
use serde::{Deserialize, Serialize};

/// A CTD sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CtdSample {
    /// When it was measured, on our clock.
    pub measured: Timestamp,
    /// Microsiemens per centimetre.
    pub conductivity_us_per_cm: f64,
    /// Degrees Celsius.
    pub temperature_c: f64,
    /// Kilopascals.
    pub pressure_kpa: f64,
}

/// What a sensor of the vehicle measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Sample {
    /// The vehicle's links (BFTEL, SPI 6.3).
    Telemetry(TelemetrySample),
    /// Sound velocity (BFSVS, SPI 6.4).
    SoundVelocity(SoundVelocitySample),
    /// A compass (BFRCM, SPI 6.5).
    Compass(CompassSample),
    /// The depth sensor (BFRDP, SPI 6.6).
    Pressure(PressureSample),
    /// Thruster and speed through the water (BFRVL, SPI 6.7).
    VehicleSpeed(VehicleSpeedSample),
    /// A battery (BFRBS, SPI 6.8).
    Battery(BatterySample),
    /// Elevator and rudder (BFERC, SPI 6.12).
    Surfaces(SurfacesSample),
    /// The DVL (BFDVL, SPI 6.13).
    Dvl(DvlSample),
    /// The DVL beam by beam (BFDV2, SPI 6.14).
    DvlBeams(DvlBeamsSample),
    /// The inertial unit (BFIMU, SPI 6.15).
    Imu(ImuSample),
    /// The pitch servos of DVL and sonar (BFPIT, SPI 6.18).
    Servo(ServoSample),
    /// The trim estimator (BFTRM, SPI 6.22).
    Trim(TrimSample),
    /// The buoyancy estimator (BFBOY, SPI 6.23).
    Buoyancy(BuoyancySample),
}

/// The vehicle's links to the topside, over the last and the next minute.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TelemetrySample {
    /// When it was measured, on our clock.
    pub measured: Timestamp,
    /// Room for uploads by acoustic modem in the next minute, kilobytes.
    pub acoustic_up_available_kb: f64,
    /// Uploaded in the last minute, kilobytes.
    pub acoustic_up_last_kb: f64,
    /// Room for downloads in the next minute, kilobytes.
    pub acoustic_down_available_kb: f64,
    /// Downloaded in the last minute, kilobytes.
    pub acoustic_down_last_kb: f64,
    /// The radio modem is connected.
    pub rf_connected: bool,
    /// Ethernet is available.
    pub ethernet_available: bool,
}

/// Sound velocity, measured or estimated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SoundVelocitySample {
    /// When it was measured, on our clock.
    pub measured: Timestamp,
    /// Metres per second.
    pub sound_velocity_mps: f64,
}

/// One compass's raw output.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CompassSample {
    /// When it was measured, on our clock.
    pub measured: Timestamp,
    /// Which compass, from 1.
    pub number: u32,
    /// Degrees.
    pub heading_deg: f64,
    /// Degrees.
    pub pitch_deg: f64,
    /// Degrees.
    pub roll_deg: f64,
}

/// The depth sensor's raw output.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PressureSample {
    /// When it was measured, on our clock.
    pub measured: Timestamp,
    /// Kilopascals.
    pub pressure_kpa: f64,
}

/// The thruster, and the speed that the vehicle estimates from it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct VehicleSpeedSample {
    /// When it was measured, on our clock.
    pub measured: Timestamp,
    /// Turns a minute.
    pub thruster_rpm: f64,
    /// Through the water, m/s; `None` if the vehicle does not know it.
    pub water_speed_mps: Option<f64>,
}

/// A battery, or the sum of all as number 0. A value is `None` if the vehicle left its field empty.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BatterySample {
    /// When it was measured, on our clock.
    pub measured: Timestamp,
    /// Which, from 1; 0 is all of them.
    pub number: u32,
    /// Of the stack, volts.
    pub voltage_v: Option<f64>,
    /// The lowest cell, volts.
    pub cell_min_v: Option<f64>,
    /// The highest cell, volts.
    pub cell_max_v: Option<f64>,
    /// The hottest cell, degrees Celsius.
    pub temperature_c: Option<f64>,
    /// Kilowatt hours.
    pub capacity_kwh: Option<f64>,
    /// State of charge, percent.
    pub charge_percent: Option<f64>,
}

/// Elevator and rudder, degrees: pitch up and starboard are positive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SurfacesSample {
    /// When it was measured, on our clock.
    pub measured: Timestamp,
    /// Elevator.
    pub elevator_deg: f64,
    /// Rudder.
    pub rudder_deg: f64,
    /// The elevator's commanded angle.
    pub elevator_target_deg: f64,
    /// The rudder's commanded angle.
    pub rudder_target_deg: f64,
}

/// The DVL's raw output. A value is `None` if the vehicle left its field empty.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DvlSample {
    /// When it was measured, on our clock.
    pub measured: Timestamp,
    /// Forward, starboard and down, m/s.
    pub velocity_mps: [Option<f64>; 3],
    /// Of the four beams, metres.
    pub ranges_m: [Option<f64>; 4],
    /// Degrees Celsius.
    pub temperature_c: Option<f64>,
}

/// The DVL's raw output beam by beam. On vehicles that do not hover, the velocities are forward, starboard, down and
/// error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DvlBeamsSample {
    /// When it was measured, on our clock.
    pub measured: Timestamp,
    /// Of the four beams, m/s.
    pub velocity_mps: [Option<f64>; 4],
    /// Of the four beams, metres.
    pub ranges_m: [Option<f64>; 4],
    /// Degrees Celsius.
    pub temperature_c: Option<f64>,
}

/// The inertial unit's raw output, about and along the axes forward, starboard and down.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ImuSample {
    /// When it was measured, on our clock.
    pub measured: Timestamp,
    /// Degrees per second, right-hand rule.
    pub rate_dps: [f64; 3],
    /// Metres per second squared.
    pub acceleration_mps2: [f64; 3],
}

/// Where DVL and sonar point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ServoSample {
    /// When it was measured, on our clock.
    pub measured: Timestamp,
    /// Degrees.
    pub dvl_deg: f64,
    /// Degrees.
    pub sonar_deg: f64,
}

/// The vehicle's trim, estimated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrimSample {
    /// When the vehicle sent it, on our clock.
    pub measured: Timestamp,
    /// An adjustment is under way, either requested or by the vehicle itself.
    pub adjusting: bool,
    /// Degrees.
    pub pitch_deg: f64,
    /// Degrees.
    pub roll_deg: f64,
}

/// The vehicle's buoyancy, estimated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BuoyancySample {
    /// When the vehicle sent it, on our clock.
    pub measured: Timestamp,
    /// An adjustment is under way, either requested or by the vehicle itself.
    pub adjusting: bool,
    /// Newtons.
    pub buoyancy_n: f64,
}

/// A hovering vehicle relative to its target (BFRNV, SPI 6.17).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RelativeSample {
    /// When it was measured, on our clock.
    pub measured: Timestamp,
    /// Along the target, metres.
    pub horizontal_m: f64,
    /// Across it, metres.
    pub vertical_m: f64,
    /// From it, metres.
    pub distance_m: f64,
    /// Degrees; zero is towards the target.
    pub heading_deg: f64,
    /// Below the surface, metres.
    pub depth_m: f64,
    /// Degrees, in the vehicle's inertial frame: not a compass heading.
    pub absolute_heading_deg: f64,
    /// Degrees.
    pub roll_deg: f64,
    /// Degrees.
    pub pitch_deg: f64,
}

/// A hovering vehicle in its inertial frame (BFCNV, SPI 6.19).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CartesianSample {
    /// When it was measured, on our clock.
    pub measured: Timestamp,
    /// Metres.
    pub x_m: f64,
    /// Metres.
    pub y_m: f64,
    /// Metres.
    pub z_m: f64,
    /// Degrees; zero is towards the target.
    pub heading_deg: f64,
}

/// A time in which the payload may send through the acoustic modem (BFCMA, SPI 9.1).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Window {
    /// Its end, on our clock.
    pub until: Timestamp,
    /// The modem's address.
    pub address: u32,
    /// The kind of modem: `Sonardyne6G`, `WHOI`, `WHOIPSK`.
    pub device: String,
}

/// A packet that the acoustic modem received (BFCPR, SPI 9.3).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReceivedPacket {
    /// When, on our clock.
    pub arrived: Timestamp,
    /// The modem that sent it.
    pub source: u32,
    /// The modem that it was for; not always this one.
    pub destination: u32,
    /// Telemetry mode; `None` if it is not known.
    pub mode: Option<i32>,
    /// As many frames as the vehicle says that there are.
    pub frames: Vec<ReceivedFrame>,
}

/// A frame of a received packet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReceivedFrame {
    /// It came undamaged. Damaged frames are kept too.
    pub good: bool,
    /// Its bytes.
    pub data: Vec<u8>,
}

/// An element of the vehicle's plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlannedElement {
    /// Its number in the dive file; `None` for an insert.
    pub number: Option<u32>,
    /// A payload's identifier, for an insert.
    pub identifier: Option<u32>,
    /// Its points in the order in which they are flown, each also in the fence's frame.
    pub points: Vec<(Position, EastNorth)>,
}
