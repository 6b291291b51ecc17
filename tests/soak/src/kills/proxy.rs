use std::io::{ErrorKind, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use anyhow::Result;
use socket2::SockRef;

const LOOK_EVERY: Duration = Duration::from_millis(10);

/// The state of the link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// It passes everything at once.
    Open,
    /// Connections are closed in order, and new ones at once.
    Closed,
    /// Connections are reset, and new ones at once.
    Reset,
    /// Connections stay open, new ones are accepted, and nothing passes.
    HalfOpen {
        /// Whether written bytes wait in the sockets' buffers instead of being lost.
        waits: bool,
    },
}

/// A link between runtime and vehicle that can be cut.
pub(super) struct Proxy {
    pub(super) address: String,
    state: Arc<State>,
}

struct State {
    vehicle: String,
    over: AtomicBool,
    now: Mutex<Link>,
}

struct Link {
    way: Way,
    /// Both ends of every connection, and whether it has been reset.
    connections: Vec<([TcpStream; 2], Arc<AtomicBool>)>,
}

impl Proxy {
    pub(super) fn start(vehicle: &str) -> Result<Self> {
        let listener = TcpListener::bind("127.0.0.1:0")?;
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?.to_string();
        let state = Arc::new(State {
            vehicle: vehicle.to_owned(),
            over: AtomicBool::new(false),
            now: Mutex::new(Link {
                way: Way::Open,
                connections: Vec::new(),
            }),
        });
        let serving = Arc::clone(&state);
        thread::spawn(move || serving.serve(&listener));
        Ok(Self { address, state })
    }

    /// Sets the state from now on.
    pub(super) fn set(&self, way: Way) {
        let mut link = self.state.link();
        let before = std::mem::replace(&mut link.way, way);
        match way {
            Way::Closed => link.end(false),
            Way::Reset => link.end(true),
            // Bytes that were held back are not passed on later.
            Way::Open if matches!(before, Way::HalfOpen { .. }) => link.end(true),
            Way::Open | Way::HalfOpen { .. } => {}
        }
    }
}

impl Drop for Proxy {
    fn drop(&mut self) {
        self.state.over.store(true, Ordering::Relaxed);
        self.state.link().end(true);
    }
}

impl Link {
    fn end(&mut self, reset: bool) {
        for (ends, cut) in self.connections.drain(..) {
            // The threads that read it then drop it, and the reset is sent when the last handle is dropped.
            cut.store(reset, Ordering::Relaxed);
            for end in ends {
                // If this fails, the connection is closed already.
                let _gone = if reset {
                    SockRef::from(&end).set_linger(Some(Duration::ZERO))
                } else {
                    end.shutdown(Shutdown::Both)
                };
            }
        }
    }
}

impl State {
    fn link(&self) -> MutexGuard<'_, Link> {
        self.now.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn serve(self: &Arc<Self>, listener: &TcpListener) {
        while !self.over.load(Ordering::Relaxed) {
            match listener.accept() {
                Ok((stream, _)) => {
                    // A connection that fails at once counts as cut.
                    let _gone = self.join(stream);
                }
                Err(_) => thread::sleep(LOOK_EVERY),
            }
        }
    }

    /// Joins a new connection of the runtime with one to the vehicle.
    fn join(self: &Arc<Self>, runtime: TcpStream) -> std::io::Result<()> {
        runtime.set_nonblocking(false)?;
        let mut link = self.link();
        match link.way {
            Way::Closed => return Ok(()),
            Way::Reset => return SockRef::from(&runtime).set_linger(Some(Duration::ZERO)),
            Way::Open | Way::HalfOpen { .. } => {}
        }
        let vehicle = TcpStream::connect(&self.vehicle)?;
        for end in [&runtime, &vehicle] {
            end.set_nodelay(true)?;
            end.set_read_timeout(Some(LOOK_EVERY))?;
        }
        let cut = Arc::new(AtomicBool::new(false));
        let ends = [runtime.try_clone()?, vehicle.try_clone()?];
        link.connections.push((ends, Arc::clone(&cut)));
        let back = (vehicle.try_clone()?, runtime.try_clone()?);
        for (from, to) in [(runtime, vehicle), back] {
            let (state, cut) = (Arc::clone(self), Arc::clone(&cut));
            thread::spawn(move || state.pass(from, to, &cut));
        }
        Ok(())
    }

    fn pass(&self, mut from: TcpStream, mut to: TcpStream, cut: &AtomicBool) {
        let mut buffer = [0; 16_384];
        while !cut.load(Ordering::Relaxed) {
            if self.link().way == (Way::HalfOpen { waits: true }) {
                thread::sleep(LOOK_EVERY);
                continue;
            }
            match from.read(&mut buffer) {
                Ok(0) => break,
                Ok(count) => {
                    // Done under the lock, so that nothing passes once the state has been changed.
                    let link = self.link();
                    let passes = link.way == Way::Open && !cut.load(Ordering::Relaxed);
                    if passes && to.write_all(buffer.get(..count).unwrap_or_default()).is_err() {
                        break;
                    }
                }
                Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
                Err(_) => break,
            }
        }
        if !cut.load(Ordering::Relaxed) {
            // When one side ends, the other is ended too; if that fails, it has ended already.
            let _gone = to.shutdown(Shutdown::Both);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ends() -> (Proxy, TcpStream, TcpStream) {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let proxy = Proxy::start(&listener.local_addr().unwrap().to_string()).unwrap();
        let runtime = TcpStream::connect(&proxy.address).unwrap();
        let (vehicle, _) = listener.accept().unwrap();
        (proxy, runtime, vehicle)
    }

    #[test]
    fn it_passes_until_it_is_cut_and_then_nothing() {
        for way in [
            Way::Closed,
            Way::Reset,
            Way::HalfOpen { waits: true },
            Way::HalfOpen { waits: false },
        ] {
            let (proxy, mut runtime, mut vehicle) = ends();
            let mut buffer = [0; 8];
            runtime.write_all(b"one").unwrap();
            assert_eq!(vehicle.read(&mut buffer).unwrap(), 3);
            vehicle.write_all(b"two").unwrap();
            assert_eq!(runtime.read(&mut buffer).unwrap(), 3);
            proxy.set(way);
            // It may be cut already.
            let _cut = runtime.write_all(b"three");
            vehicle.set_read_timeout(Some(Duration::from_millis(200))).unwrap();
            let end = vehicle.read(&mut buffer).map_err(|error| error.kind());
            match way {
                Way::Closed => assert_eq!(end, Ok(0)),
                Way::Reset => assert_eq!(end, Err(ErrorKind::ConnectionReset)),
                Way::Open | Way::HalfOpen { .. } => assert_eq!(end, Err(ErrorKind::WouldBlock)),
            }
            proxy.set(Way::Open);
            let end = vehicle.read(&mut buffer);
            assert!(!matches!(end, Ok(1..)), "{way:?}: what was kept back is never passed");
        }
    }
}
