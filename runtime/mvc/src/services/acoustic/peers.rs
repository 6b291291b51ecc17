use core::time::Duration;

use backseat_spi::{FrameReceivedStatus, ReceivedFrame};
use backseat_units::{EastNorth, Timestamp};
use backseat_world::Stream;

use crate::file::{AcousticConfig, PeerConfig};

/// The greatest number of packets in the water at the same time.
const IN_WATER_MAX: usize = 1024;

/// The other vehicles with modems, and their packets in the water.
#[derive(Debug)]
pub(super) struct Peers {
    peers: Vec<PeerConfig>,
    sources: Vec<Source>,
    stream: Stream,
    in_water: Vec<Arrival>,
}

/// One packet that a peer sends, once or periodically.
#[derive(Debug)]
struct Source {
    peer: usize,
    destination: u32,
    mode: i32,
    frames: Vec<Box<[u8]>>,
    next: Timestamp,
    period: Option<Duration>,
}

/// A packet on its way to the vehicle's modem.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Arrival {
    /// When it begins to arrive.
    pub(super) began: Timestamp,
    /// When it has arrived completely.
    pub(super) at: Timestamp,
    pub(super) source: u32,
    pub(super) destination: u32,
    pub(super) mode: i32,
    pub(super) frames: u32,
    pub(super) data: [ReceivedFrame; 8],
    /// Whether the modem fails to hear it.
    pub(super) lost: bool,
}

impl Peers {
    pub(super) fn new(config: &AcousticConfig, seed: u64) -> Self {
        let mut sources = Vec::new();
        for (peer, of) in config.peers.iter().enumerate() {
            for packet in &of.packets {
                sources.push(Source {
                    peer,
                    destination: packet.destination.unwrap_or(config.address),
                    mode: packet.mode,
                    frames: packet.bytes().unwrap_or_default(),
                    next: Timestamp::ZERO + Duration::from_secs_f64(packet.first_s),
                    period: packet.period_s.map(Duration::from_secs_f64),
                });
            }
        }
        Self {
            peers: config.peers.clone(),
            sources,
            stream: Stream::new(seed, "acoustic peers"),
            in_water: Vec::new(),
        }
    }

    /// When something is next due.
    pub(super) fn due(&self) -> Timestamp {
        let sources = self.sources.iter().map(|source| source.next);
        let arrivals = self.in_water.iter().map(|arrival| arrival.at);
        sources.chain(arrivals).min().unwrap_or(Timestamp::MAX)
    }

    /// Distance to the modem with this address; `None` if there is no such modem.
    pub(super) fn range_m(&self, address: u32, from: (EastNorth, f64), time: Timestamp) -> Option<f64> {
        let peer = self.peers.iter().find(|peer| peer.address == address)?;
        Some(range_m(peer, from, time))
    }

    /// Whether the modem with this address acknowledges.
    pub(super) fn acknowledges(&self, address: u32) -> bool {
        self.peers
            .iter()
            .any(|peer| peer.address == address && peer.acknowledges)
    }

    /// Sends the packets that are due.
    pub(super) fn transmit(&mut self, now: Timestamp, config: &AcousticConfig, at: (EastNorth, f64)) {
        for source in &mut self.sources {
            while source.next <= now {
                let sent = source.next;
                source.next = source.period.map_or(Timestamp::MAX, |period| sent + period);
                if self.in_water.len() >= IN_WATER_MAX {
                    continue;
                }
                let peer = &self.peers[source.peer];
                let way_s = range_m(peer, at, sent) / config.sound_speed_mps;
                let began = sent + Duration::from_secs_f64(way_s);
                let mut data = <[ReceivedFrame; 8]>::default();
                for (place, bytes) in data.iter_mut().zip(&source.frames) {
                    *place = received(bytes, config, &mut self.stream);
                }
                self.in_water.push(Arrival {
                    began,
                    at: began + Duration::from_secs_f64(config.frame_s * source.frames.len() as f64),
                    source: peer.address,
                    destination: source.destination,
                    mode: source.mode,
                    frames: source.frames.len() as u32,
                    data,
                    lost: self.stream.uniform() < config.loss_chance,
                });
            }
        }
    }

    /// Removes and returns the packet that arrived first, if one has arrived.
    pub(super) fn arrived(&mut self, now: Timestamp) -> Option<Arrival> {
        let (index, _) = self
            .in_water
            .iter()
            .enumerate()
            .filter(|(_, arrival)| arrival.at <= now)
            .min_by_key(|(_, arrival)| arrival.at)?;
        Some(self.in_water.remove(index))
    }
}

fn range_m(peer: &PeerConfig, (at, depth_m): (EastNorth, f64), time: Timestamp) -> f64 {
    let seconds = time.as_secs_f64();
    let east_m = peer.east_m + peer.east_mps * seconds - at.east_m;
    let north_m = peer.north_m + peer.north_mps * seconds - at.north_m;
    let down_m = peer.depth_m - depth_m;
    (east_m * east_m + north_m * north_m + down_m * down_m).sqrt()
}

/// A frame as the modem delivers it: good, with one byte changed, or undecodable.
fn received(bytes: &[u8], config: &AcousticConfig, stream: &mut Stream) -> ReceivedFrame {
    let (chance, place) = (stream.uniform(), stream.next_u64());
    if chance < config.undecodable_chance {
        return ReceivedFrame {
            status: FrameReceivedStatus::Undecodable,
            data: Box::default(),
        };
    }
    let mut data: Box<[u8]> = bytes.into();
    if chance >= config.undecodable_chance + config.corrupted_chance {
        let status = FrameReceivedStatus::Good;
        return ReceivedFrame { status, data };
    }
    let index = (place % data.len().max(1) as u64) as usize;
    if let Some(byte) = data.get_mut(index) {
        // The mask is never zero, so the byte always changes.
        *byte ^= (place >> 32) as u8 | 1;
    }
    let status = FrameReceivedStatus::Corrupted;
    ReceivedFrame { status, data }
}
