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

/// How long after the last moment at which the vehicle's words could arrive a write is no race any more.
const RACE: Duration = Duration::from_millis(50);
/// How long a modify may go unanswered, how soon it then ends, and some more for a busy vehicle.
const ANSWER_MAX: Duration = Duration::from_millis(1500);
/// How long navigation is steady after a jump before anything steers by it, less what two clocks may differ by.
const STEADY: Duration = Duration::from_millis(9700);
/// Navigation that was told so recently says where the vehicle is.
const RECENT: Duration = Duration::from_millis(500);
/// How soon a lease ends after control is lost.
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
    /// When we told the vehicle last where it is (SPI 8.8, 8.9).
    frame_moved: Option<Moment>,
    inserts: Inserts,
    /// The insert that the vehicle truly flies.
    flown: Option<u32>,
    process: Process,
    operator: Operator,
    stamps: Stamps,
    plan: Plan,
    /// The vehicle has told this process something of its plan.
    plan_heard: bool,
    /// A behavior was told to begin on this connection, or nobody has written down whether one was.
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
    /// There was a gap since the link last went up or down.
    blind: bool,
}

impl Oracle {
    /// A judge by a fence and limits.
    ///
    /// The fence is a GeoJSON feature collection (RFC 7946) of polygons with the properties `name`, `kind` (`keep-in`
    /// or `keep-out`), `margin_m`, `depth_min_m`, `depth_max_m` and `altitude_min_m`. Edges are straight in longitude
    /// and latitude. A keep-out zone without depths holds at all of them.
    ///
    /// # Errors
    /// [`OracleError`] names the feature, or the limit, and what was expected of it.
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

    /// The link came up, as a new connection, or went down. It is down at first.
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
        // What was on its way may not have been read.
        if self.flaws.unread_from(at - self.sure()) {
            // It may go by the clock from before, and see nothing where that is set back.
            self.clock.forget();
        }
        // The old connection is over either way, even where its end was not told.
        let change = self.control.link(at, false);
        self.control_changed(at, change);
        if up {
            self.counts.connections += 1;
            let change = self.control.link(at, true);
            self.control_changed(at, change);
        }
    }

    /// A fault of the simulation stops, kills or hangs the runtime with the link still up: its lease cannot be ended
    /// any more, and the vehicle's clock alone must do so (requirement 007). Until it goes on it hears nothing.
    pub fn runtime_stopped(&mut self, at_ns: u64) {
        let at = Moment::from_nanos(at_ns);
        self.pass_time(at);
        self.process.stopped(at, self.lease.is_alive());
        self.lease.cut(at);
        self.station.pause(at);
        self.operator.cut();
        self.trigger.cut();
    }

    /// The runtime goes on after it was stopped, and hears now what was said meanwhile. Where this is not told, its
    /// next write tells it.
    pub fn runtime_continued(&mut self, at_ns: u64) {
        let at = Moment::from_nanos(at_ns);
        self.pass_time(at);
        self.goes_on(at);
        self.shutdown.goes_on(at + self.sure());
    }

    /// A new process of the runtime begins: it knows the identifiers that were used and the operator's hold, and nothing
    /// else of what was said before.
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
        // The computer's clock may have been set back, and answers are told apart by connection.
        self.stamps = Stamps::default();
    }

    /// The operator holds the runtime, or releases it (requirement 015).
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

    /// A write of the vehicle, at its sender, in any split.
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

    /// A write of ours, at its sender.
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
                .add(at, Rule::Malformed, || "a line without end".to_owned()),
        });
        self.to_vehicle = lines;
    }

    /// Bytes of ours arrive at the vehicle, in any split. Where a run tells this, what the vehicle forgets by its own
    /// clock counts from here, as it must where faults of the link hold words back; else from the write.
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

    /// The vehicle reads nothing from now on, though its computer takes what arrives, or reads again. What it has not read
    /// nobody can take back.
    pub fn deaf(&mut self, at_ns: u64, deaf: bool) {
        self.delivery.deaf(Moment::from_nanos(at_ns), deaf);
    }

    /// How far the vehicle is, from now on, from where it believes to be, and from the depth that it believes in, metres:
    /// what its sensors have got wrong no payload can know. To be told before [`Oracle::truth`]; nothing where it is not.
    pub fn believed(&mut self, error_m: f64, depth_error_m: f64) {
        self.conduct.believed(error_m, depth_error_m);
    }

    /// The vehicle's truth, ten times a second.
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

    /// The run is over: everything that was found, in the order of time. The first hundred are listed, the rest are a
    /// number in one more entry whose rule is `omitted`.
    #[must_use]
    pub fn finish(mut self, at_ns: u64) -> Vec<Violation> {
        let at = Moment::from_nanos(at_ns);
        self.pass_time(at);
        if self.control.is_up() && self.to_vehicle.is_open() {
            self.findings
                .add(at, Rule::Malformed, || "a sentence without end".to_owned());
        }
        self.findings.into_violations()
    }

    /// The end of an insert shows in the truth even where BFMBE met a dead link.
    fn follow_inserts(&mut self, at: Moment, truth: &Truth) {
        let flown = match truth.activity {
            Activity::Insert(identifier) => Some(identifier),
            Activity::Plan => {
                self.inserts.plan_goes_on(at);
                None
            }
            Activity::Suspended | Activity::Other => None,
            // It may be the insert still.
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

    /// A runtime that was stopped reads now what was said meanwhile.
    fn goes_on(&mut self, at: Moment) {
        if self.process.is_stopped() {
            self.heartbeat.goes_on(at);
            self.integrity.cut();
        }
        self.process.goes_on(at);
    }

    /// Judges what silence does before anything else is looked at.
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
                "the lease goes on though navigation is stale".to_owned()
            });
        }
    }

    /// What ends a lease or station keeping that begins now at once: control that is just being lost, the operator's
    /// hold.
    fn end_due(&self) -> Option<Due> {
        let lost = self.control.denied_since().map(|since| self.lost_due(since));
        match self.operator_due() {
            Some(held) => Due::first(lost, held),
            None => lost,
        }
    }

    /// When everything dynamic must have ended under the operator's hold.
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

    /// The last jump of navigation, where it has not been steady for long enough since.
    fn unsteady(&self, now: Moment) -> Option<Jump> {
        self.navigation.jump().filter(|jump| jump.steady(now) < STEADY)
    }

    /// Until when a lease must have ended for what the vehicle said at a time.
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
        self.due(said, Rule::EndMissing, "control was lost under it")
    }

    /// How long after they were let on their way the vehicle's words have been heard for sure.
    fn sure(&self) -> Duration {
        self.link_delay + RACE
    }

    /// Whether the newest solution is older than allowed on any reading.
    fn is_stale(&self, now: Moment, tolerance: Duration) -> bool {
        let allowed = self.navigation_age_max + self.link_delay + END_WITHIN + tolerance;
        self.navigation.age(now).is_none_or(|age| age > allowed)
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
