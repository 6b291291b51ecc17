use backseat_units::{Altitude, Depth, GridHeading, Position, TimeOfDay};

use crate::codes::{
    AckStatus, AdjustmentError, AdjustmentStatus, FrameSentStatus, PlanElementKind, PositionQuality, Transport,
};
use crate::echo::EchoedTime;
use crate::forms::{
    BottomLock, Created, Decimal, Each, Flag, FrameCount, IdentifierOrEmpty, IdentifierOrZero, LastText, Optional,
    OrDefault, Percent, ReceivedFrames, Then, ThreeEmpty, Zero,
};
use crate::identity::{BehaviorId, CommandName};
use crate::packet::ReceivedFrame;
use crate::table::messages;
use crate::text::Text;

messages! {
    /// The messages that the vehicle sends (SPI 5, 6 and 9).
    pub enum FromVehicle from crate::Direction::FromVehicle;

    /// Mission command: text from a user-defined behavior of the mission file.
    "BFMSC" MissionCommand, "5.1", "payload mission command" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// A text whose meaning the payload defines.
        text: Text as Text, "text";
    }
    "$BFMSC,081025.987,start line 3*12"

    /// The payload will lose its power, in a minute at the earliest.
    "BFSHT" Shutdown, "5.2", "payload shutdown" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
    }
    "$BFSHT,081025.987*71"

    /// The lead-in of a survey line begins: the payload may log.
    "BFBDL" LoggingBegin, "5.3", "begin data logging" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// The mission planner's note for this step.
        text: Text as LastText, "text";
    }
    "$BFBDL,081025.987,line 3*45"

    /// The lead-out of a survey line has ended: the payload may stop logging.
    "BFSDL" LoggingEnd, "5.4", "stop data logging" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// The mission planner's note for this step.
        text: Text as LastText, "text";
    }
    "$BFSDL,081025.987,line 3*54"

    /// A message from the topside.
    "BFTOP" TopsideMessage, "5.5", "topside message" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// How it came.
        transport: Transport as Transport, "code";
        /// The message.
        text: Text as LastText, "text";
    }
    "$BFTOP,081025.987,3,come home*6D"

    /// The payload may begin to trigger the DVL, or must stop.
    "BFDVT" DvlTriggering, "5.6", "begin/end DVL external triggering" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Whether the payload may begin; if not, it must stop.
        begin: bool as Flag, "flag";
    }
    "$BFDVT,081025.987,1*65"

    /// The version of the interface that the vehicle speaks: its first message on a connection.
    "BFVER" VehicleVersion, "5.7", "vehicle interface version" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// `1.12`.
        version: Text as Text, "text";
    }
    "$BFVER,081025.987,1.12*4F"

    /// The vehicle's position and attitude.
    "BFNVG" Navigation, "6.1", "navigation update" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Where the vehicle is.
        position: Position as Position, "deg";
        /// Whether GPS is in the solution.
        quality: PositionQuality as PositionQuality, "code";
        /// Altitude above the seabed; `None` (zero or empty on the wire) without bottom lock.
        altitude: Option<Altitude> as BottomLock, "m";
        /// Depth below the surface.
        depth: Depth as Depth, "m";
        /// Heading from the north of the UTM grid.
        heading: GridHeading as GridHeading, "deg";
        /// Roll, degrees.
        roll_deg: f64 as Decimal<3>, "deg";
        /// Pitch, degrees.
        pitch_deg: f64 as Decimal<3>, "deg";
        /// When the navigation solution was computed, UTC.
        solution: TimeOfDay as TimeOfDay, "UTC";
    }
    "$BFNVG,081025.987,4221.810920,N,07106.846030,W,1,45.3,20.1,203.1,-3.4,4.5,081025.980*4E"

    /// The vehicle's velocity and angular rates. The header of 6.2 misprints the last field's letter; it is the yaw
    /// rate.
    "BFNVR" VelocityAndRates, "6.2", "velocity and rate update" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Velocity east, metres per second.
        east_mps: f64 as Decimal<4>, "m/s";
        /// Velocity north, metres per second.
        north_mps: f64 as Decimal<4>, "m/s";
        /// Velocity down, metres per second.
        down_mps: f64 as Decimal<4>, "m/s";
        /// Pitch rate, degrees per second.
        pitch_rate_dps: f64 as Decimal<4>, "deg/s";
        /// Roll rate, degrees per second.
        roll_rate_dps: f64 as Decimal<4>, "deg/s";
        /// Yaw rate, degrees per second.
        yaw_rate_dps: f64 as Decimal<4>, "deg/s";
    }
    "$BFNVR,081025.987,-0.5864,-1.3746,0.02,0.1,-0.25,1.5*51"

    /// The status of the links to the topside.
    "BFTEL" Telemetry, "6.3", "telemetry status" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// How much the acoustic uplink can still carry in the coming minute, kilobytes.
        acoustic_up_available_kb: f64 as Decimal<3>, "kB";
        /// How much the acoustic uplink carried in the last minute, kilobytes.
        acoustic_up_last_kb: f64 as Decimal<3>, "kB";
        /// How much the acoustic downlink can still carry in the coming minute, kilobytes.
        acoustic_down_available_kb: f64 as Decimal<3>, "kB";
        /// How much the acoustic downlink carried in the last minute, kilobytes.
        acoustic_down_last_kb: f64 as Decimal<3>, "kB";
        /// Whether the RF modem is connected.
        rf_connected: bool as Flag, "flag";
        /// Whether Ethernet is available.
        ethernet_available: bool as Flag, "flag";
    }
    "$BFTEL,081025.987,1.5,0.25,2,0.5,0,1*48"

    /// Speed of sound, measured, or estimated if the vehicle has no sensor.
    "BFSVS" SoundVelocity, "6.4", "sound velocity" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Speed of sound, metres per second.
        sound_velocity_mps: f64 as Decimal<3>, "m/s";
    }
    "$BFSVS,081025.987,1492.31*66"

    /// The raw reading of one compass. The second header of 6.5 misprints the name as BFRDM.
    "BFRCM" Compass, "6.5", "raw compass data" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Which compass, from 1.
        number: u32 as u32, "count";
        /// Heading, degrees.
        heading_deg: f64 as Decimal<3>, "deg";
        /// Pitch, degrees.
        pitch_deg: f64 as Decimal<3>, "deg";
        /// Roll, degrees.
        roll_deg: f64 as Decimal<3>, "deg";
        /// When the data were received, UTC.
        measured: TimeOfDay as TimeOfDay, "UTC";
    }
    "$BFRCM,081025.987,1,203.1,4.5,-3.4,081025.950*66"

    /// The raw reading of the depth sensor.
    "BFRDP" DepthSensor, "6.6", "raw depth sensor data" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Pressure, kilopascals.
        pressure_kpa: f64 as Decimal<4>, "kPa";
    }
    "$BFRDP,081025.987,303.4125*48"

    /// The thruster's speed of rotation. Only vehicles with a tailcone send it.
    "BFRVL" VehicleSpeed, "6.7", "raw vehicle speed" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Turns of the thruster per minute.
        thruster_rpm: f64 as Decimal<3>, "rpm";
        /// The speed through the water that corresponds to these turns, metres per second; `None` if the vehicle has no
        /// table for it.
        water_speed_mps: Option<f64> as OrDefault<Optional<Decimal<4>>>, "m/s";
    }
    "$BFRVL,081025.987,250.5,1.5*70"

    /// One battery, or all together. A vehicle leaves a value that it does not know empty, or leaves it out.
    "BFRBS" Battery, "6.8", "battery voltage" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Which battery, from 1; 0 is all of them together.
        number: u32 as u32, "count";
        /// Voltage of the whole stack, volts.
        voltage_v: Option<f64> as OrDefault<Optional<Decimal<4>>>, "V";
        /// Voltage of the weakest cell, volts.
        cell_min_v: Option<f64> as OrDefault<Optional<Decimal<4>>>, "V";
        /// Voltage of the strongest cell, volts.
        cell_max_v: Option<f64> as OrDefault<Optional<Decimal<4>>>, "V";
        /// Temperature of the hottest cell, degrees Celsius.
        temperature_c: Option<f64> as OrDefault<Optional<Decimal<4>>>, "degC";
        /// Capacity, kilowatt-hours.
        capacity_kwh: Option<f64> as OrDefault<Optional<Decimal<4>>>, "kWh";
        /// State of charge, percent. Any value is read, and only 0 to 100 is written.
        charge_percent: Option<f64> as OrDefault<Optional<Percent>>, "%";
    }
    "$BFRBS,081025.987,0,29.85,3.71,3.75,18.5,3.2,87.5*64"

    /// A behavior begins.
    "BFMBS" BehaviorBegin, "6.9", "begin new behavior" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// The dive file; empty if the payload requested the behavior.
        dive_file: Text as Text, "text";
        /// Its number in the dive file; `None` if the payload requested it.
        number: Option<u32> as Optional<u32>, "count";
        /// The payload's identifier, if the payload requested it.
        identifier: Option<BehaviorId> as IdentifierOrEmpty, "identifier";
        /// `trackline`, `waypoint`, `setpoint` and others.
        kind: Text as LastText, "text";
    }
    "$BFMBS,081025.987,survey.dive,3,,trackline*1E"

    /// A behavior ends.
    "BFMBE" BehaviorEnd, "6.10", "end behavior" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// The dive file; empty if the payload requested the behavior.
        dive_file: Text as Text, "text";
        /// Its number in the dive file; `None` if the payload requested it.
        number: Option<u32> as Optional<u32>, "count";
        /// The payload's identifier, if the payload requested it.
        identifier: Option<BehaviorId> as IdentifierOrEmpty, "identifier";
        /// As in [`BehaviorBegin`].
        kind: Text as LastText, "text";
    }
    "$BFMBE,081025.987,,,1001,trackline*15"

    /// The mission's state has changed.
    "BFMIS" MissionStatus, "6.11", "mission status" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// The dive file, or empty.
        dive_file: Text as Text, "text";
        /// `Ready`, `Running` (perhaps with the logging directory after it), `Aborting` and others. Some vehicles send
        /// junk.
        status: Text as Text, "text";
        /// For people and logs.
        details: Text as LastText, "text";
    }
    "$BFMIS,081025.987,survey.dive,Running 2015-02-09,*01"

    /// The angles of the tailcone. Only vehicles with a tailcone send it.
    "BFERC" ControlSurfaces, "6.12", "elevator and rudder data" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Elevator, degrees, positive pitches up.
        elevator_deg: f64 as Decimal<3>, "deg";
        /// Rudder, degrees, positive to starboard.
        rudder_deg: f64 as Decimal<3>, "deg";
        /// Elevator as commanded, degrees, positive pitches up.
        elevator_target_deg: f64 as Decimal<3>, "deg";
        /// Rudder as commanded, degrees, positive to starboard.
        rudder_target_deg: f64 as Decimal<3>, "deg";
    }
    "$BFERC,081025.987,-2.5,1.25,-3,1.5*42"

    /// The raw reading of the Doppler log. 6.13 misprints the unit of the ranges as m/s.
    "BFDVL" Dvl, "6.13", "raw DVL data" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Velocity forward, to starboard and down, metres per second.
        velocity_mps: [Option<f64>; 3] as Each<Optional<Decimal<4>>, 3>, "m/s";
        /// Range along each beam, metres.
        ranges_m: [Option<f64>; 4] as Each<Optional<Decimal<3>>, 4>, "m";
        /// Temperature, degrees Celsius.
        temperature_c: Option<f64> as Optional<Decimal<4>>, "degC";
        /// When the data were received, UTC.
        measured: TimeOfDay as TimeOfDay, "UTC";
    }
    "$BFDVL,081025.987,1.5,-0.02,0.01,45.1,45.3,44.9,45,10.25,081025.900*6D"

    /// The raw reading of the Doppler log. From a hovering vehicle the velocities are along the beams. From other
    /// vehicles they are forward, to starboard, down, and the log's own error velocity. 6.14 misprints the unit of the
    /// ranges as m/s.
    "BFDV2" DvlBeams, "6.14", "raw DVL data, extended" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Velocity along each beam, metres per second.
        velocity_mps: [Option<f64>; 4] as Each<Optional<Decimal<4>>, 4>, "m/s";
        /// Range along each beam, metres.
        ranges_m: [Option<f64>; 4] as Each<Optional<Decimal<3>>, 4>, "m";
        /// Temperature, degrees Celsius.
        temperature_c: Option<f64> as Optional<Decimal<4>>, "degC";
        /// When the data were received, UTC.
        measured: TimeOfDay as TimeOfDay, "UTC";
    }
    "$BFDV2,081025.987,0.5,-0.5,0.25,-0.25,5.1,5.3,,5,10.25,081025.900*18"

    /// The raw reading of the inertial sensor.
    "BFIMU" Imu, "6.15", "raw IMU data" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Angular rates about forward, starboard and down, right-handed, degrees per second.
        rate_dps: [f64; 3] as Each<Decimal<6>, 3>, "deg/s";
        /// Accelerations forward, to starboard and down, metres per second squared.
        acceleration_mps2: [f64; 3] as Each<Decimal<6>, 3>, "m/s^2";
        /// When the data were received, UTC.
        measured: TimeOfDay as TimeOfDay, "UTC";
    }
    "$BFIMU,081025.987,0.01,-0.02,1.5,0.123456,0,-9.81,081025.980*4C"

    /// A measurement of the vehicle's conductivity, temperature and pressure sensor.
    "BFCTD" Ctd, "6.16", "raw CTD sensor data" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Conductivity, microsiemens per centimetre.
        conductivity_us_per_cm: f64 as Decimal<3>, "uS/cm";
        /// Temperature, degrees Celsius.
        temperature_c: f64 as Decimal<4>, "degC";
        /// Pressure, kilopascals.
        pressure_kpa: f64 as Decimal<4>, "kPa";
        /// When the data were received, UTC.
        measured: TimeOfDay as TimeOfDay, "UTC";
    }
    "$BFCTD,081025.987,42914,10.25,303.4,081025.900*4C"

    /// The position of a hovering vehicle, relative to where it began.
    "BFRNV" RelativeNavigation, "6.17", "relative navigation position" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Horizontal position, metres.
        horizontal_m: f64 as Decimal<3>, "m";
        /// Vertical position, metres.
        vertical_m: f64 as Decimal<3>, "m";
        /// Distance from the target, metres.
        distance_m: f64 as Decimal<3>, "m";
        /// Heading, degrees; zero is towards the target.
        heading_deg: f64 as Decimal<3>, "deg";
        /// Depth, metres.
        depth_m: f64 as Decimal<3>, "m";
        /// Heading that is not relative to the target, degrees. It is not a compass heading.
        absolute_heading_deg: f64 as Decimal<3>, "deg";
        /// Roll, degrees.
        roll_deg: f64 as Decimal<3>, "deg";
        /// Pitch, degrees.
        pitch_deg: f64 as Decimal<3>, "deg";
        /// When the navigation solution was computed, UTC.
        solution: TimeOfDay as TimeOfDay, "UTC";
    }
    "$BFRNV,081025.987,-1.25,2.5,1.5,-3,4.75,187.5,0.5,-0.25,081025.980*43"

    /// The directions in which the DVL and the sonar of a hovering vehicle point.
    "BFPIT" ServoPositions, "6.18", "pitch servo positions" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Position of the DVL, degrees.
        dvl_deg: f64 as Decimal<3>, "deg";
        /// Position of the sonar, degrees.
        sonar_deg: f64 as Decimal<3>, "deg";
    }
    "$BFPIT,081025.987,-90,45.5*4D"

    /// The position of a hovering vehicle in an inertial frame.
    "BFCNV" CartesianNavigation, "6.19", "cartesian relative navigation position" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Along x, metres.
        x_m: f64 as Decimal<3>, "m";
        /// Along y, metres.
        y_m: f64 as Decimal<3>, "m";
        /// Along z, metres.
        z_m: f64 as Decimal<3>, "m";
        /// Heading, degrees; zero is towards the target.
        heading_deg: f64 as Decimal<3>, "deg";
    }
    "$BFCNV,081025.987,12.25,-3.5,4.75,90*5B"

    /// One point of the mission plan. If a behavior has several points, their messages number them.
    "BFPLN" PlanElement, "6.20", "mission plan element" {
        /// When the message was made, UTC, which is not when the behavior runs.
        created: TimeOfDay as Created, "UTC";
        /// The behavior's number in the dive file; `None` if the payload requested it.
        number: Option<u32> as Optional<u32>, "count";
        /// The payload's identifier, if the payload requested it.
        identifier: Option<BehaviorId> as IdentifierOrEmpty, "identifier";
        /// The point's place among those of its behavior.
        index: u32 as u32, "count";
        /// The kind of the point.
        element: PlanElementKind as PlanElementKind, "code";
        /// The position. The plan has no depths.
        position: Position as Then<Position, ThreeEmpty>, "deg";
    }
    "$BFPLN,081025.987,3,,0,1,4221.810920,N,07106.846030,W,,,*55"

    /// The outcome of a command. 6.21 misprints the name as BFAK and prints a trailing comma that real vehicles leave
    /// out.
    "BFACK" Acknowledgement, "6.21", "message acknowledgement" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// The command's name, such as `RMB`.
        command: CommandName as CommandName, "name";
        /// The command's own time as the vehicle echoes it; midnight if the command had no time.
        command_created: EchoedTime as EchoedTime, "UTC";
        /// The identifier of the insert that the command requested, or `None` (0 or empty).
        behavior: Option<BehaviorId> as IdentifierOrZero, "identifier";
        /// The outcome.
        status: AckStatus as Then<AckStatus, Zero>, "code";
        /// For people and logs.
        text: Text as LastText, "text";
    }
    "$BFACK,081025.987,RMB,081025.950,0,2,0,accepted*05"

    /// The trim estimate, and the state of a trim adjustment.
    "BFTRM" TrimStatus, "6.22", "trim status" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// The state of the adjustment.
        status: AdjustmentStatus as AdjustmentStatus, "code";
        /// The error of the adjustment.
        error: AdjustmentError as AdjustmentError, "code";
        /// For people and logs.
        text: Text as Text, "text";
        /// Pitch by the trim estimator, degrees.
        pitch_deg: f64 as Decimal<4>, "deg";
        /// Roll by the trim estimator, degrees.
        roll_deg: f64 as Decimal<4>, "deg";
    }
    "$BFTRM,081025.987,1,0,trimming,0.5,-0.25*48"

    /// The buoyancy estimate, and the state of a buoyancy adjustment.
    "BFBOY" BuoyancyStatus, "6.23", "buoyancy status" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// The state of the adjustment.
        status: AdjustmentStatus as AdjustmentStatus, "code";
        /// The error of the adjustment.
        error: AdjustmentError as AdjustmentError, "code";
        /// For people and logs.
        text: Text as Text, "text";
        /// Buoyancy by the estimator, newtons.
        buoyancy_n: f64 as Decimal<4>, "N";
    }
    "$BFBOY,081025.987,3,3,at limit,-12.5*1F"

    /// Gives control to the payload or takes it back. The format line of 6.24 misprints the name as BFVER.
    "BFCTL" BackseatControl, "6.24", "backseat control" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Whether the payload has control now.
        granted: bool as Flag, "flag";
    }
    "$BFCTL,081025.987,1*78"

    /// The payload may send acoustic packets until a time. The header of 9.1 prints a superfluous comma at the end.
    "BFCMA" MediumAccess, "9.1", "communications medium access" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// When the window ends, UTC.
        until: TimeOfDay as TimeOfDay, "UTC";
        /// Address of the modem.
        address: u32 as u32, "address";
        /// `Sonardyne6G`, `WHOI`, `WHOIPSK`.
        device: Text as LastText, "text";
    }
    "$BFCMA,081025.987,081055.987,7,WHOIPSK*2A"

    /// A packet has been sent, one of ours or one of the vehicle's.
    "BFCPS" PacketSent, "9.2", "communications packet sent" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// When the packet was sent, UTC.
        sent: TimeOfDay as TimeOfDay, "UTC";
        /// Identifier of the request, as BPCPD gave it.
        request: u32 as u32, "identifier";
        /// The number of frames that were sent; 0 is read as well.
        frames: u32 as FrameCount, "count";
        /// The outcome of each frame.
        statuses: [FrameSentStatus; 8] as Each<OrDefault<FrameSentStatus>, 8>, "code";
    }
    "$BFCPS,081025.987,081024.500,4711,2,2,3,0,0,0,0,0,0*76"

    /// A packet has been received that was addressed to this vehicle or to another one.
    "BFCPR" PacketReceived, "9.3", "communications packet received data" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// When the packet arrived, UTC.
        arrived: TimeOfDay as TimeOfDay, "UTC";
        /// Address of the modem that sent it.
        source: u32 as u32, "address";
        /// The address of the receiving modem.
        destination: u32 as u32, "address";
        /// The modem's mode of transmission; -1 if it is unknown.
        mode: i32 as i32, "code";
        /// The number of frames that were received; 0 is read as well.
        frames: u32 as FrameCount, "count";
        /// The frames; unset and empty beyond their number.
        data: [ReceivedFrame; 8] as ReceivedFrames, "status and bytes";
    }
    "$BFCPR,081025.987,081025.500,3,7,-1,2,1,48656C6C6F,6,00FF,0,,0,,0,,0,,0,,0,*14"
}

impl MissionStatus {
    /// Whether the mission runs: the status begins with `Running`. Any other status means that it does not run.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.status.as_str().starts_with("Running")
    }
}

#[cfg(test)]
mod tests;
