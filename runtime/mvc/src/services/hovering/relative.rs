use backseat_units::EastNorth;
use backseat_units::math::{sin_cos, wrap_180, wrap_360};
use backseat_world::Stream;

use crate::file::HoveringConfig;
use crate::vehicle::Vehicle;
use crate::vehicle::ship::Ship;

const SECONDS_PER_H: f64 = 3600.0;

/// Relative navigation: dead reckoning from a reference point, with x towards the target and y to the right of it. It
/// uses the velocity that BFNVR reports, and drifts.
///
/// With a ship, the reference point is midships of its inspected side, at the waterline. Without one, it is where the
/// vehicle started, and x points where the vehicle pointed. Both bearings count clockwise, the relative one from x.
#[derive(Clone, Debug)]
pub(crate) struct Relative {
    origin: EastNorth,
    x_axis_deg: f64,
    sin: f64,
    cos: f64,
    /// Zero of the inertial bearing: the direction in which the vehicle pointed when it was switched on.
    zero_deg: f64,
    stream: Stream,
    drift_step_m: f64,
    bearing_step_deg: f64,
    /// Steps of the vehicle a second; `until_drift` is the number of steps until the next step of the drift.
    tick_hz: u32,
    until_drift: u32,
    /// Sine and cosine of the error of the relative bearing.
    error_sin: f64,
    error_cos: f64,
    true_x_m: f64,
    true_y_m: f64,
    x_m: f64,
    y_m: f64,
    /// Error of the inertial bearing: its drift, and what BPRBO has added.
    inertial_error_deg: f64,
    /// By how much BPRNS has moved the relative bearing against the inertial one.
    alignment_deg: f64,
}

impl Relative {
    pub(crate) fn new(config: &HoveringConfig, ship: Option<Ship>, vehicle: &Vehicle, tick_hz: u32, seed: u64) -> Self {
        let (origin, x_axis_deg) = ship.map_or((vehicle.motion().at, vehicle.motion().heading_deg), |ship| {
            (ship.reference(), ship.inward_deg())
        });
        let (sin, cos) = sin_cos(x_axis_deg.to_radians());
        let steps = SECONDS_PER_H.sqrt();
        let mut relative = Self {
            origin,
            x_axis_deg,
            sin,
            cos,
            zero_deg: vehicle.motion().heading_deg,
            stream: Stream::new(seed, "relative navigation"),
            drift_step_m: config.drift_m_per_sqrt_h / steps,
            bearing_step_deg: config.bearing_drift_deg_per_sqrt_h / steps,
            tick_hz: tick_hz.max(1),
            until_drift: tick_hz.max(1),
            error_sin: 0.0,
            error_cos: 1.0,
            true_x_m: 0.0,
            true_y_m: 0.0,
            x_m: 0.0,
            y_m: 0.0,
            inertial_error_deg: 0.0,
            alignment_deg: 0.0,
        };
        (relative.true_x_m, relative.true_y_m) = relative.project(vehicle.motion().at - origin);
        (relative.x_m, relative.y_m) = (relative.true_x_m, relative.true_y_m);
        relative
    }

    /// Adds one step of the vehicle: the distance that it believes to have moved, turned by the error of its bearing,
    /// and the drift.
    pub(crate) fn reckon(&mut self, vehicle: &Vehicle, way: EastNorth) {
        (self.true_x_m, self.true_y_m) = self.project(vehicle.motion().at - self.origin);
        let (way_x_m, way_y_m) = self.project(way);
        self.x_m += way_x_m * self.error_cos - way_y_m * self.error_sin;
        self.y_m += way_x_m * self.error_sin + way_y_m * self.error_cos;
        self.until_drift -= 1;
        if self.until_drift == 0 {
            // One step of the drift a second is fine enough, and saves random numbers.
            self.until_drift = self.tick_hz;
            self.x_m += self.drift_step_m * self.stream.gaussian();
            self.y_m += self.drift_step_m * self.stream.gaussian();
            self.inertial_error_deg += self.bearing_step_deg * self.stream.gaussian();
            self.turn();
        }
    }

    /// Where the vehicle believes to be, metres along x and y.
    pub(crate) const fn believed(&self) -> (f64, f64) {
        (self.x_m, self.y_m)
    }

    /// Where it truly is, metres along x and y.
    pub(crate) const fn truth(&self) -> (f64, f64) {
        (self.true_x_m, self.true_y_m)
    }

    /// The bearing that it believes to have, degrees from x, in [-180, 180).
    pub(crate) fn bearing_deg(&self, vehicle: &Vehicle) -> f64 {
        wrap_180(self.true_bearing_deg(vehicle) + self.bearing_error_deg())
    }

    /// The bearing that it truly has, degrees from x, in [-180, 180).
    pub(crate) fn true_bearing_deg(&self, vehicle: &Vehicle) -> f64 {
        wrap_180(vehicle.motion().heading_deg - self.x_axis_deg)
    }

    /// The inertial bearing that it believes to have, degrees, in [0, 360).
    pub(crate) fn inertial_deg(&self, vehicle: &Vehicle) -> f64 {
        wrap_360(vehicle.motion().heading_deg - self.zero_deg + self.inertial_error_deg)
    }

    /// Distance from the target, metres: what the DVL measures (`ship_m`), otherwise from dead reckoning.
    pub(crate) fn distance_m(&self, ship_m: Option<f64>) -> f64 {
        ship_m.unwrap_or(-self.x_m)
    }

    /// BPRNS (SPI 8.8): sets the believed place and relative bearing. Returns by how much the place has moved.
    pub(crate) fn reset(&mut self, x_m: f64, y_m: f64, bearing_deg: f64, vehicle: &Vehicle) -> (f64, f64) {
        let moved = (x_m - self.x_m, y_m - self.y_m);
        (self.x_m, self.y_m) = (x_m, y_m);
        self.alignment_deg = wrap_180(bearing_deg - self.true_bearing_deg(vehicle) - self.inertial_error_deg);
        self.turn();
        moved
    }

    /// BPRBO (SPI 8.9): adds to the inertial bearing, and so to the relative one.
    pub(crate) fn offset_bearing(&mut self, offset_deg: f64) {
        self.inertial_error_deg = wrap_180(self.inertial_error_deg + offset_deg);
        self.turn();
    }

    /// The true velocity over ground (east, north) when the vehicle believes to move along x and y with this velocity.
    pub(crate) fn over_ground(&self, x_mps: f64, y_mps: f64) -> (f64, f64) {
        let (sin, cos) = (self.error_sin, self.error_cos);
        let (x_mps, y_mps) = (x_mps * cos + y_mps * sin, y_mps * cos - x_mps * sin);
        (x_mps * self.sin + y_mps * self.cos, x_mps * self.cos - y_mps * self.sin)
    }

    /// The true heading, degrees from the frame's north, when the vehicle believes to have this relative bearing.
    pub(crate) fn heading_deg(&self, bearing_deg: f64) -> f64 {
        self.x_axis_deg + bearing_deg - self.bearing_error_deg()
    }

    fn turn(&mut self) {
        (self.error_sin, self.error_cos) = sin_cos(self.bearing_error_deg().to_radians());
    }

    fn bearing_error_deg(&self) -> f64 {
        self.inertial_error_deg + self.alignment_deg
    }

    fn project(&self, way: EastNorth) -> (f64, f64) {
        (
            way.east_m * self.sin + way.north_m * self.cos,
            way.east_m * self.cos - way.north_m * self.sin,
        )
    }
}
