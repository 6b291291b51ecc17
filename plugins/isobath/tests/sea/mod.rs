//! A sloping shelf with meanders, a current, and a vehicle that turns with a lag.

use backseat_sdk::units::EastNorth;
use backseat_sdk::units::math::{TAU, hypot, ln, sin_cos, wrap_180, wrap_360};
use backseat_sdk::{Navigation, Plugin, Request, StepInput, Vertical};
use isobath::{Config, Isobath};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng as _, SeedableRng as _};

pub(crate) struct Chance(ChaCha8Rng);

impl Chance {
    pub(crate) fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    pub(crate) fn within(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * ((self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64)
    }

    pub(crate) fn gaussian(&mut self) -> f64 {
        let (sin, _) = sin_cos(TAU * self.within(0.0, 1.0));
        (-2.0 * ln(1.0 - self.within(0.0, 1.0))).sqrt() * sin
    }
}

struct Meander {
    amplitude_m: f64,
    wave: EastNorth,
    phase: f64,
}

pub(crate) struct Sea {
    seed: u64,
    slope: EastNorth,
    meanders: Vec<Meander>,
    pub(crate) contour_m: f64,
    downslope_deg: f64,
    along_deg: f64,
    current: (f64, f64),
    start: EastNorth,
    start_heading_deg: f64,
    noise_m: f64,
    turn_max_dps: f64,
    turn_gain: f64,
    turn_lag_s: f64,
}

impl Sea {
    pub(crate) fn drawn(seed: u64) -> Self {
        let mut chance = Chance::new(seed);
        let steepness = chance.within(0.02, 0.06);
        let downslope_deg = chance.within(0.0, 360.0);
        // Together the meanders add at most 0.4 of the slope, so that the contour remains a single line.
        let meanders = (0..3)
            .map(|_| {
                let number = TAU / chance.within(400.0, 1500.0);
                let (east, north) = sin_cos(chance.within(0.0, TAU));
                Meander {
                    amplitude_m: chance.within(0.3, 1.0) * 0.4 / 3.0 * steepness / number,
                    wave: EastNorth::new(east, north) * number,
                    phase: chance.within(0.0, TAU),
                }
            })
            .collect();
        let side = if chance.within(0.0, 1.0) < 0.5 { -90.0 } else { 90.0 };
        let (sin, cos) = sin_cos(chance.within(0.0, TAU));
        let speed = chance.within(0.0, 0.3);
        let start = EastNorth::default().offset(downslope_deg, chance.within(-300.0, 300.0));
        Self {
            seed,
            slope: EastNorth::default().offset(downslope_deg, steepness),
            meanders,
            contour_m: 40.0,
            downslope_deg,
            along_deg: downslope_deg + side,
            current: (speed * sin, speed * cos),
            start,
            start_heading_deg: chance.within(0.0, 360.0),
            noise_m: chance.within(0.1, 0.3),
            turn_max_dps: chance.within(8.0, 10.0),
            turn_gain: chance.within(0.22, 0.4),
            turn_lag_s: chance.within(0.7, 2.0),
        }
    }

    pub(crate) fn depth_and_gradient(&self, at: EastNorth) -> (f64, EastNorth) {
        let mut depth_m = self.contour_m + self.slope.east_m * at.east_m + self.slope.north_m * at.north_m;
        let mut gradient = self.slope;
        for meander in &self.meanders {
            let phase = meander.wave.east_m * at.east_m + meander.wave.north_m * at.north_m + meander.phase;
            let (sin, cos) = sin_cos(phase);
            depth_m += meander.amplitude_m * sin;
            gradient = gradient + meander.wave * (meander.amplitude_m * cos);
        }
        (depth_m, gradient)
    }

    /// Horizontal distance to the contour, metres: the distance along the gradient to where the depth is right.
    pub(crate) fn off_m(&self, at: EastNorth) -> f64 {
        let mut on = at;
        for _ in 0..8 {
            let (depth_m, gradient) = self.depth_and_gradient(on);
            let square = gradient.east_m * gradient.east_m + gradient.north_m * gradient.north_m;
            on = on - gradient * ((depth_m - self.contour_m) / square);
        }
        on.distance_m(at)
    }
}

pub(crate) fn config(sea: &Sea) -> Config {
    // An operator knows the general directions to within 20 degrees, and a typical slope.
    serde_json::from_value(serde_json::json!({
        "contour_m": sea.contour_m,
        "depth_m": 12.0,
        "speed_mps": 1.5,
        "along_deg": wrap_360(sea.along_deg),
        "deeper_toward_deg": wrap_360(sea.downslope_deg + if sea.seed.is_multiple_of(2) { 20.0 } else { -20.0 }),
    }))
    .unwrap()
}

pub(crate) struct Trial {
    sea: Sea,
    pub(crate) plugin: Isobath,
    chance: Chance,
    now_ns: u64,
    at: EastNorth,
    heading_deg: f64,
    yaw_rate_dps: f64,
    speed_mps: f64,
    demand: Option<f64>,
    ground: (f64, f64),
    pub(crate) control: bool,
    pub(crate) lock: bool,
    no_lock_steps: u32,
    pub(crate) last: Option<Request>,
}

impl Trial {
    pub(crate) fn new(sea: Sea) -> Self {
        let plugin = Isobath::new(config(&sea)).unwrap();
        Self {
            chance: Chance::new(sea.seed ^ 0x5ea),
            now_ns: 0,
            at: sea.start,
            heading_deg: sea.start_heading_deg,
            yaw_rate_dps: 0.0,
            speed_mps: 1.0,
            demand: None,
            ground: (0.0, 0.0),
            control: true,
            lock: true,
            no_lock_steps: 0,
            last: None,
            sea,
            plugin,
        }
    }

    pub(crate) fn sea(&self) -> &Sea {
        &self.sea
    }

    pub(crate) fn off_m(&self) -> f64 {
        self.sea.off_m(self.at)
    }

    pub(crate) fn input(&mut self) -> StepInput {
        let chance = &mut self.chance;
        let water_m = self.sea.depth_and_gradient(self.at).0;
        let mut altitude_m = water_m - 12.0 + self.sea.noise_m * chance.gaussian();
        let kind = chance.within(0.0, 1.0);
        if kind < 0.01 {
            altitude_m += chance.within(-15.0, 15.0);
        } else if kind < 0.015 {
            self.no_lock_steps = 1 + (chance.within(0.0, 10.0) as u32);
        }
        let lock = self.lock && self.no_lock_steps == 0;
        self.no_lock_steps = self.no_lock_steps.saturating_sub(1);
        StepInput {
            now_ns: self.now_ns,
            control: self.control,
            navigation: Some(Navigation {
                age_ns: 100_000_000,
                east: self.at.east_m + 0.1 * chance.gaussian(),
                north: self.at.north_m + 0.1 * chance.gaussian(),
                depth: 12.0 + 0.05 * chance.gaussian(),
                altitude: lock.then_some(altitude_m),
                heading: wrap_360(self.heading_deg + 0.3 * chance.gaussian()),
                velocity_east: self.ground.0 + 0.02 * chance.gaussian(),
                velocity_north: self.ground.1 + 0.02 * chance.gaussian(),
                yaw_rate: self.yaw_rate_dps,
                ..Navigation::default()
            }),
            ..StepInput::default()
        }
    }

    /// Moves the vehicle for half a second under the latest request.
    pub(crate) fn fly(&mut self, requests: &[Request]) {
        for request in requests {
            match request {
                Request::Modify(modify) => {
                    assert_eq!(modify.vertical, Vertical::Depth(12.0));
                    assert!((0.0..360.0).contains(&modify.heading));
                    self.demand = Some(modify.heading);
                }
                Request::EndModify => self.demand = None,
                other => panic!("{other:?}"),
            }
            self.last = Some(request.clone());
        }
        for _ in 0..5 {
            let dt = 0.1;
            let error = wrap_180(self.demand.unwrap_or(self.heading_deg) - self.heading_deg);
            let most = self.sea.turn_max_dps;
            let wanted = (self.sea.turn_gain * error).clamp(-most, most);
            self.yaw_rate_dps += (wanted - self.yaw_rate_dps) * dt / (self.sea.turn_lag_s + dt);
            self.speed_mps += (1.5 - self.speed_mps) * dt / 5.0;
            self.heading_deg = wrap_360(self.heading_deg + self.yaw_rate_dps * dt);
            let (sin, cos) = sin_cos(self.heading_deg.to_radians());
            self.ground = (
                self.speed_mps * sin + self.sea.current.0,
                self.speed_mps * cos + self.sea.current.1,
            );
            assert!(hypot(self.ground.0, self.ground.1) < 3.0);
            self.at = self.at + EastNorth::new(self.ground.0, self.ground.1) * dt;
        }
        self.now_ns += 500_000_000;
    }

    pub(crate) fn step(&mut self) {
        let input = self.input();
        let requests = self.plugin.step(&input).unwrap();
        self.fly(&requests);
    }
}
