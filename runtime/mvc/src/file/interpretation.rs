mod answers;

use core::fmt;
use core::marker::PhantomData;

use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer};

use crate::error::{MvcError, check};

pub use answers::{AllTopics, BrokenLine, CtdPressure, UnknownCommand};

/// The `[interpretation]` section: how the vehicle reads what the specification leaves open. Each key is one reading,
/// or `"seed"`: then each seed draws a reading, so that no plugin comes to depend on one.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct InterpretationConfig {
    /// What happens to inserts when the payload loses control (BFCTL 0; SPI 6.24 and 7.5 do not say).
    pub inserts_after_control: InsertsAfterControl,
    /// What the vehicle flies after an insert that interrupted a behavior (SPI 7.5 says both).
    pub after_interrupt: AfterInterrupt,
    /// The length of the lead-in before an inserted trackline, and of the lead-out after it, metres, 0 to 500 (SPI 7.5:
    /// "any default leadin/leadout behavior"). The seed draws up to 50 m.
    pub lead_in_m: Choice<f64>,
    /// Whether the vehicle sends BFCTL and BFMIS at once to a client that switches them on late.
    pub control_replay: Choice<bool>,
    /// Whose inserts BPRCA cancels (SPI 7.9 does not say).
    pub cancel_all_scope: CancelAllScope,
    /// Which north the heading of BPRMB counts from (SPI 7.12 does not say).
    pub modify_heading: HeadingFrame,
    /// When an insert is flown if the current behavior is neither a trackline nor a trackcircle.
    pub insert_place: InsertPlace,
    /// Whether the vehicle sends BFBDL and BFSDL for inserted tracklines and trackcircles too (SPI 7.5: "with the
    /// payloads activated").
    pub insert_logging: Choice<bool>,
    /// Whose inserts BPRCN may cancel (SPI 7.8 does not say).
    pub cancel_scope: CancelAllScope,
    /// Whether BPRCA cancels GPS hits too (SPI 7.9: "all"; 7.8 names only tracklines and trackcircles).
    pub cancel_all_gps: Choice<bool>,
    /// Whether a modify goes on under the next behavior when the one that it modifies ends (SPI 7.12 does not say).
    pub modify_survives: Choice<bool>,
    /// What happens to a modify beyond the safe operating parameters (SPI 7.12: it "can not be used" for that).
    pub modify_beyond: ModifyBeyond,
    /// What the rudder and elevator of BPRMB are (SPI 7.12 calls them adjustments).
    pub modify_fins: ModifyFins,
    /// What a value of BPRMB is if the field for its mode is empty (SPI 7.12: a mode "may be empty").
    pub modify_empty_mode: ModifyEmptyMode,
    /// Whether BPSUS needs dynamic requests to be allowed (SPI 8.1 does not say). A suspension then ends with them.
    pub suspend_needs_control: Choice<bool>,
    /// From where the mission goes on after a suspension (SPI 8.3 says both).
    pub after_suspension: AfterSuspension,
    /// Which way the vertical position of BFRNV and BPGHP counts from the waterline (SPI 6.17 and 8.6 do not say).
    pub hull_vertical: HullVertical,
    /// What a request for silent mode does to a trim or buoyancy adjustment that a payload asked for (SPI 7.22 to 7.24
    /// mention only implicit adjustments).
    pub adjustment_when_silenced: AdjustmentWhenSilenced,
    /// Whether BPTRM and BPBOY fail for a client that has not switched on BFTRM or BFBOY (SPI 7.23, 7.24: "must be
    /// registered").
    pub adjustment_needs_status: Choice<bool>,
    /// Whether the vehicle sends BFDVT when the DVL goes back to internal triggering because the payload did not
    /// trigger it (SPI 7.4 says so and marks it as not implemented).
    pub dvl_timeout_announced: Choice<bool>,
    /// What BFCPS says of frames whose acknowledgement did not come (SPI 9.2 does not say).
    pub unacked_frames: UnackedFrames,
    /// What an insert may not interrupt (SPI 7.5: "it is not possible to interrupt an interruption").
    pub interruption: Interruption,
    /// Which commands the vehicle acknowledges (SPI 6.21: "each payload command", but the own sections of many commands
    /// do not mention it).
    pub acknowledged: Acknowledged,
    /// How many decimals of its command's time a BFACK repeats, 0 to 9 (SPI 6.21 prints two, recorded vehicles write
    /// three). The seed draws 2 or 3.
    pub echo_decimals: Choice<f64>,
    /// Which layout of BPRTC the vehicle reads (SPI 7.6: the header has no entry angle, the table has one).
    pub trackcircle_layout: TrackcircleLayout,
    /// How the vehicle answers a command whose name it does not know (SPI 6.21: "Name of payload command being
    /// acknowledged", but recorded vehicles write `NAK`).
    pub unknown_command: UnknownCommand,
    /// How the vehicle answers a line that is no sentence: without `$`, or without a name after it (SPI 6.21 speaks only
    /// of commands; recorded vehicles answer). A sentence with a wrong checksum gets no answer.
    pub broken_line: BrokenLine,
    /// What the pressure of BFCTD and BPCTD counts from (SPI 6.16 and 7.15 do not say). BFRDP is always absolute.
    pub ctd_pressure: CtdPressure,
    /// Which messages `BPLOG,ALL` switches (SPI 7.1: all but BFACK).
    pub all_topics: AllTopics,
}

/// Which commands the vehicle acknowledges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Acknowledged {
    /// All of them.
    #[default]
    All,
    /// Those whose own section mentions it (BPLOG, BPTOP, BPRTK, BPRTC, BPRCN, BPRMP, BPSIL, BPTRM, BPBOY), and
    /// whatever cannot be read.
    Sections,
    /// The seed draws one: `sections` in one of eight cases.
    Seed,
}

/// Which layout of BPRTC the vehicle reads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TrackcircleLayout {
    /// The table's layout, with an entry angle, or the header's if that field is missing.
    #[default]
    Either,
    /// Only the table's. If a field is missing, the interrupt code is read as the entry angle, and the interrupt code
    /// counts as missing.
    Table,
    /// Only the header's. A value in the place of the entry angle is read as the interrupt code.
    Header,
    /// The seed draws one.
    Seed,
}

/// What an insert may not interrupt.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Interruption {
    /// Every insert of a set whose first one interrupted the plan.
    #[default]
    Set,
    /// Only an insert that itself interrupted, while it is being flown.
    Behavior,
    /// The seed draws one.
    Seed,
}

/// When an insert is flown if the current behavior is neither a trackline nor a trackcircle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum InsertPlace {
    /// Before the next trackline or trackcircle of the plan, as SPI 7.5 says; without one, after the current behavior.
    #[default]
    Leg,
    /// After the current behavior, whatever it is.
    Current,
    /// The seed draws one.
    Seed,
}

/// What happens to a modify beyond the vehicle's safe operating parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ModifyBeyond {
    /// The vehicle accepts it and flies what is safe of it.
    #[default]
    Clip,
    /// The vehicle refuses it. A modify that is in force stays.
    Refuse,
    /// The seed draws one.
    Seed,
}

/// What a value of BPRMB is if the field for its mode is empty.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ModifyEmptyMode {
    /// What it is in the current behavior: a depth or an altitude, a speed in metres a second or in rpm. SPI 7.12: "any
    /// empty fields do not modify that aspect of the current behavior".
    #[default]
    Behavior,
    /// As with the mode 0: a depth, a speed in rpm.
    Zero,
    /// The vehicle refuses it.
    Refuse,
    /// The seed draws one.
    Seed,
}

/// What the rudder and elevator of BPRMB are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ModifyFins {
    /// The angles that the vehicle holds.
    #[default]
    Absolute,
    /// Angles that are added to the behavior's own steering.
    Change,
    /// The seed draws one.
    Seed,
}

/// What happens to inserts when the payload loses control (BFCTL 0).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum InsertsAfterControl {
    /// They are flown.
    #[default]
    Fly,
    /// Those that wait are deleted, and the one that is being flown ends.
    Drop,
    /// The seed draws one.
    Seed,
}

/// What the vehicle flies after an insert that interrupted a behavior.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AfterInterrupt {
    /// The behavior after the interrupted one.
    #[default]
    Next,
    /// The interrupted one, from where it was left.
    Resume,
    /// The seed draws one.
    Seed,
}

/// Whose inserts BPRCA or BPRCN cancels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CancelAllScope {
    /// Those of every client.
    #[default]
    All,
    /// Those of the client that asks.
    Own,
    /// The seed draws one.
    Seed,
}

/// Which north the heading of BPRMB counts from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum HeadingFrame {
    /// True north.
    #[default]
    True,
    /// The north of the UTM grid, as in BFNVG.
    Grid,
    /// The seed draws one.
    Seed,
}

/// From where the mission goes on after a suspension.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AfterSuspension {
    /// A trackline or trackcircle from where it was suspended, a waypoint or setpoint from where the vehicle is.
    #[default]
    Behavior,
    /// From where it was suspended: the vehicle goes back there first.
    Return,
    /// From where the vehicle is.
    Here,
    /// The seed draws one.
    Seed,
}

/// What a request for silent mode does to an adjustment that a payload asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AdjustmentWhenSilenced {
    /// It cancels the adjustment.
    #[default]
    Cancel,
    /// It fails, and the adjustment goes on.
    Refuse,
    /// The seed draws one.
    Seed,
}

/// Which way vertical positions on a hull count from the waterline.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum HullVertical {
    /// Downwards, as depth does.
    #[default]
    Down,
    /// Upwards: positions on the hull are negative.
    Up,
    /// The seed draws one.
    Seed,
}

/// What BFCPS says of frames whose acknowledgement did not come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum UnackedFrames {
    /// Unacknowledged (1): they were sent.
    #[default]
    Unacknowledged,
    /// Failed to send (3).
    Failed,
    /// The seed draws one.
    Seed,
}

/// A value, or `"seed"`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice<T> {
    /// This value, whatever the seed.
    Fixed(T),
    /// The seed draws one.
    Seed,
}

impl<T: Default> Default for Choice<T> {
    fn default() -> Self {
        Self::Fixed(T::default())
    }
}

impl Default for InterpretationConfig {
    fn default() -> Self {
        Self {
            inserts_after_control: InsertsAfterControl::default(),
            after_interrupt: AfterInterrupt::default(),
            lead_in_m: Choice::default(),
            control_replay: Choice::default(),
            cancel_all_scope: CancelAllScope::default(),
            modify_heading: HeadingFrame::default(),
            insert_place: InsertPlace::default(),
            insert_logging: Choice::default(),
            cancel_scope: CancelAllScope::default(),
            cancel_all_gps: Choice::default(),
            modify_survives: Choice::Fixed(true),
            modify_beyond: ModifyBeyond::default(),
            modify_fins: ModifyFins::default(),
            modify_empty_mode: ModifyEmptyMode::default(),
            adjustment_when_silenced: AdjustmentWhenSilenced::default(),
            adjustment_needs_status: Choice::default(),
            dvl_timeout_announced: Choice::default(),
            unacked_frames: UnackedFrames::default(),
            suspend_needs_control: Choice::default(),
            after_suspension: AfterSuspension::default(),
            hull_vertical: HullVertical::default(),
            interruption: Interruption::default(),
            acknowledged: Acknowledged::default(),
            echo_decimals: Choice::Fixed(3.0),
            trackcircle_layout: TrackcircleLayout::default(),
            unknown_command: UnknownCommand::default(),
            broken_line: BrokenLine::default(),
            ctd_pressure: CtdPressure::default(),
            all_topics: AllTopics::default(),
        }
    }
}

impl InterpretationConfig {
    pub(crate) fn validate(&self) -> Result<(), MvcError> {
        if let Choice::Fixed(metres) = self.lead_in_m {
            check(
                (0.0..=500.0).contains(&metres),
                "interpretation.lead_in_m",
                metres,
                "0 to 500 m",
            )?;
        }
        match self.echo_decimals {
            Choice::Fixed(decimals) => check(
                (0.0..=9.0).contains(&decimals) && decimals.fract() == 0.0,
                "interpretation.echo_decimals",
                decimals,
                "a whole number, 0 to 9",
            ),
            Choice::Seed => Ok(()),
        }
    }
}

impl<'de> Deserialize<'de> for Choice<f64> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let visitor = ChoiceVisitor {
            expected: "a number or \"seed\"",
            of: PhantomData::<f64>,
        };
        deserializer.deserialize_any(visitor)
    }
}

impl<'de> Deserialize<'de> for Choice<bool> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let visitor = ChoiceVisitor {
            expected: "true, false or \"seed\"",
            of: PhantomData::<bool>,
        };
        deserializer.deserialize_any(visitor)
    }
}

struct ChoiceVisitor<T> {
    expected: &'static str,
    of: PhantomData<T>,
}

macro_rules! choice_visitor {
    ($kind:ty, $($visit:ident($value:ident: $from:ty) => $into:expr),+) => {
        impl Visitor<'_> for ChoiceVisitor<$kind> {
            type Value = Choice<$kind>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(self.expected)
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Self::Value, E> {
                if text == "seed" {
                    Ok(Choice::Seed)
                } else {
                    Err(E::invalid_value(serde::de::Unexpected::Str(text), &self))
                }
            }

            $(fn $visit<E: Error>(self, $value: $from) -> Result<Self::Value, E> {
                Ok(Choice::Fixed($into))
            })+
        }
    };
}

choice_visitor!(f64, visit_f64(value: f64) => value, visit_i64(value: i64) => value as f64);
choice_visitor!(bool, visit_bool(value: bool) => value);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_choice_is_a_value_or_the_word_seed() {
        let parse = |text: &str| toml::from_str::<InterpretationConfig>(text);
        let config = parse("lead_in_m = 30\ncontrol_replay = true\nafter_interrupt = \"seed\"").unwrap();
        assert_eq!(config.lead_in_m, Choice::Fixed(30.0));
        assert_eq!(config.control_replay, Choice::Fixed(true));
        assert_eq!(config.after_interrupt, AfterInterrupt::Seed);
        assert_eq!(parse("lead_in_m = \"seed\"").unwrap().lead_in_m, Choice::Seed);
        for bad in [
            "lead_in_m = \"sometimes\"",
            "control_replay = 1",
            "modify_heading = \"magnetic\"",
        ] {
            assert!(parse(bad).is_err(), "{bad}");
        }
    }
}
