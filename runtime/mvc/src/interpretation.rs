use backseat_world::Stream;

use crate::file::{
    AdjustmentWhenSilenced, AfterInterrupt, CancelAllScope, Choice, HeadingFrame, InsertsAfterControl,
    InterpretationConfig, UnackedFrames,
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
    /// An adjustment that a payload has asked for is cancelled by a request for silence; else it makes that fail.
    pub silence_cancels_adjustment: bool,
    /// BPTRM and BPBOY fail without BFTRM or BFBOY switched on.
    pub adjustment_needs_status: bool,
    /// BFDVT announces that the DVL has gone back to internal triggering by itself.
    pub dvl_timeout_announced: bool,
    /// BFCPS calls frames failed whose acknowledgement did not come; else unacknowledged.
    pub unacked_is_failed: bool,
}

impl Interpretation {
    /// Every draw is made, whatever is fixed, so that fixing one does not move the others.
    pub(crate) fn new(config: &InterpretationConfig, seed: u64) -> Self {
        let mut stream = Stream::new(seed, "interpretation");
        let mut coin = || stream.uniform() < 0.5;
        let drawn = [coin(), coin(), coin(), coin(), coin()];
        let lead_in_m = stream.uniform_in(0.0, 50.0);
        // A stream of their own, so that neither family's growth moves the other's draws.
        let mut services = Stream::new(seed, "interpretation of services");
        let mut coin = || services.uniform() < 0.5;
        let of_services = [coin(), coin(), coin(), coin()];
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
            control_replay: match config.control_replay {
                Choice::Fixed(replay) => replay,
                Choice::Seed => drawn[2],
            },
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
            adjustment_when_silenced: AdjustmentWhenSilenced::Seed,
            adjustment_needs_status: Choice::Seed,
            dvl_timeout_announced: Choice::Seed,
            unacked_frames: UnackedFrames::Seed,
        };
        let drawn: Vec<Interpretation> = (0..64).map(|seed| Interpretation::new(&config, seed)).collect();
        let both = |of: fn(&Interpretation) -> bool| drawn.iter().any(of) && !drawn.iter().all(of);
        assert!(both(|i| i.inserts_fly_on) && both(|i| i.resume) && both(|i| i.control_replay));
        assert!(both(|i| i.cancel_all) && both(|i| i.heading_is_grid) && both(|i| i.lead_in_m > 25.0));
        assert!(both(|i| i.silence_cancels_adjustment) && both(|i| i.adjustment_needs_status));
        assert!(both(|i| i.dvl_timeout_announced) && both(|i| i.unacked_is_failed));
    }
}
