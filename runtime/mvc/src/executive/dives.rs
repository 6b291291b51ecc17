use core::time::Duration;

use backseat_spi::Text;
use backseat_units::{LocalFrame, Timestamp};

use super::mission::Mission;
use crate::context::Context;
use crate::error::{DiveError, MvcError};
use crate::event::Status;
use crate::file::{DiveConfig, InvalidFile, MissionConfig, WorldFile, WrapUp};
use crate::plan::{self, PlanItem};

/// A dive that can be loaded.
#[derive(Clone, Debug)]
pub(crate) struct LoadableDive {
    pub(crate) file: Text,
    /// The status text of BFMIS while it runs.
    pub(crate) running: Text,
    pub(crate) plan: Vec<PlanItem>,
    pub(crate) wrap_up: WrapUp,
    pub(crate) invalid: Option<InvalidFile>,
    /// When it starts, counted from when it is loaded; `None` if only an operator starts it.
    pub(crate) start_after: Option<Duration>,
    /// When the operator calls it off, counted from its start, and whether that is an abort.
    pub(crate) called_off: Option<(Duration, bool)>,
    /// When it is loaded, counted from when the vehicle could take it; `None` if only an operator loads it.
    load_after: Option<Duration>,
}

/// The dives of a file: those of `[[dive]]`, or else the one of `[mission]` and `[[plan]]`.
pub(crate) fn resolve(file: &WorldFile, frame: &LocalFrame) -> Result<Vec<LoadableDive>, MvcError> {
    let plan = plan::resolve(&file.plan, frame, &file.vehicle)?;
    if file.dive.is_empty() {
        let mission = &file.mission;
        let starts = Duration::from_secs_f64(mission.starts_after_s);
        let online = Duration::from_secs_f64(mission.online_after_s);
        return Ok(vec![LoadableDive {
            file: Text::cleaned(&mission.dive_file),
            running: running(&mission.log_dir),
            plan,
            wrap_up: mission.wrap_up,
            invalid: None,
            start_after: Some(starts.saturating_sub(online)),
            called_off: None,
            load_after: Some(Duration::ZERO),
        }]);
    }
    let dives = (1..).zip(&file.dive).map(|(number, dive)| {
        let own = if dive.plan.is_empty() {
            Ok(plan.clone())
        } else {
            plan::resolve(&dive.plan, frame, &file.vehicle)
        };
        own.map(|plan| LoadableDive::new(dive, plan, &file.mission))
            .map_err(|error| error.of_dive(number))
    });
    dives.collect()
}

impl LoadableDive {
    fn new(dive: &DiveConfig, plan: Vec<PlanItem>, mission: &MissionConfig) -> Self {
        let after = |seconds: Option<f64>| seconds.map(Duration::from_secs_f64);
        let abort = after(dive.abort_after_s).map(|after| (after, true));
        Self {
            file: Text::cleaned(&dive.file),
            running: running(dive.log_dir.as_deref().unwrap_or(&mission.log_dir)),
            plan,
            wrap_up: dive.wrap_up.unwrap_or(mission.wrap_up),
            invalid: dive.invalid,
            start_after: after(dive.start_after_s),
            called_off: abort.or_else(|| after(dive.end_after_s).map(|after| (after, false))),
            load_after: after(dive.load_after_s),
        }
    }
}

/// The status text of BFMIS while a mission with this logging directory runs.
pub(super) fn running(log_dir: &str) -> Text {
    let running = format!("{} {log_dir}", Status::Running.name());
    Text::cleaned(running.trim_end())
}

/// The dives on the vehicle, and which of them is loaded next.
#[derive(Debug)]
pub(super) struct Dives {
    dives: Vec<LoadableDive>,
    online_at: Timestamp,
    /// The next one that may be loaded without an operator.
    next: usize,
    /// Since when a dive could be loaded; `None` while one is loaded.
    free_since: Option<Timestamp>,
    /// Whether the only dive is that of `[mission]`, whose start counts from the start of the run.
    of_mission: bool,
}

impl Dives {
    pub(super) fn new(dives: Vec<LoadableDive>, file: &WorldFile) -> Self {
        let online_at = Timestamp::ZERO + Duration::from_secs_f64(file.mission.online_after_s);
        Self {
            dives,
            online_at,
            next: 0,
            free_since: Some(online_at),
            of_mission: file.dive.is_empty(),
        }
    }

    pub(super) fn status_at_start(&self) -> Status {
        if self.online_at > Timestamp::ZERO {
            Status::Offline
        } else {
            Status::Waiting
        }
    }

    /// The dive that is loaded before the first step, if the vehicle has only that of `[mission]` and is online.
    pub(super) fn loaded_from_the_start(&mut self) -> Option<LoadableDive> {
        let loaded = self.of_mission && self.online_at == Timestamp::ZERO;
        loaded.then(|| self.take(0)).flatten()
    }

    /// The next dive that is due without an operator, and since when it is.
    fn next_due(&mut self, now: Timestamp) -> Option<(LoadableDive, Timestamp)> {
        let since = *self.free_since.get_or_insert(now);
        let waiting = self.dives.iter().enumerate().skip(self.next);
        let (index, after) = waiting
            .filter_map(|(index, dive)| Some((index, dive.load_after?)))
            .next()?;
        let due = since + after;
        if now < due {
            return None;
        }
        self.take(index).map(|dive| (dive, due))
    }

    fn is_next_waiting(&self) -> bool {
        self.dives.iter().skip(self.next).any(|dive| dive.load_after.is_some())
    }

    fn place(&self, file: &str) -> Option<usize> {
        self.dives.iter().position(|dive| dive.file.as_str() == file)
    }

    fn take(&mut self, index: usize) -> Option<LoadableDive> {
        let dive = self.dives.get_mut(index)?;
        let taken = dive.clone();
        if self.of_mission {
            dive.start_after = None;
        }
        // An operator who loads the next dive does what the vehicle would have done. Any other dive comes in between.
        let skipped = self.dives.iter().take(index).skip(self.next);
        if index >= self.next && skipped.filter(|dive| dive.load_after.is_some()).count() == 0 {
            self.next = index + 1;
        }
        self.free_since = None;
        Some(taken)
    }
}

/// Dives one after the other: an operator loads, starts, ends and aborts them, or the file says when.
impl Mission {
    /// The names of the dives that can be loaded.
    pub(crate) fn dives(&self) -> impl Iterator<Item = &str> {
        self.dives.dives.iter().map(|dive| dive.file.as_str())
    }

    /// Whether a dive will still be loaded without an operator.
    pub(crate) fn is_next_dive_waiting(&self) -> bool {
        self.dives.is_next_waiting()
    }

    /// The vehicle comes online, or loads the dive whose time has come.
    pub(super) fn step_dives(&mut self, now: Timestamp) {
        if self.executive.status() == Status::Offline {
            if now < self.dives.online_at {
                return;
            }
            self.executive.set_status(Status::Waiting, "");
        }
        if !self.executive.status().is_free() {
            self.dives.free_since = None;
            return;
        }
        if let Some((dive, due)) = self.dives.next_due(now) {
            self.load(dive, due);
        }
    }

    /// An operator loads a dive.
    pub(crate) fn load_dive(&mut self, ctx: &mut Context<'_>, file: &str) -> Result<(), DiveError> {
        let index = self.dives.place(file).ok_or_else(|| DiveError::NoSuchDive {
            file: file.into(),
            dives: self.dives().collect::<Vec<_>>().join(", "),
        })?;
        match self.executive.status() {
            Status::Offline => return Err(DiveError::Offline),
            Status::Running | Status::WrappingUp | Status::Aborting => return Err(DiveError::Running),
            Status::Waiting
            | Status::InvalidDiveFile
            | Status::InvalidWrapupFile
            | Status::Ready
            | Status::Completed
            | Status::Aborted
            | Status::Stopped => {}
        }
        if let Some(dive) = self.dives.take(index) {
            self.load(dive, ctx.now);
        }
        self.settle(ctx);
        Ok(())
    }

    fn load(&mut self, dive: LoadableDive, at: Timestamp) {
        self.dive_file = dive.file.clone();
        self.running = dive.running.clone();
        self.schedule.begin_again();
        self.executive.load(dive, at);
    }

    /// An operator starts the dive that is ready.
    pub(crate) fn start_dive(&mut self, ctx: &mut Context<'_>) -> Result<(), DiveError> {
        match self.executive.status() {
            Status::Ready => {}
            Status::Running | Status::WrappingUp | Status::Aborting => return Err(DiveError::Running),
            other @ (Status::Offline
            | Status::Waiting
            | Status::InvalidDiveFile
            | Status::InvalidWrapupFile
            | Status::Completed
            | Status::Aborted
            | Status::Stopped) => return Err(DiveError::NotReady(other.name())),
        }
        self.executive.start(ctx.now, ctx.now, ctx.estimate.at);
        self.settle(ctx);
        Ok(())
    }

    /// An operator ends the running dive as successful.
    pub(crate) fn end_dive(&mut self, ctx: &mut Context<'_>) -> Result<(), DiveError> {
        if self.executive.abort(false, ENDED).is_err() {
            return Err(DiveError::NotRunning(self.executive.status().name()));
        }
        self.settle(ctx);
        Ok(())
    }

    /// An operator aborts the running dive, or takes back the one that is ready.
    pub(crate) fn abort_dive(&mut self, ctx: &mut Context<'_>) -> Result<(), DiveError> {
        match self.executive.status() {
            Status::Ready | Status::Running | Status::WrappingUp => self.executive.fail_mission(ABORTED),
            other @ (Status::Offline
            | Status::Waiting
            | Status::InvalidDiveFile
            | Status::InvalidWrapupFile
            | Status::Aborting
            | Status::Completed
            | Status::Aborted
            | Status::Stopped) => return Err(DiveError::NotRunning(other.name())),
        }
        self.settle(ctx);
        Ok(())
    }
}

/// What BFMIS says of a dive that an operator has called off.
pub(super) const ENDED: &str = "ended by the operator";
pub(super) const ABORTED: &str = "aborted by the operator";
