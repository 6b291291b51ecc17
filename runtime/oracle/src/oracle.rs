mod ours;
mod reports;
mod requests;
mod sight;
mod vehicle;

use std::time::Duration;

use crate::moment::Moment;

use crate::area::Area;
use crate::clock::Clock;
use crate::conduct::{Conduct, Context};
use crate::consequence::Consequence;
use crate::control::{Change, Control};
use crate::delivery::Delivery;
use crate::dive::Dive;
use crate::due::Due;
use crate::error::OracleError;
use crate::flaws::Flaws;
use crate::heartbeat::Heartbeat;
use crate::inserts::Inserts;
use crate::integrity::Integrity;
use crate::lease::Lease;
use crate::limits::{Activity, Limits, Truth, seconds};
use crate::lines::{Lines, Piece};
use crate::navigation::{Jump, Navigation, Told};
use crate::operator::Operator;
use crate::pause::Pause;
use crate::plan::Plan;
use crate::process::Process;
use crate::rule::Rule;
use crate::services::{Acoustic, Quota, Shutdown, Silence, Trigger};
use crate::stamps::Stamps;
use crate::station::Station;
use crate::statistics::Statistics;
use crate::violation::{Findings, Violation};
use crate::wire::sentences;

/// A write later than this after the last moment at which the vehicle's sentence can have arrived is not a race any
/// more.
const RACE: Duration = Duration::from_millis(50);
/// How long a modify may stay unanswered, plus the time in which the lease must then end, plus some time for a busy
/// vehicle.
const ANSWER_MAX: Duration = Duration::from_millis(1500);
/// How long navigation must be steady after a jump before anything steers, less the possible difference of two clocks.
const STEADY: Duration = Duration::from_millis(9700);
/// Navigation that is no older than this says where the vehicle is.
const RECENT: Duration = Duration::from_millis(500);
/// How soon a lease must end after control is lost.
const END_WITHIN: Duration = Duration::from_millis(100);

/// The judge of one run. Its inputs come in the order of their times, which are nanoseconds since the start of the run.
#[derive(Clone, Debug)]
pub struct Oracle {
    limits: Limits,
    link_delay: Duration,
    runtime_late: Duration,
    navigation_age_max: Duration,
    area: Area,
    from_vehicle: Lines,
    to_vehicle: Lines,
    arriving: Lines,
    control: Control,
    control_held: Duration,
    navigation: Navigation,
    integrity: Integrity,
    clock: Clock,
    flaws: Flaws,
    pause: Pause,
    lease: Lease,
    station: Station,
    delivery: Delivery,
    consequence: Consequence,
    /// When we last told the vehicle where it is (SPI 8.8, 8.9).
    frame_moved: Option<Moment>,
    inserts: Inserts,
    /// The insert that the vehicle truly flies.
    flown: Option<u32>,
    process: Process,
    operator: Operator,
    stamps: Stamps,
    plan: Plan,
    /// The vehicle has reported some part of its plan to this process.
    plan_heard: bool,
    /// The vehicle has reported the begin of a behavior on this connection, or a gap in the record may hide such a
    /// report.
    begin_heard: bool,
    trigger: Trigger,
    acoustic: Acoustic,
    silence: Silence,
    heartbeat: Heartbeat,
    dive: Dive,
    quota: Quota,
    shutdown: Shutdown,
    conduct: Conduct,
    findings: Findings,
    counts: Statistics,
    now: Moment,
    /// There was a gap in the record since the link last went up or down.
    blind: bool,
}

impl Oracle {
    /// Makes a judge with a fence and limits.
    ///
    /// The fence is a GeoJSON feature collection (RFC 7946) of polygons with the properties `name`, `kind` (`keep-in`
    /// or `keep-out`), `margin_m`, `depth_min_m`, `depth_max_m` and `altitude_min_m`. Edges are straight in longitude
    /// and latitude. A keep-out zone without depths holds at all depths.
    ///
    /// # Errors
    /// [`OracleError`] names the feature or the limit, and what was expected of it.
    pub fn new(fence_geojson: &str, limits: Limits) -> Result<Self, OracleError> {
        limits.check()?;
        Ok(Self {
            link_delay: limits.link_delay(),
            runtime_late: limits.runtime_late(),
            navigation_age_max: seconds(limits.navigation_age_max_s),
            area: Area::read(fence_geojson)?,
            from_vehicle: Lines::default(),
            to_vehicle: Lines::default(),
            arriving: Lines::default(),
            control: Control::new(limits.control.clone()),
            control_held: Duration::ZERO,
            navigation: Navigation::default(),
            integrity: Integrity::new(&limits),
            clock: Clock::default(),
            flaws: Flaws::default(),
            pause: Pause::default(),
            lease: Lease::default(),
            station: Station::default(),
            delivery: Delivery::default(),
            consequence: Consequence::default(),
            frame_moved: None,
            inserts: Inserts::default(),
            flown: None,
            process: Process::default(),
            operator: Operator::default(),
            stamps: Stamps::default(),
            plan: Plan::default(),
            plan_heard: false,
            begin_heard: false,
            trigger: Trigger::default(),
            acoustic: Acoustic::default(),
            silence: Silence::default(),
            heartbeat: Heartbeat::new(&limits),
            dive: Dive::default(),
            quota: Quota::default(),
            shutdown: Shutdown::default(),
            conduct: Conduct::default(),
            findings: Findings::default(),
            counts: Statistics::default(),
            now: Moment::ZERO,
            blind: false,
            limits,
        })
    }

    /// The link came up with a new connection, or went down. At the start of a run it is down.
    pub fn link(&mut self, at_ns: u64, up: bool) {
        let at = Moment::from_nanos(at_ns);
        self.pass_time(at);
        self.lease.cut(at);
        self.station.cut(at);
        self.inserts.cut(self.limits.truth_told);
        self.heartbeat.cut();
        self.blind = false;
        self.begin_heard = false;
        self.process.link_changed();
        self.operator.cut();
        self.trigger.cut();
        self.acoustic.cut();
        self.shutdown.cut(at);
        self.from_vehicle.clear();
        self.to_vehicle.clear();
        self.arriving.clear();
        self.navigation.cut();
        self.integrity.cut();
        // The runtime may not have read what was on its way.
        if self.flaws.unread_from(at - self.sure()) {
            // The runtime may still use the clock from before, and then notices nothing when the clock is set back to
            // it.
            self.clock.forget();
        }
        // The old connection is over in both cases, even if its end was not reported.
        let change = self.control.link(at, false);
        self.control_changed(at, change);
        if up {
            self.counts.connections += 1;
            let change = self.control.link(at, true);
            self.control_changed(at, change);
        }
    }

    /// A fault of the simulation stops, kills or hangs the runtime while the link stays up. The runtime cannot end its
    /// lease any more, so the vehicle's own clock must end it (requirement 007). The runtime hears nothing until it
    /// continues.
    pub fn runtime_stopped(&mut self, at_ns: u64) {
        let at = Moment::from_nanos(at_ns);
        self.pass_time(at);
        self.process.stopped(at, self.lease.is_alive());
        self.lease.cut(at);
        self.station.pause(at);
        self.operator.cut();
        self.trigger.cut();
        self.shutdown.stopped(at);
    }

    /// The runtime continues after it was stopped, and hears now what the vehicle sent meanwhile. If a run does not
    /// call this, the runtime's next write counts as the moment at which it continued.
    pub fn runtime_continued(&mut self, at_ns: u64) {
        let at = Moment::from_nanos(at_ns);
        self.pass_time(at);
        self.goes_on(at);
    }

    /// A new process of the runtime begins. Of what was said before, it knows only the identifiers that were used and
    /// the operator's hold.
    pub fn runtime_started(&mut self, at_ns: u64) {
        let at = Moment::from_nanos(at_ns);
        self.pass_time(at);
        self.process.begins(at);
        self.inserts.new_process();
        self.navigation.clear();
        self.integrity.cut();
        self.clock.forget();
        self.flaws.clear();
        self.pause.clear();
        self.plan_heard = false;
        self.begin_heard = false;
        self.trigger = Trigger::default();
        self.silence = Silence::default();
        self.heartbeat.new_process();
        self.dive = Dive::default();
        self.quota = Quota::default();
        self.shutdown = Shutdown::default();
        self.frame_moved = None;
        // The computer's clock may have been set back, so a new process can repeat times. Acknowledgements of the two
        // processes come on different connections.
        self.stamps = Stamps::default();
    }

    /// The operator begins or releases a hold (requirement 015).
    pub fn operator(&mut self, at_ns: u64, held: bool) {
        let at = Moment::from_nanos(at_ns);
        self.pass_time(at);
        if !held {
            self.operator.releases();
        } else if self
            .operator
            .holds(at, self.control.is_up() && !self.process.is_stopped())
        {
            let due = self.operator_due();
            if let Some(due) = due {
                self.must_end(due);
            }
        }
    }

    /// Bytes of the vehicle, cut anywhere, start on their way to us, after the faults of the link.
    pub fn from_vehicle(&mut self, at_ns: u64, bytes: &[u8]) {
        let at = Moment::from_nanos(at_ns);
        self.pass_time(at);
        self.sees_bytes(at);
        self.counts.bytes_from_vehicle += bytes.len() as u64;
        let mut lines = core::mem::take(&mut self.from_vehicle);
        lines.push(bytes, |piece| match piece {
            Piece::Line(line) => self.vehicle_line(at, line),
            Piece::TooLong => {}
        });
        self.from_vehicle = lines;
    }

    /// Bytes of ours, cut anywhere. The time is that at which we write them.
    pub fn to_vehicle(&mut self, at_ns: u64, bytes: &[u8]) {
        let at = Moment::from_nanos(at_ns);
        self.pass_time(at);
        self.goes_on(at);
        self.sees_bytes(at);
        self.counts.bytes_to_vehicle += bytes.len() as u64;
        let mut lines = core::mem::take(&mut self.to_vehicle);
        lines.push(bytes, |piece| match piece {
            Piece::Line(line) => self.our_line(at, line),
            Piece::TooLong => self
                .findings
                .add(at, Rule::Malformed, || "a line without an end".to_owned()),
        });
        self.to_vehicle = lines;
    }

    /// Bytes of ours arrive at the vehicle, cut anywhere. Once a run calls this, the time after which the vehicle
    /// forgets a request by its own clock counts from the arrival, because faults of the link can hold bytes back;
    /// otherwise it counts from the write.
    pub fn arrived(&mut self, at_ns: u64, bytes: &[u8]) {
        let at = Moment::from_nanos(at_ns);
        self.delivery.tells_arrivals();
        let (delay, delivery, findings) = (self.link_delay, &mut self.delivery, &mut self.findings);
        self.arriving.push(bytes, |piece| {
            if let Piece::Line(line) = piece {
                for (name, created) in sentences(line) {
                    delivery.arrived(at, name, created, delay, findings);
                }
            }
        });
    }

    /// From now on the vehicle's program does not read, although its computer receives what arrives; or it reads again.
    /// Nobody can take back what it has not read yet.
    pub fn deaf(&mut self, at_ns: u64, deaf: bool) {
        self.delivery.deaf(Moment::from_nanos(at_ns), deaf);
    }

    /// Sets how far the vehicle is from its own estimate of its position and depth, metres. No payload can know what
    /// the vehicle's sensors have wrong. Call this before [`Oracle::truth`]; without a call both errors are zero.
    pub fn believed(&mut self, error_m: f64, depth_error_m: f64) {
        self.conduct.believed(error_m, depth_error_m);
    }

    /// The vehicle's true state, ten times a second.
    pub fn truth(&mut self, truth: &Truth) {
        let at = Moment::from_nanos(truth.at_ns);
        self.pass_time(at);
        self.integrity.truth(truth.position);
        self.follow_inserts(at, truth);
        let news = |told: &Told| at.since(told.at) < RECENT;
        let context = Context {
            believed: self.navigation.newest().filter(news).map(|told| told.fix),
            area: &self.area,
            plan: &self.plan,
            tracking_error_m: self.limits.tracking_error_m,
            delivery: &self.delivery,
            link_delay: self.link_delay,
        };
        self.conduct.judge(at, truth, &context, &mut self.findings);
    }

    /// Ends the run and returns all violations in order of time. The list has the first hundred; the number of the
    /// others is in one more entry whose rule is `omitted`.
    #[must_use]
    pub fn finish(mut self, at_ns: u64) -> Vec<Violation> {
        let at = Moment::from_nanos(at_ns);
        self.pass_time(at);
        if self.control.is_up() && self.to_vehicle.is_open() {
            self.findings
                .add(at, Rule::Malformed, || "a sentence without an end".to_owned());
        }
        self.findings.into_violations()
    }

    /// Follows inserts by the truth, which shows the end of an insert even if the link was down when the vehicle sent
    /// BFMBE.
    fn follow_inserts(&mut self, at: Moment, truth: &Truth) {
        let flown = match truth.activity {
            Activity::Insert(identifier) => Some(identifier),
            Activity::Plan => {
                self.inserts.plan_goes_on(at);
                None
            }
            Activity::Suspended | Activity::Other => None,
            // The insert may still be the behavior that is modified.
            Activity::Modified => return,
        };
        if flown == self.flown {
            return;
        }
        if let Some(done) = self.flown {
            self.inserts.ends(done);
        }
        if let Some(identifier) = flown {
            self.inserts.is_flown(at, identifier);
        }
        self.flown = flown;
    }

    /// A runtime that was stopped now reads what the vehicle sent meanwhile.
    fn goes_on(&mut self, at: Moment) {
        if self.process.is_stopped() {
            self.heartbeat.goes_on(at);
            self.integrity.cut();
            self.shutdown.goes_on(at + self.sure());
            self.operator.goes_on(at);
        }
        self.process.goes_on(at);
    }

    /// Judges the effects of silence before anything else is judged.
    fn pass_time(&mut self, at: Moment) {
        self.now = self.now.max(at);
        self.station.check(at, &mut self.findings);
        self.trigger.check(at, &mut self.findings);
        if let Some(by) = self.operator.cancels_due(at) {
            self.findings.judge(Rule::HoldCancelMissing);
            if let Some(identifier) = self.inserts.not_taken_back(by) {
                self.findings.add(at, Rule::HoldCancelMissing, || {
                    format!("no BPRCN for insert {identifier}, which waits under the operator's hold")
                });
            }
        }
        if !self.lease.is_alive() {
            return;
        }
        let answer_max = ANSWER_MAX + self.link_delay * 2;
        self.lease.check(at, answer_max, &mut self.findings);
        if self.lease.is_alive() && self.is_stale(at, END_WITHIN) && self.lease.tell_stale() {
            self.findings.add(at, Rule::StaleNavigation, || {
                "the lease continues although navigation is stale".to_owned()
            });
        }
    }

    /// What ends a lease or station keeping at once if it begins now: control that is just being lost, or the
    /// operator's hold.
    fn end_due(&self) -> Option<Due> {
        let lost = self.control.denied_since().map(|since| self.lost_due(since));
        match self.operator_due() {
            Some(held) => Due::first(lost, held),
            None => lost,
        }
    }

    /// When every dynamic request must have ended under the operator's hold.
    fn operator_due(&self) -> Option<Due> {
        let due = self.operator.due(&self.process)?;
        Some(Due {
            by: due.by + self.runtime_late,
            ..due
        })
    }

    /// A lease or station keeping that is alive must end.
    fn must_end(&mut self, due: Due) {
        if self.lease.is_alive() || self.station.is_alive() {
            self.findings.judge(due.rule);
        }
        self.lease.must_end(due);
        self.station.must_end(due);
    }

    /// A lease that is alive must end.
    fn lease_must_end(&mut self, due: Due) {
        if self.lease.is_alive() {
            self.findings.judge(due.rule);
        }
        self.lease.must_end(due);
    }

    /// The last jump of navigation, if navigation has not been steady for long enough since.
    fn unsteady(&self, now: Moment) -> Option<Jump> {
        self.navigation.jump().filter(|jump| jump.steady(now) < STEADY)
    }

    /// The time by which a lease must have ended because of what the vehicle said at a time.
    fn due(&self, said: Moment, rule: Rule, why: &'static str) -> Due {
        Due {
            by: self.process.heard(said) + self.link_delay + END_WITHIN,
            rule,
            why,
        }
    }

    fn jump_due(&self, said: Moment) -> Due {
        let went_back = self.navigation.went_back();
        let stale = went_back.map_or(said, |at| at + self.navigation_age_max);
        self.due(said.max(stale), Rule::JumpIgnored, "navigation jumped")
    }

    fn lost_due(&self, said: Moment) -> Due {
        self.due(said, Rule::EndMissing, "control was lost")
    }

    /// The longest time from the moment when the vehicle's bytes start on their way until the runtime has certainly
    /// heard them.
    fn sure(&self) -> Duration {
        self.link_delay + RACE
    }

    /// Whether the newest solution is older than allowed under any interpretation.
    fn is_stale(&self, now: Moment, tolerance: Duration) -> bool {
        let allowed = self.navigation_age_allowed() + tolerance;
        self.navigation_age(now).is_none_or(|age| age > allowed)
    }

    /// The least age that the newest solution can have; `None` if there was none on this connection. The fixes alone do
    /// not tell it: a vehicle's clock that is set forward while one fix is made, and back before the next, makes all
    /// later fixes look late by that.
    fn navigation_age(&self, now: Moment) -> Option<Duration> {
        let age = self.navigation.age(now)?;
        let newest = self.navigation.newest();
        let measured = newest.and_then(|told| self.clock.age_at_least(now, told.fix.solution));
        Some(measured.map_or(age, |measured| measured.min(age)))
    }

    /// The greatest age of navigation that the runtime may steer by, as the oracle sees it on the link.
    fn navigation_age_allowed(&self) -> Duration {
        self.navigation_age_max + self.link_delay + END_WITHIN
    }

    fn control_held_at(&self, now: Moment) -> Duration {
        self.control_held
            + self
                .control
                .held_since()
                .map_or(Duration::ZERO, |since| now.since(since))
    }

    fn control_changed(&mut self, at: Moment, change: Change) {
        match change {
            Change::None => {}
            Change::Gained => self.counts.control_spans += 1,
            Change::Lost { held } => {
                self.control_held += held;
                if self.control.is_up() {
                    self.conduct.taken();
                    self.must_end(self.lost_due(at));
                }
            }
            Change::Forgotten { held } => self.control_held += held,
        }
    }
}
