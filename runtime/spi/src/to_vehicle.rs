use backseat_units::{Position, TimeOfDay};

use crate::codes::{HorizontalMode, Interrupt, ModifySpeedMode, ModifyVerticalMode, SpeedMode, VerticalMode};
use crate::forms::{Created, Decimal, EntryAngle, Flag, LastText, OnOff, Optional, Word};
use crate::identity::BehaviorId;
use crate::table::messages;
use crate::text::Text;

messages! {
    /// What the payload sends (SPI 7).
    pub enum ToVehicle from crate::Direction::ToVehicle;

    /// Turns the sending of one kind of status message on or off.
    "BPLOG" LoggingControl, "7.1", "logging control" {
        /// Three letters, `NVG`, or `ALL`, which leaves BFACK out.
        message: Text as Word, "name";
        /// On or off.
        on: bool as OnOff, "flag";
    }
    "$BPLOG,NVG,ON*08"

    /// How the payload is. Not ok feeds the vehicle's fixed safety rules.
    "BPSTS" PayloadStatus, "7.2", "payload status message" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// All ok, or failed.
        ok: bool as Flag, "flag";
        /// For people and logs.
        text: Text as LastText, "text";
    }
    "$BPSTS,081025.987,1,all ok*08"

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
        /// What the vertical value is.
        vertical_mode: VerticalMode as VerticalMode, "code";
        /// Depth or altitude, metres.
        vertical_m: f64 as Decimal<3>, "m";
        /// Speed, metres per second or turns a minute.
        speed: f64 as Decimal<3>, "m/s or rpm";
        /// What the speed is.
        speed_mode: SpeedMode as SpeedMode, "code";
        /// When the line begins.
        interrupt: Interrupt as Interrupt, "code";
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
        /// How many times round, clockwise where positive.
        orbits: f64 as Decimal<3>, "count";
        /// What the vertical value is.
        vertical_mode: VerticalMode as VerticalMode, "code";
        /// Depth or altitude, metres.
        vertical_m: f64 as Decimal<3>, "m";
        /// Speed, metres per second or turns a minute.
        speed: f64 as Decimal<3>, "m/s or rpm";
        /// What the speed is.
        speed_mode: SpeedMode as SpeedMode, "code";
        /// Where on the circle to begin, degrees clockwise from its northmost point. The header of 7.6 lacks it; it is
        /// read with and without, and always written, empty where `None`.
        entry_angle_deg: Option<f64> as EntryAngle, "deg";
        /// When the circle begins.
        interrupt: Interrupt as Interrupt, "code";
    }
    "$BPRTC,081025.987,1002,4221.810920,N,07106.846030,W,50,-2,0,15,1.5,0,180,4*5C"

    /// Takes back a trackline or trackcircle that has not begun.
    "BPRCN" CancelBehavior, "7.8", "cancel requested behavior" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// The identifier of the behavior.
        identifier: BehaviorId as BehaviorId, "identifier";
    }
    "$BPRCN,081025.987,1001*5B"

    /// Takes back all requested behaviors, perhaps those of other payloads too.
    "BPRCA" CancelAll, "7.9", "cancel all requested behaviors" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
    }
    "$BPRCA,081025.987*78"

    /// Gives heading, depth or altitude, and speed for the next 5 s at most. What is `None` stays as the current
    /// behavior has it.
    "BPRMB" ModifyBehavior, "7.12", "modify current behavior" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// Heading or rudder, degrees. The specification does not say which north a heading counts from.
        horizontal: Option<f64> as Optional<Decimal<3>>, "deg";
        /// Depth or altitude, metres; pitch or elevator, degrees, in those modes.
        vertical_m: Option<f64> as Optional<Decimal<3>>, "m";
        /// What the vertical value is.
        vertical_mode: Option<ModifyVerticalMode> as Optional<ModifyVerticalMode>, "code";
        /// Speed, metres per second or turns a minute.
        speed: Option<f64> as Optional<Decimal<3>>, "m/s or rpm";
        /// What the speed is.
        speed_mode: Option<ModifySpeedMode> as Optional<ModifySpeedMode>, "code";
        /// What the horizontal value is.
        horizontal_mode: Option<HorizontalMode> as Optional<HorizontalMode>, "code";
    }
    "$BPRMB,081025.987,90,3,0,1.5,1,0*54"

    /// Ends a modify at once.
    "BPEMB" EndModify, "7.13", "end behavior modify" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
    }
    "$BPEMB,081025.987*62"

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

    /// The version of the interface that the payload speaks.
    "BPVER" PayloadVersion, "7.25", "payload interface version" {
        /// When the message was made, UTC.
        created: TimeOfDay as Created, "UTC";
        /// `1.12`.
        version: Text as Text, "text";
    }
    "$BPVER,081025.987,1.12*59"
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
    fn a_trackcircle_is_read_without_its_entry_angle_and_written_with_it() {
        let start = "$BPRTC,081025.987,7,4221.8,N,07106.8,W,50,-2,0,15,1.5,0";
        let circle = |end: &str| {
            let ToVehicle::Trackcircle(circle) = decode(&format!("{start},{end}")) else {
                panic!("another message")
            };
            circle
        };
        assert_eq!(circle("180.0,4").entry_angle_deg, Some(180.0));
        assert_eq!(
            (circle("4").entry_angle_deg, circle("4").interrupt),
            (None, Interrupt::InterruptCurrent)
        );
        assert_eq!(circle("4"), circle(",4"));
        assert!(encode(circle("4")).contains(",1.5,0,,4*"));
    }

    #[test]
    fn commands_say_when_they_were_made_if_they_do() {
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
