//! Checks the front seat's plan against the fence, and the limits and the fence against what the vehicle's class can
//! do.

use std::path::Path;
use std::time::Duration;

use anyhow::Result;
use backseat_fence::{Fence, Rfc3339};
use backseat_mission::{Dive, FrontSeatPlan, Mission, beyond_class};
use backseat_plan::{VehicleClass, VehicleLimits};
use backseat_units::{Position, Utc};

use crate::output::say;

/// What is known before the dive about the vehicle and the plan that it flies by itself.
pub(super) struct FrontSeat {
    /// The vehicle's class with its limits, where the class is known.
    pub(super) vehicle: Option<(VehicleClass, VehicleLimits)>,
    pub(super) plan: Option<FrontSeatPlan>,
    /// Where the plan begins.
    pub(super) start: Option<Position>,
    pub(super) start_depth_m: f64,
    /// From the beginning of the dive to that of the plan, seconds.
    pub(super) starts_after_s: f64,
    /// When the simulation begins.
    pub(super) simulated_at: Option<Utc>,
    /// A remark about `world.toml` to print.
    pub(super) remark: Option<&'static str>,
}

impl FrontSeat {
    /// The mission's vehicle and plan. `file` replaces the mission's plan.
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

    /// Prints what is checked and returns the findings, one line each. `at` is when the dive begins, where the operator
    /// has given it.
    pub(super) fn findings(&self, mission: &Mission, at: Option<Utc>, now: Utc) -> Result<Vec<String>> {
        let (fence, limits) = (mission.envelope.fence(), &mission.file.limits);
        let mut findings = match &self.vehicle {
            Some((class, vehicle)) => beyond_class(limits, fence, *class, vehicle),
            None => {
                say!("no [vehicle] class: limits and fence are not checked against what the vehicle can do");
                Vec::new()
            }
        };
        if let Some(remark) = self.remark {
            say!("{remark}");
        }
        let Some(plan) = &self.plan else {
            say!("no plan of the front seat, so none is checked against the fence; name one with --plan or [plan]");
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
            say!("plan: altitude not checked, because [limits] has no water_depth_min_m");
        }
        let begins = self.begins(at, fence, now);
        if fence.changes() {
            let times: Vec<String> = begins
                .iter()
                .map(|(utc, why)| format!("{} ({why})", Rfc3339(*utc)))
                .collect();
            say!(
                "plan: checked for a dive that begins at {}; --at sets another time",
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
                "its first position"
            };
            match plan.behaviors.len() {
                1 => say!("plan: {whence}, its behavior and the path to it lie inside the fence"),
                many => say!("plan: {whence}, all {many} behaviors and the paths between them lie inside the fence"),
            }
        }
        findings.extend(outside.into_iter().map(|(finding, why)| match fence.changes() {
            true => format!("{finding} (start of the dive: {why})"),
            false => finding,
        }));
        Ok(findings)
    }

    /// The times at which the dive may begin, each with where the time comes from. Zones with a time window are also
    /// checked for a dive that begins now, because the real dive is not on the day of the simulation.
    fn begins(&self, at: Option<Utc>, fence: &Fence, now: Utc) -> Vec<(Utc, &'static str)> {
        let today = (
            Utc::from_unix_nanos(now.as_unix_nanos() / 1_000_000_000 * 1_000_000_000),
            "now",
        );
        match (at, self.simulated_at) {
            (Some(at), _) => vec![(at, "from --at")],
            (None, Some(simulated_at)) => {
                let mut begins = vec![(simulated_at, "from world.toml")];
                begins.extend(fence.changes().then_some(today));
                begins
            }
            (None, None) => vec![today],
        }
    }
}
