use core::time::Duration;
use std::collections::VecDeque;
use std::net::SocketAddr;

use backseat_spi::{
    BackseatControl, BehaviorBegin, BehaviorEnd, FromVehicle, LoggingBegin, LoggingEnd, MissionCommand, MissionStatus,
    Text, VehicleVersion,
};
use backseat_units::{EastNorth, LocalFrame, TimeOfDay, Timestamp, Utc, utm_convergence_deg};
use backseat_world::{Grid, Span, Stream, World};

use crate::acoustic::Acoustic;
use crate::adjustment::Adjustment;
use crate::dvl_trigger::DvlTrigger;
use crate::error::MvcError;
use crate::event::{Behavior, ClientId, DropReason, MvcEvent, MvcEventKind, Source, Status};
use crate::executive::Executive;
use crate::faults::Faults;
use crate::file::{AcknowledgeConfig, MotionModel, Profile, WorldFile};
use crate::hovering::Hovering;
use crate::interpretation::Interpretation;
use crate::mission_commands::MissionCommands;
use crate::mission_event::{MissionEvent, Told};
use crate::power::Power;
use crate::requests::Pending;
use crate::sensors::{Sensors, true_heading};
use crate::server::{Received, Server, Topic};
use crate::silence::Silence;
use crate::surfacing::Surfacing;
use crate::topside::Topside;
use crate::truth::Truth;
use crate::vehicle::{Drive, Vehicle};

/// How many events may wait to be fetched.
const EVENTS_MAX: usize = 10_000;
/// A framer is given no more at once, so that a flood is worked off as it comes, bytes.
const CHUNK: usize = 4096;

/// The mock main vehicle computer. See the crate's documentation for the order of calls.
#[derive(Debug)]
pub struct Mvc {
    pub(crate) world: World,
    pub(crate) vehicle: Vehicle,
    pub(crate) executive: Executive,
    pub(crate) server: Server,
    pub(crate) interpretation: Interpretation,
    pub(crate) pending: VecDeque<Pending>,
    pub(crate) pending_s: Span,
    pub(crate) acknowledge: AcknowledgeConfig,
    pub(crate) delays: Stream,
    /// Angles from true north to the frame's north and to the UTM grid's, where the vehicle is.
    pub(crate) frame_convergence_deg: f64,
    pub(crate) grid_convergence_deg: f64,
    pub(crate) sensors: Sensors,
    pub(crate) surfacing: Surfacing,
    pub(crate) silence: Silence,
    pub(crate) adjustment: Adjustment,
    pub(crate) power: Power,
    pub(crate) dvl_trigger: DvlTrigger,
    pub(crate) topside: Topside,
    pub(crate) acoustic: Acoustic,
    pub(crate) hovering: Hovering,
    pub(crate) faults: Faults,
    pub(crate) empty_allowed: bool,
    pub(crate) mission_commands: MissionCommands,
    utc_at_start: Utc,
    version: Text,
    pub(crate) dive_file: Text,
    running_text: Text,
    profile: Profile,
    period: Duration,
    ticks: u64,
    next_tick: Timestamp,
    last_tick: Timestamp,
    grounded: bool,
    events: VecDeque<MvcEvent>,
    events_lost: u64,
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
        crate::soundings::check_start(start, file.start.depth_m, &world)?;
        crate::soundings::check(&plan, start, &world, file.vehicle.altitude_min_m, charted)?;
        let interpretation = Interpretation::new(&file.interpretation, seed);
        let period = Duration::from_nanos(1_000_000_000 / u64::from(file.vehicle.tick_hz.clamp(1, 100)));
        let at = start;
        let position = world.frame().to_position(at);
        let frame_convergence_deg = world.frame().convergence_deg(position);
        let heading_deg = file.start.heading_deg - frame_convergence_deg;
        let hull = file.vehicle.hull();
        let made = match file.vehicle.model {
            MotionModel::Kinematic => Vehicle::new,
            MotionModel::SixDof => Vehicle::with_body,
        };
        let mut vehicle = made(hull, file.vehicle.altitude_min_m, at, file.start.depth_m, heading_deg);
        let adjustment = Adjustment::new(file, seed);
        vehicle.rise_share = adjustment.rise_share();
        vehicle.sense(&world, Timestamp::ZERO);
        let hovering = Hovering::new(file, &world, &mut vehicle, seed);
        let sensors = Sensors::new(file, &vehicle, seed);
        let running = format!("{} {}", Status::Running.name(), file.mission.log_dir);
        Ok(Self {
            vehicle,
            executive: Executive::new(plan, &file.mission, &file.vehicle, interpretation, period),
            server: Server::new(&file.spi),
            interpretation,
            pending: VecDeque::new(),
            pending_s: file.spi.pending_s,
            acknowledge: file.spi.acknowledge,
            delays: Stream::new(seed, "acknowledgement delays"),
            frame_convergence_deg,
            grid_convergence_deg: utm_convergence_deg(position),
            sensors,
            surfacing: Surfacing::new(file, seed),
            silence: Silence::new(file, seed),
            adjustment,
            power: Power::new(file, seed),
            dvl_trigger: DvlTrigger::new(file, seed),
            topside: Topside::new(file, seed),
            acoustic: Acoustic::new(file, seed),
            hovering,
            faults: Faults::new(&file.faults)?,
            empty_allowed: file.mission.empty_allowed,
            mission_commands: MissionCommands::new(&file.mission.commands),
            utc_at_start: file.start.utc,
            version: Text::cleaned(&file.spi.version),
            dive_file: Text::cleaned(&file.mission.dive_file),
            running_text: Text::cleaned(running.trim_end()),
            profile: file.spi.profile,
            period,
            ticks: 0,
            next_tick: Timestamp::ZERO + period,
            last_tick: Timestamp::ZERO,
            grounded: false,
            events: VecDeque::new(),
            events_lost: 0,
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
        if !self.power.is_on() {
            self.server.cut_off(client, DropReason::PowerOff);
            self.settle(now);
            return;
        }
        let topics = match self.profile {
            Profile::Spec => 0,
            Profile::Field => Topic::Control.bit() | Topic::Mission.bit(),
        };
        if self.server.connect(client, address, topics) {
            self.note(now, MvcEventKind::Connected(client));
            if let Some(role) = self.server.role_of(client).map(Box::from) {
                self.note(now, MvcEventKind::RoleGiven(client, role));
            }
            let created = self.stamp(now);
            self.send(
                now,
                client,
                VehicleVersion {
                    created,
                    version: self.version.clone(),
                }
                .into(),
            );
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
        self.mute(client);
        if let Some(role) = self.server.disconnect(client) {
            self.note(now, MvcEventKind::Disconnected(client));
            if let Some(role) = role {
                self.note(now, MvcEventKind::RoleReleased(client, role));
            }
        }
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
                    Received::Malformed(name, text) => self.malformed(now, client, name, text),
                }
                self.settle(now);
            }
        }
        if let Some(what) = self.server.ignored(now, client) {
            self.note(now, MvcEventKind::Ignored(client, what));
        }
    }

    /// When [`Mvc::handle_timeout`] is due.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Timestamp> {
        let lapses = self.executive.lapses_at().unwrap_or(self.next_tick);
        Some(self.next_tick.min(lapses).min(self.faults.next()))
    }

    /// Takes every step of the vehicle that is due. A late call takes them all, each at its own time, so that a call
    /// an hour late costs an hour's steps. The inputs do the same before anything else.
    pub fn handle_timeout(&mut self, now: Timestamp) {
        loop {
            let fault = self.faults.next();
            let first = fault.min(self.executive.lapses_at().unwrap_or(Timestamp::MAX));
            if fault <= now && fault == first && fault <= self.next_tick {
                self.step_faults(fault);
                continue;
            }
            // A modify and a suspension lapse on time and not at the next step: their 5 s and 2 s are promises (SPI
            // 7.12, 8.1).
            if let Some(at) = self.executive.lapses_at().filter(|at| *at <= now.min(self.next_tick)) {
                self.executive.lapse(at);
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
        if self.events.is_empty() && self.events_lost > 0 {
            let lost = core::mem::take(&mut self.events_lost);
            return Some(MvcEvent {
                at: self.last_tick,
                kind: MvcEventKind::EventsLost(lost),
            });
        }
        self.events.pop_front()
    }

    /// The vehicle as it is after its last step.
    #[must_use]
    pub fn truth(&self) -> Truth {
        let vehicle = &self.vehicle;
        let position = self.frame().to_position(vehicle.at);
        let estimate = self.sensors.estimate(vehicle);
        Truth {
            time: self.last_tick,
            position,
            local: vehicle.at,
            believed: estimate.at,
            depth_m: vehicle.depth_m,
            believed_depth_m: estimate.depth_m,
            altitude_m: vehicle.water_depth_m - vehicle.depth_m,
            water_depth_m: vehicle.water_depth_m,
            heading_deg: true_heading(vehicle.heading_deg, self.frame(), position).as_deg(),
            speed_mps: vehicle.surge_mps,
            east_mps: vehicle.ground.0,
            north_mps: vehicle.ground.1,
            activity: self.executive.activity(),
            control: self.executive.control(),
        }
    }

    /// Whether the mission has completed, was aborted or was killed.
    #[must_use]
    pub fn mission_over(&self) -> bool {
        matches!(
            self.executive.status(),
            Status::Completed | Status::Aborted | Status::Stopped
        )
    }

    /// The mission's status.
    #[must_use]
    pub fn mission_status(&self) -> Status {
        self.executive.status()
    }

    /// Vehicle UTC, as its sentences carry it.
    #[must_use]
    pub fn utc(&self, now: Timestamp) -> Utc {
        self.utc_at_start + now.since(Timestamp::ZERO)
    }

    pub(crate) fn stamp(&self, now: Timestamp) -> TimeOfDay {
        self.utc(now).time_of_day()
    }

    /// When the vehicle's last step was.
    pub(crate) const fn last_tick(&self) -> Timestamp {
        self.last_tick
    }

    /// Sets the vehicle's clock forward or back.
    pub(crate) fn step_clock(&mut self, nanos: i64) {
        let utc = self.utc_at_start.as_unix_nanos().saturating_add_signed(nanos);
        self.utc_at_start = Utc::from_unix_nanos(utc);
    }

    /// Says now that the payload's power goes off, and when it does where that is not sooner anyway.
    pub(crate) fn shut_down(&mut self, now: Timestamp, at: Timestamp) {
        self.power.shut_down_at(at);
        self.watch_power(now);
    }

    /// Time between two steps of the vehicle.
    pub(crate) const fn period(&self) -> Duration {
        self.period
    }

    fn tick(&mut self, now: Timestamp) {
        self.resolve_pending(now);
        self.steer_hovering();
        let drive = self
            .executive
            .tick(now, &self.sensors.estimate(&self.vehicle), self.frame_convergence_deg);
        let drive = self.quieted(now, drive);
        self.vehicle
            .step(self.sensors.as_flown(drive), self.period.as_secs_f64());
        self.vehicle.sense(&self.world, now);
        if self.vehicle.grounded != self.grounded {
            self.grounded = self.vehicle.grounded;
            if self.grounded && drive != Drive::Held {
                self.note(now, MvcEventKind::Grounded);
            }
        }
        // The angles change by a hundred-thousandth of a degree a metre.
        if self.ticks.is_multiple_of(10) {
            let position = self.frame().to_position(self.vehicle.at);
            self.frame_convergence_deg = self.frame().convergence_deg(position);
            self.grid_convergence_deg = utm_convergence_deg(position);
        }
        self.settle(now);
        self.turn_devices();
        self.tick_sensors(now);
        self.tick_silence(now);
        self.tick_adjustment(now);
        self.tick_power(now);
        self.tick_dvl_trigger(now);
        self.tick_topside(now);
        self.tick_acoustic(now);
        self.tick_hovering(now);
        self.tick_mission_commands(now);
        self.settle(now);
    }

    /// Tells the clients and the log what the executive and the server have done.
    pub(crate) fn settle(&mut self, now: Timestamp) {
        if !self.executive.log.is_empty() {
            let mut log = core::mem::take(&mut self.executive.log);
            for kind in log.drain(..) {
                self.tell(now, &kind);
                self.note(now, kind);
            }
            // Nothing above asks the executive for more: its log is still empty, and keeps its room this way.
            self.executive.log = log;
        }
        while let Some((client, reason, role)) = self.server.dropped.pop_front() {
            self.mute(client);
            self.note(now, MvcEventKind::Dropped(client, reason));
            if let Some(role) = role {
                self.note(now, MvcEventKind::RoleReleased(client, role));
            }
        }
    }

    fn tell(&mut self, now: Timestamp, kind: &MvcEventKind) {
        let created = self.stamp(now);
        #[expect(
            clippy::wildcard_enum_match_arm,
            reason = "the rest is the vehicle's own affair, or acknowledged"
        )]
        match kind {
            MvcEventKind::Control(granted) => {
                self.publish(
                    now,
                    Some(Topic::Control),
                    &BackseatControl {
                        created,
                        granted: *granted,
                    }
                    .into(),
                );
            }
            MvcEventKind::Mission { status, details } => {
                let message = self.mission_message(now, *status, details.as_str());
                self.publish(now, Some(Topic::Mission), &message);
            }
            MvcEventKind::BehaviorBegan(behavior) => {
                let (dive_file, number, identifier, kind) = self.behavior_fields(*behavior);
                let message = BehaviorBegin {
                    created,
                    dive_file,
                    number,
                    identifier,
                    kind,
                };
                self.publish(now, Some(Topic::BehaviorBegin), &message.into());
            }
            MvcEventKind::BehaviorEnded(behavior, _) => {
                let (dive_file, number, identifier, kind) = self.behavior_fields(*behavior);
                let message = BehaviorEnd {
                    created,
                    dive_file,
                    number,
                    identifier,
                    kind,
                };
                self.publish(now, Some(Topic::BehaviorEnd), &message.into());
            }
            MvcEventKind::Executive(MissionEvent::Told { role, what, text }) => {
                let text = text.clone();
                let message = match what {
                    Told::Command => MissionCommand { created, text }.into(),
                    Told::LoggingBegins => LoggingBegin { created, text }.into(),
                    Told::LoggingEnds => LoggingEnd { created, text }.into(),
                };
                self.command_client(now, role.as_deref(), &message);
            }
            _ => {}
        }
    }

    /// A behavior as BFMBS and BFMBE give it (SPI 6.9): an insert has an identifier, an element file and number.
    fn behavior_fields(&self, behavior: Behavior) -> (Text, Option<u32>, Option<backseat_spi::BehaviorId>, Text) {
        let kind = Text::cleaned(behavior.kind);
        match behavior.source {
            Source::Plan(number) => (self.dive_file.clone(), Some(number), None, kind),
            Source::Insert(id) => (Text::default(), None, Some(id), kind),
            Source::Empty => (Text::default(), None, None, kind),
        }
    }

    pub(crate) fn mission_message(&self, now: Timestamp, status: Status, details: &str) -> FromVehicle {
        let text = match status {
            Status::Running => self.running_text.clone(),
            Status::Ready
            | Status::WrappingUp
            | Status::Aborting
            | Status::Completed
            | Status::Aborted
            | Status::Stopped => Text::cleaned(status.name()),
        };
        // An empty mission has no dive file.
        let dive_file = if self.executive.is_empty_mission() {
            Text::default()
        } else {
            self.dive_file.clone()
        };
        let details = Text::cleaned(details);
        MissionStatus {
            created: self.stamp(now),
            dive_file,
            status: text,
            details,
        }
        .into()
    }

    pub(crate) fn send(&mut self, now: Timestamp, client: ClientId, message: FromVehicle) {
        if let Err(name) = self.server.send(client, &message) {
            self.note(now, MvcEventKind::NotEncoded(name));
        }
    }

    pub(crate) fn publish(&mut self, now: Timestamp, topic: Option<Topic>, message: &FromVehicle) {
        if let Err(name) = self.server.publish(topic, message) {
            self.note(now, MvcEventKind::NotEncoded(name));
        }
    }

    pub(crate) fn note(&mut self, at: Timestamp, kind: MvcEventKind) {
        if self.events.len() < EVENTS_MAX {
            self.events.push_back(MvcEvent { at, kind });
        } else {
            self.events_lost += 1;
        }
    }
}
