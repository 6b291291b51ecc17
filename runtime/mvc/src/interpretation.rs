mod drawn;

use backseat_world::Stream;

use crate::file::{
    Acknowledged, AdjustmentWhenSilenced, AfterInterrupt, AfterSuspension, AllTopics, BrokenLine, CancelAllScope,
    Choice, CtdPressure, HeadingFrame, HullVertical, InsertPlace, InsertsAfterControl, InterpretationConfig,
    Interruption, ModifyBeyond, ModifyEmptyMode, ModifyFins, TrackcircleLayout, UnackedFrames, UnknownCommand,
};

/// How this run reads what the specification leaves open: the `[interpretation]` section after the seed's draws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interpretation {
    /// Whether inserts are flown after the payload has lost control (BFCTL 0); otherwise they are dropped.
    pub inserts_fly_on: bool,
    /// Whether an interrupted behavior is resumed; otherwise the next one follows.
    pub resume: bool,
    /// Length of the lead-in before an inserted trackline, and of the lead-out after it, metres.
    pub lead_in_m: f64,
    /// Whether BFCTL and BFMIS are sent at once to a client that switches them on late.
    pub control_replay: bool,
    /// Whether BPRCA cancels the inserts of every client; otherwise only those of the client that asks.
    pub cancel_all: bool,
    /// Whether the heading of BPRMB counts from the north of the UTM grid; otherwise from true north.
    pub heading_is_grid: bool,
    /// Whether inserts wait for the next trackline or trackcircle of the plan; otherwise they follow the current
    /// behavior, whatever it is.
    pub inserts_at_legs: bool,
    /// Whether the vehicle sends BFBDL and BFSDL for inserted tracklines and trackcircles too.
    pub insert_logging: bool,
    /// Whether BPRCN cancels the insert of any client; otherwise only one of the client that asks.
    pub cancel_any: bool,
    /// Whether BPRCA cancels GPS hits too.
    pub cancel_all_gps: bool,
    /// Whether a modify goes on under the next behavior; otherwise it ends with the one that it modifies.
    pub modify_survives: bool,
    /// Whether a modify beyond the safe operating parameters is refused; otherwise the vehicle flies what is safe of
    /// it.
    pub modify_beyond_refused: bool,
    /// Whether the rudder and elevator of BPRMB are added to the behavior's own steering; otherwise the vehicle holds
    /// these angles.
    pub fins_change: bool,
    /// What a value of BPRMB is if the field for its mode is empty.
    pub empty_mode: EmptyMode,
    /// Whether BPSUS needs dynamic requests to be allowed; a suspension then ends with them.
    pub suspend_needs_control: bool,
    /// From where the mission goes on after a suspension.
    pub resume_from: ResumeFrom,
    /// Whether vertical positions on a hull count upwards; otherwise downwards.
    pub hull_vertical_up: bool,
    /// Whether a request for silent mode cancels an adjustment that a payload asked for; otherwise the request fails.
    pub silence_cancels_adjustment: bool,
    /// Whether BPTRM and BPBOY fail for a client that has not switched on BFTRM or BFBOY.
    pub adjustment_needs_status: bool,
    /// Whether the vehicle sends BFDVT when the DVL goes back to internal triggering because the payload did not
    /// trigger it.
    pub dvl_timeout_announced: bool,
    /// Whether BFCPS reports frames without an acknowledgement as failed; otherwise as unacknowledged.
    pub unacked_is_failed: bool,
    /// Whether no insert of a set may be interrupted if its first one interrupted the plan; otherwise only that first
    /// one may not.
    pub set_interrupts: bool,
    /// Whether only those commands are acknowledged whose own section mentions it; otherwise all.
    pub acknowledges_sections: bool,
    /// How many decimals of a command's time BFACK repeats.
    pub echo_decimals: u8,
    /// The layout of BPRTC that the vehicle reads.
    pub trackcircle_layout: CircleLayout,
    /// Whether BFACK names an unknown command as it was sent; otherwise `NAK`.
    pub unknown_is_named: bool,
    /// Whether a line that is no sentence is answered with `NAK`; otherwise the vehicle ignores it.
    pub broken_lines_answered: bool,
    /// Whether the pressure of BFCTD and BPCTD counts from the atmosphere's; otherwise from a vacuum.
    pub ctd_pressure_is_gauge: bool,
    /// Whether `BPLOG,ALL` switches BFNVG, BFNVR and BFACK; otherwise everything but BFACK.
    pub all_is_navigation: bool,
}

/// The layout of BPRTC that the vehicle reads (SPI 7.6).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CircleLayout {
    /// With an entry angle, or without one if that field is missing.
    Either,
    /// With an entry angle.
    Table,
    /// Without an entry angle.
    Header,
}

/// What a value of BPRMB is if the field for its mode is empty (SPI 7.12).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EmptyMode {
    /// What it is in the current behavior.
    Behavior,
    /// As with the mode 0.
    Zero,
    /// Refused.
    Refused,
}

fn chosen(choice: Choice<bool>, drawn: bool) -> bool {
    match choice {
        Choice::Fixed(fixed) => fixed,
        Choice::Seed => drawn,
    }
}

/// From where the mission goes on after a suspension (SPI 8.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResumeFrom {
    /// It depends on the behavior: tracklines and trackcircles from where they were suspended, others from where the
    /// vehicle is.
    Behavior,
    /// From where it was suspended: the vehicle returns there first.
    SuspensionPoint,
    /// From where the vehicle is.
    Here,
}

impl Interpretation {
    /// Makes every draw, whatever the file fixes, so that fixing one reading does not change the others.
    pub(crate) fn new(config: &InterpretationConfig, seed: u64) -> Self {
        let mut stream = Stream::new(seed, "interpretation");
        let mut coin = || stream.uniform() < 0.5;
        let drawn = [coin(), coin(), coin(), coin(), coin()];
        let lead_in_m = stream.uniform_in(0.0, 50.0);
        // New draws come last, so that the earlier ones stay the same.
        let mut coin = || stream.uniform() < 0.5;
        let later = [coin(), coin(), coin(), coin(), coin(), coin(), coin(), coin()];
        let mut hovering = Stream::new(seed, "interpretation of hovering");
        let needs_control = hovering.uniform() < 0.5;
        let resume_from = match hovering.uniform() {
            share if share < 1.0 / 3.0 => ResumeFrom::Behavior,
            share if share < 2.0 / 3.0 => ResumeFrom::SuspensionPoint,
            _ => ResumeFrom::Here,
        };
        let upwards = hovering.uniform() < 0.5;
        // A separate stream, so that more draws in one family do not change those of the others.
        let mut services = Stream::new(seed, "interpretation of services");
        let mut coin = || services.uniform() < 0.5;
        let of_services = [coin(), coin(), coin(), coin()];
        let mut link = Stream::new(seed, "interpretation of the link");
        let acknowledges_sections = link.uniform() < 0.125;
        let echo_decimals = if link.uniform() < 0.5 { 2 } else { 3 };
        let layout = match link.uniform() {
            share if share < 1.0 / 3.0 => CircleLayout::Either,
            share if share < 2.0 / 3.0 => CircleLayout::Table,
            _ => CircleLayout::Header,
        };
        let mut modify = Stream::new(seed, "interpretation of modifies");
        let empty_mode = match modify.uniform() {
            share if share < 1.0 / 3.0 => EmptyMode::Behavior,
            share if share < 2.0 / 3.0 => EmptyMode::Zero,
            _ => EmptyMode::Refused,
        };
        let mut answers = Stream::new(seed, "interpretation of answers");
        let mut coin = || answers.uniform() < 0.5;
        let of_answers = [coin(), coin(), coin(), coin()];
        Self {
            inserts_fly_on: match config.inserts_after_control {
                InsertsAfterControl::Fly => true,
                InsertsAfterControl::Drop => false,
                InsertsAfterControl::Seed => drawn[0],
            },
            resume: match config.after_interrupt {
                AfterInterrupt::Next => false,
                AfterInterrupt::Resume => true,
                AfterInterrupt::Seed => drawn[1],
            },
            lead_in_m: match config.lead_in_m {
                Choice::Fixed(metres) => metres,
                Choice::Seed => lead_in_m,
            },
            control_replay: chosen(config.control_replay, drawn[2]),
            cancel_all: match config.cancel_all_scope {
                CancelAllScope::All => true,
                CancelAllScope::Own => false,
                CancelAllScope::Seed => drawn[3],
            },
            heading_is_grid: match config.modify_heading {
                HeadingFrame::True => false,
                HeadingFrame::Grid => true,
                HeadingFrame::Seed => drawn[4],
            },
            inserts_at_legs: match config.insert_place {
                InsertPlace::Leg => true,
                InsertPlace::Current => false,
                InsertPlace::Seed => later[0],
            },
            insert_logging: chosen(config.insert_logging, later[1]),
            cancel_any: match config.cancel_scope {
                CancelAllScope::All => true,
                CancelAllScope::Own => false,
                CancelAllScope::Seed => later[2],
            },
            cancel_all_gps: chosen(config.cancel_all_gps, later[3]),
            modify_survives: chosen(config.modify_survives, later[4]),
            modify_beyond_refused: match config.modify_beyond {
                ModifyBeyond::Clip => false,
                ModifyBeyond::Refuse => true,
                ModifyBeyond::Seed => later[5],
            },
            fins_change: match config.modify_fins {
                ModifyFins::Absolute => false,
                ModifyFins::Change => true,
                ModifyFins::Seed => later[6],
            },
            empty_mode: match config.modify_empty_mode {
                ModifyEmptyMode::Behavior => EmptyMode::Behavior,
                ModifyEmptyMode::Zero => EmptyMode::Zero,
                ModifyEmptyMode::Refuse => EmptyMode::Refused,
                ModifyEmptyMode::Seed => empty_mode,
            },
            suspend_needs_control: match config.suspend_needs_control {
                Choice::Fixed(needs) => needs,
                Choice::Seed => needs_control,
            },
            resume_from: match config.after_suspension {
                AfterSuspension::Behavior => ResumeFrom::Behavior,
                AfterSuspension::Return => ResumeFrom::SuspensionPoint,
                AfterSuspension::Here => ResumeFrom::Here,
                AfterSuspension::Seed => resume_from,
            },
            hull_vertical_up: match config.hull_vertical {
                HullVertical::Down => false,
                HullVertical::Up => true,
                HullVertical::Seed => upwards,
            },
            silence_cancels_adjustment: match config.adjustment_when_silenced {
                AdjustmentWhenSilenced::Cancel => true,
                AdjustmentWhenSilenced::Refuse => false,
                AdjustmentWhenSilenced::Seed => of_services[0],
            },
            adjustment_needs_status: match config.adjustment_needs_status {
                Choice::Fixed(needs) => needs,
                Choice::Seed => of_services[1],
            },
            dvl_timeout_announced: match config.dvl_timeout_announced {
                Choice::Fixed(announced) => announced,
                Choice::Seed => of_services[2],
            },
            unacked_is_failed: match config.unacked_frames {
                UnackedFrames::Unacknowledged => false,
                UnackedFrames::Failed => true,
                UnackedFrames::Seed => of_services[3],
            },
            set_interrupts: match config.interruption {
                Interruption::Set => true,
                Interruption::Behavior => false,
                Interruption::Seed => later[7],
            },
            acknowledges_sections: match config.acknowledged {
                Acknowledged::All => false,
                Acknowledged::Sections => true,
                Acknowledged::Seed => acknowledges_sections,
            },
            echo_decimals: match config.echo_decimals {
                Choice::Fixed(decimals) => decimals as u8,
                Choice::Seed => echo_decimals,
            },
            trackcircle_layout: match config.trackcircle_layout {
                TrackcircleLayout::Either => CircleLayout::Either,
                TrackcircleLayout::Table => CircleLayout::Table,
                TrackcircleLayout::Header => CircleLayout::Header,
                TrackcircleLayout::Seed => layout,
            },
            unknown_is_named: match config.unknown_command {
                UnknownCommand::Nak => false,
                UnknownCommand::Name => true,
                UnknownCommand::Seed => of_answers[0],
            },
            broken_lines_answered: match config.broken_line {
                BrokenLine::Ignore => false,
                BrokenLine::Nak => true,
                BrokenLine::Seed => of_answers[1],
            },
            ctd_pressure_is_gauge: match config.ctd_pressure {
                CtdPressure::Absolute => false,
                CtdPressure::Gauge => true,
                CtdPressure::Seed => of_answers[2],
            },
            all_is_navigation: match config.all_topics {
                AllTopics::All => false,
                AllTopics::Navigation => true,
                AllTopics::Seed => of_answers[3],
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_seed_draws_every_reading_both_ways() {
        let config = InterpretationConfig {
            inserts_after_control: InsertsAfterControl::Seed,
            after_interrupt: AfterInterrupt::Seed,
            lead_in_m: Choice::Seed,
            control_replay: Choice::Seed,
            cancel_all_scope: CancelAllScope::Seed,
            modify_heading: HeadingFrame::Seed,
            insert_place: InsertPlace::Seed,
            insert_logging: Choice::Seed,
            cancel_scope: CancelAllScope::Seed,
            cancel_all_gps: Choice::Seed,
            modify_survives: Choice::Seed,
            modify_beyond: ModifyBeyond::Seed,
            modify_fins: ModifyFins::Seed,
            modify_empty_mode: ModifyEmptyMode::Seed,
            suspend_needs_control: Choice::Seed,
            after_suspension: AfterSuspension::Seed,
            hull_vertical: HullVertical::Seed,
            adjustment_when_silenced: AdjustmentWhenSilenced::Seed,
            adjustment_needs_status: Choice::Seed,
            dvl_timeout_announced: Choice::Seed,
            unacked_frames: UnackedFrames::Seed,
            interruption: Interruption::Seed,
            acknowledged: Acknowledged::Seed,
            echo_decimals: Choice::Seed,
            trackcircle_layout: TrackcircleLayout::Seed,
            unknown_command: UnknownCommand::Seed,
            broken_line: BrokenLine::Seed,
            ctd_pressure: CtdPressure::Seed,
            all_topics: AllTopics::Seed,
        };
        let drawn: Vec<Interpretation> = (0..64).map(|seed| Interpretation::new(&config, seed)).collect();
        let both = |of: fn(&Interpretation) -> bool| drawn.iter().any(of) && !drawn.iter().all(of);
        assert!(both(|i| i.inserts_fly_on) && both(|i| i.resume) && both(|i| i.control_replay));
        assert!(both(|i| i.suspend_needs_control) && both(|i| i.hull_vertical_up));
        for mode in [EmptyMode::Behavior, EmptyMode::Zero, EmptyMode::Refused] {
            assert!(drawn.iter().any(|i| i.empty_mode == mode), "{mode:?}");
        }
        for from in [ResumeFrom::Behavior, ResumeFrom::SuspensionPoint, ResumeFrom::Here] {
            assert!(drawn.iter().any(|i| i.resume_from == from), "{from:?}");
        }
        assert!(both(|i| i.cancel_all) && both(|i| i.heading_is_grid) && both(|i| i.lead_in_m > 25.0));
        assert!(both(|i| i.inserts_at_legs) && both(|i| i.insert_logging) && both(|i| i.cancel_any));
        assert!(both(|i| i.cancel_all_gps) && both(|i| i.modify_survives) && both(|i| i.fins_change));
        assert!(both(|i| i.modify_beyond_refused) && both(|i| i.set_interrupts));
        assert!(both(|i| i.acknowledges_sections) && both(|i| i.echo_decimals == 2));
        for layout in [CircleLayout::Either, CircleLayout::Table, CircleLayout::Header] {
            assert!(drawn.iter().any(|i| i.trackcircle_layout == layout), "{layout:?}");
        }
        assert!(both(|i| i.silence_cancels_adjustment) && both(|i| i.adjustment_needs_status));
        assert!(both(|i| i.dvl_timeout_announced) && both(|i| i.unacked_is_failed));
        assert!(both(|i| i.unknown_is_named) && both(|i| i.broken_lines_answered));
        assert!(both(|i| i.ctd_pressure_is_gauge) && both(|i| i.all_is_navigation));
        // A file with the values that the seed drew has the same readings, whatever its seed.
        for (seed, interpretation) in drawn.iter().enumerate() {
            let said = interpretation.drawn(&config);
            let text: String = said.iter().map(|(key, value)| format!("{key} = {value}\n")).collect();
            let fixed: InterpretationConfig = toml::from_str(&text).unwrap_or_else(|error| panic!("{error}\n{text}"));
            let again = Interpretation::new(&fixed, seed as u64 + 1);
            let lead_in_m = interpretation.lead_in_m;
            assert!((again.lead_in_m - lead_in_m).abs() < 1e-3, "{text}");
            assert_eq!(Interpretation { lead_in_m, ..again }, *interpretation, "{text}");
            assert_eq!(again.drawn(&fixed), []);
        }
    }
}
