use std::time::Duration;

use anyhow::Result;

use crate::flight::Range;
use crate::plan::Plan;

/// The most flights for shrinking one plan.
const FLIGHTS: usize = 300;

/// The smallest plan found that fails by the same rule, with fewer and shorter faults.
///
/// # Errors
///
/// If a plan cannot be flown.
pub fn shrink(range: &Range, plan: &Plan, rule: &str) -> Result<Plan> {
    smallest(plan, |plan| {
        let flight = range.fly(plan)?;
        Ok(flight.failures.iter().any(|failure| failure.rule == rule))
    })
}

fn smallest(plan: &Plan, mut fails: impl FnMut(&Plan) -> Result<bool>) -> Result<Plan> {
    let mut left = FLIGHTS;
    let mut fails = |plan: &Plan| -> Result<bool> {
        if left == 0 {
            return Ok(false);
        }
        left -= 1;
        fails(plan)
    };
    let mut best = plan.clone();
    if !fails(&best)? {
        return Ok(best);
    }
    // Removes halves, then quarters, down to single faults, until none can be removed.
    let mut size = best.faults.len().div_ceil(2);
    while size > 0 {
        let mut start = 0;
        let mut went = false;
        while start < best.faults.len() {
            let mut smaller = best.clone();
            let end = (start + size).min(smaller.faults.len());
            smaller.faults.drain(start..end);
            if fails(&smaller)? {
                best = smaller;
                went = true;
            } else {
                start = end;
            }
        }
        if size > 1 || !went {
            size /= 2;
        }
    }
    for index in 0..best.faults.len() {
        loop {
            let lasts = best.faults[index].fault.lasts();
            if lasts < Duration::from_millis(200) {
                break;
            }
            let mut shorter = best.clone();
            let fault = shorter.faults[index].fault.clone().at_most(lasts / 2);
            if fault.lasts() == lasts {
                break;
            }
            shorter.faults[index].fault = fault;
            if !fails(&shorter)? {
                break;
            }
            best = shorter;
        }
    }
    Ok(best)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fault::Fault;
    use crate::plan::{Come, Planned};

    #[test]
    fn only_what_makes_it_fail_is_left_and_that_short() {
        let needed = |plan: &Plan| {
            let stops =
                |planned: &Planned| matches!(planned.fault, Fault::Stop { lasts } if lasts > Duration::from_secs(3));
            let kills = |planned: &Planned| matches!(planned.fault, Fault::Kill { .. });
            plan.faults.iter().any(stops) && plan.faults.iter().any(kills)
        };
        let mut shrunk = 0;
        for seed in 0..200 {
            let mut plan = Plan::draw(seed);
            let lasts = Duration::from_secs(20);
            let come = Come::At(backseat_units::Timestamp::from_secs(100));
            let fault = Fault::Stop { lasts };
            plan.faults.insert(0, Planned { come, fault });
            let whole = plan.faults.len();
            let small = smallest(&plan, |plan| Ok(needed(plan))).unwrap();
            if !needed(&plan) {
                assert_eq!(small, plan);
                continue;
            }
            shrunk += 1;
            assert!(needed(&small) && whole > 2);
            assert_eq!(small.faults.len(), 2, "seed {seed}");
            let stop = small
                .faults
                .iter()
                .find(|planned| matches!(planned.fault, Fault::Stop { .. }));
            assert!(stop.unwrap().fault.lasts() < Duration::from_secs(6));
        }
        assert!(shrunk > 20, "{shrunk}");
    }
}
