mod requests;
mod wire;

use std::time::Duration;

use backseat_spi::{AckStatus, ChecksumState, FromVehicle, Sentence};
use backseat_units::Timestamp;
use memchr::memrchr;

use self::wire::{created_time, our_message, solution_time};
use crate::area::Area;
use crate::conduct::{Conduct, Context};
use crate::control::{Change, Control};
use crate::error::OracleError;
use crate::inserts::Inserts;
use crate::lease::Lease;
use crate::limits::{Activity, Limits, Truth, seconds};
use crate::lines::{Lines, Piece};
use crate::navigation::Navigation;
use crate::plan::Plan;
use crate::rule::Rule;
use crate::stamps::Stamps;
use crate::statistics::Statistics;
use crate::violation::{Findings, Violation};

/// How long after the last moment at which the vehicle's words could arrive a write is no race any more.
const RACE: Duration = Duration::from_millis(50);
/// How soon a lease ends after control is lost.
const END_WITHIN: Duration = Duration::from_millis(100);

/// The judge of one run. Its inputs come in the order of their times.
#[derive(Clone, Debug)]
pub struct Oracle {
    limits: Limits,
    link_delay: Duration,
    navigation_age_max: Duration,
    area: Area,
    from_vehicle: Lines,
    to_vehicle: Lines,
    control: Control,
    control_held: Duration,
    navigation: Navigation,
    lease: Lease,
    inserts: Inserts,
    /// The insert that the vehicle truly flies.
    flown: Option<u32>,
    stamps: Stamps,
    plan: Plan,
    conduct: Conduct,
    findings: Findings,
    counts: Statistics,
    now: Timestamp,
}

impl Oracle {
    /// A judge by a fence and limits.
    ///
    /// The fence is a GeoJSON feature collection (RFC 7946) of polygons with the properties `name`, `kind` (`inclusion`
    /// or `exclusion`), `margin_m`, `depth_min_m`, `depth_max_m` and `altitude_min_m`. Edges are straight in longitude
    /// and latitude. An exclusion without depths holds at all of them.
    ///
    /// # Errors
    /// [`OracleError`] names the feature, or the limit, and what was expected of it.
    pub fn new(fence_geojson: &str, limits: Limits) -> Result<Self, OracleError> {
        limits.check()?;
        Ok(Self {
            link_delay: limits.link_delay(),
            navigation_age_max: seconds(limits.navigation_age_max_s),
            area: Area::read(fence_geojson)?,
            from_vehicle: Lines::default(),
            to_vehicle: Lines::default(),
            control: Control::new(limits.control.clone()),
            control_held: Duration::ZERO,
            navigation: Navigation::default(),
            lease: Lease::default(),
            inserts: Inserts::default(),
            flown: None,
            stamps: Stamps::default(),
            plan: Plan::default(),
            conduct: Conduct::default(),
            findings: Findings::default(),
            counts: Statistics::default(),
            now: Timestamp::ZERO,
            limits,
        })
    }

    /// The link came up, as a new connection, or went down. It is down at first.
    pub fn link(&mut self, at: Timestamp, up: bool) {
        self.pass_time(at);
        self.lease.cut(at);
        self.inserts.cut();
        self.from_vehicle.clear();
        self.to_vehicle.clear();
        self.navigation.clear();
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
    /// any more, and the vehicle's clock alone must do so (requirement 007).
    pub fn runtime_stopped(&mut self, at: Timestamp) {
        self.pass_time(at);
        self.lease.cut(at);
    }

    /// A write of the vehicle, at its sender, in any split.
    pub fn from_vehicle(&mut self, at: Timestamp, bytes: &[u8]) {
        self.pass_time(at);
        self.counts.bytes_from_vehicle += bytes.len() as u64;
        let mut lines = core::mem::take(&mut self.from_vehicle);
        lines.push(bytes, |piece| match piece {
            Piece::Line(line) => self.vehicle_line(at, line),
            Piece::TooLong => {}
        });
        self.from_vehicle = lines;
    }

    /// A write of ours, at its sender.
    pub fn to_vehicle(&mut self, at: Timestamp, bytes: &[u8]) {
        self.pass_time(at);
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

    /// The vehicle's truth, ten times a second.
    pub fn truth(&mut self, truth: &Truth) {
        self.pass_time(truth.at);
        self.follow_inserts(truth);
        let context = Context {
            area: &self.area,
            plan: &self.plan,
            tracking_error_m: self.limits.tracking_error_m,
            link_delay: self.link_delay,
            last_modify: self.lease.last_modify(),
        };
        self.conduct.judge(truth, &context, &mut self.findings);
    }

    /// The run is over: everything that was found, in the order of time. The first hundred are listed, the rest are a
    /// number in one more entry whose rule is `omitted`.
    #[must_use]
    pub fn finish(mut self, at: Timestamp) -> Vec<Violation> {
        self.pass_time(at);
        if self.control.is_up() && self.to_vehicle.is_open() {
            self.findings
                .add(at, Rule::Malformed, || "a sentence without end".to_owned());
        }
        self.findings.into_violations()
    }

    /// How much there was to judge until now; to be asked before [`Oracle::finish`].
    #[must_use]
    pub fn statistics(&self) -> Statistics {
        let [
            inserts_sent,
            inserts_refused,
            inserts_accepted,
            inserts_begun,
            inserts_cancelled,
        ] = self.inserts.counts();
        let (truths, truth_judged, truth_insert_s, truth_modified_s) = self.conduct.counts();
        Statistics {
            control_s: self.control_held_at(self.now).as_secs_f64(),
            leases: self.lease.opened(),
            lease_s: self.lease.alive_s(self.now),
            inserts_sent,
            inserts_refused,
            inserts_accepted,
            inserts_begun,
            inserts_cancelled,
            truths,
            truth_insert_s,
            truth_modified_s,
            truth_judged,
            violations: self.findings.count(),
            ..self.counts.clone()
        }
    }

    /// The end of an insert shows in the truth even where BFMBE met a dead link.
    fn follow_inserts(&mut self, truth: &Truth) {
        let flown = match truth.activity {
            Activity::Insert(identifier) => Some(identifier),
            Activity::Plan | Activity::Other => None,
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
            self.inserts.begins(truth.at, identifier);
        }
        self.flown = flown;
    }

    /// Judges what silence does before anything else is looked at.
    fn pass_time(&mut self, at: Timestamp) {
        self.now = self.now.max(at);
        if !self.lease.is_alive() {
            return;
        }
        self.lease.check(at, &mut self.findings);
        if self.lease.is_alive() && self.is_stale(at, END_WITHIN) && self.lease.tell_stale() {
            self.findings.add(at, Rule::StaleNavigation, || {
                "the lease goes on though navigation is stale".to_owned()
            });
        }
    }

    /// Whether the newest solution is older than allowed on any reading.
    fn is_stale(&self, now: Timestamp, tolerance: Duration) -> bool {
        let allowed = self.navigation_age_max + self.link_delay + END_WITHIN + tolerance;
        self.navigation.age(now).is_none_or(|age| age > allowed)
    }

    fn control_held_at(&self, now: Timestamp) -> Duration {
        self.control_held
            + self
                .control
                .held_since()
                .map_or(Duration::ZERO, |since| now.since(since))
    }

    fn control_changed(&mut self, at: Timestamp, change: Change) {
        match change {
            Change::None => {}
            Change::Gained => self.counts.control_spans += 1,
            Change::Lost { held } => {
                self.control_held += held;
                if self.control.is_up() {
                    self.lease.must_end_by(at + self.link_delay + END_WITHIN);
                }
            }
        }
    }

    /// A line of the vehicle's. Most are navigation, so that their names are looked at before anything is decoded.
    fn vehicle_line(&mut self, at: Timestamp, line: &[u8]) {
        let Some(line) = memrchr(b'$', line).and_then(|start| line.get(start..)) else {
            return;
        };
        match line.get(1..6) {
            Some(b"BFNVG") => {
                if let Some(solution) = solution_time(line)
                    && self.navigation.heard(at, solution)
                {
                    self.counts.navigations += 1;
                }
            }
            Some(b"BFCTL" | b"BFMIS" | b"BFMSC" | b"BFMBS" | b"BFMBE" | b"BFACK" | b"BFPLN") => {
                let sentence = core::str::from_utf8(line)
                    .ok()
                    .and_then(|line| Sentence::parse(line).ok());
                if let Some(sentence) = sentence
                    && sentence.checksum() == ChecksumState::Valid
                    && let Ok(message) = FromVehicle::decode(&sentence)
                {
                    self.vehicle_says(at, &message);
                }
            }
            Some(_) | None => {}
        }
    }

    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "messages that no rule is about, those of later versions included"
    )]
    fn vehicle_says(&mut self, at: Timestamp, message: &FromVehicle) {
        match message {
            FromVehicle::BackseatControl(control) => {
                let change = self.control.backseat_control(at, control.granted);
                self.control_changed(at, change);
            }
            FromVehicle::MissionStatus(status) => {
                let change = self.control.mission_running(at, status.is_running());
                self.control_changed(at, change);
                if !status.is_running() {
                    self.inserts.all_end();
                }
            }
            FromVehicle::MissionCommand(command) => {
                let change = self.control.mission_command(at, command.text.as_str());
                self.control_changed(at, change);
            }
            FromVehicle::BehaviorBegin(begin) => {
                if let Some(identifier) = begin.identifier {
                    self.inserts.begins(at, identifier.get());
                }
            }
            FromVehicle::BehaviorEnd(end) => {
                if let Some(identifier) = end.identifier {
                    self.inserts.ends(identifier.get());
                }
            }
            FromVehicle::PlanElement(element) => {
                let own = element.identifier.is_none();
                self.plan.told(own.then(|| self.area.point(element.position)));
                if let Some(identifier) = element.identifier {
                    self.inserts.planned(identifier.get());
                }
            }
            FromVehicle::Acknowledgement(ack) => {
                let identifier = ack.behavior.map(backseat_spi::BehaviorId::get);
                let created = ack.command_created.truncated_to_millis();
                let taken = match ack.status {
                    AckStatus::Succeeded => true,
                    AckStatus::Invalid | AckStatus::Failed | AckStatus::Other(_) => false,
                    AckStatus::Pending => return,
                };
                match ack.command.as_str() {
                    "RTK" | "RTC" | "RGP" => {
                        self.inserts.answered(identifier, created, taken);
                        if taken {
                            let (open_max, duration_s) =
                                (self.limits.inserts_open_max, self.limits.inserts_duration_max_s);
                            self.inserts.check_open(at, open_max, duration_s, &mut self.findings);
                        }
                    }
                    "RCN" if taken => self.inserts.cancel_done(identifier, created),
                    _ => {}
                }
            }
            _ => {}
        }
    }

    /// A line of ours: it must be a whole sentence as the specification wants it (SPI 4.2), and nothing else.
    fn our_line(&mut self, at: Timestamp, line: &[u8]) {
        self.counts.sentences_to_vehicle += 1;
        let message = match our_message(line) {
            Ok(message) => message,
            Err(fault) => {
                self.findings.add(at, Rule::Malformed, || {
                    let shown: String = String::from_utf8_lossy(line).chars().take(80).collect();
                    format!("{fault}: {}", shown.escape_debug())
                });
                return;
            }
        };
        let Some(name) = line.get(1..6).and_then(|name| <[u8; 5]>::try_from(name).ok()) else {
            return;
        };
        let created = if name == *b"BPLOG" { None } else { created_time(line) };
        if let Some(created) = created
            && self.stamps.repeats(name, created)
        {
            self.findings.add(at, Rule::StampRepeated, || {
                format!("{} has the time {created} twice", String::from_utf8_lossy(&name))
            });
        }
        let denied = self.judge_permission(at, &name);
        self.we_say(at, &message, denied);
    }

    /// Whether control surely is not ours, after telling so where the sentence needs it.
    fn judge_permission(&mut self, at: Timestamp, name: &[u8; 5]) -> bool {
        if !self.limits.operator_commands {
            match name {
                b"BPABT" | b"BPKIL" | b"BPRCA" | b"BPRCB" | b"BPRCE" => {
                    self.findings.add(at, Rule::OperatorOnly, || {
                        format!("{} was sent", String::from_utf8_lossy(name))
                    });
                }
                b"BPNPU" | b"BPRNS" | b"BPRBO" | b"BPSEM" => {
                    self.findings.add(at, Rule::MovesTruth, || {
                        format!("{} was sent", String::from_utf8_lossy(name))
                    });
                }
                _ => {}
            }
        }
        let Some(since) = self.control.denied_since() else {
            return false;
        };
        if since > at - (self.link_delay + RACE) {
            return false;
        }
        let rule = match name {
            b"BPVER" | b"BPLOG" | b"BPSTS" | b"BPMSG" | b"BPRMP" | b"BPRCN" | b"BPABT" | b"BPKIL" | b"BPDVR"
            | b"BPTMR" | b"BPRES" | b"BPSPD" => return true,
            b"BPEMB" if self.lease.is_unended() => return true,
            b"BPEMB" => Rule::EndModifySurplus,
            b"BPRMB" | b"BPRTK" | b"BPRTC" | b"BPRGP" => Rule::NoControl,
            _ => Rule::NotAllowedWithoutControl,
        };
        self.findings.add(at, rule, || {
            format!("{} without control since {since}", String::from_utf8_lossy(name))
        });
        true
    }
}
