//! Reports the control loop's state to the service manager (the protocol of sd_notify(3)) and measures how late the
//! loop wakes.
//!
//! Only the loop that serves core calls this. A loop that is stuck therefore does not feed the watchdog, and the
//! service manager restarts it (safety requirement 007: meanwhile the vehicle steers itself, by its own clock).

use std::error::Error;
use std::io;
use std::os::linux::net::SocketAddrExt as _;
use std::os::unix::net::{SocketAddr, UnixDatagram};
use std::time::Duration;

use backseat_units::Timestamp;
use tracing::{info, warn};

/// A wake-up that is later than this is a slip.
const SLIP: Duration = Duration::from_millis(50);
/// A wake-up that is later than this has ended every lease.
const LATE: Duration = Duration::from_millis(500);
const TELL_EVERY: Duration = Duration::from_secs(60);

/// Whether a service manager has started this process, and would start it again. Then nobody waits for its answer.
pub(crate) fn is_managed() -> bool {
    std::env::var_os("NOTIFY_SOCKET").is_some_and(|address| !address.is_empty())
}

/// Whether the same may succeed later without anybody's doing: a port is taken, an address is not there yet, a disk is full
/// or read-only.
pub(crate) fn may_pass(error: &(dyn Error + 'static)) -> bool {
    error.downcast_ref::<io::Error>().is_some_and(|error| {
        matches!(
            error.kind(),
            io::ErrorKind::AddrInUse
                | io::ErrorKind::AddrNotAvailable
                | io::ErrorKind::StorageFull
                | io::ErrorKind::QuotaExceeded
                | io::ErrorKind::ReadOnlyFilesystem
        )
    })
}

/// The service manager, where there is one.
pub(crate) struct Service {
    socket: Option<UnixDatagram>,
    feed_every: Option<Duration>,
    feed_at: Timestamp,
    ready: bool,
    failed: bool,
}

impl Service {
    /// Reads `NOTIFY_SOCKET`, `WATCHDOG_USEC` and `WATCHDOG_PID` from the environment.
    pub(crate) fn from_environment() -> Self {
        let variable = |name| std::env::var(name).ok().filter(|value| !value.is_empty());
        let socket = variable("NOTIFY_SOCKET").and_then(|address| match connect(&address) {
            Ok(socket) => Some(socket),
            Err(error) => {
                warn!("cannot reach the service manager: NOTIFY_SOCKET {address:?}: {error}");
                None
            }
        });
        let ours = variable("WATCHDOG_PID").is_none_or(|pid| pid == std::process::id().to_string());
        let term = variable("WATCHDOG_USEC")
            .and_then(|micros| micros.parse().ok())
            .filter(|micros| ours && *micros > 0);
        Self {
            socket,
            feed_every: term.map(|micros| Duration::from_micros(micros) / 2),
            feed_at: Timestamp::ZERO,
            ready: false,
            failed: false,
        }
    }

    /// Called in each round of the loop. Reports READY in the first one, and feeds the watchdog when that is due.
    pub(crate) fn comes_round(&mut self, now: Timestamp) {
        if !std::mem::replace(&mut self.ready, true) {
            self.tell("READY=1");
        }
        if let Some(every) = self.feed_every
            && now >= self.feed_at
        {
            self.feed_at = now + every;
            self.tell("WATCHDOG=1");
        }
    }

    /// When the loop must come round at the latest.
    pub(crate) fn deadline(&self) -> Option<Timestamp> {
        self.feed_every.filter(|_| self.socket.is_some()).map(|_| self.feed_at)
    }

    /// Reports that the loop has ended in order.
    pub(crate) fn stopping(&mut self) {
        self.tell("STOPPING=1");
    }

    fn tell(&mut self, state: &str) {
        let Some(socket) = &self.socket else { return };
        // The send never blocks: a service manager that does not listen must not delay the loop.
        if let Err(error) = socket.send(state.as_bytes())
            && !std::mem::replace(&mut self.failed, true)
        {
            warn!("cannot report {state} to the service manager: {error}");
        }
    }
}

fn connect(address: &str) -> io::Result<UnixDatagram> {
    let address = match address.strip_prefix('@') {
        Some(name) => SocketAddr::from_abstract_name(name)?,
        None => SocketAddr::from_pathname(address)?,
    };
    let socket = UnixDatagram::unbound()?;
    socket.connect_addr(&address)?;
    socket.set_nonblocking(true)?;
    Ok(socket)
}

/// How much later than promised the loop has woken.
#[derive(Debug, Default)]
pub(crate) struct Slips {
    minute: Count,
    all: Count,
    tell_at: Timestamp,
}

#[derive(Clone, Copy, Debug, Default)]
struct Count {
    slips: u64,
    late: u64,
    worst: Duration,
}

impl Slips {
    /// Notes that the loop, which was to wake at `promised` at the latest, woke at `now`. Logs the slips of each minute
    /// that had some.
    pub(crate) fn woke(&mut self, promised: Timestamp, now: Timestamp) {
        let late = now.since(promised);
        if late > SLIP {
            self.minute.add(late);
            self.all.add(late);
        }
        if now >= self.tell_at {
            self.tell_at = now + TELL_EVERY;
            if let Some(told) = std::mem::take(&mut self.minute).describe() {
                info!("slips in the last minute: {told}");
            }
        }
    }

    /// Logs the slips of the whole run.
    pub(crate) fn end(&self) {
        match self.all.describe() {
            Some(told) => info!("slips: {told}"),
            None => info!("slips: none"),
        }
    }
}

impl Count {
    fn add(&mut self, late: Duration) {
        self.slips += 1;
        self.late += u64::from(late > LATE);
        self.worst = self.worst.max(late);
    }

    fn describe(&self) -> Option<String> {
        (self.slips > 0).then(|| {
            format!(
                "{} wake-ups over 50 ms late, {} of them over 500 ms, the worst {:.3} s",
                self.slips,
                self.late,
                self.worst.as_secs_f64()
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_late_is_counted_with_its_worst() {
        let at = |millis| Timestamp::ZERO + Duration::from_millis(millis);
        let mut slips = Slips::default();
        slips.woke(at(1000), at(900));
        slips.woke(at(1000), at(1050));
        assert_eq!(slips.all.describe(), None, "no slip");
        slips.woke(at(2000), at(2051));
        slips.woke(at(3000), at(3700));
        let told = slips.all.describe().unwrap();
        assert_eq!(
            told,
            "2 wake-ups over 50 ms late, 1 of them over 500 ms, the worst 0.700 s"
        );
        slips.woke(at(70_000), at(70_000));
        assert_eq!(slips.minute.describe(), None, "the count of the minute is reset");
        assert!(slips.all.describe().is_some());
    }

    #[test]
    fn an_abstract_address_is_one() {
        let name = format!("backseat-service-{}", std::process::id());
        let manager = UnixDatagram::bind_addr(&SocketAddr::from_abstract_name(&name).unwrap()).unwrap();
        let socket = connect(&format!("@{name}")).unwrap();
        socket.send(b"READY=1").unwrap();
        let mut buffer = [0; 64];
        assert_eq!(manager.recv(&mut buffer).unwrap(), 7);
    }
}
