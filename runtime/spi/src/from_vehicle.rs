use backseat_units::{Altitude, Depth, GridHeading, Position, TimeOfDay};

use crate::codes::{AckStatus, PlanElementKind, PositionQuality};
use crate::forms::{
    BottomLock, Created, Decimal, Flag, IdentifierOrEmpty, IdentifierOrZero, LastText, Optional, Then, ThreeEmpty, Zero,
};
use crate::identity::{BehaviorId, CommandName};
use crate::table::messages;
use crate::text::Text;

messages! {
    /// What the vehicle sends (SPI 5 and 6).
    pub enum FromVehicle from crate::Direction::FromVehicle;

    /// Mission command: text from a user-defined behavior of the mission file.
    "BFMSC" MissionCommand, "5.1", "payload mission command" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// What the payload makes of it.
        text: Text as Text, "text";
    }
    "$BFMSC,081025.987,start line 3*12"

    /// The payload will lose its power, in a minute at the earliest.
    "BFSHT" Shutdown, "5.2", "payload shutdown" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
    }
    "$BFSHT,081025.987*71"

    /// The version of the interface that the vehicle speaks: its first words on a connection.
    "BFVER" VehicleVersion, "5.7", "vehicle interface version" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// `1.12`.
        version: Text as Text, "text";
    }
    "$BFVER,081025.987,1.12*4F"

    /// Where the vehicle is and how it lies.
    "BFNVG" Navigation, "6.1", "navigation update" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Where the vehicle is.
        position: Position as Position, "deg";
        /// Whether GPS is in the solution.
        quality: PositionQuality as PositionQuality, "code";
        /// Height above the seabed; `None` (zero or empty on the wire) without bottom lock.
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

    /// How the vehicle moves and turns. The header of 6.2 misprints the last field's letter; it is the yaw rate.
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

    /// A behavior begins.
    "BFMBS" BehaviorBegin, "6.9", "begin new behavior" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// The dive file; empty where the payload asked for the behavior.
        dive_file: Text as Text, "text";
        /// Its number in the dive file; `None` where the payload asked for it.
        number: Option<u32> as Optional<u32>, "count";
        /// The payload's identifier, where the payload asked for it.
        identifier: Option<BehaviorId> as IdentifierOrEmpty, "identifier";
        /// `trackline`, `waypoint`, `setpoint` and others.
        kind: Text as LastText, "text";
    }
    "$BFMBS,081025.987,survey.dive,3,,trackline*1E"

    /// A behavior ends.
    "BFMBE" BehaviorEnd, "6.10", "end behavior" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// The dive file; empty where the payload asked for the behavior.
        dive_file: Text as Text, "text";
        /// Its number in the dive file; `None` where the payload asked for it.
        number: Option<u32> as Optional<u32>, "count";
        /// The payload's identifier, where the payload asked for it.
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
        /// `Ready`, `Running` (perhaps with the logging directory after it), `Aborting` and others; vehicles have been
        /// seen to send junk.
        status: Text as Text, "text";
        /// For people and logs.
        details: Text as LastText, "text";
    }
    "$BFMIS,081025.987,survey.dive,Running 2015-02-09,*01"

    /// The vehicle's conductivity, temperature and pressure sensor.
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

    /// One point of the mission plan. Behaviors of several points number them from one message to the next.
    "BFPLN" PlanElement, "6.20", "mission plan element" {
        /// When the message was made, UTC; not when the behavior runs.
        created: TimeOfDay as Created, "UTC";
        /// The behavior's number in the dive file; `None` where the payload asked for it.
        number: Option<u32> as Optional<u32>, "count";
        /// The payload's identifier, where the payload asked for it.
        identifier: Option<BehaviorId> as IdentifierOrEmpty, "identifier";
        /// The point's place among those of its behavior.
        index: u32 as u32, "count";
        /// What the point is.
        element: PlanElementKind as PlanElementKind, "code";
        /// Where it is. The plan has no depths.
        position: Position as Then<Position, ThreeEmpty>, "deg";
    }
    "$BFPLN,081025.987,3,,0,1,4221.810920,N,07106.846030,W,,,*55"

    /// What became of a command. Misprinted BFAK in 6.21, whose trailing comma real vehicles leave out.
    "BFACK" Acknowledgement, "6.21", "message acknowledgement" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// The command, `RMB`.
        command: CommandName as CommandName, "name";
        /// The command's own time, to the millisecond; midnight where it had none.
        command_created: TimeOfDay as TimeOfDay, "UTC";
        /// The identifier of the insert that the command asked for, or `None` (0 or empty).
        behavior: Option<BehaviorId> as IdentifierOrZero, "identifier";
        /// What became of it.
        status: AckStatus as Then<AckStatus, Zero>, "code";
        /// For people and logs.
        text: Text as LastText, "text";
    }
    "$BFACK,081025.987,RMB,081025.950,0,2,0,accepted*05"

    /// Hands control to the payload or takes it back. The format line of 6.24 misprints BFVER.
    "BFCTL" BackseatControl, "6.24", "backseat control" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Whether the payload has control now.
        granted: bool as Flag, "flag";
    }
    "$BFCTL,081025.987,1*78"
}

impl MissionStatus {
    /// Whether the mission runs: the status begins with `Running`. Everything else means that it does not.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.status.as_str().starts_with("Running")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{EncodeError, Fault, Sentence};

    fn decode(line: &str) -> FromVehicle {
        FromVehicle::decode(&Sentence::parse(line).unwrap()).unwrap()
    }

    fn navigation(line: &str) -> Navigation {
        let FromVehicle::Navigation(navigation) = decode(line) else {
            panic!("another message")
        };
        navigation
    }

    #[test]
    fn the_example_of_section_6_1_is_read() {
        // Its checksum is misprinted as 5b.
        let navigation =
            navigation("$BFNVG,081025.987,4221.81092,N,07106.84603,W,1,45.3,20.1,203.1,-3.4,4.5,081025.980*4E");
        assert_eq!(
            navigation.created,
            TimeOfDay::from_hms_nano(8, 10, 25, 987_000_000).unwrap()
        );
        assert!((navigation.position.latitude.as_deg() - 42.363_515_333_333).abs() < 1e-12);
        assert!((navigation.position.longitude.as_deg() + 71.114_100_5).abs() < 1e-12);
        assert_eq!(navigation.quality, PositionQuality::Gps);
        assert_eq!(navigation.altitude.map(Altitude::as_m), Some(45.3));
        assert_eq!((navigation.depth.as_m(), navigation.heading.as_deg()), (20.1, 203.1));
        assert_eq!((navigation.roll_deg, navigation.pitch_deg), (-3.4, 4.5));
        assert_eq!(
            navigation.solution,
            TimeOfDay::from_hms_nano(8, 10, 25, 980_000_000).unwrap()
        );
    }

    #[test]
    fn acknowledgements_of_real_vehicles_are_read() {
        let ack = |line: &str| {
            let FromVehicle::Acknowledgement(ack) = decode(line) else {
                panic!("another message")
            };
            ack
        };
        let log = ack("$BFACK,081025.987,BPLOG,000000.000,0,2,0,log set");
        assert_eq!(log.command, CommandName::new("LOG").unwrap());
        assert_eq!((log.command_created, log.behavior), (TimeOfDay::MIDNIGHT, None));
        assert_eq!((log.status, log.text.as_str()), (AckStatus::Succeeded, "log set"));
        let insert = ack("$BFACK,081025.987,RTK,081020.125,1001,3,0,,");
        assert_eq!(
            (insert.behavior, insert.status),
            (Some(BehaviorId::new(1001)), AckStatus::Pending)
        );
        assert_eq!(ack("$BFACK,081025.987,RMB,081020.125,,1,0").text, "");
        assert_eq!(
            ack("$BFACK,081025.987,NAK,000000.000,,0,0,what").command,
            CommandName::NAK
        );
    }

    #[test]
    fn only_running_is_running() {
        let running = |status: &str| {
            let FromVehicle::MissionStatus(status) = decode(&format!("$BFMIS,081025.987,a.dive,{status},")) else {
                panic!("another message")
            };
            status.is_running()
        };
        assert!(running("Running") && running("Running /logs/12"));
        for other in ["", " ", "Ready", "running", "WrappingUp", "Not Running", " Running"] {
            assert!(!running(other), "{other:?}");
        }
    }

    #[test]
    fn a_status_is_not_lost_to_characters_of_other_alphabets() {
        let FromVehicle::MissionStatus(status) = decode("$BFMIS,081025.987,levé.dive,Aborting,\u{7}") else {
            panic!("another message");
        };
        assert_eq!(
            (
                status.dive_file.as_str(),
                status.status.as_str(),
                status.details.as_str()
            ),
            ("lev .dive", "Aborting", " ")
        );
    }

    #[test]
    fn errors_name_message_field_and_fault() {
        let error = |line: &str| FromVehicle::decode(&Sentence::parse(line).unwrap()).unwrap_err();
        assert_eq!(
            error("$BFNVG,081025.987,4221.8,N,07106.8,W,1,45.3,deep,").to_string(),
            "BFNVG field 8 (depth) \"deep\": expected a plain decimal number of at most 1e9, without exponent"
        );
        assert_eq!(
            error("$BFNVG,081025.987,4221.8,N,07106.8,W,1,45.3,20000,").to_string(),
            "BFNVG field 8 (depth) \"20000\": depth 20000 m is not within -100 to 12000"
        );
        assert_eq!(
            error("$BFCTL,081025.987").to_string(),
            "BFCTL field 2 (granted) \"\": the field is missing"
        );
        assert_eq!(
            error("$BFACK,081025.987,RMB,081020.125,0,7,0,").to_string(),
            "BFACK field 5 (status) \"7\": expected one of 0 1 2 3"
        );
        assert_eq!(error(&format!("$BFCTL,{}", "é".repeat(100))).found.chars().count(), 32);
    }

    #[test]
    fn a_message_that_cannot_be_written_leaves_no_byte() {
        let mut out = b"before".to_vec();
        let good = navigation("$BFNVG,081025.987,4221.8,N,07106.8,W,1,45.3,20,203.1,-3.4,4.5,081025.980");
        let bad = FromVehicle::from(Navigation {
            pitch_deg: f64::NAN,
            ..good
        });
        let error = bad.encode(&mut out).unwrap_err();
        assert!(matches!(
            error,
            EncodeError::Field {
                message: "BFNVG",
                field: "pitch_deg",
                fault: Fault::Malformed { .. }
            }
        ));
        let long = FromVehicle::from(MissionCommand {
            created: TimeOfDay::MIDNIGHT,
            text: Text::cleaned(&"a".repeat(2000)),
        });
        assert!(matches!(
            long.encode(&mut out),
            Err(EncodeError::TooLong { length: 2023, .. })
        ));
        let forged = crate::UnknownMessage::new("BFCTL", &["081025.987", "1"]).unwrap();
        assert!(matches!(
            FromVehicle::Unknown(forged).encode(&mut out),
            Err(EncodeError::Known { .. })
        ));
        assert_eq!(out, b"before");
    }

    #[test]
    fn what_the_payload_sends_is_unknown_here() {
        let message = decode("$BPRMB,081025.987,90,3,0,1.5,1,0");
        let FromVehicle::Unknown(unknown) = &message else {
            panic!("{message:?}")
        };
        assert_eq!(
            (unknown.name(), unknown.fields().count(), message.created()),
            ("BPRMB", 7, None)
        );
        let mut out = Vec::new();
        message.encode(&mut out).unwrap();
        assert_eq!(out, b"$BPRMB,081025.987,90,3,0,1.5,1,0*54\r\n");
    }
}
