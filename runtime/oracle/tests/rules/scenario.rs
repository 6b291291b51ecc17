//! A run written by hand. What a test does not state is a healthy vehicle that flies its plan inside the fence.

#![expect(clippy::unwrap_used, reason = "a scenario that cannot be built fails its test")]

use std::fmt::Write;

use backseat_oracle::{Activity, Limits, Oracle, Position, State, Statistics, Truth, Violation};

/// A zone of 2.2 km by 1.7 km, with a forbidden mooring of 220 m by 170 m in it, and a wreck that is forbidden only at
/// 30 m and deeper.
pub(crate) const FENCE: &str = r#"{ "type": "FeatureCollection", "features": [
    { "type": "Feature",
      "properties": { "name": "site", "kind": "keep-in", "margin_m": 20, "surfacing": true, "depth_min_m": 2, "depth_max_m": 40,
                      "altitude_min_m": 3 },
      "geometry": { "type": "Polygon", "coordinates": [[
        [-70.02, 42.0], [-70.0, 42.0], [-70.0, 42.02], [-70.02, 42.02], [-70.02, 42.0]]] } },
    { "type": "Feature",
      "properties": { "name": "mooring", "kind": "keep-out", "margin_m": 30 },
      "geometry": { "type": "Polygon", "coordinates": [[
        [-70.012, 42.01], [-70.01, 42.01], [-70.01, 42.012], [-70.012, 42.012], [-70.012, 42.01]]] } },
    { "type": "Feature",
      "properties": { "name": "wreck", "kind": "keep-out", "margin_m": 30, "depth_min_m": 30 },
      "geometry": { "type": "Polygon", "coordinates": [[
        [-70.012, 42.002], [-70.01, 42.002], [-70.01, 42.004], [-70.012, 42.004], [-70.012, 42.002]]] } }
] }"#;

/// A full BPRMB.
pub(crate) const MODIFY: &str = "BPRMB,{t},90,10,0,1.5,1,0";
pub(crate) const END: &str = "BPEMB,{t}";

#[derive(Clone)]
enum Event {
    Link(bool),
    Vehicle(Vec<u8>),
    Ours(Vec<u8>),
    Activity(Activity),
    Place(f64, f64),
    Depth(f64),
    Altitude(f64),
    Navigation(bool),
    Lock(bool),
    NavigationDelay(u64),
    Stopped,
    Continued,
    Started,
    Operator(bool),
    Arrived(Vec<u8>),
    Error(f64),
    Gap(u64),
}

/// What happens, and when.
#[derive(Clone)]
pub(crate) struct Scenario {
    events: Vec<(u64, Event)>,
    limits: Limits,
    /// Whether each BPRMB is answered at once.
    answers: bool,
    /// Until when the runtime sends BPSTS each second unless it is stopped, and how long the answers take,
    /// milliseconds.
    beats_until_ms: u64,
    beats_take_ms: u64,
    /// The positions in BFNVG, and from when on each of them counts: latitude and longitude as they are written.
    believed: Vec<(u64, &'static str)>,
    /// From the first time until the second the position in BFNVG creeps north at this speed in m/s, besides the
    /// vehicle's own motion.
    creeps: Option<(u64, u64, f64)>,
    /// The speed to the north in BFNVR, m/s, and the time without BFNVR, milliseconds.
    north_mps: f64,
    without_velocities: std::ops::Range<u64>,
    /// When the vehicle's clock is set and when it is set back, and by how many milliseconds.
    clock_set: (std::ops::Range<u64>, i64),
}

/// The oracle's result.
pub(crate) struct Outcome {
    pub(crate) violations: Vec<Violation>,
    pub(crate) statistics: Statistics,
    /// The state of the run at each tenth of a second, without repetitions.
    pub(crate) states: Vec<State>,
}

impl Scenario {
    /// The link is up, and we have control from 0.1 s on.
    pub(crate) fn with_control() -> Self {
        Self::without_control()
            .vehicle(100, "BFMIS,{t},a.dive,Running /logs/1,")
            .vehicle(100, "BFCTL,{t},1")
            .vehicle(100, "BFMBS,{t},,1,,trackline")
    }

    pub(crate) fn without_control() -> Self {
        Self {
            events: Vec::new(),
            limits: Limits {
                link_delay_s: 0.2,
                ..Limits::default()
            },
            answers: true,
            beats_until_ms: u64::MAX,
            beats_take_ms: 0,
            believed: vec![(0, "4200.300,N,07000.900,W")],
            creeps: None,
            north_mps: 0.0,
            without_velocities: 0..0,
            clock_set: (u64::MAX..u64::MAX, 0),
        }
        .link(0, true)
        .vehicle(50, "BFPLN,{t},1,,0,0,4200.300,N,07000.900,W,,,")
    }

    pub(crate) fn limits(mut self, change: impl FnOnce(&mut Limits)) -> Self {
        change(&mut self.limits);
        self
    }

    /// The vehicle answers no BPRMB.
    pub(crate) fn without_answers(mut self) -> Self {
        self.answers = false;
        self
    }

    /// The runtime sends no BPSTS from then on.
    pub(crate) fn beats_until(mut self, ms: u64) -> Self {
        self.beats_until_ms = ms;
        self
    }

    /// The answer to a BPSTS takes this long.
    pub(crate) fn beats_take(mut self, ms: u64) -> Self {
        self.beats_take_ms = ms;
        self
    }

    /// From then on BFNVG has this position.
    pub(crate) fn believes(mut self, ms: u64, place: &'static str) -> Self {
        self.believed.push((ms, place));
        self
    }

    /// The position in BFNVG creeps north from the first time until the second.
    pub(crate) fn creeps(mut self, from_ms: u64, until_ms: u64, mps: f64) -> Self {
        self.creeps = Some((from_ms, until_ms, mps));
        self
    }

    /// BFNVR says that the vehicle goes north at this speed.
    pub(crate) fn goes_north(mut self, mps: f64) -> Self {
        self.north_mps = mps;
        self
    }

    /// No BFNVR comes in this time.
    pub(crate) fn without_velocities(mut self, ms: std::ops::Range<u64>) -> Self {
        self.without_velocities = ms;
        self
    }

    /// The vehicle's clock is set.
    pub(crate) fn clock_set(mut self, ms: u64, by_ms: i64) -> Self {
        self.clock_set = (ms..u64::MAX, by_ms);
        self
    }

    /// The vehicle's clock is set, and set back at the end of this time.
    pub(crate) fn clock_set_during(mut self, ms: std::ops::Range<u64>, by_ms: i64) -> Self {
        self.clock_set = (ms, by_ms);
        self
    }

    pub(crate) fn link(self, ms: u64, up: bool) -> Self {
        self.event(ms, Event::Link(up))
    }

    /// The vehicle writes a sentence; `{t}` is the time.
    pub(crate) fn vehicle(self, ms: u64, body: &str) -> Self {
        let text = sentence(&body.replace("{t}", &stamp(ms)));
        self.vehicle_bytes(ms, text.as_bytes())
    }

    /// The link passes these bytes of the vehicle on.
    pub(crate) fn vehicle_bytes(self, ms: u64, bytes: &[u8]) -> Self {
        self.event(ms, Event::Vehicle(bytes.to_vec()))
    }

    /// We write a sentence; `{t}` is the time.
    pub(crate) fn ours(self, ms: u64, body: &str) -> Self {
        let text = sentence(&body.replace("{t}", &stamp(ms)));
        self.bytes(ms, text.as_bytes())
    }

    pub(crate) fn bytes(self, ms: u64, bytes: &[u8]) -> Self {
        self.event(ms, Event::Ours(bytes.to_vec()))
    }

    /// BPRMB every second from the first time to the second, both included, and a vehicle that flies the modify.
    pub(crate) fn lease(mut self, from_ms: u64, to_ms: u64) -> Self {
        for ms in (from_ms..=to_ms).step_by(1000) {
            self = self.ours(ms, MODIFY);
        }
        self.activity(from_ms + 100, Activity::Modified)
    }

    pub(crate) fn activity(self, ms: u64, activity: Activity) -> Self {
        self.event(ms, Event::Activity(activity))
    }

    pub(crate) fn place(self, ms: u64, latitude: f64, longitude: f64) -> Self {
        self.event(ms, Event::Place(latitude, longitude))
    }

    pub(crate) fn depth(self, ms: u64, metres: f64) -> Self {
        self.event(ms, Event::Depth(metres))
    }

    pub(crate) fn altitude(self, ms: u64, metres: f64) -> Self {
        self.event(ms, Event::Altitude(metres))
    }

    /// Whether the vehicle writes BFNVG.
    pub(crate) fn navigation(self, ms: u64, on: bool) -> Self {
        self.event(ms, Event::Navigation(on))
    }

    /// Whether BFNVG has an altitude above the seabed.
    pub(crate) fn lock(self, ms: u64, on: bool) -> Self {
        self.event(ms, Event::Lock(on))
    }

    /// How old each BFNVG is when the link passes it on, milliseconds.
    pub(crate) fn navigation_delay(self, ms: u64, delay_ms: u64) -> Self {
        self.event(ms, Event::NavigationDelay(delay_ms))
    }

    /// A fault stops the runtime.
    pub(crate) fn stopped(self, ms: u64) -> Self {
        self.event(ms, Event::Stopped)
    }

    /// A sentence of ours that was made at one time arrives at another.
    pub(crate) fn arrives(self, made_ms: u64, ms: u64, body: &str) -> Self {
        let text = sentence(&body.replace("{t}", &stamp(made_ms)));
        self.event(ms, Event::Arrived(text.into_bytes()))
    }

    /// The record lacks everything from the first time until the second.
    pub(crate) fn gap(self, from_ms: u64, until_ms: u64) -> Self {
        self.event(from_ms, Event::Gap(until_ms))
    }

    /// The error of navigation: the distance between the vehicle and the position that it believes, in metres.
    pub(crate) fn error(self, ms: u64, metres: f64) -> Self {
        self.event(ms, Event::Error(metres))
    }

    /// The stopped runtime goes on.
    pub(crate) fn continued(self, ms: u64) -> Self {
        self.event(ms, Event::Continued)
    }

    /// A new process begins.
    pub(crate) fn started(self, ms: u64) -> Self {
        self.event(ms, Event::Started)
    }

    /// The operator holds or releases.
    pub(crate) fn operator(self, ms: u64, held: bool) -> Self {
        self.event(ms, Event::Operator(held))
    }

    /// The link is lost and comes back, and so does control.
    pub(crate) fn reconnects(self, lost_ms: u64, back_ms: u64) -> Self {
        self.link(lost_ms, false)
            .link(back_ms, true)
            .vehicle(back_ms + 100, "BFMIS,{t},a.dive,Running,")
            .vehicle(back_ms + 100, "BFCTL,{t},1")
            .vehicle(back_ms + 100, "BFPLN,{t},1,,0,0,4200.300,N,07000.900,W,,,")
            .vehicle(back_ms + 100, "BFMBS,{t},,1,,trackline")
    }

    fn event(mut self, ms: u64, event: Event) -> Self {
        self.events.push((ms, event));
        self
    }

    /// Runs for this many milliseconds.
    pub(crate) fn run(mut self, until_ms: u64) -> Outcome {
        self.events.sort_by_key(|(ms, _)| *ms);
        let mut oracle = Oracle::new(FENCE, self.limits).unwrap();
        let mut truth = Truth {
            at_ns: 0,
            position: position(42.005, -70.015),
            depth_m: 10.0,
            altitude_m: 30.0,
            activity: Activity::Plan,
        };
        let (mut navigation, mut up, mut runs) = (true, false, true);
        let mut gap: Option<(u64, u64)> = None;
        let (mut beats, mut beat_now): (Vec<u64>, _) = (Vec::new(), false);
        let (mut states, mut delay_ms) = (Vec::new(), 0);
        let mut events = self.events.into_iter().peekable();
        let mut lock_m = 30;
        let (set, by_ms) = self.clock_set;
        let clock = |ms: u64| match ms {
            ms if set.contains(&ms) => stamp((86_400_000 + ms).saturating_add_signed(by_ms)),
            ms => stamp(ms),
        };
        for ms in 0..=until_ms {
            let at = ms * 1_000_000;
            if let Some((from, _)) = gap.take_if(|(_, until_ms)| *until_ms <= ms) {
                oracle.gap(from, at);
            }
            while let Some((_, event)) = events.next_if(|(due, _)| *due <= ms) {
                if gap.is_some() {
                    continue;
                }
                match event {
                    Event::Link(now) => {
                        up = now;
                        beats.clear();
                        beat_now |= now;
                        oracle.link(at, now);
                    }
                    Event::Vehicle(bytes) => oracle.from_vehicle(at, &bytes),
                    Event::Ours(bytes) => {
                        oracle.to_vehicle(at, &bytes);
                        if self.answers && bytes.starts_with(b"$BPRMB") && up {
                            let ack = format!("BFACK,{},RMB,{},0,2,0,ok", clock(ms), stamp(ms));
                            oracle.from_vehicle(at, sentence(&ack).as_bytes());
                        }
                    }
                    Event::Arrived(bytes) => oracle.arrived(at, &bytes),
                    Event::Gap(until_ms) => gap = Some((at, until_ms)),
                    Event::Error(metres) => oracle.believed(metres, 0.0),
                    Event::Activity(activity) => truth.activity = activity,
                    Event::Place(latitude, longitude) => {
                        truth.position = position(latitude, longitude);
                    }
                    Event::Depth(metres) => truth.depth_m = metres,
                    Event::Altitude(metres) => truth.altitude_m = metres,
                    Event::Navigation(on) => navigation = on,
                    Event::Lock(on) => lock_m = if on { 30 } else { 0 },
                    Event::NavigationDelay(now) => delay_ms = now,
                    Event::Stopped => {
                        runs = false;
                        oracle.runtime_stopped(at);
                    }
                    Event::Continued => {
                        (runs, beat_now) = (true, true);
                        oracle.runtime_continued(at);
                    }
                    Event::Started => {
                        (runs, beat_now) = (true, true);
                        oracle.runtime_started(at);
                    }
                    Event::Operator(held) => oracle.operator(at, held),
                }
            }
            if gap.is_some() {
                continue;
            }
            if up && runs && (ms % 1000 == 55 || core::mem::take(&mut beat_now)) && ms < self.beats_until_ms {
                beats.push(ms);
                oracle.to_vehicle(at, sentence(&format!("BPSTS,{},1,well", stamp(ms))).as_bytes());
            }
            while beats.first().is_some_and(|sent| *sent + self.beats_take_ms <= ms) {
                let sent = beats.remove(0);
                let ack = format!("BFACK,{},STS,{},0,2,0,ok", clock(ms), stamp(sent));
                oracle.from_vehicle(at, sentence(&ack).as_bytes());
            }
            if ms % 100 != 0 {
                continue;
            }
            if navigation && up {
                let time = clock(ms.saturating_sub(delay_ms));
                let place = self.believed.iter().rev().find(|(since, _)| *since <= ms).unwrap().1;
                let place = match self.creeps {
                    Some((from, until, mps)) if ms > from => {
                        let crept_m = mps * (ms.min(until) - from) as f64 / 1e3;
                        // A minute of latitude is 1851.2 m here.
                        format!("42{:010.7},N,07000.900,W", 0.3 + crept_m / 1851.2)
                    }
                    Some(_) | None => place.to_owned(),
                };
                let text = sentence(&format!("BFNVG,{time},{place},1,{lock_m},10,90,0,0,{time}"));
                let velocities = sentence(&format!("BFNVR,{time},0,{},0,0,0,0", self.north_mps));
                let (first, second) = text.as_bytes().split_at(ms as usize / 100 % text.len());
                oracle.from_vehicle(at, first);
                oracle.from_vehicle(at, second);
                if !self.without_velocities.contains(&ms) {
                    oracle.from_vehicle(at, velocities.as_bytes());
                }
            }
            truth.at_ns = at;
            oracle.truth(&truth);
            if states.last().is_none_or(|last| *last != oracle.state()) {
                states.push(oracle.state());
            }
        }
        let statistics = oracle.statistics();
        Outcome {
            violations: oracle.finish(until_ms * 1_000_000),
            statistics,
            states,
        }
    }

    /// Runs for 20 s, and checks that exactly these rules are broken.
    #[track_caller]
    pub(crate) fn finds(self, rules: &[&str]) -> Outcome {
        let outcome = self.run(20_000);
        let found: Vec<_> = outcome.violations.iter().map(|violation| violation.rule).collect();
        assert_eq!(found, rules, "{:#?}", outcome.violations);
        outcome
    }

    #[track_caller]
    pub(crate) fn finds_nothing(self) -> Outcome {
        self.finds(&[])
    }
}

/// A body with its dollar sign, checksum and line end.
pub(crate) fn sentence(body: &str) -> String {
    let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    let mut text = format!("${body}");
    write!(text, "*{sum:02X}\r\n").unwrap();
    text
}

/// The time of day at `ms`: the run begins one second before midnight.
pub(crate) fn stamp(ms: u64) -> String {
    let millis = (86_399_000 + ms) % 86_400_000;
    let (minutes, seconds) = (millis / 60_000, millis / 1000 % 60);
    format!(
        "{:02}{:02}{seconds:02}.{:03}",
        minutes / 60,
        minutes % 60,
        millis % 1000
    )
}

pub(crate) const fn position(latitude_deg: f64, longitude_deg: f64) -> Position {
    Position {
        latitude_deg,
        longitude_deg,
    }
}
