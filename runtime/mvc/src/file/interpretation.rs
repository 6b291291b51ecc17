use core::fmt;
use core::marker::PhantomData;

use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer};

use crate::error::{MvcError, check};

/// The `[interpretation]` section: what the specification leaves open. Each is one reading, or `"seed"` for whichever
/// the seed draws, so that nothing comes to depend on one.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct InterpretationConfig {
    /// What becomes of inserts when BFCTL falls to 0 (SPI 6.24 and 7.5 do not say).
    pub inserts_after_control: InsertsAfterControl,
    /// What follows an insert that has interrupted a behavior (SPI 7.5 says both).
    pub after_interrupt: AfterInterrupt,
    /// Length of the lead-in before and of the lead-out after an inserted trackline, metres, 0 to 500 (SPI 7.5:
    /// "any default leadin/leadout behavior"). The seed draws up to 50 m.
    pub lead_in_m: Choice<f64>,
    /// Whether BFCTL and BFMIS are repeated to a client that subscribes to them late.
    pub control_replay: Choice<bool>,
    /// Whose inserts BPRCA cancels (SPI 7.9 does not say).
    pub cancel_all_scope: CancelAllScope,
    /// What BPRMB's heading counts from (SPI 7.12 does not say).
    pub modify_heading: HeadingFrame,
    /// Where an insert has its place while the current behavior is neither leg nor circle.
    pub insert_place: InsertPlace,
    /// Whether BFBDL and BFSDL frame inserted tracklines too (SPI 7.5: "with the payloads activated").
    pub insert_logging: Choice<bool>,
    /// Whose inserts BPRCN cancels (SPI 7.8 does not say).
    pub cancel_scope: CancelAllScope,
    /// Whether BPRCA takes GPS hits too (SPI 7.9: "all"; 7.8 names tracklines and trackcircles alone).
    pub cancel_all_gps: Choice<bool>,
    /// Whether a modify goes on with the next behavior where the one that it modifies ends (SPI 7.12 does not say).
    pub modify_survives: Choice<bool>,
    /// What becomes of a modify beyond the safe operating parameters (SPI 7.12: it "can not be used" for that).
    pub modify_beyond: ModifyBeyond,
    /// What the rudder and elevator of BPRMB are (SPI 7.12 calls them adjustments).
    pub modify_fins: ModifyFins,
    /// Whether BPSUS needs dynamic requests to be allowed (SPI 8.1 does not say), and ends with them.
    pub suspend_needs_control: Choice<bool>,
    /// From where the mission goes on after a suspension (SPI 8.3 says both).
    pub after_suspension: AfterSuspension,
    /// Which way the vertical position of BFRNV and BPGHP counts from the waterline (SPI 6.17 and 8.6 do not say).
    pub hull_vertical: HullVertical,
    /// What a request for silence does to a trim or buoyancy adjustment that a payload has asked for (SPI 7.22 to 7.24
    /// speak of implicit ones alone).
    pub adjustment_when_silenced: AdjustmentWhenSilenced,
    /// Whether BPTRM and BPBOY fail where their client has not switched on BFTRM or BFBOY (SPI 7.23, 7.24: "must be
    /// registered").
    pub adjustment_needs_status: Choice<bool>,
    /// Whether BFDVT says so when the DVL goes back to internal triggering because the payload has not triggered it
    /// (SPI 7.4 says so and marks it as not implemented).
    pub dvl_timeout_announced: Choice<bool>,
    /// What BFCPS says of frames whose acknowledgement did not come (SPI 9.2 does not say).
    pub unacked_frames: UnackedFrames,
    /// What may not be interrupted (SPI 7.5: "it is not possible to interrupt an interruption").
    pub interruption: Interruption,
    /// Which commands are acknowledged (SPI 6.21: "each payload command"; of many the own section says nothing).
    pub acknowledged: Acknowledged,
    /// How many decimals of a second a BFACK echoes of its command's time, 0 to 9 (SPI 6.21 prints two, recorded vehicles
    /// write three). The seed draws 2 or 3.
    pub echo_decimals: Choice<f64>,
    /// Which layout of BPRTC is read (SPI 7.6: the header has no entry angle, the table has).
    pub trackcircle_layout: TrackcircleLayout,
}

/// Which commands are acknowledged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Acknowledged {
    /// All of them.
    #[default]
    All,
    /// Those whose own section speaks of it: BPLOG, BPTOP, BPRTK, BPRTC, BPRCN, BPRMP, BPSIL, BPTRM, BPBOY; and whatever
    /// cannot be read.
    Sections,
    /// The seed draws, one vehicle in eight the second.
    Seed,
}

/// Which layout of BPRTC is read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TrackcircleLayout {
    /// The table's with an entry angle, and the header's where the field is missing.
    #[default]
    Either,
    /// The table's alone: where a field is missing it is the interrupt code.
    Table,
    /// The header's alone: what stands where the entry angle would is the interrupt code.
    Header,
    /// The seed draws.
    Seed,
}

/// What may not be interrupted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Interruption {
    /// Any insert of a set whose first has interrupted the plan.
    #[default]
    Set,
    /// The insert alone that has interrupted, while it runs.
    Behavior,
    /// The seed draws.
    Seed,
}

/// Where an insert has its place while the current behavior is neither survey leg nor trackcircle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum InsertPlace {
    /// Before the next leg or circle of the plan, by the letter of SPI 7.5; after the current behavior where none comes.
    #[default]
    Leg,
    /// After the current behavior, whatever it is.
    Current,
    /// The seed draws.
    Seed,
}

/// What becomes of a modify beyond the vehicle's safe operating parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ModifyBeyond {
    /// It is taken, and the vehicle flies what is safe of it.
    #[default]
    Clip,
    /// It fails, and a modify that is in force stays as it was.
    Refuse,
    /// The seed draws.
    Seed,
}

/// What the rudder and elevator of BPRMB are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ModifyFins {
    /// The angles that are held.
    #[default]
    Absolute,
    /// Added to what the behavior's own steering asks for.
    Change,
    /// The seed draws.
    Seed,
}

/// What becomes of inserts when BFCTL falls to 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum InsertsAfterControl {
    /// They are flown.
    #[default]
    Fly,
    /// The waiting ones are deleted and a running one ends.
    Drop,
    /// The seed draws.
    Seed,
}

/// What follows an insert that has interrupted a behavior.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AfterInterrupt {
    /// The behavior after the interrupted one.
    #[default]
    Next,
    /// The interrupted one, where it was left.
    Resume,
    /// The seed draws.
    Seed,
}

/// Whose inserts BPRCA cancels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CancelAllScope {
    /// Those of every client.
    #[default]
    All,
    /// Those of the client that asks.
    Own,
    /// The seed draws.
    Seed,
}

/// What BPRMB's heading counts from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum HeadingFrame {
    /// True north.
    #[default]
    True,
    /// North of the UTM grid, as BFNVG's.
    Grid,
    /// The seed draws.
    Seed,
}

/// From where the mission goes on after a suspension.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AfterSuspension {
    /// A trackline and a trackcircle from where they were suspended, a waypoint and a setpoint from where it is.
    #[default]
    Behavior,
    /// From where it was suspended: the vehicle returns there first.
    Return,
    /// From where the vehicle is.
    Here,
    /// The seed draws.
    Seed,
}

/// What a request for silence does to an adjustment that a payload has asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AdjustmentWhenSilenced {
    /// It is cancelled.
    #[default]
    Cancel,
    /// It goes on, and the request for silence fails.
    Refuse,
    /// The seed draws.
    Seed,
}

/// Which way the vertical position on a hull counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum HullVertical {
    /// Down, as depth does.
    #[default]
    Down,
    /// Up: places on the hull are negative.
    Up,
    /// The seed draws.
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
    /// The seed draws.
    Seed,
}

/// A value, or `"seed"`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice<T> {
    /// This, whatever the seed.
    Fixed(T),
    /// The seed draws.
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
    fn values_and_the_word_seed() {
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
