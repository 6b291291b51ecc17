use backseat_world::Stream;

use crate::file::{
    Acknowledged, AdjustmentWhenSilenced, AfterInterrupt, AfterSuspension, CancelAllScope, Choice, HeadingFrame,
    HullVertical, InsertPlace, InsertsAfterControl, InterpretationConfig, Interruption, ModifyBeyond, ModifyFins,
    TrackcircleLayout, UnackedFrames,
};

/// How this run reads what the specification leaves open: the `[interpretation]` section with the seed's draws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interpretation {
    /// Inserts are flown after BFCTL has fallen to 0; else they are dropped.
    pub inserts_fly_on: bool,
    /// An interrupted behavior is resumed; else the next one follows.
    pub resume: bool,
    /// Length of the lead-in before and of the lead-out after an inserted trackline, metres.
    pub lead_in_m: f64,
    /// BFCTL and BFMIS are repeated to a client that subscribes.
    pub control_replay: bool,
    /// BPRCA cancels the inserts of every client; else only those of the one that asks.
    pub cancel_all: bool,
    /// BPRMB's heading counts from the north of the UTM grid; else from true north.
    pub heading_is_grid: bool,
    /// Inserts wait for the next leg or circle of the plan; else they follow the current behavior, whatever it is.
    pub inserts_at_legs: bool,
    /// BFBDL and BFSDL frame inserted tracklines too.
    pub insert_logging: bool,
    /// BPRCN cancels the insert of any client; else only one of the client that asks.
    pub cancel_any: bool,
    /// BPRCA takes GPS hits too.
    pub cancel_all_gps: bool,
    /// A modify goes on with the next behavior; else it ends with the one that it modifies.
    pub modify_survives: bool,
    /// A modify beyond the safe operating parameters is refused; else what is safe of it is flown.
    pub modify_beyond_refused: bool,
    /// BPRMB's rudder and elevator are added to the behavior's own; else they are held as they are.
    pub fins_change: bool,
    /// BPSUS needs dynamic requests to be allowed, and a suspension ends with them.
    pub suspend_needs_control: bool,
    /// From where the mission goes on after a suspension.
    pub resume_from: ResumeFrom,
    /// Vertical positions on a hull count upwards.
    pub hull_vertical_up: bool,
    /// An adjustment that a payload has asked for is cancelled by a request for silence; else it makes that fail.
    pub silence_cancels_adjustment: bool,
    /// BPTRM and BPBOY fail without BFTRM or BFBOY switched on.
    pub adjustment_needs_status: bool,
    /// BFDVT announces that the DVL has gone back to internal triggering by itself.
    pub dvl_timeout_announced: bool,
    /// BFCPS calls frames failed whose acknowledgement did not come; else unacknowledged.
    pub unacked_is_failed: bool,
    /// No insert of a set whose first has interrupted may be interrupted; else only that first one may not.
    pub set_interrupts: bool,
    /// Commands are acknowledged only where their own section speaks of it; else all are.
    pub acknowledges_sections: bool,
    /// Decimals of the time that a BFACK echoes.
    pub echo_decimals: u8,
    /// The layout of BPRTC that is read.
    pub trackcircle_layout: CircleLayout,
}

/// The layout of BPRTC that is read (SPI 7.6).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CircleLayout {
    /// With an entry angle, or without where the field is missing.
    Either,
    /// With an entry angle.
    Table,
    /// Without.
    Header,
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
    /// As the behavior has it: lines and circles from where they were suspended, others from where the vehicle is.
    Behavior,
    /// From where it was suspended.
    SuspensionPoint,
    /// From where the vehicle is.
    Here,
}

impl Interpretation {
    /// Every draw is made, whatever is fixed, so that fixing one does not move the others.
    pub(crate) fn new(config: &InterpretationConfig, seed: u64) -> Self {
        let mut stream = Stream::new(seed, "interpretation");
        let mut coin = || stream.uniform() < 0.5;
        let drawn = [coin(), coin(), coin(), coin(), coin()];
        let lead_in_m = stream.uniform_in(0.0, 50.0);
        // New draws come last, so that those before stay as they are.
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
        // A stream of their own, so that neither family's growth moves the other's draws.
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
        };
        let drawn: Vec<Interpretation> = (0..64).map(|seed| Interpretation::new(&config, seed)).collect();
        let both = |of: fn(&Interpretation) -> bool| drawn.iter().any(of) && !drawn.iter().all(of);
        assert!(both(|i| i.inserts_fly_on) && both(|i| i.resume) && both(|i| i.control_replay));
        assert!(both(|i| i.suspend_needs_control) && both(|i| i.hull_vertical_up));
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
    }
}
