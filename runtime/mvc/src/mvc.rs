//! The vehicle as a whole: it takes what comes to the part that it is for, and has no other knowledge.

mod commands;
mod faults;
mod steps;

use core::time::Duration;
use std::net::SocketAddr;

use backseat_units::{EastNorth, LocalFrame, Position, Timestamp, Utc};
use backseat_world::{Grid, World};

use crate::context::North;
use crate::error::MvcError;
use crate::event::{ClientId, DropReason, MvcEvent, Status};
use crate::executive::mission::Mission;
use crate::faults::timeline::Timeline;
use crate::file::{MotionModel, WorldFile};
use crate::interpretation::Interpretation;
use crate::plan::soundings;
use crate::sensors::{Sensors, true_heading};
use crate::server::{Received, Server};
use crate::services::Services;
use crate::truth::{HoveringTruth, Truth};
use crate::vehicle::Vehicle;

/// A framer is given no more at once, so that a flood is worked off as it comes, bytes.
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
    period: Duration,
    ticks: u64,
    next_tick: Timestamp,
    last_tick: Timestamp,
    /// What the log last said of it.
    grounded: bool,
}

impl Mvc {
    /// A vehicle at its start, its mission loaded, over a seabed without a grid.
    ///
    /// # Errors
    /// As [`Mvc::with_grid`]; and where the file names a grid.
    pub fn new(file: &WorldFile, seed: u64) -> Result<Self, MvcError> {
        Self::with_grid(file, seed, None)
    }

    /// A vehicle at its start, its mission loaded, over the grid that the file's `seabed.grid` names: whoever reads the
    /// file reads the grid too.
    ///
    /// # Errors
    /// [`MvcError`] where the world or the plan cannot be made from the file (one that [`WorldFile::from_toml`] has passed
    /// gives none of these but for its grid), where the vehicle starts below the seabed, where its start or its plan leads
    /// off the grid, and where this seed's water is too shallow for the plan anywhere on its way: less than
    /// the depth that the element is planned at, or than `vehicle.altitude_min_m` and 0.5 m. Nearer to the bed than its least
    /// altitude the vehicle does not go, whatever is planned.
    ///
    /// The way is looked at every 10 m, over a grid every 2 m, by the chart, without the tide. After a setpoint, which ends
    /// where the current takes it, it is looked at again from the next place that the plan names.
    pub fn with_grid(file: &WorldFile, seed: u64, grid: Option<Grid>) -> Result<Self, MvcError> {
        let charted = grid.is_some();
        let world = World::with_grid(&file.world_config(), seed, grid)?;
        let plan = crate::plan::resolve(&file.plan, world.frame(), &file.vehicle)?;
        let start = EastNorth::new(file.start.east_m, file.start.north_m);
        soundings::check_start(start, file.start.depth_m, &world)?;
        soundings::check(&plan, start, &world, file.vehicle.altitude_min_m, charted)?;
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
            sensors: Sensors::new(file, &vehicle, seed),
            mission: Mission::new(file, plan, interpretation, period, seed),
            services,
            server: Server::new(file, &interpretation, seed),
            faults: Timeline::new(&file.faults)?,
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

    /// The sea.
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

    /// A client has connected from an address that is not known, as one in the same process: it holds no role.
    /// Otherwise as [`Mvc::connect_from`].
    pub fn connect(&mut self, now: Timestamp, client: ClientId) {
        self.connect_from(now, client, None);
    }

    /// A client has connected: it is given the role that is meant for its address (SPI 4.1), and told the interface
    /// version (SPI 5.7).
    ///
    /// Where the identifier is known already, the old connection is forgotten. Where there is no room, no role or no
    /// power, [`Mvc::poll_disconnect`] says so.
    pub fn connect_from(&mut self, now: Timestamp, client: ClientId, address: Option<SocketAddr>) {
        self.handle_timeout(now);
        self.forget(now, client);
        if self.services.power.is_on() {
            self.server.connect(now, client, address);
        } else {
            self.server.cut_off(client, DropReason::PowerOff);
        }
        self.settle(now);
    }

    /// A client's connection is gone, with all that it had switched on and all that was due to it. What it has asked
    /// of the vehicle stands: inserts are flown, a modify lapses by the vehicle's clock.
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

    /// Bytes from a client, as they came: any number of sentences, the last perhaps cut.
    pub fn receive(&mut self, now: Timestamp, client: ClientId, bytes: &[u8]) {
        self.handle_timeout(now);
        for chunk in bytes.chunks(CHUNK) {
            self.server.push(client, chunk);
            while let Some(received) = self.server.next_received(client) {
                match received {
                    Received::Command(command) => self.command(now, client, command),
                    Received::Malformed(name, text) => self.server.malformed(now, client, name, text.as_str()),
                }
                self.settle(now);
            }
        }
        self.server.note_ignored(now, client);
    }

    /// When [`Mvc::handle_timeout`] is due.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Timestamp> {
        let lapses = self.mission.lapses_at().unwrap_or(self.next_tick);
        Some(self.next_tick.min(lapses).min(self.next_fault()))
    }

    /// Takes every step of the vehicle that is due. A late call takes them all, each at its own time, so that a call
    /// an hour late costs an hour's steps. The inputs do the same before anything else.
    pub fn handle_timeout(&mut self, now: Timestamp) {
        loop {
            let fault = self.next_fault();
            let first = fault.min(self.mission.lapses_at().unwrap_or(Timestamp::MAX));
            if fault <= now && fault == first && fault <= self.next_tick {
                self.step_faults(fault);
                continue;
            }
            // A modify and a suspension lapse on time and not at the next step: their 5 s and 2 s are promises (SPI
            // 7.12, 8.1).
            if let Some(at) = self.mission.lapses_at().filter(|at| *at <= now.min(self.next_tick)) {
                self.mission.lapse(at);
                self.settle(at);
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
        }
    }

    /// Fills `out` with all that is due to one client now, for one write; none where nothing is due to any.
    ///
    /// The buffer's content is thrown away and its allocation kept for the next message.
    #[must_use]
    pub fn poll_transmit(&mut self, out: &mut Vec<u8>) -> Option<ClientId> {
        self.server.poll_transmit(out)
    }

    /// The next client that the server has cut off: the driver closes its connection.
    #[must_use]
    pub fn poll_disconnect(&mut self) -> Option<ClientId> {
        self.server.poll_disconnect()
    }

    /// The next line of the vehicle's log.
    #[must_use]
    pub fn poll_event(&mut self) -> Option<MvcEvent> {
        self.server.poll_event(self.last_tick)
    }

    /// The points of the front seat's plan and of the inserts in it, with the numbers of the planned elements.
    #[must_use]
    pub fn plan_points(&self) -> Vec<(Option<u32>, Position)> {
        let points = self.mission.plan_points(self.sensors.estimate(&self.vehicle).at);
        let place = |(number, at)| (number, self.frame().to_position(at));
        points.into_iter().map(place).collect()
    }

    /// A hovering vehicle's truth beside [`Mvc::truth`]; none of other vehicles.
    #[must_use]
    pub fn hovering_truth(&self) -> Option<HoveringTruth> {
        self.services.hovering.truth(&self.vehicle, &self.mission)
    }

    /// The vehicle as it is after its last step.
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
            speed_mps: vehicle.motion().surge_mps,
            east_mps: vehicle.motion().ground.0,
            north_mps: vehicle.motion().ground.1,
            activity: self.mission.activity(),
            control: self.mission.control(),
        }
    }

    /// Whether the mission has completed, was aborted or was killed.
    #[must_use]
    pub fn mission_over(&self) -> bool {
        matches!(
            self.mission.status(),
            Status::Completed | Status::Aborted | Status::Stopped
        )
    }

    /// The mission's status.
    #[must_use]
    pub fn mission_status(&self) -> Status {
        self.mission.status()
    }

    /// Vehicle UTC, as its sentences carry it.
    #[must_use]
    pub fn utc(&self, now: Timestamp) -> Utc {
        self.server.utc(now)
    }
}
