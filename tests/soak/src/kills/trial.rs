use std::io::{Read, Write};
use std::net::TcpStream;
use std::thread;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use backseat_suite::{Backseat, Line, Mission, Process, Signal, Vehicle};

use super::plan::{Act, Plan, Subject};
use super::proxy::{Proxy, Way};

/// Programs start slowly where many start at once.
const STARTS_WITHIN: Duration = Duration::from_secs(180);
/// The vehicle's log must show an event within this real time.
const SHOWS_WITHIN: Duration = Duration::from_secs(120);
const LOOK_EVERY: Duration = Duration::from_millis(100);
/// The least number of refreshes before the fault.
const REFRESHES: usize = 3;
/// How long a runtime that can steer again is watched, vehicle's time.
const AGAIN_WITHIN_S: f64 = 30.0;
const FIRST_IDENTIFIER: &str = "100";

/// The result of a trial.
#[derive(Clone, Debug, Default)]
pub(super) struct Record {
    /// The vehicle's log.
    pub(super) lines: Vec<Line>,
    /// The log's text.
    pub(super) text: String,
    /// The time of day by the runtime's clock when it could act again, seconds.
    pub(super) back_utc_s: Option<f64>,
    /// How it ended, if it was told to.
    pub(super) exit: Option<Option<i32>>,
    /// A panic on its standard error, if there is one.
    pub(super) panic: Option<String>,
}

/// The texts that mark in the vehicle's log what was done to the runtime.
pub(super) const FAULT: &str = "trial: now";
pub(super) const BACK: &str = "trial: back";

impl Subject {
    /// The sentence that keeps it active.
    pub(super) const fn refreshes(self) -> &'static [&'static str] {
        match self {
            Self::Modify => &["BPRMB"],
            Self::Station => &["BPSUS", "BPCON", "BPGHP", "BPGBP"],
            Self::Insert => &["BPRTK"],
        }
    }

    /// How long the vehicle keeps it active without this sentence, seconds.
    pub(super) const fn lasts_s(self) -> f64 {
        match self {
            Self::Station => 2.0,
            Self::Modify | Self::Insert => 5.0,
        }
    }

    pub(super) fn is_refresh(self, line: &Line) -> bool {
        self.refreshes().iter().any(|name| line.is_received(name))
    }

    fn mission(self) -> Mission {
        match self {
            Self::Modify => Mission::steady(),
            Self::Station => Mission::hovering(),
            // Lines of some 60 m, one after the other; a new one each second when none is open.
            Self::Insert => Mission::steady()
                .in_legs()
                .edit("mission.toml", "[\"modify\"]", "[\"insert\", \"interrupt\"]")
                .edit(
                    "mission.toml",
                    "fault = \"none\"",
                    "fault = \"cross_fence\"\ntarget_east_m = -520\ntarget_north_m = 0",
                ),
        }
    }
}

/// Flies a trial to its end, and returns what the vehicle has logged.
///
/// # Panics
///
/// If it cannot be flown: a program does not start, or never steers.
pub(super) fn fly(plan: &Plan) -> Record {
    let mut trial = Trial::begin(plan);
    thread::sleep(plan.after);
    let mut record = Record::default();
    match plan.act {
        Act::Kill => trial.runtime.kill(),
        Act::Stop => trial.runtime.signal(Signal::STOP),
        Act::Terminate => {
            trial.runtime.signal(Signal::TERM);
            record.exit = Some(trial.runtime.wait(SHOWS_WITHIN));
        }
        Act::Pause(lasts) => {
            trial.runtime.signal(Signal::STOP);
            trial.mark(FAULT);
            thread::sleep(lasts);
            record.back_utc_s = Some(utc_s());
            trial.mark(BACK);
            trial.runtime.signal(Signal::CONT);
        }
        Act::Close(lasts) => record.back_utc_s = Some(trial.cut(Way::Closed, lasts)),
        Act::Reset(lasts) => record.back_utc_s = Some(trial.cut(Way::Reset, lasts)),
        Act::HalfOpen { lasts, waits } => {
            record.back_utc_s = Some(trial.cut(Way::HalfOpen { waits }, lasts));
        }
    }
    if record.back_utc_s.is_none() {
        trial.mark(FAULT);
    }
    let before = trial.seen(plan.subject);
    let died = matches!(plan.act, Act::Kill | Act::Stop | Act::Terminate);
    match (plan.subject, died) {
        // Until the lease has certainly lapsed.
        (Subject::Modify | Subject::Station, true) => trial.wait_for_clock(plan.subject.lasts_s() + 0.5, |_| false),
        (Subject::Modify | Subject::Station, false) => {
            trial.wait_for_clock(AGAIN_WITHIN_S, |seen| seen > before);
            trial.wait_for_clock(1.0, |_| false);
        }
        (Subject::Insert, _) => {
            if died {
                trial.runtime.kill();
                trial.runtime = trial.run(&[]);
            }
            trial.wait_for_clock(AGAIN_WITHIN_S, |seen| seen > before + 1);
        }
    }
    // Once more, for what the flush of the log may still leave out.
    thread::sleep(Duration::from_millis(300));
    record.text = trial.vehicle.log_text();
    record.lines = trial.vehicle.lines();
    let said = trial.runtime.stderr();
    record.panic = said.lines().find(|line| line.contains("panicked")).map(str::to_owned);
    record
}

struct Trial {
    subject: Subject,
    /// Dropped in this order: first the programs that talk to the vehicle.
    runtime: Process,
    proxy: Option<Proxy>,
    marker: TcpStream,
    vehicle: Vehicle,
    mission: Mission,
}

impl Trial {
    /// Runs until the runtime steers.
    fn begin(plan: &Plan) -> Self {
        let mission = plan.subject.mission();
        let vehicle = Vehicle::start_within(&mission, STARTS_WITHIN);
        let marker = marker(&vehicle.address);
        let proxy = plan
            .act
            .is_cut()
            .then(|| Proxy::start(&vehicle.address).expect("a local port can be listened on"));
        let address = proxy.as_ref().map_or(&vehicle.address, |proxy| &proxy.address);
        let first: &[&str] = match plan.subject {
            Subject::Modify | Subject::Station => &[],
            Subject::Insert => &["--first-identifier", FIRST_IDENTIFIER],
        };
        let runtime = run(&mission, address, first);
        let trial = Self {
            subject: plan.subject,
            runtime,
            proxy,
            marker,
            vehicle,
            mission,
        };
        let wanted = match plan.subject {
            Subject::Modify | Subject::Station => REFRESHES,
            Subject::Insert => 1,
        };
        let start = Instant::now();
        while trial.seen(plan.subject) < wanted {
            assert!(
                start.elapsed() < STARTS_WITHIN,
                "the runtime does not steer: {}\n{}",
                trial.runtime.stderr(),
                trial.vehicle.story()
            );
            thread::sleep(LOOK_EVERY);
        }
        trial
    }

    fn run(&self, flags: &[&str]) -> Process {
        let address = self
            .proxy
            .as_ref()
            .map_or(&self.vehicle.address, |proxy| &proxy.address);
        run(&self.mission, address, flags)
    }

    /// Writes a marker line into the vehicle's log.
    fn mark(&self, text: &str) {
        let line = format!("$BPMSG,000000.000,{text}\n");
        (&self.marker)
            .write_all(line.as_bytes())
            .expect("the vehicle serves us to the end");
    }

    /// The number of refreshes that the vehicle has received.
    fn seen(&self, subject: Subject) -> usize {
        let text = self.vehicle.log_text();
        let of = |name: &&str| text.matches(&format!(" ${name},")).count();
        subject.refreshes().iter().map(of).sum()
    }

    /// The vehicle's time of the newest line in its log.
    fn clock_s(&self) -> f64 {
        let text = self.vehicle.log_text();
        let whole = text.rfind('\n').map_or("", |end| text.get(..end).unwrap_or(""));
        let last = whole.rsplit('\n').next().and_then(|line| line.split(' ').next());
        last.and_then(|at| at.parse().ok()).unwrap_or(0.0)
    }

    /// Waits until the vehicle's clock has advanced by this many seconds, or until there are enough refreshes.
    fn wait_for_clock(&self, seconds: f64, enough: impl Fn(usize) -> bool) {
        let (start, from_s) = (Instant::now(), self.clock_s());
        while self.clock_s() < from_s + seconds && !enough(self.seen(self.subject)) {
            assert!(
                start.elapsed() < SHOWS_WITHIN,
                "the vehicle's clock does not go on\n{}",
                self.vehicle.process.stderr()
            );
            thread::sleep(LOOK_EVERY);
        }
    }

    fn cut(&self, way: Way, lasts: Duration) -> f64 {
        let proxy = self.proxy.as_ref().expect("a trial of the link has its own");
        proxy.set(way);
        self.mark(FAULT);
        thread::sleep(lasts);
        let back_s = utc_s();
        self.mark(BACK);
        proxy.set(Way::Open);
        back_s
    }
}

fn run(mission: &Mission, address: &str, flags: &[&str]) -> Process {
    Backseat::new()
        .args(["run", "--arm", "--connect", address, "--log"])
        .arg(mission.beside("logs"))
        .arg("--state")
        .arg(mission.beside("state"))
        .args(flags.iter().copied())
        .mission(mission)
        .spawn()
}

/// A client that marks the vehicle's log. It receives navigation, so that the log's clock advances without a runtime.
fn marker(address: &str) -> TcpStream {
    let stream = TcpStream::connect(address).expect("the vehicle listens");
    stream.set_nodelay(true).expect("the connection is new");
    let mut reader = stream.try_clone().expect("the connection is new");
    (&stream).write_all(b"$BPLOG,NVG,ON\n").expect("the connection is new");
    thread::spawn(move || {
        let mut buffer = [0; 4096];
        while reader.read(&mut buffer).is_ok_and(|read| read > 0) {}
    });
    stream
}

/// The time of day by the machine's clock, which is also the runtime's, seconds.
fn utc_s() -> f64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    since.as_secs_f64() % 86_400.0
}
