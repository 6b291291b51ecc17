//! Where the vehicle comes from before a request, and where it goes on to after it.

use backseat_units::Depth;

use super::Outlook;
use crate::monitor::envelope::{End, Insert, Passage, Route, Track};
use crate::plugin::RequestState;
use crate::vehicle::plan::Element;

/// From above the surface to the deepest sea.
const ALL_DEPTHS_M: [f64; 2] = [-100.0, 12_000.0];

impl Outlook<'_> {
    /// Where the vehicle goes when a modify lapses: back to the leg that it flies, or on to what comes after it.
    pub(crate) fn route_of_modify(&self) -> Route {
        let mut route = Route {
            to: self.vehicle.plan.next_points().into_iter().map(End::At).collect(),
            before_s: self.flown_insert_s(),
            depths_m: self.depths_of_ways(),
            seen_mps: self.vehicle.courses.seen_mps(),
            ..Route::default()
        };
        // A vehicle that is on its way to the start of its path comes back to that way.
        let begun = self.vehicle.courses.of_current();
        let mut flying = false;
        for (_, entry) in self.ledger.iter() {
            let Some(insert) = entry.insert else { continue };
            let heard = self.vehicle.courses.current().is_some() && entry.state == RequestState::Started;
            if heard {
                route.legs.extend(self.tracks_of_insert(&insert, &begun));
            }
            flying |= heard;
            if !heard {
                route.to.push(self.monitor.envelope.ends(&insert).0);
            }
        }
        // Inserts that the vehicle has not answered, and inserts that are not ours, may come next.
        let doubtful = self.ledger.doubtful().filter_map(|entry| entry.insert);
        route
            .to
            .extend(doubtful.map(|insert| self.monitor.envelope.ends(&insert).0));
        let others = self.others();
        route.to.extend(others.map(|(_, element)| End::At(element.first())));
        route.to.extend(self.returns_to().map(End::At));
        // The vehicle may end an insert from which the modify leads it away (SPI 7.12), and take up again what that
        // insert has interrupted.
        route.legs.extend(self.taken_up_after(false));
        if !flying {
            let lines: Vec<_> = self.vehicle.plan.current().flat_map(Element::legs).collect();
            route.legs.extend(self.tracks_of_lines(&begun, &lines));
        }
        route.legs.extend(
            self.vehicle
                .plan
                .seen_before()
                .map(|(start, end)| Track::Line(start, end)),
        );
        route
    }

    /// Where the vehicle may be when an insert begins, and what it may go on to after it.
    pub(crate) fn route_of_insert(&self, interrupt: bool) -> Route {
        let chain = self.chain();
        let mut route = Route {
            to: self.vehicle.plan.goes_on_to().into_iter().map(End::At).collect(),
            before_s: self.before_insert_s(interrupt),
            onto: self.taken_up_after(interrupt),
            depths_m: self.depths_of_ways(),
            seen_mps: self.vehicle.courses.seen_mps(),
            ..Route::default()
        };
        let here = self
            .vehicle
            .navigation
            .newest()
            .map(|navigation| End::At(navigation.local));
        if interrupt {
            route.from.extend(here);
            // After an interruption the vehicle goes on to the next behavior, or back to the interrupted one: the
            // specification can be read both ways (SPI 7.5).
            route.to.extend(
                self.vehicle
                    .plan
                    .current()
                    .flat_map(|element| [element.first(), element.last()].map(End::At)),
            );
            route
                .to
                .extend(chain.iter().map(|(_, insert, _)| self.monitor.envelope.ends(insert).0));
            route.to_surface = chain.iter().any(|(_, insert, _)| insert.surfaces());
            // The other inserts are flown before the plan goes on (7.5), whoever has requested them.
            for doubtful in self.ledger.doubtful().filter_map(|entry| entry.insert) {
                route.to.push(self.monitor.envelope.ends(&doubtful).0);
                route.to_surface |= doubtful.surfaces();
            }
            let others = self.others();
            route.to.extend(others.map(|(_, element)| End::At(element.first())));
            return route;
        }
        // An insert that was not answered may still be flown before this one.
        let doubtful: Vec<Insert> = self.ledger.doubtful().filter_map(|entry| entry.insert).collect();
        let mut before = doubtful.iter().chain(chain.iter().map(|(_, insert, _)| insert));
        route.from_surface = before.any(Insert::surfaces);
        route.deepest_m = self.deepest_open_m();
        route
            .from
            .extend(doubtful.iter().map(|insert| self.monitor.envelope.ends(insert).1));
        route.from.extend(self.comes_from(&chain));
        route
    }

    /// Where the vehicle may be when it goes on to what comes after these inserts, which are in the order in which they
    /// are flown. It is at the end of the last insert that it surely flies, or of one after that. If none is sure, it
    /// may also be anywhere on the element of its plan that it flies, or between that element and the place from which
    /// it comes back to it: where it is now, or the end of the insert that interrupts the element.
    pub(crate) fn comes_from(&self, before: &[(u64, Insert, bool)]) -> Vec<End> {
        // Inserts that are not ours come before the next one too (SPI 7.5: a new one is appended at the end of the
        // set).
        let others = self.others();
        let mut from: Vec<End> = others.map(|(_, element)| End::At(element.last())).collect();
        for (request, insert, begun) in before.iter().rev() {
            from.push(self.monitor.envelope.ends(insert).1);
            // After an insert that interrupts, the vehicle may take up again what it left.
            let interrupted = self.ledger.get(*request).is_some_and(|entry| entry.interrupted);
            if !insert.interrupt
                && !interrupted
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
        if from.is_empty() {
            from.extend(here);
        }
        from
    }

    /// The least and the greatest depth on the ways to what the vehicle flies before or after a request, metres. Core
    /// knows the depths of our own inserts. No sentence says at which depth the front seat flies. Core assumes the
    /// depths at which the vehicle has settled in this mission, once it has settled on what it flies now, and all
    /// depths before that.
    pub(crate) fn depths_of_ways(&self) -> Option<[f64; 2]> {
        let Some([from_m, to_m]) = self.vehicle.courses.settled_depths_m() else {
            return Some(ALL_DEPTHS_M);
        };
        // No sentence says at which depth an insert is flown that is not ours (6.20).
        let mut others = self.others();
        if others.next().is_some() {
            return Some(ALL_DEPTHS_M);
        }
        let navigation = self.vehicle.navigation.newest()?;
        let lock = self.vehicle.navigation.bottom_lock(self.now);
        let (mut from_m, mut to_m) = (from_m.min(navigation.depth.as_m()), to_m.max(navigation.depth.as_m()));
        for (_, insert, _) in self.chain() {
            let Some([least_m, most_m]) = self.monitor.envelope.depths_m(&insert, navigation.depth, lock) else {
                return Some(ALL_DEPTHS_M);
            };
            (from_m, to_m) = (from_m.min(least_m), to_m.max(most_m));
        }
        let error_m = self.monitor.limits().vertical_error_m;
        Some([from_m - error_m, to_m + error_m])
    }

    /// The greatest depth to which an insert leads that is open or was not answered, metres.
    pub(crate) fn deepest_open_m(&self) -> f64 {
        let chain = self.chain();
        let doubtful = self.ledger.doubtful().filter_map(|entry| entry.insert);
        let open = doubtful.chain(chain.into_iter().map(|(_, insert, _)| insert));
        let depth_m = |insert: Insert| {
            let navigation = self.vehicle.navigation.newest()?;
            let lock = self.vehicle.navigation.bottom_lock(self.now);
            self.monitor.envelope.deepest_m(&insert, navigation.depth, lock)
        };
        // If one depth cannot be known, it counts as infinite, and every judgement that depends on it fails.
        open.map(|insert| depth_m(insert).unwrap_or(f64::INFINITY))
            .fold(0.0, f64::max)
    }

    /// How a way is flown that starts at this depth, and begins after `before_s` seconds at the latest.
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
