//! Leases: phases in which the plugin steers alternate with phases in which its inserts are flown.

use backseat_sdk::units::EastNorth;
use backseat_sdk::{Modify, Request, State, Vertical};
use serde::{Deserialize, Serialize};

use crate::asking::Asking;
use crate::config::Kind;

const SECOND_NS: u64 = 1_000_000_000;
/// Within this distance a goal counts as reached, metres.
const NEAR_M: f64 = 30.0;

/// Whether the plugin steers, and where to.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Steering {
    leasing: bool,
    /// Whether the vehicle flew an insert of the plugin in the last step.
    flying: bool,
    /// When the phase ends.
    until_ns: u64,
    drive: Option<Drive>,
    /// No request is made before this time.
    next_ns: u64,
    /// Refusals since a request was last accepted.
    refused: u32,
    /// Whether a lease has been accepted.
    steered: bool,
}

/// A course that is kept by one lease after another until something ends it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Drive {
    tag: u64,
    heading_deg: f64,
    depth_m: Option<f64>,
    altitude_m: f64,
    speed_mps: f64,
    /// The next two goals, east and north in metres.
    goals_m: [Option<[f64; 2]>; 2],
    bold: bool,
    /// When it is renewed.
    renew_ns: u64,
    /// When the course has been kept long enough.
    until_ns: u64,
}

impl Drive {
    fn request(&self, duration_ns: u64) -> Request {
        let vertical = match self.depth_m {
            Some(metres) => Vertical::Depth(metres),
            None => Vertical::Altitude(self.altitude_m),
        };
        Request::Modify(Modify {
            tag: self.tag,
            heading: self.heading_deg,
            vertical,
            speed: self.speed_mps,
            duration_ns,
        })
    }

    const fn with(mut self, vertical: Vertical) -> Self {
        match vertical {
            Vertical::Depth(metres) => self.depth_m = Some(metres),
            Vertical::Altitude(metres) => (self.depth_m, self.altitude_m) = (None, metres),
        }
        self
    }
}

impl Steering {
    /// `flying`: the vehicle is flying an insert of the plugin. `settled`: it has accepted one, so that there is time
    /// for other goals.
    pub(crate) fn step(&mut self, flying: bool, settled: bool, asking: &mut Asking<'_>) {
        if !asking.config.asks_for(Kind::Modify) {
            return;
        }
        let takes_off = flying && !self.flying;
        self.flying = flying;
        let roams = self.drive.is_some_and(|drive| drive.goals_m[0].is_some());
        if asking.now_ns >= self.until_ns && !roams || self.leasing && takes_off && asking.random.chance(0.8) {
            self.change_phase(asking);
        }
        if !self.leasing {
            return;
        }
        match self.drive {
            None if asking.now_ns >= self.next_ns => {
                let roams = settled && asking.random.chance(0.2);
                match roams.then(|| draw_roaming(asking)).flatten() {
                    Some(drive) => self.ask(drive, asking),
                    None => self.begin(asking),
                }
            }
            None => {}
            Some(drive) if asking.now_ns >= drive.until_ns => self.end(asking),
            Some(drive) => self.go_on(drive, asking),
        }
    }

    /// Takes in the outcome of a request.
    pub(crate) fn hear(&mut self, tag: u64, state: &State, asking: &mut Asking<'_>) {
        let Some(drive) = self.drive.filter(|drive| drive.tag == tag) else {
            return;
        };
        match state {
            State::Sent | State::Pending | State::Started => {}
            State::Accepted => {
                self.refused = 0;
                self.steered = true;
            }
            State::Rejected(_)
            | State::Failed(_)
            | State::TimedOut
            | State::Unknown
            | State::Ended(_)
            | State::Cancelled => {
                self.drive = None;
                if matches!(state, State::Rejected(_)) {
                    self.refused += 1;
                }
                // Stopped at the fence, it tries again; on the way to a goal, it takes another direction.
                if drive.goals_m[0].is_some() && asking.now_ns < drive.until_ns {
                    self.drive = Some(drive);
                    self.refused = 0;
                } else if drive.bold && asking.random.chance(0.3) {
                    let tag = asking.next_tag();
                    self.ask(Drive { tag, ..drive }, asking);
                } else {
                    self.next_ns = asking.now_ns + asking.random.nanos(0.0, 3.0);
                }
            }
        }
    }

    /// A new instance does not know what was open.
    pub(crate) fn restart(&mut self) {
        self.drive = None;
    }

    fn change_phase(&mut self, asking: &mut Asking<'_>) {
        let share = asking.config.modify_share;
        // An insert under a lease never ends, because the lease modifies it too.
        let lets_fly = self.flying && share < 1.0 && asking.random.chance(0.7);
        self.leasing = (!self.leasing && share > 0.0 || share >= 1.0) && !lets_fly;
        if !self.leasing && self.drive.take().is_some() && asking.random.chance(0.5) {
            // Otherwise it lapses.
            asking.ask(Request::EndModify);
        }
        let cycle_s = asking.random.within(40.0, 160.0);
        let phase_s = if self.leasing { share } else { 1.0 - share } * cycle_s;
        self.until_ns = asking.now_ns + (phase_s.max(5.0) * 1e9) as u64;
    }

    fn begin(&mut self, asking: &mut Asking<'_>) {
        // Until a request has been accepted, at least every second one is modest.
        let bold = asking.is_bold() && (self.steered || self.refused % 2 == 1);
        let drive = if bold {
            self.draw_bold(asking)
        } else {
            self.draw_modest(asking)
        };
        self.ask(drive, asking);
    }

    fn draw_modest(&self, asking: &mut Asking<'_>) -> Drive {
        let tag = asking.next_tag();
        let mut drive = Drive {
            tag,
            heading_deg: asking.fix.heading_deg,
            depth_m: None,
            altitude_m: 0.0,
            speed_mps: asking.config.speed_mps[0],
            goals_m: [None; 2],
            bold: false,
            renew_ns: 0,
            until_ns: asking.now_ns + asking.random.nanos(3.0, 60.0),
        }
        .with(asking.level());
        if self.refused >= 3 && asking.random.chance(0.5) {
            // Straight ahead and slowly, which is where the front seat goes anyway.
            return drive;
        }
        for _ in 0..3 {
            let inwards_deg = asking.fix.local().bearing_deg(asking.middle());
            let aside_deg = asking.random.within(-120.0, 120.0);
            drive.heading_deg = wrap_deg(inwards_deg + aside_deg);
            drive.speed_mps = asking.speed(false);
            drive = drive.with(asking.vertical(false));
            if asking.fits(&drive.request(5 * SECOND_NS)) {
                break;
            }
        }
        drive
    }

    /// Towards the fence, a corner of the box, or anywhere, until the monitor stops it.
    fn draw_bold(&self, asking: &mut Asking<'_>) -> Drive {
        let here = asking.fix.local();
        let heading_deg = match asking.random.below(4) {
            0 => here.bearing_deg(asking.nearest_edge()),
            1 => here.bearing_deg(asking.corner(0.0)),
            2 => here.bearing_deg(asking.anywhere()),
            _ => asking.random.within(0.0, 360.0),
        };
        let tag = asking.next_tag();
        let drive = Drive {
            tag,
            heading_deg: wrap_deg(heading_deg),
            depth_m: None,
            altitude_m: 0.0,
            speed_mps: asking.speed(true),
            goals_m: [None; 2],
            bold: true,
            renew_ns: 0,
            until_ns: asking.now_ns + asking.random.nanos(20.0, 600.0),
        };
        let bold = asking.random.chance(0.4);
        drive.with(asking.vertical(bold))
    }

    fn go_on(&mut self, mut drive: Drive, asking: &mut Asking<'_>) {
        if drive.goals_m[0].is_some() {
            if asking.now_ns >= drive.renew_ns {
                drive.tag = asking.next_tag();
                let drive = turned(drive, asking);
                if drive.until_ns == 0 {
                    // The goal is reached, so the lease ends.
                    self.drive = None;
                    self.next_ns = asking.now_ns + asking.random.nanos(5.0, 40.0);
                    return;
                }
                self.ask(drive, asking);
                if let Some(drive) = &mut self.drive {
                    drive.renew_ns = asking.now_ns + asking.random.nanos(1.0, 6.0);
                }
            }
            return;
        }
        // Sometimes it turns, dives or accelerates on the way.
        let turns = asking.random.chance(0.06);
        if asking.now_ns < drive.renew_ns && !turns {
            return;
        }
        if turns {
            match asking.random.below(4) {
                0 => drive.speed_mps = asking.speed(drive.bold),
                1 => drive = drive.with(asking.vertical(drive.bold)),
                2 => drive.heading_deg = wrap_deg(drive.heading_deg + asking.random.within(-180.0, 180.0)),
                _ => drive.heading_deg = wrap_deg(drive.heading_deg + asking.random.within(-20.0, 20.0)),
            }
        }
        if asking.random.chance(0.5) {
            drive.tag = asking.next_tag();
        }
        if asking.dares(0.05) {
            // It makes more changes in a step than a vehicle accepts in a second.
            for _ in 0..8 {
                drive.heading_deg = wrap_deg(drive.heading_deg + asking.random.within(-10.0, 10.0));
                self.ask(drive, asking);
            }
        }
        self.ask(drive, asking);
    }

    fn ask(&mut self, mut drive: Drive, asking: &mut Asking<'_>) {
        let longest_s = if asking.dares(0.05) { 90.0 } else { 60.0 };
        let duration_ns = match asking.random.below(3) {
            0 => asking.random.nanos(2.0, 5.0),
            1 => asking.random.nanos(5.0, 20.0),
            _ => asking.random.nanos(20.0, longest_s),
        };
        // Usually it is renewed in time; sometimes it lapses first.
        let share = asking.random.within(0.3, 1.2);
        drive.renew_ns = asking.now_ns + (duration_ns as f64 * share) as u64;
        self.drive = Some(drive);
        asking.ask(drive.request(duration_ns));
    }

    fn end(&mut self, asking: &mut Asking<'_>) {
        self.drive = None;
        self.next_ns = asking.now_ns + asking.random.nanos(0.0, 5.0);
        match asking.random.below(3) {
            0 => asking.ask(Request::EndModify),
            1 => {
                // An end and a new beginning in the same step.
                asking.ask(Request::EndModify);
                self.begin(asking);
            }
            _ => {}
        }
    }
}

/// Towards a point with a view behind an obstacle, and then behind it.
fn draw_roaming(asking: &mut Asking<'_>) -> Option<Drive> {
    let [hidden, seen] = asking.behind_something()?;
    let goal = |at: EastNorth| Some([at.east_m, at.north_m]);
    let drive = Drive {
        tag: asking.next_tag(),
        heading_deg: asking.fix.heading_deg,
        depth_m: None,
        altitude_m: 0.0,
        speed_mps: asking.speed(false),
        goals_m: [goal(seen), goal(hidden)],
        bold: false,
        renew_ns: 0,
        until_ns: asking.now_ns + asking.random.nanos(60.0, 300.0),
    };
    Some(turned(drive.with(asking.level()), asking))
}

/// Goes on to the next goal when one is reached, on the closest course that the fence allows. Ends if there is none.
fn turned(mut drive: Drive, asking: &Asking<'_>) -> Drive {
    let here = asking.fix.local();
    let at = |[east_m, north_m]: [f64; 2]| EastNorth::new(east_m, north_m);
    if drive.goals_m[0].is_some_and(|goal_m| here.distance_m(at(goal_m)) < NEAR_M) {
        drive.goals_m = [drive.goals_m[1], None];
    }
    let Some(goal_m) = drive.goals_m[0] else {
        drive.until_ns = 0;
        return drive;
    };
    let straight_deg = here.bearing_deg(at(goal_m));
    for turn_deg in [0.0, 25.0, -25.0, 50.0, -50.0, 80.0, -80.0, 120.0, -120.0] {
        drive.heading_deg = wrap_deg(straight_deg + turn_deg);
        if asking.fits(&drive.request(5 * SECOND_NS)) {
            break;
        }
    }
    drive
}

fn wrap_deg(heading_deg: f64) -> f64 {
    let wrapped = heading_deg.rem_euclid(360.0);
    // The remainder of a small negative number rounds to the divisor.
    if wrapped < 360.0 { wrapped } else { 0.0 }
}
