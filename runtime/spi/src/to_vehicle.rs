use backseat_units::{Position, TimeOfDay};

use crate::circle_entry::CircleEntry;
use crate::codes::{
    AbortReason, DurationUnit, HorizontalMode, Interrupt, ModifySpeedMode, ModifyVerticalMode, SpeedMode, SurfaceMode,
    Transport, VerticalMode, VerticalReference,
};
use crate::forms::{Created, Decimal, Flag, LastText, Nine, OnOff, Optional, OrDefault, Then, Word, Zero};
use crate::identity::BehaviorId;
use crate::packet::FrameData;
use crate::table::messages;
use crate::text::{RelayedText, Text};

messages! {
    /// The messages that the payload sends (SPI 7, 8 and 9).
    pub enum ToVehicle from crate::Direction::ToVehicle;

    /// Turns the sending of one kind of status message on or off.
    "BPLOG" LoggingControl, "7.1", "logging control" {
        /// Three letters such as `NVG`, or `ALL`, which does not include BFACK.
        message: Text as Word, "name";
        /// On or off.
        on: bool as OnOff, "flag";
    }
    "$BPLOG,NVG,ON*08"

    /// The status of the payload. A status that is not ok goes into the vehicle's fixed safety rules.
    "BPSTS" PayloadStatus, "7.2", "payload status message" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Whether all is ok.
        ok: bool as Flag, "flag";
        /// For people and logs.
        text: Text as LastText, "text";
    }
    "$BPSTS,081025.987,1,all ok*08"

    /// Asks the vehicle to send a message to the topside by the best available link.
    "BPTOP" TopsideText, "7.3", "request to send data topside" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// The slowest link that is worth using for the message; vehicles may ignore it.
        slowest: Transport as Transport, "code";
        /// The message.
        text: Text as Then<LastText, Zero>, "text";
    }
    "$BPTOP,081025.987,3,target 3 found,0*18"

    /// Whether the payload wants to trigger the DVL, and whether it triggers it now.
    "BPDVR" DvlTriggerRequest, "7.4", "request to change DVL triggering method" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Whether the payload asks for external triggering; if not, it asks to end it.
        external: bool as Flag, "flag";
        /// Whether the payload triggers the DVL now.
        triggering: bool as Flag, "flag";
    }
    "$BPDVR,081025.987,1,0*69"

    /// Asks for a survey line, with the vehicle's default lead-in and lead-out.
    "BPRTK" Trackline, "7.5", "request additional trackline" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// The payload's identifier for it.
        identifier: BehaviorId as BehaviorId, "identifier";
        /// Where the line starts.
        start: Position as Position, "deg";
        /// Where the line ends.
        end: Position as Position, "deg";
        /// The meaning of the vertical value.
        vertical_mode: VerticalMode as VerticalMode, "code";
        /// Depth or altitude, metres.
        vertical_m: f64 as Decimal<3>, "m";
        /// Speed, metres per second or turns of the thruster per minute.
        speed: f64 as Decimal<3>, "m/s or rpm";
        /// The unit of the speed.
        speed_mode: SpeedMode as SpeedMode, "code";
        /// When the line begins. A missing or empty field is read as after the current behavior.
        interrupt: Interrupt as OrDefault<Interrupt>, "code";
    }
    "$BPRTK,081025.987,1001,4221.810920,N,07106.846030,W,4221.910920,N,07106.846030,W,1,10,1.5,0,0*7E"

    /// Asks for a circle.
    "BPRTC" Trackcircle, "7.6", "request additional trackcircle" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// The payload's identifier for it.
        identifier: BehaviorId as BehaviorId, "identifier";
        /// The circle's centre.
        centre: Position as Position, "deg";
        /// The circle's radius, metres.
        radius_m: f64 as Decimal<3>, "m";
        /// The number of orbits, clockwise if positive.
        orbits: f64 as Decimal<3>, "count";
        /// The meaning of the vertical value.
        vertical_mode: VerticalMode as VerticalMode, "code";
        /// Depth or altitude, metres.
        vertical_m: f64 as Decimal<3>, "m";
        /// Speed, metres per second or turns of the thruster per minute.
        speed: f64 as Decimal<3>, "m/s or rpm";
        /// The unit of the speed.
        speed_mode: SpeedMode as SpeedMode, "code";
        /// Where on the circle to begin. The header of 7.6 lacks the field and its table has it, so both forms are
        /// read.
        entry_angle_deg: CircleEntry as CircleEntry, "deg";
        /// When the circle begins. A missing or empty field is read as after the current behavior.
        interrupt: Interrupt as OrDefault<Interrupt>, "code";
    }
    "$BPRTC,081025.987,1002,4221.810920,N,07106.846030,W,50,-2,0,15,1.5,0,180,4*5C"

    /// Asks to surface for GPS. The header of 7.7 misprints the letter of the time to surface.
    "BPRGP" GpsHit, "7.7", "request additional GPS hits" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// The payload's identifier for it.
        identifier: BehaviorId as BehaviorId, "identifier";
        /// Where to surface.
        position: Position as Position, "deg";
        /// The longest time to the surface, seconds. Vehicles ignore it.
        surface_within_s: Option<f64> as Optional<Decimal<3>>, "s";
        /// How many fixes to get. Vehicles ignore it.
        hits: Option<u32> as Optional<u32>, "count";
        /// How to surface.
        mode: SurfaceMode as SurfaceMode, "code";
    }
    "$BPRGP,081025.987,1003,4221.810920,N,07106.846030,W,120,5,0*7E"

    /// Cancels a trackline or trackcircle that has not begun.
    "BPRCN" CancelBehavior, "7.8", "cancel requested behavior" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// The identifier of the behavior.
        identifier: BehaviorId as BehaviorId, "identifier";
    }
    "$BPRCN,081025.987,1001*5B"

    /// Cancels all requested behaviors, perhaps including those of other payloads.
    "BPRCA" CancelAll, "7.9", "cancel all requested behaviors" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
    }
    "$BPRCA,081025.987*78"

    /// Ends the current behavior, whoever requested it. The next behavior of the mission begins.
    "BPRCB" CancelCurrent, "7.10", "cancel current behavior" {
        /// When the message was made, UTC.
        created: TimeOfDay as Then<Created, Zero>, "UTC";
    }
    "$BPRCB,081025.987,0*67"

    /// Ends the current mission element, as the planner counts elements. The next element begins.
    "BPRCE" CancelElement, "7.11", "cancel current mission element" {
        /// When the message was made, UTC.
        created: TimeOfDay as Then<Created, Zero>, "UTC";
    }
    "$BPRCE,081025.987,0*60"

    /// Sets heading, depth or altitude, and speed for the next 5 s at most. A value that is `None` stays that of the
    /// current behavior.
    "BPRMB" ModifyBehavior, "7.12", "modify current behavior" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Heading or rudder, degrees. The specification does not say from which north a heading counts.
        horizontal: Option<f64> as Optional<Decimal<3>>, "deg";
        /// Depth or altitude, metres; pitch or elevator, degrees, in those modes.
        vertical_m: Option<f64> as Optional<Decimal<3>>, "m";
        /// The meaning of the vertical value.
        vertical_mode: Option<ModifyVerticalMode> as Optional<ModifyVerticalMode>, "code";
        /// Speed, metres per second or turns of the thruster per minute.
        speed: Option<f64> as Optional<Decimal<3>>, "m/s or rpm";
        /// The unit of the speed.
        speed_mode: Option<ModifySpeedMode> as Optional<ModifySpeedMode>, "code";
        /// The meaning of the horizontal value.
        horizontal_mode: Option<HorizontalMode> as Optional<HorizontalMode>, "code";
    }
    "$BPRMB,081025.987,90,3,0,1.5,1,0*54"

    /// Ends a modify at once.
    "BPEMB" EndModify, "7.13", "end behavior modify" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
    }
    "$BPEMB,081025.987*62"

    /// Passes on a message from the topside that came through the payload's own modem.
    "BPTMR" TopsideRelay, "7.14", "topside message relay" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// How it came.
        transport: Transport as Transport, "code";
        /// The message as it came, with its delimiters: everything up to the checksum. A message that holds `$BP` is
        /// not written.
        text: RelayedText as RelayedText, "text";
    }
    "$BPTMR,081025.987,3,abort*3A"

    /// A measurement of the payload's conductivity, temperature and pressure sensor, which helps the vehicle's
    /// navigation.
    "BPCTD" PayloadCtd, "7.15", "raw CTD sensor data" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Conductivity, microsiemens per centimetre.
        conductivity_us_per_cm: f64 as Decimal<3>, "uS/cm";
        /// Temperature, degrees Celsius.
        temperature_c: f64 as Decimal<4>, "degC";
        /// Pressure, kilopascals.
        pressure_kpa: f64 as Decimal<4>, "kPa";
        /// When it was measured, UTC.
        measured: TimeOfDay as TimeOfDay, "UTC";
    }
    "$BPCTD,081025.987,42914,10.25,303.4,081025.900*5A"

    /// Ends the mission. The vehicle then wraps it up.
    "BPABT" Abort, "7.16", "abort mission" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// For people and logs.
        text: Text as LastText, "text";
        /// The reason. A missing or empty field is read as errors.
        reason: AbortReason as OrDefault<AbortReason>, "code";
    }
    "$BPABT,081025.987,leak in bay 2,1*22"

    /// Ends the mission and all movement. The vehicle drifts.
    "BPKIL" Kill, "7.17", "kill mission" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// For people and logs.
        text: Text as LastText, "text";
    }
    "$BPKIL,081025.987,leak in bay 2*26"

    /// A line for the vehicle's logs.
    "BPMSG" LogMessage, "7.18", "log message" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// The line.
        text: Text as Text, "text";
    }
    "$BPMSG,081025.987,line 3 done*60"

    /// Asks for the mission plan, which comes as BFPLN messages.
    "BPRMP" RequestPlan, "7.19", "request mission plan" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
    }
    "$BPRMP,081025.987*67"

    /// Starts a mission that does only what the payload asks for.
    "BPSEM" StartEmptyMission, "7.20", "start empty mission" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// The longest duration of the mission.
        duration: f64 as Decimal<3>, "h, min or s";
        /// The unit of the duration.
        unit: DurationUnit as DurationUnit, "code";
    }
    "$BPSEM,081025.987,1.5,0*69"

    /// A position for the vehicle's navigation, from an acoustic positioning system or a similar source. The header of
    /// 7.21 misprints the name as BPNU.
    "BPNPU" PositionFix, "7.21", "navigation position update" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// The position.
        position: Position as Position, "deg";
        /// The radius within which the vehicle is with a probability of one half, metres.
        error_m: f64 as Decimal<3>, "m";
        /// Depth, metres.
        depth_m: f64 as Decimal<3>, "m";
        /// Whether the vehicle must accept the position.
        force: bool as Flag, "flag";
        /// When the position was measured, UTC.
        measured: TimeOfDay as TimeOfDay, "UTC";
    }
    "$BPNPU,081025.987,4221.810920,N,07106.846030,W,12.5,20.1,0,081024.500*65"

    /// Silences the devices that could disturb acoustic sensors, or ends the silence.
    "BPSIL" SilentMode, "7.22", "silent mode" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Silent mode, or normal mode.
        silent: bool as Flag, "flag";
    }
    "$BPSIL,081025.987,1*63"

    /// Asks the vehicle to level itself.
    "BPTRM" TrimAdjustment, "7.23", "request trim adjustment behavior" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
    }
    "$BPTRM,081025.987*63"

    /// Asks the vehicle to adjust its buoyancy.
    "BPBOY" BuoyancyAdjustment, "7.24", "request buoyancy adjustment behavior" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
    }
    "$BPBOY,081025.987*7C"

    /// The version of the interface that the payload speaks.
    "BPVER" PayloadVersion, "7.25", "payload interface version" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// `1.12`.
        version: Text as Text, "text";
    }
    "$BPVER,081025.987,1.12*59"

    /// Suspends the mission of a hovering vehicle, for 2 s from the last such message.
    "BPSUS" Suspend, "8.1", "suspend mission" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
    }
    "$BPSUS,081025.987*7D"

    /// Prolongs a suspension for 2 s.
    "BPCON" Continue, "8.2", "continue" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
    }
    "$BPCON,081025.987*6A"

    /// Ends a suspension. The mission continues.
    "BPRES" Resume, "8.3", "resume mission" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
    }
    "$BPRES,081025.987*6C"

    /// Limits the speed of movements relative to the hull. The limit outlives the suspension.
    "BPSPD" HullSpeedLimit, "8.4", "hull relative speed limit" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Speed, metres per second; vehicles start with 1.5.
        speed_mps: f64 as Decimal<3>, "m/s";
    }
    "$BPSPD,081025.987,0.5*68"

    /// Turns the sonar.
    "BPSAN" SonarAngle, "8.5", "set sonar angle" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Angle, degrees.
        angle_deg: f64 as Decimal<3>, "deg";
    }
    "$BPSAN,081025.987,-30*76"

    /// Moves a suspended vehicle along the hull, and prolongs the suspension.
    "BPGHP" HullPosition, "8.6", "go to hull position" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Horizontal position, metres.
        horizontal_m: f64 as Decimal<3>, "m";
        /// Vertical position, metres.
        vertical_m: f64 as Decimal<3>, "m";
        /// Distance from the hull, metres.
        distance_m: f64 as Decimal<3>, "m";
    }
    "$BPGHP,081025.987,2.5,-1.25,1.5*6D"

    /// Moves a suspended vehicle along the bottom, and prolongs the suspension.
    "BPGBP" BottomPosition, "8.7", "go to bottom position" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Along x, metres.
        x_m: f64 as Decimal<3>, "m";
        /// Along y, metres.
        y_m: f64 as Decimal<3>, "m";
        /// The meaning of the vertical value.
        reference: VerticalReference as VerticalReference, "code";
        /// Depth or altitude, metres.
        vertical_m: f64 as Decimal<3>, "m";
    }
    "$BPGBP,081025.987,12.5,-3.25,A,2*21"

    /// Tells a hovering vehicle where it is.
    "BPRNS" RelativeReset, "8.8", "reset relative navigation" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Along x, metres.
        x_m: f64 as Decimal<3>, "m";
        /// Along y, metres.
        y_m: f64 as Decimal<3>, "m";
        /// Bearing, degrees.
        bearing_deg: f64 as Decimal<3>, "deg";
    }
    "$BPRNS,081025.987,1.5,-2.25,90*5E"

    /// Adds to the inertial bearing of a hovering vehicle.
    "BPRBO" BearingOffset, "8.9", "hull relative bearing offset" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// The angle to add, degrees.
        offset_deg: f64 as Decimal<3>, "deg";
    }
    "$BPRBO,081025.987,-2.5*5F"

    /// Moves the camera. Each value is a movement in tenths of a second.
    "BPPTZ" Camera, "8.10", "pan tilt zoom camera control" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Pan, -9 to 9.
        pan: i32 as Nine, "0.1 s";
        /// Tilt, -9 to 9.
        tilt: i32 as Nine, "0.1 s";
        /// Zoom, -9 to 9.
        zoom: i32 as Nine, "0.1 s";
    }
    "$BPPTZ,081025.987,-9,0,3*4D"

    /// Turns a light on or off. The format line of 8.11 misprints BPPTZ.
    "BPLIT" Light, "8.11", "strobe light control" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Which light. Vehicles ignore it.
        light: i32 as i32, "count";
        /// Whether to turn it on.
        on: bool as Flag, "flag";
    }
    "$BPLIT,081025.987,0,1*78"

    /// Asks the vehicle to send an acoustic packet. The payload may send this only within a window that BFCMA gave.
    "BPCPD" Packet, "9.4", "communications packet data" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// The payload's identifier for it, which BFCPS repeats.
        request: u32 as u32, "identifier";
        /// The address of the receiving modem.
        destination: u32 as u32, "address";
        /// The modem's mode of transmission.
        mode: i32 as i32, "code";
        /// Whether the receiver is to acknowledge it.
        ack: bool as Flag, "flag";
        /// The frames.
        frames: FrameData as FrameData, "bytes";
    }
    "$BPCPD,081025.987,4711,3,1,1,2,48656C6C6F,00FF,,,,,,*2E"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Sentence;

    fn decode(line: &str) -> ToVehicle {
        ToVehicle::decode(&Sentence::parse(line).unwrap()).unwrap()
    }

    fn encode(message: impl Into<ToVehicle>) -> String {
        let mut out = Vec::new();
        message.into().encode(&mut out).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn modifies_of_real_clients_are_read() {
        let created = TimeOfDay::from_hms_nano(8, 10, 25, 987_000_000).unwrap();
        let full = ModifyBehavior {
            created,
            horizontal: Some(90.0),
            vertical_m: Some(3.0),
            vertical_mode: Some(ModifyVerticalMode::Depth),
            speed: Some(1.5),
            speed_mode: Some(ModifySpeedMode::MetresPerSecond),
            horizontal_mode: Some(HorizontalMode::Heading),
        };
        assert_eq!(decode("$BPRMB,081025.987,90,3,0,1.5,1,0"), full.into());
        let rudder = ModifyBehavior {
            created,
            horizontal: None,
            vertical_m: None,
            vertical_mode: None,
            speed: Some(750.0),
            speed_mode: Some(ModifySpeedMode::Rpm),
            horizontal_mode: Some(HorizontalMode::Rudder),
        };
        assert_eq!(decode("$BPRMB,081025.987,,,,750,0,1"), rudder.clone().into());
        assert!(encode(rudder).starts_with("$BPRMB,081025.987,,,,750,0,1*"));
    }

    #[test]
    fn a_trackcircle_is_read_and_written_with_its_entry_angle_and_without() {
        let start = "$BPRTC,081025.987,7,4221.8,N,07106.8,W,50,-2,0,15,1.5,0";
        let circle = |end: &str| {
            let ToVehicle::Trackcircle(circle) = decode(&format!("{start},{end}")) else {
                panic!("another message")
            };
            circle
        };
        assert_eq!(circle("180.0,4").entry_angle_deg, CircleEntry::Angle(180.0));
        assert_eq!(
            (circle("4").entry_angle_deg, circle("4").interrupt),
            (CircleEntry::Absent, Interrupt::InterruptCurrent)
        );
        assert_eq!(circle(",4").entry_angle_deg, CircleEntry::Anywhere);
        assert!(encode(circle("4")).contains(",1.5,0,4*"));
        assert!(encode(circle(",4")).contains(",1.5,0,,4*"));
    }

    #[test]
    fn commands_with_a_time_say_when_they_were_made() {
        assert_eq!(decode("$BPLOG,NVG,ON").created(), None);
        assert_eq!(decode("$BPRMP,000001").created(), TimeOfDay::from_nanos(1_000_000_000));
    }

    #[test]
    fn logging_words_have_no_blanks_around_them() {
        let on = |message: &str| {
            ToVehicle::from(LoggingControl {
                message: Text::cleaned(message),
                on: true,
            })
        };
        assert_eq!(decode("$BPLOG, ALL ,ON"), on("ALL"));
        assert!(on(" ALL").encode(&mut Vec::new()).is_err());
        assert!(on("").encode(&mut Vec::new()).is_err());
        assert!(ToVehicle::decode(&Sentence::parse("$BPLOG,,ON").unwrap()).is_err());
    }
}
