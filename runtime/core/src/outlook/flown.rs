//! What the vehicle flies, and whether core knows it.

use std::collections::BTreeSet;

use backseat_spi::BehaviorId;
use backseat_units::EastNorth;
use backseat_units::math::hypot;

use super::Outlook;
use crate::ledger::Entry;
use crate::mutations::{Check, is_on};
use crate::plugin::{NavigationSample, Refusal, RequestState};
use crate::refusal::Reason;
use crate::vehicle::course::{Begin, Flown, Sighting, WIDENS, leads_to};

impl Outlook<'_> {
    /// Where the vehicle was at the newest navigation, and how far it may have gone since.
    pub(crate) fn begins_here(&self) -> Option<Begin> {
        let navigation = self.vehicle.navigation.newest()?;
        let limits = self.monitor.limits();
        let age_s = self.now.since(navigation.solution).as_secs_f64() + limits.link_delay_max_s;
        Some(Begin {
            at: navigation.local,
            within_m: limits.speed_max_mps * age_s,
        })
    }

    /// Whether core knows what the vehicle flies and what it goes on to. Core needs this to judge a modify's ways back.
    /// The vehicle must fly a behavior of its plan or an insert of this process, and core must have heard it begin or
    /// have seen the vehicle on its line.
    pub(crate) fn knows_what_is_flown(&self) -> Result<(), Refusal> {
        let known = match self.vehicle.courses.current() {
            // With `modify_needs_plan = false`, core does without the plan, unless there was a previous run: that run
            // may have led the vehicle away from a line.
            None => {
                let without_plan = !self.monitor.limits().modify_needs_plan && self.vehicle.previous_run.is_none();
                self.is_placed() || (without_plan && !self.may_fly_insert())
            }
            Some(Flown::Planned(number)) => self.vehicle.plan.names(number) || !self.vehicle.plan.is_complete(),
            Some(Flown::Inserted(identifier)) => self.ledger.by_identifier(identifier).is_some(),
        };
        if !known {
            let unheard = self.vehicle.courses.current().is_none();
            let reason = if unheard {
                Reason::FlownUnheard
            } else {
                Reason::FlownNotPlanned
            };
            return Err(reason.into());
        }
        self.knows_what_is_taken_up(false)
    }

    /// Whether core has seen which planned behaviors the vehicle may fly, and the plan has them.
    pub(crate) fn is_placed(&self) -> bool {
        let placed = self.vehicle.courses.placed();
        !placed.is_empty() && placed.iter().all(|number| self.vehicle.plan.names(*number))
    }

    /// Whether core has heard what the vehicle flies. Core needs this to judge the way to an insert.
    pub(crate) fn heard_what_is_flown(&self, interrupts: bool) -> Result<(), Refusal> {
        match self.vehicle.courses.current() {
            None => return Err(Reason::BeginUnheard.into()),
            Some(Flown::Planned(_)) => {}
            Some(Flown::Inserted(identifier)) => {
                // Where another one ends is not known. It may be another payload's that the plan does not name, or one
                // of ours that the vehicle had refused.
                let ours = self.ledger.sent(identifier).is_some();
                let named = !self.identifiers.is_ours(identifier) && self.vehicle.plan.has(identifier);
                if !ours && !named {
                    return Err(Reason::FlownNotPlanned.into());
                }
            }
        }
        self.knows_what_is_taken_up(interrupts)
    }

    /// Whether core knows where the planned behavior began that the vehicle may take up again.
    pub(crate) fn knows_what_is_taken_up(&self, interrupts: bool) -> Result<(), Refusal> {
        if self.takes_up_plan(interrupts) && self.vehicle.courses.lacks_plan() {
            return Err(Reason::TakenUpUnheard.into());
        }
        if self.vehicle.courses.has_left_foreign() {
            return Err(Reason::TakenUpForeign.into());
        }
        Ok(())
    }

    /// Whether the vehicle may fly an insert, or be on its way to one, if nobody has heard what it flies.
    fn may_fly_insert(&self) -> bool {
        let courses = &self.vehicle.courses;
        self.ledger.open_inserts() > 0
            || self.ledger.left().next().is_some()
            || courses.shared()
            || courses.has_left_foreign()
            || self.others().next().is_some()
            || self.previous_run_may_fly()
    }

    /// The lines of the plan, and the number of the behavior to which each belongs. Empty if the vehicle may fly an
    /// insert: the line of an insert, or the way to it, may run along the plan's.
    pub(crate) fn lines_that_may_be_flown(&self) -> Vec<(u32, (EastNorth, EastNorth))> {
        let plan = &self.vehicle.plan;
        // An element without a number belongs to a behavior that core cannot name.
        let numbered = plan.planned().all(|element| element.number.is_some());
        if !plan.is_complete() || !numbered || self.may_fly_insert() {
            return Vec::new();
        }
        plan.lines().collect()
    }

    /// The planned behaviors to whose lines, or to the ways to them, the vehicle moves. The vehicle may be coming back to
    /// one of them, from where a modify has led it.
    pub(crate) fn ahead(&self, here: EastNorth, velocity: EastNorth) -> BTreeSet<u32> {
        let plan = &self.vehicle.plan;
        let approaches = self.vehicle.courses.begun_of_plan().flat_map(|(number, begin)| {
            let of = plan.planned().filter(move |element| element.number == Some(number));
            of.map(move |element| (number, (begin.at, element.first())))
        });
        let within_m = self.monitor.limits().tracking_error_m;
        let ahead = plan.lines().chain(approaches);
        let ahead = ahead.filter(|(_, line)| leads_to(here, velocity, *line, within_m));
        ahead.map(|(number, _)| number).collect()
    }

    /// The planned behaviors that the vehicle may fly, if it moves `along` lines of some. It may also be on the way to one
    /// of which a line is ahead of it, or on the way back to one that it flew before. If such a behavior begins ahead of the vehicle,
    /// no message tells where the way to it began.
    pub(crate) fn sighted(
        &self,
        along: &[u32],
        navigation: &NavigationSample,
        is_on: impl Fn((EastNorth, EastNorth)) -> bool,
    ) -> Vec<Sighting> {
        let velocity = EastNorth::new(navigation.east_mps, navigation.north_mps);
        let within_m = self.monitor.limits().tracking_error_m;
        let comes_to: BTreeSet<u32> = self.vehicle.courses.may_come_to().collect();
        let mut sighted: Vec<Sighting> = Vec::new();
        for element in self.vehicle.plan.planned() {
            let Some(number) = element.number else { continue };
            if sighted.iter().any(|sighting| sighting.number == number) {
                continue;
            }
            let ahead = leads_to(navigation.local, velocity, (element.first(), element.first()), within_m);
            let comes_from = ahead.then(|| self.comes_along(navigation.local, velocity, element.first()));
            if comes_from.is_some() || along.contains(&number) || comes_to.contains(&number) {
                sighted.push(Sighting {
                    number,
                    on_first_line: self.first_line_of(Flown::Planned(number)).is_some_and(&is_on),
                    comes_from,
                });
            }
        }
        sighted
    }

    /// The way on which the vehicle may be `here`, `to` the first point of a behavior. It counts as far back as a modify
    /// may lead the vehicle.
    fn comes_along(&self, here: EastNorth, velocity: EastNorth, to: EastNorth) -> Begin {
        let limits = self.monitor.limits();
        let back_m = limits.speed_max_mps * (limits.modify_term_max_s + limits.link_delay_max_s);
        let left_m = here.distance_m(to);
        if left_m <= limits.tracking_error_m {
            // So close to it, the direction to it says nothing.
            let speed_mps = hypot(velocity.east_m, velocity.north_m);
            return Begin {
                at: here + velocity * (-back_m / speed_mps),
                within_m: limits.tracking_error_m + WIDENS * back_m,
            };
        }
        let back = (here - to) * (back_m / left_m);
        Begin {
            at: here + back,
            within_m: limits.tracking_error_m * (1.0 + back_m / left_m),
        }
    }

    /// The line of a behavior, or the first of several, without leads. The others do not count, because the way to the
    /// first may lead along any of them.
    pub(crate) fn first_line_of(&self, flown: Flown) -> Option<(EastNorth, EastNorth)> {
        match flown {
            Flown::Planned(number) => {
                let mut planned = self.vehicle.plan.planned();
                let first = planned.find(|element| element.number == Some(number));
                first.and_then(|element| element.legs().next())
            }
            Flown::Inserted(identifier) => {
                let insert = self.ledger.get(self.ledger.by_identifier(identifier)?)?.insert?;
                self.monitor.envelope.line_without_leads(&insert)
            }
        }
    }

    /// Whether the vehicle may take up its plan again after what it flies, or after an insert that interrupts that.
    pub(crate) fn takes_up_plan(&self, interrupts: bool) -> bool {
        interrupts || self.ledger.interrupts() || self.previous_run_may_fly() || self.vehicle.courses.has_left_plan()
    }

    /// How many inserts of previous runs are left in the plan: they count towards the cap (safety requirements 007 and
    /// 019).
    pub(crate) fn inherited(&self) -> u32 {
        if !is_on(Check::InheritedInserts) {
            return 0;
        }
        // An insert of this process that core believed to be over counts if the plan still names it.
        let mut inherited: BTreeSet<BehaviorId> = self
            .others()
            .map(|(identifier, _)| identifier)
            .filter(|identifier| self.identifiers.is_used(*identifier))
            .collect();
        // An insert that has begun is flown, even if the plan does not name it.
        let current = self.vehicle.named_insert.may_be_current();
        inherited.extend(current.filter(|identifier| self.vehicle.previous_run.includes(*identifier)));
        u32::try_from(inherited.len())
            .unwrap_or(u32::MAX)
            .saturating_add(u32::from(self.vehicle.previous_run.is_still_flown_after_end()))
    }

    /// Whether the plan names an insert of this process that core believed to be over.
    pub(crate) fn names_what_is_over(&self) -> bool {
        self.others()
            .any(|(identifier, _)| self.identifiers.is_ours(identifier))
    }

    /// Whether the vehicle may still fly an insert of a previous run, or flies one that core believed to be over.
    pub(crate) fn previous_run_may_fly(&self) -> bool {
        let vehicle = self.vehicle;
        self.names_what_is_over()
            || vehicle
                .previous_run
                .may_fly(vehicle.named_insert.current(), &vehicle.plan)
    }

    /// Whether the vehicle may be on its way to the surface for a GPS hit that core believed to be over, or that a
    /// previous run has sent. Core cannot see this: BFPLN does not distinguish a GPS hit from a waypoint (SPI 6.20),
    /// the specification does not say which name BFMBS gives it (6.9), and nothing reports what began before we
    /// connected.
    pub(crate) fn previous_run_may_surface(&self) -> bool {
        let doubtful = |entry: &Entry| entry.insert.is_some_and(|insert| insert.surfaces());
        self.vehicle
            .previous_run
            .may_surface(self.ledger.doubtful().any(doubtful))
    }

    /// Safety requirement 002: a vehicle that a request leads away from a GPS hit surfaces wherever it is then.
    pub(crate) fn admit_beside_gps_hit(&self) -> Result<(), Refusal> {
        let begun = |entry: &Entry| entry.state == RequestState::Started;
        let flown = self
            .ledger
            .iter()
            .any(|(request, entry)| begun(entry) && self.ledger.is_gps_hit(Some(request)));
        // If core has not heard what is flown, it may be a GPS hit that waited.
        let unheard = self.vehicle.courses.current().is_none() && self.ledger.surfaces();
        if (flown || unheard || self.previous_run_may_surface()) && is_on(Check::Surfacing) {
            return Err(Reason::GpsHitFlown.into());
        }
        Ok(())
    }
}
