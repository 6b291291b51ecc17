//! The mock moves only as a vehicle can move, and its messages about that agree with each other (SPI 6.1, 6.2, 6.13,
//! 6.14, 6.17 to 6.19). A client that looks for impossible navigation finds none here.

mod inspector;
mod log;
mod mission;
mod record;

use std::collections::BTreeMap;

use backseat_units::math::{hypot, wrap_180};

use mission::Kind;
use record::{Flight, Step, drawn};

/// What a vehicle can do at most: `mock.md` says the same.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    /// Change of the horizontal velocity over ground in a second: by the sharpest turn at full speed, and by the
    /// thruster.
    horizontal_mps2: f64,
    /// The same vertically: full speed times the fastest change of pitch, or a hovering vehicle's thrusters.
    vertical_mps2: f64,
    yaw_dps: f64,
    pitch_dps: f64,
    roll_dps: f64,
    down_mps: f64,
    /// Speed through the water, along the vehicle's axis.
    speed_mps: f64,
    /// The narrowest turn through the water; a hovering vehicle turns on the spot.
    radius_m: f64,
}

impl Kind {
    const fn bounds(self) -> Bounds {
        match self {
            Self::NineInch => Bounds {
                horizontal_mps2: 1.0,
                vertical_mps2: 0.6,
                yaw_dps: 15.0,
                pitch_dps: 12.0,
                roll_dps: 12.0,
                down_mps: 0.85,
                speed_mps: 2.51,
                radius_m: 5.0,
            },
            Self::TwelveInch => Bounds {
                horizontal_mps2: 0.8,
                vertical_mps2: 0.5,
                yaw_dps: 10.0,
                pitch_dps: 10.0,
                roll_dps: 8.0,
                down_mps: 0.65,
                speed_mps: 2.51,
                radius_m: 7.0,
            },
            Self::TwentyOneInch => Bounds {
                horizontal_mps2: 0.5,
                vertical_mps2: 0.4,
                yaw_dps: 6.0,
                pitch_dps: 6.0,
                roll_dps: 5.0,
                down_mps: 0.65,
                speed_mps: 2.31,
                radius_m: 12.0,
            },
            // When the vehicle drifts across a current of half a metre a second, the water takes it along broadside.
            Self::SixDof => Bounds {
                horizontal_mps2: 1.5,
                vertical_mps2: 0.8,
                yaw_dps: 9.0,
                pitch_dps: 15.0,
                roll_dps: 20.0,
                down_mps: 0.9,
                speed_mps: 2.51,
                radius_m: 13.0,
            },
            Self::Hovering => Bounds {
                horizontal_mps2: 0.6,
                vertical_mps2: 0.6,
                yaw_dps: 20.0,
                pitch_dps: 0.01,
                roll_dps: 12.0,
                down_mps: 0.35,
                speed_mps: 0.76,
                radius_m: 0.0,
            },
        }
    }
}

/// Standard deviations of the readings, as the missions here have them.
#[derive(Clone, Copy, Debug)]
struct Noise {
    position_m: f64,
    drift_m_per_sqrt_s: f64,
    velocity_mps: f64,
    depth_m: f64,
    angle_deg: f64,
    altitude_m: f64,
}

impl Noise {
    fn of(exact: bool) -> Self {
        let times = if exact { 0.0 } else { 1.0 };
        Self {
            position_m: 0.03 * times,
            drift_m_per_sqrt_s: 3.5 / 60.0 * times,
            velocity_mps: 0.005 * times,
            depth_m: 0.01 * times,
            angle_deg: 0.05 * times,
            altitude_m: 0.05 * times,
        }
    }
}

/// The hundred thousand readings of these flights do not exceed this many standard deviations.
const SIGMAS: f64 = 5.5;

/// For each check the worst value, as a share of what is allowed, and where it was.
#[derive(Debug, Default)]
struct Worst(BTreeMap<&'static str, (f64, String)>);

impl Worst {
    fn look(&mut self, what: &'static str, value: f64, most: f64, flight: &Flight, step: &Step) {
        let share = value.abs() / most;
        let worst = self.0.entry(what).or_insert_with(|| (0.0, String::new()));
        let share = if share.is_nan() { f64::INFINITY } else { share };
        if share > worst.0 {
            let told = format!("{value:.4} of {most:.4} at {:.1} s of {}", step.at_s, flight.name);
            *worst = (share, told);
        }
    }

    /// Panics if anything is beyond what is allowed, and names that first and then everything that was checked.
    fn assert(&self) {
        let told = |(what, (share, told)): (&&str, &(f64, String))| format!("{share:6.2} {what}: {told}\n");
        let all: String = self.0.iter().map(told).collect();
        let beyond: String = self.0.iter().filter(|(_, (share, _))| *share > 1.0).map(told).collect();
        assert!(beyond.is_empty(), "impossible:\n{beyond}of all:\n{all}");
    }
}

fn check(flight: &Flight, noise: Noise, worst: &mut Worst) {
    for pair in flight.steps.windows(2) {
        let [before, now] = pair else { continue };
        successive(flight, noise, before, now, worst);
    }
    for seconds in [5.0, 20.0] {
        windows(flight, noise, seconds, worst);
    }
}

/// Checks one step and the next.
fn successive(flight: &Flight, noise: Noise, before: &Step, now: &Step, worst: &mut Worst) {
    let (dt_s, bounds) = (flight.dt_s, flight.kind.bounds());
    let (was, is) = (&before.velocity, &now.velocity);
    let change_mps = hypot(
        now.truth.east_mps - before.truth.east_mps,
        now.truth.north_mps - before.truth.north_mps,
    );
    worst.look(
        "true acceleration",
        change_mps / dt_s,
        bounds.horizontal_mps2,
        flight,
        now,
    );
    let told_mps = hypot(is.east_mps - was.east_mps, is.north_mps - was.north_mps);
    let told_most_mps = (bounds.horizontal_mps2 + 0.1) * dt_s + SIGMAS * 1.5 * noise.velocity_mps + 0.0002;
    worst.look("told acceleration", told_mps, told_most_mps, flight, now);
    let sinking_mps = is.down_mps - was.down_mps;
    worst.look(
        "vertical acceleration",
        sinking_mps,
        bounds.vertical_mps2 * dt_s + 0.0002,
        flight,
        now,
    );
    worst.look("depth rate", is.down_mps, bounds.down_mps, flight, now);
    // The current is at most half a metre a second.
    let over_ground_mps = hypot(now.truth.east_mps, now.truth.north_mps);
    worst.look("speed", over_ground_mps, bounds.speed_mps + 0.5, flight, now);
    worst.look("yaw rate", is.yaw_rate_dps, bounds.yaw_dps + 0.001, flight, now);
    worst.look("pitch rate", is.pitch_rate_dps, bounds.pitch_dps, flight, now);
    worst.look("roll rate", is.roll_rate_dps, bounds.roll_dps, flight, now);
    // The mean of two rates gives the turn between them, except for how a body's rate curves between two readings.
    let curve_deg = if flight.kind == Kind::SixDof {
        1.6 * dt_s * dt_s
    } else {
        0.0
    };
    let most_deg = SIGMAS * 1.5 * noise.angle_deg + 0.003 + curve_deg;
    let heading_deg = wrap_180(now.navigation.heading.as_deg() - before.navigation.heading.as_deg());
    let turned_deg = heading_deg - 0.5 * dt_s * (was.yaw_rate_dps + is.yaw_rate_dps);
    worst.look("heading by yaw rate", turned_deg, most_deg, flight, now);
    let pitched_deg = now.navigation.pitch_deg - before.navigation.pitch_deg;
    let pitched_deg = pitched_deg - 0.5 * dt_s * (was.pitch_rate_dps + is.pitch_rate_dps);
    worst.look("pitch by its rate", pitched_deg, most_deg, flight, now);
    let rolled_deg = now.navigation.roll_deg - before.navigation.roll_deg;
    let rolled_deg = rolled_deg - 0.5 * dt_s * (was.roll_rate_dps + is.roll_rate_dps);
    // Roll is the quickest of the body's motions.
    worst.look("roll by its rate", rolled_deg, most_deg + 3.0 * curve_deg, flight, now);
    if bounds.radius_m > 0.0 && is.yaw_rate_dps.abs() > 0.5 {
        let radius_m = now.truth.speed_mps.max(0.0) / is.yaw_rate_dps.to_radians().abs();
        worst.look("narrowest turn", bounds.radius_m, radius_m + 0.005, flight, now);
    }
    let own_m = 0.35 + SIGMAS * noise.depth_m;
    if let Some(altitude) = now.navigation.altitude {
        let water_m = altitude.as_m() + now.navigation.depth.as_m();
        let most_m = if noise.depth_m > 0.0 {
            own_m + SIGMAS * noise.altitude_m
        } else {
            0.002
        };
        worst.look(
            "depth and altitude",
            water_m - now.truth.water_depth_m,
            most_m,
            flight,
            now,
        );
    }
}

/// Checks whole windows: what was integrated over a window must be what has changed.
fn windows(flight: &Flight, noise: Noise, seconds: f64, worst: &mut Worst) {
    // A body's velocity curves between two readings that are a second apart.
    let curve = if flight.kind == Kind::SixDof {
        flight.dt_s * flight.dt_s
    } else {
        0.0
    };
    for (first, last, sums) in flight.apart(seconds) {
        let off = last.truth.local - first.truth.local - sums.true_way;
        worst.look(
            "true way",
            hypot(off.east_m, off.north_m),
            0.01 + 0.3 * curve,
            flight,
            last,
        );
        let sunk_m = last.navigation.depth.as_m() - first.navigation.depth.as_m() - sums.sunk_m;
        let most_m = SIGMAS * 1.5 * noise.depth_m + 0.02 + 0.1 * curve;
        worst.look("depth by down velocity", sunk_m, most_m, flight, last);
        let swung_deg = last.navigation.heading.as_deg() - first.navigation.heading.as_deg() - sums.turned_deg;
        let most_deg = SIGMAS * 1.5 * noise.angle_deg + 0.02 + 2.0 * curve;
        worst.look("heading by yaw rates", wrap_180(swung_deg), most_deg, flight, last);
        // A fix moves the position, and nothing else does.
        if last.fixes > first.fixes {
            continue;
        }
        let off = last.place - first.place - sums.way;
        let random_m = noise.position_m
            + noise.drift_m_per_sqrt_s * seconds.sqrt()
            + noise.velocity_mps * (seconds * flight.dt_s).sqrt();
        let most_m = 0.03 + 0.3 * curve + SIGMAS * 1.5 * random_m;
        worst.look(
            "position by velocity",
            hypot(off.east_m, off.north_m),
            most_m,
            flight,
            last,
        );
    }
}

fn many(kinds: &[Kind], seeds: core::ops::Range<u64>) {
    let mut worst = Worst::default();
    for kind in kinds {
        for seed in seeds.clone() {
            let hz = [10, 10, 5, 2, 1][seed as usize % 5];
            let exact = seed % 2 == 0;
            let flight = drawn(*kind, exact, hz, seed, 450);
            check(&flight, Noise::of(exact), &mut worst);
            if exact {
                log::check(&flight, &mut worst);
            }
            if *kind == Kind::Hovering {
                inspector::check(&flight, exact, &mut worst);
            }
        }
    }
    worst.assert();
}

#[test]
fn a_kinematic_vehicles_motion_is_possible() {
    many(&[Kind::NineInch, Kind::TwelveInch, Kind::TwentyOneInch], 0..15);
}

#[test]
fn the_motion_of_a_body_with_six_degrees_of_freedom_is_possible() {
    many(&[Kind::SixDof], 0..15);
}

#[test]
fn a_hovering_vehicles_motion_is_possible() {
    many(&[Kind::Hovering], 0..20);
}
