//! An example of the acoustic modem: the plugin sends reports of depth and temperature to a ship, repeats those that
//! the ship did not acknowledge, and flies the depth that the ship orders.
//!
//! What it shows:
//!
//! - The modem belongs to the vehicle. The payload may send only in the *windows* that the vehicle announces. So the
//!   plugin collects reports, and sends as many as fit into a packet when a window opens.
//! - Sound is unreliable. The outcome of a packet says what happened to each frame. A report is forgotten when its
//!   frame is acknowledged, and goes into the next packet otherwise. The ship may get it twice, so each report has a
//!   number.
//! - A received frame can be damaged, can be meant for another vehicle, and can say anything. The plugin checks all
//!   three before it obeys.

mod order;
mod report;

use std::collections::VecDeque;

use backseat_sdk::{
    Ctd, Description, Event, FRAME_BYTES, FRAMES, FrameOutcome, Grant, Modify, Packet, Plugin, ReceivedPacket, Request,
    Rule, State as Fate, StepInput, Topic, Vertical, Window, log, measures,
};
use serde::{Deserialize, Serialize};

pub use order::depth_ordered;
pub use report::Report;

const SECOND_NS: u64 = 1_000_000_000;
/// How long one modify lasts, and after what time the plugin makes it again.
const STANDS_NS: u64 = 5 * SECOND_NS;
const RENEW_NS: u64 = 2 * SECOND_NS;
/// The most reports that wait. When there are more, the oldest are dropped.
const WAITING_MAX: usize = 256;

/// The plugin's settings, from `[plugin.config]` of the mission.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// The address of the ship's modem.
    pub ship: u32,
    /// The telemetry mode, as the modem numbers them. It decides the next two.
    pub mode: i32,
    /// The most frames of a packet, 1 to 8.
    pub frames: usize,
    /// The most bytes of a frame, 6 to 1024.
    pub frame_bytes: usize,
    /// The time from one report to the next, seconds.
    pub report_s: f64,
    /// The depths that the plugin obeys, least and greatest, metres.
    pub depth_m: [f64; 2],
    /// The heading and the speed with which it flies an ordered depth, degrees and metres per second.
    pub heading_deg: f64,
    /// See `heading_deg`.
    pub speed_mps: f64,
}

/// Sends reports, and obeys orders.
#[derive(Debug)]
pub struct AcousticWindows {
    config: Config,
    state: State,
    /// The window in which the modem may be used. It does not outlive an instance.
    window: Option<Window>,
}

/// What a new instance needs after a failure.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct State {
    tag: u64,
    /// The address of the vehicle's modem, once a window has told it.
    address: Option<u32>,
    /// The reports that the ship has not acknowledged, oldest first.
    waiting: VecDeque<Report>,
    numbered: u16,
    acknowledged: u32,
    dropped: u32,
    next_report_ns: u64,
    /// The packet under way: its tag, and the numbers of the reports in each of its frames.
    sent: Option<(u64, Vec<Vec<u16>>)>,
    /// A packet is worth the energy: a window has opened, a frame was lost, or a whole frame waits.
    due: bool,
    /// The depth that the ship ordered last, metres.
    ordered_m: Option<f64>,
    /// The tag of the present modify, and when to make it again.
    steering: u64,
    renew_ns: u64,
}

impl Plugin for AcousticWindows {
    type Config = Config;

    fn describe() -> Description {
        Description {
            name: "acoustic-windows".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            step_period_ns: SECOND_NS,
            topics: vec![Topic::Acoustic, Topic::Ctd],
            grants: vec![Grant::Acoustic, Grant::Modify],
        }
    }

    fn new(config: Config) -> Result<Self, String> {
        let [least, most] = config.depth_m;
        for (key, ok, expected) in [
            ("frames", (1..=FRAMES).contains(&config.frames), "1 to 8"),
            (
                "frame_bytes",
                (Report::BYTES..=FRAME_BYTES).contains(&config.frame_bytes),
                "6 to 1024",
            ),
            ("report_s", (1.0..=3600.0).contains(&config.report_s), "1 to 3600"),
            (
                "depth_m",
                0.0 <= least && least < most && most <= 6000.0,
                "[least, greatest]",
            ),
            (
                "heading_deg",
                (0.0..360.0).contains(&config.heading_deg),
                "0 to below 360",
            ),
            ("speed_mps", (0.1..=5.0).contains(&config.speed_mps), "0.1 to 5"),
        ] {
            if !ok {
                return Err(format!("{key}: expected {expected}"));
            }
        }
        Ok(Self {
            config,
            state: State::default(),
            window: None,
        })
    }

    fn step(&mut self, input: &StepInput) -> Result<Vec<Request>, String> {
        for event in &input.events {
            if let Event::Ctd(ctd) = event {
                self.measure(ctd, input);
            } else if let Event::Window(window) = event {
                self.state.address = Some(window.address);
                self.window = Some(window.clone());
                self.state.due = true;
            } else if let Event::Packet(packet) = event {
                self.receive(packet);
            } else if let Event::Outcome(outcome) = event {
                self.hear(outcome.tag, &outcome.state);
            } else if let Event::Restored(restored) = event {
                // What was under way may have arrived. Its reports still wait, so they are sent again.
                self.state.sent = None;
                self.state.tag = restored.open.iter().copied().fold(self.state.tag + 1, u64::max);
            }
        }
        // Without control the runtime rejects every request, so make none.
        if !input.control {
            return Ok(vec![]);
        }
        let packet = self.packet(input).map(Request::Packet);
        let modify = self.modify(input.now_ns).map(Request::Modify);
        Ok(packet.into_iter().chain(modify).collect())
    }

    backseat_sdk::keep!(state);
}

impl AcousticWindows {
    fn next_tag(&mut self) -> u64 {
        self.state.tag += 1;
        self.state.tag
    }

    /// Adds a report when one is due.
    fn measure(&mut self, ctd: &Ctd, input: &StepInput) {
        let Some(navigation) = &input.navigation else { return };
        let state = &mut self.state;
        if input.now_ns < state.next_report_ns {
            return;
        }
        state.next_report_ns = input.now_ns + (self.config.report_s * SECOND_NS as f64) as u64;
        state.numbered = state.numbered.wrapping_add(1);
        state
            .waiting
            .push_back(Report::of(state.numbered, navigation.depth, ctd.temperature));
        if state.waiting.len() > WAITING_MAX {
            state.waiting.pop_front();
            state.dropped += 1;
        }
        measures::publish("waiting", state.waiting.len() as f64, "");
        measures::publish("dropped", f64::from(state.dropped), "");
    }

    /// How many reports a frame holds.
    const fn reports_each(&self) -> usize {
        self.config.frame_bytes / Report::BYTES
    }

    /// A packet with the oldest reports, if a window is open and no other packet is under way.
    fn packet(&mut self, input: &StepInput) -> Option<Packet> {
        let open = self.window.as_ref().is_some_and(|window| window.is_open(input));
        if !open || !self.state.due || self.state.sent.is_some() || self.state.waiting.is_empty() {
            return None;
        }
        self.state.due = false;
        let each = self.reports_each();
        let reports: Vec<Report> = self
            .state
            .waiting
            .iter()
            .take(each * self.config.frames)
            .copied()
            .collect();
        let numbers = |frame: &[Report]| frame.iter().map(|report| report.number).collect();
        let bytes = |frame: &[Report]| frame.iter().flat_map(Report::to_bytes).collect();
        let tag = self.next_tag();
        self.state.sent = Some((tag, reports.chunks(each).map(numbers).collect()));
        log::info!("sending {} reports of {}", reports.len(), self.state.waiting.len());
        Some(Packet {
            tag,
            destination: self.config.ship,
            mode: self.config.mode,
            acknowledge: true,
            frames: reports.chunks(each).map(bytes).collect(),
        })
    }

    /// Takes in what has become of a request.
    fn hear(&mut self, tag: u64, fate: &Fate) {
        if tag == self.state.steering {
            // Other rules pass by themselves: the plugin asks again.
            if let Fate::Rejected(refusal) = fate
                && let Rule::Depth | Rule::Altitude | Rule::KeepIn | Rule::KeepOut | Rule::Limit = refusal.rule
            {
                log::warn!("the ordered depth is refused: {}", refusal.text);
                self.state.ordered_m = None;
            }
            return;
        }
        let Some((_, frames)) = self.state.sent.take_if(|(sent, _)| *sent == tag) else {
            return;
        };
        match fate {
            // The modem is at work, or its report is still to come.
            Fate::Sent | Fate::Pending | Fate::Accepted | Fate::Started | Fate::Unknown => {
                self.state.sent = Some((tag, frames));
            }
            Fate::Ended(ended) => {
                for (numbers, outcome) in frames.iter().zip(&ended.frames) {
                    if *outcome == FrameOutcome::Acked {
                        self.acknowledge(numbers);
                    }
                }
                let acked = ended.frames.iter().filter(|frame| **frame == FrameOutcome::Acked);
                let arrived = acked.count();
                log::info!("{arrived} of {} frames arrived", frames.len());
                self.state.due = arrived < frames.len() || self.state.waiting.len() >= self.reports_each();
            }
            Fate::Rejected(refusal) => {
                // The window was over before the packet could leave. The next window brings the reports.
                if refusal.rule != Rule::Window {
                    log::warn!("packet refused: {}", refusal.text);
                }
                self.window = None;
            }
            // The reports still wait. After a packet that the vehicle refused, try again in the next window.
            Fate::Failed(_) | Fate::TimedOut | Fate::Cancelled => {
                log::warn!("packet not sent: {}", fate.reason().unwrap_or("no report"));
                self.window = None;
            }
        }
    }

    fn acknowledge(&mut self, numbers: &[u16]) {
        self.state.waiting.retain(|report| !numbers.contains(&report.number));
        self.state.acknowledged += numbers.len() as u32;
        measures::publish("acknowledged", f64::from(self.state.acknowledged), "");
    }

    /// Takes in a packet of another vehicle.
    fn receive(&mut self, packet: &ReceivedPacket) {
        if self.state.address != Some(packet.destination) || packet.source != self.config.ship {
            log::debug!("a packet from {} to {}", packet.source, packet.destination);
            return;
        }
        for frame in &packet.frames {
            let [least, most] = self.config.depth_m;
            match depth_ordered(&frame.data).filter(|_| frame.good) {
                Some(depth_m) if (least..=most).contains(&depth_m) => {
                    log::info!("ordered to {depth_m} m");
                    measures::publish("ordered", depth_m, "m");
                    self.state.ordered_m = Some(depth_m);
                    self.state.renew_ns = 0;
                }
                Some(depth_m) => log::warn!("ordered to {depth_m} m: not from {least} to {most} m"),
                None => log::warn!("a damaged or unknown order"),
            }
        }
    }

    /// The modify that flies the ordered depth, when it is due.
    fn modify(&mut self, now_ns: u64) -> Option<Modify> {
        let depth_m = self.state.ordered_m?;
        if now_ns < self.state.renew_ns {
            return None;
        }
        self.state.renew_ns = now_ns + RENEW_NS;
        self.state.steering = self.next_tag();
        Some(Modify {
            tag: self.state.steering,
            heading: self.config.heading_deg,
            vertical: Vertical::Depth(depth_m),
            speed: self.config.speed_mps,
            duration_ns: STANDS_NS,
        })
    }
}

backseat_sdk::export!(AcousticWindows);

#[cfg(test)]
mod tests;
