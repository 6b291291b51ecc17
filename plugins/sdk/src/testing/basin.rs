use std::collections::VecDeque;
use std::time::Duration;

use backseat_units::math::{sin_cos, wrap_180, wrap_360};
use backseat_units::{EastNorth, LocalFrame, Position};

use super::{Fault, Harness};
use crate::{EndKind, Ended, Event, Navigation, Outcome, Plugin, Refusal, Request, Rule, State, Trackcircle, Vertical};

/// The most inserts that may be open.
const OPEN_MAX: usize = 4;
/// How fast the vehicle changes its depth, metres per second.
const DIVE_MPS: f64 = 0.3;
/// How fast it turns, degrees per second.
const TURN_DPS: f64 = 8.0;

/// What a vehicle in a basin did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Flown {
    /// The vehicle's place at each step.
    pub way: Vec<EastNorth>,
    /// What the plugin asked for, in order; without timers, messages and refused requests.
    pub accepted: Vec<Request>,
    /// The inserts that were flown to their end, in order.
    pub flown: Vec<Request>,
    /// How many requests were refused.
    pub rejected: usize,
    /// The errors of the plugin's steps.
    pub failures: Vec<String>,
}

impl Flown {
    /// How near the vehicle came to a place, metres; infinite if there was no step.
    #[must_use]
    pub fn nearest_m(&self, place: EastNorth) -> f64 {
        let away_m = self.way.iter().map(|at| at.distance_m(place));
        away_m.fold(f64::INFINITY, f64::min)
    }
}

/// A plugin that flies a simple vehicle. Change the fields before [`Basin::fly`].
pub struct Basin<P: Plugin> {
    /// The plugin.
    pub harness: Harness<P>,
    /// Where the vehicle is, in the mission's local frame.
    pub place: EastNorth,
    /// Its depth, metres.
    pub depth_m: f64,
    /// Its heading, degrees.
    pub heading_deg: f64,
    /// Its speed when nothing of the plugin's is flown, metres per second: then it goes straight on.
    pub cruise_mps: f64,
    /// The water depth at a place, metres.
    pub water_depth_m: fn(EastNorth) -> f64,
    /// The fence: requests that lead farther than this from the origin are refused, metres.
    pub fence_m: f64,
    /// What the plugin hears beside outcomes and timers, such as samples of sensors, for the vehicle's place and depth and
    /// the time since the beginning in seconds.
    pub senses: Box<dyn FnMut(EastNorth, f64, f64) -> Vec<Event>>,
    /// What goes wrong.
    pub faults: Vec<Fault>,
    frame: LocalFrame,
    modify: Option<Steering>,
    inserts: VecDeque<Insert>,
    /// What the plugin hears in its next step.
    events: Vec<Event>,
}

struct Steering {
    tag: u64,
    heading_deg: f64,
    vertical: Vertical,
    speed_mps: f64,
    until_s: f64,
}

struct Insert {
    tag: u64,
    request: Request,
    begun: bool,
    /// The points that the vehicle passes, and how many of them it has.
    points: Vec<EastNorth>,
    passed: usize,
    vertical: Vertical,
    speed_mps: f64,
}

impl<P: Plugin> Basin<P> {
    /// Starts a plugin with its configuration as JSON. The vehicle is at the origin of the local frame at 10 m depth over 50
    /// m of water, and goes east at 1.5 m/s; the fence is 2 km away.
    ///
    /// # Errors
    /// The line with which the plugin refuses to start.
    pub fn new(config: &str) -> Result<Self, String> {
        Self::around(Harness::new(config)?)
    }

    /// The same around a plugin that was started already.
    ///
    /// # Errors
    /// One line, if the briefing's origin is no position on the earth.
    pub fn around(mut harness: Harness<P>) -> Result<Self, String> {
        let frame = harness.briefing().frame()?;
        harness.set_fence(move |request| refused(&frame, 2000.0, request));
        Ok(Self {
            harness,
            place: EastNorth::default(),
            depth_m: 10.0,
            heading_deg: 90.0,
            cruise_mps: 1.5,
            water_depth_m: |_| 50.0,
            fence_m: 2000.0,
            senses: Box::new(|_, _, _| Vec::new()),
            faults: Vec::new(),
            frame,
            modify: None,
            inserts: VecDeque::new(),
            events: Vec::new(),
        })
    }

    /// Flies for some time, with a step of the plugin at each of its periods. A later call goes on where this one ends; the times
    /// of faults and senses count from the call.
    pub fn fly(&mut self, lasts: Duration) -> Flown {
        let (frame, fence_m) = (self.frame, self.fence_m);
        self.harness.set_fence(move |request| refused(&frame, fence_m, request));
        let period_s = P::describe().step_period_ns as f64 * 1e-9;
        let steps = (lasts.as_secs_f64() / period_s).ceil() as u64;
        let mut flown = Flown::default();
        let mut events = std::mem::take(&mut self.events);
        let mut snapshots = VecDeque::new();
        let mut faults = self.faults.clone();
        for step in 0..steps {
            let now_s = step as f64 * period_s;
            events.extend(self.wrong(&mut faults, now_s, &snapshots));
            let now_is =
                |from: Duration, lasts: Duration| (from.as_secs_f64()..(from + lasts).as_secs_f64()).contains(&now_s);
            let mut control = true;
            let mut blind = false;
            for fault in &faults {
                if let Fault::NoControl { from, lasts } = fault {
                    control &= !now_is(*from, *lasts);
                }
                if let Fault::NoNavigation { from, lasts } = fault {
                    blind |= now_is(*from, *lasts);
                }
            }
            if control != self.harness.control {
                self.harness.control = control;
                events.push(Event::Control(control));
            }
            if !self.harness.control {
                events.extend(self.end_modify(EndKind::Control, "control was lost"));
            }
            self.harness.navigation = (!blind).then(|| self.navigation());
            events.extend((self.senses)(self.place, self.depth_m, now_s));
            snapshots.push_front(self.harness.snapshot());
            snapshots.truncate(11);
            match self.harness.step(std::mem::take(&mut events)) {
                Ok(requests) => {
                    for request in requests {
                        events.extend(self.take(request, now_s, &mut faults, &mut flown));
                    }
                }
                Err(why) => flown.failures.push(why),
            }
            flown.way.push(self.place);
            // Ten times a step, so that a long period makes no difference.
            for part in 0..10 {
                let now_s = now_s + 0.1 * f64::from(part) * period_s;
                events.extend(self.move_on(now_s, 0.1 * period_s, &mut flown));
            }
        }
        self.events = events;
        flown
    }

    /// Does what goes wrong at this time.
    fn wrong(&mut self, faults: &mut Vec<Fault>, now_s: f64, snapshots: &VecDeque<Vec<u8>>) -> Vec<Event> {
        let mut events = Vec::new();
        let mut later = Vec::new();
        for fault in std::mem::take(faults) {
            match fault {
                Fault::EndsEarly { at } if at.as_secs_f64() <= now_s => {
                    if let Some(insert) = self.inserts.pop_front() {
                        events.push(outcome(insert.tag, ended(EndKind::Behavior, "the vehicle ended it")));
                    }
                    events.extend(self.end_modify(EndKind::Refused, "the vehicle ended it"));
                }
                Fault::Restart { at, lost_steps } if at.as_secs_f64() <= now_s => {
                    let lost = (lost_steps as usize).min(snapshots.len().saturating_sub(1));
                    if let Some(snapshot) = snapshots.get(lost) {
                        let open = self.open_tags();
                        // A plugin that cannot be restored fails in each of its next steps, as in the runtime.
                        if let Err(why) = self.harness.restart_from(snapshot, lost as u64, open) {
                            panic!("the plugin could not be restarted: {why}");
                        }
                    }
                }
                Fault::NoControl { .. }
                | Fault::NoNavigation { .. }
                | Fault::Rejections { .. }
                | Fault::NoAnswers { .. }
                | Fault::EndsEarly { .. }
                | Fault::Restart { .. } => later.push(fault),
            }
        }
        *faults = later;
        events
    }

    fn open_tags(&self) -> Vec<u64> {
        let modify = self.modify.iter().map(|modify| modify.tag);
        self.inserts.iter().map(|insert| insert.tag).chain(modify).collect()
    }

    /// Takes a request, and returns its outcomes.
    fn take(&mut self, request: Request, now_s: f64, faults: &mut [Fault], flown: &mut Flown) -> Vec<Event> {
        if let Request::Cancel(tag) = request {
            return self.cancel(tag);
        }
        if matches!(request, Request::EndModify) {
            return self
                .end_modify(EndKind::Asked, "its plugin ended it")
                .into_iter()
                .collect();
        }
        let Some(tag) = request.tag() else {
            return Vec::new();
        };
        let steers = matches!(
            request,
            Request::Modify(_) | Request::Trackline(_) | Request::Trackcircle(_)
        );
        let refusal = if !self.harness.control {
            Some(Refusal::new(Rule::Control, "no control"))
        } else if steers && used_up(faults, now_s, |fault| matches!(fault, Fault::Rejections { .. })) {
            Some(Refusal::new(Rule::Rate, "too many requests"))
        } else if self.inserts.len() >= OPEN_MAX && !matches!(request, Request::Modify(_)) && steers {
            Some(Refusal::new(Rule::Cap, "too many inserts are open"))
        } else {
            refused(&self.frame, self.fence_m, &request)
        };
        if let Some(refusal) = refusal {
            flown.rejected += 1;
            return vec![outcome(tag, State::Rejected(refusal))];
        }
        if steers && used_up(faults, now_s, |fault| matches!(fault, Fault::NoAnswers { .. })) {
            return vec![outcome(tag, State::Sent), outcome(tag, State::TimedOut)];
        }
        let mut events = Vec::new();
        if let Request::Modify(modify) = &request {
            // A newer modify replaces the one before.
            if self.modify.as_ref().is_some_and(|before| before.tag != tag) {
                events.extend(self.end_modify(EndKind::Replaced, "a newer one replaced it"));
            }
            self.modify = Some(Steering {
                tag,
                heading_deg: modify.heading,
                vertical: modify.vertical,
                speed_mps: modify.speed,
                until_s: now_s + modify.duration_ns as f64 * 1e-9,
            });
        } else if let Request::Trackline(line) = &request {
            let points = [line.start, line.end].map(|at| local(&self.frame, at)).to_vec();
            self.queue(&request, tag, points, (line.vertical, line.speed), line.interrupt);
        } else if let Request::Trackcircle(circle) = &request {
            let points = self.round(circle);
            self.queue(&request, tag, points, (circle.vertical, circle.speed), circle.interrupt);
        } else {
            // The vehicle does everything else at once.
            flown.accepted.push(request);
            let states = [State::Sent, State::Accepted, ended(EndKind::Done, "done")];
            return states.into_iter().map(|state| outcome(tag, state)).collect();
        }
        flown.accepted.push(request);
        events.extend([outcome(tag, State::Sent), outcome(tag, State::Accepted)]);
        events
    }

    fn queue(
        &mut self,
        request: &Request,
        tag: u64,
        points: Vec<EastNorth>,
        (vertical, speed_mps): (Vertical, f64),
        interrupt: bool,
    ) {
        let insert = Insert {
            tag,
            request: request.clone(),
            begun: false,
            points,
            passed: 0,
            vertical,
            speed_mps,
        };
        if interrupt {
            self.inserts.push_front(insert);
        } else {
            self.inserts.push_back(insert);
        }
    }

    fn cancel(&mut self, tag: u64) -> Vec<Event> {
        let Some(index) = self.inserts.iter().position(|insert| insert.tag == tag) else {
            return Vec::new();
        };
        self.inserts.remove(index);
        vec![outcome(tag, State::Cancelled)]
    }

    fn end_modify(&mut self, kind: EndKind, why: &str) -> Option<Event> {
        let modify = self.modify.take()?;
        Some(outcome(modify.tag, ended(kind, why)))
    }

    /// The points of a circle, ten degrees apart.
    fn round(&self, circle: &Trackcircle) -> Vec<EastNorth> {
        let centre = local(&self.frame, circle.centre);
        let first_deg = circle.entry_angle.unwrap_or_else(|| centre.bearing_deg(self.place));
        let count = (36.0 * circle.orbits.abs()).ceil().clamp(1.0, 3600.0) as u32;
        let points = (0..=count).map(|index| {
            let turned_deg = 360.0 * circle.orbits * f64::from(index) / f64::from(count);
            centre.offset(first_deg + turned_deg, circle.radius)
        });
        points.collect()
    }

    fn move_on(&mut self, now_s: f64, lasts_s: f64, flown: &mut Flown) -> Vec<Event> {
        let mut events = Vec::new();
        if self.modify.as_ref().is_some_and(|modify| modify.until_s <= now_s) {
            events.extend(self.end_modify(EndKind::Term, "its time is over"));
        }
        let (heading_deg, vertical, speed_mps) = if let Some(modify) = &self.modify {
            (modify.heading_deg, Some(modify.vertical), modify.speed_mps)
        } else if let Some(insert) = self.inserts.front_mut() {
            if !insert.begun {
                insert.begun = true;
                events.push(outcome(insert.tag, State::Started));
            }
            let reach_m = insert.speed_mps * lasts_s;
            let reached = |next: &EastNorth| self.place.distance_m(*next) <= reach_m;
            while insert.points.get(insert.passed).is_some_and(reached) {
                insert.passed += 1;
            }
            let Some(next) = insert.points.get(insert.passed) else {
                events.push(outcome(insert.tag, ended(EndKind::Done, "flown")));
                flown.flown.push(insert.request.clone());
                self.inserts.pop_front();
                return events;
            };
            // It turns to the point at once.
            self.heading_deg = self.place.bearing_deg(*next);
            (self.heading_deg, Some(insert.vertical), insert.speed_mps)
        } else {
            (self.heading_deg, None, self.cruise_mps)
        };
        let turn_deg = wrap_180(heading_deg - self.heading_deg).clamp(-TURN_DPS * lasts_s, TURN_DPS * lasts_s);
        self.heading_deg = wrap_360(self.heading_deg + turn_deg);
        self.place = self.place.offset(self.heading_deg, speed_mps * lasts_s);
        let aim_m = match vertical {
            Some(Vertical::Depth(depth_m)) => depth_m,
            Some(Vertical::Altitude(altitude_m)) => (self.water_depth_m)(self.place) - altitude_m,
            None => self.depth_m,
        };
        self.depth_m += (aim_m - self.depth_m).clamp(-DIVE_MPS * lasts_s, DIVE_MPS * lasts_s);
        events
    }

    fn navigation(&self) -> Navigation {
        let speed_mps = match (&self.modify, self.inserts.front()) {
            (Some(modify), _) => modify.speed_mps,
            (None, Some(insert)) => insert.speed_mps,
            (None, None) => self.cruise_mps,
        };
        let (sin, cos) = sin_cos(self.heading_deg.to_radians());
        Navigation {
            position: self.frame.to_position(self.place).into(),
            east: self.place.east_m,
            north: self.place.north_m,
            depth: self.depth_m,
            altitude: Some((self.water_depth_m)(self.place) - self.depth_m),
            heading: self.heading_deg,
            velocity_east: speed_mps * sin,
            velocity_north: speed_mps * cos,
            ..Navigation::default()
        }
    }
}

fn outcome(tag: u64, state: State) -> Event {
    Event::Outcome(Outcome { tag, state })
}

fn ended(kind: EndKind, text: &str) -> State {
    State::Ended(Ended::new(kind, text))
}

fn local(frame: &LocalFrame, at: crate::Position) -> EastNorth {
    // A position that is none is infinitely far away.
    Position::try_from(at).map_or(EastNorth::new(f64::INFINITY, 0.0), |at| frame.to_local(at))
}

/// Refuses a request that leads farther from the origin than this.
fn refused(frame: &LocalFrame, fence_m: f64, request: &Request) -> Option<Refusal> {
    let away_m = |at: crate::Position| local(frame, at).distance_m(EastNorth::default());
    let farthest_m = if let Request::Trackline(line) = request {
        away_m(line.start).max(away_m(line.end))
    } else if let Request::Trackcircle(circle) = request {
        away_m(circle.centre) + circle.radius
    } else if let Request::GpsHit(hit) = request {
        away_m(hit.position)
    } else {
        return None;
    };
    // NaN is not inside.
    let inside = farthest_m <= fence_m;
    (!inside).then(|| Refusal::new(Rule::KeepIn, "outside of the basin"))
}

/// Uses up one of a fault that counts.
fn used_up(faults: &mut [Fault], now_s: f64, is_it: impl Fn(&Fault) -> bool) -> bool {
    let mut counting = faults.iter_mut().filter(|fault| is_it(fault));
    counting.any(|fault| {
        if let Fault::Rejections { from, count } | Fault::NoAnswers { from, count } = fault
            && from.as_secs_f64() <= now_s
            && *count > 0
        {
            *count -= 1;
            return true;
        }
        false
    })
}
