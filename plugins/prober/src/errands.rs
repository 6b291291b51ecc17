//! Requests that are neither leases nor inserts: each kind at times of its own.

use backseat_sdk::{Camera, DvlTrigger, GpsHit, Light, Packet, Request, Silent, SonarAngle, State, Topside, Transport};
use serde::{Deserialize, Serialize};

use crate::asking::Asking;
use crate::config::Kind;
use crate::inserts::Inserts;

const SECOND_NS: u64 = 1_000_000_000;

/// The kinds, with the approximate time between two requests of each, seconds.
const PERIODS_S: [(Kind, f64); 9] = [
    (Kind::Packet, 15.0),
    (Kind::GpsHit, 150.0),
    (Kind::Cancel, 240.0),
    (Kind::Message, 20.0),
    (Kind::Topside, 30.0),
    (Kind::Silent, 120.0),
    (Kind::Trim, 200.0),
    (Kind::Buoyancy, 200.0),
    (Kind::Devices, 15.0),
];
/// The index of packets in the table.
const PACKET: usize = 0;
/// The time between two floods, seconds.
const FLOOD_EVERY_S: f64 = 120.0;
/// The number of requests in a flood.
const FLOOD: usize = 40;

/// Texts that can be sent in a sentence.
const PLAIN: [&str; 3] = ["on the way", "depth 12.5 m: steady", "?"];
/// Texts that cannot.
const RESERVED: [&str; 4] = [
    "a,b",
    "$BPABT,000000.000*5A",
    "RMB",
    "first\r\n$BPKIL,000000.000*5A\r\n",
];

/// When each kind is due, and the state that lasts from step to step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Errands {
    /// 0 until it is drawn.
    due_ns: [u64; PERIODS_S.len()],
    flood_ns: u64,
    dvl: Dvl,
    /// Whether the plugin wants the vehicle to be silent.
    silent: bool,
    /// The modem may be used until this time.
    window_until_ns: u64,
}

/// The handshake for triggering the DVL, as a plugin sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Dvl {
    /// The tag of the open request.
    tag: Option<u64>,
    allowed: bool,
    triggering: bool,
    /// When the next step of the handshake is due.
    next_ns: u64,
    /// When the plugin has triggered for long enough.
    until_ns: u64,
}

impl Errands {
    pub(crate) fn step(&mut self, inserts: &Inserts, asking: &mut Asking<'_>) {
        for (at, (kind, every_s)) in PERIODS_S.into_iter().enumerate() {
            let due_ns = self.due_ns[at];
            if asking.now_ns < due_ns || !asking.config.asks_for(kind) {
                continue;
            }
            self.due_ns[at] = asking.now_ns + asking.random.nanos(0.3 * every_s, 1.7 * every_s);
            if due_ns != 0
                && let Some(request) = self.draw(kind, inserts, asking)
            {
                asking.ask(request);
            }
        }
        if asking.now_ns >= self.flood_ns {
            if self.flood_ns != 0 && asking.dares(0.6) {
                self.flood(inserts, asking);
            }
            self.flood_ns = asking.now_ns + asking.random.nanos(0.3 * FLOOD_EVERY_S, 1.7 * FLOOD_EVERY_S);
        }
        if asking.config.asks_for(Kind::Dvl) {
            self.dvl.step(asking);
        }
    }

    /// Takes in the outcome of a request.
    pub(crate) fn hear(&mut self, tag: u64, state: &State) {
        let over = match state {
            State::Sent | State::Pending | State::Accepted | State::Started | State::Unknown => false,
            // A refused step is reported with the tag of the open request, which stays open.
            State::Rejected(_) => !self.dvl.allowed,
            State::Failed(_) | State::TimedOut | State::Ended(_) | State::Cancelled => true,
        };
        if over && self.dvl.tag == Some(tag) {
            self.dvl.tag = None;
        }
    }

    /// Takes in whether the vehicle allows the payload to trigger the DVL.
    pub(crate) fn hear_dvl(&mut self, allowed: bool, asking: &mut Asking<'_>) {
        let dvl = &mut self.dvl;
        dvl.allowed = allowed;
        dvl.next_ns = asking.now_ns;
        if allowed {
            dvl.until_ns = asking.now_ns + asking.random.nanos(4.0, 40.0);
        } else if dvl.tag.is_some() && asking.is_bold() {
            // It ignores this for a while.
            dvl.next_ns += 3 * SECOND_NS;
        }
    }

    /// Takes in a window for the modem, which lasts until `until_ns`.
    pub(crate) fn hear_window(&mut self, until_ns: u64, now_ns: u64) {
        self.window_until_ns = until_ns;
        if self.due_ns[PACKET] != 0 {
            self.due_ns[PACKET] = self.due_ns[PACKET].min(now_ns);
        }
    }

    /// In a new instance the handshake starts from the beginning.
    pub(crate) fn restart(&mut self) {
        self.dvl = Dvl::default();
    }

    fn draw(&mut self, kind: Kind, inserts: &Inserts, asking: &mut Asking<'_>) -> Option<Request> {
        let bold = asking.is_bold();
        Some(match kind {
            Kind::GpsHit => gps_hit(bold, asking),
            Kind::Cancel => Request::Cancel(inserts.to_cancel(bold, asking)?),
            Kind::Message => Request::Message(text(bold, asking)),
            Kind::Topside => Request::Topside(Topside {
                tag: asking.next_tag(),
                slowest: asking
                    .random
                    .pick([Transport::Wifi, Transport::RadioModem, Transport::AcousticModem]),
                text: text(bold, asking),
            }),
            Kind::Trim => Request::Trim(asking.next_tag()),
            Kind::Buoyancy => Request::Buoyancy(asking.next_tag()),
            Kind::Packet => {
                // A modest packet waits for its window.
                if asking.now_ns >= self.window_until_ns && !bold {
                    return None;
                }
                packet(asking)
            }
            Kind::Silent => {
                self.silent = if bold { asking.random.chance(0.6) } else { !self.silent };
                Request::Silent(Silent {
                    tag: asking.next_tag(),
                    silent: self.silent,
                })
            }
            Kind::Devices => device(bold, asking),
            // These have a timing of their own.
            Kind::Modify | Kind::Trackline | Kind::Trackcircle | Kind::Dvl | Kind::Station => return None,
        })
    }

    /// Makes more requests of one kind in a step than a mission allows in a second or a minute.
    fn flood(&mut self, inserts: &Inserts, asking: &mut Asking<'_>) {
        let kind = PERIODS_S[asking.random.below(PERIODS_S.len())].0;
        if !asking.config.asks_for(kind) {
            return;
        }
        for _ in 0..FLOOD {
            if let Some(request) = self.draw(kind, inserts, asking) {
                asking.ask(request);
            }
        }
    }
}

impl Dvl {
    fn step(&mut self, asking: &mut Asking<'_>) {
        if self.next_ns == 0 {
            self.next_ns = asking.now_ns + asking.random.nanos(5.0, 60.0);
        }
        if asking.now_ns < self.next_ns {
            return;
        }
        let Some(tag) = self.tag else {
            let tag = asking.next_tag();
            *self = Self {
                tag: Some(tag),
                // The vehicle's permission may take some time; a bold plugin does not wait for it.
                next_ns: asking.now_ns + asking.random.nanos(2.0, 30.0),
                ..Self::default()
            };
            let triggering = asking.dares(0.2);
            return asking.ask(dvl(tag, true, triggering));
        };
        let (external, triggering) = match (self.allowed, self.triggering) {
            (true, _) if asking.now_ns < self.until_ns => {
                self.triggering = !asking.random.chance(0.1);
                (true, self.triggering)
            }
            (true, true) => {
                self.triggering = false;
                (false, asking.random.chance(0.5))
            }
            (true, false) => (false, false),
            (false, true) => {
                // Asked to stop, it stops for now or ends the handshake.
                self.triggering = asking.dares(0.3);
                (asking.random.chance(0.5), self.triggering)
            }
            (false, false) => (true, asking.dares(0.5)),
        };
        // Usually it repeats the request in time; sometimes too late.
        let most_s = if asking.dares(0.2) { 8.0 } else { 4.0 };
        self.next_ns = asking.now_ns + asking.random.nanos(1.0, most_s);
        if !external && !triggering {
            self.tag = None;
            self.next_ns = asking.now_ns + asking.random.nanos(20.0, 120.0);
        }
        asking.ask(dvl(tag, external, triggering));
    }
}

const fn dvl(tag: u64, external: bool, triggering: bool) -> Request {
    Request::DvlTrigger(DvlTrigger {
        tag,
        external,
        triggering,
    })
}

fn text(bold: bool, asking: &mut Asking<'_>) -> String {
    if bold && asking.random.chance(0.3) {
        asking.random.pick(RESERVED).into()
    } else {
        asking.random.pick(PLAIN).into()
    }
}

/// Close to the vehicle where the fence permits surfacing; a bold one anywhere.
fn gps_hit(bold: bool, asking: &mut Asking<'_>) -> Request {
    let here = asking.fix.local();
    let mut hit = GpsHit {
        tag: asking.next_tag(),
        position: asking.fix.position_of(here),
    };
    for _ in 0..4 {
        let at = if bold {
            asking.anywhere()
        } else {
            here.offset(asking.random.within(0.0, 360.0), asking.random.within(0.0, 300.0))
        };
        hit.position = asking.fix.position_of(at);
        if bold || asking.fits(&Request::GpsHit(hit)) {
            break;
        }
    }
    Request::GpsHit(hit)
}

fn packet(asking: &mut Asking<'_>) -> Request {
    let bytes = asking.random.pick([1, 8, 32, 32, 256]);
    let frames = asking.random.below(3) + 1;
    Request::Packet(Packet {
        tag: asking.next_tag(),
        destination: asking.random.pick([0, 1, 15]),
        mode: asking.random.pick([0, 0, 1, 5]),
        acknowledge: asking.random.chance(0.3),
        frames: vec![vec![0x55; bytes]; frames],
    })
}

fn device(bold: bool, asking: &mut Asking<'_>) -> Request {
    let tag = asking.next_tag();
    let most = if bold { 12.0 } else { 9.0 };
    match asking.random.below(3) {
        0 => Request::SonarAngle(SonarAngle {
            tag,
            angle: asking.random.within(-4.0 * most, 4.0 * most),
        }),
        1 => Request::Camera(Camera {
            tag,
            pan: asking.random.within(-most, most) as i32,
            tilt: asking.random.within(-most, most) as i32,
            zoom: asking.random.within(-most, most) as i32,
        }),
        _ => Request::Light(Light {
            tag,
            light: 0,
            on: asking.random.chance(0.5),
        }),
    }
}
