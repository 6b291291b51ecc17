mod orders;

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::time::Duration;

use anyhow::Result;
use backseat_mvc::{ClientId, Direction, LinkFaults, MvcEvent};
use backseat_scenario::true_pose;
use backseat_units::Timestamp;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::mpsc;

use crate::clock::Clock;
use crate::mvc::connection::Connection;
use crate::mvc::log::Log;
use crate::mvc::operator::Lines;
use crate::mvc::status::Status;
use crate::mvc::vehicle_clock::VehicleClock;
use crate::peer::Heard;
use crate::plc::controller::{Controller, Inbox, Message};
use crate::speed::Speed;

/// A client with more unread bytes than this is disconnected: it is too slow, and nothing else waits for it.
const WAITING_MAX: usize = 1 << 20;
/// At `--speed max` the vehicle goes as fast as its clients read: it waits while this many bytes wait for one of them.
/// A client that reads nothing for [`STALL_MAX`] is disconnected.
const WAITING_AT_MAX_SPEED: usize = 1 << 16;
const STALL_MAX: Duration = Duration::from_secs(2);
/// At `--speed max` a client's first commands would arrive minutes late by the vehicle's clock. So the clock begins when
/// the clients that it waits for have said nothing for this long, and after [`SETTLE_MAX`] at the latest.
const SETTLE: Duration = Duration::from_millis(250);
const SETTLE_MAX: Duration = Duration::from_secs(2);
/// Overdue steps are taken for this long at most before clients are read again.
const STEPS_FOR: Duration = Duration::from_millis(5);
/// How much real time of the log a killed process can lose.
const FLUSH_EVERY: Duration = Duration::from_millis(200);
/// How long clients may take to read the last bytes at the end.
const FAREWELL: Duration = Duration::from_secs(1);
/// The pause after a client could not be accepted, for example when no file descriptor is left.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

struct Server {
    vehicle: backseat_mvc::Mvc,
    /// The payload controller on the vehicle.
    controller: Option<Controller>,
    faults: LinkFaults,
    clock: Clock,
    speed: Speed,
    vehicle_clock: VehicleClock,
    /// The vehicle's time, which never goes backwards.
    at: Timestamp,
    end: Option<Timestamp>,
    connections: BTreeMap<ClientId, Connection>,
    heard: mpsc::UnboundedSender<Heard>,
    clients: u32,
    log: Option<Log>,
    status: Status,
    spectators: Vec<Box<dyn Spectator>>,
    scratch: Vec<u8>,
    flush_at: Duration,
    accept_at: Duration,
    /// At the greatest speed the vehicle stands until the first of these times, and until the second at the latest.
    settling: Option<(Duration, Duration)>,
    sentences: (u64, u64),
}

/// What a served vehicle is made of.
pub(crate) struct Service {
    pub(crate) listener: TcpListener,
    pub(crate) vehicle: backseat_mvc::Mvc,
    pub(crate) faults: LinkFaults,
    /// The payload controller on the vehicle.
    pub(crate) controller: Option<(Controller, Inbox)>,
    pub(crate) clock: Clock,
    pub(crate) speed: Speed,
    /// How many clients must be connected before the vehicle's clock goes.
    pub(crate) wait: usize,
    pub(crate) end: Option<Timestamp>,
    pub(crate) log: Option<Log>,
    pub(crate) status: Status,
    /// Whoever sees what happens.
    pub(crate) spectators: Vec<Box<dyn Spectator>>,
    /// What the operator types.
    pub(crate) operator: Lines,
}

/// Whoever sees the vehicle after its steps, and perhaps what happens between them.
pub(crate) trait Spectator {
    /// The vehicle has taken a step.
    fn step(&mut self, vehicle: &backseat_mvc::Mvc);

    /// A client's line has arrived.
    fn received(&mut self, _line: &[u8]) {}

    /// Something has happened in the vehicle.
    fn event(&mut self, _event: &MvcEvent) {}
}

impl<F: FnMut(&backseat_mvc::Mvc)> Spectator for F {
    fn step(&mut self, vehicle: &backseat_mvc::Mvc) {
        self(vehicle);
    }
}

impl Service {
    /// Serves until `ended`, or until the vehicle's time has reached the end. Returns the vehicle as it is then, and how
    /// many clients it has served.
    ///
    /// # Errors
    ///
    /// If a file is incomplete: the log, or one of the payload controller.
    pub(crate) async fn serve(self, ended: impl Future<Output = ()>) -> Result<(backseat_mvc::Mvc, u32)> {
        let listener = self.listener;
        let mut operator = self.operator;
        let (heard_by, mut heard) = mpsc::unbounded_channel();
        let (controller, mut inbox) = self.controller.unzip();
        let mut server = Server {
            vehicle: self.vehicle,
            controller,
            faults: self.faults,
            clock: self.clock,
            speed: self.speed,
            vehicle_clock: VehicleClock::new(self.clock, self.speed, self.wait),
            at: Timestamp::ZERO,
            end: self.end,
            connections: BTreeMap::new(),
            heard: heard_by,
            clients: 0,
            log: self.log,
            status: self.status,
            spectators: self.spectators,
            scratch: Vec::new(),
            flush_at: Duration::ZERO,
            accept_at: Duration::ZERO,
            settling: None,
            sentences: (0, 0),
        };
        server
            .status
            .say(Duration::ZERO, &format!("listening on {}", listener.local_addr()?));
        server.tell_of_waiting();
        let mut ended = std::pin::pin!(ended);
        while !server.ended() {
            // The vehicle comes first, whatever its clients do; each client has at most one read waiting here.
            server.step();
            while let Ok(what) = heard.try_recv() {
                server.hear(what);
                server.step();
            }
            server.play_faults();
            server.look_after();
            tokio::select! {
                biased;
                () = &mut ended => break,
                accepted = listener.accept(), if server.clock.elapsed() >= server.accept_at => match accepted {
                    Ok((stream, address)) => server.welcome(stream, address),
                    Err(error) => server.not_accepted(&error),
                },
                Some(what) = heard.recv() => server.hear(what),
                message = next(&mut inbox) => server.pass(message),
                line = operator.next() => server.obey(&line),
                () = server.wait() => {}
            }
        }
        server.say_farewell(&mut heard).await;
        let now = server.at;
        let ended = match (&mut server.controller, &mut inbox) {
            (Some(controller), Some(inbox)) => controller.end(now, inbox).await,
            _ => Ok(()),
        };
        server.tell_of_controller();
        let clients = server.clients;
        let (vehicle, finished) = server.finish();
        ended.and(finished).map(|()| (vehicle, clients))
    }
}

/// The next message for the payload controller; never without one.
async fn next(inbox: &mut Option<Inbox>) -> Message {
    match inbox {
        Some(inbox) => inbox.next().await,
        None => std::future::pending().await,
    }
}

impl Server {
    /// The vehicle's time, never later than the next step.
    fn now(&mut self) -> Timestamp {
        let now = self.vehicle_clock.now(self.at);
        let due = self.vehicle.poll_timeout().unwrap_or(now);
        let now = self.end.map_or(now, |end| now.min(end));
        self.at = self.at.max(now.min(due));
        self.at
    }

    fn ended(&self) -> bool {
        self.end.is_some_and(|end| self.at >= end)
    }

    /// Waits until there is something to do.
    async fn wait(&self) {
        let soon = self.clock.now() + Duration::from_millis(100);
        let pings = self.controller.as_ref().and_then(Controller::next);
        match (self.vehicle.poll_timeout(), self.speed) {
            (Some(_), Speed::Max) if !self.held() => tokio::task::yield_now().await,
            (Some(due), Speed::Times(_)) => {
                let due = [self.arrives(), pings].into_iter().flatten().fold(due, Timestamp::min);
                let real = self.vehicle_clock.real(due).unwrap_or(soon);
                self.clock.sleep_until(real.min(soon)).await;
            }
            (_, Speed::Max) | (None, Speed::Times(_)) => {
                self.clock.sleep_until(soon).await;
            }
        }
    }

    /// Whether the vehicle waits: for clients to connect, or at the greatest speed for one of them to read.
    fn held(&self) -> bool {
        let slow = |connection: &Connection| connection.peer.waiting() > WAITING_AT_MAX_SPEED;
        let settles = |(quiet, latest): (Duration, Duration)| self.clock.elapsed() < quiet.min(latest);
        let stands = self.vehicle_clock.waits_for().is_some() || self.settling.is_some_and(settles);
        stands || self.speed == Speed::Max && self.connections.values().any(slow)
    }

    /// Takes all due steps, each at its own time, so that a late wake-up changes no result.
    fn step(&mut self) {
        let until = self.clock.elapsed() + STEPS_FOR;
        while !self.ended() && !self.held() {
            let Some(due) = self.vehicle.poll_timeout() else { return };
            if self.speed == Speed::Max {
                self.at = self.at.max(self.end.map_or(due, |end| due.min(end)));
            }
            let now = self.now();
            if due > now {
                if let Some(controller) = &mut self.controller {
                    controller.advance(now);
                }
                self.tell_of_controller();
                return;
            }
            self.vehicle.handle_timeout(due);
            self.collect(due);
            if let Some(controller) = &mut self.controller {
                controller.truth(due, true_pose(&self.vehicle));
            }
            self.tell_of_controller();
            for spectator in &mut self.spectators {
                spectator.step(&self.vehicle);
            }
            self.play_faults();
            self.flush();
            if self.clock.elapsed() >= until {
                return;
            }
        }
    }

    fn welcome(&mut self, stream: TcpStream, address: SocketAddr) {
        self.clients = self.clients.wrapping_add(1);
        let client = ClientId(self.clients);
        let now = self.now();
        self.tell(now, &format!("{client} connected from {address}"));
        match Connection::open(client, stream, self.heard.clone(), self.clock) {
            Ok(mut connection) => {
                if self.faults.refuses(now, client, None) {
                    connection.peer.reset();
                    self.tell(now, &format!("{client} is refused by a fault"));
                    return;
                }
                self.vehicle.connect_from(now, client, Some(address));
                let role = self.vehicle.role(client);
                if !self.faults.is_empty() {
                    let to = self.faults.link(now, client, role, Direction::ToVehicle);
                    let from = self.faults.link(now, client, role, Direction::FromVehicle);
                    connection.faults = Some(Box::new((to, from)));
                }
                let refused = role.is_some() && self.faults.refuses(now, client, role);
                self.connections.insert(client, connection);
                if refused {
                    self.cut(now, client);
                }
                self.collect(now);
                self.flush();
                self.count_connected();
            }
            Err(error) => self.tell(now, &format!("{client} disconnected: {error}")),
        }
    }

    fn not_accepted(&mut self, error: &std::io::Error) {
        self.accept_at = self.clock.elapsed() + ACCEPT_PAUSE;
        let now = self.now();
        self.tell(now, &format!("a client could not be accepted: {error}"));
    }

    fn hear(&mut self, what: Heard) {
        let now = self.now();
        if let Some((quiet, _)) = &mut self.settling {
            *quiet = self.clock.elapsed() + SETTLE;
        }
        match what {
            // The permit is dropped at the end, which allows the client's next read.
            Heard::Bytes(client, bytes, _permit) => {
                let client = ClientId(client);
                let connection = self.connections.get_mut(&client);
                let passed = match connection.and_then(|connection| connection.faults.as_mut()) {
                    Some(faults) => faults.0.pass(now, &bytes),
                    None => Some(&*bytes),
                };
                self.receive(now, client, passed.unwrap_or_default());
            }
            Heard::Writable(client) => {
                if let Some(connection) = self.connections.get_mut(&ClientId(client)) {
                    connection.peer.writable();
                }
            }
            Heard::Gone(client) => self.close(now, ClientId(client)),
        }
        self.collect(now);
        self.flush();
    }

    /// Passes a message to the payload controller.
    fn pass(&mut self, message: Message) {
        let now = self.now();
        if let Some(controller) = &mut self.controller {
            controller.take(now, message);
        }
        self.tell_of_controller();
    }

    fn tell_of_controller(&mut self) {
        while let Some((at, line)) = self.controller.as_mut().and_then(Controller::poll_line) {
            let line = format!("plc: {line}");
            let shown = format!("{:.3} s: {line}", at.as_secs_f64());
            self.status.say(self.clock.elapsed(), &shown);
            if let Some(log) = &mut self.log {
                log.event(at, &line);
            }
        }
    }

    /// Handles the bytes line by line, so that the log has each answer after its command.
    fn receive(&mut self, now: Timestamp, client: ClientId, bytes: &[u8]) {
        let Some(connection) = self.connections.get_mut(&client) else {
            return;
        };
        let mut cutter = std::mem::take(&mut connection.cutter);
        cutter.cut(bytes, |line| {
            if !self.connections.contains_key(&client) {
                return;
            }
            if let Some(log) = &mut self.log {
                log.received(now, client, line);
            }
            self.sentences.0 += 1;
            self.status.command(client, line);
            for spectator in &mut self.spectators {
                spectator.received(line);
            }
            self.vehicle.receive(now, client, line);
            self.collect(now);
        });
        if let Some(connection) = self.connections.get_mut(&client) {
            connection.cutter = cutter;
        }
    }

    /// Delivers what links with faults have held back, and resets connections that a fault cuts.
    fn play_faults(&mut self) {
        if self.faults.is_empty() {
            return;
        }
        let now = self.now();
        let clients: Vec<ClientId> = self.connections.keys().copied().collect();
        for client in clients {
            match self
                .connections
                .get_mut(&client)
                .map(|connection| connection.arrived(now))
            {
                Some(Some(bytes)) if !bytes.is_empty() => self.receive(now, client, &bytes),
                Some(None) => self.cut(now, client),
                Some(Some(_)) | None => {}
            }
        }
        self.flush();
    }

    /// When the next link with a fault delivers something.
    fn arrives(&self) -> Option<Timestamp> {
        self.connections.values().filter_map(Connection::arrives).min()
    }

    fn cut(&mut self, now: Timestamp, client: ClientId) {
        if let Some(connection) = self.connections.get_mut(&client) {
            connection.peer.reset();
        }
        self.tell(now, &format!("{client} is cut off by a fault"));
        self.close(now, client);
    }

    fn close(&mut self, now: Timestamp, client: ClientId) {
        let Some(connection) = self.connections.remove(&client) else {
            return;
        };
        if let Some(log) = &mut self.log {
            log.received(now, client, connection.cutter.rest());
        }
        self.vehicle.disconnect(now, client);
        self.collect(now);
        self.tell_of_waiting();
    }

    /// Takes the vehicle's output: bytes for its clients, disconnections and log events.
    fn collect(&mut self, now: Timestamp) {
        let real = self.clock.elapsed();
        while let Some(fault) = self.vehicle.poll_link_fault() {
            self.break_links(&fault);
        }
        while let Some(event) = self.vehicle.poll_event() {
            self.status.event(real, &event);
            for spectator in &mut self.spectators {
                spectator.event(&event);
            }
            if let Some(log) = &mut self.log {
                log.event(event.at, &event.kind.to_string());
            }
        }
        let mut buffer = std::mem::take(&mut self.scratch);
        while let Some(client) = self.vehicle.poll_transmit(&mut buffer) {
            if let Some(log) = &mut self.log {
                log.sent(now, client, &buffer);
            }
            self.sentences.1 += 1;
            if let Some(connection) = self.connections.get_mut(&client) {
                connection.send(now, &buffer);
            }
        }
        self.scratch = buffer;
        while let Some(client) = self.vehicle.poll_disconnect() {
            self.connections.remove(&client);
        }
    }

    /// Writes to every client what it takes now, and disconnects clients that read too slowly.
    fn flush(&mut self) {
        let real = self.clock.elapsed();
        let max_speed = self.speed == Speed::Max;
        let mut lost = Vec::new();
        for (client, connection) in &mut self.connections {
            if connection.peer.waiting() == 0 {
                continue;
            }
            if let Err(error) = connection.peer.flush(real) {
                lost.push((*client, format!("{client} disconnected: {error}")));
            } else if connection.peer.waiting() > WAITING_MAX
                || max_speed && connection.peer.stalled().is_some_and(|since| real > since + STALL_MAX)
            {
                lost.push((*client, format!("{client} does not read: cut off")));
            }
        }
        for (client, text) in lost {
            let now = self.now();
            self.tell(now, &text);
            self.close(now, client);
        }
    }

    /// Occasional work: flushes the log and updates the status line.
    fn look_after(&mut self) {
        let real = self.clock.elapsed();
        if real < self.flush_at {
            return;
        }
        self.flush_at = real + FLUSH_EVERY;
        self.flush();
        if let Some(log) = &mut self.log {
            log.flush();
        }
        self.status.update(real, &self.vehicle, self.connections.len());
    }

    fn tell(&mut self, now: Timestamp, text: &str) {
        self.status.say(self.clock.elapsed(), text);
        if let Some(log) = &mut self.log {
            log.event(now, text);
        }
    }

    /// Waits for the clients to read their last bytes.
    async fn say_farewell(&mut self, heard: &mut mpsc::UnboundedReceiver<Heard>) {
        let until = self.clock.now() + FAREWELL;
        while self
            .connections
            .values()
            .any(|connection| connection.peer.waiting() > 0)
        {
            tokio::select! {
                Some(what) = heard.recv() => match what {
                    Heard::Writable(client) => {
                        if let Some(connection) = self.connections.get_mut(&ClientId(client)) {
                            connection.peer.writable();
                        }
                        self.flush();
                    }
                    Heard::Gone(client) => {
                        self.connections.remove(&ClientId(client));
                    }
                    // Too late for the vehicle.
                    Heard::Bytes(..) => {}
                },
                () = self.clock.sleep_until(until) => return,
            }
        }
    }

    fn finish(mut self) -> (backseat_mvc::Mvc, Result<()>) {
        self.status.end();
        let (lines, writes) = self.sentences;
        let text = format!(
            "{:.1} s of the vehicle's time in {:.1} s; {} clients served, {lines} lines received, {writes} writes",
            self.at.as_secs_f64(),
            self.clock.elapsed().as_secs_f64(),
            self.clients,
        );
        self.status.say(self.clock.elapsed(), &text);
        (self.vehicle, self.log.map_or(Ok(()), Log::finish))
    }
}
