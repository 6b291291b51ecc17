use std::collections::{BTreeMap, VecDeque};
use std::net::SocketAddr;
use std::time::Duration;

use anyhow::{Context, Result, bail};
use backseat_plc::{ClientId, FileFailure, Plc, Pose, Reported, Stored};
use backseat_scenario::{Scenario, Soundings};
use backseat_units::{Timestamp, Utc};
use backseat_world::World;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::OwnedSemaphorePermit;
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};

use super::disk::{Disk, Folder, Report};
use crate::clock::Clock;
use crate::output::escaped;
use crate::peer::{Heard, Peer, listen};

/// The pause after a client could not be accepted, for example when no file descriptor is left.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);
/// How long clients may take to read the last bytes at the end.
const FAREWELL: Duration = Duration::from_secs(1);
/// How long the disk may take to write the last bytes at the end.
const LAST_WRITES: Duration = Duration::from_secs(10);
/// A megabyte, as `[plc.disk]` counts it.
const MEGABYTE: f64 = 1e6;

/// The mock payload controller with its clients and its disk. The owner gives it the time.
pub(crate) struct Controller {
    plc: Plc,
    soundings: Soundings<World>,
    clients: BTreeMap<ClientId, Client>,
    /// How many clients have connected so far.
    served: u32,
    heard: UnboundedSender<Heard>,
    clock: Clock,
    disk: Option<Disk>,
    lines: VecDeque<(Timestamp, String)>,
    scratch: Vec<u8>,
}

struct Client {
    peer: Peer,
    /// While the controller takes no bytes of this client, its next read waits for this permit.
    permit: Option<OwnedSemaphorePermit>,
}

/// What a controller is told from outside.
pub(crate) enum Message {
    Accepted(TcpStream, SocketAddr),
    NotAccepted(std::io::Error),
    Heard(Heard),
    Disk(Report),
}

/// Where messages for a controller arrive.
pub(crate) struct Inbox {
    listener: TcpListener,
    accept_at: Duration,
    clock: Clock,
    heard: UnboundedReceiver<Heard>,
    reports: UnboundedReceiver<Report>,
}

impl Inbox {
    /// The address on which the controller listens.
    pub(crate) fn address(&self) -> std::io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// The next message. A call that is given up loses none.
    pub(crate) async fn next(&mut self) -> Message {
        tokio::select! {
            biased;
            Some(report) = self.reports.recv() => Message::Disk(report),
            accepted = self.listener.accept(), if self.clock.elapsed() >= self.accept_at => match accepted {
                Ok((stream, address)) => Message::Accepted(stream, address),
                Err(error) => {
                    self.accept_at = self.clock.elapsed() + ACCEPT_PAUSE;
                    Message::NotAccepted(error)
                }
            },
            // The controller keeps a sender, so there is always another message to wait for.
            Some(heard) = self.heard.recv() => Message::Heard(heard),
        }
    }
}

/// What a controller needs from the command line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Setup<'a> {
    pub(crate) address: &'a str,
    /// The option that chooses another address.
    pub(crate) option: &'static str,
    pub(crate) folder: Option<&'a std::path::Path>,
    pub(crate) seed: u64,
    /// The true UTC at time zero.
    pub(crate) utc: Utc,
}

impl Controller {
    /// A controller of this scenario that listens. A mission without a table `[plc]` has the defaults of all keys.
    ///
    /// # Errors
    ///
    /// In one line: the address, the folder, or what an earlier run left in it.
    pub(crate) async fn start(scenario: &Scenario, setup: Setup<'_>, clock: Clock) -> Result<(Self, Inbox)> {
        let mut scenario = scenario.clone();
        let config = scenario.plc.get_or_insert_default();
        let (report, reports) = unbounded_channel();
        let mut stored = Stored::default();
        let mut logs = Vec::new();
        let disk = match setup.folder {
            Some(path) => {
                let folder = Folder::open(path, &config.logging.folder)?;
                let (size, free) = folder.space()?;
                config.disk.capacity_mb = (size as f64 / MEGABYTE).clamp(1.0, 1e9);
                config.disk.used_mb = (config.disk.capacity_mb - free as f64 / MEGABYTE).max(0.0);
                stored = folder.stored()?;
                logs = folder.logs()?;
                Some(Disk::start(folder, report)?)
            }
            None => None,
        };
        let named = || {
            setup
                .folder
                .map_or_else(String::new, |folder| folder.display().to_string())
        };
        let made = scenario
            .controller(setup.seed, setup.utc, &stored)
            .with_context(named)?;
        let Some(mut plc) = made else {
            bail!("{}: the table [plc] is missing", scenario.path.display())
        };
        logs.into_iter().for_each(|place| plc.keep_file(place));
        let soundings = scenario.soundings(setup.seed)?;
        let listener = listen(setup.address, setup.option).await?;
        let (heard_by, heard) = unbounded_channel();
        let mut controller = Self {
            plc,
            soundings,
            clients: BTreeMap::new(),
            served: 0,
            heard: heard_by,
            clock,
            disk,
            lines: VecDeque::new(),
            scratch: Vec::new(),
        };
        let files = setup.folder.map_or_else(
            || "files are not kept".to_owned(),
            |folder| format!("files in {}", folder.display()),
        );
        let line = format!("payload controller at {}; {files}", listener.local_addr()?);
        controller.lines.push_back((Timestamp::ZERO, line));
        controller.collect(Timestamp::ZERO);
        let inbox = Inbox {
            listener,
            accept_at: Duration::ZERO,
            clock,
            heard,
            reports,
        };
        Ok((controller, inbox))
    }

    /// How many clients have connected so far.
    pub(crate) const fn served(&self) -> u32 {
        self.served
    }

    /// Whether it is shut down for good.
    pub(crate) const fn is_shut_down(&self) -> bool {
        self.plc.is_shut_down()
    }

    /// What clients say of the vehicle.
    pub(crate) fn reported(&self) -> Option<Reported> {
        self.plc.reported()
    }

    /// When to call [`Controller::advance`].
    pub(crate) fn next(&self) -> Option<Timestamp> {
        self.plc.poll_timeout()
    }

    /// The next line about what happened, with its time.
    pub(crate) fn poll_line(&mut self) -> Option<(Timestamp, String)> {
        self.lines.pop_front()
    }

    /// Does everything that is due.
    pub(crate) fn advance(&mut self, now: Timestamp) {
        if self.plc.poll_timeout().is_some_and(|due| due <= now) {
            self.plc.handle_timeout(now, &mut self.soundings);
            self.collect(now);
        }
    }

    /// Where the vehicle truly is.
    pub(crate) fn truth(&mut self, now: Timestamp, pose: Pose) {
        self.advance(now);
        self.plc.truth(now, pose);
    }

    /// Takes a message.
    pub(crate) fn take(&mut self, now: Timestamp, message: Message) {
        self.advance(now);
        match message {
            Message::Accepted(stream, address) => self.welcome(now, stream, address),
            Message::NotAccepted(error) => self.tell(now, format!("a client could not be accepted: {error}")),
            Message::Heard(Heard::Bytes(number, bytes, permit)) => {
                let id = ClientId(number);
                // What is still under way of a client that is gone is for nobody.
                if let Some(client) = self.clients.get_mut(&id) {
                    client.permit = Some(permit);
                    self.plc.receive(now, id, &bytes);
                }
            }
            Message::Heard(Heard::Writable(number)) => {
                if let Some(client) = self.clients.get_mut(&ClientId(number)) {
                    client.peer.writable();
                    self.flush(now, ClientId(number));
                }
            }
            Message::Heard(Heard::Gone(number)) => self.lose(now, ClientId(number)),
            Message::Disk(Report::Free(bytes)) => self.plc.set_disk_free(now, bytes),
            Message::Disk(Report::Failed(file, failure, text)) => {
                self.tell(now, text);
                self.plc.file_failed(now, file, failure);
            }
        }
        self.collect(now);
    }

    fn welcome(&mut self, now: Timestamp, stream: TcpStream, address: SocketAddr) {
        self.served = self.served.wrapping_add(1);
        let id = ClientId(self.served);
        self.tell(now, format!("{id} is {address}"));
        match Peer::open(id.0, stream, self.heard.clone(), self.clock) {
            Ok(peer) => {
                self.clients.insert(id, Client { peer, permit: None });
                self.plc.connect(now, id);
            }
            Err(error) => self.tell(now, format!("{id} disconnected: {error}")),
        }
    }

    fn lose(&mut self, now: Timestamp, id: ClientId) {
        if self.clients.remove(&id).is_some() {
            self.plc.disconnect(now, id);
        }
    }

    /// Carries out what the controller wants: files first, because a failure changes the rest.
    fn collect(&mut self, now: Timestamp) {
        while let Some(effect) = self.plc.poll_file() {
            let lost = self.disk.as_mut().and_then(|disk| disk.carry_out(effect));
            if let Some(file) = lost {
                self.tell(now, "the disk is too slow: too much waits to be written".to_owned());
                self.plc.file_failed(now, file, FileFailure::Other);
            }
        }
        let mut bytes = std::mem::take(&mut self.scratch);
        while let Some(id) = self.plc.poll_transmit(&mut bytes) {
            if let Some(client) = self.clients.get_mut(&id) {
                client.peer.send(&bytes);
                self.flush(now, id);
            }
        }
        self.scratch = bytes;
        while let Some(id) = self.plc.poll_disconnect() {
            self.clients.remove(&id);
        }
        while let Some(event) = self.plc.poll_event() {
            self.lines
                .push_back((event.at, escaped(&event.kind.to_string(), char::is_control)));
        }
        for (id, client) in &mut self.clients {
            if client.permit.is_some() && self.plc.reads(*id) {
                client.permit = None;
            }
        }
    }

    /// Writes what a client takes now. While it takes no more, the controller keeps what is for it.
    fn flush(&mut self, now: Timestamp, id: ClientId) {
        let Some(client) = self.clients.get_mut(&id) else {
            return;
        };
        match client.peer.flush(self.clock.elapsed()) {
            Ok(()) => {
                let blocked = client.peer.waiting() > 0;
                self.plc.set_blocked(now, id, blocked);
            }
            Err(error) => {
                self.tell(now, format!("{id}: {error}"));
                self.lose(now, id);
            }
        }
    }

    fn tell(&mut self, now: Timestamp, text: String) {
        self.lines.push_back((now, text));
    }

    /// Shuts the controller down, waits a moment for its clients to read the last bytes, and until its files are whole.
    ///
    /// # Errors
    ///
    /// If the disk does not take the last bytes.
    pub(crate) async fn end(&mut self, now: Timestamp, inbox: &mut Inbox) -> Result<()> {
        self.plc.shut_down(now);
        self.collect(now);
        let until = self.clock.instant(self.clock.now() + FAREWELL);
        while self.clients.values().any(|client| client.peer.waiting() > 0) {
            tokio::select! {
                message = inbox.next() => match message {
                    Message::Heard(Heard::Writable(number)) => {
                        if let Some(client) = self.clients.get_mut(&ClientId(number)) {
                            client.peer.writable();
                        }
                        self.flush(now, ClientId(number));
                        self.collect(now);
                    }
                    Message::Heard(Heard::Gone(number)) => {
                        self.clients.remove(&ClientId(number));
                    }
                    // Too late for the controller.
                    Message::Heard(Heard::Bytes(..))
                    | Message::Accepted(..)
                    | Message::NotAccepted(_)
                    | Message::Disk(_) => {}
                },
                () = tokio::time::sleep_until(until) => break,
            }
        }
        self.clients.clear();
        let written = self.disk.take().is_none_or(|disk| disk.finish(LAST_WRITES));
        if !written {
            bail!(
                "the disk has not taken the last records in {} s: the last file is incomplete",
                LAST_WRITES.as_secs()
            );
        }
        Ok(())
    }
}
