//! The TCP connection to the vehicle, set up so that it never delivers old bytes (safety requirement 007).

use std::io;
use std::time::Duration;

use backseat_units::Timestamp;
use socket2::SockRef;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

/// The connection ends when data stays unacknowledged for longer than this.
const USER_TIMEOUT: Duration = Duration::from_secs(2);
/// A write that has waited this long resets the connection.
const WRITE_WITHIN: Duration = Duration::from_secs(1);
/// Output of core that is older than this is not written: the process has stood still since core judged it.
const JUDGED_WITHIN: Duration = Duration::from_millis(500);
const CONNECT_WITHIN: Duration = Duration::from_secs(5);

/// A connection, or none.
#[derive(Default)]
pub(crate) struct Link {
    stream: Option<TcpStream>,
    pending: Vec<u8>,
    pending_since: Option<Timestamp>,
}

/// Connects; makes a single attempt.
pub(crate) async fn connect(address: &str) -> io::Result<TcpStream> {
    let connecting = TcpStream::connect(address);
    let stream = tokio::time::timeout(CONNECT_WITHIN, connecting)
        .await
        .map_err(|_| io::Error::new(io::ErrorKind::TimedOut, "no answer within 5 s"))??;
    stream.set_nodelay(true)?;
    SockRef::from(&stream).set_tcp_user_timeout(Some(USER_TIMEOUT))?;
    Ok(stream)
}

impl Link {
    pub(crate) fn open(&mut self, stream: TcpStream) {
        self.stream = Some(stream);
        self.pending.clear();
        self.pending_since = None;
    }

    pub(crate) const fn is_open(&self) -> bool {
        self.stream.is_some()
    }

    /// Resets the connection: bytes in the socket's buffers are discarded, not delivered later.
    pub(crate) fn reset(&mut self) {
        if let Some(stream) = self.stream.take() {
            // If this fails, the connection is already closed.
            let _gone = SockRef::from(&stream).set_linger(Some(Duration::ZERO));
        }
        self.pending.clear();
        self.pending_since = None;
    }

    /// Closes in order, so that written bytes are delivered. Reads until the other side has closed too, at most for
    /// `within`, because closing with unread bytes would reset the connection and lose the bytes in transit.
    pub(crate) async fn close(&mut self, within: Duration) {
        let Some(mut stream) = self.stream.take() else { return };
        let farewell = async {
            let mut rest = [0; 4096];
            stream.shutdown().await?;
            while stream.read(&mut rest).await? > 0 {}
            io::Result::Ok(())
        };
        // The connection is closed even if this is late or fails.
        let _ended = tokio::time::timeout(within, farewell).await;
    }

    /// Writes what can be written at once. The rest waits, at most for [`WRITE_WITHIN`]. `judged` is when core produced
    /// the output.
    ///
    /// # Errors
    ///
    /// If the connection is broken or the bytes are too old to send. The caller must then reset the connection.
    pub(crate) fn send(&mut self, judged: Timestamp, now: Timestamp, bytes: &[u8]) -> io::Result<()> {
        let old = now.since(judged);
        if old > JUDGED_WITHIN {
            let why = format!("the process stood still for {:.1} s before a write", old.as_secs_f64());
            return Err(io::Error::new(io::ErrorKind::TimedOut, why));
        }
        self.pending.extend_from_slice(bytes);
        self.flush(now)
    }

    pub(crate) fn flush(&mut self, now: Timestamp) -> io::Result<()> {
        let Some(stream) = &self.stream else {
            self.pending.clear();
            return Ok(());
        };
        if self.write_deadline().is_some_and(|at| at <= now) {
            return Err(io::Error::new(
                io::ErrorKind::TimedOut,
                "a write has been waiting for a second",
            ));
        }
        while !self.pending.is_empty() {
            match stream.try_write(&self.pending) {
                Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
                Ok(written) => {
                    self.pending.drain(..written);
                }
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => break,
                Err(error) => return Err(error),
            }
        }
        self.pending_since = if self.pending.is_empty() {
            None
        } else {
            Some(self.pending_since.unwrap_or(now))
        };
        Ok(())
    }

    /// When the waiting write becomes too old.
    pub(crate) fn write_deadline(&self) -> Option<Timestamp> {
        self.pending_since.map(|since| since + WRITE_WITHIN)
    }

    /// Waits until bytes can be read or, where some wait to be written, until they can be. Waits for ever without a
    /// connection. Reads what is there.
    pub(crate) async fn ready(&self, buffer: &mut [u8]) -> Ready {
        let Some(stream) = &self.stream else {
            return std::future::pending().await;
        };
        loop {
            let interest = if self.pending.is_empty() {
                tokio::io::Interest::READABLE
            } else {
                tokio::io::Interest::READABLE | tokio::io::Interest::WRITABLE
            };
            match stream.ready(interest).await {
                Ok(ready) if ready.is_readable() || ready.is_read_closed() => match stream.try_read(buffer) {
                    Ok(0) => return Ready::Closed,
                    Ok(read) => return Ready::Read(read),
                    Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
                    Err(_) => return Ready::Closed,
                },
                Ok(_) => return Ready::Writable,
                Err(_) => return Ready::Closed,
            }
        }
    }
}

/// What a connection is ready for.
pub(crate) enum Ready {
    /// This many bytes have been read.
    Read(usize),
    /// Waiting bytes can be written.
    Writable,
    /// The other side has closed the connection.
    Closed,
}

#[cfg(test)]
mod tests {
    use super::*;
    use tokio::net::TcpListener;

    async fn connected() -> (Link, TcpStream) {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let stream = connect(&listener.local_addr().unwrap().to_string()).await.unwrap();
        let (vehicle, _) = listener.accept().await.unwrap();
        let mut link = Link::default();
        link.open(stream);
        (link, vehicle)
    }

    fn at(millis: u64) -> Timestamp {
        Timestamp::ZERO + Duration::from_millis(millis)
    }

    #[tokio::test]
    async fn sr_007_what_was_judged_before_the_process_stood_still_is_not_written() {
        let (mut link, mut vehicle) = connected().await;
        link.send(at(1000), at(1001), b"judged now").unwrap();
        assert!(link.send(at(2000), at(2501), b"judged long ago").is_err());
        link.reset();
        let mut read = Vec::new();
        // The reset ends the read with an error.
        let _reset = vehicle.read_to_end(&mut read).await;
        assert!(!String::from_utf8_lossy(&read).contains("long ago"));
    }

    #[tokio::test]
    async fn sr_007_what_waited_for_a_second_is_not_written() {
        let (mut link, vehicle) = connected().await;
        // More than all buffers of the connection hold, and no one reads.
        let flood = vec![b'x'; 64 << 20];
        link.send(at(1000), at(1000), &flood).unwrap();
        assert_eq!(link.write_deadline(), Some(at(2000)));
        let mut buffer = vec![0; 1 << 20];
        while vehicle.try_read(&mut buffer).is_ok_and(|read| read > 0) {}
        tokio::time::sleep(Duration::from_millis(50)).await;
        // There is room now, but it is too late.
        let error = link.send(at(2100), at(2100), b"$BPEMB").unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::TimedOut);
        assert_eq!(link.write_deadline(), Some(at(2000)), "nothing more was written");
    }
}
