use core::time::Duration;

use backseat_spi::{Dvl as DvlMessage, DvlBeams};
use backseat_units::math::{cos, sin, sin_cos};
use backseat_units::{TimeOfDay, Timestamp};

use super::EastNorthRate;
use super::attitude::{Attitude, dot};
use super::noise::{Draws, Noise};
use crate::file::SensorConfig;
use crate::vehicle::Vehicle;

/// Bottom lock needs this many of the four beams, because a velocity has three components.
const BEAMS_FOR_LOCK: usize = 3;
/// Directions of the beams, degrees clockwise from ahead.
const AZIMUTHS_DEG: [f64; 4] = [45.0, 135.0, 225.0, 315.0];

/// The angle of a DVL that looks straight down, degrees above the horizontal.
const DOWN_DEG: f64 = -90.0;
/// Above this angle the DVL measures the distance from the ship.
const TO_SHIP_ABOVE_DEG: f64 = -45.0;
/// That many beams that end at the ship's side give its distance.
const BEAMS_FOR_DISTANCE: usize = 2;

/// The DVL (Doppler velocity log): four beams, bottom lock, and the constant errors of its velocity.
///
/// A servo turns the DVL of a hovering vehicle. It measures against a ship's plating or the seabed, whichever a beam
/// meets first. The beams are the whole of it: their ends give the ranges, the lock, the velocity and the distance from
/// the ship.
#[derive(Clone, Debug)]
pub(super) struct Dvl {
    config: SensorConfig,
    noise: Noise,
    /// Unit vectors along the beams, in the DVL's axes; `beams` has them in the vehicle's axes.
    own_beams: [[f64; 3]; 4],
    beams: [[f64; 3]; 4],
    /// Its angle, degrees above the horizontal.
    look_deg: f64,
    /// Whether a separate altimeter measures the altitude. A vehicle that turns its DVL away from the bottom needs one.
    altimeter: bool,
    range_max_m: f64,
    /// The greatest range at which a beam returns from a ship, metres.
    ship_range_max_m: f64,
    dropout_chance: f64,
    no_lock_until: Timestamp,
    scale: f64,
    misalignment: (f64, f64),
    /// Whether it has failed.
    pub(super) dead: bool,
    /// Whether it waits for a trigger that does not come (SPI 7.4).
    pub(super) waits: bool,
    /// Whether enough beams return from the seabed or the ship.
    pub(super) lock: bool,
    /// Whether there is an altitude.
    pub(super) sounds: bool,
    /// The distance from the inspected side of the ship, metres, if the beams measure it.
    pub(super) ship_m: Option<f64>,
}

/// One reading. BFDVL and BFDV2 each report a part of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct DvlReading {
    velocity_mps: Option<[f64; 3]>,
    along_beams_mps: [Option<f64>; 4],
    error_mps: f64,
    ranges_m: [Option<f64>; 4],
    temperature_c: f64,
}

impl Dvl {
    /// `ship_range_max_m` is the greatest distance from a ship that it measures, metres.
    pub(super) fn new(
        config: &SensorConfig,
        readings_per_h: f64,
        hovers: bool,
        ship_range_max_m: f64,
        seed: u64,
    ) -> Self {
        let noise = Noise::new(seed, "dvl");
        let mut constant = Noise::new(seed, "dvl alignment").reading(0);
        let scale = 1.0 + constant.normal(config.dvl.scale_error);
        let misalignment_rad = constant.normal(config.dvl.misalignment_deg).to_radians();
        let beam_rad = config.dvl.beam_angle_deg.to_radians();
        let (out, down) = sin_cos(beam_rad);
        let beams = AZIMUTHS_DEG.map(|azimuth| {
            let (sin, cos) = sin_cos(azimuth.to_radians());
            [out * cos, out * sin, down]
        });
        Self {
            config: *config,
            noise,
            own_beams: beams,
            beams,
            look_deg: DOWN_DEG,
            altimeter: hovers,
            range_max_m: config.altitude_range_m / cos(beam_rad),
            ship_range_max_m: ship_range_max_m.min(config.altitude_range_m) / cos(beam_rad),
            dropout_chance: config.altitude_dropouts_per_h / readings_per_h,
            no_lock_until: Timestamp::ZERO,
            scale,
            misalignment: (sin(misalignment_rad), cos(misalignment_rad)),
            dead: false,
            waits: false,
            lock: false,
            sounds: false,
            ship_m: None,
        }
    }

    /// Turns it to this angle, degrees above the horizontal.
    pub(super) fn turn_to(&mut self, look_deg: f64) {
        if look_deg.to_bits() == self.look_deg.to_bits() {
            return;
        }
        self.look_deg = look_deg;
        let (sin, cos) = sin_cos((look_deg - DOWN_DEG).to_radians());
        self.beams = self
            .own_beams
            .map(|[x, y, z]| [x * cos + z * sin, y, z * cos - x * sin]);
    }

    /// One step of the vehicle: finds out whether there is bottom lock.
    pub(super) fn step(&mut self, vehicle: &Vehicle, now: Timestamp, draws: &mut Draws) {
        if draws.uniform() < self.dropout_chance {
            let seconds = self.config.altitude_dropout_s * (0.5 + draws.uniform());
            self.no_lock_until = now + Duration::from_secs_f64(seconds);
        }
        let heard = now >= self.no_lock_until;
        self.lock = !self.dead && !self.waits && heard && self.reaches(vehicle);
        self.sounds = if self.altimeter {
            heard && self.altitude_in_reach(vehicle)
        } else {
            self.lock
        };
        self.ship_m = self.distance_of_ship(vehicle);
    }

    /// The mean of what the beams say that end at the inspected side of the ship; `None` without lock, too few such
    /// beams, or a DVL that is turned to the bottom.
    fn distance_of_ship(&self, vehicle: &Vehicle) -> Option<f64> {
        let ship = vehicle.obstacle()?.ship;
        if !self.lock || self.look_deg <= TO_SHIP_ABOVE_DEG {
            return None;
        }
        let attitude = Attitude::of(vehicle);
        let (mut sum_m, mut count) = (0.0, 0);
        for beam in self.beams {
            let [north, east, down] = attitude.to_frame(beam);
            let off_m = self
                .range_m(vehicle, attitude, beam)
                .and_then(|range_m| ship.off_side_m(vehicle.motion().at, (east, north, down), range_m));
            if let Some(off_m) = off_m {
                (sum_m, count) = (sum_m + off_m, count + 1);
            }
        }
        (count >= BEAMS_FOR_DISTANCE).then(|| sum_m / count as f64)
    }

    fn altitude_in_reach(&self, vehicle: &Vehicle) -> bool {
        let altitude_m = vehicle.motion().water_depth_m - vehicle.motion().depth_m;
        let tilt_deg = vehicle.motion().pitch_deg.abs().max(vehicle.motion().roll_deg.abs());
        altitude_m >= self.config.altitude_blanking_m
            && altitude_m <= self.config.altitude_range_m
            && tilt_deg <= self.config.dvl.tilt_max_deg
    }

    fn reaches(&self, vehicle: &Vehicle) -> bool {
        if vehicle.obstacle().is_none() {
            if !self.altitude_in_reach(vehicle) {
                return false;
            }
            // Well within its range, every beam returns, on any realistic slope.
            if 3.0 * (vehicle.motion().water_depth_m - vehicle.motion().depth_m) < self.config.altitude_range_m {
                return true;
            }
        }
        let attitude = Attitude::of(vehicle);
        self.beams
            .iter()
            .filter(|beam| self.range_m(vehicle, attitude, **beam).is_some())
            .count()
            >= BEAMS_FOR_LOCK
    }

    /// The range at which a beam meets the plane of the seabed below the vehicle, or a ship before that; `None` if it
    /// does not return.
    fn range_m(&self, vehicle: &Vehicle, attitude: Attitude, beam: [f64; 3]) -> Option<f64> {
        let [north, east, down] = attitude.to_frame(beam);
        let closing = down - vehicle.motion().gradient.north_m * north - vehicle.motion().gradient.east_m * east;
        let to_bed_m = (closing > 0.0).then_some((vehicle.motion().water_depth_m - vehicle.motion().depth_m) / closing);
        let to_ship_m = vehicle.obstacle().as_ref().and_then(|obstacle| {
            obstacle
                .ship
                .ahead_m(vehicle.motion().at, vehicle.motion().depth_m, (east, north, down))
        });
        let (metres, most_m) = match (to_ship_m, to_bed_m) {
            (Some(ship_m), None) => (ship_m, self.ship_range_max_m),
            (Some(ship_m), Some(bed_m)) if ship_m < bed_m => (ship_m, self.ship_range_max_m),
            (_, Some(bed_m)) => (bed_m, self.range_max_m),
            (None, None) => return None,
        };
        (self.config.altitude_blanking_m..=most_m)
            .contains(&metres)
            .then_some(metres)
    }

    /// A velocity over ground or through the water (east, north) as the DVL measures it, with its scale error and
    /// misalignment.
    pub(super) fn measured(&self, (east, north): EastNorthRate, sound_ratio: f64) -> EastNorthRate {
        let scale = self.scale * sound_ratio;
        let (sin, cos) = self.misalignment;
        (scale * (east * cos + north * sin), scale * (north * cos - east * sin))
    }

    /// The reading of this number; `None` from a DVL that has failed or waits for a trigger.
    pub(super) fn reading(
        &self,
        vehicle: &Vehicle,
        temperature_c: f64,
        sound_ratio: f64,
        number: u64,
    ) -> Option<DvlReading> {
        if self.dead || self.waits {
            return None;
        }
        let config = self.config.dvl;
        let mut draws = self.noise.reading(number);
        let noise_mps = [(); 3].map(|()| draws.normal(config.velocity_noise_mps));
        let error_mps = draws.normal(config.velocity_noise_mps);
        let attitude = Attitude::of(vehicle);
        let ranges_m = self.beams.map(|beam| {
            let (lost, noise_m) = (draws.uniform() < config.beam_loss, draws.normal(config.range_noise_m));
            self.range_m(vehicle, attitude, beam)
                .filter(|_| self.lock && !lost)
                .map(|range_m| (range_m + noise_m).max(0.01))
        });
        let (east, north) = vehicle.motion().ground;
        let over_ground = ranges_m.iter().flatten().count() >= BEAMS_FOR_LOCK;
        let velocity = if over_ground {
            Some((east, north))
        } else if config.water_velocity {
            Some((east - vehicle.motion().current.0, north - vehicle.motion().current.1))
        } else {
            None
        };
        let velocity_mps = velocity.map(|velocity| {
            let (east, north) = self.measured(velocity, sound_ratio);
            let [x, y, z] = attitude.to_body([north, east, vehicle.motion().heave_mps]);
            [x + noise_mps[0], y + noise_mps[1], z + noise_mps[2]]
        });
        let mut along_beams_mps = [None; 4];
        for ((along, beam), range) in along_beams_mps.iter_mut().zip(self.beams).zip(ranges_m) {
            *along = velocity_mps
                .filter(|_| range.is_some() || !over_ground)
                .map(|velocity| dot(beam, velocity));
        }
        Some(DvlReading {
            velocity_mps,
            along_beams_mps,
            error_mps,
            ranges_m,
            temperature_c: temperature_c + draws.normal(config.temperature_noise_c),
        })
    }
}

impl DvlReading {
    /// BFDVL (SPI 6.13).
    pub(super) fn message(&self, stamp: TimeOfDay) -> DvlMessage {
        DvlMessage {
            created: stamp,
            velocity_mps: self.velocity_mps.map_or([None; 3], |velocity| velocity.map(Some)),
            ranges_m: self.ranges_m,
            temperature_c: Some(self.temperature_c),
            measured: stamp,
        }
    }

    /// BFDV2 (SPI 6.14): velocities along the beams for a hovering vehicle, otherwise along the axes with the error
    /// velocity.
    pub(super) fn extended(&self, hovers: bool, stamp: TimeOfDay) -> DvlBeams {
        let velocity_mps = if hovers {
            self.along_beams_mps
        } else {
            self.velocity_mps
                .map_or([None; 4], |[x, y, z]| [Some(x), Some(y), Some(z), Some(self.error_mps)])
        };
        DvlBeams {
            created: stamp,
            velocity_mps,
            ranges_m: self.ranges_m,
            temperature_c: Some(self.temperature_c),
            measured: stamp,
        }
    }
}
