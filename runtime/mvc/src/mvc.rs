//! The vehicle as a whole: it passes each input to the part that handles it, and knows nothing else.

mod commands;
mod dives;
mod faults;
mod orders;
mod steps;

use core::time::Duration;
use std::collections::VecDeque;
use std::net::SocketAddr;

use backseat_units::{EastNorth, LocalFrame, Position, Timestamp, Utc};
use backseat_world::{Grid, World};

use crate::context::North;
use crate::error::MvcError;
use crate::event::{ClientId, DropReason, MvcEvent, Status};
use crate::executive::dives::resolve;
use crate::executive::mission::Mission;
use crate::faults::Fault;
use crate::faults::timeline::Timeline;
use crate::file::{MotionModel, WorldFile};
use crate::interpretation::Interpretation;
use crate::plan::soundings;
use crate::script::rules::Rules;
use crate::sensors::{Sensors, true_heading};
use crate::server::{Received, Server};
use crate::services::Services;
use crate::truth::{HoveringTruth, Truth};
use crate::vehicle::Vehicle;

/// The most bytes that a framer receives at once. The mock carries out the commands of one chunk before it takes the
/// next.
const CHUNK: usize = 4096;

/// The mock main vehicle computer. See the crate's documentation for the order of calls.
#[derive(Debug)]
pub struct Mvc {
    world: World,
    interpretation: Interpretation,
    vehicle: Vehicle,
    north: North,
    sensors: Sensors,
    mission: Mission,
    services: Services,
    server: Server,
    faults: Timeline,
    rules: Rules,
    /// Faults of links that orders have begun, for the driver.
    link_faults: VecDeque<Fault>,
    period: Duration,
    ticks: u64,
    next_tick: Timestamp,
    last_tick: Timestamp,
    /// Whether the vehicle touched the seabed at its last step. The log reports a change.
    grounded: bool,
}

impl Mvc {
    /// A vehicle at its start with its mission loaded, over a seabed without a grid.
    ///
    /// # Errors
    /// The errors of [`Mvc::with_grid`], and an error if the file names a grid.
    pub fn new(file: &WorldFile, seed: u64) -> Result<Self, MvcError> {
        Self::with_grid(file, seed, None)
    }

    /// A vehicle at its start with its mission loaded, over the grid that the file's `seabed.grid` names. The caller
    /// that reads the file also reads the grid.
    ///
    /// # Errors
    /// [`MvcError`] if:
    ///
    /// - the world or the plan cannot be made from the file. This cannot happen with a file from
    ///   [`WorldFile::from_toml`], except because of its grid;
    /// - the vehicle starts below the seabed;
    /// - the start or the plan leads off the grid;
    /// - this seed's water is too shallow somewhere on the plan's way: shallower than the planned depth of the element,
    ///   or than `vehicle.altitude_min_m` plus 0.5 m. The vehicle never goes nearer to the seabed than its least
    ///   altitude, whatever is planned.
    ///
    /// The check takes a place every 10 m of the way, or every 2 m over a grid, and the charted depth without the tide.
    /// The current decides where a setpoint ends, so the check goes on at the next place that the plan names.
    pub fn with_grid(file: &WorldFile, seed: u64, grid: Option<Grid>) -> Result<Self, MvcError> {
        let charted = grid.is_some();
        let world = World::with_grid(&file.world_config(), seed, grid)?;
        let dives = resolve(file, world.frame())?;
        let start = EastNorth::new(file.start.east_m, file.start.north_m);
        soundings::check_start(start, file.start.depth_m, &world)?;
        for (number, dive) in (1..).zip(&dives) {
            // Where a later dive begins is where the one before left the vehicle.
            let start = (number == 1).then_some(start);
            let checked = soundings::check(&dive.plan, start, &world, file.vehicle.altitude_min_m, charted);
            checked.map_err(|error| {
                if file.dive.is_empty() {
                    error
                } else {
                    error.of_dive(number)
                }
            })?;
        }
        let interpretation = Interpretation::new(&file.interpretation, seed);
        let period = Duration::from_nanos(1_000_000_000 / u64::from(file.vehicle.tick_hz.clamp(1, 100)));
        let north = North::at(start, world.frame());
        let made = match file.vehicle.model {
            MotionModel::Kinematic => Vehicle::new,
            MotionModel::SixDof => Vehicle::with_body,
        };
        let heading_deg = file.start.heading_deg - north.frame_deg;
        let (performance, altitude_min_m) = (file.vehicle.performance(), file.vehicle.altitude_min_m);
        let mut vehicle = made(performance, altitude_min_m, start, file.start.depth_m, heading_deg);
        vehicle.sense(&world, Timestamp::ZERO);
        let services = Services::new(file, &world, &mut vehicle, seed);
        Ok(Self {
            sensors: Sensors::new(file, &interpretation, &vehicle, seed),
            mission: Mission::new(file, dives, interpretation, period, seed),
            services,
            server: Server::new(file, &interpretation, seed),
            faults: Timeline::new(&file.faults)?,
            rules: Rules::default(),
            link_faults: VecDeque::new(),
            interpretation,
            vehicle,
            north,
            period,
            ticks: 0,
            next_tick: Timestamp::ZERO + period,
            last_tick: Timestamp::ZERO,
            grounded: false,
            world,
        })
    }

    /// The sea and what is in it.
    #[must_use]
    pub const fn world(&self) -> &World {
        &self.world
    }

    /// The world's frame.
    #[must_use]
    pub const fn frame(&self) -> &LocalFrame {
        self.world.frame()
    }

    /// How this run reads what the specification leaves open.
    #[must_use]
    pub const fn interpretation(&self) -> &Interpretation {
        &self.interpretation
    }

    /// A client has connected from an unknown address, such as a client in the same process: it holds no role.
    /// Otherwise the same as [`Mvc::connect_from`].
    pub fn connect(&mut self, now: Timestamp, client: ClientId) {
        self.connect_from(now, client, None);
    }

    /// A client has connected. It gets the role for its address (SPI 4.1), and BFVER with the interface version (SPI
    /// 5.7).
    ///
    /// If the identifier is already in use, the mock forgets the old connection. If there is no room, no role or no
    /// power for the client, [`Mvc::poll_disconnect`] returns it.
    pub fn connect_from(&mut self, now: Timestamp, client: ClientId, address: Option<SocketAddr>) {
        self.handle_timeout(now);
        self.forget(now, client);
        if self.services.power.is_on() {
            self.server.connect(now, client, address);
        } else {
            self.server.cut_off(client, DropReason::PowerOff);
        }
        self.settle(now);
        self.fire(now);
    }

    /// A client's connection is gone. The mock forgets the client's subscriptions and what it had still to send to it.
    /// It keeps what the client asked of the vehicle: inserts are flown, and a modify lapses by the vehicle's clock.
    pub fn disconnect(&mut self, now: Timestamp, client: ClientId) {
        self.handle_timeout(now);
        self.forget(now, client);
    }

    fn forget(&mut self, now: Timestamp, client: ClientId) {
        self.services.client_left(client);
        self.server.disconnect(now, client);
    }

    /// The role that a client holds (SPI 4.1).
    #[must_use]
    pub fn role(&self, client: ClientId) -> Option<&str> {
        self.server.role_of(client)
    }

    /// Bytes from a client as they arrived: any number of sentences, of which the last may be incomplete.
    pub fn receive(&mut self, now: Timestamp, client: ClientId, bytes: &[u8]) {
        self.handle_timeout(now);
        // A vehicle that answers broken lines answers them in their order among the good ones.
        let by_line = self.interpretation.broken_lines_answered;
        let pieces = bytes.chunks(CHUNK);
        for piece in pieces.flat_map(|chunk| chunk.split_inclusive(|byte| by_line && *byte == b'\n')) {
            self.server.push(client, piece);
            while let Some(received) = self.server.next_received(client) {
                let name = received.name();
                match received {
                    Received::Command(command) => self.command(now, client, command),
                    Received::Malformed(name, created, text) => {
                        self.server.malformed(now, client, (name, created), text.as_str());
                    }
                }
                self.settle(now);
                self.see_command(now, name);
                self.fire(now);
            }
            if by_line && piece.ends_with(b"\n") && self.server.ends_broken_line(client) {
                self.server.no_sentence(now, client);
                self.settle(now);
            }
        }
        self.server.note_ignored(now, client);
    }

    /// When the driver must call [`Mvc::handle_timeout`].
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Timestamp> {
        let lapses = self.mission.lapses_at().unwrap_or(self.next_tick);
        Some(self.next_tick.min(lapses).min(self.next_fault()).min(self.rules.next()))
    }

    /// Takes every step of the vehicle that is due. A late call takes all of them, each at its own time, so a call that
    /// is an hour late costs an hour's steps. Every input first does the same.
    pub fn handle_timeout(&mut self, now: Timestamp) {
        loop {
            let fault = self.next_fault();
            let rule = self.rules.next();
            let first = fault.min(rule).min(self.mission.lapses_at().unwrap_or(Timestamp::MAX));
            if fault <= now && fault == first && fault <= self.next_tick {
                self.step_faults(fault);
                self.observe();
                continue;
            }
            if rule <= now && rule == first && rule <= self.next_tick {
                self.fire(rule);
                continue;
            }
            // A modify and a suspension lapse on time and not at the next step: SPI 7.12 and 8.1 promise 5 s and 2 s.
            if let Some(at) = self.mission.lapses_at().filter(|at| *at <= now.min(self.next_tick)) {
                self.mission.lapse(at);
                self.settle(at);
                self.observe();
                continue;
            }
            if self.next_tick > now {
                return;
            }
            let tick = self.next_tick;
            self.ticks += 1;
            self.next_tick = tick + self.period;
            self.last_tick = tick;
            self.tick(tick);
            self.observe();
        }
    }

    /// Fills `out` with all bytes that wait for one client, for one write, and returns that client. Returns `None` if
    /// nothing waits for any client.
    ///
    /// The buffer's old content is lost. Its allocation is kept for the next message.
    #[must_use]
    pub fn poll_transmit(&mut self, out: &mut Vec<u8>) -> Option<ClientId> {
        self.server.poll_transmit(out)
    }

    /// The next client that the server has cut off. The driver must close its connection.
    #[must_use]
    pub fn poll_disconnect(&mut self) -> Option<ClientId> {
        self.server.poll_disconnect()
    }

    /// The next line of the vehicle's log.
    #[must_use]
    pub fn poll_event(&mut self) -> Option<MvcEvent> {
        self.server.poll_event(self.last_tick)
    }

    /// The points of the front seat's plan and of the inserts in it. A point of a planned element has the element's
    /// number.
    #[must_use]
    pub fn plan_points(&self) -> Vec<(Option<u32>, Position)> {
        let points = self.mission.plan_points(self.sensors.estimate(&self.vehicle).at);
        let place = |(number, at)| (number, self.frame().to_position(at));
        points.into_iter().map(place).collect()
    }

    /// What is true of a hovering vehicle in addition to [`Mvc::truth`]; `None` for other vehicles.
    #[must_use]
    pub fn hovering_truth(&self) -> Option<HoveringTruth> {
        self.services.hovering.truth(&self.vehicle, &self.mission)
    }

    /// The true state of the vehicle after its last step.
    #[must_use]
    pub fn truth(&self) -> Truth {
        let vehicle = &self.vehicle;
        let position = self.frame().to_position(vehicle.motion().at);
        let estimate = self.sensors.estimate(vehicle);
        Truth {
            time: self.last_tick,
            position,
            local: vehicle.motion().at,
            believed: estimate.at,
            depth_m: vehicle.motion().depth_m,
            believed_depth_m: estimate.depth_m,
            altitude_m: vehicle.motion().water_depth_m - vehicle.motion().depth_m,
            water_depth_m: vehicle.motion().water_depth_m,
            heading_deg: true_heading(vehicle.motion().heading_deg, self.frame(), position).as_deg(),
            pitch_deg: vehicle.motion().pitch_deg,
            roll_deg: vehicle.motion().roll_deg,
            speed_mps: vehicle.motion().surge_mps,
            east_mps: vehicle.motion().ground.0,
            north_mps: vehicle.motion().ground.1,
            down_mps: vehicle.motion().heave_mps,
            activity: self.mission.activity(),
            control: self.mission.control(),
        }
    }

    /// Whether the mission has completed, was aborted, was killed or cannot start, and no other dive is loaded without an
    /// operator.
    #[must_use]
    pub fn mission_over(&self) -> bool {
        let status = self.mission.status();
        status.is_free() && status != Status::Waiting && !self.mission.is_next_dive_waiting()
    }

    /// The mission's status.
    #[must_use]
    pub fn mission_status(&self) -> Status {
        self.mission.status()
    }

    /// UTC by the vehicle's clock, as its sentences carry it.
    #[must_use]
    pub fn utc(&self, now: Timestamp) -> Utc {
        self.server.utc(now)
    }
}
