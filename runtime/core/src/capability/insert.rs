//! Inserts: tracklines, trackcircles and GPS hits (SPI 7.5 to 7.7), and their cancels (7.8). The vehicle flies an
//! insert by itself once it has accepted it. Safety requirements 002, 009, 010 and 019.
//!
//! A GPS hit is an insert that runs after the current behavior. Nothing can take it back: BPRCN covers tracklines and
//! trackcircles only.

pub(crate) mod irrevocable;
pub(crate) mod late;
pub(crate) mod previous_run;
pub(crate) mod recall;
pub(crate) mod waiting;

use backseat_spi::{
    BehaviorId, CancelBehavior, CircleEntry, GpsHit, Interrupt, SpeedMode, SurfaceMode, ToVehicle, Trackcircle,
    Trackline, VerticalMode,
};
use backseat_units::Timestamp;
use std::time::Duration;

use crate::capability::insert::irrevocable::Waiting;
use crate::capability::insert::recall::Recalls;
use crate::context::Context;
use crate::ended::{EndCause, Failure};
use crate::io::Note;
use crate::ledger::Entry;
use crate::ledger::schedule::Schedule;
use crate::monitor::envelope::{Flight, Insert, InsertPath, Route, Vertical};
use crate::monitor::limits::Grant;
use crate::mutations::{Check, is_on};
use crate::plugin::{PluginId, Refusal, Request, RequestState, TrackcircleRequest};
use crate::refusal::{Figure, Reason, Uncontrolled};
use crate::session::commands::{Answer, Purpose, SETTLED_WITHIN};
use crate::session::dispatch::Dispatch;
use crate::timer::Timer;

/// Results of an insert's judgement that are kept with it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Admitted {
    /// How long it flies at most, seconds.
    duration_s: f64,
    schedule: Option<Schedule>,
}

/// The inserts that wait for an answer of the vehicle before they leave, and those that the runtime is cancelling.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Inserts {
    waiting: Vec<Waiting>,
    recalls: Recalls,
}

/// How long after a cancel that did not succeed core asks for the plan: six times a minute at most.
const ASKED_AGAIN: Duration = Duration::from_secs(10);

/// The grant that an insert needs. One that interrupts needs `Grant::Interrupt` as well.
pub(crate) const fn grant_of(insert: &Insert) -> Grant {
    if insert.surfaces() {
        Grant::Surface
    } else {
        Grant::Insert
    }
}

impl Inserts {
    /// The insert that a request asks for, if its figures are in range; `None` for requests of other kinds.
    pub(crate) fn shape(&self, cx: &mut Context, asked: &Request) -> Option<Result<Insert, Refusal>> {
        let insert = match asked {
            Request::Trackline(line) => cx.monitor.envelope.admit_trackline(line),
            Request::Trackcircle(circle) => self
                .admit_layout(cx, circle)
                .and_then(|()| cx.monitor.envelope.admit_trackcircle(circle)),
            Request::GpsHit(hit) => cx.monitor.envelope.admit_gps_hit(hit),
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
            | Request::Station(_)
            | Request::EndStation
            | Request::SonarAngle(_)
            | Request::Camera(_)
            | Request::Light(_)
            | Request::SonarSet(_)
            | Request::SonarLog(_)
            | Request::Timer { .. } => return None,
        };
        cx.reserve();
        Some(insert)
    }

    /// Checks everything that an insert needs at the moment that it leaves.
    pub(crate) fn check(
        &mut self,
        cx: &mut Context,
        plugin: PluginId,
        tag: u64,
        insert: &Insert,
    ) -> Result<Admitted, Refusal> {
        let route = self.admit_insert(cx, plugin, tag, insert)?;
        self.judge_insert(cx, insert, &route)?;
        cx.outlook().admit_delay(insert, &route)?;
        Ok(Admitted {
            duration_s: self.cap_duration(cx, plugin, insert, &route)?,
            schedule: cx.outlook().schedule(insert, &route),
        })
    }

    /// What an insert sends, under the next identifier; `None` if the identifiers' state on disk is missing.
    pub(crate) fn dispatch(&self, cx: &mut Context, request: u64, insert: &Insert) -> Option<Dispatch> {
        let identifier = BehaviorId::new(cx.identifiers.take()?);
        let (letters, message) = message_of(cx, identifier, insert);
        Some(Dispatch::new(letters, message, Purpose::Insert(request)).naming(identifier))
    }

    /// SPI 7.6 has two layouts of BPRTC, which differ in what comes before the interrupt code. If the mission does not
    /// say which one the vehicle reads, a circle may leave only if it means the same in both: it is flown after the
    /// current behavior, and the vehicle enters it anywhere.
    fn admit_layout(&self, cx: &Context, circle: &TrackcircleRequest) -> Result<(), Refusal> {
        let layout = cx.settings.trackcircle_entry_angle;
        match layout {
            Some(true) => Ok(()),
            _ if circle.entry_angle_deg.is_some() => Err(Reason::EntryAngleUnread.into()),
            None if circle.interrupt => Err(Reason::InterruptCodeUnplaced.into()),
            Some(false) | None => Ok(()),
        }
    }

    /// Checks everything that does not depend on the geometry: plan, doubt, tag, interrupts, caps on numbers,
    /// identifiers. Returns the insert's route.
    fn admit_insert(
        &mut self,
        cx: &mut Context,
        plugin: PluginId,
        tag: u64,
        insert: &Insert,
    ) -> Result<Route, Refusal> {
        let surfaces = insert.surfaces();
        if !cx.vehicle.plan.is_complete() && is_on(Check::PlanKnown) {
            return Err(Reason::PlanUnknownForInsert.into());
        }
        if cx.ledger.in_doubt() && is_on(Check::InsertInDoubt) {
            return Err(Reason::InsertInDoubt.into());
        }
        if cx.outlook().open_insert(plugin, tag).is_some() || self.is_waiting(plugin, tag) {
            return Err(Reason::TagOpen.into());
        }
        if insert.interrupt {
            cx.outlook().admit_beside_gps_hit()?;
        }
        if insert.interrupt && cx.ledger.interrupts() && is_on(Check::InterruptOfInterrupt) {
            return Err(Reason::InterruptOpen.into());
        }
        if insert.interrupt && cx.outlook().previous_run_may_fly() && is_on(Check::InterruptOfInterrupt) {
            return Err(Reason::InterruptPreviousRun.into());
        }
        let current = cx.vehicle.named_insert.current();
        if insert.interrupt
            && current.is_some_and(|current| !cx.identifiers.is_ours(current))
            && is_on(Check::InterruptOfInterrupt)
        {
            return Err(Reason::InterruptForeign.into());
        }
        let limits = cx.monitor.limits();
        if cx.ledger.open_inserts() + cx.outlook().inherited() >= limits.inserts_open_max && is_on(Check::InsertsOpen) {
            return Err(Figure::OpenInserts.one_over(limits.inserts_open_max));
        }
        if surfaces && cx.identifiers.gps_hits_sent() >= limits.gps_hits_total_max && is_on(Check::GpsHitsTotal) {
            return Err(Figure::GpsHits.one_over(limits.gps_hits_total_max));
        }
        if !surfaces && cx.identifiers.inserts_sent() >= limits.inserts_total_max && is_on(Check::InsertsTotal) {
            return Err(Figure::Inserts.one_over(limits.inserts_total_max));
        }
        let own = cx.plugins.limits(plugin);
        let open = cx.ledger.open_inserts_of(plugin);
        if let Some(most) = own.inserts_open_max.filter(|most| open >= *most) {
            return Err(Figure::OwnOpenInserts.one_over(most));
        }
        let sent = cx.plugins.inserts_sent(plugin);
        if let Some(most) = own.inserts_total_max.filter(|most| !surfaces && sent >= *most) {
            return Err(Figure::OwnInserts.one_over(most));
        }
        if is_on(Check::PlanKnown) {
            cx.outlook().heard_what_is_flown(insert.interrupt)?;
        }
        let plan = &cx.vehicle.plan;
        cx.identifiers
            .next_insert(surfaces, |identifier| plan.has(identifier))?;
        Ok(cx.outlook().route_of_insert(insert.interrupt))
    }

    /// Returns how long an insert flies at most, seconds, if that and the open inserts together stay under the caps.
    fn cap_duration(&self, cx: &Context, plugin: PluginId, insert: &Insert, route: &Route) -> Result<f64, Refusal> {
        let duration_s = cx.monitor.envelope.duration_s(insert, &route.from);
        let open_s = cx.ledger.open_duration_s();
        let most_s = cx.monitor.limits().inserts_duration_max_s;
        if open_s + duration_s > most_s && is_on(Check::InsertsDuration) {
            return Err(Figure::InsertsDuration.over(open_s + duration_s, most_s));
        }
        let own_s = cx.ledger.open_duration_of_s(plugin);
        let own_max_s = cx.plugins.limits(plugin).inserts_duration_max_s;
        if let Some(most_s) = own_max_s.filter(|most_s| own_s + duration_s > *most_s) {
            return Err(Figure::OwnInsertsDuration.over(own_s + duration_s, most_s));
        }
        Ok(duration_s)
    }

    fn judge_insert(&self, cx: &Context, insert: &Insert, route: &Route) -> Result<f64, Refusal> {
        let Some(navigation) = cx.vehicle.navigation.fresh(cx.now) else {
            return Err(Reason::NavigationIsStale.into());
        };
        if !is_on(Check::InsertFence) {
            return Ok(f64::MAX);
        }
        if insert.interrupt && is_on(Check::InsertWayOn) {
            cx.outlook()
                .judge_ways_back(cx.monitor.envelope.duration_s(insert, &route.from))?;
        }
        cx.monitor.envelope.judge_insert(
            insert,
            navigation.depth,
            cx.vehicle.navigation.bottom_lock(cx.now),
            route,
            cx.outlook().clocks(),
        )
    }

    /// The request's command was sent.
    pub(crate) fn sent(&self, cx: &mut Context, request: u64, dispatch: &Dispatch, insert: Insert, admitted: Admitted) {
        let Some(identifier) = dispatch.identifier() else {
            return;
        };
        cx.identifiers.sent(identifier, insert.surfaces());
        if !insert.surfaces()
            && let Some(plugin) = cx.ledger.get(request).and_then(|entry| entry.owner.plugin())
        {
            cx.plugins.count_insert(plugin);
        }
        cx.reserve();
        if let Some(entry) = cx.ledger.get_mut(request) {
            entry.identifier = Some(identifier);
            entry.insert = Some(insert);
            entry.duration_s = admitted.duration_s;
            entry.schedule = admitted.schedule;
            entry.sent_at = cx.now;
        }
    }

    /// Checks the cancel of a plugin's insert and returns what to send.
    pub(crate) fn check_cancel(
        &self,
        cx: &mut Context,
        plugin: PluginId,
        request: u64,
        tag: u64,
    ) -> Result<Dispatch, Refusal> {
        let insert = self.may_cancel(cx, plugin, tag)?;
        let Some(identifier) = cx.ledger.get(insert).and_then(|entry| entry.identifier) else {
            return Err(Uncontrolled::NotSent.into());
        };
        let purpose = Purpose::Cancel {
            cancel: Some(request),
            insert,
        };
        let created = cx.stamper.stamp(cx.now, "RCN");
        let message = ToVehicle::CancelBehavior(CancelBehavior { created, identifier });
        Ok(Dispatch::new("RCN", message, purpose).naming(identifier))
    }

    fn may_cancel(&self, cx: &Context, plugin: PluginId, tag: u64) -> Result<u64, Refusal> {
        let Some(insert) = cx.outlook().open_insert(plugin, tag) else {
            return Err(Reason::TagUnknown.into());
        };
        if cx
            .ledger
            .get(insert)
            .is_some_and(|entry| entry.state == RequestState::Started)
        {
            return Err(Reason::TagBegun.into());
        }
        if cx.ledger.is_gps_hit(Some(insert)) {
            return Err(Reason::TagIsGpsHit.into());
        }
        // Without this insert, the vehicle goes from what comes before it to what comes after it.
        cx.outlook().judge_cancel(&cx.outlook().chain(), insert)?;
        Ok(insert)
    }

    /// The vehicle's answer to an insert.
    pub(crate) fn answered(&mut self, cx: &mut Context, request: u64, answer: Answer<'_>) {
        match answer {
            Answer::Pending => cx.transition(request, RequestState::Pending),
            Answer::Done => {
                cx.transition(request, RequestState::Accepted);
                if cx.ledger.is_recalled(request) {
                    // The vehicle may have refused its cancel because it had not decided on it.
                    self.recall(cx, request);
                }
            }
            Answer::Refused(text) => cx.transition(request, RequestState::Failed(Failure::Vehicle(text.to_owned()))),
            Answer::Missing => self.unanswered(cx, request),
        }
    }

    /// The vehicle has accepted an insert after it had refused it. The plugin takes it for refused, so it counts as one
    /// that the vehicle may fly, and the runtime cancels it, unless it is a GPS hit.
    pub(crate) fn accepted_after_refusal(&mut self, cx: &mut Context, request: u64) {
        let Some(entry) = cx.ledger.doubt_refused(cx.now, request) else {
            return;
        };
        let surfaces = entry.insert.is_some_and(|insert| insert.surfaces());
        let identifier = entry.identifier.filter(|_| !surfaces);
        cx.note_of_vehicle(Note::Text {
            text: format!("the vehicle has accepted insert {request} after it had refused it"),
        });
        if let Some(identifier) = identifier {
            self.recall_as(cx, request, identifier);
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
                self.ask_whether_gone(cx, insert);
                if let Some(cancel) = cancel {
                    cx.transition(cancel, RequestState::TimedOut);
                }
            }
            Answer::Done => {
                if let Some(identifier) = cx.ledger.identifier_of(insert) {
                    cx.vehicle.plan.ended(identifier);
                }
                cx.transition(insert, RequestState::Cancelled);
                cx.ledger.settle_doubt(insert);
                if let Some(cancel) = cancel {
                    cx.transition(cancel, RequestState::Accepted);
                    cx.transition(cancel, RequestState::Ended(EndCause::Done.into()));
                }
            }
            Answer::Refused(text) => {
                // The insert has begun, or does not wait.
                if let Some(entry) = cx.ledger.get_mut(insert) {
                    entry.may_be_gone = entry.may_be_gone.max(Some(cx.now));
                }
                self.ask_whether_gone(cx, insert);
                if let Some(cancel) = cancel {
                    cx.transition(cancel, RequestState::Failed(Failure::Vehicle(text.to_owned())));
                }
            }
        }
    }

    /// A cancel was not answered, or refused: only the plan can show whether the vehicle still has the insert.
    fn ask_whether_gone(&self, cx: &mut Context, insert: u64) {
        let waits = |entry: &Entry| entry.is_open_insert() && entry.state != RequestState::Started;
        if cx.ledger.get(insert).is_some_and(waits) || cx.ledger.is_doubtful(insert) {
            cx.timers.set_unless_set(Timer::Plan, cx.now + ASKED_AGAIN);
        }
    }

    /// The vehicle flies another dive. What waited in the dive before may be gone; the plan of this one will show it.
    pub(crate) fn another_dive(&mut self, cx: &mut Context) {
        let mut accepted = Vec::new();
        for (request, entry) in cx.ledger.iter_mut().filter(|(_, entry)| entry.is_open_insert()) {
            entry.may_be_gone = entry.may_be_gone.max(Some(cx.now));
            if entry.state == RequestState::Accepted {
                accepted.push(request);
            }
        }
        for request in accepted {
            cx.transition(request, RequestState::Unknown);
        }
    }

    /// The vehicle did not answer an insert. It counts as one that the vehicle may fly, and the runtime cancels it,
    /// unless it is a GPS hit.
    fn unanswered(&mut self, cx: &mut Context, request: u64) {
        if !cx.ledger.is_gps_hit(Some(request)) {
            self.recall(cx, request);
        }
        cx.transition(request, RequestState::TimedOut);
    }

    /// The plan is complete: it has the inserts that are in doubt, or it has not.
    pub(crate) fn resolve_by_plan(&mut self, cx: &mut Context) {
        let open: Vec<(u64, BehaviorId, Timestamp)> = cx
            .ledger
            .iter()
            .filter(|(_, entry)| entry.state == RequestState::Unknown)
            .filter_map(|(request, entry)| Some((request, entry.identifier?, entry.sent_at + SETTLED_WITHIN)))
            .collect();
        let asked_at = cx.vehicle.plan.asked_at();
        if let Some(by) = cx.ledger.cancels_decided_by().filter(|by| asked_at < *by) {
            // The vehicle may not have decided on a cancel yet.
            cx.timers.set_unless_set(Timer::Plan, by.max(cx.now + ASKED_AGAIN));
        }
        for (request, identifier, decided_at) in open {
            if cx.vehicle.plan.has(identifier) {
                cx.transition(request, RequestState::Accepted);
            } else if asked_at < decided_at {
                // The vehicle may not have decided on it when it was asked for the plan.
                cx.timers.set(Timer::Plan, decided_at.max(cx.now));
            } else if cx.vehicle.courses.flies_plan() && !cx.ledger.is_gps_hit(Some(request)) {
                cx.transition(request, RequestState::Failed(Failure::NotInPlan));
            } else {
                // It may be flown. And BFPLN has no code for a GPS hit (6.20), so a plan without one proves nothing.
                // The insert stays under the caps.
                cx.transition(request, RequestState::TimedOut);
            }
        }
        let plan = &cx.vehicle.plan;
        cx.ledger.heard_plan(asked_at, |identifier| plan.has(identifier));
        for request in cx.ledger.refused_that(|identifier| plan.has(identifier)) {
            self.accepted_after_refusal(cx, request);
        }
    }

    /// The mission is over, and so is what it held.
    pub(crate) fn mission_over(&mut self, cx: &mut Context) {
        let open: Vec<u64> = cx
            .ledger
            .iter()
            .filter(|(_, entry)| entry.is_open_insert())
            .map(|(request, _)| request)
            .collect();
        for request in open {
            cx.transition(request, RequestState::Ended(EndCause::MissionOver.into()));
        }
        cx.ledger.settle_all_doubt();
    }
}

/// What an insert sends, under this identifier.
fn message_of(cx: &mut Context, identifier: BehaviorId, insert: &Insert) -> (&'static str, ToVehicle) {
    let interrupt = if insert.interrupt {
        Interrupt::InterruptCurrent
    } else {
        Interrupt::AfterCurrent
    };
    let (message, letters) = match insert.path {
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
            (message, "RTK")
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
                    // A vehicle that takes this field for the interrupt code reads the same code as the next field has.
                    None => CircleEntry::Angle(0.0),
                },
                interrupt,
            });
            (message, "RTC")
        }
        InsertPath::Surface { at } => {
            let created = cx.stamper.stamp(cx.now, "RGP");
            let message = ToVehicle::GpsHit(GpsHit {
                created,
                identifier,
                position: at,
                // Vehicles ignore both today and use their default (7.7). An empty field means the default in every
                // reading. To a vehicle that heeds them one day, a zero would mean no time and no fix.
                surface_within_s: None,
                hits: None,
                mode: SurfaceMode::StraightLine,
            });
            (message, "RGP")
        }
    };
    (letters, message)
}

fn figures(flight: Flight) -> (f64, VerticalMode, f64) {
    let (vertical_m, mode) = match flight.vertical {
        Vertical::Depth(depth) => (depth.as_m(), VerticalMode::Depth),
        Vertical::Altitude(altitude) => (altitude.as_m(), VerticalMode::Altitude),
    };
    (vertical_m, mode, flight.speed.as_mps())
}
