//! Ways that nobody requests but that follow from a request: to and from a waiting insert, and past a cancelled one.

use super::Outlook;
use crate::monitor::envelope::{End, Insert};
use crate::mutations::{Check, is_on};
use crate::plugin::Refusal;
use crate::refusal::Reason;

impl Outlook<'_> {
    pub(crate) fn judge_way_to(&self, before: &[(u64, Insert, bool)], insert: &Insert) -> Result<(), Refusal> {
        // If no navigation has ever come, no insert was ever sent.
        let Some(navigation) = self.vehicle.navigation.newest() else {
            return Ok(());
        };
        let surfacing = insert.surfaces() || before.iter().any(|(_, before, _)| before.surfaces());
        let passage = self.passage(navigation.depth, surfacing, self.before_insert_s(false));
        for from in self.comes_from(before) {
            self.monitor
                .envelope
                .judge_way((from, self.monitor.envelope.ends(insert).0), &passage)?;
        }
        Ok(())
    }

    /// Judges the way on from the last of our inserts: the element that comes next may be another one by now.
    pub(crate) fn judge_way_on(&self, insert: &Insert) -> Result<(), Refusal> {
        if self.vehicle.courses.has_left_foreign() {
            return Err(Refusal::from(Reason::TakenUpForeign).on_the_way_on());
        }
        let Some(navigation) = self.vehicle.navigation.newest() else {
            return Ok(());
        };
        let from = self.monitor.envelope.ends(insert).1;
        let passage = self.passage(navigation.depth, insert.surfaces(), self.before_insert_s(false));
        for to in self.vehicle.plan.goes_on_to() {
            let judged = self.monitor.envelope.judge_way((from, End::At(to)), &passage);
            judged.map_err(Refusal::on_the_way_on)?;
        }
        for track in self.taken_up_after(false) {
            let judged = self.monitor.envelope.judge_way_onto((from, &track), &passage);
            judged.map_err(Refusal::on_the_way_on)?;
        }
        Ok(())
    }

    /// Judges the ways on from waiting inserts back onto what a new insert would interrupt. The vehicle may fly the
    /// waiting inserts before it takes that up again (SPI 7.5), and when they were requested there was nothing to take
    /// up.
    pub(crate) fn judge_ways_back(&self, interrupts_for_s: f64) -> Result<(), Refusal> {
        let Some(navigation) = self.vehicle.navigation.newest() else {
            return Ok(());
        };
        let mut waiting: Vec<Insert> = self.ledger.doubtful().filter_map(|entry| entry.insert).collect();
        for (request, insert, begun) in self.chain().into_iter().rev() {
            if begun {
                continue;
            }
            waiting.push(insert);
            if self.is_surely_flown(request) {
                break;
            }
        }
        let ends = self.others().map(|(_, element)| End::At(element.last()));
        let mut from: Vec<(End, bool)> = ends.map(|end| (end, false)).collect();
        from.extend(
            waiting
                .iter()
                .map(|insert| (self.monitor.envelope.ends(insert).1, insert.surfaces())),
        );
        let tracks = self.taken_up_after(true);
        let before_s = self.before_insert_s(false) + interrupts_for_s;
        for (from, surfaces) in from {
            let passage = self.passage(navigation.depth, surfaces, before_s);
            for track in &tracks {
                let judged = self.monitor.envelope.judge_way_onto((from, track), &passage);
                judged.map_err(|refusal| Refusal::WayBack(Box::new(refusal)))?;
            }
        }
        Ok(())
    }

    /// Safety requirements 002 and 020: judges the way that the vehicle takes when one insert of a chain is cancelled,
    /// from what comes before that insert to what comes after it.
    pub(crate) fn judge_cancel(&self, chain: &[(u64, Insert, bool)], insert: u64) -> Result<(), Refusal> {
        let Some(at) = chain.iter().position(|(request, _, _)| *request == insert) else {
            return Ok(());
        };
        if chain.len() <= 1 || !is_on(Check::CancelWay) {
            // What remains is the way of the plan itself.
            return Ok(());
        }
        let Some(navigation) = self.vehicle.navigation.fresh(self.now) else {
            return Err(Reason::NavigationIsStale.into());
        };
        let before = at.checked_sub(1).and_then(|before| chain.get(before));
        // An insert that interrupts comes before all waiting ones.
        let waits = |(_, next, begun): &&(u64, Insert, bool)| !begun && !next.interrupt;
        let after = chain.iter().skip(at + 1).find(waits);
        let surfacing = [before, after]
            .into_iter()
            .flatten()
            .any(|(_, next, _)| next.surfaces());
        let from = self.comes_from(chain.get(..at).unwrap_or_default());
        let to: Vec<End> = match after {
            Some(after) => vec![self.monitor.envelope.ends(&after.1).0],
            None => self.vehicle.plan.goes_on_to().into_iter().map(End::At).collect(),
        };
        let onto = if after.is_none() {
            self.taken_up_after(false)
        } else {
            Vec::new()
        };
        let passage = self.passage(navigation.depth, surfacing, self.before_insert_s(false));
        for from in &from {
            for to in &to {
                self.monitor.envelope.judge_way((*from, *to), &passage)?;
            }
            for track in &onto {
                self.monitor.envelope.judge_way_onto((*from, track), &passage)?;
            }
        }
        Ok(())
    }
}
