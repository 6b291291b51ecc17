use core::fmt;
use core::time::Duration;
use std::collections::VecDeque;

use backseat_spi::{AckStatus, SilentMode};
use backseat_units::Timestamp;
use backseat_world::Stream;

use crate::answers::Regarding;
use crate::event::{ClientId, MvcEventKind, Status};
use crate::file::{SilenceConfig, WorldFile};
use crate::mvc::Mvc;
use crate::vehicle::Drive;

/// How much longer the second acknowledgement is held off where the tailcone has not stopped (SPI 7.22).
const HELD_OFF: Duration = Duration::from_secs(2);
/// How many requests may wait for their second acknowledgement.
const CHANGES_MAX: usize = 64;

/// What happened to silent mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SilenceEvent {
    /// A client has asked for it: the devices are being quieted.
    Asked(ClientId),
    /// The vehicle is silent.
    Began,
    /// It could not be entered: why.
    Failed(&'static str),
    /// It ended at a payload's request.
    Ended,
    /// It ended by itself.
    TimedOut,
    /// The mission's wrap-up, a powered ascent, ended it.
    WrapUp,
}

/// Silent mode (SPI 7.22), and the tailcone that it asks after.
#[derive(Debug)]
pub(crate) struct Silence {
    config: SilenceConfig,
    stream: Stream,
    changes: VecDeque<Change>,
    /// When it ends by itself; none where the vehicle is not silent.
    until: Option<Timestamp>,
    /// The tailcone's target state: whether its thruster is on.
    driven: bool,
    /// A hovering vehicle has none: its thrusters go on in silence.
    has_tailcone: bool,
    /// The tailcone's current state: it spins until then.
    spins_until: Timestamp,
}

/// A request whose second acknowledgement is still to come.
#[derive(Clone, Copy, Debug)]
struct Change {
    re: Regarding,
    silent: bool,
    due: Timestamp,
    held_off: bool,
}

impl Silence {
    pub(crate) fn new(file: &WorldFile, seed: u64) -> Self {
        Self {
            config: file.silence,
            stream: Stream::new(seed, "silent mode"),
            changes: VecDeque::new(),
            until: None,
            driven: false,
            has_tailcone: !file.vehicle.hull().hovers,
            spins_until: Timestamp::ZERO,
        }
    }

    pub(crate) const fn is_silent(&self) -> bool {
        self.until.is_some()
    }

    /// Whether the vehicle is silent, or on the way there.
    pub(crate) fn is_commanded(&self) -> bool {
        self.is_silent() || self.changes.iter().any(|change| change.silent)
    }

    /// Whether the thruster is on.
    pub(crate) const fn is_driven(&self) -> bool {
        self.driven
    }

    /// Whether the tailcone spins, driven or not.
    pub(crate) fn is_spinning(&self, now: Timestamp) -> bool {
        self.has_tailcone && (self.driven || now < self.spins_until)
    }

    /// A connection is gone: its requests are decided and no longer answered.
    pub(crate) fn mute(&mut self, client: ClientId) {
        for change in self.changes.iter_mut().filter(|change| change.re.client == client) {
            change.re.muted = true;
        }
    }

    fn watch_tailcone(&mut self, now: Timestamp, driven: bool) {
        self.driven = driven;
        if driven {
            self.spins_until = now + Duration::from_secs_f64(self.config.spin_down_s);
        }
    }

    fn take_due(&mut self, now: Timestamp) -> Option<Change> {
        let at = self.changes.iter().position(|change| change.due <= now)?;
        self.changes.remove(at)
    }
}

impl Mvc {
    /// BPSIL (SPI 7.22). Both acknowledgements come whatever the setting for other requests.
    pub(crate) fn silent_mode(&mut self, now: Timestamp, re: Regarding, request: &SilentMode) {
        if self.silence.changes.len() >= CHANGES_MAX {
            self.acknowledge(now, re, AckStatus::Failed, "too many requests are pending");
            return;
        }
        if request.silent && !self.silence.is_silent() {
            // "The target state of the tailcone is checked". It is at rest wherever no mission runs.
            if self.silence.has_tailcone && self.silence.is_driven() {
                return self.silence_failed(now, re, "the tailcone is spinning");
            }
            if self.adjustment.is_asked_for() && !self.interpretation.silence_cancels_adjustment {
                return self.silence_failed(now, re, "a trim or buoyancy adjustment is running");
            }
            self.note(now, MvcEventKind::Silence(SilenceEvent::Asked(re.client)));
            self.silence_adjustment(now);
        }
        if !request.silent {
            self.withdraw_silence(now);
        }
        self.acknowledge(now, re, AckStatus::Pending, "");
        let settle_s = self.silence.config.settle_s.draw(&mut self.silence.stream);
        self.silence.changes.push_back(Change {
            re,
            silent: request.silent,
            due: now + Duration::from_secs_f64(settle_s),
            held_off: false,
        });
    }

    /// One step of the vehicle.
    pub(crate) fn tick_silence(&mut self, now: Timestamp) {
        while let Some(change) = self.silence.take_due(now) {
            if change.silent {
                self.enter_silence(now, change);
            } else {
                let text = if self.silence.is_silent() {
                    ""
                } else {
                    "the vehicle was not silent"
                };
                self.end_silence(now, SilenceEvent::Ended);
                self.acknowledge(now, change.re, AckStatus::Succeeded, text);
            }
        }
        // "The vehicle will resume as normal with no feedback to the payload."
        if self.silence.until.is_some_and(|until| until <= now) {
            self.end_silence(now, SilenceEvent::TimedOut);
        }
    }

    /// What moves the vehicle in truth: the thruster is off while the vehicle is silent, while it adjusts its trim or
    /// buoyancy, and where no speed is asked for.
    pub(crate) fn quieted(&mut self, now: Timestamp, drive: Drive) -> Drive {
        if matches!(drive, Drive::Under(_)) && self.executive.status() != Status::Running {
            // A powered ascent. Bringing the vehicle home comes first; the specification does not speak of it.
            self.end_silence(now, SilenceEvent::WrapUp);
            self.abandon_adjustment(now);
        }
        let drive = match drive {
            Drive::Under(_)
                if self.silence.has_tailcone && (self.silence.is_silent() || self.adjustment.is_asked_for()) =>
            {
                Drive::Adrift
            }
            Drive::Under(demand) if !demand.throttle.is_on() && !self.vehicle.hull().hovers => Drive::Adrift,
            Drive::Held | Drive::Under(_) | Drive::Hover(_) | Drive::Adrift => drive,
        };
        self.silence.watch_tailcone(now, matches!(drive, Drive::Under(_)));
        drive
    }

    fn enter_silence(&mut self, now: Timestamp, mut change: Change) {
        if self.silence.is_silent() {
            let text = "silent already: the time is not extended";
            return self.acknowledge(now, change.re, AckStatus::Succeeded, text);
        }
        if self.silence.is_spinning(now) {
            if change.held_off {
                return self.silence_failed(now, change.re, "the tailcone is still spinning");
            }
            (change.held_off, change.due) = (true, change.due + HELD_OFF);
            self.silence.changes.push_back(change);
            return;
        }
        if self.silence.stream.uniform() < self.silence.config.failure_chance {
            return self.silence_failed(now, change.re, "a device did not go quiet");
        }
        self.silence.until = Some(now + Duration::from_secs_f64(self.silence.config.timeout_s));
        self.note(now, MvcEventKind::Silence(SilenceEvent::Began));
        self.silence_adjustment(now);
        self.silence_acoustic(now);
        self.acknowledge(now, change.re, AckStatus::Succeeded, "");
    }

    fn silence_failed(&mut self, now: Timestamp, re: Regarding, why: &'static str) {
        self.note(now, MvcEventKind::Silence(SilenceEvent::Failed(why)));
        self.acknowledge(now, re, AckStatus::Failed, why);
    }

    /// A request for normal mode overtakes those for silence that are not decided.
    fn withdraw_silence(&mut self, now: Timestamp) {
        while let Some(at) = self.silence.changes.iter().position(|change| change.silent) {
            if let Some(change) = self.silence.changes.remove(at) {
                self.silence_failed(now, change.re, "normal mode was asked for meanwhile");
            }
        }
    }

    fn end_silence(&mut self, now: Timestamp, why: SilenceEvent) {
        if self.silence.until.take().is_some() {
            self.note(now, MvcEventKind::Silence(why));
        }
    }
}

impl fmt::Display for SilenceEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Asked(client) => write!(f, "{client} asks for silence"),
            Self::Began => f.write_str("silent mode began"),
            Self::Failed(why) => write!(f, "silent mode was not entered: {why}"),
            Self::Ended => f.write_str("silent mode ended: asked for"),
            Self::TimedOut => f.write_str("silent mode ended: timed out"),
            Self::WrapUp => f.write_str("silent mode ended: the mission wraps up"),
        }
    }
}
