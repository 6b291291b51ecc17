//! Inserts: short ones close to the vehicle, to be flown, and bold ones, to be refused.

use backseat_sdk::units::EastNorth;
use backseat_sdk::{Request, State, Trackcircle, Trackline, Vertical};
use serde::{Deserialize, Serialize};

use crate::asking::Asking;
use crate::config::Kind;

/// How many of its own inserts it remembers in order to cancel them.
const OPEN_MAX: usize = 32;
/// The longest modest line, metres.
const LINE_MAX_M: f64 = 250.0;
const LINE_MIN_M: f64 = 50.0;

/// The inserts that it has requested.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Inserts {
    open: Vec<Open>,
    /// When the next insert is requested.
    next_ns: u64,
    /// Rejections since a request was last accepted.
    refused: u32,
    /// Whether an insert has been accepted.
    accepted: bool,
    /// Whether the vehicle has refused the last one.
    failed: bool,
    detour: Option<Detour>,
}

/// Successive lines around an obstacle. A path leads to the start of the last line from the end of the one before it,
/// but not from what is flown earlier. Finally the line before the last is cancelled.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Detour {
    /// The tags of the requested lines, in the order in which they are flown.
    tags: Vec<u64>,
    /// The ends of the lines that are yet to be requested, east and north in metres, the last line first.
    left_m: Vec<[[f64; 2]; 2]>,
    /// When the line before the last is cancelled; 0 until all lines are accepted.
    due_ns: u64,
}

impl Detour {
    /// Whether a tag belongs to a line that is flown before the one that will be cancelled.
    fn is_before(&self, tag: u64) -> bool {
        let to_come = self.left_m.len();
        let at = self.tags.iter().position(|known| *known == tag);
        at.is_some_and(|at| at + 2 < self.tags.len() + to_come)
    }

    fn taken_back(&self) -> Option<u64> {
        self.tags.iter().rev().nth(1).copied()
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Open {
    tag: u64,
    started: bool,
    interrupt: bool,
}

impl Inserts {
    pub(crate) fn step(&mut self, asking: &mut Asking<'_>) {
        if let Some(detour) = self
            .detour
            .take_if(|detour| (1..=asking.now_ns).contains(&detour.due_ns))
            && let Some(tag) = detour.taken_back()
        {
            asking.ask(Request::Cancel(tag));
        }
        if asking.now_ns < self.next_ns {
            return;
        }
        self.next_ns = asking.now_ns + asking.random.nanos(3.0, 8.0);
        let kinds = [Kind::Trackline, Kind::Trackcircle].map(|kind| asking.config.asks_for(kind));
        let line = match kinds {
            [false, false] => return,
            [true, false] => true,
            [false, true] => false,
            [true, true] => asking.random.chance(0.65),
        };
        let bold = asking.is_bold() && (self.accepted || self.refused % 2 == 1);
        if !bold && (self.open.len() > 1 || self.open.len() == 1 && asking.random.chance(0.8)) {
            // The vehicle has enough to fly.
            return;
        }
        match (bold, line) {
            (true, _) if asking.random.chance(0.15) => self.burst(line, asking),
            (true, true) => self.bold_line(asking),
            (true, false) => self.bold_circle(asking),
            (false, true) => self.modest_line(asking),
            (false, false) => self.modest_circle(asking),
        }
    }

    /// Takes in the outcome of a request.
    pub(crate) fn hear(&mut self, tag: u64, state: &State, asking: &mut Asking<'_>) {
        let Some(at) = self.open.iter().position(|open| open.tag == tag) else {
            return;
        };
        self.lead(tag, state, asking);
        match state {
            State::Sent | State::Pending | State::Unknown => {}
            State::Accepted => {
                self.accepted = true;
                self.failed = false;
                self.refused = 0;
                let every_s = asking.config.insert_every_s;
                self.next_ns = asking.now_ns + asking.random.nanos(0.5 * every_s, 1.5 * every_s);
            }
            State::Started => self.open[at].started = true,
            State::Rejected(_) => {
                self.open.remove(at);
                self.refused += 1;
                self.next_ns = self.next_ns.min(asking.now_ns + asking.random.nanos(0.5, 4.0));
            }
            State::Failed(_) | State::TimedOut => {
                self.open.remove(at);
                self.failed = true;
                self.next_ns = asking.now_ns + asking.random.nanos(5.0, 20.0);
            }
            State::Ended(_) | State::Cancelled => {
                self.open.remove(at);
            }
        }
    }

    /// Called when control is gained: the next request comes soon.
    pub(crate) fn hurry(&mut self, asking: &mut Asking<'_>) {
        self.next_ns = self.next_ns.min(asking.now_ns + asking.random.nanos(0.0, 5.0));
    }

    /// Whether the vehicle is flying one of these inserts.
    pub(crate) fn is_flying(&self) -> bool {
        self.open.iter().any(|open| open.started)
    }

    /// Whether the vehicle has accepted any.
    pub(crate) const fn is_accepted(&self) -> bool {
        self.accepted
    }

    /// A new instance learns which inserts are open.
    pub(crate) fn restart(&mut self, open: &[u64]) {
        self.open.retain(|known| open.contains(&known.tag));
    }

    /// The tag of an insert to cancel: one of several that have not begun or, if bold, any, or one that does not exist.
    pub(crate) fn to_cancel(&self, bold: bool, asking: &mut Asking<'_>) -> Option<u64> {
        if bold && asking.random.chance(0.4) {
            return Some(asking.random.next());
        }
        let waits = |open: &&Open| bold || !open.started && !open.interrupt;
        let tags: Vec<u64> = self.open.iter().filter(waits).map(|open| open.tag).collect();
        if tags.len() < 2 && !asking.random.chance(0.2) {
            return None;
        }
        tags.get(asking.random.below(tags.len())).copied()
    }

    fn note(&mut self, tag: u64, interrupt: bool) {
        if self.open.len() == OPEN_MAX {
            self.open.remove(0);
        }
        self.open.push(Open {
            tag,
            started: false,
            interrupt,
        });
    }

    /// Whether the next insert interrupts. A modest one never interrupts an interrupting insert of its own. Most modest
    /// ones do interrupt, because an insert that follows a long leg of the plan is not flown for a long time.
    fn interrupts(&self, bold: bool, asking: &mut Asking<'_>) -> bool {
        let interrupted = self.open.iter().any(|open| open.interrupt) || self.failed;
        asking.random.chance(if bold { 0.4 } else { 0.75 }) && (bold || !interrupted)
    }

    fn line(
        &mut self,
        [start, end]: [EastNorth; 2],
        vertical: Vertical,
        bold: bool,
        asking: &mut Asking<'_>,
    ) -> Request {
        Request::Trackline(Trackline {
            tag: asking.next_tag(),
            start: asking.fix.position_of(start),
            end: asking.fix.position_of(end),
            vertical,
            speed: asking.speed(bold),
            interrupt: self.interrupts(bold, asking),
        })
    }

    fn circle(&mut self, ring: Ring, vertical: Vertical, bold: bool, asking: &mut Asking<'_>) -> Request {
        Request::Trackcircle(Trackcircle {
            tag: asking.next_tag(),
            centre: asking.fix.position_of(ring.centre),
            radius: ring.radius_m,
            orbits: ring.orbits,
            vertical,
            speed: asking.speed(bold),
            entry_angle: ring.entry_deg,
            interrupt: self.interrupts(bold, asking),
        })
    }

    fn ask(&mut self, request: Request, asking: &mut Asking<'_>) {
        if let Request::Trackline(Trackline { tag, interrupt, .. })
        | Request::Trackcircle(Trackcircle { tag, interrupt, .. }) = &request
        {
            self.note(*tag, *interrupt);
        }
        asking.ask(request);
    }

    fn vertical(&self, asking: &mut Asking<'_>) -> Vertical {
        // The depth may have been the reason for the refusals.
        if self.refused >= 3 {
            asking.level()
        } else {
            asking.vertical(false)
        }
    }

    fn modest_line(&mut self, asking: &mut Asking<'_>) {
        if self.accepted && asking.random.chance(0.3) && (self.detour(asking) || self.hidden_line(asking)) {
            return;
        }
        let mut request = None;
        for _ in 0..4 {
            let here = asking.fix.local();
            // After each refusal the line is shorter, and closer to the vehicle's own path.
            let narrow = 1.0 / f64::from(self.refused.min(6) + 1);
            let along_deg = if asking.random.chance(0.5) {
                asking.fix.heading_deg
            } else {
                here.bearing_deg(asking.middle())
            };
            let aside_deg = asking.random.within(-150.0, 150.0) * narrow;
            let start_m = asking.random.within(20.0, 20.0 + 150.0 * narrow);
            let start = here.offset(along_deg + aside_deg, start_m);
            let length_m = asking
                .random
                .within(LINE_MIN_M, LINE_MIN_M + (LINE_MAX_M - LINE_MIN_M) * narrow);
            let turn_deg = asking.random.within(-90.0, 90.0) * narrow;
            let end = start.offset(along_deg + aside_deg + turn_deg, length_m);
            let vertical = self.vertical(asking);
            let line = self.line([start, end], vertical, false, asking);
            let fits = asking.fits(&line);
            request = Some(line);
            if fits {
                break;
            }
        }
        if let Some(request) = request {
            self.ask(request, asking);
        }
    }

    fn modest_circle(&mut self, asking: &mut Asking<'_>) {
        let mut request = None;
        for _ in 0..4 {
            let here = asking.fix.local();
            let inwards_deg = here.bearing_deg(asking.middle()) + asking.random.within(-120.0, 120.0);
            let away_m = asking.random.within(20.0, 150.0);
            let entry = asking.random.chance(0.6);
            let ring = Ring {
                centre: here.offset(inwards_deg, away_m),
                radius_m: asking.random.within(18.0, 35.0),
                orbits: asking.random.sign() * asking.random.within(0.3, 1.5),
                entry_deg: entry.then(|| asking.random.within(0.0, 360.0)),
            };
            let vertical = self.vertical(asking);
            let circle = self.circle(ring, vertical, false, asking);
            let fits = asking.fits(&circle);
            request = Some(circle);
            if fits {
                break;
            }
        }
        if let Some(request) = request {
            self.ask(request, asking);
        }
    }

    fn bold_line(&mut self, asking: &mut Asking<'_>) {
        let here = asking.fix.local();
        let near = here.offset(asking.random.within(0.0, 360.0), asking.random.within(0.0, 200.0));
        let ends = match asking.random.below(7) {
            0 => [asking.anywhere(), asking.anywhere()],
            // Along an edge, or across a corner.
            1 => [asking.corner(120.0), asking.corner(120.0)],
            2 => [near, asking.nearest_edge()],
            // As far towards an edge as the fence allows, or a little farther.
            3 => {
                let far = asking.anywhere();
                let end = self.creep(near, far, asking);
                [near, end]
            }
            4 | 5 if self.hidden_line(asking) => return,
            _ => [near, asking.anywhere()],
        };
        let bold = asking.random.chance(0.4);
        let vertical = asking.vertical(bold);
        let line = self.line(ends, vertical, bold, asking);
        if asking.random.chance(0.2) && !asking.fits(&line) && asking.random.chance(0.5) {
            // After a refusal it requests another line; otherwise it goes ahead.
            return self.modest_line(asking);
        }
        self.ask(line, asking);
    }

    /// Begins a detour. Returns false if there is no obstacle, or by chance.
    fn detour(&mut self, asking: &mut Asking<'_>) -> bool {
        if self.detour.is_some() || asking.random.chance(0.3) {
            return false;
        }
        let lines = match asking.round_something() {
            // An insert that interrupts has an end that the vehicle comes from.
            Some(lines) => lines.to_vec(),
            None => {
                let Some([hidden, seen]) = asking.behind_something() else {
                    return false;
                };
                let near = seen.offset(asking.random.within(0.0, 360.0), asking.random.within(40.0, 80.0));
                vec![[near, seen], [hidden, seen]]
            }
        };
        let ends_m = |line: &[EastNorth; 2]| line.map(|end| [end.east_m, end.north_m]);
        self.detour = Some(Detour {
            tags: vec![self.queue(lines[0], lines.len() > 2, asking)],
            left_m: lines[1..].iter().rev().map(ends_m).collect(),
            due_ns: 0,
        });
        true
    }

    /// Continues a detour once the vehicle has accepted its previous line.
    fn lead(&mut self, tag: u64, state: &State, asking: &mut Asking<'_>) {
        let Some(mut detour) = self.detour.take_if(|detour| detour.tags.contains(&tag)) else {
            return;
        };
        match state {
            State::Sent | State::Pending | State::Unknown => {}
            State::Accepted => match detour.left_m.pop() {
                Some(ends_m) => {
                    let ends = ends_m.map(|[east_m, north_m]| EastNorth::new(east_m, north_m));
                    detour.tags.push(self.queue(ends, false, asking));
                }
                None => detour.due_ns = asking.now_ns + asking.random.nanos(2.0, 15.0),
            },
            State::Started if detour.is_before(tag) => {}
            State::Started
            | State::Rejected(_)
            | State::Failed(_)
            | State::TimedOut
            | State::Ended(_)
            | State::Cancelled => return,
        }
        self.detour = Some(detour);
    }

    /// Requests a line at the vehicle's depth, queued or at once. Returns its tag.
    fn queue(&mut self, ends: [EastNorth; 2], at_once: bool, asking: &mut Asking<'_>) -> u64 {
        let level = asking.level();
        let mut line = self.line(ends, level, false, asking);
        if let Request::Trackline(line) = &mut line {
            line.interrupt = at_once;
        }
        let tag = line.tag().unwrap_or_default();
        self.ask(line, asking);
        tag
    }

    /// Requests a line to behind an obstacle, or from there, so that the way there or back is its main part. Returns
    /// false without an obstacle.
    fn hidden_line(&mut self, asking: &mut Asking<'_>) -> bool {
        let Some([hidden, seen]) = asking.behind_something() else {
            return false;
        };
        let ends = asking.random.pick([[hidden, seen], [seen, hidden]]);
        let level = asking.level();
        let line = self.line(ends, level, false, asking);
        self.ask(line, asking);
        true
    }

    /// The end of a line from one point towards another, as far as the fence allows.
    fn creep(&mut self, from: EastNorth, to: EastNorth, asking: &mut Asking<'_>) -> EastNorth {
        let (mut fits, mut fits_not) = (0.0, 1.0);
        let way = to - from;
        for _ in 0..6 {
            let share = (fits + fits_not) / 2.0;
            let vertical = asking.level();
            let line = self.line([from, from + way * share], vertical, false, asking);
            *(if asking.fits(&line) { &mut fits } else { &mut fits_not }) = share;
        }
        let share = asking.random.pick([fits, fits, fits_not]);
        from + way * share
    }

    fn bold_circle(&mut self, asking: &mut Asking<'_>) {
        let radius_m = asking.random.within(8.0, 400.0);
        let orbits = asking.random.pick([0.25, 1.0, 3.0, 20.0, 120.0]);
        if asking.random.chance(0.3) {
            return self.ring_at_the_border(asking);
        }
        let centre = match asking.random.below(3) {
            0 => asking.anywhere(),
            1 => asking.corner(1.5 * radius_m),
            // The circle touches the box's edge.
            _ => {
                let edge = asking.nearest_edge();
                let back_m = radius_m + asking.random.within(-20.0, 80.0);
                edge.offset(edge.bearing_deg(asking.middle()), back_m)
            }
        };
        let entry = asking.random.chance(0.5);
        let ring = Ring {
            centre,
            radius_m,
            orbits: asking.random.sign() * orbits,
            entry_deg: entry.then(|| asking.random.within(0.0, 360.0)),
        };
        let bold = asking.random.chance(0.4);
        let vertical = asking.vertical(bold);
        let circle = self.circle(ring, vertical, bold, asking);
        self.ask(circle, asking);
    }

    /// A circle that is entered and left well inside, with its far side close to the border or beyond.
    fn ring_at_the_border(&mut self, asking: &mut Asking<'_>) {
        let radius_m = asking.random.within(18.0, 45.0);
        let middle = asking.middle();
        let reach_m = middle.distance_m(asking.nearest_edge());
        let outwards_deg = asking.random.within(0.0, 360.0);
        let centre = middle.offset(outwards_deg, reach_m * asking.random.within(0.6, 0.95) - radius_m);
        let ring = Ring {
            centre,
            radius_m,
            orbits: asking.random.sign(),
            entry_deg: Some((outwards_deg + 180.0).rem_euclid(360.0)),
        };
        let vertical = asking.level();
        let circle = self.circle(ring, vertical, false, asking);
        self.ask(circle, asking);
    }

    /// Requests more inserts at once than may be open.
    fn burst(&mut self, line: bool, asking: &mut Asking<'_>) {
        for _ in 0..asking.random.within(3.0, 9.0) as u32 {
            if line {
                self.modest_line(asking);
            } else {
                self.modest_circle(asking);
            }
        }
    }
}

/// The values of a circle.
#[derive(Clone, Copy, Debug)]
struct Ring {
    centre: EastNorth,
    radius_m: f64,
    orbits: f64,
    entry_deg: Option<f64>,
}
