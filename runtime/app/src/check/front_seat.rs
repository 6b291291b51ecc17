//! The front seat's plan, held against the fence, and what a vehicle of the class can do, against limits and fence.

use std::path::Path;
use std::time::Duration;

use anyhow::Result;
use backseat_fence::{Fence, Rfc3339};
use backseat_mission::{Dive, FrontSeatPlan, Mission, beyond_class};
use backseat_plan::{VehicleClass, VehicleLimits};
use backseat_units::{Position, Utc};

use crate::output::say;

/// What is known ashore of the vehicle and of what it will do by itself.
pub(super) struct FrontSeat {
    /// What it can do, where its class is known.
    pub(super) vehicle: Option<(VehicleClass, VehicleLimits)>,
    pub(super) plan: Option<FrontSeatPlan>,
    /// Where it begins.
    pub(super) start: Option<Position>,
    pub(super) start_depth_m: f64,
    /// From the begin of the dive to that of the plan, seconds.
    pub(super) starts_after_s: f64,
    /// When the simulation begins.
    pub(super) simulated_at: Option<Utc>,
    /// What is to be said of `world.toml`.
    pub(super) remark: Option<&'static str>,
}

impl FrontSeat {
    /// What the mission says, with the plan of a file in the place of its own.
    pub(super) fn of_mission(mission: &Mission, file: Option<&Path>) -> Result<Self> {
        let vehicle = mission.file.vehicle.class.map(|class| (class, class.limits()));
        let limits = vehicle.map_or_else(VehicleLimits::of_any_class, |(_, limits)| limits);
        let plan = match file {
            Some(file) => Some(FrontSeatPlan::read(file, &limits, None)?),
            None => mission.plan.clone(),
        };
        Ok(Self {
            vehicle,
            plan,
            start: None,
            start_depth_m: 0.0,
            starts_after_s: 0.0,
            simulated_at: None,
            remark: None,
        })
    }

    /// Says what is judged, and gives back what is amiss, a line each. `at` is when the dive begins, where the operator has
    /// named it.
    pub(super) fn findings(&self, mission: &Mission, at: Option<Utc>, now: Utc) -> Result<Vec<String>> {
        let (fence, limits) = (mission.envelope.fence(), &mission.file.limits);
        let mut findings = match &self.vehicle {
            Some((class, vehicle)) => beyond_class(limits, fence, *class, vehicle),
            None => {
                say!("no [vehicle] class: what its hull can do is held against nothing");
                Vec::new()
            }
        };
        if let Some(remark) = self.remark {
            say!("{remark}");
        }
        let Some(plan) = &self.plan else {
            say!("no plan of the front seat: it is held against nothing; name one by --plan or [plan]");
            return Ok(findings);
        };
        let begun_at = |utc: Utc| Dive {
            fence,
            limits,
            plan: &plan.behaviors,
            start: self.start,
            start_depth_m: self.start_depth_m,
            utc: utc + Duration::try_from_secs_f64(self.starts_after_s).unwrap_or_default(),
        };
        if begun_at(now).bottom_is_unknown() {
            say!("plan: how far from the bottom it keeps is not judged: [limits] has no water_depth_min_m");
        }
        let begins = self.begins(at, fence, now);
        if fence.changes() {
            let times: Vec<String> = begins
                .iter()
                .map(|(utc, why)| format!("{} ({why})", Rfc3339(*utc)))
                .collect();
            say!(
                "plan: judged as begun at {}; --at names another time",
                times.join(" and at ")
            );
        }
        let mut outside = Vec::new();
        for (utc, why) in begins {
            for finding in begun_at(utc).findings() {
                if !outside.iter().any(|(told, _)| *told == finding) {
                    outside.push((finding, why));
                }
            }
        }
        if outside.is_empty() {
            let whence = if self.start.is_some() {
                "its start"
            } else {
                "its first place"
            };
            say!(
                "plan: {whence} and all {} behaviors, with the ways between them, lie inside the fence",
                plan.behaviors.len()
            );
        }
        findings.extend(outside.into_iter().map(|(finding, why)| match fence.changes() {
            true => format!("{finding} (begun {why})"),
            false => finding,
        }));
        Ok(findings)
    }

    /// When the dive is taken to begin, and why then. Zones that come and go count on the day of the dive, which is not that
    /// of the simulation.
    fn begins(&self, at: Option<Utc>, fence: &Fence, now: Utc) -> Vec<(Utc, &'static str)> {
        let today = (
            Utc::from_unix_nanos(now.as_unix_nanos() / 1_000_000_000 * 1_000_000_000),
            "now",
        );
        match (at, self.simulated_at) {
            (Some(at), _) => vec![(at, "as --at says")],
            (None, Some(simulated_at)) => {
                let mut begins = vec![(simulated_at, "as world.toml says")];
                begins.extend(fence.changes().then_some(today));
                begins
            }
            (None, None) => vec![today],
        }
    }
}
