use std::io;

use backseat_mvc::{ClientId, FaultyLink};
use backseat_units::Timestamp;
use tokio::net::TcpStream;
use tokio::sync::mpsc;

use crate::clock::Clock;
use crate::mvc::log::LineCutter;
use crate::peer::{Heard, Peer};

/// A client's connection: its socket, the faults of its link, and the part of a line that has been read.
pub(crate) struct Connection {
    pub(crate) peer: Peer,
    pub(crate) cutter: LineCutter,
    /// The link's faults to the vehicle and from it, where it has any.
    pub(crate) faults: Option<Box<(FaultyLink, FaultyLink)>>,
}

impl Connection {
    pub(crate) fn open(
        client: ClientId,
        stream: TcpStream,
        heard: mpsc::UnboundedSender<Heard>,
        clock: Clock,
    ) -> io::Result<Self> {
        Ok(Self {
            peer: Peer::open(client.0, stream, heard, clock)?,
            cutter: LineCutter::default(),
            faults: None,
        })
    }

    /// Sends bytes from the vehicle.
    pub(crate) fn send(&mut self, now: Timestamp, bytes: &[u8]) {
        let passed = match &mut self.faults {
            Some(faults) => faults.1.pass(now, bytes),
            None => Some(bytes),
        };
        self.peer.send(passed.unwrap_or_default());
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
            self.peer.send(&chunk);
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
}
