use std::time::Duration;

use backseat_units::{TimeOfDay, Timestamp};

use crate::settings::ControlHook;
use crate::vehicle::clock::elapsed_nanos;

/// For how long a message can count as older than one that came before it. After that, a time of day that seems older is
/// that of another day, or the vehicle's clock was set.
const OLDER_WITHIN: Duration = Duration::from_secs(60);

const DAY_NANOS: i64 = 86_400_000_000_000;

/// The newest message of a kind that has ended or stopped something: when the vehicle made it, and when it came. A message
/// that allows something again does not count if it was made before.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) struct Newest {
    // The vehicle of the exploration sends nothing late, so there this changes nothing.
    #[cfg_attr(feature = "explore", serde(skip))]
    message: Option<(TimeOfDay, Timestamp)>,
}

/// Core has found that the vehicle's clock was set.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ClockSet {
    /// When core found it.
    pub(crate) at: Timestamp,
    /// What the vehicle wrote just before, by its new clock.
    pub(crate) written: TimeOfDay,
    /// By how much the vehicle's times are later now, nanoseconds.
    pub(crate) by_nanos: i64,
}

impl Newest {
    /// Whether a message that comes now was made before the newest one: either it is late, or the vehicle's clock was set.
    pub(crate) fn is_after(&self, now: Timestamp, created: TimeOfDay) -> bool {
        let newest = self.message.filter(|(_, heard)| now.since(*heard) < OLDER_WITHIN);
        newest.is_some_and(|(newest, _)| elapsed_nanos(newest, created) < 0)
    }

    /// The vehicle's clock was set: moves the time of the newest message with it, unless the vehicle gave it the time by its
    /// new clock.
    pub(crate) fn clock_set(&mut self, set: ClockSet) {
        let Some((created, heard)) = &mut self.message else {
            return;
        };
        // How much later than it came the message was made, if the vehicle's clock was set before that.
        let since_heard = i64::try_from(set.at.since(*heard).as_nanos()).unwrap_or(i64::MAX);
        let later = elapsed_nanos(set.written, *created).saturating_add(since_heard);
        if later.abs() > set.by_nanos.abs() / 2 {
            let whole = DAY_NANOS + set.by_nanos % DAY_NANOS;
            *created = *created + Duration::from_nanos(whole.unsigned_abs());
        }
    }

    /// When the vehicle made the newest one.
    pub(crate) fn created(&self) -> Option<TimeOfDay> {
        self.message.map(|(created, _)| created)
    }

    /// Such a message has come. It becomes the newest, unless it is older; then the newest counts from now on.
    pub(crate) fn hear(&mut self, now: Timestamp, created: TimeOfDay) {
        let created = match self.message {
            Some((newest, _)) if self.is_after(now, created) => newest,
            _ => created,
        };
        self.message = Some((created, now));
    }
}

/// What the vehicle, the operator and the run itself say about who steers.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Control {
    /// The operator allows this process to send messages that steer.
    pub(crate) armed: bool,
    /// Whether the backseat has control, by the last word of the configured hook.
    pub(crate) handed_over: Option<bool>,
    /// The newest message of this connection that took control away.
    revoked: Newest,
    /// The newest BFMIS of this connection with the status `Running`, and the newest with another.
    ran: Newest,
    stopped: Newest,
    /// When the operator held last, if that was not by text.
    #[cfg_attr(feature = "explore", serde(skip))]
    pub(crate) held_at: Option<Timestamp>,
    /// The newest BFMSC whose text held.
    pub(crate) held_by_text: Newest,
    /// When the newest message of this connection came that may have taken control away, and could not be read.
    doubted: Option<Timestamp>,
    /// BFMIS begins with `Running`.
    pub(crate) running: Option<bool>,
    /// The operator holds.
    pub(crate) held: bool,
    /// The run is ending.
    pub(crate) stopping: bool,
    /// The operator has ended the mission. Whatever comes of that order, plugins do not steer until the mission is over
    /// or the operator releases them.
    pub(crate) mission_ended: bool,
    /// The vehicle is outside the fence because of us: no plugin's request is accepted.
    pub(crate) recovering: bool,
    /// Whether control is ours, as core last reported it.
    pub(crate) granted: bool,
}

impl Control {
    /// What holds as a process begins.
    pub(crate) fn new(armed: bool, held: bool) -> Self {
        Self {
            armed,
            held,
            ..Self::default()
        }
    }

    /// The link is new or gone: the vehicle has said nothing about control on it.
    pub(crate) fn forget(&mut self) {
        self.handed_over = None;
        self.running = None;
        (self.revoked, self.ran, self.stopped) = Default::default();
        self.doubted = None;
    }

    /// A BFCTL, or a BFMSC with one of the texts for it, has come. One that gives control does not count if the vehicle made
    /// it before the newest one that took control away: either it is late, or the vehicle's clock was set. Nobody can tell
    /// which, so it is then unknown who has control. Nor does it count if the vehicle may have made it before the newest one
    /// came that could not be read. `made` is the earliest time, by our clock, at which the vehicle may have made it.
    /// Returns whether it counts.
    pub(crate) fn hand_over(&mut self, now: Timestamp, (created, made): (TimeOfDay, Timestamp), granted: bool) -> bool {
        let counts = !granted || !(self.revoked.is_after(now, created) || self.is_doubted(now, made));
        if !granted {
            self.revoked.hear(now, created);
        }
        self.handed_over = counts.then_some(granted);
        counts
    }

    /// A BFMIS has come. One that says `Running` does not count if the vehicle made it before the newest one that says
    /// something else, and the other way round. Returns whether it counts.
    pub(crate) fn mission(&mut self, now: Timestamp, (created, made): (TimeOfDay, Timestamp), running: bool) -> bool {
        let (this, other) = if running {
            (&mut self.ran, self.stopped)
        } else {
            (&mut self.stopped, self.ran)
        };
        this.hear(now, created);
        !(other.is_after(now, created) || running && self.is_doubted(now, made))
    }

    /// The vehicle's clock was set.
    pub(crate) fn clock_set(&mut self, set: ClockSet) {
        for newest in [
            &mut self.revoked,
            &mut self.ran,
            &mut self.stopped,
            &mut self.held_by_text,
        ] {
            newest.clock_set(set);
        }
    }

    /// Whether a text that the vehicle made at this time at the earliest, by our clock, was made before the operator held last without a text.
    pub(crate) fn is_before_hold(&self, now: Timestamp, made: Timestamp) -> bool {
        let held = self.held_at.filter(|held| now.since(*held) < OLDER_WITHIN);
        held.is_some_and(|held| made < held)
    }

    fn is_doubted(&self, now: Timestamp, made: Timestamp) -> bool {
        let doubted = self.doubted.filter(|heard| now.since(*heard) < OLDER_WITHIN);
        doubted.is_some_and(|heard| made < heard)
    }

    /// Whether the vehicle has told on this connection what it tells each new subscriber: who has control, and whether its
    /// mission runs.
    pub(crate) fn is_told(&self, hook: &ControlHook) -> bool {
        (*hook != ControlHook::Bfctl || self.handed_over.is_some()) && self.running.is_some()
    }

    /// A message of the vehicle that is damaged or cannot be read may have taken control away (safety requirement 001).
    /// Returns whether this one may have.
    pub(crate) fn doubt(&mut self, now: Timestamp, hook: &ControlHook, message: &str) -> bool {
        match message {
            "BFCTL" if *hook == ControlHook::Bfctl => self.handed_over = None,
            "BFMSC" if matches!(hook, ControlHook::MissionCommand { .. }) => self.handed_over = None,
            "BFMIS" => self.running = None,
            _ => return false,
        }
        self.doubted = Some(now);
        true
    }
}
