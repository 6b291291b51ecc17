use backseat_sdk::sonar::coverage::{CoverageMap, LineReach, Look, NoiseFloor, PingStack, Quality, Strip, Strips};
use backseat_sdk::units::{EastNorth, LocalFrame, Position};
use backseat_sdk::{AltitudeSource, SonarPing, Swath};
use serde::{Deserialize, Serialize};

const SECOND_NS: u64 = 1_000_000_000;
/// Pings are taken together over this time: several of them, but a short way.
const STACK_NS: u64 = 2 * SECOND_NS;
/// Looks that are farther apart make no strip, metres.
const APART_MAX_M: f64 = 25.0;
/// Without a look by pings for so long, the reported swath is used.
const SWATH_AFTER_NS: u64 = 6 * SECOND_NS;
/// An altitude from the imagery is used for so long.
const ALTITUDE_NS: u64 = 3 * SECOND_NS;
/// A ping whose navigation is older is not used.
const NAVIGATION_NS: u64 = 2 * SECOND_NS;

/// Turns pings and swaths into strips of the seabed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Observer {
    stack: PingStack,
    stack_from_ns: u64,
    strips: Strips,
    /// What the present line has seen.
    pub(crate) reach: LineReach,
    looked_ns: u64,
    /// The newest altitude that the imagery gave, and when.
    first_return: Option<(u64, f64)>,
    /// The newest altitude of a look, metres.
    pub(crate) altitude_m: Option<f64>,
}

/// A pose and the time when the vehicle had it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pose {
    pub(crate) at_ns: u64,
    pub(crate) at: EastNorth,
    pub(crate) bearing_deg: f64,
}

impl Observer {
    pub(crate) fn new(turn_max_dps: f64) -> Self {
        Self {
            stack: PingStack::default(),
            stack_from_ns: 0,
            strips: Strips::new(turn_max_dps, APART_MAX_M),
            reach: LineReach::default(),
            looked_ns: 0,
            first_return: None,
            altitude_m: None,
        }
    }

    /// Takes in a ping. Returns the strip that it completes.
    pub(crate) fn ping(
        &mut self,
        ping: &SonarPing,
        now_ns: u64,
        frame: &LocalFrame,
        quality: &Quality,
        noise: Option<&NoiseFloor>,
    ) -> Option<Strip> {
        let navigation = ping.navigation.as_ref()?;
        let at_ns = now_ns.saturating_sub(ping.age_ns);
        if navigation.before_ping_ns > NAVIGATION_NS {
            return None;
        }
        let position = Position::try_from(navigation.position).ok()?;
        let altitude_m = navigation.altitude.or_else(|| {
            self.first_return
                .filter(|(seen_ns, _)| at_ns.saturating_sub(*seen_ns) <= ALTITUDE_NS)
                .map(|(_, altitude_m)| altitude_m)
        })?;
        // Pings from before a pause belong to no stack with this one.
        if self.stack.pings() == 0 || at_ns.saturating_sub(self.stack_from_ns) > 2 * STACK_NS {
            self.stack.clear();
            self.stack_from_ns = at_ns;
        }
        self.stack.add(ping);
        if at_ns.saturating_sub(self.stack_from_ns) < STACK_NS {
            return None;
        }
        let seen = self.stack.look(altitude_m, quality, noise);
        self.stack.clear();
        let seen = seen?;
        self.looked_ns = now_ns;
        self.altitude_m = Some(altitude_m);
        self.strips.next(Look {
            at_ns,
            at: frame.to_local(position),
            bearing_deg: navigation.heading - frame.convergence_deg(position),
            port: seen.port,
            starboard: seen.starboard,
        })
    }

    /// Takes in a reported swath with the vehicle's pose. Returns the strip that it completes; none while pings come.
    pub(crate) fn swath(&mut self, swath: &Swath, now_ns: u64, pose: Pose, quality: &Quality) -> Option<Strip> {
        if let (AltitudeSource::FirstReturn, Some(altitude_m)) = (swath.source, swath.altitude) {
            self.first_return = Some((now_ns, altitude_m));
        }
        if self.looked_ns > 0 && now_ns.saturating_sub(self.looked_ns) < SWATH_AFTER_NS {
            return None;
        }
        self.altitude_m = swath.altitude.or(self.altitude_m);
        let look = Look::of_swath(swath, quality.nadir_deg, pose.at_ns, pose.at, pose.bearing_deg)?;
        self.strips.next(look)
    }

    /// Marks a strip in the map, and remembers its reach if the vehicle is on its line.
    pub(crate) fn mark(&mut self, strip: &Strip, map: &mut CoverageMap, on_line: bool) {
        map.mark(strip);
        if on_line {
            self.reach.note(strip);
        }
    }

    /// Whether looks by pings come.
    pub(crate) const fn has_looked(&self) -> bool {
        self.looked_ns > 0
    }

    /// What it sees now does not count: nothing is transmitted.
    pub(crate) fn interrupt(&mut self) {
        self.stack.clear();
        self.strips.interrupt();
    }
}
