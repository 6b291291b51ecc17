//! Days of simulated time.

use std::fmt;
use std::time::{Duration, Instant};

use anyhow::Result;
use backseat_mvc::{ClientId, FaultKind, FaultPlan, Mvc, MvcEventKind, WorldFile};
use backseat_units::Timestamp;
use clap::Args;

use crate::memory::resident_kib;

const DAY: Duration = Duration::from_secs(86_400);
const DAY_MS: u64 = 86_400_000;
/// Memory counts as flat if it grows by less than this from the middle to the end, KiB.
const GROWTH_MAX_KIB: u64 = 4096;

/// The parameters.
#[derive(Clone, Copy, Debug, Args)]
pub struct Year {
    /// Days of simulated time, each a separate mission
    #[arg(long, default_value_t = 365)]
    pub days: u32,
    /// Seed for the worlds and the faults
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Intensity of faults: 0 for none, 1 for one each 15 s
    #[arg(long, default_value_t = 0.02)]
    pub intensity: f64,
}

/// The results.
#[derive(Clone, Debug, Default)]
pub struct YearReport {
    /// Simulated time.
    pub simulated: Duration,
    /// Real time.
    pub real: Duration,
    /// Memory after the first day, in the middle and at the end, KiB.
    pub resident_kib: [u64; 3],
    /// The vehicle's steps, and those with exactly one BFNVG of their millisecond.
    pub steps: u64,
    /// BFNVG with the time of their step.
    pub navigation: u64,
    /// BFNVG with another time.
    pub clock_wrong: u64,
    /// Steps without a BFNVG, although there was no fault and the client was connected.
    pub missing: u64,
    /// Steps without one because of a fault.
    pub excused: u64,
    /// Sentences of all kinds that the client received.
    pub sentences: u64,
    /// Commands that the client sent.
    pub commands: u64,
    /// Lines of the vehicle's log, and how many were lost.
    pub events: u64,
    /// Lines of the log that were lost.
    pub events_lost: u64,
    /// Faults that were injected.
    pub faults_played: u64,
    /// How many times the client had to reconnect.
    pub reconnects: u64,
}

/// Flies the days.
///
/// # Errors
///
/// If a world cannot be created, or the memory cannot be read.
pub fn run(arguments: &Year) -> Result<YearReport> {
    let mut report = YearReport::default();
    let start = Instant::now();
    for day in 0..arguments.days {
        fly(u64::from(day), arguments, &mut report)?;
        let resident = resident_kib("self")?;
        if day == 0 {
            report.resident_kib[0] = resident;
        }
        if day <= arguments.days / 2 {
            report.resident_kib[1] = resident;
        }
        report.resident_kib[2] = resident;
        if day % 30 == 29 {
            eprintln!("day {}: {} KiB", day + 1, resident);
        }
    }
    report.real = start.elapsed();
    Ok(report)
}

/// A day begins at noon, so that each has a midnight.
const START_MS: u64 = DAY_MS / 2;

fn world() -> Result<WorldFile> {
    let mut text = String::from(
        "start = { utc = 2026-06-01T12:00:00Z }\norigin = { latitude_deg = 42.3, longitude_deg = -70.9 }\n\
         current = { speed_mps = [0.0, 0.2], rotation_h = 12.42 }\nspi = { profile = \"field\" }\n\
         mission = { starts_after_s = 1 }\n[seabed]\ndepth_m = [50, 60]\nslope = 0\n",
    );
    // A circle for each hour, which is never completed: an insert interrupts it and the next one follows.
    for _ in 0..30 {
        text.push_str(
            "[[plan]]\nkind = \"trackcircle\"\ncentre = { east_m = 100, north_m = 0 }\nradius_m = 100\norbits = 1000\n\
             depth_m = 10\nspeed_mps = 1.5\ndynamic = true\n",
        );
    }
    Ok(WorldFile::from_toml(&text)?)
}

fn fly(day: u64, arguments: &Year, report: &mut YearReport) -> Result<()> {
    let seed = arguments.seed.wrapping_add(day);
    let mut plan = FaultPlan::draw(seed, DAY, arguments.intensity);
    // This measures the clock; links are tested elsewhere.
    plan.faults
        .retain(|fault| !matches!(fault.kind, FaultKind::ClockStep(_) | FaultKind::Link(_)));
    let windows: Vec<(Timestamp, Timestamp)> = plan
        .faults
        .iter()
        .map(|fault| {
            // The power stays off.
            let off = matches!(fault.kind, FaultKind::Shutdown);
            let until = if off {
                Timestamp::MAX
            } else {
                fault.until() + Duration::from_millis(200)
            };
            (fault.at, until)
        })
        .collect();
    report.faults_played += plan.faults.len() as u64;
    let mut vehicle = Mvc::new(&world()?, seed)?;
    vehicle.set_faults(plan);
    let mut client = Client::connect(&mut vehicle, Timestamp::ZERO, 1);
    let end = Timestamp::ZERO + DAY;
    let (mut out, mut step_ms) = (Vec::with_capacity(4096), 100);
    while let Some(at) = vehicle.poll_timeout().filter(|at| *at <= end) {
        vehicle.handle_timeout(at);
        let is_step = at == Timestamp::ZERO + Duration::from_millis(step_ms);
        let stamp = is_step.then(|| stamp((START_MS + step_ms) % DAY_MS));
        let mut came = 0;
        while vehicle.poll_transmit(&mut out).is_some() {
            for line in out.split(|byte| *byte == b'\n').filter(|line| !line.is_empty()) {
                report.sentences += 1;
                if line.starts_with(b"$BFNVG,") {
                    if stamp.is_some_and(|stamp| line.get(7..17) == Some(stamp.as_slice())) {
                        came += 1;
                    } else {
                        report.clock_wrong += 1;
                    }
                }
            }
        }
        if is_step {
            report.steps += 1;
            report.navigation += came;
            let faulty = || windows.iter().any(|(from, until)| *from <= at && at < *until);
            if came == 0 {
                *(if faulty() {
                    &mut report.excused
                } else {
                    &mut report.missing
                }) += 1;
            } else if came > 1 {
                report.clock_wrong += came - 1;
            }
            if step_ms % 1000 == 0 {
                report.commands += client.ask(&mut vehicle, at, step_ms / 1000);
            }
            step_ms += 100;
        }
        while vehicle.poll_disconnect().is_some() {
            report.reconnects += 1;
            client = Client::connect(&mut vehicle, at, client.id.0 + 1);
            // If it is refused again, the power is off and stays off.
            while vehicle.poll_disconnect().is_some() {}
        }
        while let Some(event) = vehicle.poll_event() {
            report.events += 1;
            if let MvcEventKind::EventsLost(count) = event.kind {
                report.events_lost += count;
            }
        }
    }
    report.simulated += DAY;
    Ok(())
}

/// `hhmmss.sss`, formatted here again, because the run shares no code with what it judges.
fn stamp(ms: u64) -> [u8; 10] {
    let (seconds, millis) = (ms / 1000, ms % 1000);
    let clock = (seconds / 3600) * 10_000 + (seconds / 60 % 60) * 100 + seconds % 60;
    let mut text = *b"000000.000";
    for (at, value) in [(5, clock), (9, millis)] {
        let mut value = value;
        for digit in text.iter_mut().take(at + 1).rev().take_while(|digit| **digit != b'.') {
            *digit = b'0' + (value % 10) as u8;
            value /= 10;
        }
    }
    text
}

struct Client {
    id: ClientId,
    inserts: u32,
}

impl Client {
    fn connect(vehicle: &mut Mvc, at: Timestamp, number: u32) -> Self {
        let id = ClientId(number);
        vehicle.connect(at, id);
        vehicle.receive(at, id, b"$BPLOG,ALL,ON\r\n$BPLOG,ACK,ON\r\n");
        // Identifiers are never used twice in a mission, also after reconnections (SPI 7.5).
        Self {
            id,
            inserts: number * 100_000,
        }
    }

    /// The requests of a payload in this second: modifies, an insert each hour, one that it cancels, the plan.
    fn ask(&mut self, vehicle: &mut Mvc, at: Timestamp, second: u64) -> u64 {
        const LINE: &str = "4218.01,N,07053.95,W,4218.03,N,07053.95,W,0,10,1.5,0";
        let mut sentences: Vec<String> = Vec::new();
        match second % 60 {
            10..20 => sentences.push("$BPRMB,120000.000,20,10,0,1.5,1,0".to_owned()),
            20 => sentences.push("$BPEMB,120000.000".to_owned()),
            30 => {
                self.inserts += 1;
                sentences.push(format!("$BPRTK,120000.000,{},{LINE},0", self.inserts));
            }
            35 => sentences.push(format!("$BPRCN,120000.000,{}", self.inserts)),
            40 => sentences.push("$BPSTS,120000.000,1,all well".to_owned()),
            _ => {}
        }
        if second % 300 == 250 {
            sentences.push("$BPRMP,120000.000".to_owned());
        }
        if second % 3600 == 3000 {
            self.inserts += 1;
            sentences.push(format!("$BPRTK,120000.000,{},{LINE},4", self.inserts));
        }
        for sentence in &sentences {
            vehicle.receive(at, self.id, format!("{sentence}\r\n").as_bytes());
        }
        sentences.len() as u64
    }
}

impl YearReport {
    /// Everything that is not as required.
    #[must_use]
    pub fn faults(&self) -> Vec<String> {
        let mut faults = Vec::new();
        let [_, middle, end] = self.resident_kib;
        if end > middle + GROWTH_MAX_KIB {
            faults.push(format!("memory grew from {middle} to {end} KiB in the second half"));
        }
        for (count, what) in [
            (self.clock_wrong, "BFNVG differ from their step's time"),
            (self.missing, "steps without a fault have no BFNVG"),
            (self.events_lost, "lines of the vehicle's log are lost"),
        ] {
            if count > 0 {
                faults.push(format!("{count} {what}"));
            }
        }
        let steps = self.simulated.as_millis() as u64 / 100;
        if self.steps != steps || self.navigation + self.excused + self.missing != steps {
            faults.push(format!("{} steps of {steps}, {} BFNVG", self.steps, self.navigation));
        }
        faults
    }
}

impl fmt::Display for YearReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let days = self.simulated.as_secs_f64() / DAY.as_secs_f64();
        let real = self.real.as_secs_f64();
        writeln!(
            f,
            "{days:.1} days in {real:.1} s: {:.0} x real time",
            self.simulated.as_secs_f64() / real
        )?;
        let [start, middle, end] = self.resident_kib;
        writeln!(
            f,
            "memory: {start} KiB after a day, {middle} KiB in the middle, {end} KiB at the end"
        )?;
        writeln!(
            f,
            "{} steps: {} BFNVG at their millisecond, {} at another, {} missing, {} kept back by faults",
            self.steps, self.navigation, self.clock_wrong, self.missing, self.excused
        )?;
        write!(
            f,
            "{} sentences, {} commands, {} events ({} lost), {} faults, {} reconnects",
            self.sentences, self.commands, self.events, self.events_lost, self.faults_played, self.reconnects
        )
    }
}
