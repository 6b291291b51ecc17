//! The mock vehicle as a TCP server: for our own runtime and for any other SPI client.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context, Result, bail};
use backseat_mission::Mission;
use backseat_mvc::{Activity, ClientId};
use backseat_units::Timestamp;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::tcp::{OwnedReadHalf, OwnedWriteHalf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::mpsc;
use tracing::{info, warn};

use crate::cli::{Mvc, Profile, Speed};
use crate::clock::Clock;

/// Writes that wait for one client before it is cut off: it is too slow, and nobody else waits for it.
const WRITES_MAX: usize = 1024;
const STATUS_EVERY: Duration = Duration::from_secs(60);
/// How much of the log a killed process can cost, real time.
const FLUSH_EVERY: Duration = Duration::from_millis(500);

pub(crate) fn mvc(arguments: &Mvc) -> Result<bool> {
    let mission = Mission::load(&arguments.mission.mission, &arguments.mission.layers())?;
    let mut world = mission.world()?.clone();
    match arguments.profile {
        Some(Profile::Spec) => world.spi.profile = backseat_mvc::Profile::Spec,
        Some(Profile::Field) => world.spi.profile = backseat_mvc::Profile::Field,
        None => {}
    }
    let vehicle = mission.vehicle(&world, arguments.seed)?;
    let log = match &arguments.log {
        Some(path) => Some(Log::create(path)?),
        None => None,
    };
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    runtime.block_on(serve(arguments, vehicle, log))?;
    Ok(true)
}

/// Every sentence both ways and every event, each with the vehicle's clock.
struct Log {
    file: BufWriter<File>,
    path: PathBuf,
    failed: bool,
}

impl Log {
    fn create(path: &Path) -> Result<Self> {
        let file = File::create(path).with_context(|| format!("{}", path.display()))?;
        Ok(Self {
            file: BufWriter::new(file),
            path: path.to_path_buf(),
            failed: false,
        })
    }

    fn lines(&mut self, now: Timestamp, mark: &str, bytes: &[u8]) {
        if self.failed {
            return;
        }
        let text = String::from_utf8_lossy(bytes);
        for line in text.lines().filter(|line| !line.is_empty()) {
            if let Err(error) = writeln!(self.file, "{:.3} {mark} {line}", now.as_secs_f64()) {
                warn!(
                    "{}: {error}; the log ends here, the vehicle goes on",
                    self.path.display()
                );
                self.failed = true;
                return;
            }
        }
    }

    fn flush(&mut self) {
        if !self.failed && self.file.flush().is_err() {
            self.failed = true;
        }
    }
}

/// What a client's reader says.
enum Heard {
    Bytes(ClientId, Vec<u8>),
    Gone(ClientId),
}

struct Server {
    vehicle: backseat_mvc::Mvc,
    clock: Clock,
    speed: Speed,
    /// Virtual time where there is no pace.
    fastest: Timestamp,
    writers: BTreeMap<ClientId, mpsc::Sender<Vec<u8>>>,
    log: Option<Log>,
    scratch: Vec<u8>,
}

async fn serve(arguments: &Mvc, vehicle: backseat_mvc::Mvc, log: Option<Log>) -> Result<()> {
    let listener = match TcpListener::bind(&arguments.listen).await {
        Ok(listener) => listener,
        Err(error) if error.kind() == std::io::ErrorKind::AddrInUse => {
            bail!(
                "{} is in use: stop what listens there, or choose another with --listen",
                arguments.listen
            )
        }
        Err(error) => return Err(error).with_context(|| format!("cannot listen on {}", arguments.listen)),
    };
    info!("listening on {}", listener.local_addr()?);
    let (heard_by, mut heard) = mpsc::channel(256);
    let mut server = Server {
        vehicle,
        clock: Clock::start(),
        speed: arguments.speed,
        fastest: Timestamp::ZERO,
        writers: BTreeMap::new(),
        log,
        scratch: Vec::new(),
    };
    let mut clients = 0;
    let mut status_at = Timestamp::ZERO;
    let mut flush_at = Duration::ZERO;
    let mut terminate = tokio::signal::unix::signal(tokio::signal::unix::SignalKind::terminate())?;
    loop {
        let due = server.vehicle.poll_timeout();
        tokio::select! {
            () = server.wait(due) => {
                server.step();
                if server.now() >= status_at {
                    server.status();
                    status_at = server.now() + STATUS_EVERY;
                }
                if server.clock.elapsed() >= flush_at {
                    flush_at = server.clock.elapsed() + FLUSH_EVERY;
                    server.flush();
                }
            }
            accepted = listener.accept() => match accepted {
                Ok((stream, address)) => {
                    clients += 1;
                    info!("client {clients} is {address}");
                    server.welcome(ClientId(clients), stream, &heard_by);
                }
                Err(error) => warn!("a client could not be accepted: {error}"),
            },
            Some(what) = heard.recv() => server.hear(what),
            _ = tokio::signal::ctrl_c() => break,
            _ = terminate.recv() => break,
        }
    }
    server.flush();
    Ok(())
}

impl Server {
    /// The vehicle's time.
    fn now(&self) -> Timestamp {
        match self.speed {
            Speed::Times(times) => Timestamp::ZERO + self.clock.elapsed().mul_f64(times),
            Speed::Max => self.fastest,
        }
    }

    async fn wait(&self, due: Option<Timestamp>) {
        match (due, self.speed) {
            (None, _) => std::future::pending().await,
            (Some(_), Speed::Max) => tokio::task::yield_now().await,
            (Some(due), Speed::Times(times)) => {
                let real = Timestamp::ZERO + Duration::from_nanos(due.as_nanos()).div_f64(times);
                tokio::time::sleep_until(self.clock.instant(real)).await;
            }
        }
    }

    fn step(&mut self) {
        if let Some(due) = self.vehicle.poll_timeout() {
            self.fastest = self.fastest.max(due);
        }
        // Each step at its own time, so that a late wake-up changes nothing.
        let now = self.now();
        while let Some(due) = self.vehicle.poll_timeout().filter(|due| *due <= now) {
            self.vehicle.handle_timeout(due);
            self.drain(due);
        }
    }

    fn welcome(&mut self, client: ClientId, stream: TcpStream, heard: &mpsc::Sender<Heard>) {
        if let Err(error) = stream.set_nodelay(true) {
            warn!("{client}: {error}");
        }
        let (reader, writer) = stream.into_split();
        let (sender, receiver) = mpsc::channel(WRITES_MAX);
        self.writers.insert(client, sender);
        tokio::spawn(read(client, reader, heard.clone()));
        tokio::spawn(write(writer, receiver));
        let now = self.now();
        self.vehicle.connect(now, client);
        self.drain(now);
    }

    fn hear(&mut self, what: Heard) {
        let now = self.now();
        match what {
            Heard::Bytes(client, bytes) if self.writers.contains_key(&client) => {
                if let Some(log) = &mut self.log {
                    log.lines(now, &format!("< {client}"), &bytes);
                }
                self.vehicle.receive(now, client, &bytes);
            }
            Heard::Bytes(..) => {}
            Heard::Gone(client) => {
                if self.writers.remove(&client).is_some() {
                    self.vehicle.disconnect(now, client);
                }
            }
        }
        self.drain(now);
    }

    fn drain(&mut self, now: Timestamp) {
        let mut slow = Vec::new();
        let mut buffer = std::mem::take(&mut self.scratch);
        while let Some(client) = self.vehicle.poll_transmit(&mut buffer) {
            if let Some(log) = &mut self.log {
                log.lines(now, &format!("> {client}"), &buffer);
            }
            if let Some(writer) = self.writers.get(&client)
                && writer.try_send(buffer.clone()).is_err()
            {
                slow.push(client);
            }
        }
        self.scratch = buffer;
        while let Some(client) = self.vehicle.poll_disconnect() {
            self.writers.remove(&client);
        }
        for client in slow {
            if self.writers.remove(&client).is_some() {
                warn!("{client} does not read: cut off");
                self.vehicle.disconnect(now, client);
            }
        }
        while let Some(event) = self.vehicle.poll_event() {
            info!("{event}");
            if let Some(log) = &mut self.log {
                log.lines(now, "--", event.kind.to_string().as_bytes());
                log.flush();
            }
        }
    }

    fn status(&mut self) {
        let truth = self.vehicle.truth();
        let doing = match truth.activity {
            Activity::Waiting => "waiting for its mission".to_owned(),
            Activity::Plan { number } => format!("on element {number} of its plan"),
            Activity::Insert { id } => format!("on insert {}", id.get()),
            Activity::Modified { .. } => "modified by a payload".to_owned(),
            Activity::Suspended => "suspended by a payload".to_owned(),
            Activity::WrappingUp => "wrapping up".to_owned(),
            Activity::Stopped => "stopped".to_owned(),
        };
        info!(
            "{:.0} s: {doing}; {:.5} {:.5}, depth {:.1} m over {:.1} m of water, heading {:.0}, {:.1} m/s; {} clients",
            truth.time.as_secs_f64(),
            truth.position.latitude.as_deg(),
            truth.position.longitude.as_deg(),
            truth.depth_m,
            truth.water_depth_m,
            truth.heading_deg,
            truth.speed_mps,
            self.writers.len(),
        );
    }

    fn flush(&mut self) {
        if let Some(log) = &mut self.log {
            log.flush();
        }
    }
}

async fn read(client: ClientId, mut reader: OwnedReadHalf, heard: mpsc::Sender<Heard>) {
    let mut buffer = vec![0; 16 * 1024];
    loop {
        let what = match reader.read(&mut buffer).await {
            Ok(0) | Err(_) => Heard::Gone(client),
            Ok(read) => Heard::Bytes(client, buffer[..read].to_vec()),
        };
        let gone = matches!(what, Heard::Gone(_));
        if heard.send(what).await.is_err() || gone {
            return;
        }
    }
}

async fn write(mut writer: OwnedWriteHalf, mut what: mpsc::Receiver<Vec<u8>>) {
    while let Some(bytes) = what.recv().await {
        if writer.write_all(&bytes).await.is_err() {
            return;
        }
    }
}
