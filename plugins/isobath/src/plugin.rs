use backseat_sdk::units::math::wrap_180;
use backseat_sdk::{
    Description, Event, Grant, Modify, Navigation, Outcome, Plugin, Request, State as Fate, StepInput, Vertical, fence,
    log, measures,
};
use serde::{Deserialize, Serialize};

use crate::config::Config;
use crate::current::CurrentEstimate;
use crate::guidance::{Aim, Guidance};
use crate::seabed::{Estimate, Seabed};

const SECOND_NS: u64 = 1_000_000_000;
const PERIOD_NS: u64 = SECOND_NS / 2;
/// A heading that differs by less than this is not worth a new request, degrees.
const HEADING_STEP_DEG: f64 = 0.3;
/// The same heading is requested again after this time, well before the request ends.
const RENEW_NS: u64 = 4 * SECOND_NS;
/// The pause after a lease that ended for a reason other than the fence.
const AGAIN_NS: u64 = SECOND_NS;
/// If there is no sample for this long, there is no bottom lock.
const LOCK_NS: u64 = 2 * SECOND_NS;
/// The time that the vehicle needs to reach the requested speed.
const SPEED_SETTLES_NS: u64 = 15 * SECOND_NS;
/// Within the first distance of the contour the vehicle counts as following it. Beyond the second it counts as on its
/// way to it again. Metres.
const FOLLOW_M: f64 = 15.0;
const LOST_M: f64 = 80.0;
/// The time between two lines of progress.
const REPORT_NS: u64 = 60 * SECOND_NS;

/// Follows a depth contour.
#[derive(Debug)]
pub struct Isobath {
    config: Config,
    guidance: Guidance,
    state: State,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Phase {
    /// On the way to the contour.
    Acquire,
    /// On the contour.
    Follow,
}

/// The request that the vehicle may be carrying out.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Asked {
    heading_deg: f64,
    at_ns: u64,
    /// Since when the backseat has had control without a break.
    since_ns: u64,
}

/// The state that a new instance needs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct State {
    seabed: Seabed,
    current: CurrentEstimate,
    phase: Phase,
    /// The tag of the lease: renewals carry the same tag, the next lease the next one.
    tag: u64,
    asked: Option<Asked>,
    /// The last heading from a measured seabed, to keep without bottom lock.
    heading_deg: Option<f64>,
    /// No requests before this time.
    wait_until_ns: u64,
    /// Refusals since a request was last accepted; only the first is logged.
    refusals: u32,
    control: bool,
    /// When the newest navigation was computed.
    solution_ns: Option<u64>,
    sample_ns: Option<u64>,
    lock: bool,
    report_ns: u64,
    shut_down: bool,
}

impl Plugin for Isobath {
    type Config = Config;

    fn describe() -> Description {
        Description {
            name: "isobath".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            step_period_ns: PERIOD_NS,
            topics: vec![],
            grants: vec![Grant::Modify],
        }
    }

    fn new(config: Config) -> Result<Self, String> {
        config.validate().map_err(|error| error.to_string())?;
        let guidance = Guidance {
            contour_m: config.contour_m,
            lookahead_m: config.lookahead_m,
            deep_side: config.deep_side(),
            speed_mps: config.speed_mps,
        };
        let state = State {
            seabed: Seabed::new(config.slope, config.deeper_toward_deg, config.memory_m),
            current: CurrentEstimate::default(),
            phase: Phase::Acquire,
            tag: 1,
            asked: None,
            heading_deg: None,
            wait_until_ns: 0,
            refusals: 0,
            control: false,
            solution_ns: None,
            sample_ns: None,
            lock: false,
            report_ns: 0,
            shut_down: false,
        };
        Ok(Self {
            config,
            guidance,
            state,
        })
    }

    fn step(&mut self, input: &StepInput) -> Result<Vec<Request>, String> {
        let mut requests = Vec::new();
        for event in &input.events {
            self.hear(event, input.now_ns, &mut requests);
        }
        self.note_control(input.control);
        let estimate = input
            .navigation
            .as_ref()
            .and_then(|navigation| self.measure(navigation, input.now_ns));
        self.note_lock(input.now_ns);
        if !input.control || self.state.shut_down {
            return Ok(requests);
        }
        let aim = match estimate {
            Some(estimate) if self.state.lock => {
                let aim = self.guidance.aim(&estimate);
                self.note_progress(&estimate, &aim, input.now_ns);
                Some(aim)
            }
            Some(_) | None => None,
        };
        if input.now_ns < self.state.wait_until_ns {
            return Ok(requests);
        }
        match self.heading(aim, input.now_ns) {
            Some(heading_deg) => self.ask(heading_deg, input.now_ns, &mut requests),
            None => self.let_go("no bottom lock", &mut requests),
        }
        Ok(requests)
    }

    backseat_sdk::keep!(state);
}

impl Isobath {
    /// The vehicle's estimated distance from the contour, metres, positive on its deep side; `None` without an
    /// estimate.
    #[must_use]
    pub fn offset_m(&self) -> Option<f64> {
        Some(self.guidance.aim(&self.state.seabed.estimate()?).offset_m)
    }

    fn hear(&mut self, event: &Event, now_ns: u64, requests: &mut Vec<Request>) {
        match event {
            Event::Outcome(outcome) if outcome.tag == self.state.tag => self.hear_of(outcome, now_ns, requests),
            Event::Restored(restored) => {
                log::warn!("a new instance: {} steps were lost", restored.lost_steps);
                let last = restored.open.iter().fold(self.state.tag, |last, tag| last.max(*tag));
                self.lease_over(last + 1, now_ns);
            }
            Event::Shutdown => {
                log::info!("power goes off soon: making no more requests");
                self.state.shut_down = true;
                self.state.asked = None;
            }
            Event::Outcome(_)
            | Event::Control(_)
            | Event::Ctd(_)
            | Event::MissionCommand(_)
            | Event::BehaviorBegan(_)
            | Event::BehaviorEnded(_)
            | Event::Timer(_)
            | Event::LoggingBegan(_)
            | Event::LoggingEnded(_)
            | Event::TopsideMessage(_)
            | Event::DvlTrigger(_)
            | Event::Window(_)
            | Event::Packet(_)
            | Event::Plan(_)
            | Event::Sample(_)
            | Event::Sidescan(_)
            | Event::SubBottom(_)
            | Event::Sonar(_) => {}
        }
    }

    fn hear_of(&mut self, outcome: &Outcome, now_ns: u64, requests: &mut Vec<Request>) {
        let why = match &outcome.state {
            Fate::Sent | Fate::Pending | Fate::Started => return,
            Fate::Accepted => {
                if self.state.refusals > 0 {
                    log::info!("steering again after {} refusals", self.state.refusals);
                    self.state.refusals = 0;
                }
                return;
            }
            Fate::Rejected(refusal) => return self.rejected(&refusal.text, now_ns, requests),
            state @ (Fate::Failed(_) | Fate::Ended(_)) => state.reason().unwrap_or_default(),
            Fate::TimedOut => "the vehicle did not answer",
            Fate::Unknown => "the link was lost",
            Fate::Cancelled => "cancelled",
        };
        log::info!("lease {} has ended: {why}", outcome.tag);
        self.lease_over(self.state.tag + 1, now_ns + AGAIN_NS);
    }

    /// Near the edge of the fence the plugin tries no other heading and lets the vehicle steer itself.
    fn rejected(&mut self, why: &str, now_ns: u64, requests: &mut Vec<Request>) {
        // Only the newest request was rejected. The vehicle may still carry out an older one, which leads to where this
        // one may not go.
        let asked = self.state.asked;
        let by_fence = asked.is_none_or(|asked| fence::check(&self.modify(asked.heading_deg)).is_err());
        let wait_ns = if by_fence {
            nanoseconds(self.config.retry_s)
        } else {
            2 * SECOND_NS
        };
        if self.state.refusals == 0 {
            log::warn!("heading refused, the vehicle steers itself: {why}");
        }
        if asked.is_some() {
            requests.push(Request::EndModify);
        }
        self.state.refusals = self.state.refusals.saturating_add(1);
        self.lease_over(self.state.tag + 1, now_ns + wait_ns);
    }

    fn lease_over(&mut self, next_tag: u64, wait_until_ns: u64) {
        self.state.asked = None;
        self.state.tag = next_tag;
        self.state.wait_until_ns = wait_until_ns;
    }

    fn note_control(&mut self, control: bool) {
        if control == self.state.control {
            return;
        }
        self.state.control = control;
        if control {
            log::info!("control: steering for the {} m contour", self.config.contour_m);
            self.state.wait_until_ns = 0;
            self.state.refusals = 0;
        } else {
            log::info!("control lost: still measuring, making no requests");
            if self.state.asked.is_some() {
                self.lease_over(self.state.tag + 1, 0);
            }
        }
    }

    /// Takes in the seabed and the current from navigation. Returns the seabed here, if known.
    fn measure(&mut self, navigation: &Navigation, now_ns: u64) -> Option<Estimate> {
        let state = &mut self.state;
        let solution_ns = now_ns.saturating_sub(navigation.age_ns);
        let over_ns = match state.solution_ns {
            // The same solution again is not a new sample.
            Some(before_ns) if solution_ns <= before_ns => return state.seabed.estimate(),
            Some(before_ns) => solution_ns - before_ns,
            None => PERIOD_NS,
        };
        state.solution_ns = Some(solution_ns);
        let at = navigation.local();
        match navigation.altitude {
            Some(altitude_m) if altitude_m > 0.0 => {
                if state.seabed.measure(at, navigation.depth + altitude_m) {
                    state.sample_ns = Some(now_ns);
                }
            }
            Some(_) | None => state.seabed.move_to(at),
        }
        let settled = state
            .asked
            .is_some_and(|asked| now_ns >= asked.since_ns + SPEED_SETTLES_NS);
        if settled {
            state.current.measure(
                navigation.heading,
                self.config.speed_mps,
                (navigation.velocity_east, navigation.velocity_north),
                navigation.yaw_rate,
                over_ns as f64 / SECOND_NS as f64,
            );
        }
        state.seabed.estimate()
    }

    fn note_lock(&mut self, now_ns: u64) {
        let lock = self
            .state
            .sample_ns
            .is_some_and(|sample_ns| now_ns.saturating_sub(sample_ns) < LOCK_NS);
        if lock == self.state.lock {
            return;
        }
        self.state.lock = lock;
        if lock {
            log::debug!("bottom lock");
        } else if self.state.control {
            log::warn!(
                "no bottom lock: holding the heading for at most {} s",
                self.config.hold_s
            );
        } else {
            log::warn!("no bottom lock");
        }
    }

    fn note_progress(&mut self, seabed: &Estimate, aim: &Aim, now_ns: u64) {
        let off_m = aim.offset_m.abs();
        let phase = match self.state.phase {
            Phase::Acquire if off_m < FOLLOW_M => Phase::Follow,
            Phase::Follow if off_m > LOST_M => Phase::Acquire,
            same @ (Phase::Acquire | Phase::Follow) => same,
        };
        measures::publish("contour_offset", aim.offset_m, "m");
        measures::publish("slope", 100.0 * seabed.slope(), "%");
        let verb = match phase {
            Phase::Acquire => "acquiring",
            Phase::Follow => "following",
        };
        if phase == self.state.phase && now_ns < self.state.report_ns {
            return;
        }
        self.state.phase = phase;
        self.state.report_ns = now_ns + REPORT_NS;
        let (east, north) = self.state.current.mps();
        log::info!(
            "{verb} the {} m contour: {:.1} m off, course {:.0}, slope {:.1} %, soundings good to {:.2} m, current {:.2} {:.2} m/s",
            self.config.contour_m,
            aim.offset_m,
            aim.course_deg,
            100.0 * seabed.slope(),
            self.state.seabed.noise_m(),
            east,
            north
        );
    }

    /// The heading to request; `None` if there is nothing left to steer by.
    fn heading(&mut self, aim: Option<Aim>, now_ns: u64) -> Option<f64> {
        if let Some(aim) = aim {
            // North in the local frame is taken as true north: they differ by 0.01 degrees a kilometre from the origin,
            // which the estimate of the current absorbs.
            let heading_deg = self.state.current.heading_deg(aim.course_deg, self.config.speed_mps);
            self.state.heading_deg = Some(heading_deg);
            return Some(heading_deg);
        }
        let without_ns = now_ns.saturating_sub(self.state.sample_ns?);
        if without_ns > nanoseconds(self.config.hold_s) {
            return None;
        }
        self.state.heading_deg
    }

    fn ask(&mut self, heading_deg: f64, now_ns: u64, requests: &mut Vec<Request>) {
        let since_ns = match self.state.asked {
            Some(asked) => {
                let same = wrap_180(heading_deg - asked.heading_deg).abs() <= HEADING_STEP_DEG;
                if same && now_ns < asked.at_ns + RENEW_NS {
                    return;
                }
                asked.since_ns
            }
            None => now_ns,
        };
        self.state.asked = Some(Asked {
            heading_deg,
            at_ns: now_ns,
            since_ns,
        });
        requests.push(self.modify(heading_deg));
    }

    fn let_go(&mut self, why: &str, requests: &mut Vec<Request>) {
        if self.state.asked.is_none() {
            return;
        }
        log::warn!("{why}: the vehicle steers itself");
        requests.push(Request::EndModify);
        self.lease_over(self.state.tag + 1, 0);
    }

    fn modify(&self, heading_deg: f64) -> Request {
        Request::Modify(Modify {
            tag: self.state.tag,
            heading: heading_deg,
            vertical: Vertical::Depth(self.config.depth_m),
            speed: self.config.speed_mps,
            duration_ns: nanoseconds(self.config.duration_s),
        })
    }
}

/// Converts validated seconds to nanoseconds.
fn nanoseconds(seconds: f64) -> u64 {
    (seconds * SECOND_NS as f64) as u64
}
