use backseat_sdk::units::{EastNorth, LocalFrame, Position};
use backseat_sdk::{Navigation, Request, StepInput, Trackline, Vertical};
use serde::{Deserialize, Serialize};

use crate::config::Config;
use crate::random::Random;

/// More requests in a step would be a failure of the plugin, and are never needed.
const REQUESTS_MAX: usize = 100;
/// Even at full boldness some requests are modest, so that the vehicle has something to fly.
const BOLDNESS_MAX: f64 = 0.85;

/// The vehicle's last known position, which the plugin remembers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Fix {
    latitude: f64,
    longitude: f64,
    east_m: f64,
    north_m: f64,
    pub(crate) depth_m: f64,
    pub(crate) heading_deg: f64,
    /// Horizontal, vertical and distance relative to the hull.
    pub(crate) hull_m: Option<[f64; 3]>,
    /// X and y in the vehicle's inertial frame.
    pub(crate) bottom_m: Option<[f64; 2]>,
}

impl Fix {
    pub(crate) fn of(navigation: &Navigation, input: &StepInput) -> Self {
        Self {
            latitude: navigation.position.latitude,
            longitude: navigation.position.longitude,
            east_m: navigation.east,
            north_m: navigation.north,
            depth_m: navigation.depth,
            heading_deg: navigation.heading,
            hull_m: input
                .relative
                .map(|relative| [relative.horizontal, relative.vertical, relative.distance]),
            bottom_m: input.cartesian.map(|cartesian| [cartesian.x, cartesian.y]),
        }
    }

    pub(crate) const fn local(&self) -> EastNorth {
        EastNorth::new(self.east_m, self.north_m)
    }

    /// Converts a point of the mission's local frame to latitude and longitude.
    pub(crate) fn position_of(&self, point: EastNorth) -> backseat_sdk::Position {
        match Position::from_deg(self.latitude, self.longitude) {
            Ok(here) => LocalFrame::new(here).to_position(point - self.local()).into(),
            Err(_) => backseat_sdk::Position {
                latitude: self.latitude,
                longitude: self.longitude,
            },
        }
    }
}

/// The requests of one step, with what is known and the source of random numbers.
pub(crate) struct Asking<'a> {
    pub(crate) config: &'a Config,
    pub(crate) random: &'a mut Random,
    pub(crate) tag: &'a mut u64,
    pub(crate) fix: Fix,
    pub(crate) now_ns: u64,
    /// Whether the fence allows a request, as far as a plugin can ask.
    pub(crate) fits: fn(&Request) -> bool,
    pub(crate) requests: &'a mut Vec<Request>,
}

impl Asking<'_> {
    pub(crate) fn ask(&mut self, request: Request) {
        if self.requests.len() < REQUESTS_MAX {
            self.requests.push(request);
        }
    }

    pub(crate) const fn next_tag(&mut self) -> u64 {
        *self.tag += 1;
        *self.tag
    }

    pub(crate) fn is_bold(&mut self) -> bool {
        self.random.chance(self.config.boldness.min(BOLDNESS_MAX))
    }

    /// True with a probability that grows with the boldness.
    pub(crate) fn dares(&mut self, share: f64) -> bool {
        self.random.chance(share * self.config.boldness)
    }

    pub(crate) fn fits(&self, request: &Request) -> bool {
        (self.fits)(request)
    }

    /// A random point of the box, which may be outside of the fence.
    pub(crate) fn anywhere(&mut self) -> EastNorth {
        let (config, random) = (self.config, &mut *self.random);
        EastNorth::new(
            random.within(config.east_min_m, config.east_max_m),
            random.within(config.north_min_m, config.north_max_m),
        )
    }

    pub(crate) fn middle(&self) -> EastNorth {
        let config = self.config;
        EastNorth::new(
            (config.east_min_m + config.east_max_m) / 2.0,
            (config.north_min_m + config.north_max_m) / 2.0,
        )
    }

    /// Two points with an obstacle between: the fence allows no straight path to the first one. It allows one to the
    /// second, which is close to the vehicle's path, and from there to the first.
    pub(crate) fn behind_something(&mut self) -> Option<[EastNorth; 2]> {
        let (here, ahead_deg, vertical) = (self.fix.local(), self.fix.heading_deg, self.level());
        for _ in 0..8 {
            let side_deg = ahead_deg + 90.0 * self.random.sign();
            let ahead = here.offset(ahead_deg, self.random.within(-150.0, 250.0));
            let seen = ahead.offset(side_deg, self.random.within(5.0, 90.0));
            let hidden = seen.offset(
                side_deg + self.random.within(-90.0, 90.0),
                self.random.within(60.0, 250.0),
            );
            if self.fits_line([seen, hidden], vertical) && !self.fits_line([hidden, seen], vertical) {
                return Some([hidden, seen]);
            }
        }
        None
    }

    /// Three lines, to be flown one after the other. The fence allows no straight path from the end of the first to the
    /// start of the third; the second leads around the obstacle.
    pub(crate) fn round_something(&mut self) -> Option<[[EastNorth; 2]; 3]> {
        let (here, ahead_deg, vertical) = (self.fix.local(), self.fix.heading_deg, self.level());
        for _ in 0..12 {
            let start = here.offset(
                ahead_deg + self.random.within(-40.0, 40.0),
                self.random.within(20.0, 60.0),
            );
            let end = start.offset(
                ahead_deg + self.random.within(-60.0, 60.0),
                self.random.within(50.0, 120.0),
            );
            let on_deg = ahead_deg + self.random.within(-100.0, 100.0);
            let hidden = end.offset(on_deg, self.random.within(60.0, 300.0));
            let aside_deg = on_deg + 90.0 * self.random.sign();
            let [before, after] = [0.4, 0.6].map(|share| end + (hidden - end) * share);
            let seen = before.offset(aside_deg, self.random.within(30.0, 200.0));
            let fits = |ends| self.fits_line(ends, vertical);
            if !fits([before, after]) && fits([start, end]) && fits([end, seen]) && fits([seen, hidden]) {
                let half = end + (seen - end) * 0.5;
                return Some([[start, end], [half, seen], [hidden, seen]]);
            }
        }
        None
    }

    /// Whether the fence allows a line at modest speed, and the path to its start.
    fn fits_line(&self, [start, end]: [EastNorth; 2], vertical: Vertical) -> bool {
        self.fits(&Request::Trackline(Trackline {
            tag: 0,
            start: self.fix.position_of(start),
            end: self.fix.position_of(end),
            vertical,
            speed: self.config.speed_mps[0],
            interrupt: false,
        }))
    }

    /// A corner of the box, moved by up to `inset_m` towards the middle or away from it on each axis.
    pub(crate) fn corner(&mut self, inset_m: f64) -> EastNorth {
        let config = self.config;
        let east_m = self.random.within(-0.2 * inset_m, inset_m);
        let north_m = self.random.within(-0.2 * inset_m, inset_m);
        EastNorth::new(
            self.random
                .pick([config.east_min_m + east_m, config.east_max_m - east_m]),
            self.random
                .pick([config.north_min_m + north_m, config.north_max_m - north_m]),
        )
    }

    /// The point of the box's edge closest to the vehicle.
    pub(crate) fn nearest_edge(&self) -> EastNorth {
        let (config, here) = (self.config, self.fix.local());
        let sides = [
            EastNorth::new(config.east_min_m, here.north_m),
            EastNorth::new(config.east_max_m, here.north_m),
            EastNorth::new(here.east_m, config.north_min_m),
            EastNorth::new(here.east_m, config.north_max_m),
        ];
        let nearer = |a: EastNorth, b: EastNorth| if b.distance_m(here) < a.distance_m(here) { b } else { a };
        sides.into_iter().reduce(nearer).unwrap_or(here)
    }

    /// A depth or an altitude.
    pub(crate) fn vertical(&mut self, bold: bool) -> Vertical {
        let altitude_m = self.config.altitude_m.filter(|_| self.random.chance(0.3));
        let (range_m, past_m) = match altitude_m {
            Some(range_m) => (range_m, 1.0),
            None => (self.config.depth_m, 3.0),
        };
        let metres = self.figure(range_m, past_m, bold).max(0.0);
        if altitude_m.is_some() {
            Vertical::Altitude(metres)
        } else {
            Vertical::Depth(metres)
        }
    }

    /// The vehicle's depth, as far as the modest depths allow.
    pub(crate) fn level(&self) -> Vertical {
        let [min_m, max_m] = self.config.depth_m;
        Vertical::Depth(self.fix.depth_m.clamp(min_m, max_m))
    }

    pub(crate) fn speed(&mut self, bold: bool) -> f64 {
        self.figure(self.config.speed_mps, 0.1, bold).max(0.0)
    }

    fn figure(&mut self, [min, max]: [f64; 2], past: f64, bold: bool) -> f64 {
        let inside = self.random.within(min, max);
        if !bold {
            inside
        } else if self.random.chance(0.1) {
            self.random.pick([min - past, max + past])
        } else {
            self.random.pick([min, max, inside])
        }
    }
}
