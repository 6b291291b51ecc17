//! The monitor's answer to a plugin that asks before it makes a request.

use super::{Clocks, End, Envelope, Insert, Route, Surroundings, bottom_lock};
use crate::mutations::with_every_check;
use crate::plugin::{Judge, Refusal, Request, StepInput};
use crate::refusal::Reason;

impl Judge for Envelope {
    fn judge(&self, request: &Request, input: &StepInput) -> Result<f64, Refusal> {
        let Some(navigation) = &input.navigation else {
            return Err(Reason::NavigationMissing.into());
        };
        let lock = bottom_lock(navigation);
        let clocks = Clocks {
            utc: input.utc,
            apart: input.clocks_apart,
        };
        let alone = Route::default();
        let from_here = Route {
            from: vec![End::At(navigation.local)],
            ..Route::default()
        };
        let insert = |insert: &Insert| {
            with_every_check(|| self.judge_insert(insert, navigation.depth, lock, &from_here, clocks))
        };
        match request {
            Request::Modify(modify) => {
                let setpoint = self.admit_modify(modify)?;
                self.judge_modify(&setpoint, navigation, lock, &alone, (input.now, clocks))
            }
            Request::Trackline(line) => insert(&self.admit_trackline(line)?),
            Request::Trackcircle(circle) => insert(&self.admit_trackcircle(circle)?),
            Request::GpsHit(hit) => insert(&self.admit_gps_hit(hit)?),
            Request::Station(station) => {
                let around = Surroundings {
                    relative: input.relative.as_ref(),
                    cartesian: input.cartesian.as_ref(),
                    navigation,
                    lock,
                    suspended: &[],
                    now: input.now,
                };
                self.judge_station(&self.admit_station(station)?, &around)
            }
            Request::SonarAngle(asked) => self.admit_sonar_angle(asked).map(|()| f64::MAX),
            Request::Camera(asked) => self.admit_camera(asked).map(|()| f64::MAX),
            Request::Light(asked) => self.admit_light(asked).map(|()| f64::MAX),
            // These requests have no geometry.
            Request::EndModify
            | Request::Cancel(_)
            | Request::Message(_)
            | Request::Topside(_)
            | Request::DvlTrigger(_)
            | Request::Silent(_)
            | Request::Trim(_)
            | Request::Buoyancy(_)
            | Request::Packet(_)
            | Request::EndStation
            | Request::SonarSet(_)
            | Request::SonarLog(_)
            | Request::Timer { .. } => Ok(f64::MAX),
        }
    }
}
