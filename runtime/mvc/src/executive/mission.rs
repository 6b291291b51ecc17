use core::time::Duration;

use backseat_spi::Text;
use backseat_units::{EastNorth, Timestamp};
use backseat_world::Stream;

use super::Executive;
use super::dives::{Dives, LoadableDive, running};
use super::schedule::Schedule;
use crate::context::Context;
use crate::event::{ClientId, Status};
use crate::file::WorldFile;
use crate::interpretation::Interpretation;
use crate::plan::GpsTimes;
use crate::script::ControlOrder;
use crate::truth::Activity;
use crate::vehicle::{Drive, HoverDemand};

/// The mission's side of SPI: it passes the commands of SPI 7.5 to 7.13, 7.16, 7.17, 7.19 and 7.20 to the executive,
/// and reports to the clients what the executive does (SPI 5.1, 5.3, 5.4, 6.9 to 6.11, 6.20, 6.24).
#[derive(Debug)]
pub(crate) struct Mission {
    pub(super) executive: Executive,
    pub(super) dive_file: Text,
    /// The status text of BFMIS while the mission runs.
    pub(super) running: Text,
    /// The same while an empty mission runs.
    pub(super) running_empty: Text,
    pub(super) empty_allowed: bool,
    /// How long a GPS hit takes.
    pub(super) gps: GpsTimes,
    pub(super) schedule: Schedule,
    pub(super) dives: Dives,
}

impl Mission {
    pub(crate) fn new(
        file: &WorldFile,
        dives: Vec<LoadableDive>,
        interpretation: Interpretation,
        period: Duration,
        seed: u64,
    ) -> Self {
        let config = &file.mission;
        let fix_s = config.gps_fix_s.draw(&mut Stream::new(seed, "gps fix"));
        let mut dives = Dives::new(dives, file);
        let status = dives.status_at_start();
        let mut executive = Executive::new(config, &file.vehicle, interpretation, period, status);
        let mut dive_file = Text::default();
        if let Some(dive) = dives.loaded_from_the_start() {
            dive_file = dive.file.clone();
            executive.load(dive, Timestamp::ZERO);
            // Nobody hears of what happened before the start.
            executive.take_log();
        }
        Self {
            executive,
            dive_file,
            running: running(&config.log_dir),
            running_empty: running(&config.log_dir),
            empty_allowed: config.empty_allowed,
            gps: GpsTimes {
                fix: Duration::from_secs_f64(fix_s),
                within: Duration::from_secs_f64(config.gps_within_s),
            },
            schedule: Schedule::new(&config.commands),
            dives,
        }
    }

    pub(crate) const fn status(&self) -> Status {
        self.executive.status()
    }

    /// Whether the payload has control (SPI 6.24).
    pub(crate) const fn control(&self) -> bool {
        self.executive.control()
    }

    pub(crate) fn activity(&self) -> Activity {
        self.executive.activity()
    }

    /// One step of the vehicle. Returns what moves it now.
    pub(crate) fn step(&mut self, ctx: &Context<'_>) -> Drive {
        self.step_dives(ctx.now);
        self.executive.tick(ctx.now, &ctx.estimate, ctx.north.frame_deg)
    }

    /// When a modify or a suspension lapses unless it is refreshed.
    pub(crate) fn lapses_at(&self) -> Option<Timestamp> {
        self.executive.lapses_at()
    }

    pub(crate) fn lapse(&mut self, now: Timestamp) {
        self.executive.lapse(now);
    }

    /// Whether control is withheld though the plan allows it; the next step acts on it.
    pub(crate) const fn deny_control(&mut self, denied: bool) {
        self.executive.deny_control(denied);
    }

    /// What decides about control from now on; the next step acts on it.
    pub(crate) const fn order_control(&mut self, order: ControlOrder) {
        self.executive.order_control(order);
    }

    /// The vehicle ends a mission that is running or waiting to start.
    pub(crate) fn fail(&mut self, details: &'static str) {
        self.executive.fail_mission(details);
    }

    /// See [`Executive::suspend`].
    pub(crate) fn suspend(&mut self, ctx: &Context<'_>, client: ClientId) -> Result<bool, &'static str> {
        self.executive.suspend(ctx.now, client, &ctx.estimate)
    }

    /// See [`Executive::keep_suspended`].
    pub(crate) fn keep_suspended(&mut self, now: Timestamp) -> bool {
        self.executive.keep_suspended(now)
    }

    /// See [`Executive::resume_asked`].
    pub(crate) fn resume(&mut self, now: Timestamp) -> bool {
        self.executive.resume_asked(now)
    }

    pub(crate) fn is_suspended(&self) -> bool {
        self.executive.is_suspended()
    }

    /// When the suspension lapses unless it is refreshed.
    pub(crate) fn suspended_until(&self) -> Option<Timestamp> {
        self.executive.suspended_until()
    }

    /// Sets the demand of the payload that has suspended the mission.
    pub(crate) fn set_hover(&mut self, hover: HoverDemand) {
        self.executive.set_hover(hover);
    }

    /// The points of the plan and of the inserts in it, with the numbers of the planned elements.
    pub(crate) fn plan_points(&self, at: EastNorth) -> Vec<(Option<u32>, EastNorth)> {
        let points = self.executive.points(at).into_iter();
        points.map(|point| (point.number, point.at)).collect()
    }
}
