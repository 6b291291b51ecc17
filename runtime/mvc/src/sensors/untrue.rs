use backseat_units::EastNorth;

use crate::faults::Untrue;

/// The faults that make BFNVG and BFNVR report wrong values.
///
/// They change only the messages, after the solution is computed. The vehicle does not steer by the messages, so its
/// truth and its own estimate remain those of a vehicle without faults.
#[derive(Clone, Debug, Default)]
pub(super) struct UntrueWords(Vec<Acting>);

#[derive(Clone, Copy, Debug)]
struct Acting {
    number: usize,
    what: Untrue,
    /// The last step before the fault.
    since: u64,
    /// Where the solution was in that step.
    from: EastNorth,
    /// The place that is reported all the time, if the position is frozen.
    held: Option<EastNorth>,
}

impl UntrueWords {
    pub(super) fn begin(&mut self, number: usize, what: Untrue, since: u64, from: EastNorth) {
        let acting = Acting {
            number,
            what,
            since,
            from,
            held: None,
        };
        self.0.push(acting);
        self.0.sort_by_key(|acting| acting.number);
    }

    pub(super) fn end(&mut self, number: usize) {
        self.0.retain(|acting| acting.number != number);
    }

    /// The place that is reported in a step. The faults act one after the other, in the order of their numbers.
    pub(super) fn place(&mut self, so: EastNorth, step: u64, dt_s: f64) -> EastNorth {
        let mut told = so;
        for acting in &mut self.0 {
            match acting.what {
                Untrue::PositionCreeps { speed_mps, towards_deg } => {
                    let for_s = step.saturating_sub(acting.since) as f64 * dt_s;
                    told = told.offset(towards_deg, speed_mps * for_s);
                }
                Untrue::PositionFrozen => told = *acting.held.get_or_insert(told),
                Untrue::PositionBackwards => told = acting.from + (acting.from - told),
                Untrue::VelocityMissing | Untrue::HeadingFlips { .. } | Untrue::DepthFlips { .. } => {}
            }
        }
        told
    }

    /// The heading and the depth that are reported in a step, degrees and metres.
    pub(super) fn attitude(&self, mut heading_deg: f64, mut depth_m: f64, step: u64) -> (f64, f64) {
        for acting in &self.0 {
            let turned = step.saturating_sub(acting.since) % 2 == 1;
            match acting.what {
                Untrue::HeadingFlips { by_deg } if turned => heading_deg += by_deg,
                Untrue::DepthFlips { by_m } if turned => depth_m += by_m,
                Untrue::PositionCreeps { .. }
                | Untrue::PositionFrozen
                | Untrue::PositionBackwards
                | Untrue::VelocityMissing
                | Untrue::HeadingFlips { .. }
                | Untrue::DepthFlips { .. } => {}
            }
        }
        (heading_deg, depth_m)
    }

    pub(super) fn has_no_velocity(&self) -> bool {
        let missing = |acting: &Acting| matches!(acting.what, Untrue::VelocityMissing);
        self.0.iter().any(missing)
    }
}
