use std::io;
use std::sync::Arc;
use std::time::Duration;

use backseat_mvc::{ClientId, FaultyLink};
use backseat_units::Timestamp;
use socket2::{SockRef, TcpKeepalive};
use tokio::net::TcpStream;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, mpsc};
use tokio::task::AbortHandle;

use crate::clock::Clock;
use crate::mvc::log::LineCutter;

/// Bytes of one read from a client at most. The next read waits until the vehicle has handled this one, so that a flood
/// waits in its sender's own buffers and each client gets its turn.
const READ: usize = 8 * 1024;
/// How fast a client is read: bytes a second, and bytes of a first burst. This is a hundred times what SPI needs, and
/// little enough that a flood leaves the vehicle its processor time.
const PACE: f64 = 1e6;
const BURST: f64 = 256e3;
/// A dead peer loses its connection and its role after about this time.
const KEEPALIVE: TcpKeepalive = TcpKeepalive::new()
    .with_time(Duration::from_secs(10))
    .with_interval(Duration::from_secs(5))
    .with_retries(3);

/// An event of a client's socket.
pub(crate) enum Heard {
    Bytes(ClientId, Box<[u8]>, OwnedSemaphorePermit),
    /// The socket can be written to again.
    Writable(ClientId),
    Gone(ClientId),
}

/// A client's connection: the bytes that wait to be written, and the part of a line that has been read.
pub(crate) struct Connection {
    client: ClientId,
    stream: Arc<TcpStream>,
    out: Vec<u8>,
    /// How many bytes of `out` have been written.
    written: usize,
    awaits_writable: bool,
    resets: bool,
    /// When writing stalled, since the program's start.
    pub(crate) stalled: Option<Duration>,
    pub(crate) cutter: LineCutter,
    /// The link's faults to the vehicle and from it, where it has any.
    pub(crate) faults: Option<Box<(FaultyLink, FaultyLink)>>,
    heard: mpsc::UnboundedSender<Heard>,
    reader: AbortHandle,
}

impl Connection {
    pub(crate) fn open(
        client: ClientId,
        stream: TcpStream,
        heard: mpsc::UnboundedSender<Heard>,
        clock: Clock,
    ) -> io::Result<Self> {
        stream.set_nodelay(true)?;
        SockRef::from(&stream).set_tcp_keepalive(&KEEPALIVE)?;
        let stream = Arc::new(stream);
        let reader = tokio::spawn(read(client, Arc::clone(&stream), heard.clone(), clock));
        Ok(Self {
            client,
            stream,
            out: Vec::new(),
            written: 0,
            awaits_writable: false,
            resets: false,
            stalled: None,
            cutter: LineCutter::default(),
            faults: None,
            heard,
            reader: reader.abort_handle(),
        })
    }

    /// Sends bytes from the vehicle.
    pub(crate) fn send(&mut self, now: Timestamp, bytes: &[u8]) {
        let passed = match &mut self.faults {
            Some(faults) => faults.1.pass(now, bytes),
            None => Some(bytes),
        };
        self.out.extend_from_slice(passed.unwrap_or_default());
    }

    /// Takes what has arrived over a link with faults: writes it to the client, or returns it if it is for the vehicle.
    /// `None` where the link is cut.
    pub(crate) fn arrived(&mut self, now: Timestamp) -> Option<Vec<u8>> {
        let mut bytes = Vec::new();
        let Some(faults) = &mut self.faults else {
            return Some(bytes);
        };
        if faults.0.is_cut(now) || faults.1.is_cut(now) {
            return None;
        }
        while let Some(chunk) = faults.1.poll(now) {
            self.out.extend_from_slice(&chunk);
            faults.1.recycle(chunk);
        }
        while let Some(chunk) = faults.0.poll(now) {
            bytes.extend_from_slice(&chunk);
            faults.0.recycle(chunk);
        }
        Some(bytes)
    }

    /// When more arrives over a link with faults.
    pub(crate) fn arrives(&self) -> Option<Timestamp> {
        let faults = self.faults.as_ref()?;
        [faults.0.poll_timeout(), faults.1.poll_timeout()]
            .into_iter()
            .flatten()
            .min()
    }

    /// From now on, closing resets the connection.
    pub(crate) fn reset(&mut self) {
        // If this fails, the connection is already closed.
        let _gone = SockRef::from(&*self.stream).set_linger(Some(Duration::ZERO));
        self.resets = true;
    }

    /// Bytes that wait to be written.
    pub(crate) fn waiting(&self) -> usize {
        self.out.len() - self.written
    }

    /// The socket can be written to again.
    pub(crate) fn writable(&mut self) {
        self.awaits_writable = false;
    }

    /// Writes what can be written now, usually in one call.
    pub(crate) fn flush(&mut self, now: Duration) -> io::Result<()> {
        if self.awaits_writable {
            return Ok(());
        }
        while self.written < self.out.len() {
            match self.stream.try_write(self.out.get(self.written..).unwrap_or_default()) {
                Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
                Ok(count) => {
                    self.written += count;
                    self.stalled = None;
                }
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {
                    self.stalled.get_or_insert(now);
                    self.awaits_writable = true;
                    tokio::spawn(tell_writable(self.client, Arc::clone(&self.stream), self.heard.clone()));
                    // Drops the written bytes only when few bytes have to be moved for it.
                    if self.written > self.out.len() / 2 {
                        self.out.drain(..self.written);
                        self.written = 0;
                    }
                    return Ok(());
                }
                Err(error) => return Err(error),
            }
        }
        self.out.clear();
        self.written = 0;
        self.stalled = None;
        Ok(())
    }
}

impl Drop for Connection {
    fn drop(&mut self) {
        self.reader.abort();
        if self.resets {
            return;
        }
        // The task that waits for room also holds the socket. If this fails, the peer has already disconnected.
        let _gone = SockRef::from(&*self.stream).shutdown(std::net::Shutdown::Both);
    }
}

async fn read(client: ClientId, stream: Arc<TcpStream>, heard: mpsc::UnboundedSender<Heard>, clock: Clock) {
    let one = Arc::new(Semaphore::new(1));
    let mut buffer = vec![0; READ];
    let (mut allowance, mut since) = (BURST, clock.elapsed());
    loop {
        let Ok(permit) = Arc::clone(&one).acquire_owned().await else {
            return;
        };
        let read = loop {
            match stream.readable().await.and_then(|()| stream.try_read(&mut buffer)) {
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
                read => break read.unwrap_or(0),
            }
        };
        let bytes = buffer.get(..read).unwrap_or_default();
        let what = if bytes.is_empty() {
            Heard::Gone(client)
        } else {
            Heard::Bytes(client, bytes.into(), permit)
        };
        // The server has ended if nothing receives this.
        if heard.send(what).is_err() || read == 0 {
            return;
        }
        let now = clock.elapsed();
        allowance = (allowance + PACE * (now - since).as_secs_f64()).min(BURST) - read as f64;
        since = now;
        if allowance < 0.0 {
            tokio::time::sleep(Duration::from_secs_f64(-allowance / PACE)).await;
        }
    }
}

async fn tell_writable(client: ClientId, stream: Arc<TcpStream>, heard: mpsc::UnboundedSender<Heard>) {
    let writable = stream.writable().await;
    let what = match writable {
        Ok(()) => Heard::Writable(client),
        Err(_) => Heard::Gone(client),
    };
    // The server has ended if nothing receives this.
    let _ended = heard.send(what);
}
