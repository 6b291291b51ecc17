//! The socket of a client of a mock server: paced reads, and writes that wait for nobody.

use std::io;
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context, Result, bail};
use socket2::{SockRef, TcpKeepalive};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore, mpsc};
use tokio::task::AbortHandle;

use crate::clock::Clock;

/// Bytes of one read from a client at most. The next read waits until the server has handled this one, so that a flood
/// waits in its sender's own buffers and each client gets its turn.
const READ: usize = 8 * 1024;
/// How fast a client is read: bytes a second, and bytes of a first burst. This is a hundred times what a payload needs,
/// and little enough that a flood leaves the server its processor time.
const PACE: f64 = 1e6;
const BURST: f64 = 256e3;
/// A dead peer loses its connection and its role after about this time.
const KEEPALIVE: TcpKeepalive = TcpKeepalive::new()
    .with_time(Duration::from_secs(10))
    .with_interval(Duration::from_secs(5))
    .with_retries(3);

/// Listens on an address.
///
/// # Errors
///
/// In one line, which names the option that chooses another address.
pub(crate) async fn listen(address: &str, option: &str) -> Result<TcpListener> {
    match TcpListener::bind(address).await {
        Ok(listener) => Ok(listener),
        Err(error) if error.kind() == io::ErrorKind::AddrInUse => {
            bail!("{address} is in use: stop the program that listens there, or choose another address with {option}")
        }
        Err(error) if error.kind() == io::ErrorKind::InvalidInput => {
            bail!("{option} {address}: expected ADDRESS:PORT, such as 127.0.0.1:7000")
        }
        Err(error) => Err(error).with_context(|| format!("cannot listen on {address}")),
    }
}

/// An event of a client's socket, with the client's number.
pub(crate) enum Heard {
    /// Bytes. The next read begins when the permit is dropped.
    Bytes(u32, Box<[u8]>, OwnedSemaphorePermit),
    /// The socket can be written to again.
    Writable(u32),
    Gone(u32),
}

/// The socket and the bytes that wait to be written to it.
pub(crate) struct Peer {
    client: u32,
    stream: Arc<TcpStream>,
    out: Vec<u8>,
    /// How many bytes of `out` have been written.
    written: usize,
    awaits_writable: bool,
    resets: bool,
    /// When writing stalled, since the program's start.
    stalled: Option<Duration>,
    heard: mpsc::UnboundedSender<Heard>,
    reader: AbortHandle,
}

impl Peer {
    pub(crate) fn open(
        client: u32,
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
            heard,
            reader: reader.abort_handle(),
        })
    }

    /// Adds bytes to those that wait.
    pub(crate) fn send(&mut self, bytes: &[u8]) {
        self.out.extend_from_slice(bytes);
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

    /// When writing stalled, since the program's start; `None` while the client reads.
    pub(crate) fn stalled(&self) -> Option<Duration> {
        self.stalled
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

impl Drop for Peer {
    fn drop(&mut self) {
        self.reader.abort();
        if self.resets {
            return;
        }
        // The task that waits for room also holds the socket. If this fails, the peer has already disconnected.
        let _gone = SockRef::from(&*self.stream).shutdown(std::net::Shutdown::Both);
    }
}

async fn read(client: u32, stream: Arc<TcpStream>, heard: mpsc::UnboundedSender<Heard>, clock: Clock) {
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

async fn tell_writable(client: u32, stream: Arc<TcpStream>, heard: mpsc::UnboundedSender<Heard>) {
    let writable = stream.writable().await;
    let what = match writable {
        Ok(()) => Heard::Writable(client),
        Err(_) => Heard::Gone(client),
    };
    // The server has ended if nothing receives this.
    let _ended = heard.send(what);
}
