//! Inserts: tracklines, trackcircles and GPS hits that the vehicle flies by itself once it has accepted them (SPI 7.5 to
//! 7.7), and their cancelling (7.8). Safety requirements 002, 009, 010 and 019.
//!
//! A GPS hit is an insert that runs after the current behaviour and that nothing takes back: BPRCN covers tracklines and
//! trackcircles alone.

use std::collections::BTreeSet;

use backseat_spi::{
    BehaviorId, CancelBehavior, CircleEntry, GpsHit, Interrupt, SpeedMode, SurfaceMode, ToVehicle, Trackcircle,
    Trackline, VerticalMode,
};
use backseat_units::Timestamp;

use crate::commands::{Answer, Command, FIRST_WITHIN, Purpose, SETTLED_WITHIN};
use crate::context::Context;
use crate::envelope::{End, Flight, Insert, InsertPath, Route, Vertical};
use crate::io::Output;
use crate::irrevocable::Waiting;
use crate::ledger::{Entry, RequestKind};
use crate::limits::Grant;
use crate::plugin::{PluginId, Refusal, Request, RequestState, TrackcircleRequest};
use crate::recall::Recalls;
use crate::refusal::refused;
use crate::schedule::Schedule;
use crate::session::name;
use crate::switches::{Check, is_on};
use crate::timer::Timer;

/// What the judgement of an insert found that is kept with it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Admitted {
    /// How long it flies at most, seconds.
    duration_s: f64,
    schedule: Option<Schedule>,
}

/// The inserts that wait for an answer of the vehicle before they leave, and those that are being taken back.
#[derive(Debug, Default)]
pub(crate) struct Inserts {
    pub(crate) waiting: Vec<Waiting>,
    pub(crate) recalls: Recalls,
}

/// The grant that an insert needs; one that interrupts needs that of its own beside it.
const fn grant_of(insert: &Insert) -> Grant {
    if insert.surfaces() {
        Grant::Surface
    } else {
        Grant::Insert
    }
}

impl Inserts {
    pub(crate) fn asked(&mut self, cx: &mut Context, plugin: PluginId, asked: &Request) {
        let (tag, kind, insert) = match asked {
            Request::Trackline(line) => (
                line.tag,
                RequestKind::Trackline,
                cx.monitor.envelope.admit_trackline(line),
            ),
            Request::Trackcircle(circle) => (
                circle.tag,
                RequestKind::Trackcircle,
                self.admit_layout(cx, circle)
                    .and_then(|()| cx.monitor.envelope.admit_trackcircle(circle)),
            ),
            Request::GpsHit(hit) => (hit.tag, RequestKind::GpsHit, cx.monitor.envelope.admit_gps_hit(hit)),
            Request::Modify(_)
            | Request::EndModify
            | Request::Cancel(_)
            | Request::Message(_)
            | Request::Topside(_)
            | Request::DvlTrigger(_)
            | Request::Silent(_)
            | Request::Trim(_)
            | Request::Buoyancy(_)
            | Request::Packet(_)
            | Request::Hold(_)
            | Request::EndHold
            | Request::SonarAngle(_)
            | Request::Camera(_)
            | Request::Light(_)
            | Request::Timer { .. } => return,
        };
        cx.reserve();
        let request = cx.ledger.propose(plugin, tag, kind);
        let admitted = insert.and_then(|insert| {
            cx.admit(plugin, grant_of(&insert))?;
            if insert.interrupt && !cx.plugins[plugin.0].grants().contains(&Grant::Interrupt) {
                return Err(refused("grant", "the mission does not grant it Interrupt"));
            }
            Ok((insert, self.admit(cx, plugin, tag, &insert)?))
        });
        match admitted {
            Ok((insert, _)) if self.waits_for_answer(cx, &insert) => {
                self.wait_for_answer(cx, request, plugin, tag, insert)
            }
            Ok((insert, admitted)) => self.send_insert(cx, request, insert, admitted),
            Err(refusal) => cx.reject(request, refusal),
        }
    }

    /// All that an insert needs at the moment that it leaves.
    pub(crate) fn admit(
        &mut self,
        cx: &mut Context,
        plugin: PluginId,
        tag: u64,
        insert: &Insert,
    ) -> Result<Admitted, Refusal> {
        let route = self.admit_insert(cx, plugin, tag, insert)?;
        self.judge_insert(cx, insert, &route)?;
        cx.admit_delay(insert, &route)?;
        Ok(Admitted {
            duration_s: self.cap_duration(cx, plugin, insert, &route)?,
            schedule: cx.schedule(insert, &route),
        })
    }

    /// The two layouts of BPRTC in SPI 7.6 differ in what comes before the interrupt code. Where nobody has said which one
    /// the vehicle reads, a circle leaves only if both read it alike: after what is flown, entered anywhere.
    fn admit_layout(&self, cx: &Context, circle: &TrackcircleRequest) -> Result<(), Refusal> {
        let layout = cx.settings.trackcircle_entry_angle;
        let text = match layout {
            Some(true) => return Ok(()),
            _ if circle.entry_angle_deg.is_some() => {
                "the mission does not say that the vehicle reads a circle's entry angle (vehicle.trackcircle_entry_angle)"
            }
            None if circle.interrupt => {
                "the mission does not say where the vehicle reads a circle's interrupt code (vehicle.trackcircle_entry_angle)"
            }
            Some(false) | None => return Ok(()),
        };
        Err(refused("layout", text))
    }

    /// All that does not hang on the geometry: grants, the plan, doubt, caps of number, identifiers. The insert's route.
    fn admit_insert(
        &mut self,
        cx: &mut Context,
        plugin: PluginId,
        tag: u64,
        insert: &Insert,
    ) -> Result<Route, Refusal> {
        let surfaces = insert.surfaces();
        cx.admit_standing(grant_of(insert))?;
        if !cx.vehicle.plan.is_complete() && is_on(Check::PlanKnown) {
            return Err(refused(
                "plan",
                "the vehicle's plan is not known, nor so where the insert would begin",
            ));
        }
        if cx.ledger.in_doubt() && is_on(Check::InsertInDoubt) {
            return Err(refused(
                "doubt",
                "the vehicle has not answered for an earlier insert since the link was lost",
            ));
        }
        if cx.open_insert(plugin, tag).is_some() || self.is_waiting(plugin, tag) {
            return Err(refused("tag", "an insert with this tag is still open"));
        }
        if insert.interrupt {
            cx.admit_beside_gps_hit()?;
        }
        if insert.interrupt && cx.ledger.interrupts() && is_on(Check::InterruptOfInterrupt) {
            return Err(refused(
                "interrupt",
                "an insert that interrupts is open, and none may interrupt it (SPI 7.5)",
            ));
        }
        if insert.interrupt && cx.former_may_fly() && is_on(Check::InterruptOfInterrupt) {
            return Err(refused(
                "interrupt",
                "an insert of an earlier process may be flown, and may be one that none may interrupt (SPI 7.5)",
            ));
        }
        let current = cx.vehicle.named_insert.current();
        if insert.interrupt
            && current.is_some_and(|current| !cx.identifiers.is_ours(current))
            && is_on(Check::InterruptOfInterrupt)
        {
            return Err(refused(
                "interrupt",
                "an insert that is not ours is flown, and may be one that none may interrupt (SPI 7.5)",
            ));
        }
        let limits = cx.monitor.limits();
        if cx.ledger.open_inserts() + cx.inherited() >= limits.inserts_open_max && is_on(Check::InsertsOpen) {
            return Err(refused(
                "cap",
                &format!("{} inserts are open, the most there may be", limits.inserts_open_max),
            ));
        }
        if surfaces && cx.identifiers.gps_hits_sent() >= limits.gps_hits_total_max && is_on(Check::GpsHitsTotal) {
            return Err(refused(
                "cap",
                &format!(
                    "{} GPS hits have been sent, the most of a mission",
                    limits.gps_hits_total_max
                ),
            ));
        }
        if !surfaces && cx.identifiers.inserts_sent() >= limits.inserts_total_max && is_on(Check::InsertsTotal) {
            return Err(refused(
                "cap",
                &format!(
                    "{} inserts have been sent, the most of a mission",
                    limits.inserts_total_max
                ),
            ));
        }
        let own = cx.plugins[plugin.0].limits();
        let open = cx.ledger.open_inserts_of(plugin);
        if let Some(most) = own.inserts_open_max.filter(|most| open >= *most) {
            let text = format!("{open} inserts of its own are open, and {most} may be");
            return Err(refused("cap", &text));
        }
        let sent = cx.plugins[plugin.0].inserts_sent();
        if let Some(most) = own.inserts_total_max.filter(|most| !surfaces && sent >= *most) {
            let text = format!("it has sent {sent} inserts, and may send {most}");
            return Err(refused("cap", &text));
        }
        if is_on(Check::PlanKnown) {
            cx.heard_what_is_flown(insert.interrupt)?;
        }
        let plan = &cx.vehicle.plan;
        cx.identifiers
            .next_insert(surfaces, |identifier| plan.has(identifier))?;
        Ok(cx.route_of_insert(insert.interrupt))
    }

    /// How long an insert flies at most, where that and what is open stay under the cap.
    fn cap_duration(&self, cx: &Context, plugin: PluginId, insert: &Insert, route: &Route) -> Result<f64, Refusal> {
        let duration_s = cx.monitor.envelope.duration_s(insert, &route.from);
        let open_s = cx.ledger.open_duration_s();
        let most_s = cx.monitor.limits().inserts_duration_max_s;
        if open_s + duration_s > most_s && is_on(Check::InsertsDuration) {
            return Err(refused(
                "cap",
                &format!(
                    "it may fly for {duration_s:.0} s and the open inserts for {open_s:.0} s, together over {most_s} s"
                ),
            ));
        }
        let own_s = cx.ledger.open_duration_of_s(plugin);
        let own_max_s = cx.plugins[plugin.0].limits().inserts_duration_max_s;
        if let Some(most_s) = own_max_s.filter(|most_s| own_s + duration_s > *most_s) {
            let text = format!(
                "it may fly for {duration_s:.0} s and its plugin's open inserts for {own_s:.0} s, together over {most_s} s"
            );
            return Err(refused("cap", &text));
        }
        Ok(duration_s)
    }

    fn judge_insert(&self, cx: &Context, insert: &Insert, route: &Route) -> Result<f64, Refusal> {
        let Some(navigation) = cx.vehicle.navigation.fresh(cx.now) else {
            return Err(refused("navigation", "navigation is stale"));
        };
        if !is_on(Check::InsertFence) {
            return Ok(f64::MAX);
        }
        cx.monitor.envelope.judge_insert(
            insert,
            navigation.depth,
            cx.vehicle.navigation.bottom_lock(cx.now),
            route,
            cx.clocks(),
        )
    }

    pub(crate) fn send_insert(&mut self, cx: &mut Context, request: u64, insert: Insert, admitted: Admitted) {
        let Admitted { duration_s, schedule } = admitted;
        let Some(identifier) = cx.identifiers.take() else {
            return;
        };
        let identifier = BehaviorId::new(identifier);
        let interrupt = if insert.interrupt {
            Interrupt::InterruptCurrent
        } else {
            Interrupt::AfterCurrent
        };
        let (message, letters, created) = match insert.path {
            InsertPath::Line { start, end, flight } => {
                let created = cx.stamper.stamp(cx.now, "RTK");
                let (vertical_m, vertical_mode, speed) = figures(flight);
                let message = ToVehicle::Trackline(Trackline {
                    created,
                    identifier,
                    start,
                    end,
                    vertical_mode,
                    vertical_m,
                    speed,
                    speed_mode: SpeedMode::MetresPerSecond,
                    interrupt,
                });
                (message, "RTK", created)
            }
            InsertPath::Circle {
                centre,
                radius_m,
                orbits,
                entry_angle_deg,
                flight,
            } => {
                let created = cx.stamper.stamp(cx.now, "RTC");
                let (vertical_m, vertical_mode, speed) = figures(flight);
                let message = ToVehicle::Trackcircle(Trackcircle {
                    created,
                    identifier,
                    centre,
                    radius_m,
                    orbits,
                    vertical_mode,
                    vertical_m,
                    speed,
                    speed_mode: SpeedMode::MetresPerSecond,
                    entry_angle_deg: match cx.settings.trackcircle_entry_angle {
                        Some(true) => entry_angle_deg.map_or(CircleEntry::Anywhere, CircleEntry::Angle),
                        Some(false) => CircleEntry::Absent,
                        // The interrupt code of who takes it for that is the same as the one that follows.
                        None => CircleEntry::Angle(0.0),
                    },
                    interrupt,
                });
                (message, "RTC", created)
            }
            InsertPath::Surface { at } => {
                let created = cx.stamper.stamp(cx.now, "RGP");
                let message = ToVehicle::GpsHit(GpsHit {
                    created,
                    identifier,
                    position: at,
                    // Vehicles ignore both today and use their default (7.7). Empty means the default in every reading;
                    // a zero would be no time and no fix to a vehicle that heeds them one day.
                    surface_within_s: None,
                    hits: None,
                    mode: SurfaceMode::StraightLine,
                });
                (message, "RGP", created)
            }
        };
        let command = Command {
            name: name(letters),
            created: Some(created),
            identifier: Some(identifier),
            purpose: Purpose::Insert(request),
            deadline: cx.now + 2 * FIRST_WITHIN,
            pending: false,
        };
        if !cx.transmit(&message, Some(command)) {
            cx.reserve();
            return cx.reject(request, refused("control", "it could not be sent"));
        }
        cx.identifiers.sent(identifier, insert.surfaces());
        if !insert.surfaces()
            && let Some(plugin) = cx.ledger.get(request).and_then(|entry| entry.owner.plugin())
        {
            cx.plugins[plugin.0].count_insert();
        }
        cx.reserve();
        if let Some(entry) = cx.ledger.get_mut(request) {
            entry.identifier = Some(identifier);
            entry.insert = Some(insert);
            entry.duration_s = duration_s;
            entry.schedule = schedule;
            entry.sent_at = cx.now;
        }
        cx.transition(request, RequestState::Sent);
    }

    pub(crate) fn asked_cancel(&mut self, cx: &mut Context, plugin: PluginId, tag: u64) {
        let cancel = cx.ledger.propose(plugin, tag, RequestKind::Cancel);
        match self.admit_cancel(cx, plugin, tag) {
            Ok(insert) => {
                let identifier = cx.ledger.get(insert).and_then(|entry| entry.identifier);
                if identifier.is_some_and(|identifier| cx.send_cancel(Some(cancel), insert, identifier)) {
                    cx.transition(cancel, RequestState::Sent);
                } else {
                    cx.reject(cancel, refused("control", "it could not be sent"));
                }
            }
            Err(refusal) => cx.reject(cancel, refusal),
        }
    }

    fn admit_cancel(&mut self, cx: &mut Context, plugin: PluginId, tag: u64) -> Result<u64, Refusal> {
        cx.admit(plugin, Grant::Insert)?;
        let Some(insert) = cx.open_insert(plugin, tag) else {
            return Err(refused("tag", "no insert with this tag is open"));
        };
        if cx
            .ledger
            .get(insert)
            .is_some_and(|entry| entry.state == RequestState::Started)
        {
            return Err(refused(
                "tag",
                "the insert has begun and can no longer be cancelled (SPI 7.8)",
            ));
        }
        if cx.ledger.is_gps_hit(Some(insert)) {
            return Err(refused(
                "tag",
                "a GPS hit cannot be cancelled: BPRCN covers tracklines and trackcircles only (SPI 7.8)",
            ));
        }
        // Without it the vehicle goes from what was before it to what comes after it.
        cx.judge_cancel(&cx.chain(), insert)?;
        Ok(insert)
    }

    /// The vehicle's answer to an insert.
    pub(crate) fn answered(&mut self, cx: &mut Context, request: u64, answer: Answer<'_>) {
        match answer {
            Answer::Pending => cx.transition(request, RequestState::Pending),
            Answer::Done => cx.transition(request, RequestState::Accepted),
            Answer::Refused(text) => cx.transition(request, RequestState::Failed(text.to_owned())),
            Answer::Missing => self.unanswered(cx, request),
        }
    }

    /// The vehicle's answer to a cancel.
    pub(crate) fn cancel_answered(&mut self, cx: &mut Context, cancel: Option<u64>, insert: u64, answer: Answer<'_>) {
        if cancel.is_none() {
            self.recall_answered(cx, insert, answer);
        }
        match answer {
            Answer::Pending => {}
            Answer::Missing => {
                if let Some(cancel) = cancel {
                    cx.transition(cancel, RequestState::TimedOut);
                }
            }
            Answer::Done => {
                if let Some(identifier) = cx.ledger.get(insert).and_then(|entry| entry.identifier) {
                    cx.vehicle.plan.ended(identifier);
                }
                cx.transition(insert, RequestState::Cancelled);
                cx.ledger.settle_doubt(insert);
                if let Some(cancel) = cancel {
                    cx.transition(cancel, RequestState::Accepted);
                    cx.transition(cancel, RequestState::Ended("done".to_owned()));
                }
            }
            Answer::Refused(text) => {
                if let Some(cancel) = cancel {
                    cx.transition(cancel, RequestState::Failed(text.to_owned()));
                }
            }
        }
    }

    /// An insert was not answered: it counts as one that the vehicle may fly, and is called back where that is possible.
    fn unanswered(&mut self, cx: &mut Context, request: u64) {
        if !cx.ledger.is_gps_hit(Some(request)) {
            self.recall(cx, request);
        }
        cx.transition(request, RequestState::TimedOut);
    }

    /// The plan has come whole: inserts in doubt are in it or are not.
    pub(crate) fn resolve_by_plan(&mut self, cx: &mut Context) {
        let open: Vec<(u64, BehaviorId, Timestamp)> = cx
            .ledger
            .iter()
            .filter(|(_, entry)| entry.state == RequestState::Unknown)
            .filter_map(|(request, entry)| Some((request, entry.identifier?, entry.sent_at + SETTLED_WITHIN)))
            .collect();
        let asked_at = cx.vehicle.plan.asked_at();
        for (request, identifier, decided_at) in open {
            if cx.vehicle.plan.has(identifier) {
                cx.transition(request, RequestState::Accepted);
            } else if asked_at < decided_at {
                // The vehicle may not have decided on it yet.
                cx.timers.set(Timer::Plan, decided_at.max(cx.now));
            } else if cx.vehicle.courses.current().is_some() && !cx.ledger.is_gps_hit(Some(request)) {
                let text = "it is not in the vehicle's plan".to_owned();
                cx.transition(request, RequestState::Failed(text));
            } else {
                // It may be flown; and BFPLN has no code for a GPS hit (6.20), so that a plan without it proves nothing. It
                // stays under the caps.
                cx.transition(request, RequestState::TimedOut);
            }
        }
        let plan = &cx.vehicle.plan;
        cx.ledger.told_plan(asked_at, |identifier| plan.has(identifier));
    }

    /// The mission no longer runs: what it held is over.
    pub(crate) fn mission_over(&mut self, cx: &mut Context, reason: &str) {
        let open: Vec<u64> = cx
            .ledger
            .iter()
            .filter(|(_, entry)| entry.is_open_insert())
            .map(|(request, _)| request)
            .collect();
        for request in open {
            cx.transition(request, RequestState::Ended(reason.to_owned()));
        }
        cx.ledger.settle_all_doubt();
    }
}

impl Context {
    /// Sends a cancel: of the request `cancel`, or of the runtime's own. False where it could not be sent.
    pub(crate) fn send_cancel(&mut self, cancel: Option<u64>, insert: u64, identifier: BehaviorId) -> bool {
        let created = self.stamper.stamp(self.now, "RCN");
        let command = Command {
            name: name("RCN"),
            created: Some(created),
            identifier: Some(identifier),
            purpose: Purpose::Cancel { cancel, insert },
            deadline: self.now + 2 * FIRST_WITHIN,
            pending: false,
        };
        self.transmit(
            &ToVehicle::CancelBehavior(CancelBehavior { created, identifier }),
            Some(command),
        )
    }

    /// Asks for more where few identifiers are left, or not as many inserts as may be open at once.
    pub(crate) fn reserve(&mut self) {
        let ahead = self.monitor.limits().inserts_open_max.max(1);
        let surfaces = self.plugins.iter().any(|slot| slot.grants().contains(&Grant::Surface));
        if let Some(reservation) = self.identifiers.reserve(self.now, ahead, surfaces) {
            self.outbox.push(Output::Reserve(reservation));
        }
    }

    /// Safety requirement 002: a vehicle that is led away from a GPS hit comes up wherever it is then.
    pub(crate) fn admit_beside_gps_hit(&self) -> Result<(), Refusal> {
        let begun = |entry: &Entry| entry.state == RequestState::Started;
        let flown = self
            .ledger
            .iter()
            .any(|(request, entry)| begun(entry) && self.ledger.is_gps_hit(Some(request)));
        // Where it was not heard what is flown, one that waited may be.
        let unheard = self.vehicle.courses.current().is_none() && self.ledger.surfaces();
        if (flown || unheard || self.former_may_surface()) && is_on(Check::Surfacing) {
            let text = "a GPS hit is flown, and the vehicle would come up wherever this leaves it";
            return Err(refused("surface", text));
        }
        Ok(())
    }

    /// Our open inserts in the order that they fly, with their requests and whether they have begun.
    pub(crate) fn chain(&self) -> Vec<(u64, Insert, bool)> {
        self.ledger
            .iter()
            .filter_map(|(request, entry)| Some((request, entry.insert?, entry.state == RequestState::Started)))
            .collect()
    }

    /// How many inserts of the plan an earlier process of ours has left: they count under the cap (safety requirements
    /// 007 and 019).
    pub(crate) fn inherited(&self) -> u32 {
        if !is_on(Check::InheritedInserts) {
            return 0;
        }
        // One of this process that was held to be over counts where the plan names it all the same.
        let others = self
            .vehicle
            .plan
            .others(|identifier| self.ledger.by_identifier(identifier).is_some());
        let mut inherited: BTreeSet<BehaviorId> = others
            .map(|(identifier, _)| identifier)
            .filter(|identifier| self.identifiers.is_used(*identifier))
            .collect();
        // One that has begun is flown, though the plan that came did not name it.
        let current = self.vehicle.named_insert.may_be_current();
        inherited.extend(current.filter(|identifier| self.vehicle.former.includes(*identifier)));
        u32::try_from(inherited.len())
            .unwrap_or(u32::MAX)
            .saturating_add(u32::from(self.vehicle.former.has_revenant()))
    }

    pub(crate) fn open_insert(&self, plugin: PluginId, tag: u64) -> Option<u64> {
        self.ledger
            .iter()
            .find(|(_, entry)| entry.is_open_insert() && entry.owner == plugin && entry.tag == tag)
            .map(|(request, _)| request)
    }

    /// Where the vehicle will be when an insert begins, and what it may go on to after it.
    pub(crate) fn route_of_insert(&self, interrupt: bool) -> Route {
        let chain = self.chain();
        let mut route = Route {
            to: self.vehicle.plan.next_points().into_iter().map(End::At).collect(),
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
            // After an interruption the vehicle goes on to the next behaviour, or back: readings differ (SPI 7.5).
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
            // The rest of the set is flown before the plan goes on (7.5), whoever has asked for it.
            for doubtful in self.ledger.doubtful().filter_map(|entry| entry.insert) {
                route.to.push(self.monitor.envelope.ends(&doubtful).0);
                route.to_surface |= doubtful.surfaces();
            }
            let others = self
                .vehicle
                .plan
                .others(|identifier| self.identifiers.is_ours(identifier));
            route.to.extend(others.map(|(_, element)| End::At(element.first())));
            return route;
        }
        // One that was not answered may be flown before this one all the same.
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

    /// The greatest depth that an open insert leads to, metres, or one that was not answered.
    pub(crate) fn deepest_open_m(&self) -> f64 {
        let chain = self.chain();
        let doubtful = self.ledger.doubtful().filter_map(|entry| entry.insert);
        let open = doubtful.chain(chain.into_iter().map(|(_, insert, _)| insert));
        let depth_m = |insert: Insert| {
            let navigation = self.vehicle.navigation.newest()?;
            let lock = self.vehicle.navigation.bottom_lock(self.now);
            self.monitor.envelope.deepest_m(&insert, navigation.depth, lock)
        };
        // Where one cannot be known, nothing that depends on it holds.
        open.map(|insert| depth_m(insert).unwrap_or(f64::INFINITY))
            .fold(0.0, f64::max)
    }
}

fn figures(flight: Flight) -> (f64, VerticalMode, f64) {
    let (vertical_m, mode) = match flight.vertical {
        Vertical::Depth(depth) => (depth.as_m(), VerticalMode::Depth),
        Vertical::Altitude(altitude) => (altitude.as_m(), VerticalMode::Altitude),
    };
    (vertical_m, mode, flight.speed.as_mps())
}
