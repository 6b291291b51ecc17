//! What the vehicle flies before an insert that waits its turn, and whether the way from there still holds (safety
//! requirement 002).
//!
//! An insert that interrupts nothing is flown after the current behaviour. That may be over sooner than its path is: a
//! behaviour of the plan has a time limit that no sentence tells, and a lease delays it. And it may be another one by
//! the time that the insert arrives, or than the insert was judged for, where vehicles differ in the place that they give
//! it (SPI 7.5).

use backseat_units::Depth;

use crate::commands::Purpose;
use crate::context::Context;
use crate::envelope::{End, Insert, Passage};
use crate::inserts::Inserts;
use crate::plan::Element;
use crate::plugin::{Refusal, RequestState};
use crate::switches::{Check, is_on};

impl Inserts {
    /// The plan is flown on, or is known anew: an insert that waits and whose way does not hold from there is called
    /// back. What comes after it has then another way.
    pub(crate) fn judge_waiting(&mut self, cx: &mut Context) {
        if !cx.vehicle.plan.is_complete() || !is_on(Check::InsertWayTo) {
            return;
        }
        let mut before = Vec::new();
        let chain = cx.chain();
        let waits = |cx: &Context, (request, insert, begun): &(u64, Insert, bool)| {
            !begun && !insert.interrupt && !cx.ledger.is_recalled(*request)
        };
        for open in &chain {
            let (request, insert, _) = open;
            if !waits(cx, open) {
                before.push(*open);
                continue;
            }
            let Err(refusal) = cx.judge_way_to(&before, insert) else {
                // The rest comes after it.
                break;
            };
            self.call_back(cx, *request, &format!("its way no longer holds: {}", refusal.text));
            if insert.surfaces() {
                return;
            }
        }
        for open in chain.iter().rev() {
            if cx.ledger.is_recalled(open.0) {
                continue;
            }
            if !waits(cx, open) {
                return;
            }
            let Err(refusal) = cx.judge_way_on(&open.1) else {
                return;
            };
            let text = format!("its way on no longer holds: {}", refusal.text);
            self.call_back(cx, open.0, &text);
        }
    }
}

impl Context {
    /// Where the vehicle may be when it goes on to what comes after these inserts, which are in the order that they are
    /// flown: at the end of the last that it surely flies, or of one after that. Where none is sure, anywhere on what it
    /// flies of its plan, or between that and where it comes back from: where it is now, or the end of what interrupts it.
    pub(crate) fn comes_from(&self, before: &[(u64, Insert, bool)]) -> Vec<End> {
        let mut from = Vec::new();
        for (request, insert, begun) in before.iter().rev() {
            from.push(self.monitor.envelope.ends(insert).1);
            // After one that interrupts it may take up again what it left.
            if !insert.interrupt
                && self.vehicle.courses.current().is_some()
                && (*begun || self.is_surely_flown(*request))
            {
                return from;
            }
        }
        let here = self
            .vehicle
            .navigation
            .newest()
            .map(|navigation| End::At(navigation.local));
        let flown = before.iter().find(|(_, _, begun)| *begun);
        let aside = flown
            .map(|(_, insert, _)| self.monitor.envelope.ends(insert).1)
            .or(here);
        let lines: Vec<_> = self.vehicle.plan.current().flat_map(Element::legs).collect();
        let begun = self.vehicle.courses.of_current();
        let tracks = self.tracks_of_lines(&begun, &lines);
        from.extend(tracks.iter().map(|track| End::on_or_beside(track, aside)));
        // Inserts that are not ours come before it too (SPI 7.5: appended at the end of the set).
        let others = self
            .vehicle
            .plan
            .others(|identifier| self.identifiers.is_ours(identifier));
        from.extend(others.map(|(_, element)| End::At(element.last())));
        if from.is_empty() {
            from.extend(here);
        }
        from
    }

    /// The vehicle has taken it, and it is not being taken back.
    pub(crate) fn is_surely_flown(&self, request: u64) -> bool {
        let accepted = |state: &RequestState| *state == RequestState::Accepted;
        self.ledger.get(request).is_some_and(|entry| accepted(&entry.state))
            && !self.ledger.is_recalled(request)
            && !self
                .link
                .commands
                .purposes()
                .any(|purpose| matches!(purpose, Purpose::Cancel { insert, .. } if insert == request))
    }

    pub(crate) fn judge_way_to(&self, before: &[(u64, Insert, bool)], insert: &Insert) -> Result<(), Refusal> {
        // Where nothing was ever heard, nothing was ever inserted.
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

    /// The way on from the last of our inserts: what it goes on to may be another element by now.
    pub(crate) fn judge_way_on(&self, insert: &Insert) -> Result<(), Refusal> {
        let Some(navigation) = self.vehicle.navigation.newest() else {
            return Ok(());
        };
        let from = self.monitor.envelope.ends(insert).1;
        let passage = self.passage(navigation.depth, insert.surfaces(), self.before_insert_s(false));
        for to in self.vehicle.plan.next_points() {
            self.monitor.envelope.judge_way((from, End::At(to)), &passage)?;
        }
        Ok(())
    }

    /// How a way is flown from this depth that begins after so many seconds at the latest.
    pub(crate) fn passage(&self, depth: Depth, surfacing: bool, before_s: f64) -> Passage {
        Passage {
            depth,
            lock: self.vehicle.navigation.bottom_lock(self.now),
            surfacing,
            deepest_m: self.deepest_open_m(),
            seen_mps: self.vehicle.courses.seen_mps(),
            depths_m: self.depths_of_ways(),
            clocks: self.clocks(),
            before_s,
        }
    }
}
