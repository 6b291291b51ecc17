use core::ops::Deref;
use core::time::Duration;
use std::collections::VecDeque;

use backseat_units::Timestamp;
use backseat_world::Stream;

use crate::event::ClientId;
use crate::faults::{Directions, Fault, FaultKind, FaultPlan, LinkFault, LinkFaultKind};

/// How many bytes and pieces may be under way in one direction. With more the connection counts as cut: a real sender
/// gives up when the other side does not read.
const QUEUE_MAX: usize = 1 << 20;
const PIECES_MAX: usize = 1 << 16;
/// The longest piece that several writes may become, bytes.
const PIECE_MAX: usize = 1 << 16;
/// This many bytes without a line end count as a sentence.
const SENTENCE_MAX: usize = 4096;
const SPARES_MAX: usize = 8;
/// The most by which `growth` lengthens a delay.
const GROWN_MAX: Duration = Duration::from_secs(60);

/// The direction of bytes on a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// From a payload to the vehicle.
    ToVehicle,
    /// From the vehicle to a payload.
    FromVehicle,
}

/// The faults of a plan that the driver of a link plays.
///
/// The driver calls [`LinkFaults::refuses`] before it accepts a connection, makes a [`FaultyLink`] for each direction
/// of the connection, and passes every byte through them. The vehicle's own log says when each fault begins and ends.
#[derive(Clone, Debug, Default)]
pub struct LinkFaults {
    faults: Vec<(Window, LinkFault)>,
    seed: u64,
}

/// The time of a fault: it acts from `from` until just before `until`.
#[derive(Clone, Copy, Debug)]
struct Window {
    from: Timestamp,
    until: Timestamp,
}

impl Window {
    fn of(fault: &Fault) -> Self {
        Self {
            from: fault.at,
            until: fault.until(),
        }
    }

    fn holds(self, at: Timestamp) -> bool {
        self.from <= at && at < self.until
    }
}

impl LinkFaults {
    /// The plan's faults of links. The seed draws what the plan leaves open: which bytes, which sentences, how much
    /// jitter.
    #[must_use]
    pub fn new(plan: &FaultPlan, seed: u64) -> Self {
        let mut faults = Self {
            faults: Vec::new(),
            seed,
        };
        for fault in &plan.faults {
            faults.inject(fault);
        }
        faults
    }

    /// Adds a fault for connections that are made later, as if the plan had always had it. For existing connections
    /// call [`FaultyLink::inject`]. A fault that is not one of a link changes nothing.
    pub fn inject(&mut self, fault: &Fault) {
        if let FaultKind::Link(link) = &fault.kind {
            let window = Window::of(fault);
            let place = self.faults.partition_point(|(other, _)| other.from <= window.from);
            self.faults.insert(place, (window, link.clone()));
        }
    }

    /// Whether no link has any fault at any time.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.faults.is_empty()
    }

    /// Whether a client that connects now is refused: its connection is reset at once.
    #[must_use]
    pub fn refuses(&self, now: Timestamp, client: ClientId, role: Option<&str>) -> bool {
        self.faults.iter().any(|(window, fault)| {
            matches!(fault.kind, LinkFaultKind::Cut | LinkFaultKind::Refuse)
                && window.holds(now)
                && fault.whom.includes(client, role)
        })
    }

    /// One direction of a connection that was made at `since`.
    #[must_use]
    pub fn link(&self, since: Timestamp, client: ClientId, role: Option<&str>, direction: Direction) -> FaultyLink {
        let way = match direction {
            Direction::ToVehicle => "to",
            Direction::FromVehicle => "from",
        };
        let mut link = FaultyLink {
            client,
            role: role.map(Box::from),
            direction,
            quiet_until: Timestamp::MAX,
            acts: Vec::new(),
            cut_at: Timestamp::MAX,
            // Made at the first draw, so that a connection without faults does not pay for it.
            stream: None,
            seed: self.seed,
            name: format!("link fault {way} the vehicle, {client}"),
            bytes: VecDeque::new(),
            pieces: VecDeque::new(),
            last: Timestamp::ZERO,
            last_read: Timestamp::ZERO,
            sentence: Vec::new(),
            sentence_until: Timestamp::MAX,
            lost: None,
            scratch: Vec::new(),
            spare: Vec::new(),
        };
        for (window, fault) in &self.faults {
            // Skip faults that were over, and a cut that began before this connection.
            let past = match fault.kind {
                LinkFaultKind::Cut => window.from <= since,
                LinkFaultKind::Refuse
                | LinkFaultKind::Stall
                | LinkFaultKind::Deaf
                | LinkFaultKind::HalfOpen
                | LinkFaultKind::Delay { .. }
                | LinkFaultKind::Split { .. }
                | LinkFaultKind::Join { .. }
                | LinkFaultKind::Duplicate { .. }
                | LinkFaultKind::Corrupt { .. }
                | LinkFaultKind::Drop { .. } => window.until <= since,
            };
            if !past {
                link.meet(*window, fault);
            }
        }
        link
    }
}

/// Bytes that arrive together. [`FaultyLink::recycle`] takes a chunk back, to use its buffer again.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Chunk {
    /// At least one byte.
    pub bytes: Vec<u8>,
}

impl Deref for Chunk {
    type Target = [u8];
    fn deref(&self) -> &[u8] {
        &self.bytes
    }
}

/// One direction of one client's link, with the faults of the plan: bytes go in when they are written and come out when
/// they arrive.
///
/// After each [`FaultyLink::push`] and at each [`FaultyLink::poll_timeout`], the driver calls [`FaultyLink::is_cut`].
/// If the link is not cut, it calls [`FaultyLink::poll`] until that returns `None`. Time never goes back. While no
/// fault acts, [`FaultyLink::pass`] returns bytes unchanged.
///
/// The faults act on a write in this order: silent loss, sentences lost or duplicated, corrupt bytes, delay, joining,
/// splitting, stall, deafness. Bytes never overtake each other.
#[derive(Clone, Debug)]
pub struct FaultyLink {
    client: ClientId,
    role: Option<Box<str>>,
    direction: Direction,
    /// The faults that act or will act, in the order of their begins.
    acts: Vec<(Window, LinkFaultKind)>,
    /// Before this time no fault acts.
    quiet_until: Timestamp,
    cut_at: Timestamp,
    stream: Option<Stream>,
    seed: u64,
    name: String,
    /// The bytes under way, and the pieces in which they arrive.
    bytes: VecDeque<u8>,
    pieces: VecDeque<Piece>,
    /// When the last piece arrives, and when it is read.
    last: Timestamp,
    last_read: Timestamp,
    /// The begin of a sentence whose end has not been written yet, while a fault loses or duplicates sentences.
    sentence: Vec<u8>,
    sentence_until: Timestamp,
    /// The time in which all writes are lost: since the first lost write, until the faults that are known now end.
    lost: Option<Window>,
    scratch: Vec<u8>,
    spare: Vec<Vec<u8>>,
}

#[derive(Clone, Copy, Debug)]
struct Piece {
    written: Timestamp,
    /// When it reaches the other computer, which acknowledges it.
    arrives: Timestamp,
    /// When it is read there: later than `arrives` only if the vehicle is deaf.
    at: Timestamp,
    len: usize,
    /// More bytes may be added to it, because it was held back.
    gathers: bool,
}

impl FaultyLink {
    /// Adds a fault if it applies to this connection and this direction, as if the plan had always had it. The fault
    /// may not begin before the last time that this link has received. Its effect can be due at once, so the driver
    /// must call [`FaultyLink::is_cut`] and [`FaultyLink::poll_timeout`] again.
    pub fn inject(&mut self, fault: &Fault) {
        if let FaultKind::Link(link) = &fault.kind {
            self.meet(Window::of(fault), link);
        }
    }

    fn meet(&mut self, window: Window, fault: &LinkFault) {
        let this_way = match fault.direction {
            Directions::Both => true,
            Directions::ToVehicle => self.direction == Direction::ToVehicle,
            Directions::FromVehicle => self.direction == Direction::FromVehicle,
        };
        if !fault.whom.includes(self.client, self.role.as_deref()) {
            return;
        }
        match fault.kind {
            LinkFaultKind::Cut => self.cut_at = self.cut_at.min(window.from),
            LinkFaultKind::Refuse => {}
            LinkFaultKind::Stall
            | LinkFaultKind::Deaf
            | LinkFaultKind::HalfOpen
            | LinkFaultKind::Delay { .. }
            | LinkFaultKind::Split { .. }
            | LinkFaultKind::Join { .. }
            | LinkFaultKind::Duplicate { .. }
            | LinkFaultKind::Corrupt { .. }
            | LinkFaultKind::Drop { .. } => {
                if !this_way || window.until <= window.from {
                    return;
                }
                let place = self.acts.partition_point(|(other, _)| other.from <= window.from);
                self.acts.insert(place, (window, fault.kind));
                self.quiet_until = self.quiet_until.min(window.from);
                if matches!(fault.kind, LinkFaultKind::Stall | LinkFaultKind::Deaf) {
                    self.hold_back();
                }
            }
        }
    }

    /// Bytes are written now. If no fault acts and nothing is under way, returns the bytes, which the driver then
    /// passes on at once. Otherwise takes them as [`FaultyLink::push`] does.
    #[must_use]
    pub fn pass<'a>(&mut self, now: Timestamp, bytes: &'a [u8]) -> Option<&'a [u8]> {
        if now < self.quiet_until && now < self.cut_at && self.pieces.is_empty() && self.sentence.is_empty() {
            return Some(bytes);
        }
        self.push(now, bytes);
        None
    }

    /// Bytes are written now. If the link is cut, they are lost.
    pub fn push(&mut self, now: Timestamp, bytes: &[u8]) {
        if self.is_cut(now) {
            return;
        }
        self.forget(now);
        self.end_sentence(now);
        let (mut lost, mut by_sentence) = (false, None);
        for (window, kind) in self.acting(now) {
            if matches!(kind, LinkFaultKind::HalfOpen) {
                lost = true;
            }
            if matches!(kind, LinkFaultKind::Duplicate { .. } | LinkFaultKind::Drop { .. }) {
                by_sentence = by_sentence.max(Some(window.until));
            }
        }
        if lost {
            let until = self.after(now, |kind| matches!(kind, LinkFaultKind::HalfOpen));
            let since = self.lost.filter(|lost| now <= lost.until).map_or(now, |lost| lost.from);
            self.lost = Some(Window { from: since, until });
            return;
        }
        match by_sentence {
            Some(until) => {
                self.sentence_until = until;
                self.push_sentences(now, bytes);
            }
            None => self.emit(now, bytes),
        }
    }

    /// The next bytes that have arrived by now.
    #[must_use]
    pub fn poll(&mut self, now: Timestamp) -> Option<Chunk> {
        if self.is_cut(now) {
            return None;
        }
        self.end_sentence(now);
        let piece = self.pieces.front().filter(|piece| piece.at <= now)?;
        let mut bytes = self.spare.pop().unwrap_or_default();
        bytes.clear();
        bytes.extend(self.bytes.drain(..piece.len));
        self.pieces.pop_front();
        Some(Chunk { bytes })
    }

    /// When [`FaultyLink::poll`] returns more bytes or the link is cut; `None` if nothing is under way and no cut will
    /// come.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Timestamp> {
        let arrives = self.pieces.front().map(|piece| piece.at);
        let sentence = (!self.sentence.is_empty()).then_some(self.sentence_until);
        let cut = (self.cut_at < Timestamp::MAX).then_some(self.cut_at);
        [arrives, sentence, cut].into_iter().flatten().min()
    }

    /// When a write will have been without an acknowledgement for `within`, as far as is known now: because it is under
    /// way for that long, or because it is lost and so is everything that is sent again meanwhile. A driver that gives
    /// up such a connection, as TCP does with its user timeout (RFC 5482), resets it then.
    #[must_use]
    pub fn gives_up(&self, within: Duration) -> Option<Timestamp> {
        // The computer of a deaf vehicle acknowledges what it has received.
        let taken = |piece: &Piece| piece.arrives < piece.at && piece.arrives < piece.written + within;
        let under_way = self.pieces.iter().find(|piece| !taken(piece));
        let under_way = under_way.map(|piece| piece.written + within);
        let lost = self.lost.map(|lost| (lost.from + within, lost.until));
        let lost = lost.filter(|(at, until)| at < until).map(|(at, _)| at);
        under_way.into_iter().chain(lost).min()
    }

    /// Whether the connection is cut. The driver resets it and tells the vehicle. It stays cut.
    #[must_use]
    pub fn is_cut(&self, now: Timestamp) -> bool {
        now >= self.cut_at
    }

    /// Takes a chunk's buffer back, to use it again.
    pub fn recycle(&mut self, chunk: Chunk) {
        if self.spare.len() < SPARES_MAX {
            self.spare.push(chunk.bytes);
        }
    }

    fn acting(&self, at: Timestamp) -> impl Iterator<Item = (Window, LinkFaultKind)> {
        let begun = self.acts.iter().take_while(move |(window, _)| window.from <= at);
        begun.filter(move |(window, _)| window.holds(at)).copied()
    }

    /// The time from which no fault of a kind acts: the end of those that act at `at`, and of those that begin before
    /// these end.
    fn after(&self, mut at: Timestamp, kind: impl Fn(&LinkFaultKind) -> bool) -> Timestamp {
        while let Some(until) = self
            .acting(at)
            .filter(|(_, acts)| kind(acts))
            .map(|(window, _)| window.until)
            .max()
        {
            at = until;
        }
        at
    }

    /// Recomputes when the pieces under way arrive and are read, after a stall or deafness was added: nothing arrives
    /// during a stall, what it holds back arrives together, and a deaf vehicle reads nothing.
    fn hold_back(&mut self) {
        let pieces = core::mem::take(&mut self.pieces);
        (self.last, self.last_read) = (Timestamp::ZERO, Timestamp::ZERO);
        for piece in pieces {
            self.line_up(piece);
        }
    }

    /// Forgets the faults that are over. They cannot touch what is written from now on.
    fn forget(&mut self, now: Timestamp) {
        if now < self.quiet_until {
            return;
        }
        self.acts.retain(|(window, _)| window.until > now);
        self.quiet_until = self.acts.first().map_or(Timestamp::MAX, |(window, _)| window.from);
    }

    fn uniform(&mut self) -> f64 {
        let (seed, name) = (self.seed, &self.name);
        self.stream.get_or_insert_with(|| Stream::new(seed, name)).uniform()
    }

    /// Sends an incomplete sentence unchanged when no fault waits for its end any more.
    fn end_sentence(&mut self, now: Timestamp) {
        if !self.sentence.is_empty() && now >= self.sentence_until {
            let sentence = core::mem::take(&mut self.sentence);
            self.emit(now, &sentence);
            self.sentence = sentence;
            self.sentence.clear();
        }
    }

    fn push_sentences(&mut self, now: Timestamp, bytes: &[u8]) {
        for part in bytes.split_inclusive(|byte| *byte == b'\n') {
            self.sentence.extend_from_slice(part);
            if !part.ends_with(b"\n") && self.sentence.len() < SENTENCE_MAX {
                break;
            }
            let mut times = 1u32;
            let acting: Vec<_> = self.acting(now).collect();
            for (_, kind) in acting {
                if let LinkFaultKind::Drop { chance } = kind
                    && self.uniform() < chance
                {
                    times = 0;
                }
                if let LinkFaultKind::Duplicate { chance } = kind
                    && self.uniform() < chance
                {
                    times *= 2;
                }
            }
            let sentence = core::mem::take(&mut self.sentence);
            for _ in 0..times {
                self.emit(now, &sentence);
            }
            self.sentence = sentence;
            self.sentence.clear();
        }
    }

    fn emit(&mut self, now: Timestamp, bytes: &[u8]) {
        let corrupts = |kind| {
            if let LinkFaultKind::Corrupt { chance } = kind {
                Some(chance)
            } else {
                None
            }
        };
        let intact = self
            .acting(now)
            .fold(1.0, |intact, (_, kind)| intact * (1.0 - corrupts(kind).unwrap_or(0.0)));
        if intact >= 1.0 {
            self.send(now, bytes);
            return;
        }
        let mut scratch = core::mem::take(&mut self.scratch);
        scratch.clear();
        for byte in bytes {
            let flips = self.uniform() >= intact;
            // Each of the eight bits is equally likely.
            let bit = if flips {
                1 << ((self.uniform() * 8.0) as u32).min(7)
            } else {
                0
            };
            scratch.push(byte ^ bit);
        }
        self.send(now, &scratch);
        self.scratch = scratch;
    }

    /// Applies delay, joining and splitting, and puts the bytes under way.
    fn send(&mut self, now: Timestamp, bytes: &[u8]) {
        let (mut at, mut jitters, mut hold, mut split) = (now, Duration::ZERO, Duration::ZERO, None);
        for (window, kind) in self.acting(now) {
            if let LinkFaultKind::Delay { delay, jitter, growth } = kind {
                at = at + delay;
                jitters += jitter;
                if growth > 0.0 {
                    at = at + now.since(window.from).mul_f64(growth).min(GROWN_MAX);
                }
            }
            if let LinkFaultKind::Join { hold: this } = kind {
                hold = hold.max(this);
            }
            if let LinkFaultKind::Split { bytes, gap } = kind
                && split.is_none_or(|(least, _)| bytes < least)
            {
                split = Some((bytes, gap));
            }
        }
        if !jitters.is_zero() {
            at = at + jitters.mul_f64(self.uniform());
        }
        if !hold.is_zero() {
            if let Some(last) = self.pieces.back_mut()
                && last.gathers
                && last.arrives >= at
                && last.len + bytes.len() <= PIECE_MAX
                && self.bytes.len() + bytes.len() <= QUEUE_MAX
            {
                last.len += bytes.len();
                self.bytes.extend(bytes);
                return;
            }
            at = at + hold;
        }
        let Some((most, gap)) = split else {
            self.put(now, at, bytes, !hold.is_zero());
            return;
        };
        let mut rest = bytes;
        while !rest.is_empty() {
            let len = (1 + (self.uniform() * f64::from(most)) as usize).min(rest.len());
            let (piece, after) = rest.split_at(len);
            if !self.pieces.is_empty() {
                at = at.max(self.last + gap);
            }
            self.put(now, at, piece, false);
            rest = after;
        }
    }

    fn put(&mut self, now: Timestamp, at: Timestamp, bytes: &[u8], gathers: bool) {
        if bytes.is_empty() {
            return;
        }
        if self.bytes.len() + bytes.len() > QUEUE_MAX || self.pieces.len() >= PIECES_MAX {
            // A time in the past: the link is cut at once.
            self.cut_at = Timestamp::ZERO;
            self.bytes = VecDeque::new();
            self.pieces = VecDeque::new();
            return;
        }
        self.bytes.extend(bytes);
        self.line_up(Piece {
            written: now,
            arrives: at,
            at,
            len: bytes.len(),
            gathers,
        });
    }

    /// Computes when a piece arrives and is read, and appends it. It arrives not before the last piece and not during a
    /// stall; a deaf vehicle reads it later.
    fn line_up(&mut self, piece: Piece) {
        let wanted = piece.arrives.max(self.last);
        let arrives = self.after(wanted, |kind| matches!(kind, LinkFaultKind::Stall));
        let at = self.after(arrives, |kind| matches!(kind, LinkFaultKind::Deaf));
        let at = at.max(self.last_read);
        (self.last, self.last_read) = (arrives, at);
        // What a stall has held back arrives together.
        let gathers = piece.gathers || arrives > wanted;
        match self.pieces.back_mut() {
            Some(last)
                if last.gathers && (last.arrives, last.at) == (arrives, at) && last.len + piece.len <= PIECE_MAX =>
            {
                last.len += piece.len;
            }
            _ => self.pieces.push_back(Piece {
                arrives,
                at,
                gathers,
                ..piece
            }),
        }
    }
}
