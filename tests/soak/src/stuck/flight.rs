use std::time::Duration;

use backseat_suite::{Heard, Process, Scripted, Signal, Stopwatch, settle};

/// Measurements of one flight from the vehicle's log, by its own clock, seconds.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Figures {
    /// The number of BPRMB that it received in the window.
    pub(super) modifies: usize,
    /// The longest time in the window without one.
    pub(super) gap_s: f64,
    /// From SIGUSR1 to BPEMB.
    pub(super) held_s: f64,
    /// From SIGTERM to BPEMB.
    pub(super) ended_s: f64,
    /// From SIGTERM to the end of the process.
    pub(super) gone_s: f64,
    /// The latest wake-up of the loop, if standard error can be read.
    pub(super) slip_s: Option<f64>,
}

impl Figures {
    /// The worse value of each.
    pub(super) fn worst(self, other: Self) -> Self {
        Self {
            modifies: self.modifies.min(other.modifies),
            gap_s: self.gap_s.max(other.gap_s),
            held_s: self.held_s.max(other.held_s),
            ended_s: self.ended_s.max(other.ended_s),
            gone_s: self.gone_s.max(other.gone_s),
            slip_s: self.slip_s.zip(other.slip_s).map(|(one, two)| one.max(two)),
        }
    }
}

/// Waits until the vehicle is steered.
pub(super) fn begin(vehicle: &Scripted) {
    vehicle.hears("BPRMB", 3, super::STARTS_WITHIN);
}

/// Watches the vehicle for this long. Returns the number of modifies and the longest time without one, including the
/// time to the end of the window.
pub(super) fn window(vehicle: &Scripted, seconds: f64) -> (usize, f64) {
    let since_s = vehicle.now_s();
    let before = vehicle.heard("BPRMB").last().map_or(since_s, |heard| heard.at_s);
    settle(Duration::from_secs_f64(seconds));
    let end_s = vehicle.now_s();
    let heard = vehicle.heard_since("BPRMB", since_s);
    let mut times: Vec<f64> = vec![before];
    times.extend(heard.iter().map(|heard: &Heard| heard.at_s));
    times.push(end_s);
    let gap_s = times.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    (heard.len(), gap_s)
}

/// Seconds from a signal to the end of the lease.
pub(super) fn end_lease(vehicle: &Scripted, runtime: &Process, signal: Signal) -> f64 {
    let (since_s, before) = (vehicle.now_s(), vehicle.heard("BPEMB").len());
    runtime.signal(signal);
    vehicle.hears("BPEMB", before + 1, super::ACTS_WITHIN);
    vehicle.heard("BPEMB")[before].at_s - since_s
}

/// The operator releases the hold, and the vehicle is steered again.
pub(super) fn release(vehicle: &Scripted, runtime: &Process) {
    settle(Duration::from_millis(500));
    runtime.signal(Signal::USR2);
    vehicle.hears("BPRMB", vehicle.heard("BPRMB").len() + 2, super::ACTS_WITHIN);
}

/// Holds, releases and ends. Returns the measurements and the exit code.
pub(super) fn end(vehicle: &Scripted, runtime: &mut Process) -> (Figures, Option<i32>) {
    let held_s = end_lease(vehicle, runtime, Signal::USR1);
    release(vehicle, runtime);
    let stopped = Stopwatch::start();
    let ended_s = end_lease(vehicle, runtime, Signal::TERM);
    let code = runtime.wait(super::ACTS_WITHIN);
    let figures = Figures {
        held_s,
        ended_s,
        gone_s: stopped.elapsed().as_secs_f64(),
        ..Figures::default()
    };
    (figures, code)
}

/// The latest wake-up of the loop, which it reports at its end: `slips: none`, or `slips: ... the worst 0.123 s`.
pub(super) fn slip(said: &str) -> Option<f64> {
    let slips = said.lines().rev().find_map(|line| line.split_once(" slips: "))?.1;
    if slips == "none" {
        return Some(0.0);
    }
    let worst = slips.rsplit_once("the worst ")?.1;
    worst.strip_suffix(" s")?.parse().ok()
}
